//! Compares readings of the same place: a rangefinder and the scanner, or one of them and the map.

use crate::expected_scan::ExpectedScan;
use crate::sensors::{Mountings, RANGEFINDERS, ScanGeometry};
use certainty_core::transducer::Reading;
use certainty_core::units::{Direction, Millimeters, Point, Pose};

/// The parameters of a [`CrossCheck`](super::CrossCheck), before they are checked.
///
/// The weights are steps of a logarithm of odds: a sound pair contradicts itself at edges, about once in
/// twenty readings; a pair with a failed sensor contradicts itself nearly always, and agrees by chance only.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CrossCheckConfig<const R: usize = RANGEFINDERS> {
    /// Where the sensors look.
    pub mountings: Mountings<R>,
    /// How far two readings of the same object may differ, besides a sixteenth of the distance.
    pub tolerance: Millimeters,
    /// What a contradiction adds to the suspicion of a pair; above zero.
    pub contradiction: u8,
    /// What an agreement subtracts; above zero.
    pub agreement: u8,
    /// The highest suspicion; at least twice [`Self::failure_cost`].
    pub max_suspicion: u8,
    /// The lowest suspicion, negated: the most that agreements add up to. It decays while the pair sees no
    /// common object, so that only recent agreements count against contradictions.
    pub max_credit: u8,
    /// How much suspicion a failure must explain to be likelier than chance; above zero.
    pub failure_cost: u8,
}

impl<const R: usize> CrossCheckConfig<R> {
    /// Returns a configuration with a tolerance of 150 mm, ten standard deviations of a laser with 15 mm, and
    /// weights with which a failure is found for certain after six contradictions in a row.
    #[must_use]
    pub const fn new(mountings: Mountings<R>) -> Self {
        Self {
            mountings,
            tolerance: Millimeters::new(150),
            contradiction: 4,
            agreement: 2,
            max_suspicion: 48,
            max_credit: 16,
            failure_cost: 12,
        }
    }
}

/// The result of comparing two readings of the same place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Verdict {
    /// Both report the same object.
    Agreement,
    /// One reports an object where the other reports none, or a farther one.
    Contradiction,
    /// A sensor reports an object where the map is surely free.
    Phantom,
    /// A sensor reports no object, or a farther one, where the map shows one beside its beam: the beam may
    /// pass it, or the sensor may have failed.
    Past,
    /// Nothing to compare: they do not look at the same place, or a reading is missing.
    Silence,
}

/// The results of all comparisons at one step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Verdicts<const R: usize = RANGEFINDERS> {
    /// Each rangefinder and the scanner.
    pub pairs: [Verdict; R],
    /// Each rangefinder and the map.
    pub rangefinders: [Verdict; R],
    /// The scanner and the map, by most of its beams.
    pub scanner: Verdict,
}

/// Beams with a result (alike or not) that a comparison of the whole scan needs.
const FEWEST_BEAMS: u8 = 5;

/// Neighbouring points farther apart than this belong to two objects.
const GAP_MM: u32 = 250;

/// Where each beam's echo is, in the robot's frame.
fn points<const B: usize>(scan: &[Reading; B], scanner: Pose) -> [Option<Point>; B] {
    let mut points = [None; B];
    // A constant's place in memory, not a copy on the stack.
    let directions: &[Direction; B] = const { &ScanGeometry::<B>::DIRECTIONS };
    let beams = scan.iter().zip(directions);
    for (point, (reading, &direction)) in points.iter_mut().zip(beams) {
        if let Reading::Echo(distance) = reading {
            let there = Point::ORIGIN.ahead(direction, *distance);
            *point = Some(scanner.to_outer(there));
        }
    }
    points
}

impl<const R: usize> CrossCheckConfig<R> {
    /// Compares every rangefinder with the scanner.
    pub(super) fn compare_pairs<const B: usize>(
        &self,
        rangefinders: &[Reading; R],
        scan: &[Reading; B],
    ) -> [Verdict; R] {
        let points = points(scan, self.mountings.scanner);
        let mut verdicts = [Verdict::Silence; R];
        let all = self.mountings.rangefinders.iter().zip(rangefinders);
        for (verdict, (&mounting, &reading)) in verdicts.iter_mut().zip(all) {
            *verdict = self.compare_pair(mounting, reading, scan, &points);
        }
        verdicts
    }

