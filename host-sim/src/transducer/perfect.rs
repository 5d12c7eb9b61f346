//! A sensor without error: what the papers' "perfect virtual sensors" see.

use super::{Look, Sensor};
use crate::world::World;
use certainty_core::transducer::Reading;
use certainty_core::units::Millimeters;
use std::sync::Arc;

/// A sensor that reads the true distance, rounded to the nearest millimetre.
///
/// The maps it makes are what \[001\] §6.2 compares with. For a sensor with the errors of a real one
/// see [`SimulatedGp2d02`](super::SimulatedGp2d02).
#[derive(Debug, Clone)]
pub struct PerfectSensor {
    world: Arc<World>,
    nearest: Millimeters,
    farthest: Millimeters,
}

impl PerfectSensor {
    /// Creates a sensor that looks at `world` and can tell distances from `nearest` to `farthest`,
    /// both included.
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
        // A millimetre more, because what is half of one beyond still rounds into the range.
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
