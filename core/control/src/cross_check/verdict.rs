//! Whether two that look at the same place agree.

use super::super::histogram::{BEAMS, PerBeam, beam_bearing};
use super::super::valley::beam_towards;
use super::super::{ExpectedScan, PerRangefinder, RANGEFINDERS};
use super::CrossCheckConfig;
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Direction, Millimeters, Point, Pose};

/// Where the beams go, computed once.
const BEAM_DIRECTIONS: PerBeam<Direction> = {
    let mut directions = [BinaryAngle::ZERO.direction(); BEAMS];
    let mut rest: &mut [Direction] = &mut directions;
    let mut index = 0_u8;
    while let [direction, others @ ..] = rest {
        *direction = beam_bearing(index).direction();
        rest = others;
        index = index.wrapping_add(1);
    }
    directions
};

/// What two said about the same place: a rangefinder and the scanner, or one of them and the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Verdict {
    /// Both see an object there.
    Agreement,
    /// One sees an object where the other sees through, or past it.
    Contradiction,
    /// A sensor sees an object where the map is surely free.
    Phantom,
    /// A sensor sees past an object that the map shows beside its beam: it may, or may be blind to it.
    Past,
    /// They do not look at the same place, or one says nothing.
    Silence,
}

/// What the sensors say of each other, and the map of every one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Verdicts {
    /// Of each rangefinder and the scanner.
    pub pairs: PerRangefinder<Verdict>,
    /// Of each rangefinder and the map.
    pub rangefinders: PerRangefinder<Verdict>,
    /// Of the scanner and the map, by most of its beams.
    pub scanner: Verdict,
}

/// Beams that must see something the map remembers before the scanner is judged.
const FEWEST_BEAMS: u8 = 5;

/// Where each beam's echo is, in the robot's frame.
fn points(scan: &PerBeam<Reading>, scanner: Pose) -> PerBeam<Option<Point>> {
    let mut points = [None; BEAMS];
    let beams = scan.iter().zip(&BEAM_DIRECTIONS);
    for (point, (reading, &direction)) in points.iter_mut().zip(beams) {
        if let Reading::Echo(distance) = reading {
            let there = Point::ORIGIN.ahead(direction, *distance);
            *point = Some(scanner.compose(Pose::new(there, BinaryAngle::ZERO)).at);
        }
    }
    points
}

impl CrossCheckConfig {
    /// Compares every rangefinder with the scanner.
    pub(super) fn between(
        &self,
        rangefinders: &PerRangefinder<Reading>,
        scan: &PerBeam<Reading>,
    ) -> PerRangefinder<Verdict> {
        let points = points(scan, self.views.scanner);
        let mut verdicts = [Verdict::Silence; RANGEFINDERS];
        let all = self.views.rangefinders.iter().zip(rangefinders);
        for (verdict, (&mounting, &reading)) in verdicts.iter_mut().zip(all) {
            *verdict = self.verdict(mounting, reading, scan, &points);
        }
        verdicts
    }

