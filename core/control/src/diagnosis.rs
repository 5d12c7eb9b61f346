//! The robot's diagnosis of its own sensors: each by itself, all against each other and against the map.

use crate::cross_check::{CrossCheck, Verdict};
use crate::expected_scan::ExpectedScan;
use crate::failures::{Failures, SensorFlags};
use crate::sensors::{BEAMS, RANGEFINDERS, ScanGeometry, SensorReadings};
use certainty_core::transducer::{Finding, Missing, Reading, ValidationRules, Validator};
use certainty_core::units::{BinaryAngle, Pose, Ticks};

/// What a jump adds to the count of jumps; any other reading subtracts one.
const JUMP: u8 = 4;
/// From this count on the readings are implausible.
const TOO_MANY: u8 = 16;
/// The highest count, which bounds how long a sensor that stopped jumping is still excluded.
const MOST: u8 = 40;

/// Checks the readings of one rangefinder, or of one beam of a scanner, on a robot that moves (the validation
/// of \[002\] Fig. 1).
///
/// It replaces by *missing, implausible*:
/// - the same millimetre, or *too near*, again and again while the robot turns: the noise of a working sensor
///   would change it;
/// - jumps one after the other: an edge is one jump, random readings jump three times in four.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PlausibilityFilter {
    /// In the map's frame, where a turn of the robot makes the direction new.
    repetitions: Validator,
    /// In the robot's frame, where the direction is always the same.
    distances: Validator,
    jumps: u8,
}

impl PlausibilityFilter {
    /// Creates the filter of a sensor without readings yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            repetitions: Validator::new(),
            distances: Validator::new(),
            jumps: 0,
        }
    }

    /// Returns `reading`, taken at `now` in direction `bearing` of the map, or *missing* in its place.
    pub fn filter(
        &mut self,
        rules: &ValidationRules,
        reading: Reading,
        bearing: BinaryAngle,
        now: Ticks,
    ) -> Reading {
        let value = match reading {
            Reading::Echo(distance) => u16::try_from(distance.get()).ok(),
            Reading::TooNear | Reading::NoObject | Reading::Missing(_) => None,
        };
        let by_repetition = (self.repetitions).validate(rules, reading, value, bearing, now);
        let by_distance = self
            .distances
            .validate(rules, reading, None, BinaryAngle::ZERO, now);
        self.jumps = match by_distance.finding {
            Finding::Jump => self.jumps.saturating_add(JUMP).min(MOST),
            _ => self.jumps.saturating_sub(1),
        };
        match by_repetition.reading {
            Reading::Missing(reason) => Reading::Missing(reason),
            _ if self.jumps >= TOO_MANY => Reading::Missing(Missing::Implausible),
            _ => reading,
        }
    }
}

impl Default for PlausibilityFilter {
    fn default() -> Self {
        Self::new()
    }
}

/// Which sensors have failed, and which must not be drawn into the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Assessment<const R: usize = RANGEFINDERS> {
    /// The estimated failures.
    pub failures: Failures<R>,
    /// The sensors that have failed by half at least, or contradict the map now.
    pub excluded: SensorFlags<R>,
}

/// The diagnosis of `R` rangefinders and a scanner of `B` beams.
///
/// Each step: [`Self::validate`], then [`Self::assess`], then draw the readings of the sensors that are not
/// excluded. A [`Pilot`](crate::Pilot) does all of it.
///
/// Memory: two [`Validator`]s and a byte per rangefinder and per beam, and the [`CrossCheck`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Diagnosis<const R: usize = RANGEFINDERS, const B: usize = BEAMS> {
    rules: ValidationRules,
    rangefinders: [PlausibilityFilter; R],
    beams: [PlausibilityFilter; B],
    check: CrossCheck<R>,
}

impl<const R: usize, const B: usize> Diagnosis<R, B> {
    /// Creates the diagnosis of sensors without readings yet.
    #[must_use]
    pub const fn new(rules: ValidationRules, check: CrossCheck<R>) -> Self {
        Self {
            rules,
            rangefinders: [PlausibilityFilter::new(); R],
            beams: [PlausibilityFilter::new(); B],
            check,
        }
    }

