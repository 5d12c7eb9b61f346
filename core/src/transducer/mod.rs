//! The transducer level: what a range sensor says, and how its words become millimetres.

mod calibration;
mod reading;
mod sweep;

pub use calibration::{Calibration, CalibrationError};
pub use reading::{Missing, Reading};
pub use sweep::{Sweep, SweepError};