    /// Compares every sensor with the map, given the verdicts of the `pairs`: an object that two sensors report
    /// is no phantom of either.
    pub(super) fn compare_with_map<const B: usize>(
        &self,
        rangefinders: &[Reading; R],
        scan: &[Reading; B],
        pairs: [Verdict; R],
        expected: &ExpectedScan<R, B>,
    ) -> Verdicts<R> {
        let range = self.mountings.rangefinder_range;
        let mut verdicts = [Verdict::Silence; R];
        let all = rangefinders.iter().zip(&expected.fans).zip(&pairs);
        for (verdict, ((&reading, fan), &pair)) in verdicts.iter_mut().zip(all) {
            // If the rays hit two objects it is open which of them the beam hits.
            let is_one_object =
                |&(near, far): &(Millimeters, Millimeters)| (far - near).get() <= 2 * GAP_MM;
            if let Some((near, far)) = fan.ahead().filter(is_one_object) {
                *verdict = self.compare_with_hit(reading, near, far, range);
            }
            if *verdict == Verdict::Silence && pair != Verdict::Agreement {
                if self.is_phantom(reading, fan.clear()) {
                    *verdict = Verdict::Phantom;
                } else if fan
                    .nearest_ahead()
                    .is_some_and(|near| self.is_past(reading, near))
                {
                    *verdict = Verdict::Past;
                }
            }
        }
        Verdicts {
            pairs,
            rangefinders: verdicts,
            scanner: self.compare_scan(scan, pairs.contains(&Verdict::Agreement), expected),
        }
    }

    /// Compares the scan with the map. Objects that are new to the map are no phantoms if a rangefinder has
    /// `confirmed` the scan.
    fn compare_scan<const B: usize>(
        &self,
        scan: &[Reading; B],
        confirmed: bool,
        expected: &ExpectedScan<R, B>,
    ) -> Verdict {
        let range = self.mountings.scanner_range;
        let (mut alike, mut unlike) = (0_u8, 0_u8);
        let all = scan.iter().zip(&expected.scan).zip(&expected.clear);
        for ((&reading, &shown), &clear) in all {
            let verdict = match shown {
                Reading::Echo(distance) => {
                    self.compare_with_hit(reading, distance, distance, range)
                }
                _ => Verdict::Silence,
            };
            match verdict {
                Verdict::Agreement => alike = alike.saturating_add(1),
                Verdict::Silence if confirmed || !self.is_phantom(reading, clear) => {}
                _ => unlike = unlike.saturating_add(1),
            }
        }
        if alike.saturating_add(unlike) < FEWEST_BEAMS {
            Verdict::Silence
        } else if unlike > alike {
            Verdict::Contradiction
        } else if unlike <= alike >> 1 {
            Verdict::Agreement
        } else {
            Verdict::Silence
        }
    }

    /// Whether a rangefinder reports no object at the distance `near`, but beyond it or none.
    fn is_past(&self, reading: Reading, near: Millimeters) -> bool {
        let beyond = near + self.slack(near);
        match reading {
            Reading::Echo(distance) => distance > beyond,
            Reading::NoObject => beyond < self.mountings.rangefinder_range,
            Reading::TooNear | Reading::Missing(_) => false,
        }
    }

    /// Whether a reading reports an object well within the distance `clear` that is surely free.
    fn is_phantom(&self, reading: Reading, clear: Millimeters) -> bool {
        match reading {
            Reading::Echo(distance) => distance + self.slack(distance) < clear,
            Reading::TooNear => self.slack(Millimeters::ZERO) < clear,
            Reading::NoObject | Reading::Missing(_) => false,
        }
    }

    /// Compares a reading with the map's hits from `near` to `far`, within the sensor's `range`.
    fn compare_with_hit(
        &self,
        reading: Reading,
        near: Millimeters,
        far: Millimeters,
        range: Millimeters,
    ) -> Verdict {
        let slack = self.slack(far);
        let (least, most) = (near - slack, far + slack);
        match reading {
            _ if most >= range => Verdict::Silence,
            Reading::Missing(_) => Verdict::Silence,
            Reading::Echo(read) if least <= read && read <= most => Verdict::Agreement,
            Reading::TooNear if least == Millimeters::ZERO => Verdict::Agreement,
            Reading::Echo(_) | Reading::NoObject | Reading::TooNear => Verdict::Contradiction,
        }
    }

