//! The control level fed by the robot's sensors, by what it finds out about them and what it remembers.

use super::course::Course;
use super::diagnosis::{Diagnosis, broken};
use super::drawn_map::DrawnMap;
use super::modes::{HealthMode, MapSource, Memory};
use super::sensors::Glance;
use crate::fusion::{HostMapper, Method};
use certainty_control::{
    Blame, Command, Completed, ControlConfig, ControlInput, ControlRules, Controller,
    CoverageConfig, Effort, Failures, SENSORS, Side, Stamped,
};
use certainty_core::units::{Point, Pose, Ticks};

/// The control level and what feeds it.
#[derive(Debug)]
pub struct Pilot {
    controller: Controller,
    mode: HealthMode,
    diagnosis: Diagnosis,
    /// What the robot remembers, where it remembers or finds out by itself what has failed.
    memory: Option<DrawnMap>,
    /// Whether the memory makes up for what is not seen.
    remembers: bool,
    source: MapSource,
    /// The map that the histogram is made from, where that is not the memory.
    map: Option<DrawnMap>,
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
pub struct PilotConfig {
    /// Whether full speed is allowed as long as any sensor is believed, as in \[004\]'s simulations.
    pub bold: bool,
    /// What a failed rangefinder does to the others.
    pub blame: Blame,
    /// Who remembers what the map shows.
    pub memory: Memory,
}

impl Default for PilotConfig {
    fn default() -> Self {
        Self {
            bold: false,
            blame: ControlConfig::DEFAULT.blame,
            memory: Memory::Diagnosed,
        }
    }
}

impl PilotConfig {
    /// Returns the rules.
    ///
    /// # Panics
    ///
    /// Never: a test tries all.
    #[must_use]
    pub fn rules(self) -> ControlRules {
        let default = ControlConfig::DEFAULT;
        let any = CoverageConfig {
            rangefinders: [Effort::ONE; SENSORS - 1],
            scanner: Effort::ONE,
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
    pub fn new(course: &Course, manner: PilotConfig, mode: HealthMode, source: MapSource) -> Self {
        let remembers = manner.memory.serves(mode);
        let memory = (remembers || mode == HealthMode::Diagnosed)
            .then(|| DrawnMap::new(course, Method::Robust));
        let map = match source {
            MapSource::Map(Method::Robust) if memory.is_some() => None,
            MapSource::Map(method) => Some(DrawnMap::new(course, method)),
            MapSource::Beams => None,
        };
        Self {
            controller: Controller::new(manner.rules(), Side::Left),
            mode,
            diagnosis: Diagnosis::new(),
            memory,
            remembers,
            source,
            map,
        }
    }

    /// Decides what to do with what the sensors say at `now`; `given` is what an oracle says of them.
    pub fn decide(
        &mut self,
        glance: &Glance,
        pose: Pose,
        goal: Point,
        now: Ticks,
        given: Failures,
    ) -> Decision {
        let mut glance = glance.clone();
        let memory = self.memory.as_ref().map(|map| map.recollection(pose));
        let (mut failures, doubted) = match (self.mode, &memory) {
            (HealthMode::Given, _) => (given, broken(&given)),
            (HealthMode::Diagnosed, Some(memory)) => {
                self.diagnosis.validate(&mut glance, pose, now);
                self.diagnosis.judge(&glance, memory)
            }
            _ => (Failures::NONE, [false; SENSORS]),
        };
        for map in self.memory.iter_mut().chain(&mut self.map) {
            map.draw(&glance, pose, now, &doubted);
        }
        if let (HealthMode::Diagnosed, Some(map)) = (self.mode, &self.memory) {
            failures = failures.worst(map.failures());
        }
        let seen = match memory.as_ref().filter(|_| self.remembers) {
            Some(memory) => memory.complete(&glance.rangefinders, &glance.scan, &failures),
            None => Completed {
                rangefinders: glance.rangefinders,
                scan: &glance.scan,
                failures,
            },
        };
        let shown = self.shown().map(|map| map.scan(pose));
        let command = self.controller.step(&ControlInput {
            now,
            pose,
            goal,
            rangefinders: seen.rangefinders.map(|what| Stamped { what, at: now }),
            scan: Stamped {
                what: shown.as_ref().unwrap_or(seen.scan),
                at: now,
            },
            failures: seen.failures,
        });
        Decision { command, failures }
    }

    /// The map that the histogram is made from, if it is made from one.
    fn shown(&self) -> Option<&DrawnMap> {
        match self.source {
            MapSource::Beams => None,
            MapSource::Map(_) => self.map.as_ref().or(self.memory.as_ref()),
        }
    }

    /// Returns the map that the histogram is made from, if it is made from one.
    #[must_use]
    pub fn map(&self) -> Option<&HostMapper> {
        self.shown().map(DrawnMap::mapper)
    }
}

#[cfg(test)]
mod tests {
    use super::super::sensors::RobotSensors;
    use super::*;
    use certainty_control::SpeedLimit;

    #[test]
    fn bold_rules_need_one_sensor_for_full_speed() {
        for blame in [Blame::Shared, Blame::Own] {
            let manner = PilotConfig {
                bold: true,
                blame,
                ..PilotConfig::default()
            };
            let rules = manner.rules();
            assert_eq!(rules.config().coverage.rangefinders, [Effort::ONE; 6]);
            assert_eq!(rules.config().blame, blame);
        }
        assert_eq!(PilotConfig::default().rules(), ControlRules::DEFAULT);
    }

    /// What a robot that stands at the start decides after a second, with every sensor given as failed
    /// from then on.
    #[test]
    fn a_memory_that_nobody_draws_moves_no_robot() {
        let course = Course::built_in();
        let manner = PilotConfig {
            memory: Memory::Everyone,
            ..PilotConfig::default()
        };
        let mut pilot = Pilot::new(&course, manner, HealthMode::Given, MapSource::Beams);
        let mut sensors = RobotSensors::new(&course.world, &[], 1).unwrap();
        let mut decide = |ms, given| {
            let now = Ticks::new(ms);
            let glance = sensors.look(course.start, now);
            let decision = pilot.decide(&glance, course.start, course.goal, now, given);
            decision.command
        };
        for ms in (0..1000).step_by(50) {
            decide(ms, Failures::NONE);
        }
        assert_ne!(decide(1000, Failures::NONE).caution, SpeedLimit::Blind);
        assert_eq!(decide(1050, Failures::ALL).caution, SpeedLimit::Blind);
    }
}
