//! What the control level is told of the car's senses.

use super::rules::{GOAL, OBSTACLE, SIDES_DEG, SIGHT};
use crate::smart_car::{HEADS, RANGERS};
use certainty_control::{
    BEAMS, Command, ControlInput, ControlRules, Controller, Effort, Failure, Failures, PerBeam,
    Stamped, beam_bearing, beam_in_map,
};
use certainty_core::fusion::{CertaintyGrid, Environment};
use certainty_core::health::Health;
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Pose, Ticks};

/// A fixed ranger, as control hears it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::smart_car) struct RangerInput<'a> {
    pub(in crate::smart_car) reading: Reading,
    /// When it measured.
    pub(in crate::smart_car) measured: Ticks,
    pub(in crate::smart_car) health: &'a Health,
}

/// A round's senses, besides the map.
pub(super) struct ControlInputs<'a> {
    pub(super) now: Ticks,
    /// Where the car is when it does what is decided.
    pub(super) pose: Pose,
    /// Which heads said nothing in this round, the first on the right.
    pub(super) silent: &'a [bool; HEADS as usize],
    /// The first on the right.
    pub(super) rangers: &'a [RangerInput<'a>; RANGERS as usize],
}

impl ControlInputs<'_> {
    /// Lets `controller` decide.
    ///
    /// What its beams meet in the map is the scanner of \[004\]; the rangers are its rangefinders 1, on the
    /// left, and 6. Its other four are what single beams meet in the map to the sides.
    pub(super) fn step<G: CertaintyGrid>(
        &self,
        controller: &mut Controller<&'static ControlRules>,
        map: &Environment<'_, G>,
    ) -> Command {
        let mut scan = [Reading::NoObject; BEAMS];
        look_ahead(&mut scan, map, self.pose);
        let aside = |degrees: i32| {
            let aside = BinaryAngle::from_millidegrees(degrees.wrapping_mul(1000));
            let along = Pose::new(self.pose.at, self.pose.heading.wrapping_add(aside));
            Stamped {
                what: beam_in_map(map, along, SIGHT, OBSTACLE),
                at: self.now,
            }
        };
        let [second, third] = SIDES_DEG;
        let [right, left] = self.rangers.map(|ranger| Stamped {
            what: ranger.reading,
            at: ranger.measured,
        });
        controller.step(&ControlInput {
            now: self.now,
            pose: self.pose,
            goal: GOAL,
            rangefinders: [
                left,
                aside(second),
                aside(third),
                aside(third.wrapping_neg()),
                aside(second.wrapping_neg()),
                right,
            ],
            scan: Stamped {
                what: &scan,
                at: self.now,
            },
            failures: self.failures(map),
        })
    }

    /// How far each sense has failed.
    ///
    /// The map has failed as far as its heads have in the mean: each sweeps all of what lies ahead, so with
    /// one of three gone a third of the looks is missing. A head that says nothing in this round is gone for
    /// this round, before its health gives it up. Where the car is outside its grid the map has failed, as it has
    /// nothing there and would say that nothing is.
    // Not inlined: it is done before the controller needs the stack.
    #[inline(never)]
    fn failures<G: CertaintyGrid>(&self, map: &Environment<'_, G>) -> Failures {
        let heads = map.sensors().zip(self.silent);
        let sum = heads.fold(Effort::ZERO, |sum, ((_, health), &silent)| {
            let failure = if silent {
                Failure::TOTAL
            } else {
                Failure::of_health(health)
            };
            sum + failure.part()
        });
        let mean = sum.checked_div_int(HEADS.into()).unwrap_or(Effort::ONE);
        let [right, left] = self.rangers.map(|ranger| Failure::of_health(ranger.health));
        let map = match map.geometry().cell_at(self.pose.at) {
            Some(_) => Failure::new_saturating(mean),
            None => Failure::TOTAL,
        };
        Failures {
            rangefinders: [left, map, map, map, map, right],
            scanner: map,
        }
    }
}

/// Writes into `scan` what a scanner at `pose` would meet in the map.
///
/// Every second beam is looked up, the one between takes the nearer of its neighbours: as far as the car sees,
/// 2° are less than a third of a cell, and looking all up takes longer than its slot may.
// Not inlined: it is done before the controller needs the stack.
#[inline(never)]
fn look_ahead<G: CertaintyGrid>(scan: &mut PerBeam<Reading>, map: &Environment<'_, G>, pose: Pose) {
    for (reading, index) in scan.iter_mut().zip(0..=u8::MAX).step_by(2) {
        let heading = pose.heading.wrapping_add(beam_bearing(index));
        *reading = beam_in_map(map, Pose::new(pose.at, heading), SIGHT, OBSTACLE);
    }
    let [pairs @ .., last] = scan;
    let mut next = *last;
    for pair in pairs.chunks_exact_mut(2).rev() {
        if let [looked_up, between] = pair {
            *between = nearer(*looked_up, next);
            next = *looked_up;
        }
    }
}

