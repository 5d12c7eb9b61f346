//! The control level's inputs from the car's sensors, its rules and its goal (\[004\]).

use super::config::{CHASSIS, FARTHEST, HEADS, RANGERS};
use certainty_control::{
    BEAMS, Command, ControlConfig, ControlInput, ControlRules, Controller, Corner, CoverageConfig,
    Effort, Failure, FailureSharing, Failures, HistogramConfig, Limits, PerBeam, Ramp, Stamped,
    Weights, beam_bearing, beam_in_map,
};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::{CertaintyGrid, Environment};
use certainty_core::health::Health;
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose, Ticks};

/// The car's goal: 0.76 m from its start, ahead to the left, within its grid.
///
/// Open choice. In the built-in scene it lies behind the gap of 27 cm between the block in the middle and the
/// long box on the left, and the straight way there would touch the block's corner. A goal right behind the
/// block does not work with cells of 10 cm: the car would have to turn close to the corner, and in such runs
/// it touched the block half of the time.
pub const GOAL: Point = Point::from_mm(-300, 700);

/// A cell above this certainty stops a beam through the map: half way from *uncertain* to *occupied*.
const OBSTACLE: Certainty = Certainty::from_bits(192);

/// The range of beams through the map: that of the heads.
const SIGHT: Millimeters = FARTHEST;

/// The directions of rangefinders 2 and 3 of \[004\], in degrees to the left; 5 and 4 mirror them.
const SIDES_DEG: [i32; 2] = [60, 90];

/// The error of an obstacle's place in the map, in mm: half a cell.
const HALF_CELL_MM: u32 = 50;

/// The car's control rules: [`ControlConfig::DEFAULT`] for a car a quarter as large and a tenth as fast.
///
/// - Distances shrink with the radius. The safe region is the outline itself, because eq. 7 widens an obstacle
///   by more than the outline: at 200 mm by 110 mm. The speed is zero if an obstacle is within half a cell of
///   the outline.
/// - The car lacks four of the six rangefinders of \[004\]; they are computed from the map, at 60° and 90°, so
///   that the car does not turn into an obstacle beside it. They cover nothing beyond the map and fail with
///   it. Therefore [`FailureSharing::Own`]: no sensor's failure is attributed to another.
/// - The map covers four fifths of the view ahead and each ranger a tenth. At least three fifths must be
///   covered: one head or both rangers may fail, but not two heads of three, because the remaining one could
///   not be checked. So the car stands if the map's trust is below a half; below that the
///   [`Controller`](certainty_control::Controller) would not brake for obstacles in it.
/// - A wheel's acceleration is its full speed a second, or four fifths of it a round.
pub static CONTROL: ControlRules = {
    let default = ControlConfig::DEFAULT;
    let ahead = Effort::lit("0.1");
    let none = Effort::ZERO;
    let config = ControlConfig {
        braitenberg: default.braitenberg,
        rangefinder_default: Millimeters::new(300),
        histogram: HistogramConfig {
            default: Millimeters::new(600),
            safe: Millimeters::new(CHASSIS.radius_mm),
        },
        weights: Weights {
            braitenberg: ramp([(150, 16), (250, 12), (400, 6), (600, 0)]),
            histogram: ramp([(150, 16), (300, 20), (600, 16), (800, 8)]),
            azimuth: ramp([(150, 4), (250, 6), (400, 10), (600, 20)]),
            speed: ramp([
                (CHASSIS.radius_mm + HALF_CELL_MM, 0),
                (200, 6),
                (350, 12),
                (600, 16),
            ]),
        },
        sharing: FailureSharing::Own,
        coverage: CoverageConfig {
            rangefinders: [ahead, none, none, none, none, ahead],
            scanner: Effort::lit("0.8"),
            least: Effort::lit("0.601"),
        },
        limits: Limits {
            full_speed_mm_s: CHASSIS.full_speed_mm_s,
            faster_mm_s2: 100,
            slower_mm_s2: 1000,
        },
        goal_radius: Millimeters::new(100),
        stale_after: 400,
    };
    match ControlRules::try_new(config) {
        Ok(rules) => rules,
        Err(_) => panic!("no such rules"),
    }
};

