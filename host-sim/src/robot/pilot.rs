//! The control level fed by the robot's sensors, and who tells it which of them have failed.

use super::course::Course;
use super::sensors::{
    FARTHEST, Glance, SCANNER, SCANNER_POSE, beam_model, cross_check, rangefinders,
};
use super::watch::Watch;
use crate::fusion::{HostMapper, Method, UnknownMethod};
use certainty_core::certainty::Certainty;
use certainty_core::control::{
    Blame, Command, ControlConfig, ControlRules, Controller, CoverageConfig, CrossCheck, Dated,
    Failures, PerBeam, PerRangefinder, SENSORS, Side, Signal, Situation, beam_bearing,
};
use certainty_core::fusion::{Beam, BeamModel};
use certainty_core::health::{Health, HealthConfig};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::{Point, Pose, Ticks};
use core::fmt;
use core::str::FromStr;

/// Who tells the control level what has failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum HealthMode {
    /// An oracle, as in \[004\]: at once, and right.
    Given,
    /// The fusion level's health, and the cross-check.
    Diagnosed,
    /// Nobody: **F** is zero.
    Ignored,
}

impl HealthMode {
    /// All of them, in the order of reports.
    pub const ALL: [Self; 3] = [Self::Given, Self::Diagnosed, Self::Ignored];

    /// Returns its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Given => "given",
            Self::Diagnosed => "diagnosed",
            Self::Ignored => "ignored",
        }
    }
}

impl fmt::Display for HealthMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The name is none of a health mode's.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is no way to know health; use given, diagnosed or ignored")]
pub struct UnknownHealthMode(pub String);

impl FromStr for HealthMode {
    type Err = UnknownHealthMode;

    fn from_str(name: &str) -> Result<Self, UnknownHealthMode> {
        let found = Self::ALL.into_iter().find(|mode| mode.name() == name);
        found.ok_or_else(|| UnknownHealthMode(name.to_owned()))
    }
}

/// What the histogram is made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapSource {
    /// The scanner's last beams, as in \[004\].
    Beams,
    /// A certainty grid of all sensors' readings, as in the first vector field histogram.
    Map(Method),
}

impl fmt::Display for MapSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Beams => f.write_str("beams"),
            Self::Map(method) => method.fmt(f),
        }
    }
}

/// The name is neither beams nor a fusion method's.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is nothing to see obstacles in; use beams, bayes, robust, trimmed or median")]
pub struct UnknownMapSource(pub String);

impl FromStr for MapSource {
    type Err = UnknownMapSource;

    fn from_str(name: &str) -> Result<Self, UnknownMapSource> {
        if name == "beams" {
            return Ok(Self::Beams);
        }
        let method: Result<Method, UnknownMethod> = name.parse();
        method
            .map(Self::Map)
            .map_err(|UnknownMethod(name)| UnknownMapSource(name))
    }
}

/// A cell surer than this stops a beam through a map: half way from *uncertain* to *occupied*.
const OBSTACLE: Certainty = Certainty::from_bits(192);

/// The control level and what feeds it.
#[derive(Debug)]
pub struct Pilot {
    controller: Controller,
    /// Whether the map stands in for broken rangefinders.
    stand_in: bool,
    mode: HealthMode,
    /// The map that the histogram is made from.
    map: Option<HostMapper>,
    diagnosis: Option<Diagnosis>,
    model: BeamModel,
}

/// What is known of the sensors by themselves, by each other and by the fusion level.
#[derive(Debug)]
struct Diagnosis {
    watches: PerRangefinder<Watch>,
    mapper: HostMapper,
    check: CrossCheck,
    /// Whether its map is also the histogram's.
    shown: bool,
}

/// What the pilot decided at one step, and what it believed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Decision {
    /// What the wheels are told.
    pub command: Command,
    /// **F** as it was believed.
    pub failures: Failures,
}

/// What of the core's rules a run may have otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Manner {
    /// Whether full speed is allowed as long as any sensor is believed, as in \[004\]'s simulations.
    pub bold: bool,
    /// What a failed rangefinder does to the others.
    pub blame: Blame,
    /// Whether the map stands in for a rangefinder that was found broken; where the robot finds out
    /// itself, as only then there is a map.
    pub stand_in: bool,
}

impl Default for Manner {
    fn default() -> Self {
        Self {
            bold: false,
            blame: ControlConfig::DEFAULT.blame,
            stand_in: true,
        }
    }
}

impl Manner {
    /// Returns the rules.
    ///
    /// # Panics
    ///
    /// Never: a test tries all.
    #[must_use]
    pub fn rules(self) -> ControlRules {
        let default = ControlConfig::DEFAULT;
        let any = CoverageConfig {
            rangefinders: [Signal::ONE; SENSORS - 1],
            scanner: Signal::ONE,
            ..default.coverage
        };
        let config = ControlConfig {
            coverage: if self.bold { any } else { default.coverage },
            blame: self.blame,
            ..default
        };
        ControlRules::try_new(config).expect("every part is within 0 and 1")
    }
}

