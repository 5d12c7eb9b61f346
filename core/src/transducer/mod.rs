//! The transducer level: what a range sensor says, and how its words become millimetres.

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
