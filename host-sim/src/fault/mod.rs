//! Faults that wrap any sensor.
//!
//! [`FaultSpec`] is a fault as it is written on a command line, [`Faulty`] a sensor that has some.
//! What is assumed to go wrong is \[001\] §2.1: transient faults have a [`Window`] that ends,
//! intermittent ones come in [`Bursts`], permanent ones do neither.

mod defect;
mod error;
mod faulty;
mod spec;

pub use defect::{Defect, Factor, Fault, Times, Window};
pub use error::SpecError;
pub use faulty::{Bursts, BurstsError, Faulty};
pub(crate) use spec::Parts;
pub use spec::{FaultSpec, SensorName, assign};