    /// Compares every sensor with the map, after the `pairs` with each other: what two sensors see is no
    /// phantom of either.
    pub(super) fn against(
        &self,
        rangefinders: &PerRangefinder<Reading>,
        scan: &PerBeam<Reading>,
        pairs: PerRangefinder<Verdict>,
        memory: &ExpectedScan,
    ) -> Verdicts {
        let mut verdicts = [Verdict::Silence; RANGEFINDERS];
        let all = rangefinders.iter().zip(&memory.sectors).zip(&pairs);
        for (verdict, ((&reading, sector), &pair)) in verdicts.iter_mut().zip(all) {
            // Rays that meet two objects do not say which of them the beam meets.
            let one = |&(near, far): &(Millimeters, Millimeters)| {
                far.saturating_sub(near).get() <= 2 * GAP_MM
            };
            *verdict = match sector.ahead().filter(one) {
                Some((near, far)) => {
                    self.remembered(reading, near, far, self.views.rangefinders_see)
                }
                None => Verdict::Silence,
            };
            if *verdict == Verdict::Silence && pair != Verdict::Agreement {
                if self.is_phantom(reading, sector.clear()) {
                    *verdict = Verdict::Phantom;
                } else if sector
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
            scanner: self.of_scan(scan, pairs.contains(&Verdict::Agreement), memory),
        }
    }

    /// Compares the scan with the map; where it is `confirmed` by a rangefinder, new things are no phantoms.
    fn of_scan(&self, scan: &PerBeam<Reading>, confirmed: bool, memory: &ExpectedScan) -> Verdict {
        let (mut alike, mut unlike) = (0_u8, 0_u8);
        let all = scan.iter().zip(&memory.scan).zip(&memory.clear);
        for ((&reading, &shown), &clear) in all {
            let verdict = match shown {
                Reading::Echo(distance) => {
                    self.remembered(reading, distance, distance, self.views.scanner_sees)
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

    /// Whether a sensor sees past what is `near`.
    fn is_past(&self, reading: Reading, near: Millimeters) -> bool {
        let beyond = near.saturating_add(self.slack(near));
        match reading {
            Reading::Echo(told) => told > beyond,
            Reading::NoObject => beyond < self.views.rangefinders_see,
            Reading::TooNear | Reading::Missing(_) => false,
        }
    }

    /// Whether a sensor sees something well before where the map stops being surely free.
    fn is_phantom(&self, reading: Reading, clear: Millimeters) -> bool {
        match reading {
            Reading::Echo(told) => told.saturating_add(self.slack(told)) < clear,
            Reading::TooNear => self.slack(Millimeters::ZERO) < clear,
            Reading::NoObject | Reading::Missing(_) => false,
        }
    }

    /// Compares a reading with what the map shows from `near` to `far`, within what the sensor sees.
    fn remembered(
        &self,
        reading: Reading,
        near: Millimeters,
        far: Millimeters,
        sees: Millimeters,
    ) -> Verdict {
        let slack = self.slack(far);
        let (least, most) = (near.saturating_sub(slack), far.saturating_add(slack));
        match reading {
            _ if most >= sees => Verdict::Silence,
            Reading::Missing(_) => Verdict::Silence,
            Reading::Echo(told) if least <= told && told <= most => Verdict::Agreement,
            Reading::TooNear if least == Millimeters::ZERO => Verdict::Agreement,
            Reading::Echo(_) | Reading::NoObject | Reading::TooNear => Verdict::Contradiction,
        }
    }

    /// Compares one rangefinder with the scanner.
    fn verdict(
        &self,
        mounting: Pose,
        reading: Reading,
        scan: &PerBeam<Reading>,
        points: &PerBeam<Option<Point>>,
    ) -> Verdict {
        let told = match reading {
            Reading::Echo(distance) => distance,
            Reading::NoObject => Millimeters::new(u32::MAX),
            Reading::TooNear => Millimeters::ZERO,
            Reading::Missing(_) => return Verdict::Silence,
        };
        // What the scanner's surfaces would give the rangefinder.
        if let Some((near, far)) = points_ahead(mounting, points) {
            let slack = self.slack(far);
            let beyond = far.saturating_add(slack);
            if beyond < told && beyond < self.views.rangefinders_see {
                return Verdict::Contradiction;
            }
            let one_surface = far.saturating_sub(near).get() <= GAP_MM;
            if one_surface && near.saturating_sub(slack) <= told && told <= beyond {
                return Verdict::Agreement;
            }
        }
        match reading {
            Reading::Echo(distance) => self.seen_through(mounting, distance, scan),
            _ => Verdict::Silence,
        }
    }

    /// Whether the scanner sees the rangefinder's echo, or past it.
    fn seen_through(&self, mounting: Pose, echo: Millimeters, scan: &PerBeam<Reading>) -> Verdict {
        let there = mounting.at.ahead(mounting.heading.direction(), echo);
        let away = self.views.scanner.at.distance(there);
        let Some(bearing) = self.views.scanner.at.bearing(there) else {
            return Verdict::Silence;
        };
        let from_ahead = bearing.wrapping_sub(self.views.scanner.heading);
        let slack = self.slack(away);
        let (Some(beam), true) = (
            beam_towards(from_ahead),
            away.saturating_add(slack) < self.views.scanner_sees,
        ) else {
            return Verdict::Silence;
        };
        let beyond = away.saturating_add(slack);
        let first = usize::from(beam).saturating_sub(2);
        let (mut alike, mut past) = (0_u8, 0_u8);
        let taken = usize::from(beam).saturating_add(3).saturating_sub(first);
        for reading in scan.iter().skip(first).take(taken) {
            match reading {
                Reading::Echo(distance) if distance.get().abs_diff(away.get()) <= slack.get() => {
                    alike = alike.saturating_add(1);
                }
                Reading::Echo(distance) if *distance > beyond => past = past.saturating_add(1),
                Reading::NoObject => past = past.saturating_add(1),
                Reading::Echo(_) | Reading::TooNear | Reading::Missing(_) => {}
            }
        }
        // At an edge some beams pass; a scanner that guesses hits now and then.
        match (alike, past) {
            (2.., _) => Verdict::Agreement,
            (0, 5..) | (1, 3..) => Verdict::Contradiction,
            _ => Verdict::Silence,
        }
    }

    /// How far two distances may differ.
    const fn slack(&self, distance: Millimeters) -> Millimeters {
        (self.tolerance).saturating_add(Millimeters::new(distance.get() >> 4))
    }
}

/// Neighbouring points farther apart are of two objects.
const GAP_MM: u32 = 250;

/// How far ahead of a rangefinder two points are, the nearer and the farther, that neighbouring beams of
/// the scanner see on either side of the rangefinder's beam.
///
/// One point near the beam may be a corner that it passes; between two there is little room to pass.
fn points_ahead(
    mounting: Pose,
    points: &PerBeam<Option<Point>>,
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
            let close = left.abs_diff(right) <= u64::from(GAP_MM) << Direction::FRACTION_BITS;
            let ends = (u32::try_from(one.min(other)), u32::try_from(one.max(other)));
            if let (true, true, (Ok(near), Ok(far))) = (crosses, close, ends)
                && nearest.is_none_or(|(known_near, known)| (far, near) < (known, known_near))
            {
                nearest = Some((near, far));
            }
        }
        before = here;
    }
    nearest.map(|(near, far)| (Millimeters::new(near), Millimeters::new(far)))
}