/// The nearer of two echoes.
fn nearer(one: Reading, other: Reading) -> Reading {
    match (one, other) {
        (Reading::Echo(a), Reading::Echo(b)) => Reading::Echo(a.min(b)),
        (Reading::Echo(_), _) => one,
        _ => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smart_car::{CELLS, POSE, SENSORS, SmartCarShape};
    use certainty_control::scan_of_map;
    use certainty_core::certainty::Certainty;
    use certainty_core::fusion::{BayesGrid, Measurement, Shape, Strength};
    use certainty_core::health::Confidence;
    use certainty_core::sensor::SensorId;
    use certainty_core::units::Point;

    const NOW: Ticks = Ticks::new(1000);

    fn eye(health: &Health) -> RangerInput<'_> {
        RangerInput {
            reading: Reading::NoObject,
            measured: Ticks::new(900),
            health,
        }
    }

    /// What fails with these heads silent, this confidence of all, and these rangers.
    fn failures(silent: [bool; 3], confidence: u16, rangers: [RangerInput<'_>; 2]) -> Failures {
        failures_at(POSE, silent, confidence, rangers)
    }

    /// The same where the car is at `pose`.
    fn failures_at(
        pose: Pose,
        silent: [bool; 3],
        confidence: u16,
        rangers: [RangerInput<'_>; 2],
    ) -> Failures {
        let grid = BayesGrid::try_new(SmartCarShape, Strength::UNLIMITED, [0; CELLS]).unwrap();
        let health = [Health::new(Confidence::from_bits(confidence)); SENSORS as usize];
        let seen = ControlInputs {
            now: NOW,
            pose,
            silent: &silent,
            rangers: &rangers,
        };
        seen.failures(&Environment::new(&grid, &health))
    }

    #[test]
    fn the_map_has_failed_as_far_as_its_heads_have_in_the_mean() {
        let health = Health::default();
        let sound = [eye(&health); 2];
        let scanner =
            |silent, confidence| failures(silent, confidence, sound).scanner.part().to_bits();
        assert_eq!(scanner([false; 3], u16::MAX), 0);
        assert_eq!(scanner([true, false, false], u16::MAX), 65_536 / 3);
        assert_eq!(scanner([true; 3], u16::MAX), 65_536);
        // No confidence is as good as silence.
        assert_eq!(scanner([false; 3], 0), 65_536);
    }

    #[test]
    fn outside_its_grid_the_map_has_failed_and_the_rangers_have_not() {
        let health = Health::default();
        let at = |x, y| {
            let pose = Pose::new(Point::from_mm(x, y), BinaryAngle::ZERO);
            failures_at(pose, [false; 3], u16::MAX, [eye(&health); 2])
        };
        // 17 by 11 cells of 100 mm: the first and the last place of each row and column are within.
        for (x, y) in [(0, 0), (-850, 0), (849, 0), (0, 1_099), (849, 1_099)] {
            assert_eq!(at(x, y).scanner, Failure::NONE, "{x} {y}");
        }
        for (x, y) in [(0, -1), (-851, 500), (850, 500), (0, 1_100), (0, -5_000)] {
            let told = at(x, y);
            assert_eq!(told.scanner, Failure::TOTAL, "{x} {y}");
            assert_eq!(told.rangefinders[1..5], [Failure::TOTAL; 4]);
            assert_eq!(
                [told.rangefinders[0], told.rangefinders[5]],
                [Failure::NONE; 2]
            );
        }
    }

    /// A cell anywhere: the even beams are those of the whole scan, the others are off by a beam at most.
    #[test]
    fn half_the_beams_see_every_cell_that_all_would() {
        let geometry = SmartCarShape.geometry();
        let sensor = SensorId::try_new(1).unwrap();
        for number in (0..CELLS).step_by(3) {
            let cell = geometry.iter().nth(number).unwrap();
            let mut grid =
                BayesGrid::try_new(SmartCarShape, Strength::UNLIMITED, [0; CELLS]).unwrap();
            let certainty = Certainty::OCCUPIED;
            grid.add(cell, Measurement { sensor, certainty }, &mut []);
            let map = Environment::new(&grid, &[]);
            let mut scan = [Reading::NoObject; BEAMS];
            look_ahead(&mut scan, &map, POSE);
            let whole: PerBeam<Reading> = scan_of_map(&map, POSE, SIGHT, OBSTACLE);
            for (index, (seen, exact)) in scan.into_iter().zip(whole).enumerate() {
                let neighbours = whole.iter().skip(index.saturating_sub(1)).take(3);
                let near = neighbours.copied().any(|reading| reading == seen);
                assert!(near, "{number} {index}");
                if index % 2 == 0 {
                    assert_eq!(seen, exact);
                }
            }
            // A cell that one beam alone grazes, at the end of its sight, may be missed.
            let met = |scan: &PerBeam<Reading>| {
                let echoes = scan.iter().filter(|&&reading| reading != Reading::NoObject);
                echoes.count()
            };
            assert!(met(&scan) > 0 || met(&whole) <= 1, "{number}");
        }
    }

    #[test]
    fn a_ranger_fails_on_its_side_and_what_the_map_stands_in_for_fails_with_the_map() {
        let (broken, sound) = (Health::new(Confidence::NONE), Health::default());
        let rangers = [eye(&broken), eye(&sound)];
        let told = failures([true, false, true], u16::MAX, rangers);
        assert_eq!(told.rangefinders[0], Failure::NONE, "the left ranger");
        assert_eq!(told.rangefinders[5], Failure::TOTAL, "the right one");
        assert_eq!(told.rangefinders[1..5], [told.scanner; 4]);
        assert_eq!(told.scanner.part().to_bits(), 65_536 * 2 / 3);
    }
}
