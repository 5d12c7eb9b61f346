//! Where an echo may come from: arcs of circles and ellipses, and whether two meet (\[003\] §6).
//!
//! An echo came from somewhere on an ellipse about the path's two sonars, within both cones; a direct
//! echo, from a circle. As seen from the robot's middle, each such arc is a function: one radius a
//! direction, as sound never comes from behind a sonar. Two arcs meet where the difference of their
//! radii is zero, and as an arc is at most as steep as half a cone's opening, the difference at two
//! directions bounds what is between them. So no equation of fourth degree is solved: an interval is
//! divided until the arcs are seen to meet, or seen not to. Tangency and coincidence need no cases.

use super::place::{FinePoint, sixteenths};
use super::ring::{Path, Ring};
use certainty_core::narrow::{saturating_i32, saturating_u16_of_u64};
use certainty_core::units::{BinaryAngle, Direction, Millimeters};

/// The arc of one echo. Lengths in sixteenths of a millimetre.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arc {
    middle: BinaryAngle,
    /// How far the arc goes to each side, in steps of a [`BinaryAngle`].
    half: u16,
    /// How far the middle between the sonars is from the robot's.
    offset: u64,
    /// The square of the semi-axis straight ahead.
    ahead: u64,
    /// The square of half of how far the sonars are apart: the ellipse's focal distance.
    focal: u64,
    /// The semi-axis to the sides.
    aside: u64,
    /// The product of the semi-axes.
    both: u64,
}

/// Fraction bits of sines here; a radius is then exact to some tenth of a millimetre.
const SINE_BITS: u32 = 14;

impl Arc {
    /// The arc of `path` at `distance`, as long as both cones are; `None` if no place of it is in both.
    pub(super) fn of<const SENSORS: usize>(
        ring: &Ring<SENSORS>,
        path: Path,
        distance: u16,
    ) -> Option<Self> {
        let mut arc = Self::unbounded(ring, path, distance);
        arc.half = arc.reach(ring, path)?;
        Some(arc)
    }

    /// The same arc, whose reach is known.
    pub(super) fn with_reach<const SENSORS: usize>(
        ring: &Ring<SENSORS>,
        path: Path,
        distance: u16,
        half: u16,
    ) -> Self {
        let arc = Self::unbounded(ring, path, distance);
        Self { half, ..arc }
    }

    fn unbounded<const SENSORS: usize>(ring: &Ring<SENSORS>, path: Path, distance: u16) -> Self {
        let (offset, half_apart) = ring.chord(path.order());
        let straight = sixteenths(Millimeters::new(distance.into())).unsigned_abs();
        let straight = u64::from(straight);
        let ahead = straight.wrapping_mul(straight);
        let focal = half_apart.wrapping_mul(half_apart);
        let aside = ahead.wrapping_add(focal).isqrt();
        Self {
            middle: ring.middle(path),
            half: 0,
            offset,
            ahead,
            focal,
            aside,
            both: aside.wrapping_mul(straight),
        }
    }

    /// How far the arc goes to each side of its middle while it is in both cones.
    ///
    /// The farther aside, the farther out of a cone: so the last place inside is found by halving.
    fn reach<const SENSORS: usize>(&self, ring: &Ring<SENSORS>, path: Path) -> Option<u16> {
        let sonars = ring.sonars(path);
        let inside = |aside: u16| {
            let direction = self.middle.wrapping_add(BinaryAngle::from_bits(aside));
            let radius = self.radius(aside.into())?;
            let place = FinePoint::polar(saturating_i32(radius), direction.direction());
            sonars
                .iter()
                .all(|sonar| sonar.sees(place))
                .then_some(aside)
        };
        let mut last = inside(0)?;
        let mut beyond = ring.half_width(path.order()).wrapping_add(1);
        while last.wrapping_add(1) < beyond {
            let between = last.midpoint(beyond);
            match inside(between) {
                Some(between) => last = between,
                None => beyond = between,
            }
        }
        Some(last)
    }

    pub(super) const fn half(&self) -> u16 {
        self.half
    }

