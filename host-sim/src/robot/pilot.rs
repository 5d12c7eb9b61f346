//! Settings of the control level in a run: source of the failures, memory, source of the histogram.

use super::course::Course;
use super::sensors::sensor_model;
use crate::fusion::{HostMapper, Method};
use certainty_control::{
    ControlConfig, ControlRules, CoverageConfig, Effort, FailureSharing, HistogramSource, Pilot,
    PilotMaps, RANGEFINDERS, SENSORS,
};
use core::fmt;

/// Source of the control level's failure estimates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum HealthMode {
    /// The true faults without delay, as in \[004\].
    Given,
    /// The robot's own diagnosis.
    Diagnosed,
    /// None: **F** is zero.
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

/// Robots that replace the readings of failed sensors by those expected from their map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Memory {
    /// None, as in \[004\].
    Nobody,
    /// Those that diagnose their sensors: the diagnosis needs the map in any case.
    Diagnosed,
    /// All, so that the effect of the memory can be separated from that of the diagnosis.
    Everyone,
}

impl Memory {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Nobody, Self::Diagnosed, Self::Everyone];

    /// Returns its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nobody => "nobody",
            Self::Diagnosed => "diagnosed",
            Self::Everyone => "everyone",
        }
    }

    /// Returns whether a robot in this health mode fills in readings.
    #[must_use]
    pub fn applies_to(self, mode: HealthMode) -> bool {
        match self {
            Self::Nobody => false,
            Self::Diagnosed => mode == HealthMode::Diagnosed,
            Self::Everyone => true,
        }
    }
}

/// Source of the obstacles in the histogram.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapSource {
    /// The scanner's last beams, as in \[004\].
    Beams,
    /// A certainty grid of all sensors' readings, as in the first vector field histogram.
    Map(Method),
}

impl MapSource {
    /// All of them, in the order of the help.
    pub const ALL: [Self; 5] = [
        Self::Beams,
        Self::Map(Method::Bayes),
        Self::Map(Method::Robust),
        Self::Map(Method::Trimmed),
        Self::Map(Method::Median),
    ];

    /// Returns its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Beams => "beams",
            Self::Map(method) => method.name(),
        }
    }
}

impl fmt::Display for MapSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Settings of the control level that differ from the default.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PilotConfig {
    /// Whether full speed is allowed as long as any sensor is trusted, as in \[004\]'s simulations.
    pub bold: bool,
    /// Effect of a failed rangefinder on the credibility of the others.
    pub sharing: FailureSharing,
    /// Robots that replace readings of failed sensors from their map.
    pub memory: Memory,
}

impl Default for PilotConfig {
    fn default() -> Self {
        Self {
            bold: false,
            sharing: ControlConfig::DEFAULT.sharing,
            memory: Memory::Diagnosed,
        }
    }
}

impl PilotConfig {
    /// Returns the rules.
    ///
    /// # Panics
    ///
    /// Only if the constants do not fit together, which a test excludes.
    #[must_use]
    pub fn rules(self) -> ControlRules {
        let default = ControlConfig::DEFAULT;
        let any = CoverageConfig {
            rangefinders: [Effort::ONE; RANGEFINDERS],
            scanner: Effort::ONE,
            ..default.coverage
        };
        let config = ControlConfig {
            coverage: if self.bold { any } else { default.coverage },
            sharing: self.sharing,
            ..default
        };
        ControlRules::try_new(config).expect("every part is within 0 and 1")
    }

    /// Returns the control level for `course`, with empty maps.
    ///
    /// # Panics
    ///
    /// Only if the constants do not fit together, which a test excludes.
    #[must_use]
    pub fn pilot(self, course: &Course, mode: HealthMode, source: MapSource) -> Pilot<HostMapper> {
        let map = |method| course.map(method, SENSORS as u8);
        let fills_in = self.memory.applies_to(mode);
        let memory = (fills_in || mode == HealthMode::Diagnosed).then(|| map(Method::Robust));
        let maps = PilotMaps {
            histogram: match source {
                MapSource::Beams => HistogramSource::Scanner,
                MapSource::Map(Method::Robust) if memory.is_some() => HistogramSource::Memory,
                MapSource::Map(method) => HistogramSource::Map(map(method)),
            },
            memory,
            fills_in,
        };
        Pilot::try_new(sensor_model(), self.rules(), maps).expect("maps for seven sensors")
    }
}

#[cfg(test)]
mod tests {
    use super::super::sensors::RobotSensors;
    use super::*;
    use crate::fault::FaultSpec;
    use certainty_control::{
        CrossCheck, Diagnosis, ExpectedScan, FailureSource, Failures, SensorFlags, SensorReadings,
        SpeedLimit,
    };
    use certainty_core::transducer::Reading;
    use certainty_core::units::Ticks;

    #[test]
    fn a_memory_applies_to_the_robots_it_names() {
        let applies = |memory: Memory| HealthMode::ALL.map(|mode| memory.applies_to(mode));
        assert_eq!(applies(Memory::Nobody), [false; 3]);
        assert_eq!(applies(Memory::Diagnosed), [false, true, false]);
        assert_eq!(applies(Memory::Everyone), [true; 3]);
    }

