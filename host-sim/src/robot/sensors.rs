//! Six laser rangefinders and a laser scanner: their mountings, noise and faults.

use crate::fault::{Fault, FaultSpec, Faulty, SpecError, assign};
use crate::random::{Purpose, stream};
use crate::transducer::{Look, PerfectSensor, Sensor};
use crate::world::World;
use certainty_control::{
    BEAMS, CrossCheckConfig, Failure, Failures, Mountings, RANGEFINDERS, SENSORS, SensorModel,
    SensorReadings, beam_bearing,
};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::{BeamConfig, BeamModel, Behind};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Reading, ValidationConfig, ValidationRules};
use certainty_core::units::{Millimeters, Point, Pose, Ticks};
use fixed::types::U0F16;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::sync::Arc;

/// The sensors' names, in the order of their numbers: front, oblique and side ones, from the left to the
/// right.
///
/// \[004\] names only FL; the others follow its pattern.
pub const NAMES: [&str; SENSORS] = ["FL", "OL", "SL", "SR", "OR", "FR", "scanner"];

/// The shortest distance that any of them measures.
pub const NEAREST: Millimeters = Millimeters::new(30);

/// The longest distance that any of them measures.
pub const FARTHEST: Millimeters = Mountings::IBIS.rangefinder_range;

/// Standard deviation of a distance, in millimetres.
const NOISE_MM: f64 = 15.0;

/// Returns the beam model of a reading in a map.
///
/// Cells behind an echo are unchanged, because readings from other places have measured them. The spread is two standard deviations at half the range.
#[must_use]
pub fn beam_model() -> BeamModel {
    let accuracy = U0F16::from_num(2.0 * NOISE_MM / f64::from(FARTHEST.get() / 2));
    let config = BeamConfig {
        accuracy,
        behind: Behind::Untouched,
        ..BeamConfig::narrow(FARTHEST)
    };
    BeamModel::new(config)
}

/// Returns the robot's model of its sensors: plausibility limits, beam model, and the certainty of an obstacle.
///
/// With noise of 15 mm two readings are equal to the millimetre once in fifty times, so a distance that
/// repeats in eight new directions is not a measurement. A jump is half a metre, more than a robot at full
/// speed explains. A cell stops a ray from half way between *uncertain* and *occupied* on.
#[must_use]
pub fn sensor_model() -> SensorModel {
    let validation = ValidationConfig {
        nearest: NEAREST,
        farthest: FARTHEST,
        jump: Millimeters::new(500),
        speed_mm_s: 1000,
        compare_within: 200,
        max_repeats: 8,
        repeat_noise: 0,
    };
    SensorModel {
        check: CrossCheckConfig::new(Mountings::IBIS),
        validation: ValidationRules::new(validation),
        beams: beam_model(),
        obstacle: Certainty::from_bits(192),
    }
}

/// A laser rangefinder with Gaussian noise.
#[derive(Debug, Clone)]
pub struct Laser {
    truth: PerfectSensor,
    rng: ChaCha8Rng,
}

impl Laser {
    /// Creates the laser of sensor `id` in `world`, in the run that `seed` names.
    #[must_use]
    pub fn new(world: Arc<World>, id: SensorId, seed: u64) -> Self {
        Self {
            truth: PerfectSensor::new(world, NEAREST, FARTHEST),
            rng: stream(seed, Purpose::Transducer, id.number(), 0),
        }
    }
}

impl Sensor for Laser {
    fn sense(&mut self, look: &Look) -> Reading {
        // Drawn for every reading, so that the scene does not change later draws.
        let normal: f64 = StandardNormal.sample(&mut self.rng);
        match self.truth.sense(look) {
            Reading::Echo(distance) => {
                let measured = (f64::from(distance.get()) + NOISE_MM * normal).round();
                if measured < f64::from(NEAREST.get()) {
                    Reading::TooNear
                } else if measured > f64::from(FARTHEST.get()) {
                    Reading::NoObject
                } else {
                    Reading::Echo(Millimeters::new(measured as u32))
                }
            }
            other => other,
        }
    }

    fn range(&self) -> (Millimeters, Millimeters) {
        self.truth.range()
    }
}

/// All sensors of the robot with their faults.
#[derive(Debug)]
pub struct RobotSensors {
    sensors: Vec<(Faulty<Laser>, Vec<Fault>)>,
}

impl RobotSensors {
    /// Creates the sensors in `world` with `faults`, in the run that `seed` names.
    ///
    /// # Errors
    ///
    /// [`SpecError`] for a fault of a sensor that does not exist.
    pub fn new(world: &Arc<World>, faults: &[FaultSpec], seed: u64) -> Result<Self, SpecError> {
        let assigned = assign(faults, &NAMES)?;
        let numbered = assigned.into_iter().enumerate();
        let sensors = numbered.filter_map(|(slot, faults)| {
            let id = SensorId::from_slot(slot)?;
            let laser = Laser::new(Arc::clone(world), id, seed);
            Some((Faulty::new(laser, id, faults.clone(), seed), faults))
        });
        Ok(Self {
            sensors: sensors.collect(),
        })
    }

