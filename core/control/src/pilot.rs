//! The whole control level of a robot that diagnoses its own sensors and draws a map.
//!
//! ```text
//! readings ─► validate ─► assess ─► draw the trusted ones ─► fill in from the map ─► Controller ─► wheels
//!                           ▲                │
//!                           └── expected ◄── map
//! ```

use crate::config::ControlRules;
use crate::controller::{Command, ControlInput, Controller, Stamped};
use crate::cross_check::{CrossCheck, CrossCheckConfig, CrossCheckConfigError};
use crate::diagnosis::{Assessment, Diagnosis};
use crate::expected_scan::{CastRay, Completed, ExpectedScan, RayHit, scan_of_map};
use crate::failures::{Failure, Failures, SensorFlags};
use crate::motion::Side;
use crate::sensors::{BEAMS, RANGEFINDERS, ScanGeometry, SensorReadings};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::{Beam, BeamModel, CertaintyGrid, Mapper, UnknownSensor};
use certainty_core::health::{Health, HealthRules};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Reading, ValidationRules};
use certainty_core::units::{Millimeters, Point, Pose, Ticks};
use core::fmt;

/// A map that a [`Pilot`] draws and casts rays into: a [`Mapper`] of any grid.
pub trait RobotMap: CastRay {
    /// Takes one reading of `sensor`, at `now`, into the map; returns the number of cells it contributed to.
    ///
    /// # Errors
    ///
    /// [`UnknownSensor`] if the map was made for fewer sensors.
    fn integrate(
        &mut self,
        sensor: SensorId,
        beam: &Beam,
        model: &BeamModel,
        now: Ticks,
    ) -> Result<u32, UnknownSensor>;

    /// Takes one reading of `sensor`, at `now`, into its health and not into the map.
    ///
    /// # Errors
    ///
    /// [`UnknownSensor`] if the map was made for fewer sensors.
    fn record(
        &mut self,
        sensor: SensorId,
        reading: Reading,
        now: Ticks,
    ) -> Result<(), UnknownSensor>;

    /// Returns the sensors' health as the map's comparisons left it, in the order of their numbers.
    fn health(&self) -> &[Health];
}

impl<G: CertaintyGrid, H: AsRef<[Health]> + AsMut<[Health]>> CastRay for Mapper<G, H> {
    fn cast(&self, from: Pose, range: Millimeters, obstacle: Certainty) -> RayHit {
        RayHit::in_map(&self.environment(), from, range, obstacle)
    }
}

impl<G: CertaintyGrid, H: AsRef<[Health]> + AsMut<[Health]>> RobotMap for Mapper<G, H> {
    fn integrate(
        &mut self,
        sensor: SensorId,
        beam: &Beam,
        model: &BeamModel,
        now: Ticks,
    ) -> Result<u32, UnknownSensor> {
        Self::integrate(self, sensor, beam, model, now)
    }

    fn record(
        &mut self,
        sensor: SensorId,
        reading: Reading,
        now: Ticks,
    ) -> Result<(), UnknownSensor> {
        Self::record(self, sensor, reading, now)
    }

    fn health(&self) -> &[Health] {
        Self::health(self)
    }
}

/// What a [`Pilot`] needs to know about the sensors.
///
/// In a map the rangefinders are sensors 1 to `R`, the scanner is sensor `R` + 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SensorModel<const R: usize = RANGEFINDERS> {
    /// Where the sensors look, and how they are compared.
    pub check: CrossCheckConfig<R>,
    /// What is plausible for a single sensor.
    pub validation: ValidationRules,
    /// How a reading is drawn into a map.
    pub beams: BeamModel,
    /// Cells with a certainty above this stop a ray.
    pub obstacle: Certainty,
}

