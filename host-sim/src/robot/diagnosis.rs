//! What the robot finds out about its sensors: each by itself, all by each other, all by what the map
//! remembers.

use super::plausibility_filter::PlausibilityFilter;
use super::sensors::{Glance, SCANNER_POSE, cross_check, rangefinders};
use certainty_control::{
    CrossCheck, ExpectedScan, Failures, PerBeam, PerRangefinder, SENSORS, Verdict, beam_bearing,
};
use certainty_core::units::{Point, Pose, Ticks};

/// Whose words are not to be drawn, by the order of their numbers.
pub type Doubted = [bool; SENSORS];

/// Returns who has failed, by half at least.
#[must_use]
pub fn broken(failures: &Failures) -> Doubted {
    let parts = failures.rangefinders.iter().chain([&failures.scanner]);
    let mut broken = [false; SENSORS];
    for (broken, failure) in broken.iter_mut().zip(parts) {
        *broken = failure.is_broken();
    }
    broken
}

/// Watches over every rangefinder and every beam of the scanner, and compares them with each other and
/// with the map.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    rangefinders: PerRangefinder<PlausibilityFilter>,
    beams: PerBeam<PlausibilityFilter>,
    check: CrossCheck,
}

impl Diagnosis {
    /// Creates the diagnosis of sensors that have said nothing yet.
    ///
    /// # Panics
    ///
    /// Never: the cross-check's configuration is a constant that every test tries.
    #[must_use]
    pub fn new() -> Self {
        Self {
            rangefinders: core::array::from_fn(|_| PlausibilityFilter::new()),
            beams: core::array::from_fn(|_| PlausibilityFilter::new()),
            check: CrossCheck::try_new(cross_check()).expect("somebody can be found broken"),
        }
    }

    /// Takes out what no sound sensor says.
    pub fn validate(&mut self, glance: &mut Glance, robot: Pose, now: Ticks) {
        let own = glance.rangefinders.iter_mut().zip(&mut self.rangefinders);
        for ((reading, watch), mounting) in own.zip(rangefinders()) {
            *reading = watch.judge(*reading, robot.compose(mounting), now);
        }
        let scanner = robot.compose(SCANNER_POSE);
        let own = glance.scan.iter_mut().zip(&mut self.beams);
        for ((reading, watch), index) in own.zip(0_u8..) {
            let beam = scanner.compose(Pose::new(Point::ORIGIN, beam_bearing(index)));
            *reading = watch.judge(*reading, beam, now);
        }
    }

    /// Returns who has failed by this glance and those before, and whose words are not to be drawn: who
    /// has failed, and who contradicts now what the map remembers or shows as surely free.
    ///
    /// A map that its own sensor may wipe out remembers nothing that speaks against it.
    pub fn judge(&mut self, glance: &Glance, memory: &ExpectedScan) -> (Failures, Doubted) {
        let Glance { rangefinders, scan } = glance;
        let verdicts = self.check.observe(rangefinders, scan, Some(memory));
        let failures = self.check.failures();
        let mut doubted = broken(&failures);
        let all = verdicts.rangefinders.iter().chain([&verdicts.scanner]);
        for (doubted, &verdict) in doubted.iter_mut().zip(all) {
            *doubted |= !matches!(verdict, Verdict::Agreement | Verdict::Silence);
        }
        (failures, doubted)
    }
}

impl Default for Diagnosis {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::super::course::Course;
    use super::super::drawn_map::DrawnMap;
    use super::super::sensors::RobotSensors;
    use super::*;
    use crate::fault::FaultSpec;
    use crate::fusion::Method;
    use certainty_control::{Effort, Failure};

    /// Who is believed to be broken after each of 10 s of glances from where the built-in course begins.
    fn believed(faults: &[&str]) -> Vec<Doubted> {
        let faults: Vec<FaultSpec> = faults.iter().map(|fault| fault.parse().unwrap()).collect();
        let course = Course::built_in();
        let mut sensors = RobotSensors::new(&course.world, &faults, 1).unwrap();
        let mut map = DrawnMap::new(&course, Method::Robust);
        let mut diagnosis = Diagnosis::new();
        let glances = (0..10_000).step_by(50).map(|ms| {
            let now = Ticks::new(ms);
            let mut glance = sensors.look(course.start, now);
            let memory = map.recollection(course.start);
            diagnosis.validate(&mut glance, course.start, now);
            let (failures, doubted) = diagnosis.judge(&glance, &memory);
            map.draw(&glance, course.start, now, &doubted);
            broken(&failures)
        });
        glances.collect()
    }

    const NOBODY: Doubted = [false; SENSORS];
    const SCANNER_ALONE: Doubted = [false, false, false, false, false, false, true];

    #[test]
    fn nobody_is_found_broken_while_all_are_sound() {
        assert_eq!(believed(&[]), vec![NOBODY; 200]);
    }

    /// It contradicts what it saw itself, which stays in the map as it is not drawn any more.
    #[test]
    fn a_scanner_that_goes_blind_is_found_by_what_it_saw_before() {
        let believed = believed(&["stuck-far:scanner@2s"]);
        assert_eq!(believed[..40], vec![NOBODY; 40]);
        assert_eq!(believed[80..], vec![SCANNER_ALONE; 120]);
    }

    #[test]
    fn a_given_failure_is_broken_from_half_on() {
        let mut failures = Failures::NONE;
        assert_eq!(broken(&failures), [false; SENSORS]);
        failures.rangefinders[2] = Failure::new_saturating(Effort::lit("0.5"));
        failures.scanner = Failure::new_saturating(Effort::lit("0.49"));
        let expected = [false, false, true, false, false, false, false];
        assert_eq!(broken(&failures), expected);
    }
}