impl Pilot {
    /// Creates a pilot for `course` that knows nothing yet.
    #[must_use]
    pub fn new(course: &Course, manner: Manner, mode: HealthMode, source: MapSource) -> Self {
        let sensors = SENSORS as u8;
        let diagnosis = (mode == HealthMode::Diagnosed).then(|| Diagnosis {
            watches: core::array::from_fn(|_| Watch::new()),
            mapper: course.map(Method::Robust, sensors),
            check: CrossCheck::new(cross_check()),
            shown: source == MapSource::Map(Method::Robust),
        });
        let shared = diagnosis.as_ref().is_some_and(|diagnosis| diagnosis.shown);
        let map = match source {
            MapSource::Map(method) if !shared => Some(course.map(method, sensors)),
            _ => None,
        };
        Self {
            controller: Controller::new(manner.rules(), Side::Left),
            stand_in: manner.stand_in,
            mode,
            map,
            diagnosis,
            model: beam_model(),
        }
    }

    /// Decides what to do with what the sensors say at `now`; `given` is what an oracle says of them.
    ///
    /// # Panics
    ///
    /// Never: the maps are made for the robot's sensors.
    pub fn decide(
        &mut self,
        glance: &Glance,
        pose: Pose,
        goal: Point,
        now: Ticks,
        given: Failures,
    ) -> Decision {
        let model = self.model;
        let mut validated = glance.clone();
        if let Some(own) = &mut self.diagnosis {
            own.validate(&mut validated, pose, now);
        }
        let glance = &validated;
        let checked = self.diagnosis.as_mut().map(|own| own.check(glance));
        let checked = checked.unwrap_or(Failures::NONE);
        let own = self.diagnosis.iter_mut().map(|own| &mut own.mapper);
        for mapper in own.chain(&mut self.map) {
            draw(mapper, glance, pose, &model, now, &checked);
        }
        let failures = match (self.mode, &mut self.diagnosis) {
            (HealthMode::Given, _) => given,
            (HealthMode::Diagnosed, Some(diagnosis)) => diagnosis.failures().worst(checked),
            _ => Failures::NONE,
        };
        let (mut rangefinders, mut told) = (glance.rangefinders, failures);
        if let Some(own) = self.diagnosis.iter().find(|_| self.stand_in) {
            own.stand_in(&mut rangefinders, &mut told, pose);
        }
        let shown = self.diagnosis.iter().filter(|own| own.shown);
        let mut maps = self.map.iter().chain(shown.map(|own| &own.mapper));
        let scanner = pose.compose(SCANNER_POSE);
        let seen = maps.next().map(|map| map.scan(scanner, FARTHEST, OBSTACLE));
        let scan: &PerBeam<Reading> = seen.as_ref().unwrap_or(&glance.scan);
        let command = self.controller.step(&Situation {
            now,
            pose,
            goal,
            rangefinders: rangefinders.map(|what| Dated { what, at: now }),
            scan: Dated {
                what: scan,
                at: now,
            },
            failures: told,
        });
        Decision { command, failures }
    }

    /// Returns the map that the histogram is made from, if it is made from one.
    #[must_use]
    pub fn map(&self) -> Option<&HostMapper> {
        let shown = self.diagnosis.iter().filter(|own| own.shown);
        self.map.iter().chain(shown.map(|own| &own.mapper)).next()
    }
}

impl Diagnosis {
    /// Takes out what no sound rangefinder says.
    fn validate(&mut self, glance: &mut Glance, robot: Pose, now: Ticks) {
        let own = glance.rangefinders.iter_mut().zip(&mut self.watches);
        for ((reading, watch), mounting) in own.zip(rangefinders()) {
            *reading = watch.judge(*reading, robot.compose(mounting), now);
        }
    }

    /// What the cross-check says after this glance.
    fn check(&mut self, glance: &Glance) -> Failures {
        self.check.observe(&glance.rangefinders, &glance.scan);
        self.check.failures()
    }

    /// Puts what the map shows in the place of what a broken rangefinder says.
    ///
    /// The map is mostly the scanner's and fails with it: then nothing stands in.
    fn stand_in(
        &self,
        readings: &mut PerRangefinder<Reading>,
        failures: &mut Failures,
        robot: Pose,
    ) {
        let half = Signal::lit("0.5");
        let scanner = failures.scanner;
        let own = readings.iter_mut().zip(&mut failures.rangefinders);
        for ((reading, failure), mounting) in own.zip(rangefinders()) {
            if failure.part() >= half && scanner.part() < half {
                *reading = self
                    .mapper
                    .beam(robot.compose(mounting), FARTHEST, OBSTACLE);
                *failure = scanner;
            }
        }
    }