impl<const R: usize> SensorModel<R> {
    /// Draws the readings of a robot at `robot` into `map`, the rangefinders first.
    ///
    /// Readings of `excluded` sensors change no cell, as after the validation before the fusion of \[002\] Fig. 1:
    /// a faulty scanner has a hundred times as many readings as a rangefinder, and a map drawn from them would
    /// contradict the sound sensors. That the sensor sent something is recorded all the same.
    pub fn draw<M: RobotMap, const B: usize>(
        &self,
        map: &mut M,
        readings: &SensorReadings<R, B>,
        robot: Pose,
        now: Ticks,
        excluded: &SensorFlags<R>,
    ) {
        let mountings = &self.check.mountings;
        let scanner = robot.compose(mountings.scanner);
        let mut draw = |slot: usize, pose: Pose, reading: Reading, is_excluded: bool| {
            let Some(sensor) = SensorId::from_slot(slot) else {
                return;
            };
            // Both fail only if the map has no such sensor, and then there is nothing to draw.
            if is_excluded {
                let _ = map.record(sensor, reading, now);
            } else {
                let beam = Beam {
                    origin: pose.at,
                    bearing: pose.heading,
                    reading,
                };
                let _ = map.integrate(sensor, &beam, &self.beams, now);
            }
        };
        let rangefinders = mountings.rangefinders.iter().zip(&readings.rangefinders);
        let flagged = rangefinders.zip(&excluded.rangefinders).zip(0..R);
        for (((&mounting, &reading), &is_excluded), slot) in flagged {
            draw(slot, robot.compose(mounting), reading, is_excluded);
        }
        for (&reading, index) in readings.scan.iter().zip(0..=u8::MAX) {
            let bearing = scanner.heading + ScanGeometry::<B>::bearing(index);
            draw(R, Pose::new(scanner.at, bearing), reading, excluded.scanner);
        }
    }

    /// Returns the scan that a robot at `robot` can expect from `map`.
    #[must_use]
    pub fn expected<const B: usize>(&self, map: &impl CastRay, robot: Pose) -> ExpectedScan<R, B> {
        ExpectedScan::of_map(map, robot, &self.check.mountings, self.obstacle)
    }
}

/// Returns the failures of the rangefinders by `map`'s comparisons of cells, and of the scanner if it sends
/// nothing.
///
/// The scanner draws nearly all of the map: few of its cells are compared with another sensor's, and most of
/// those with one rangefinder's, whose failure would count against it. So the comparisons do not count for it.
fn failures_by_map<const R: usize>(map: &impl RobotMap) -> Failures<R> {
    let mut failures = Failures::of_health(map.health().iter().take(R));
    let is_missing = map.health().get(R).is_none_or(|health| {
        health.is_stale() || health.missing_in_a_row() >= HealthRules::FAILED_MISSING
    });
    if is_missing {
        failures.scanner = Failure::TOTAL;
    }
    failures
}

/// The maps of a [`Pilot`], and what they are used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PilotMaps<M> {
    /// The map that readings are compared with; without it they are compared with each other only.
    pub memory: Option<M>,
    /// Whether readings of failed sensors are filled in from the memory.
    pub fills_in: bool,
    /// What the histogram is made from.
    pub histogram: HistogramSource<M>,
}

/// What the histogram of \[004\] eq. 6 is made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum HistogramSource<M> {
    /// The scanner's beams, as in \[004\].
    Scanner,
    /// The pilot's memory; without one the scanner's beams.
    Memory,
    /// A map of its own, drawn with the same readings as the memory.
    Map(M),
}

/// Where the failures of the sensors come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FailureSource<const R: usize = RANGEFINDERS> {
    /// They are given, as in \[004\].
    Given(Failures<R>),
    /// The pilot diagnoses them.
    Diagnosed,
}

/// The output of one step of a [`Pilot`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Decision<const R: usize = RANGEFINDERS> {
    /// The command.
    pub command: Command,
    /// **F** as given or diagnosed, before readings were filled in.
    pub failures: Failures<R>,
}

/// Why a [`Pilot`] cannot be created.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PilotError {
    /// The configuration of the cross-check does not fit.
    CrossCheck(CrossCheckConfigError),
    /// A map has too few sensors.
    TooFewSensors,
}

