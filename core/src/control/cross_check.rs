//! Who lies, told by rangefinders and a scanner that look at the same places.

use super::failures::Failure;
use super::histogram::{BEAMS, PerBeam, beam_bearing};
use super::valley::beam_towards;
use super::{Failures, PerRangefinder, Signal};
use crate::narrow::low_u32;
use crate::transducer::Reading;
use crate::units::{BinaryAngle, Direction, Millimeters, Point, Pose};

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

/// What a cross-check leaves open.
///
/// The weights are steps of a logarithm of odds: a sound pair contradicts itself at edges, about once in
/// twenty readings, a broken one nearly always, and agrees by chance alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CrossCheckConfig {
    /// Where the rangefinders sit and look, in the robot's frame.
    pub rangefinders: PerRangefinder<Pose>,
    /// Where the scanner does.
    pub scanner: Pose,
    /// How far two sensors that see the same may differ, besides a sixteenth of the distance.
    pub tolerance: Millimeters,
    /// How far the rangefinders see.
    pub rangefinders_see: Millimeters,
    /// How far the scanner sees.
    pub scanner_sees: Millimeters,
    /// What a contradiction adds to the suspicion of a pair.
    pub contradiction: u8,
    /// What an agreement takes.
    pub agreement: u8,
    /// The most that contradictions add up to.
    pub most: u8,
    /// The most that agreements add up to. It is forgotten step by step while they see nothing alike, so
    /// that only those who agree now speak against those who contradict.
    pub credit: u8,
    /// How much suspicion makes a failure likelier than chance: what a failure costs.
    pub unlikely: u8,
}

/// What a rangefinder and the scanner said about the same place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Verdict {
    /// Both see an object there.
    Agreement,
    /// One sees an object where the other sees through, or past it.
    Contradiction,
    /// They do not look at the same place, or one says nothing.
    Silence,
}

/// Suspicion of each pair of a rangefinder and the scanner, and who of the two it falls on.
///
/// A pair that contradicts itself has a broken member, and does not say which. Who it is the other pairs
/// say: a broken rangefinder contradicts the scanner alone, a broken scanner every rangefinder that sees
/// something. So the one failure that explains most is preferred to several (consistency-based
/// diagnosis); one pair alone leaves both in doubt by half. An explanation that stands already is
/// cheaper than a new one: a sensor that was found broken stays what is wrong while the others see
/// nothing that could speak for the scanner.
///
/// Unlike a grid's comparison of cells this takes whole readings: it does not drown in the free cells
/// that even a blind sensor agrees on. Prefer the grid's [`Health`](crate::health::Health) for sensors
/// that look where others have been.
///
/// Cost: 101 products of vectors a rangefinder. Memory: 20 bytes and the
/// configuration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CrossCheck {
    config: CrossCheckConfig,
    suspicion: PerRangefinder<i16>,
    /// Who is found broken, and stands for it.
    standing: Standing,
}

/// Which failures explain what was observed so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Standing {
    rangefinders: PerRangefinder<bool>,
    scanner: bool,
}

impl Standing {
    const NOBODY: Self = Self {
        rangefinders: [false; super::RANGEFINDERS],
        scanner: false,
    };

    /// Takes in who has failed by three quarters, and lets go of who has by less than a quarter.
    fn settle(&mut self, failures: &Failures) {
        const QUARTER: Signal = Signal::lit("0.25");
        let own = self.rangefinders.iter_mut().chain([&mut self.scanner]);
        let all = failures.rangefinders.iter().chain([&failures.scanner]);
        for (stands, failure) in own.zip(all) {
            *stands = if *stands {
                failure.part() >= QUARTER
            } else {
                failure.left() <= QUARTER
            };
        }
    }
}

impl CrossCheck {
    /// Creates a check that suspects nobody.
    #[must_use]
    pub const fn new(config: CrossCheckConfig) -> Self {
        Self {
            config,
            suspicion: [0; super::RANGEFINDERS],
            standing: Standing::NOBODY,
        }
    }

