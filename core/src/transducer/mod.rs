//! The transducer level: readings of range sensors, their calibration and their plausibility.

mod calibration;
mod fluctuation;
mod reading;
mod sweep;
mod validation;

pub use calibration::{Calibration, CalibrationError};
pub use fluctuation::{Fluctuation, Steadiness};
pub use reading::{Missing, Reading};
pub use sweep::{Sweep, SweepError};
pub use validation::{
    Finding, FindingCounts, Validated, ValidationConfig, ValidationError, ValidationRules,
    Validator,
};
