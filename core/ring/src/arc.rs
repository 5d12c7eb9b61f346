//! The arc from which an echo may have come, and whether two arcs intersect (\[003\] §6, Fig. 5).
//!
//! An echo came from a point on an ellipse whose foci are the path's two sonars, within both cones; a
//! direct echo came from a circle. Seen from the robot's centre, each such arc is a function: one radius
//! per direction, as no echo comes from behind a sonar. Two arcs intersect where the difference of their
//! radii is zero. The slope of an arc is bounded by half a cone's opening, so the differences at two
//! directions bound those in between. An interval of directions is therefore bisected until the arcs are
//! proven to intersect, or proven not to; no equation of fourth degree is solved, and tangency and
//! coincidence are no special cases.

use super::geometry::{FinePoint, saturating_i32, sixteenths};
use super::ring::{Path, Ring};
use certainty_core::units::{BinaryAngle, Direction, Millimeters};

/// The arc of one echo. Lengths are in sixteenths of a millimetre.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arc {
    middle: BinaryAngle,
    /// The extent of the arc to each side, in steps of a [`BinaryAngle`].
    half: u16,
    /// The distance of the ellipse's centre, the midpoint between the sonars, from the robot's centre.
    offset: u64,
    /// The square of the semi-axis straight ahead.
    ahead: u64,
    /// The square of half the distance between the sonars: of the ellipse's focal distance.
    focal: u64,
    /// The semi-axis to the sides.
    aside: u64,
    /// The product of the semi-axes.
    both: u64,
}

/// Fraction bits of sines in this module; a radius is then exact to some tenth of a millimetre.
const SINE_BITS: u32 = 14;

impl Arc {
    /// The arc of `path` at `distance`, as far as both cones extend; `None` if no point of it is in both.
    pub(super) fn of<const SENSORS: usize>(
        ring: &Ring<SENSORS>,
        path: Path,
        distance: u16,
    ) -> Option<Self> {
        let mut arc = Self::unbounded(ring, path, distance);
        arc.half = arc.extent(ring, path)?;
        Some(arc)
    }