    /// Replaces implausible readings of a robot at `robot` by missing ones.
    pub fn validate(&mut self, readings: &mut SensorReadings<R, B>, robot: Pose, now: Ticks) {
        let mountings = &self.check.config().mountings;
        let scanner = robot.heading + mountings.scanner.heading;
        let each = (readings.rangefinders.iter_mut()).zip(&mut self.rangefinders);
        for ((reading, filter), &mounting) in each.zip(&mountings.rangefinders) {
            let bearing = robot.heading + mounting.heading;
            *reading = filter.filter(&self.rules, *reading, bearing, now);
        }
        let each = readings.scan.iter_mut().zip(&mut self.beams);
        for ((reading, filter), index) in each.zip(0..=u8::MAX) {
            let bearing = scanner + ScanGeometry::<B>::bearing(index);
            *reading = filter.filter(&self.rules, *reading, bearing, now);
        }
    }

    /// Estimates the failures from these readings and those before, and returns which sensors to exclude from
    /// the map: those that have failed, and those that contradict now what the map shows as occupied or as
    /// surely free.
    ///
    /// `expected` is from the map before these readings are drawn. A map that a sensor itself may erase could
    /// not contradict it.
    pub fn assess(
        &mut self,
        readings: &SensorReadings<R, B>,
        expected: Option<&ExpectedScan<R, B>>,
    ) -> Assessment<R> {
        let SensorReadings { rangefinders, scan } = readings;
        let verdicts = self.check.observe(rangefinders, scan, expected);
        let failures = self.check.failures();
        let mut excluded = failures.failed();
        let all = verdicts.rangefinders.iter().chain([&verdicts.scanner]);
        for (is_excluded, &verdict) in excluded.iter_mut().zip(all) {
            *is_excluded |= !matches!(verdict, Verdict::Agreement | Verdict::Silence);
        }
        Assessment { failures, excluded }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::transducer::ValidationConfig;
    use certainty_core::units::Millimeters;

    const IMPLAUSIBLE: Reading = Reading::Missing(Missing::Implausible);

    fn rules() -> ValidationRules {
        let config = ValidationConfig {
            nearest: Millimeters::new(30),
            farthest: Millimeters::new(4000),
            jump: Millimeters::new(500),
            speed_mm_s: 1000,
            compare_within: 200,
            max_repeats: 8,
            repeat_noise: 0,
        };
        ValidationRules::try_new(config).unwrap()
    }

    /// The filtered readings of a robot that turns 1° every 50 ms.
    fn filtered(readings: impl IntoIterator<Item = Reading>) -> Vec<Reading> {
        let mut filter = PlausibilityFilter::new();
        let numbered = (0..).zip(readings);
        let filtered = numbered.map(|(step, reading)| {
            let bearing = BinaryAngle::from_millidegrees(1000 * step);
            let now = Ticks::new(50 * step.unsigned_abs());
            filter.filter(&rules(), reading, bearing, now)
        });
        filtered.collect()
    }

    fn filtered_mm(distances: impl IntoIterator<Item = u32>) -> Vec<Reading> {
        let distances = distances.into_iter();
        filtered(distances.map(|mm| Reading::Echo(Millimeters::new(mm))))
    }

    #[test]
    fn a_repeated_distance_is_missing_from_the_ninth_on() {
        let left = filtered_mm([250; 12]);
        assert!(left[..8].iter().all(|&reading| reading != IMPLAUSIBLE));
        assert_eq!(left[8..], [IMPLAUSIBLE; 4]);
    }

    #[test]
    fn too_near_in_every_direction_is_missing_too() {
        let left = filtered([Reading::TooNear; 12]);
        assert_eq!(left[..8], [Reading::TooNear; 8]);
        assert_eq!(left[8..], [IMPLAUSIBLE; 4]);
    }

    /// 4 a jump: 16 at the fourth.
    #[test]
    fn a_sensor_that_jumps_is_missing_until_it_stops() {
        let guesses = [300, 2500, 900, 3900, 1200, 200];
        let left = filtered_mm(guesses.into_iter().chain((0..20).map(|step| 1000 + step)));
        assert!(left[..4].iter().all(|&reading| reading != IMPLAUSIBLE));
        assert_eq!(left[4..6], [IMPLAUSIBLE; 2]);
        // A sixth jump to 1000 makes it 24; nine readings later it is 15.
        assert_eq!(left[14], IMPLAUSIBLE);
        assert_ne!(left[15], IMPLAUSIBLE);
    }

    #[test]
    fn edges_and_a_wall_that_comes_nearer_are_plausible() {
        let wall = (0..30).map(|step| 2000 - 45 * step);
        let edges = (0..30).map(|step| if step / 5 % 2 == 0 { 800 } else { 3000 } + step);
        let left = filtered_mm(wall.chain(edges));
        assert!(left.iter().all(|&reading| reading != IMPLAUSIBLE));
    }
}
