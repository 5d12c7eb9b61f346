//! Reception of a board's telemetry.
//!
//! A [`Port`] is the source of the bytes, [`Port::listen`] reads them on a thread of its own, and a
//! [`Session`] keeps their latest reports: the map and whether it is complete, every sensor's state, and
//! the counts of damaged frames. The frames are those of [`certainty_firmware::telemetry`].

mod port;
mod session;

pub use port::{Arrival, Port, PortError};
pub use session::{SensorState, Session};
