//! Simulated range sensors, behind one trait.

pub mod stream;

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