    /// Takes in what all sensors say at the same time.
    pub fn observe(&mut self, rangefinders: &PerRangefinder<Reading>, scan: &PerBeam<Reading>) {
        let Self {
            config, suspicion, ..
        } = self;
        let points = points(scan, config.scanner);
        let all = config.rangefinders.iter().zip(rangefinders);
        for (suspicion, (&mounting, &reading)) in suspicion.iter_mut().zip(all) {
            let heard = !matches!(reading, Reading::Missing(_));
            let step = match config.verdict(mounting, reading, scan, &points) {
                Verdict::Agreement => i16::from(config.agreement).saturating_neg(),
                Verdict::Contradiction => config.contradiction.into(),
                // Who is not heard accuses nobody: a robot that stands, blinded by what a sensor said
                // before it was taken out, would stand for ever.
                Verdict::Silence if !heard => suspicion.signum().saturating_neg(),
                // What they agreed on before does not speak for them for ever.
                Verdict::Silence => i16::from(*suspicion < 0),
            };
            let (least, most) = (i16::from(config.credit), i16::from(config.most));
            let sum = suspicion.saturating_add(step);
            // Not `clamp`, which has a panic for bounds the wrong way round.
            *suspicion = if sum > most {
                most
            } else {
                sum.max(least.saturating_neg())
            };
        }
        let failures = self.failures();
        self.standing.settle(&failures);
    }

    /// Returns the failures that explain what was observed.
    ///
    /// Formula: with `x_i` the suspicion of pair i and λ what a failure costs, half of that where it
    /// stands already, a broken scanner explains `S = Σ x_i − λ_s`, broken rangefinders explain
    /// `R = Σ max(0, x_i − λ_i)`. The scanner's share of the blame is ½ + (S − R) / 2λ within 0..=1; its
    /// failure is that share of S / λ, rangefinder i's the rest's of `(x_i − λ_i) / λ`, each within
    /// 0..=1.
    #[must_use]
    pub fn failures(&self) -> Failures {
        let cost = i32::from(self.config.unlikely).max(1);
        let of_new_or_old = |stands: bool| if stands { cost >> 1 } else { cost };
        let mut over = [0_i32; super::RANGEFINDERS];
        let (mut sum, mut broken) = (0_i32, 0_i32);
        let each = self.suspicion.iter().zip(self.standing.rangefinders);
        for (over, (&x, stands)) in over.iter_mut().zip(each) {
            let own = of_new_or_old(stands);
            *over = i32::from(x).saturating_sub(own).max(0);
            sum = sum.saturating_add(x.into());
            broken = broken.saturating_add(*over);
        }
        let scanner = sum.saturating_sub(of_new_or_old(self.standing.scanner));
        let part = |value: i32, of: i32| {
            let wide = i64::from(value).saturating_mul(1 << Signal::FRAC_NBITS);
            let part = wide.checked_div(of.into()).unwrap_or(0);
            let bounded = part.clamp(0, 1 << Signal::FRAC_NBITS);
            Signal::from_bits(low_u32(bounded.cast_unsigned()).cast_signed())
        };
        let lead = scanner.saturating_sub(broken).saturating_add(cost);
        let blame = part(lead, cost.saturating_mul(2));
        let rest = Signal::ONE.saturating_sub(blame);
        let of = |share: Signal, strength: Signal| {
            Failure::new_saturating(super::motion::scaled(share, strength))
        };
        Failures {
            rangefinders: over.map(|over| of(rest, part(over, cost))),
            scanner: of(blame, part(scanner, cost)),
        }
    }
}

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
            if beyond < told && beyond < self.rangefinders_see {
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
        let away = self.scanner.at.distance(there);
        let Some(bearing) = self.scanner.at.bearing(there) else {
            return Verdict::Silence;
        };
        let from_ahead = bearing.wrapping_sub(self.scanner.heading);
        let slack = self.slack(away);
        let (Some(beam), true) = (
            beam_towards(from_ahead),
            away.saturating_add(slack) < self.scanner_sees,
        ) else {
            return Verdict::Silence;
        };
        let beyond = away.saturating_add(slack);
        let first = usize::from(beam).saturating_sub(2);
        let (mut alike, mut past) = (0_u8, 0_u8);
        for reading in scan.iter().skip(first).take(5) {
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
        (
            along >> Direction::FRACTION_BITS,
            across >> Direction::FRACTION_BITS,
        )
    };
    let mut nearest: Option<(u32, u32)> = None;
    let mut before: Option<(i64, i64)> = None;
    for point in points {
        let here = point.map(place);
        if let (Some((one, left)), Some((other, right))) = (before, here) {
            let crosses = (left < 0) != (right < 0);
            let close = left.abs_diff(right) <= u64::from(GAP_MM);
            let ends = (u32::try_from(one.min(other)), u32::try_from(one.max(other)));
            if let (true, true, (Ok(near), Ok(far))) = (crosses, close, ends)
                && nearest.is_none_or(|(_, known)| far < known)
            {
                nearest = Some((near, far));
            }
        }
        before = here;
    }
    nearest.map(|(near, far)| (Millimeters::new(near), Millimeters::new(far)))
}

#[cfg(test)]
mod tests;