    /// What the grid's comparisons say.
    fn failures(&self) -> Failures {
        let health = self.mapper.health();
        let health: Vec<Health> = health.into_iter().map(|(_, own)| own).collect();
        Failures::of_health(&health, &HealthConfig::DEFAULT)
    }
}

/// Draws what the sensors say into a map, the rangefinders first.
///
/// A sensor that the cross-check does not believe is not drawn, as a validation before the fusion
/// (\[002\] Fig. 1): a scanner speaks a hundred times as often as a rangefinder, and a map of its lies would
/// blame the others. That it was heard is recorded all the same.
fn draw(
    mapper: &mut HostMapper,
    glance: &Glance,
    robot: Pose,
    model: &BeamModel,
    now: Ticks,
    checked: &Failures,
) {
    let half = Signal::lit("0.5");
    let parts = checked.rangefinders.into_iter().chain([checked.scanner]);
    let lies: Vec<bool> = parts.map(|failure| failure.part() >= half).collect();
    let numbered = rangefinders()
        .into_iter()
        .zip(glance.rangefinders)
        .enumerate();
    let own = numbered.filter_map(|(slot, (mounting, reading))| {
        Some((SensorId::from_slot(slot)?, mounting, reading))
    });
    let beams = glance.scan.into_iter().zip(0_u8..).map(|(reading, index)| {
        let along = Pose::new(Point::ORIGIN, beam_bearing(index));
        (SCANNER, SCANNER_POSE.compose(along), reading)
    });
    for (sensor, mounting, reading) in own.chain(beams) {
        let pose = robot.compose(mounting);
        let beam = Beam {
            origin: pose.at,
            bearing: pose.heading,
            reading: match reading {
                Reading::Missing(_) => reading,
                // Heard, and nothing said about any cell.
                _ if lies[sensor.slot()] => Reading::TooNear,
                _ => reading,
            },
        };
        mapper
            .integrate(sensor, &beam, model, now)
            .expect("the map is made for seven sensors");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::control::Failure;
    use certainty_core::units::Millimeters;

    #[test]
    fn names_are_read_back_and_others_refused() {
        for mode in HealthMode::ALL {
            assert_eq!(mode.name().parse(), Ok(mode));
        }
        assert!("Given".parse::<HealthMode>().is_err());
        for name in ["beams", "bayes", "robust", "trimmed", "median"] {
            let source: MapSource = name.parse().unwrap();
            assert_eq!(source.to_string(), name);
        }
        assert!("".parse::<MapSource>().is_err());
    }

    #[test]
    fn bold_rules_need_one_sensor_for_full_speed() {
        for blame in [Blame::Shared, Blame::Own] {
            let manner = Manner {
                bold: true,
                blame,
                ..Manner::default()
            };
            let rules = manner.rules();
            assert_eq!(rules.config().coverage.rangefinders, [Signal::ONE; 6]);
            assert_eq!(rules.config().blame, blame);
        }
        assert_eq!(Manner::default().rules(), ControlRules::DEFAULT);
    }

    #[test]
    fn the_map_stands_in_for_a_broken_rangefinder_unless_the_scanner_is_broken_too() {
        let course = Course::random(1).unwrap();
        let mut diagnosis = Diagnosis {
            watches: core::array::from_fn(|_| Watch::new()),
            mapper: course.map(Method::Robust, SENSORS as u8),
            check: CrossCheck::new(cross_check()),
            shown: false,
        };
        // The scanner saw something a metre from where FL looks.
        let [fl, ..] = rangefinders();
        let from = course.start.compose(fl);
        let beam = Beam {
            origin: from.at,
            bearing: from.heading,
            reading: Reading::Echo(Millimeters::new(1000)),
        };
        for tick in 0..3 {
            let now = Ticks::new(tick);
            let integrated = diagnosis
                .mapper
                .integrate(SCANNER, &beam, &beam_model(), now);
            integrated.unwrap();
        }
        let stood_in = |failures: Failures| {
            let (mut readings, mut failures) = ([Reading::NoObject; 6], failures);
            diagnosis.stand_in(&mut readings, &mut failures, course.start);
            (readings, failures)
        };
        let mut broken = Failures::NONE;
        broken.rangefinders[0] = Failure::TOTAL;
        let (readings, told) = stood_in(broken);
        let Reading::Echo(distance) = readings[0] else {
            panic!("the map shows it: {readings:?}");
        };
        // To the centre of a cell, and the spread of the beam.
        assert!(distance.get().abs_diff(1000) <= 200, "{distance}");
        assert_eq!(readings[1..], [Reading::NoObject; 5]);
        assert_eq!(told, Failures::NONE);

        assert_eq!(stood_in(Failures::NONE).0, [Reading::NoObject; 6]);
        broken.scanner = Failure::TOTAL;
        assert_eq!(stood_in(broken), ([Reading::NoObject; 6], broken));
    }
}
