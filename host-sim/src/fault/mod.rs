//! Faults that wrap any sensor.
//!
//! [`FaultSpec`] is a fault as it is written on a command line, [`Faulty`] a sensor that has some.
//! What is assumed to go wrong is \[001\] §2.1: transient faults have a [`Window`] that ends,
//! intermittent ones come and go in bursts, permanent ones do neither.

mod defect;
mod faulty;
mod spec;

pub use defect::{Defect, Factor, Fault, Times, Window};
pub use faulty::Faulty;
pub use spec::{FaultSpec, SensorName, SpecError, assign, assign_by_number};

pub(crate) use spec::Parts;
