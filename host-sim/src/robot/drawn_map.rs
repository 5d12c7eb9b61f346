//! A map that the robot draws on its way.

use super::course::Course;
use super::diagnosis::Doubted;
use super::sensors::{FARTHEST, Glance, SCANNER, SCANNER_POSE, beam_model, rangefinders, views};
use crate::fusion::{HostMapper, Method};
use certainty_control::{ExpectedScan, Failure, Failures, PerBeam, SENSORS, beam_bearing};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::{Beam, BeamModel};
use certainty_core::health::{Health, HealthRules};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::{Point, Pose, Ticks};

/// A cell surer than this stops a beam through a map: half way from *uncertain* to *occupied*.
const OBSTACLE: Certainty = Certainty::from_bits(192);

/// A certainty grid of the course, and how it is drawn.
#[derive(Debug)]
pub struct DrawnMap {
    mapper: HostMapper,
    model: BeamModel,
}

impl DrawnMap {
    /// Creates an empty map of `course`.
    #[must_use]
    pub fn new(course: &Course, method: Method) -> Self {
        Self {
            mapper: course.map(method, SENSORS as u8),
            model: beam_model(),
        }
    }

    /// Returns the grid, with the health of those who draw it.
    #[must_use]
    pub const fn mapper(&self) -> &HostMapper {
        &self.mapper
    }

    /// Draws what the sensors say, the rangefinders first.
    ///
    /// Who is doubted is not drawn, as a validation before the fusion (\[002\] Fig. 1): a scanner speaks a
    /// hundred times as often as a rangefinder, and a map of its lies would blame the others. That it was
    /// heard is recorded all the same.
    ///
    /// # Panics
    ///
    /// Never: the map is made for the robot's sensors.
    pub fn draw(&mut self, glance: &Glance, robot: Pose, now: Ticks, doubted: &Doubted) {
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
                    _ if doubted[sensor.slot()] => Reading::TooNear,
                    _ => reading,
                },
            };
            let integrated = self.mapper.integrate(sensor, &beam, &self.model, now);
            integrated.expect("the map is made for seven sensors");
        }
    }

    /// Returns what the map shows where the scanner of a robot at `robot` looks.
    #[must_use]
    pub fn scan(&self, robot: Pose) -> PerBeam<Reading> {
        let scanner = robot.compose(SCANNER_POSE);
        self.mapper.scan(scanner, FARTHEST, OBSTACLE)
    }

    /// Returns what the map shows where all sensors of a robot at `robot` look.
    #[must_use]
    pub fn recollection(&self, robot: Pose) -> ExpectedScan {
        self.mapper.expected_scan(robot, &views(), OBSTACLE)
    }

    /// Returns what the comparisons of the grid's cells say of the rangefinders, and who is silent.
    ///
    /// The scanner draws nearly all of the map: few of its cells are compared with anybody's, and most of those
    /// with one rangefinder's, whose lies would fall on it. So its comparisons say nothing of it here.
    #[must_use]
    pub fn failures(&self) -> Failures {
        let health = self.mapper.health();
        let health: Vec<Health> = health.into_iter().map(|(_, own)| own).collect();
        let mut failures = Failures::of_health(&health);
        let of_scanner = health.get(SCANNER.slot());
        let silent = of_scanner.is_none_or(|own| {
            own.is_stale() || own.missing_in_a_row() >= HealthRules::FAILED_MISSING
        });
        failures.scanner = if silent {
            Failure::TOTAL
        } else {
            Failure::NONE
        };
        failures
    }
}

#[cfg(test)]
mod tests {
    use super::super::sensors::RobotSensors;
    use super::*;
    use certainty_control::BEAMS;

    /// Draws what a robot at the start of the built-in course sees, and recalls it.
    fn recalled(doubted: &Doubted) -> (Glance, ExpectedScan) {
        let course = Course::built_in();
        let mut sensors = RobotSensors::new(&course.world, &[], 1).unwrap();
        let mut map = DrawnMap::new(&course, Method::Robust);
        let glance = sensors.look(course.start, Ticks::new(0));
        for step in 0..3 {
            let now = Ticks::new(50 * step);
            let glance = sensors.look(course.start, now);
            map.draw(&glance, course.start, now, doubted);
        }
        (glance, map.recollection(course.start))
    }

    #[test]
    fn what_is_drawn_is_remembered_where_it_was_seen() {
        let (glance, memory) = recalled(&[false; SENSORS]);
        let mut met = 0;
        for (seen, shown) in glance.scan.iter().zip(&memory.scan) {
            // Beyond 3.5 m an echo's spread reaches out of range.
            if let (Reading::Echo(seen), Reading::Echo(shown)) = (seen, shown)
                && seen.get() < 3500
            {
                met += 1;
                // A cell's diagonal and a beam's spread, or another obstacle's edge a cell away.
                assert!(shown.get() <= seen.get() + 250, "{seen} {shown}");
            }
        }
        assert!(met >= 10, "{met}");
    }

    #[test]
    fn who_is_doubted_is_heard_and_not_drawn() {
        let (_, memory) = recalled(&[true; SENSORS]);
        assert_eq!(memory.scan, [Reading::NoObject; BEAMS]);
        let course = Course::built_in();
        let mut sensors = RobotSensors::new(&course.world, &[], 1).unwrap();
        let mut map = DrawnMap::new(&course, Method::Robust);
        let now = Ticks::new(0);
        let glance = sensors.look(course.start, now);
        map.draw(&glance, course.start, now, &[true; SENSORS]);
        for (id, health) in map.mapper().health() {
            assert!(!health.is_stale(), "{id:?}");
        }
    }
}
