//! The transducer level: what a range sensor says, and how its words become millimetres.

mod calibration;
mod reading;
mod sweep;
mod validation;

pub use calibration::{Calibration, CalibrationError};
pub use reading::{Missing, Reading};
pub use sweep::{Sweep, SweepError};
pub use validation::{
    Finding, FindingCounts, Fluctuation, Steadiness, Validated, ValidationConfig, ValidationError,
    ValidationRules, Validator,
};
