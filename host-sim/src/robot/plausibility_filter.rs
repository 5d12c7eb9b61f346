//! What a sensor's own readings say about it, before anybody else is asked (\[002\] Fig. 1).

use super::sensors::{FARTHEST, NEAREST};
use certainty_core::transducer::{
    Finding, Missing, Reading, ValidationConfig, ValidationRules, Validator,
};
use certainty_core::units::{BinaryAngle, Millimeters, Pose, Ticks};

/// What a jump adds to the count of jumps; a reading that is none takes one.
const JUMP: u8 = 4;
/// From here on a sensor that jumps is no sensor.
const TOO_MANY: u8 = 16;
/// The count grows no further: so soon is one believed again that stopped jumping.
const MOST: u8 = 40;

/// Watches one rangefinder, or one beam of a scanner, of a robot that moves.
///
/// What it takes out goes on as *missing, implausible*:
/// - the same millimetre, or *too near*, again and again while the robot turns, as the noise of a laser
///   that measures would change it;
/// - jumps one after the other: an edge is one jump, a sensor that guesses jumps three times in four.
#[derive(Debug, Clone, Copy)]
pub struct PlausibilityFilter {
    rules: ValidationRules,
    /// In the map's frame, where the robot's turning makes directions new.
    words: Validator,
    /// In the robot's frame, where the direction is always the same.
    distances: Validator,
    jumps: u8,
}

/// Returns what the readings are held to.
///
/// With noise of 15 mm two readings are the same to the millimetre once in fifty times: eight more of
/// the same in new directions are no measurement. A jump is half a metre, beyond what a robot at full
/// speed explains.
const RULES: ValidationRules = ValidationRules::new(ValidationConfig {
    nearest: NEAREST,
    farthest: FARTHEST,
    jump: Millimeters::new(500),
    speed_mm_s: 1000,
    compare_within: 200,
    max_repeats: 8,
});

impl PlausibilityFilter {
    /// Creates the watch of a sensor that has said nothing yet.
    #[must_use]
    pub fn new() -> Self {
        Self {
            rules: RULES,
            words: Validator::new(),
            distances: Validator::new(),
            jumps: 0,
        }
    }

    /// Returns what goes on of `reading`, taken at `now` by a sensor at `pose` in the map.
    pub fn judge(&mut self, reading: Reading, pose: Pose, now: Ticks) -> Reading {
        // *Too near* is a word as well: who is as near as that in every direction is within the robot.
        let (claim, word) = match reading {
            Reading::Echo(distance) => (reading, Some(distance.get() as u8)),
            Reading::TooNear => (Reading::Echo(NEAREST), Some(0)),
            Reading::NoObject | Reading::Missing(_) => (reading, None),
        };
        let bearing = pose.heading;
        let (rules, ahead) = (&self.rules, BinaryAngle::ZERO);
        let by_word = self.words.validate(rules, claim, word, bearing, now);
        let by_distance = self.distances.validate(rules, reading, None, ahead, now);
        self.jumps = match by_distance.finding {
            Finding::Jump => self.jumps.saturating_add(JUMP).min(MOST),
            _ => self.jumps.saturating_sub(1),
        };
        match by_word.reading {
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

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::units::Point;

    const OUT: Reading = Reading::Missing(Missing::Implausible);

    /// What is left of distances that are read every 50 ms by a robot that turns 1° in each.
    fn left_of(distances: impl IntoIterator<Item = u32>) -> Vec<Reading> {
        let echoes = distances
            .into_iter()
            .map(|mm| Reading::Echo(Millimeters::new(mm)));
        left(echoes)
    }

    fn left(readings: impl IntoIterator<Item = Reading>) -> Vec<Reading> {
        let mut watch = PlausibilityFilter::new();
        let numbered = (0..).zip(readings);
        let judged = numbered.map(|(step, reading)| {
            let heading = BinaryAngle::from_millidegrees(1000 * step);
            let pose = Pose::new(Point::ORIGIN, heading);
            watch.judge(reading, pose, Ticks::new(50 * step.unsigned_abs()))
        });
        judged.collect()
    }

    #[test]
    fn a_word_that_never_changes_is_taken_out_from_the_ninth_on() {
        let left = left_of([250; 12]);
        assert!(left[..8].iter().all(|&reading| reading != OUT));
        assert_eq!(left[8..], [OUT; 4]);
    }

    #[test]
    fn too_near_in_every_direction_is_a_word_that_never_changes() {
        let left = left([Reading::TooNear; 12]);
        assert_eq!(left[..8], [Reading::TooNear; 8]);
        assert_eq!(left[8..], [OUT; 4]);
    }

    /// 4 a jump: 16 at the fourth.
    #[test]
    fn one_that_jumps_all_the_time_is_taken_out_until_it_stops() {
        let guesses = [300, 2500, 900, 3900, 1200, 200];
        let left = left_of(guesses.into_iter().chain((0..20).map(|step| 1000 + step)));
        assert!(left[..4].iter().all(|&reading| reading != OUT));
        assert_eq!(left[4..6], [OUT; 2]);
        // A sixth jump to 1000 makes it 24; nine readings later it is 15.
        assert_eq!(left[14], OUT);
        assert_ne!(left[15], OUT);
    }

    #[test]
    fn edges_and_a_wall_that_comes_nearer_are_plausible() {
        let wall = (0..30).map(|step| 2000 - 45 * step);
        let edges = (0..30).map(|step| if step / 5 % 2 == 0 { 800 } else { 3000 } + step);
        let left = left_of(wall.chain(edges));
        assert!(left.iter().all(|&reading| reading != OUT));
    }
}
