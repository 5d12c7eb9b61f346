//! A Sharp GP2D02 infrared sensor, simulated down to its byte.
//!
//! One conversion: the true distance → the errors of Table 1 of \[001\] → the byte of this unit's own
//! curve. A driver's half, byte → millimetres by the unit's calibration, makes it a [`Sensor`].

use super::stream::{Purpose, stream};
use super::table1::SensorModel;
use super::unit::Gp2d02Unit;
use super::{Look, Sensor};
use crate::world::World;
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::Millimeters;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::sync::Arc;

pub use certainty_firmware::smart_car::{FARTHEST, NEAREST};

/// A simulated GP2D02 that looks at a world.
///
/// The rates of Table 1 hold at every distance of the range: an object that is seen at all is
/// reported with some distance, if with the farthest, and noise alone never turns it into *no
/// object*. Distances scatter by the accuracy as far as the unit's curve is like its fit; where many
/// real units have a kink, around 40 cm, by up to a quarter more on average. Nearer than the range the byte folds back, as a real unit's does, and reads too near or
/// as a distance that is wrong.
///
/// Order: the draws of a sensor depend on the seed, its number and how often it was asked; neither
/// on other sensors nor on what it saw.
#[derive(Debug, Clone)]
pub struct SimulatedGp2d02 {
    world: Arc<World>,
    unit: Gp2d02Unit,
    model: SensorModel,
    rng: ChaCha8Rng,
}

impl SimulatedGp2d02 {
    /// Creates sensor number `sensor` of the run that `seed` names.
    ///
    /// ```
    /// use certainty_core::sensor::SensorId;
    /// use certainty_core::transducer::Reading;
    /// use certainty_core::units::{BinaryAngle, Point, Ticks};
    /// use certainty_sim::transducer::{Gp2d02Unit, Look, Sensor, SensorModel, SimulatedGp2d02};
    /// use certainty_sim::world::World;
    /// use std::sync::Arc;
    ///
    /// let world = Arc::new(World::built_in());
    /// let unit = Gp2d02Unit::shipped()[0].clone();
    /// let first = SensorId::try_new(1).unwrap();
    /// let mut sensor = SimulatedGp2d02::new(world, unit, SensorModel::FLAWLESS, 7, first);
    /// let look = Look { origin: Point::ORIGIN, bearing: BinaryAngle::QUARTER, at: Ticks::new(0) };
    /// let Reading::Echo(distance) = sensor.sense(&look) else { panic!("nothing ahead") };
    /// assert!((528..=572).contains(&distance.get())); // a block stands 550 mm ahead
    /// ```
    #[must_use]
    pub fn new(
        world: Arc<World>,
        unit: Gp2d02Unit,
        model: SensorModel,
        seed: u64,
        sensor: SensorId,
    ) -> Self {
        Self {
            world,
            unit,
            model,
            rng: stream(seed, Purpose::Transducer, sensor.number(), 0),
        }
    }

    /// Returns the unit that is simulated.
    #[must_use]
    pub const fn unit(&self) -> &Gp2d02Unit {
        &self.unit
    }

    /// Converts once: the byte that the unit clocks out, which falls with distance.
    pub fn convert(&mut self, look: &Look) -> u8 {
        // All three are always drawn, so that what is seen changes no later draw.
        let chance: f64 = self.rng.random();
        let error: f64 = self.rng.sample(StandardNormal);
        let somewhere: f64 = self.rng.random();
        let seen = match self.world.distance(look.origin, look.bearing, FARTHEST) {
            Some(truth) if chance >= self.model.p_false_inf() => {
                Some(truth * (1.0 + self.model.accuracy() * error))
            }
            None if chance < self.model.p_failed_inf() => {
                let (from, to) = self.model.false_distances();
                let (nearest, farthest) = (f64::from(NEAREST.get()), f64::from(FARTHEST.get()));
                let part = from + (to - from) * somewhere;
                Some(nearest + (farthest - nearest) * part)
            }
            Some(_) | None => None,
        };
        match seen {
            Some(distance) => self.unit.byte_at(distance).max(self.unit.faintest_echo()),
            None => self.unit.silent_byte(),
        }
    }
}

impl Sensor for SimulatedGp2d02 {
    fn sense(&mut self, look: &Look) -> Reading {
        let raw = self.convert(look);
        self.unit.calibration().reading(raw)
    }

    fn range(&self) -> (Millimeters, Millimeters) {
        let calibration = self.unit.calibration();
        (calibration.nearest(), calibration.farthest())
    }
}

#[cfg(test)]
mod tests;