impl fmt::Display for PilotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CrossCheck(error) => error.fmt(f),
            Self::TooFewSensors => f.write_str(
                "a map has too few sensors: expected one more than there are rangefinders",
            ),
        }
    }
}

impl core::error::Error for PilotError {}

/// A robot's control level: diagnoses its sensors, draws maps with the trusted ones, fills in the others from
/// the map, and controls the wheels.
///
/// Use it if the robot has a map of its own. A [`Controller`] alone is enough if the failures are known.
///
/// Cost: per step the cells on 11 `R` + `B` lines, `B` more if the histogram is made from a map, and as many
/// readings drawn as there are. Memory: the maps,
/// the [`Diagnosis`], the rules.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Pilot<M, const R: usize = RANGEFINDERS, const B: usize = BEAMS> {
    sensors: SensorModel<R>,
    controller: Controller<ControlRules<R>, R>,
    diagnosis: Diagnosis<R, B>,
    maps: PilotMaps<M>,
}

impl<M: RobotMap, const R: usize, const B: usize> Pilot<M, R, B> {
    /// Creates the pilot of a robot that stands still.
    ///
    /// # Errors
    ///
    /// [`PilotError`] if the cross-check's configuration does not fit, or a map is for fewer than `R` + 1
    /// sensors.
    pub fn try_new(
        sensors: SensorModel<R>,
        rules: ControlRules<R>,
        maps: PilotMaps<M>,
    ) -> Result<Self, PilotError> {
        let check = CrossCheck::try_new(sensors.check).map_err(PilotError::CrossCheck)?;
        let own = match &maps.histogram {
            HistogramSource::Map(map) => Some(map),
            HistogramSource::Scanner | HistogramSource::Memory => None,
        };
        let mut all = maps.memory.iter().chain(own);
        if all.any(|map| map.health().len() <= R) {
            return Err(PilotError::TooFewSensors);
        }
        Ok(Self {
            sensors,
            controller: Controller::new(rules, Side::Left),
            diagnosis: Diagnosis::new(sensors.validation, check),
            maps,
        })
    }

    /// Decides what to do with the readings that a robot at `pose` took at `now`.
    pub fn step(
        &mut self,
        readings: &SensorReadings<R, B>,
        pose: Pose,
        goal: Point,
        now: Ticks,
        source: FailureSource<R>,
    ) -> Decision<R> {
        let mut readings = *readings;
        let memory = self.maps.memory.as_ref();
        let expected = memory.map(|map| self.sensors.expected(map, pose));
        let assessment = match source {
            FailureSource::Given(failures) => Assessment {
                failures,
                excluded: failures.failed(),
            },
            FailureSource::Diagnosed => {
                self.diagnosis.validate(&mut readings, pose, now);
                self.diagnosis.assess(&readings, expected.as_ref())
            }
        };
        let own = match &mut self.maps.histogram {
            HistogramSource::Map(map) => Some(map),
            HistogramSource::Scanner | HistogramSource::Memory => None,
        };
        for map in self.maps.memory.iter_mut().chain(own) {
            (self.sensors).draw(map, &readings, pose, now, &assessment.excluded);
        }
        let failures = match (source, &self.maps.memory) {
            (FailureSource::Diagnosed, Some(map)) => {
                assessment.failures.worst(failures_by_map(map))
            }
            _ => assessment.failures,
        };
        let completed = match expected.as_ref().filter(|_| self.maps.fills_in) {
            Some(expected) => expected.complete(&readings.rangefinders, &readings.scan, &failures),
            None => Completed {
                rangefinders: readings.rangefinders,
                scan: &readings.scan,
                failures,
            },
        };
        let mountings = &self.sensors.check.mountings;
        let from_map: Option<[Reading; B]> = self.histogram_map().map(|map| {
            let scanner = pose.compose(mountings.scanner);
            scan_of_map(map, scanner, mountings.scanner_range, self.sensors.obstacle)
        });
        let command = self.controller.step(&ControlInput {
            now,
            pose,
            goal,
            rangefinders: completed.rangefinders.map(|what| Stamped { what, at: now }),
            scan: Stamped {
                what: from_map.as_ref().unwrap_or(completed.scan),
                at: now,
            },
            failures: completed.failures,
        });
        Decision { command, failures }
    }