    #[test]
    fn bold_rules_need_one_sensor_for_full_speed() {
        for sharing in [FailureSharing::Shared, FailureSharing::Own] {
            let config = PilotConfig {
                bold: true,
                sharing,
                ..PilotConfig::default()
            };
            let rules = config.rules();
            assert_eq!(rules.config().coverage.rangefinders, [Effort::ONE; 6]);
            assert_eq!(rules.config().sharing, sharing);
        }
        assert_eq!(PilotConfig::default().rules(), ControlRules::DEFAULT);
    }

    /// A robot that stands at the start, with every sensor given as failed after a second.
    #[test]
    fn a_map_that_no_sensor_draws_moves_no_robot() {
        let course = Course::built_in();
        let config = PilotConfig {
            memory: Memory::Everyone,
            ..PilotConfig::default()
        };
        let mut pilot = config.pilot(&course, HealthMode::Given, MapSource::Beams);
        let mut sensors = RobotSensors::new(&course.world, &[], 1).unwrap();
        let mut step = |ms, given| {
            let now = Ticks::new(ms);
            let readings = sensors.read(course.start, now);
            let source = FailureSource::Given(given);
            let decision = pilot.step(&readings, course.start, course.goal, now, source);
            decision.command.speed_limit
        };
        for ms in (0..1000).step_by(50) {
            step(ms, Failures::NONE);
        }
        assert_ne!(step(1000, Failures::NONE), SpeedLimit::Blind);
        assert_eq!(step(1050, Failures::ALL), SpeedLimit::Blind);
    }

    /// The sensors found to have failed after each of 200 steps at the start of the built-in course.
    fn found(faults: &[&str]) -> Vec<SensorFlags> {
        let faults: Vec<FaultSpec> = faults.iter().map(|fault| fault.parse().unwrap()).collect();
        let course = Course::built_in();
        let model = sensor_model();
        let mut sensors = RobotSensors::new(&course.world, &faults, 1).unwrap();
        let mut map = course.map(Method::Robust, SENSORS as u8);
        let check = CrossCheck::try_new(model.check).unwrap();
        let mut diagnosis = Diagnosis::new(model.validation, check);
        let steps = (0..10_000).step_by(50).map(|ms| {
            let now = Ticks::new(ms);
            let mut readings = sensors.read(course.start, now);
            let expected = model.expected(&map, course.start);
            diagnosis.validate(&mut readings, course.start, now);
            let assessment = diagnosis.assess(&readings, Some(&expected));
            model.draw(&mut map, &readings, course.start, now, &assessment.excluded);
            assessment.failures.failed()
        });
        steps.collect()
    }

    #[test]
    fn no_failure_is_found_while_all_sensors_are_sound() {
        assert_eq!(found(&[]), vec![SensorFlags::NONE; 200]);
    }

    /// It contradicts its own earlier readings, which stay in the map as it is not drawn any more.
    #[test]
    fn a_scanner_that_goes_blind_is_found_by_its_earlier_echoes() {
        let found = found(&["stuck-far:scanner@2s"]);
        let scanner_alone = SensorFlags {
            scanner: true,
            ..SensorFlags::NONE
        };
        assert_eq!(found[..40], vec![SensorFlags::NONE; 40]);
        assert_eq!(found[80..], vec![scanner_alone; 120]);
    }

    /// The map of what a robot at the start of the built-in course reads, and one scan.
    fn drawn(excluded: &SensorFlags) -> (SensorReadings, HostMapper, ExpectedScan) {
        let course = Course::built_in();
        let mut sensors = RobotSensors::new(&course.world, &[], 1).unwrap();
        let mut map = course.map(Method::Robust, SENSORS as u8);
        let first = sensors.read(course.start, Ticks::new(0));
        for step in 0..3 {
            let now = Ticks::new(50 * step);
            let readings = sensors.read(course.start, now);
            sensor_model().draw(&mut map, &readings, course.start, now, excluded);
        }
        let expected = sensor_model().expected(&map, course.start);
        (first, map, expected)
    }

    #[test]
    fn drawn_echoes_are_expected_where_they_were_seen() {
        let (readings, _, expected) = drawn(&SensorFlags::NONE);
        let mut hits = 0;
        for (read, shown) in readings.scan.iter().zip(&expected.scan) {
            // Beyond 3.5 m an echo's spread reaches out of range.
            if let (Reading::Echo(read), Reading::Echo(shown)) = (read, shown)
                && read.get() < 3500
            {
                hits += 1;
                // A cell's diagonal and a beam's spread, or another obstacle's edge a cell away.
                assert!(shown.get() <= read.get() + 250, "{read} {shown}");
            }
        }
        assert!(hits >= 10, "{hits}");
    }

    #[test]
    fn excluded_sensors_are_recorded_but_not_drawn() {
        let (_, map, expected) = drawn(&SensorFlags::ALL);
        assert_eq!(expected.scan, ExpectedScan::<6>::EMPTY.scan);
        for slot in 0..SENSORS {
            let (_, health) = map.health()[slot];
            assert!(!health.is_stale(), "{slot}");
        }
    }
}
