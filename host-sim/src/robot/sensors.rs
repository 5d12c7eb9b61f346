//! Six laser rangefinders and a laser scanner: where they sit, how they err, what befalls them.

use crate::fault::{Fault, FaultSpec, Faulty, SpecError, assign};
use crate::random::{Purpose, stream};
use crate::transducer::{Look, PerfectSensor, Sensor};
use crate::world::World;
use certainty_control::{
    BEAMS, CrossCheckConfig, Failure, Failures, PerBeam, PerRangefinder, SENSORS, Views,
    beam_bearing,
};
use certainty_core::fusion::{BeamConfig, BeamModel, Behind};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose, Ticks};
use fixed::types::U0F16;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::sync::Arc;

/// What the sensors are called, in the order of their numbers: front, oblique and side ones, from the
/// left to the right.
///
/// \[004\] names FL alone; the rest is in its manner.
pub const NAMES: [&str; SENSORS] = ["FL", "OL", "SL", "SR", "OR", "FR", "scanner"];

/// The scanner's number.
pub const SCANNER: SensorId = SensorId::new(7);

/// Shortest distance that any of them tells.
pub const NEAREST: Millimeters = Millimeters::new(30);

/// Longest distance that any of them tells.
pub const FARTHEST: Millimeters = Millimeters::new(4000);

/// Standard deviation of a distance, in millimetres.
const NOISE_MM: f64 = 15.0;

/// Where the rangefinders sit and look, in the robot's frame: [`NAMES`] without the scanner.
///
/// \[004\] Fig. 2 shows them without numbers: all around, most of them ahead. Front and side ones look
/// into the scanner's field, so that each can check the other.
#[must_use]
pub const fn rangefinders() -> PerRangefinder<Pose> {
    const fn at(x: i32, y: i32, degrees: i32) -> Pose {
        let heading = BinaryAngle::from_millidegrees(degrees * 1000);
        Pose::new(Point::from_mm(x, y), heading)
    }
    [
        at(390, 170, 15),
        at(310, 240, 45),
        at(0, 280, 95),
        at(0, -280, -95),
        at(310, -240, -45),
        at(390, -170, -15),
    ]
}

/// Where the scanner sits: at the front, in the middle.
pub const SCANNER_POSE: Pose = Pose::new(Point::from_mm(420, 0), BinaryAngle::ZERO);

/// Returns how a reading is drawn into a map.
///
/// What lies behind an echo is left as it was: it was seen from elsewhere, and a robot that moves would
/// forget it. The spread is two standard deviations at half the range.
///
/// # Panics
///
/// Never: the parameters are constants that a test tries.
#[must_use]
pub fn beam_model() -> BeamModel {
    let accuracy = U0F16::from_num(2.0 * NOISE_MM / f64::from(FARTHEST.get() / 2));
    let config = BeamConfig {
        accuracy,
        behind: Behind::Untouched,
        ..BeamConfig::narrow(FARTHEST)
    };
    BeamModel::try_new(config).expect("a range of 4 m")
}

/// Returns where all of them look, and how far.
#[must_use]
pub const fn views() -> Views {
    Views {
        rangefinders: rangefinders(),
        scanner: SCANNER_POSE,
        rangefinders_see: FARTHEST,
        scanner_sees: FARTHEST,
    }
}

/// Returns what the cross-check is told of the sensors.
#[must_use]
pub const fn cross_check() -> CrossCheckConfig {
    CrossCheckConfig {
        views: views(),
        // Ten standard deviations: what differs by less is no danger.
        tolerance: Millimeters::new(150),
        contradiction: 4,
        agreement: 2,
        most: 48,
        credit: 16,
        unlikely: 12,
    }
}

/// A laser that measures with a little noise.
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
        // Drawn in any case, so that what is there changes no later draw.
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

/// What all sensors say at one time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Glance {
    /// The rangefinders'.
    pub rangefinders: PerRangefinder<Reading>,
    /// The scanner's.
    pub scan: PerBeam<Reading>,
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
    /// [`SpecError`] for a fault of a sensor that is not there.
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

    /// Lets every sensor look from a robot at `robot`.
    ///
    /// # Panics
    ///
    /// Never: there are seven sensors.
    pub fn look(&mut self, robot: Pose, at: Ticks) -> Glance {
        let mut sense = |slot: usize, mounting: Pose| {
            let pose = robot.compose(mounting);
            self.sensors[slot].0.sense(&Look {
                origin: pose.at,
                bearing: pose.heading,
                at,
            })
        };
        let mut rangefinders = [Reading::NoObject; SENSORS - 1];
        for (slot, mounting) in self::rangefinders().into_iter().enumerate() {
            rangefinders[slot] = sense(slot, mounting);
        }
        let mut scan = [Reading::NoObject; BEAMS];
        for (reading, index) in scan.iter_mut().zip(0_u8..) {
            let beam = Pose::new(Point::ORIGIN, beam_bearing(index));
            *reading = sense(SENSORS - 1, SCANNER_POSE.compose(beam));
        }
        Glance { rangefinders, scan }
    }

    /// Returns which sensors' next reading a fault befalls: what *given* health knows.
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
        let all = failures
            .rangefinders
            .iter_mut()
            .chain([&mut failures.scanner]);
        for (failure, sensor) in all.zip(&self.sensors) {
            *failure = failed(sensor);
        }
        failures
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Obstacle;

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
    fn every_sensor_looks_where_it_says() {
        let glance = set(&[]).look(Pose::default(), Ticks::new(0));
        let near =
            |reading, expected: f64| (millimetres(reading) - expected).abs() < 5.0 * NOISE_MM;
        assert!(near(glance.scan[50], 2000.0));
        assert!(near(glance.scan[0], 2000.0 / 50_f64.to_radians().cos()));
        assert!(near(glance.scan[100], 2000.0 / 50_f64.to_radians().cos()));
        assert!(near(
            glance.rangefinders[0],
            2030.0 / 15_f64.to_radians().cos()
        ));
        assert!(near(
            glance.rangefinders[4],
            2110.0 / 45_f64.to_radians().cos()
        ));
        assert_eq!(glance.rangefinders[2..4], [Reading::NoObject; 2]);
    }

    /// PEERS: two sonars at 0° and 90° were inserted along the same direction.
    #[test]
    fn rangefinders_mirror_each_other_and_look_apart() {
        let poses = rangefinders();
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
        assert_eq!(beam_model().config().farthest, FARTHEST);
    }

    #[test]
    fn faults_befall_who_they_name_when_they_say() {
        let mut sensors = set(&["stuck-far:FL@5s", "dropout:scanner=100%"]);
        let at = Ticks::new;
        let before = sensors.look(Pose::default(), at(0));
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
        let after = sensors.look(Pose::default(), at(5000));
        assert_eq!(after.rangefinders[0], Reading::NoObject);
        assert!(matches!(after.rangefinders[5], Reading::Echo(_)));
    }

    #[test]
    fn a_sensor_that_is_not_there_has_no_fault() {
        let spec: FaultSpec = "stuck-far:XX".parse().unwrap();
        assert!(RobotSensors::new(&wall(), &[spec], 1).is_err());
    }
}
