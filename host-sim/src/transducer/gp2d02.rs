//! A Sharp GP2D02 infrared sensor, simulated with its byte.
//!
//! One conversion: the true distance → the errors of Table 1 of \[001\] → the byte of this unit's own
//! curve. The driver's part, byte → millimetres by the unit's calibration, makes it a [`Sensor`].

use super::sensor::{Look, Sensor};
use super::sensor_model::SensorModel;
use super::unit::Gp2d02Unit;
use crate::random::{Purpose, stream};
use crate::world::World;
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::Millimeters;
use certainty_firmware::smart_car::{FARTHEST, NEAREST};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::sync::Arc;

/// A simulated GP2D02 in a world.
///
/// The rates of Table 1 hold at every distance of the range: a detected object has a distance, at most the
/// farthest, and noise alone never turns it into *no object*. Distances scatter by the accuracy where the
/// unit's curve is like its fit; where many real units have a kink, around 40 cm, by up to a quarter more on
/// average. Nearer than the range the byte folds back, as a real unit's does, and reads *too near* or a wrong
/// distance.
///
/// Order: the random numbers of a sensor depend on the seed, its number and the count of its conversions;
/// neither on other sensors nor on what it measured.
#[derive(Debug, Clone)]
pub struct SimulatedGp2d02 {
    world: Arc<World>,
    unit: Gp2d02Unit,
    model: SensorModel,
    rng: ChaCha8Rng,
}

impl SimulatedGp2d02 {
    /// Creates sensor number `sensor` of the run with this `seed`.
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

