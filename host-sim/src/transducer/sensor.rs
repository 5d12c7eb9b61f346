//! A range sensor, and the one without errors: the papers' "perfect virtual sensor".

use crate::world::World;
use certainty_core::transducer::{Reading, ValidationRules, Validator};
use certainty_core::units::{BinaryAngle, Millimeters, Point, Ticks};
use std::sync::Arc;

/// The pose of a sensor's beam and the time of one measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Look {
    /// Where the beam starts, in the map frame.
    pub origin: Point,
    /// Its direction, in the map frame.
    pub bearing: BinaryAngle,
    /// The time of the simulation's clock.
    pub at: Ticks,
}

/// A range sensor: real or simulated, sound or faulty.
pub trait Sensor {
    /// Measures once.
    fn sense(&mut self, look: &Look) -> Reading;

    /// Returns the nearest and the farthest distance that the sensor can measure.
    fn range(&self) -> (Millimeters, Millimeters);

    /// Returns the number of readings in one turn of the schedule; 1 for a sound sensor.
    fn reports_per_turn(&self, _at: Ticks) -> u32 {
        1
    }
}

/// A boxed sensor is a sensor, so that wrappers compose.
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

/// Local validation (\[002\] Fig. 1) of a sensor whose distance in millimetres stands for its raw value.
#[derive(Debug, Clone, Copy)]
pub struct Validation {
    rules: ValidationRules,
    validator: Validator,
}

impl Validation {
    /// Creates the validation of a sensor without readings yet.
    #[must_use]
    pub const fn new(rules: ValidationRules) -> Self {
        Self {
            rules,
            validator: Validator::new(),
        }
    }

    /// Returns `measured` as it goes on to the fusion: *missing* if it is implausible.
    pub fn check(&mut self, measured: Reading, look: &Look) -> Reading {
        let raw = match measured {
            Reading::Echo(distance) => u16::try_from(distance.get()).ok(),
            Reading::NoObject | Reading::TooNear | Reading::Missing(_) => None,
        };
        let rules = &self.rules;
        let checked = (self.validator).validate(rules, measured, raw, look.bearing, look.at);
        checked.reading
    }
}

/// A sensor that reads the true distance, rounded to the nearest millimetre.
///
/// \[001\] §6.2 compares maps with those of such sensors. For a sensor with the errors of a real one see
/// [`SimulatedGp2d02`](crate::transducer::SimulatedGp2d02).
#[derive(Debug, Clone)]
pub struct PerfectSensor {
    world: Arc<World>,
    nearest: Millimeters,
    farthest: Millimeters,
}

impl PerfectSensor {
    /// Creates a sensor in `world` that measures distances from `nearest` to `farthest`, both included.
    #[must_use]
    pub const fn new(world: Arc<World>, nearest: Millimeters, farthest: Millimeters) -> Self {
        Self {
            world,
            nearest,
            farthest,
        }
    }
}

impl Sensor for PerfectSensor {
    fn sense(&mut self, look: &Look) -> Reading {
        // A millimetre more, as up to half of one beyond still rounds into the range.
        let within = self.farthest.saturating_add(Millimeters::new(1));
        let Some(distance) = self.world.distance(look.origin, look.bearing, within) else {
            return Reading::NoObject;
        };
        let distance = Millimeters::new(distance.round() as u32);
        if distance < self.nearest {
            Reading::TooNear
        } else if distance > self.farthest {
            Reading::NoObject
        } else {
            Reading::Echo(distance)
        }
    }

    fn range(&self) -> (Millimeters, Millimeters) {
        (self.nearest, self.farthest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Obstacle;
    use certainty_core::units::{BinaryAngle, Point, Ticks};

    fn reading_at(away: i32) -> Reading {
        let disc = Obstacle::disc(Point::from_mm(0, away + 200), Millimeters::new(200)).unwrap();
        let world = Arc::new(World::new("disc", vec![disc]));
        PerfectSensor::new(world, Millimeters::new(100), Millimeters::new(800)).sense(&Look {
            origin: Point::ORIGIN,
            bearing: BinaryAngle::QUARTER,
            at: Ticks::new(0),
        })
    }

    #[test]
    fn both_ends_of_the_range_are_within_it() {
        // The ray starts half a millimetre up, and ties round up.
        assert_eq!(reading_at(99), Reading::TooNear);
        assert_eq!(reading_at(100), Reading::Echo(Millimeters::new(100)));
        assert_eq!(reading_at(500), Reading::Echo(Millimeters::new(500)));
        assert_eq!(reading_at(800), Reading::Echo(Millimeters::new(800)));
        assert_eq!(reading_at(801), Reading::NoObject);
        assert_eq!(reading_at(-10), Reading::TooNear);
    }
}