/// Returns a ramp through corners (distance in mm, height in steps of 1/16).
#[expect(clippy::panic, reason = "a constant that panics does not build")]
const fn ramp(corners: [(u32, i32); 4]) -> Ramp {
    const fn corner((mm, height): (u32, i32)) -> Corner {
        Corner {
            at: Millimeters::new(mm),
            height: Effort::from_bits(height << (Effort::FRAC_NBITS - 4)),
        }
    }
    let [a, b, c, d] = corners;
    match Ramp::try_new([corner(a), corner(b), corner(c), corner(d)]) {
        Ok(ramp) => ramp,
        Err(_) => panic!("no such ramp"),
    }
}

/// A fixed ranger's latest reading and its health.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct RangerInput<'a> {
    pub(super) reading: Reading,
    /// The time of the measurement.
    pub(super) measured: Ticks,
    pub(super) health: &'a Health,
}

/// A round's inputs, besides the map.
pub(super) struct ControlInputs<'a> {
    pub(super) now: Ticks,
    /// The car's pose when the decision takes effect.
    pub(super) pose: Pose,
    /// Which heads had no reading in this round, the first on the right.
    pub(super) missing: &'a [bool; HEADS as usize],
    /// The fixed rangers, the first on the right.
    pub(super) rangers: &'a [RangerInput<'a>; RANGERS as usize],
}

