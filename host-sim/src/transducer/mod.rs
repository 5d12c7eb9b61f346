//! Simulated range sensors, behind one trait.
//!
//! [`PerfectSensor`] measures without errors, [`SimulatedGp2d02`] with those of a real unit. Faults wrap
//! either: see [`fault`](crate::fault).

mod characteristic;
mod gp2d02;
mod sensor;
mod sensor_model;
mod table;
mod unit;

pub use characteristic::{Characteristic, CurveError, CurvePoint, Fit, FitError};
pub use gp2d02::SimulatedGp2d02;
pub use sensor::{Look, PerfectSensor, Sensor, Validation};
pub use sensor_model::{CarSensor, SensorModel, SensorModelError, SensorSet, SensorSetError};
pub use table::{Adc, MeasuredUnit, TableError, TableProblem};
pub use unit::{GP2D02_UNITS, Gp2d02Unit, UnitsError};