    /// Returns the map that the histogram is made from, if any.
    #[must_use]
    pub const fn histogram_map(&self) -> Option<&M> {
        match &self.maps.histogram {
            HistogramSource::Scanner => None,
            HistogramSource::Memory => self.maps.memory.as_ref(),
            HistogramSource::Map(map) => Some(map),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::ControlConfig;
    use crate::controller::SpeedLimit;
    use crate::sensors::Mountings;
    use certainty_core::fusion::{BayesGrid, BeamConfig, Geometry, Strength};
    use certainty_core::transducer::ValidationConfig;
    use certainty_core::units::BinaryAngle;

    const RANGE: Millimeters = Millimeters::new(4000);
    const GOAL: Point = Point::from_mm(20_000, 0);

    fn at(x: i32, y: i32, degrees: i32) -> Pose {
        let heading = BinaryAngle::from_millidegrees(degrees * 1000);
        Pose::new(Point::from_mm(x, y), heading)
    }

    fn model<const R: usize>(rangefinders: [Pose; R]) -> SensorModel<R> {
        let validation = ValidationConfig {
            nearest: Millimeters::new(30),
            farthest: RANGE,
            jump: Millimeters::new(500),
            speed_mm_s: 1000,
            compare_within: 200,
            max_repeats: 8,
            repeat_noise: 0,
        };
        SensorModel {
            check: CrossCheckConfig::new(Mountings {
                rangefinders,
                scanner: Mountings::IBIS.scanner,
                rangefinder_range: RANGE,
                scanner_range: RANGE,
            }),
            validation: ValidationRules::try_new(validation).unwrap(),
            beams: BeamModel::try_new(BeamConfig::narrow(RANGE)).unwrap(),
            obstacle: Certainty::from_bits(192),
        }
    }

    fn six() -> SensorModel {
        model(Mountings::IBIS.rangefinders)
    }

    type Map<const SENSORS: usize> = Mapper<BayesGrid<Geometry, Vec<u8>>, [Health; SENSORS]>;

    /// 12 m by 12 m around the origin.
    fn map<const SENSORS: usize>() -> Map<SENSORS> {
        let corner = Point::from_mm(-6000, -6000);
        let shape = Geometry::try_new(120, 120, Millimeters::new(100), corner).unwrap();
        let grid = BayesGrid::try_new(shape, Strength::MEASUREMENT, vec![0; 14_400]).unwrap();
        Mapper::new(grid, HealthRules::DEFAULT)
    }

    fn maps<const SENSORS: usize>() -> PilotMaps<Map<SENSORS>> {
        PilotMaps {
            memory: Some(map()),
            fills_in: true,
            histogram: HistogramSource::Scanner,
        }
    }

    /// A second of the same readings, of a robot that stays where it is.
    fn settled<M: RobotMap, const R: usize, const B: usize>(
        pilot: &mut Pilot<M, R, B>,
        readings: &SensorReadings<R, B>,
        from_ms: u32,
        source: FailureSource<R>,
    ) -> Decision<R> {
        let mut last = None;
        for ms in (from_ms..from_ms + 1000).step_by(50) {
            let now = Ticks::new(ms);
            last = Some(pilot.step(readings, Pose::default(), GOAL, now, source));
        }
        last.unwrap()
    }

    #[test]
    fn in_the_open_it_goes_at_full_speed() {
        let open = SensorReadings {
            rangefinders: [Reading::NoObject; 6],
            scan: [Reading::NoObject; 101],
        };
        let mut pilot = Pilot::try_new(six(), ControlRules::DEFAULT, maps::<7>()).unwrap();
        let decision = settled(&mut pilot, &open, 0, FailureSource::Diagnosed);
        assert_eq!(decision.failures, Failures::NONE);
        assert_eq!(decision.command.speed_limit, SpeedLimit::None);
        assert_eq!(decision.command.wheels.right, crate::Effort::ONE);
    }

    /// A wall 2 m ahead of the scanner; later the scanner reports nothing any more.
    #[test]
    fn a_scanner_that_goes_blind_is_found_by_the_map() {
        let wall = |beam: usize| {
            let angle = (beam as f64 - 50.0).to_radians();
            // Noise, as the same distance again and again is implausible.
            let mm = 2000.0 / angle.cos() + (beam % 7) as f64;
            Reading::Echo(Millimeters::new(mm as u32))
        };
        let mut readings = SensorReadings {
            rangefinders: [Reading::NoObject; 6],
            scan: core::array::from_fn(wall),
        };
        let mut maps = maps::<7>();
        maps.histogram = HistogramSource::Memory;
        let mut pilot = Pilot::try_new(six(), ControlRules::DEFAULT, maps).unwrap();
        // Without the rangefinders, which would see the wall as well.
        readings.rangefinders = [Reading::Missing(certainty_core::transducer::Missing::Timeout); 6];
        settled(&mut pilot, &readings, 0, FailureSource::Diagnosed);
        readings.scan = [Reading::NoObject; 101];
        let decision = settled(&mut pilot, &readings, 1000, FailureSource::Diagnosed);
        assert!(decision.failures.scanner.is_failed());
    }

    #[test]
    fn excluded_readings_are_recorded_but_not_drawn() {
        let readings = SensorReadings {
            rangefinders: [Reading::Echo(Millimeters::new(1000)); 6],
            scan: [Reading::Echo(Millimeters::new(1000)); 101],
        };
        let mut drawn = map::<7>();
        let (now, all) = (Ticks::new(0), SensorFlags::ALL);
        six().draw(&mut drawn, &readings, Pose::default(), now, &all);
        let expected = |map| -> ExpectedScan { six().expected(map, Pose::default()) };
        assert!(expected(&drawn) == expected(&map::<7>()));
        for slot in 0..7 {
            assert!(!drawn.health()[slot].is_stale(), "{slot}");
        }
    }

    #[test]
    fn a_map_for_too_few_sensors_is_refused() {
        let pilot: Result<Pilot<_>, _> = Pilot::try_new(six(), ControlRules::DEFAULT, maps::<6>());
        assert_eq!(pilot.unwrap_err(), PilotError::TooFewSensors);
    }

    #[test]
    fn two_rangefinders_and_61_beams_are_a_robot_too() {
        use crate::{Braitenberg, CoverageConfig, Effort};
        let base = ControlConfig::DEFAULT;
        let rules = ControlRules::try_new(ControlConfig {
            braitenberg: Braitenberg::new([Effort::lit("-0.5")]),
            rangefinder_default: base.rangefinder_default,
            histogram: base.histogram,
            weights: base.weights,
            sharing: base.sharing,
            coverage: CoverageConfig {
                rangefinders: [Effort::lit("0.25"); 2],
                scanner: Effort::ONE,
                least: Effort::lit("0.3"),
            },
            limits: base.limits,
            goal_radius: base.goal_radius,
            stale_after: base.stale_after,
        })
        .unwrap();
        let sensors = model([at(390, 170, 15), at(390, -170, -15)]);
        let mut pilot: Pilot<_, 2, 61> = Pilot::try_new(sensors, rules, maps::<3>()).unwrap();
        let open = SensorReadings {
            rangefinders: [Reading::NoObject; 2],
            scan: [Reading::NoObject; 61],
        };
        let going = settled(&mut pilot, &open, 0, FailureSource::Diagnosed);
        assert_eq!(going.command.wheels.right, Effort::ONE);
        let all = FailureSource::Given(Failures::ALL);
        let stopped = settled(&mut pilot, &open, 1000, all);
        assert_eq!(stopped.command.speed_limit, SpeedLimit::Blind);
        assert_eq!(stopped.command.wheels, crate::Wheels::STOPPED);
    }
}