impl ControlInputs<'_> {
    /// Runs one step of `controller`.
    ///
    /// Beams cast through the map replace the scanner of \[004\]. The rangers are its rangefinders 1, on the
    /// left, and 6; the other four are single beams cast through the map to the sides.
    pub(super) fn step<G: CertaintyGrid>(
        &self,
        controller: &mut Controller<&'static ControlRules>,
        map: &Environment<'_, G>,
    ) -> Command {
        let mut scan = [Reading::NoObject; BEAMS];
        cast_scan(&mut scan, map, self.pose);
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

    /// Returns the failure estimate of each input.
    ///
    /// The map's failure is the mean of its heads': each head sweeps the whole view ahead, so without one of
    /// three a third of the measurements is missing. A head without a reading counts as failed for this round,
    /// before its health changes. If the car is outside its grid, the map counts as failed, because it has no
    /// cells there and would show no obstacles.
    // Not inlined: its stack is free again before the controller runs.
    #[inline(never)]
    fn failures<G: CertaintyGrid>(&self, map: &Environment<'_, G>) -> Failures {
        let heads = map.sensors().zip(self.missing);
        let sum = heads.fold(Effort::ZERO, |sum, ((_, health), &missing)| {
            let failure = if missing {
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

/// Writes into `scan` what a scanner at `pose` would measure in the map.
///
/// Only every second beam is cast; each beam between takes the nearer of its neighbours. At the car's range 2°
/// are less than a third of a cell, and casting all beams would take longer than the slot.
// Not inlined: its stack is free again before the controller runs.
#[inline(never)]
fn cast_scan<G: CertaintyGrid>(scan: &mut PerBeam<Reading>, map: &Environment<'_, G>, pose: Pose) {
    for (reading, index) in scan.iter_mut().zip(0..=u8::MAX).step_by(2) {
        let heading = pose.heading.wrapping_add(beam_bearing(index));
        *reading = beam_in_map(map, Pose::new(pose.at, heading), SIGHT, OBSTACLE);
    }
    let [pairs @ .., last] = scan;
    let mut next = *last;
    for pair in pairs.chunks_exact_mut(2).rev() {
        if let [cast, between] = pair {
            *between = nearer(*cast, next);
            next = *cast;
        }
    }
}

/// Returns the nearer of two echoes.
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
    use crate::smart_car::config::{CELLS, POSE, SENSORS, SmartCarShape};
    use certainty_control::scan_of_map;
    use certainty_core::certainty::Certainty;
    use certainty_core::fusion::{BayesGrid, Measurement, Shape, Strength};
    use certainty_core::health::Confidence;
    use certainty_core::sensor::SensorId;
    use certainty_core::units::Point;

    const NOW: Ticks = Ticks::new(1000);

    fn ranger(health: &Health) -> RangerInput<'_> {
        RangerInput {
            reading: Reading::NoObject,
            measured: Ticks::new(900),
            health,
        }
    }

    /// Returns the failures with these heads missing, this confidence of all, and these rangers.
    fn failures(missing: [bool; 3], confidence: u16, rangers: [RangerInput<'_>; 2]) -> Failures {
        failures_at(POSE, missing, confidence, rangers)
    }

    /// Returns the same for a car at `pose`.
    fn failures_at(
        pose: Pose,
        missing: [bool; 3],
        confidence: u16,
        rangers: [RangerInput<'_>; 2],
    ) -> Failures {
        let grid = BayesGrid::try_new(SmartCarShape, Strength::UNLIMITED, [0; CELLS]).unwrap();
        let health = [Health::new(Confidence::from_bits(confidence)); SENSORS as usize];
        let inputs = ControlInputs {
            now: NOW,
            pose,
            missing: &missing,
            rangers: &rangers,
        };
        inputs.failures(&Environment::new(&grid, &health))
    }

    #[test]
    fn the_maps_failure_is_the_mean_of_its_heads() {
        let health = Health::default();
        let sound = [ranger(&health); 2];
        let scanner = |missing, confidence| {
            failures(missing, confidence, sound)
                .scanner
                .part()
                .to_bits()
        };
        assert_eq!(scanner([false; 3], u16::MAX), 0);
        assert_eq!(scanner([true, false, false], u16::MAX), 65_536 / 3);
        assert_eq!(scanner([true; 3], u16::MAX), 65_536);
        // No confidence counts like no reading.
        assert_eq!(scanner([false; 3], 0), 65_536);
    }

    #[test]
    fn outside_the_grid_only_the_map_has_failed() {
        let health = Health::default();
        let at = |x, y| {
            let pose = Pose::new(Point::from_mm(x, y), BinaryAngle::ZERO);
            failures_at(pose, [false; 3], u16::MAX, [ranger(&health); 2])
        };
        // 17 by 11 cells of 100 mm: the first and the last place of each row and column are within.
        for (x, y) in [(0, 0), (-850, 0), (849, 0), (0, 1_099), (849, 1_099)] {
            assert_eq!(at(x, y).scanner, Failure::NONE, "{x} {y}");
        }
        for (x, y) in [(0, -1), (-851, 500), (850, 500), (0, 1_100), (0, -5_000)] {
            let result = at(x, y);
            assert_eq!(result.scanner, Failure::TOTAL, "{x} {y}");
            assert_eq!(result.rangefinders[1..5], [Failure::TOTAL; 4]);
            assert_eq!(
                [result.rangefinders[0], result.rangefinders[5]],
                [Failure::NONE; 2]
            );
        }
    }

    /// For any occupied cell the even beams equal those of the whole scan; the others are off by one beam at
    /// most.
    #[test]
    fn half_the_beams_find_every_cell_that_all_find() {
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
            cast_scan(&mut scan, &map, POSE);
            let whole = scan_of_map(&map, POSE, SIGHT, OBSTACLE);
            for (index, (cast, exact)) in scan.into_iter().zip(whole).enumerate() {
                let neighbours = whole.iter().skip(index.saturating_sub(1)).take(3);
                let near = neighbours.copied().any(|reading| reading == cast);
                assert!(near, "{number} {index}");
                if index % 2 == 0 {
                    assert_eq!(cast, exact);
                }
            }
            // A cell that only one beam touches, at the end of its range, may be missed.
            let met = |scan: &PerBeam<Reading>| {
                let echoes = scan.iter().filter(|&&reading| reading != Reading::NoObject);
                echoes.count()
            };
            assert!(met(&scan) > 0 || met(&whole) <= 1, "{number}");
        }
    }

    #[test]
    fn each_rangefinder_fails_with_its_source() {
        let (failed, sound) = (Health::new(Confidence::NONE), Health::default());
        let rangers = [ranger(&failed), ranger(&sound)];
        let result = failures([true, false, true], u16::MAX, rangers);
        assert_eq!(result.rangefinders[0], Failure::NONE, "the left ranger");
        assert_eq!(result.rangefinders[5], Failure::TOTAL, "the right one");
        assert_eq!(result.rangefinders[1..5], [result.scanner; 4]);
        assert_eq!(result.scanner.part().to_bits(), 65_536 * 2 / 3);
    }
}
