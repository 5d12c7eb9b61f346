//! Simulated range sensors, behind one trait.
//!
//! [`PerfectSensor`] reads the truth; [`SimulatedGp2d02`] errs as a real unit does. Faults beyond
//! that wrap either: see [`fault`](crate::fault).

mod characteristic;
mod fit;
pub mod gp2d02;
mod perfect;
pub mod stream;
mod table;
mod table1;
mod unit;

pub use characteristic::{Characteristic, CurveError, CurvePoint};
pub use fit::{Fit, FitError, MOST_OFFSET};
pub use gp2d02::SimulatedGp2d02;
pub use perfect::PerfectSensor;
pub use table::{MeasuredUnit, TableError, TableProblem};
pub use table1::{BELOW_ONE_PERCENT, SensorModel, SensorModelError};
pub use unit::{GP2D02_UNITS, Gp2d02Unit, UnitsError};

use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Millimeters, Point, Ticks};

/// One look of a sensor: from where, which way, when.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Look {
    /// Where the beam starts, in the map frame.
    pub origin: Point,
    /// Which way it goes, in the map frame.
    pub bearing: BinaryAngle,
    /// When, on the simulation's clock.
    pub at: Ticks,
}

/// A range sensor: real or simulated, sound or faulty.
pub trait Sensor {
    /// Measures once.
    fn sense(&mut self, look: &Look) -> Reading;

    /// Returns the distances between which the sensor can tell: nearest and farthest.
    fn range(&self) -> (Millimeters, Millimeters);

    /// Returns how many measurements the sensor reports in one turn of the schedule; 1 if sound.
    fn reports_per_turn(&self, _at: Ticks) -> u32 {
        1
    }
}

/// A boxed sensor is one, so that wrappers compose whatever is inside.
impl<S: Sensor + ?Sized> Sensor for Box<S> {
    fn sense(&mut self, look: &Look) -> Reading {
        (**self).sense(look)
    }

    fn range(&self) -> (Millimeters, Millimeters) {
        (**self).range()
    }

    fn reports_per_turn(&self, at: Ticks) -> u32 {
        (**self).reports_per_turn(at)
    }
}
