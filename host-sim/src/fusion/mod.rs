//! The core's grids with the host's storage, chosen at run time.
//!
//! [`HostMapper`] is the core's mapper for any [`Method`], size and number of sensors. [`FusionRules`] holds
//! the numbers that the methods leave open, and [`Rules`] names sets of numbers for `AddToGrid`.

mod literal;
mod mapper;
mod rules;

pub use mapper::HostMapper;
pub use rules::{FusionRules, Landmarks, Method, Own, Rules, UnknownMethod};