    /// How far from the robot's middle the ellipse is, `turned` from the arc's middle; `None` where it
    /// is not in that direction.
    ///
    /// Formula: with semi-axes b straight ahead and a aside, a² = b² + f², and the ellipse's middle m
    /// ahead of the robot's, `r = (a²·m·cos ψ + a·b·√(A − m²·sin² ψ)) / A`, `A = b² + f²·cos² ψ`.
    ///
    /// Range: b and a below 2^17.1, m below 2^14; products below 2^63.
    fn radius(&self, turned: i32) -> Option<i64> {
        let direction = BinaryAngle::from_bits(low_bits(turned)).direction();
        let (cos, sin) = (sine(direction.cos()), sine(direction.sin()));
        let squared = |length: u64, part: u64| {
            let product = length.wrapping_mul(part).wrapping_mul(part);
            product >> (2 * SINE_BITS)
        };
        let across = self.ahead.wrapping_add(squared(self.focal, cos));
        let offset_square = self.offset.wrapping_mul(self.offset);
        let under = across.checked_sub(squared(offset_square, sin))?;
        let aside_square = self.ahead.wrapping_add(self.focal);
        let along = aside_square.wrapping_mul(self.offset).wrapping_mul(cos) >> SINE_BITS;
        let root = self.both.wrapping_mul(under.isqrt());
        let radius = along.wrapping_add(root).checked_div(across)?;
        Some(radius.cast_signed())
    }

    /// The farthest that any place of the arc can be from the robot's middle.
    const fn farthest(&self) -> u64 {
        self.offset.wrapping_add(self.aside)
    }

    /// Whether two arcs have a place in common, or come as near as `touch` to each other.
    ///
    /// Cost: two radii an interval; two to four intervals where the arcs clearly meet or do not, some
    /// thirty where they nearly touch, below 500 ever.
    pub(super) fn meets<const SENSORS: usize>(
        &self,
        other: &Self,
        ring: &Ring<SENSORS>,
        touch: Millimeters,
    ) -> bool {
        /// 2π / 2^16 in steps of 2^-32, rounded up: the angle of one step.
        const STEP: u64 = 411_775;
        let touch = i64::from(sixteenths(touch));
        // Directions count from this arc's middle; the other's middle is less than half a turn away.
        let apart = signed(other.middle.wrapping_sub(self.middle));
        let (half, other_half) = (i32::from(self.half), i32::from(other.half));
        let from = half.wrapping_neg().max(apart.wrapping_sub(other_half));
        let to = half.min(apart.wrapping_add(other_half));
        if from > to {
            return false;
        }
        let gap = |at: i32| {
            let own = self.radius(at)?;
            Some(own.wrapping_sub(other.radius(at.wrapping_sub(apart))?))
        };
        let far = self.farthest().wrapping_add(other.farthest());
        let steepest = far.wrapping_mul(ring.steepest()) >> 14;
        let slack = |steps: i32| {
            let most = steepest.wrapping_mul(steps.unsigned_abs().into());
            (most.wrapping_mul(STEP) >> 32)
                .cast_signed()
                .wrapping_add(2)
        };
        let (Some(first), Some(last)) = (gap(from), gap(to)) else {
            return false;
        };
        let mut open = heapless::Vec::<Interval, DEPTH>::new();
        let mut next = Some(Interval {
            from,
            to,
            first,
            last,
        });
        while let Some(interval) = next.take().or_else(|| open.pop()) {
            let Interval {
                from,
                to,
                first,
                last,
            } = interval;
            let (near_first, near_last) = (first.wrapping_abs(), last.wrapping_abs());
            if near_first <= touch || near_last <= touch || (first < 0) != (last < 0) {
                return true;
            }
            let width = to.wrapping_sub(from);
            // Least difference in between: both ends less what the arcs can turn towards each other.
            let twice_least = near_first
                .wrapping_add(near_last)
                .wrapping_sub(slack(width));
            if twice_least > touch.wrapping_mul(2) || width <= 1 {
                continue;
            }
            let middle = from.midpoint(to);
            let Some(between) = gap(middle) else {
                continue;
            };
            let right = Interval {
                to: middle,
                last: between,
                ..interval
            };
            let left = Interval {
                from: middle,
                first: between,
                ..interval
            };
            // Depth first: at most one open half a level, and widths halve from 2^15.
            let room = open.push(left);
            if room.is_err() {
                return false;
            }
            next = Some(right);
        }
        false
    }
}

/// Halves that may be open at once: one a level, from the widest of 2^15 steps down to one.
const DEPTH: usize = 18;

/// A range of directions, and the difference of the radii at its ends.
#[derive(Debug, Clone, Copy)]
struct Interval {
    from: i32,
    to: i32,
    first: i64,
    last: i64,
}

/// A part of a unit vector with fewer bits, without its sign.
const fn sine(part: i32) -> u64 {
    (part.unsigned_abs() >> (Direction::FRACTION_BITS - SINE_BITS)) as u64
}

/// An angle as steps to the left, or, below zero, to the right.
const fn signed(angle: BinaryAngle) -> i32 {
    angle.to_bits().cast_signed() as i32
}

/// Steps as an angle; turns do not matter.
fn low_bits(steps: i32) -> u16 {
    saturating_u16_of_u64(u64::from(steps.cast_unsigned() & 0xFFFF))
}

#[cfg(test)]
mod tests;