    /// The same arc, whose extent has been computed before.
    pub(super) fn with_extent<const SENSORS: usize>(
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

    /// The extent of the arc to each side of its middle within both cones.
    ///
    /// A point farther aside is farther out of a cone, so the last point inside is found by bisection.
    fn extent<const SENSORS: usize>(&self, ring: &Ring<SENSORS>, path: Path) -> Option<u16> {
        let sonars = ring.sonars(path);
        let inside = |aside: u16| {
            let direction = self.middle.wrapping_add(BinaryAngle::from_bits(aside));
            let radius = self.radius(aside.into())?;
            let point = FinePoint::polar(saturating_i32(radius), direction.direction());
            sonars
                .iter()
                .all(|sonar| sonar.covers(point))
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

    /// The distance of the ellipse from the robot's centre, in the direction `turned` from the arc's
    /// middle; `None` if the ellipse is not in that direction.
    ///
    /// Formula: with semi-axes b straight ahead and a aside, a² = b² + f², and the ellipse's centre m ahead
    /// of the robot's, `r = (a²·m·cos ψ + a·b·√(A − m²·sin² ψ)) / A`, `A = b² + f²·cos² ψ`.
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

    /// A bound of the distance of any point of the arc from the robot's centre.
    const fn farthest(&self) -> u64 {
        self.offset.wrapping_add(self.aside)
    }

    /// Whether two arcs intersect, or come as close as `touch` to each other.
    ///
    /// Cost: two radii per interval; two to four intervals if the arcs clearly intersect or clearly do not,
    /// some thirty if they nearly touch, always below 500.
    pub(super) fn intersects<const SENSORS: usize>(
        &self,
        other: &Self,
        ring: &Ring<SENSORS>,
        touch: Millimeters,
    ) -> bool {
        /// 2π / 2^16 in steps of 2^-32, rounded up: the angle of one step.
        const STEP: u64 = 411_775;
        let touch = i64::from(sixteenths(touch));
        // Directions are relative to this arc's middle; the other's is less than half a turn away.
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
            // The least difference in between: that of both ends less what the slopes allow.
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
            // Depth first: at most one open half per level, and widths halve from 2^15.
            let pushed = open.push(left);
            if pushed.is_err() {
                return false;
            }
            next = Some(right);
        }
        false
    }
}

/// Halves that may be open at once: one per level, from the widest of 2^15 steps down to one.
const DEPTH: usize = 18;

/// A range of directions, and the difference of the radii at its ends.
#[derive(Debug, Clone, Copy)]
struct Interval {
    from: i32,
    to: i32,
    first: i64,
    last: i64,
}

/// The absolute value of a unit vector's component, with fewer bits.
const fn sine(part: i32) -> u64 {
    (part.unsigned_abs() >> (Direction::FRACTION_BITS - SINE_BITS)) as u64
}

/// An angle in steps, positive to the left.
const fn signed(angle: BinaryAngle) -> i32 {
    angle.to_bits().cast_signed() as i32
}

/// Steps as an angle, modulo a full turn.
const fn low_bits(steps: i32) -> u16 {
    let [low, high, ..] = steps.to_le_bytes();
    u16::from_le_bytes([low, high])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RingConfig;
    use core::f64::consts::TAU;
    use proptest::prelude::*;

    const RADIUS: f64 = 300.0;

    fn ring() -> Ring<24> {
        Ring::try_new(RingConfig::DEFAULT).unwrap()
    }

    /// The arcs in floating point, by their definition: no axes, no closed form.
    #[derive(Clone, Copy)]
    struct Naive {
        foci: [(f64, f64); 2],
        axes: [f64; 2],
        length: f64,
        middle: f64,
    }

    impl Naive {
        fn of(from: u8, order: u8, distance: f64) -> Self {
            let axes = [f64::from(from), f64::from(from + order)].map(|slot| slot * TAU / 24.0);
            let foci = axes.map(|axis| (RADIUS * axis.cos(), RADIUS * axis.sin()));
            let half_apart = (foci[0].0 - foci[1].0).hypot(foci[0].1 - foci[1].1) / 2.0;
            Self {
                foci,
                axes,
                length: 2.0 * distance.hypot(half_apart),
                middle: f64::midpoint(axes[0], axes[1]),
            }
        }

        fn radius(&self, direction: f64) -> f64 {
            let over = |radius: f64| {
                let (x, y) = (radius * direction.cos(), radius * direction.sin());
                let ways = self.foci.map(|(fx, fy)| (x - fx).hypot(y - fy));
                ways[0] + ways[1] > self.length
            };
            let (mut low, mut high) = (RADIUS * 0.5, 20_000.0);
            for _ in 0..60 {
                let middle = f64::midpoint(low, high);
                if over(middle) {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            low
        }

        /// Whether the arc's point in this direction is within cones of this half angle.
        fn within(&self, direction: f64, half: f64) -> bool {
            let radius = self.radius(direction);
            let (x, y) = (radius * direction.cos(), radius * direction.sin());
            self.foci.iter().zip(self.axes).all(|(&(fx, fy), axis)| {
                let off = (y - fy).atan2(x - fx) - axis;
                let off = (off + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
                off.abs() <= half
            })
        }
    }

    /// The least difference of two arcs within cones of this half angle, and whether it changes its sign.
    fn naive_gap(one: &Naive, other: &Naive, half: f64) -> Option<(f64, bool)> {
        let mut least: Option<(f64, bool)> = None;
        let mut sign = None;
        for step in -600..=600 {
            let direction = one.middle + f64::from(step) / 600.0 * half;
            if !one.within(direction, half) || !other.within(direction, half) {
                continue;
            }
            let gap = one.radius(direction) - other.radius(direction);
            let changed = sign.is_some_and(|positive| positive != (gap > 0.0));
            sign = Some(gap > 0.0);
            let before = least.unwrap_or((f64::INFINITY, false));
            least = Some((before.0.min(gap.abs()), before.1 || changed));
        }
        least
    }

    fn intersects(one: (u8, u8, u16), other: (u8, u8, u16)) -> bool {
        let ring = ring();
        let arc = |(from, order, distance)| Arc::of(&ring, Path::new(from, order), distance);
        let touch = Millimeters::new(1);
        arc(one)
            .zip(arc(other))
            .is_some_and(|(one, other)| one.intersects(&other, &ring, touch))
    }

    #[test]
    fn the_radius_is_that_of_the_definition() {
        let ring = ring();
        let mut worst = 0.0_f64;
        for order in 0..=3 {
            for distance in [150, 300, 700, 1999, 2000] {
                let Some(arc) = Arc::of(&ring, Path::new(2, order), distance) else {
                    // The cones of distant neighbours share no point so near.
                    let naive = Naive::of(2, order, distance.into());
                    assert!(!naive.within(naive.middle, TAU / 12.0 - 1e-3));
                    continue;
                };
                let naive = Naive::of(2, order, distance.into());
                for turned in (-i32::from(arc.half)..=i32::from(arc.half)).step_by(97) {
                    let direction = naive.middle + f64::from(turned) / 65536.0 * TAU;
                    let found = arc.radius(turned).unwrap() as f64 / 16.0;
                    worst = worst.max((found - naive.radius(direction)).abs());
                }
            }
        }
        assert!(worst < 0.25, "{worst} mm");
        assert!(
            worst > 0.001,
            "an error of {worst} mm is below the resolution: the comparison is void"
        );
    }

    #[test]
    fn an_arc_extends_as_far_as_both_cones() {
        let ring = ring();
        for order in 0..=3 {
            for distance in [150, 400, 1000, 2000] {
                let naive = Naive::of(0, order, distance.into());
                let half = Arc::of(&ring, Path::new(0, order), distance).map(|arc| arc.half);
                let Some(half) = half else {
                    assert!(
                        !naive.within(naive.middle, TAU / 12.0 - 1e-3),
                        "{order} at {distance}"
                    );
                    continue;
                };
                let reach = f64::from(half) / 65536.0 * TAU;
                assert!(naive.within(naive.middle + reach - 0.002, TAU / 12.0));
                assert!(!naive.within(naive.middle + reach + 0.002, TAU / 12.0));
            }
        }
    }

    #[test]
    fn arcs_of_one_wall_and_of_one_corner_intersect() {
        // A wall 1 m from the centre, square to sonar 1: the neighbours' feet are at 1 m − 0.3·cos 15°.
        let direct = |slot: f64| (1000.0 - 300.0 * (slot * TAU / 24.0).cos()).round() as u16;
        assert!(intersects((0, 0, direct(0.0)), (1, 0, direct(1.0))));
        assert!(intersects((23, 0, direct(1.0)), (1, 0, direct(1.0))));
        // The arcs around (0.9 m, 0.2 m), from sonars 1, 2 and across between them.
        let (x, y) = (900.0_f64, 200.0_f64);
        let away = |slot: f64| {
            let axis = slot * TAU / 24.0;
            (x - 300.0 * axis.cos()).hypot(y - 300.0 * axis.sin())
        };
        let chord = 300.0 * (TAU / 48.0).sin();
        let across = ((away(0.0) + away(1.0)) / 2.0).powi(2) - chord * chord;
        let across = across.sqrt().round() as u16;
        let (first, second) = (away(0.0).round() as u16, away(1.0).round() as u16);
        assert!(intersects((0, 0, first), (1, 0, second)));
        assert!(intersects((0, 0, first), (0, 1, across)));
        assert!(!intersects((0, 0, first), (0, 1, across + 40)));
    }

    #[test]
    fn arcs_that_touch_intersect() {
        // The circle about sonar 2 and the ellipse about 1 and 3 are both symmetric to sonar 2's axis: they
        // touch there if the wall is square to it, and are apart for a longer path.
        let wall = 1000.0_f64;
        let direct = (wall - 300.0).round() as u16;
        let across = (wall - 300.0 * (TAU / 24.0).cos()).round() as u16;
        assert!(intersects((1, 0, direct), (0, 2, across)));
        assert!(!intersects((1, 0, direct), (0, 2, across + 8)));
    }

    #[test]
    fn arcs_that_coincide_intersect() {
        for order in 0..=3 {
            for distance in [120, 500, 2000] {
                let arc = (4, order, distance);
                let there = Arc::of(&ring(), Path::new(4, order), distance).is_some();
                assert_eq!(intersects(arc, arc), there, "{arc:?}");
            }
        }
    }

    #[test]
    fn a_distance_of_zero_is_defined() {
        for order in 0..=3 {
            for other in 0..=3 {
                let _ = intersects((0, order, 0), (1, other, 0));
                let _ = intersects((0, order, 0), (1, other, 2000));
                let _ = intersects((0, order, 8000), (1, other, 1));
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]
        #[test]
        fn arcs_intersect_where_a_fine_search_finds_it(
            one in (0_u8..=3, 60_u16..2000),
            apart in 0_u8..6,
            order in 0_u8..=3,
            nearly in -150_i32..150,
        ) {
            let other = (apart, order, (i32::from(one.1) + nearly).max(20) as u16);
            let naive = Naive::of(0, one.0, one.1.into());
            let against = Naive::of(other.0, other.1, other.2.into());
            let found = intersects((0, one.0, one.1), other);
            // Cases decided by the last tenth of a degree of a cone, or of a millimetre, are left out.
            let half = TAU / 12.0;
            let narrow = naive_gap(&naive, &against, half - 0.004);
            let wide = naive_gap(&naive, &against, half + 0.004);
            if narrow.is_some_and(|(least, changes)| changes || least < 0.5) {
                prop_assert!(found, "{one:?} {other:?}: {narrow:?}");
            }
            if wide.is_none_or(|(least, changes)| !changes && least > 2.5) {
                prop_assert!(!found, "{one:?} {other:?}: {wide:?}");
            }
        }

        #[test]
        fn intersecting_is_symmetric(
            one in (0_u8..24, 0_u8..=3, 1_u16..8000),
            other in (0_u8..24, 0_u8..=3, 1_u16..8000),
        ) {
            prop_assert_eq!(intersects(one, other), intersects(other, one));
        }
    }
}