    /// Compares one rangefinder with the scanner.
    fn compare_pair<const B: usize>(
        &self,
        mounting: Pose,
        reading: Reading,
        scan: &[Reading; B],
        points: &[Option<Point>; B],
    ) -> Verdict {
        let read = match reading {
            Reading::Echo(distance) => distance,
            Reading::NoObject => Millimeters::MAX,
            Reading::TooNear => Millimeters::ZERO,
            Reading::Missing(_) => return Verdict::Silence,
        };
        // The distances at which the rangefinder's beam crosses a surface that the scanner sees.
        if let Some((near, far)) = crossing(mounting, points) {
            let slack = self.slack(far);
            let beyond = far + slack;
            if beyond < read && beyond < self.mountings.rangefinder_range {
                return Verdict::Contradiction;
            }
            let is_one_surface = (far - near).get() <= GAP_MM;
            if is_one_surface && near - slack <= read && read <= beyond {
                return Verdict::Agreement;
            }
        }
        match reading {
            Reading::Echo(distance) => self.compare_echo(mounting, distance, scan),
            _ => Verdict::Silence,
        }
    }

    /// Compares a rangefinder's echo with the five beams of the scanner around its place.
    fn compare_echo<const B: usize>(
        &self,
        mounting: Pose,
        echo: Millimeters,
        scan: &[Reading; B],
    ) -> Verdict {
        let Mountings {
            scanner,
            scanner_range,
            ..
        } = self.mountings;
        let there = mounting.at.ahead(mounting.heading.direction(), echo);
        let away = scanner.at.distance(there);
        let Some(bearing) = scanner.at.bearing(there) else {
            return Verdict::Silence;
        };
        let from_ahead = bearing - scanner.heading;
        let slack = self.slack(away);
        let beyond = away + slack;
        let (Some(beam), true) = (
            ScanGeometry::<B>::beam_towards(from_ahead),
            beyond < scanner_range,
        ) else {
            return Verdict::Silence;
        };
        let first = usize::from(beam).saturating_sub(2);
        let count = usize::from(beam).saturating_add(3).saturating_sub(first);
        let (mut alike, mut past) = (0_u8, 0_u8);
        for reading in scan.iter().skip(first).take(count) {
            match reading {
                Reading::Echo(distance) if distance.get().abs_diff(away.get()) <= slack.get() => {
                    alike = alike.saturating_add(1);
                }
                Reading::Echo(distance) if *distance > beyond => past = past.saturating_add(1),
                Reading::NoObject => past = past.saturating_add(1),
                Reading::Echo(_) | Reading::TooNear | Reading::Missing(_) => {}
            }
        }
        // At an edge some beams pass; a scanner with random readings agrees now and then.
        match (alike, past) {
            (2.., _) => Verdict::Agreement,
            (0, 5..) | (1, 3..) => Verdict::Contradiction,
            _ => Verdict::Silence,
        }
    }

    /// How far two distances may differ.
    fn slack(&self, distance: Millimeters) -> Millimeters {
        self.tolerance + Millimeters::new(distance.get() >> 4)
    }
}

/// How far ahead of a rangefinder two points are, the nearer and the farther, that neighbouring beams of
/// the scanner see on either side of the rangefinder's beam; of several pairs the nearest.
///
/// One point near the beam may be a corner that the beam passes; between two there is little room to pass.
fn crossing<const B: usize>(
    mounting: Pose,
    points: &[Option<Point>; B],
) -> Option<(Millimeters, Millimeters)> {
    let direction = mounting.heading.direction();
    let (cos, sin) = (i64::from(direction.cos()), i64::from(direction.sin()));
    // In the rangefinder's frame, in millimetres: 29 bits times 30.
    let place = |point: Point| {
        let x = i64::from(point.x_mm()).saturating_sub(mounting.at.x_mm().into());
        let y = i64::from(point.y_mm()).saturating_sub(mounting.at.y_mm().into());
        let along = x.wrapping_mul(cos).wrapping_add(y.wrapping_mul(sin));
        let across = y.wrapping_mul(cos).wrapping_sub(x.wrapping_mul(sin));
        (along >> Direction::FRACTION_BITS, across)
    };
    let mut nearest: Option<(u32, u32)> = None;
    let mut before: Option<(i64, i64)> = None;
    for point in points {
        let here = point.map(place);
        if let (Some((one, left)), Some((other, right))) = (before, here) {
            let crosses = left.min(right) <= 0 && 0 <= left.max(right);
            let is_close = left.abs_diff(right) <= u64::from(GAP_MM) << Direction::FRACTION_BITS;
            let ends = (u32::try_from(one.min(other)), u32::try_from(one.max(other)));
            if let (true, true, (Ok(near), Ok(far))) = (crosses, is_close, ends)
                && nearest.is_none_or(|(best_near, best_far)| (far, near) < (best_far, best_near))
            {
                nearest = Some((near, far));
            }
        }
        before = here;
    }
    nearest.map(|(near, far)| (Millimeters::new(near), Millimeters::new(far)))
}