    /// Takes a reading of every sensor of a robot at `robot`.
    pub fn read(&mut self, robot: Pose, at: Ticks) -> SensorReadings {
        let mut sense = |slot: usize, mounting: Pose| {
            let pose = robot.compose(mounting);
            self.sensors[slot].0.sense(&Look {
                origin: pose.at,
                bearing: pose.heading,
                at,
            })
        };
        let mut rangefinders = [Reading::NoObject; RANGEFINDERS];
        for (slot, mounting) in Mountings::IBIS.rangefinders.into_iter().enumerate() {
            rangefinders[slot] = sense(slot, mounting);
        }
        let mut scan = [Reading::NoObject; BEAMS];
        for (reading, index) in scan.iter_mut().zip(0_u8..) {
            let beam = Pose::new(Point::ORIGIN, beam_bearing(index));
            *reading = sense(RANGEFINDERS, Mountings::IBIS.scanner.compose(beam));
        }
        SensorReadings { rangefinders, scan }
    }

    /// Returns the sensors with a fault in their next reading: the failures of *given* health.
    #[must_use]
    pub fn failures(&self, at: Ticks) -> Failures {
        let failed = |(sensor, faults): &(Faulty<Laser>, Vec<Fault>)| {
            let active = |fault: &Fault| fault.window.contains(sensor.readings(), at);
            if faults.iter().any(active) {
                Failure::TOTAL
            } else {
                Failure::NONE
            }
        };
        let mut failures = Failures::NONE;
        for (failure, sensor) in failures.iter_mut().zip(&self.sensors) {
            *failure = failed(sensor);
        }
        failures
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Obstacle;
    use certainty_core::units::BinaryAngle;

    fn wall() -> Arc<World> {
        let wall = Obstacle::wall(
            Point::from_mm(2420, -9000),
            Point::from_mm(2420, 9000),
            Millimeters::new(2),
        );
        Arc::new(World::new("wall", vec![wall.unwrap()]))
    }

    fn set(faults: &[&str]) -> RobotSensors {
        let specs: Vec<FaultSpec> = faults.iter().map(|spec| spec.parse().unwrap()).collect();
        RobotSensors::new(&wall(), &specs, 1).unwrap()
    }

    fn millimetres(reading: Reading) -> f64 {
        match reading {
            Reading::Echo(distance) => f64::from(distance.get()),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn every_sensor_looks_where_it_is_mounted() {
        let readings = set(&[]).read(Pose::default(), Ticks::new(0));
        let near =
            |reading, expected: f64| (millimetres(reading) - expected).abs() < 5.0 * NOISE_MM;
        assert!(near(readings.scan[50], 2000.0));
        assert!(near(readings.scan[0], 2000.0 / 50_f64.to_radians().cos()));
        assert!(near(readings.scan[100], 2000.0 / 50_f64.to_radians().cos()));
        assert!(near(
            readings.rangefinders[0],
            2030.0 / 15_f64.to_radians().cos()
        ));
        assert!(near(
            readings.rangefinders[4],
            2110.0 / 45_f64.to_radians().cos()
        ));
        assert_eq!(readings.rangefinders[2..4], [Reading::NoObject; 2]);
    }

    #[test]
    fn rangefinders_mirror_each_other_and_look_apart() {
        let poses = Mountings::IBIS.rangefinders;
        for (slot, pose) in poses.iter().enumerate() {
            let other = poses[poses.len() - 1 - slot];
            assert_eq!(other.at, Point::from_mm(pose.at.x_mm(), -pose.at.y_mm()));
            assert_eq!(other.heading, BinaryAngle::ZERO.wrapping_sub(pose.heading));
            assert!(
                poses[..slot]
                    .iter()
                    .all(|before| before.heading != pose.heading)
            );
        }
        assert_eq!(sensor_model().beams.config().farthest, FARTHEST);
    }

    #[test]
    fn faults_affect_the_named_sensor_at_their_time() {
        let mut sensors = set(&["stuck-far:FL@5s", "dropout:scanner=100%"]);
        let at = Ticks::new;
        let before = sensors.read(Pose::default(), at(0));
        assert!(matches!(before.rangefinders[0], Reading::Echo(_)));
        assert!(
            before
                .scan
                .iter()
                .all(|reading| matches!(reading, Reading::Missing(_)))
        );
        assert_eq!(sensors.failures(at(4999)).rangefinders[0], Failure::NONE);
        assert_eq!(sensors.failures(at(5000)).rangefinders[0], Failure::TOTAL);
        assert_eq!(sensors.failures(at(0)).scanner, Failure::TOTAL);
        let after = sensors.read(Pose::default(), at(5000));
        assert_eq!(after.rangefinders[0], Reading::NoObject);
        assert!(matches!(after.rangefinders[5], Reading::Echo(_)));
    }

    #[test]
    fn a_fault_of_an_unknown_sensor_is_refused() {
        let spec: FaultSpec = "stuck-far:XX".parse().unwrap();
        assert!(RobotSensors::new(&wall(), &[spec], 1).is_err());
    }
}