    /// Converts once: returns the byte that the unit clocks out, which falls with distance.
    pub fn convert(&mut self, look: &Look) -> u8 {
        // All three are always drawn, so that a measurement changes no later one.
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
            None => self.unit.no_object_byte(),
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
mod tests {
    use super::*;
    use crate::world::Obstacle;
    use certainty_core::units::{BinaryAngle, Point, Ticks};

    const LOOK: Look = Look {
        origin: Point::ORIGIN,
        bearing: BinaryAngle::QUARTER,
        at: Ticks::new(0),
    };

    const READINGS: u32 = 20_000;

    fn id(number: u8) -> SensorId {
        SensorId::try_new(number).unwrap()
    }

    /// A wall across the beam, its face `away` millimetres from the origin.
    fn wall(away: i32) -> Arc<World> {
        let y = away + 10;
        let wall = Obstacle::wall(
            Point::from_mm(-900, y),
            Point::from_mm(900, y),
            Millimeters::new(20),
        );
        Arc::new(World::new("wall", vec![wall.unwrap()]))
    }

    fn open() -> Arc<World> {
        Arc::new(World::new("open", vec![]))
    }

    fn readings(world: &Arc<World>, unit: &Gp2d02Unit, model: SensorModel) -> Vec<Reading> {
        let mut sensor = SimulatedGp2d02::new(Arc::clone(world), unit.clone(), model, 11, id(1));
        (0..READINGS).map(|_| sensor.sense(&LOOK)).collect()
    }

    fn share(readings: &[Reading], wanted: fn(&Reading) -> bool) -> f64 {
        readings.iter().filter(|r| wanted(r)).count() as f64 / readings.len() as f64
    }

    fn echoes(readings: &[Reading]) -> Vec<f64> {
        readings
            .iter()
            .filter_map(|r| match r {
                Reading::Echo(distance) => Some(f64::from(distance.get())),
                _ => None,
            })
            .collect()
    }

    /// The relative error's standard deviation and mean at `away` mm, averaged over all units.
    ///
    /// One unit's tabulated curve is locally steeper or flatter than its fit; sixteen are less so.
    fn scatter(model: SensorModel, away: i32) -> (f64, f64) {
        let units = Gp2d02Unit::shipped();
        let (mut deviation, mut offset) = (0.0, 0.0);
        for unit in units {
            let truth = f64::from(away) - 0.5;
            let errors: Vec<f64> = echoes(&readings(&wall(away), unit, model))
                .iter()
                .map(|mm| mm / truth - 1.0)
                .collect();
            let mean = errors.iter().sum::<f64>() / errors.len() as f64;
            let squares: f64 = errors.iter().map(|e| (e - mean).powi(2)).sum();
            deviation += (squares / errors.len() as f64).sqrt() / units.len() as f64;
            offset += mean / units.len() as f64;
        }
        (deviation, offset)
    }

    /// Four standard deviations of a rate's estimate.
    fn four_sigma(rate: f64) -> f64 {
        4.0 * (rate * (1.0 - rate) / f64::from(READINGS)).sqrt()
    }

    #[test]
    fn p_failed_inf_is_that_of_table_1() {
        for (letter, model) in SensorModel::TABLE_1 {
            for unit in [0, 5, 8] {
                let all = readings(&open(), &Gp2d02Unit::shipped()[unit], model);
                let failed = share(&all, |r| matches!(r, Reading::Echo(_)));
                let rate = model.p_failed_inf();
                assert!(
                    (failed - rate).abs() < four_sigma(rate),
                    "{letter}, unit {unit}: {failed}"
                );
                let none = share(&all, |r| matches!(r, Reading::NoObject));
                assert!((failed + none - 1.0).abs() < 1e-9, "nothing else is read");
            }
        }
    }

    #[test]
    fn p_false_inf_is_that_of_table_1_at_every_distance() {
        for (letter, model) in SensorModel::TABLE_1 {
            for away in [200, 400, 799] {
                let all = readings(&wall(away), &Gp2d02Unit::shipped()[0], model);
                let missed = share(&all, |r| matches!(r, Reading::NoObject));
                let rate = model.p_false_inf();
                assert!(
                    (missed - rate).abs() < four_sigma(rate),
                    "{letter} at {away} mm: {missed}"
                );
            }
        }
    }

    #[test]
    fn distances_scatter_as_in_table_1() {
        for (letter, model) in SensorModel::TABLE_1 {
            for away in [200, 300] {
                let (deviation, offset) = scatter(model, away);
                // Rounding to a byte adds 0.8 %, in squares.
                let ratio = deviation / model.accuracy().hypot(0.008);
                assert!((ratio - 1.0).abs() < 0.04, "{letter} at {away}: {ratio}");
                assert!(offset.abs() < 0.015, "{letter} at {away}: off by {offset}");
            }
        }
    }

    #[test]
    fn distances_scatter_more_at_the_units_kink() {
        // From 36 to 44 cm many of the tabulated units fall more steeply than their fits.
        for (letter, model) in SensorModel::TABLE_1 {
            let ratio = scatter(model, 400).0 / model.accuracy().hypot(0.008);
            assert!((1.05..1.30).contains(&ratio), "{letter}: {ratio}");
        }
    }

    #[test]
    fn false_distances_come_from_the_far_half_of_the_range() {
        let all = echoes(&readings(
            &open(),
            &Gp2d02Unit::shipped()[12],
            SensorModel::D,
        ));
        let (least, most) = all
            .iter()
            .fold((f64::MAX, 0.0_f64), |(l, m), &d| (l.min(d), m.max(d)));
        // The range is 100 to 800; one count is 35 mm at its far end.
        assert!((430.0..=470.0).contains(&least), "{least}");
        assert!((760.0..=800.0).contains(&most), "{most}");
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        assert!((610.0..=640.0).contains(&mean), "{mean}");
    }

    #[test]
    fn a_flawless_model_keeps_the_units_misfit() {
        let unit = &Gp2d02Unit::shipped()[4];
        for away in (110..800).step_by(30) {
            let mut sensor =
                SimulatedGp2d02::new(wall(away), unit.clone(), SensorModel::FLAWLESS, 1, id(1));
            let Reading::Echo(read) = sensor.sense(&LOOK) else {
                panic!("no echo at {away} mm");
            };
            let error = f64::from(read.get()) / (f64::from(away) - 0.5) - 1.0;
            assert!(error.abs() < 0.14, "{away} mm reads {read}");
        }
    }

    #[test]
    fn an_object_too_near_reads_as_a_far_one() {
        let unit = &Gp2d02Unit::shipped()[0];
        let read = |away| {
            SimulatedGp2d02::new(wall(away), unit.clone(), SensorModel::FLAWLESS, 1, id(1))
                .sense(&LOOK)
        };
        assert_eq!(read(85), Reading::TooNear);
        let Reading::Echo(folded) = read(30) else {
            panic!("{:?}", read(30));
        };
        assert!(folded.get() > 150, "{folded}");
    }

    #[test]
    fn an_object_beyond_the_range_is_none() {
        let all = readings(&wall(820), &Gp2d02Unit::shipped()[0], SensorModel::FLAWLESS);
        assert!(all.iter().all(|r| *r == Reading::NoObject));
    }

    #[test]
    fn random_numbers_depend_on_no_other_sensor() {
        let unit = &Gp2d02Unit::shipped()[0];
        let sensor = |world: &Arc<World>, number| {
            SimulatedGp2d02::new(
                Arc::clone(world),
                unit.clone(),
                SensorModel::D,
                3,
                id(number),
            )
        };
        let (wall, open) = (wall(400), open());
        let (mut alone, mut among) = (sensor(&wall, 2), sensor(&wall, 2));
        let mut other = sensor(&wall, 1);
        let alone: Vec<_> = (0..200).map(|_| alone.sense(&LOOK)).collect();
        let among: Vec<_> = (0..200)
            .map(|_| {
                other.sense(&LOOK);
                among.sense(&LOOK)
            })
            .collect();
        assert_eq!(alone, among);
        let others: Vec<_> = (0..200).map(|_| other.sense(&LOOK)).collect();
        assert_ne!(alone, others);
        // Nor on earlier measurements: another world for the first hundred looks.
        let mut moved = sensor(&open, 2);
        for _ in 0..100 {
            moved.sense(&LOOK);
        }
        moved.world = wall;
        let moved: Vec<_> = (100..200).map(|_| moved.sense(&LOOK)).collect();
        assert_eq!(moved, alone[100..]);
    }
}
