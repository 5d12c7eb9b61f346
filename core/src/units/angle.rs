//! Angles as fractions of a turn, and the directions they point in.

use crate::narrow::{saturating_i32, wrapping_u16, wrapping_u32};
use core::ops::{Add, AddAssign, Neg, Sub, SubAssign};

/// An angle in steps of 1/65536 of a turn, counter-clockwise from +x.
///
/// Units and range: one step is 0.0055°; sums and differences wrap at the full turn.
///
/// ```
/// use certainty_core::units::BinaryAngle;
///
/// assert_eq!(BinaryAngle::QUARTER + BinaryAngle::QUARTER, BinaryAngle::HALF);
/// assert_eq!(BinaryAngle::HALF + BinaryAngle::HALF, BinaryAngle::ZERO);
/// assert_eq!(-BinaryAngle::HALF, BinaryAngle::HALF);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct BinaryAngle(u16);

/// Taylor coefficients of sin(z·π/2), in Q30: (−1)^k · (π/2)^(2k+1) / (2k+1)! for k = 0..=6.
///
/// On 0 ≤ z ≤ 1 the remainder of the series stays under 10⁻⁹, which is one step of Q30.
const SINE: [i64; 7] = [
    1_686_629_713,
    -693_598_668,
    85_569_306,
    -5_026_995,
    172_272,
    -3_864,
    61,
];

impl BinaryAngle {
    /// Along +x.
    pub const ZERO: Self = Self(0);
    /// A quarter turn counter-clockwise: along +y.
    pub const QUARTER: Self = Self(0x4000);
    /// Half a turn.
    pub const HALF: Self = Self(0x8000);

    /// Creates an angle of `steps`/65536 of a turn.
    #[must_use]
    pub const fn from_bits(steps: u16) -> Self {
        Self(steps)
    }

    /// Returns the angle in 1/65536 of a turn.
    #[must_use]
    pub const fn to_bits(self) -> u16 {
        self.0
    }

    /// Creates an angle of `millidegrees` thousandths of a degree, any number of turns.
    ///
    /// Rounds to the nearest step, ties up.
    ///
    /// ```
    /// use certainty_core::units::BinaryAngle;
    ///
    /// assert_eq!(BinaryAngle::from_millidegrees(90_000), BinaryAngle::QUARTER);
    /// assert_eq!(BinaryAngle::from_millidegrees(-270_000), BinaryAngle::QUARTER);
    /// ```
    #[must_use]
    pub const fn from_millidegrees(millidegrees: i32) -> Self {
        const TURN: i64 = 360_000;
        let within = (millidegrees as i64).rem_euclid(TURN);
        let steps = within.wrapping_mul(1 << 16).wrapping_add(TURN / 2) / TURN;
        // At most 65536, which is the full turn and wraps to zero.
        Self(wrapping_u16(wrapping_u32(steps)))
    }

    /// Returns the sum, modulo a turn. In a `const fn`; elsewhere write `+`.
    #[must_use]
    pub const fn wrapping_add(self, other: Self) -> Self {
        Self(self.0.wrapping_add(other.0))
    }

    /// Returns the difference, modulo a turn. In a `const fn`; elsewhere write `-`.
    #[must_use]
    pub const fn wrapping_sub(self, other: Self) -> Self {
        Self(self.0.wrapping_sub(other.0))
    }

    /// Returns the smaller angle between two directions: at most half a turn.
    #[must_use]
    pub const fn separation(self, other: Self) -> Self {
        let difference = self.0.wrapping_sub(other.0);
        let back = difference.wrapping_neg();
        Self(if back < difference { back } else { difference })
    }

    /// Returns the unit vector in this direction.
    ///
    /// Cost: 16 multiplications of 64 bits. Call it once a reading, not once a cell.
    #[must_use]
    pub const fn direction(self) -> Direction {
        Direction {
            cos: sine_q30(self.0.wrapping_add(0x4000)),
            sin: sine_q30(self.0),
        }
    }
}

/// Wraps at the full turn.
impl Add for BinaryAngle {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        self.wrapping_add(other)
    }
}

/// Wraps at the full turn.
impl AddAssign for BinaryAngle {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// Wraps at the full turn.
impl Sub for BinaryAngle {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self.wrapping_sub(other)
    }
}

/// Wraps at the full turn.
impl SubAssign for BinaryAngle {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

/// The same angle clockwise; wraps, so that half a turn is its own negative.
impl Neg for BinaryAngle {
    type Output = Self;

    fn neg(self) -> Self {
        Self::ZERO - self
    }
}

/// A unit vector, its components in steps of 2^-30.
///
/// Invariant: `cos² + sin²` is 1 to within 10⁻⁸, and neither component is beyond ±1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Direction {
    cos: i32,
    sin: i32,
}

impl Direction {
    /// Fraction bits of [`cos`](Self::cos) and [`sin`](Self::sin).
    pub const FRACTION_BITS: u32 = 30;

    /// Returns the direction of the vector (`x`, `y`); `None` for the zero vector.
    ///
    /// Units and range: any unit, each coordinate within ±2^62. The components are off by less than
    /// 4·10⁻⁹, and mirrored vectors have mirrored directions.
    ///
    /// ```
    /// use certainty_core::units::{BinaryAngle, Direction};
    ///
    /// assert_eq!(Direction::towards(0, 7), Some(BinaryAngle::QUARTER.direction()));
    /// assert_eq!(Direction::towards(0, 0), None);
    /// ```
    #[must_use]
    pub const fn towards(x: i64, y: i64) -> Option<Self> {
        /// Both coordinates are shifted to this many bits, so that their squares fit 63 bits.
        const BITS: u32 = 31;
        let (along, across) = (x.unsigned_abs(), y.unsigned_abs());
        let largest = if along > across { along } else { across };
        let bits = u64::BITS.wrapping_sub(largest.leading_zeros());
        let (along, across) = if bits > BITS {
            let less = bits.wrapping_sub(BITS);
            (along.wrapping_shr(less), across.wrapping_shr(less))
        } else {
            let more = BITS.wrapping_sub(bits);
            (along.wrapping_shl(more), across.wrapping_shl(more))
        };
        let squares = along.wrapping_mul(along);
        let length = squares.wrapping_add(across.wrapping_mul(across)).isqrt();
        match (
            component(along, length, x < 0),
            component(across, length, y < 0),
        ) {
            (Some(cos), Some(sin)) => Some(Self { cos, sin }),
            _ => None,
        }
    }

    /// Returns the direction a quarter turn counter-clockwise of this one.
    #[must_use]
    pub const fn turned_left(self) -> Self {
        Self {
            cos: self.sin.wrapping_neg(),
            sin: self.cos,
        }
    }

    /// Returns the opposite direction.
    #[must_use]
    pub const fn reversed(self) -> Self {
        Self {
            cos: self.cos.wrapping_neg(),
            sin: self.sin.wrapping_neg(),
        }
    }

    /// Returns the component along x, in steps of 2^-30.
    #[must_use]
    pub const fn cos(self) -> i32 {
        self.cos
    }

    /// Returns the component along y, in steps of 2^-30.
    #[must_use]
    pub const fn sin(self) -> i32 {
        self.sin
    }
}

/// `magnitude / length` in Q30, rounded, at most one; `None` if the length is zero.
const fn component(magnitude: u64, length: u64, negative: bool) -> Option<i32> {
    const ONE: u64 = 1 << Direction::FRACTION_BITS;
    let scaled = (magnitude << Direction::FRACTION_BITS).wrapping_add(length >> 1);
    match scaled.checked_div(length) {
        None => None,
        Some(ratio) => {
            let ratio = saturating_i32(if ratio > ONE { ONE } else { ratio }.cast_signed());
            Some(if negative {
                ratio.wrapping_neg()
            } else {
                ratio
            })
        }
    }
}

/// sin of `steps`/65536 of a turn, in Q30; mirror-symmetric to the last bit.
const fn sine_q30(steps: u16) -> i32 {
    fine_sine_q30((steps as u32) << 16)
}

/// sin of `steps`/2^32 of a turn, in Q30; mirror-symmetric to the last bit.
///
/// Range: every product stays below 2^62, as |sum| < 2^31 and z ≤ 2^30.
#[must_use]
pub const fn fine_sine_q30(steps: u32) -> i32 {
    const ONE: i64 = 1 << Direction::FRACTION_BITS;
    const HALF: i64 = 1 << (Direction::FRACTION_BITS - 1);
    // Fold into the first quarter: `z` is 0..=2^30, a quarter being one.
    let half = steps & 0x7FFF_FFFF;
    let folded = if half > 0x4000_0000 {
        0x8000_0000_u32.wrapping_sub(half)
    } else {
        half
    };
    let z = folded as i64;
    let square = z.wrapping_mul(z) >> Direction::FRACTION_BITS;
    let [c0, c1, c2, c3, c4, c5, c6] = SINE;
    let sum = horner(c6, square, c5);
    let sum = horner(sum, square, c4);
    let sum = horner(sum, square, c3);
    let sum = horner(sum, square, c2);
    let sum = horner(sum, square, c1);
    let sum = horner(sum, square, c0);
    let product = sum.wrapping_mul(z).wrapping_add(HALF) >> Direction::FRACTION_BITS;
    let magnitude = saturating_i32(if product > ONE { ONE } else { product });
    if steps & 0x8000_0000 == 0 {
        magnitude
    } else {
        magnitude.wrapping_neg()
    }
}

/// One step of Horner's rule in Q30: `sum · square + coefficient`, rounded.
const fn horner(sum: i64, square: i64, coefficient: i64) -> i64 {
    const HALF: i64 = 1 << (Direction::FRACTION_BITS - 1);
    let product = sum.wrapping_mul(square).wrapping_add(HALF);
    (product >> Direction::FRACTION_BITS).wrapping_add(coefficient)
}

/// atan(2^-k) for k = 0..=23, in steps of 2^-32 of a turn.
const ARCTANGENTS: [u32; 24] = [
    536_870_912,
    316_933_406,
    167_458_907,
    85_004_756,
    42_667_331,
    21_354_465,
    10_679_838,
    5_340_245,
    2_670_163,
    1_335_087,
    667_544,
    333_772,
    166_886,
    83_443,
    41_722,
    20_861,
    10_430,
    5_215,
    2_608,
    1_304,
    652,
    326,
    163,
    81,
];

impl BinaryAngle {
    /// Returns the direction of the vector (`x`, `y`); `None` for the zero vector.
    ///
    /// Formula: atan2(y, x), by rotating the vector onto an axis in halving steps (CORDIC). Rounds to
    /// the nearest step; mirrored vectors have mirrored directions, to the bit.
    ///
    /// Cost: 24 rounds of two shifts and three additions.
    ///
    /// ```
    /// use certainty_core::units::BinaryAngle;
    ///
    /// assert_eq!(BinaryAngle::towards(0, 5), Some(BinaryAngle::QUARTER));
    /// assert_eq!(BinaryAngle::towards(-3, 0), Some(BinaryAngle::HALF));
    /// assert_eq!(BinaryAngle::towards(0, 0), None);
    /// ```
    #[must_use]
    pub const fn towards(x: i32, y: i32) -> Option<Self> {
        let (across, up) = (x.unsigned_abs(), y.unsigned_abs());
        if across == 0 && up == 0 {
            return None;
        }
        // Folded into the first octant, so that all mirror images round alike.
        let steep = up > across;
        let (long, short) = if steep { (up, across) } else { (across, up) };
        let octant = first_octant(long, short);
        let quarter = if steep {
            Self::QUARTER.wrapping_sub(octant)
        } else {
            octant
        };
        let upper = if x < 0 {
            Self::HALF.wrapping_sub(quarter)
        } else {
            quarter
        };
        Some(if y < 0 {
            Self::ZERO.wrapping_sub(upper)
        } else {
            upper
        })
    }
}

/// atan(`short` / `long`), for `short` ≤ `long`.
const fn first_octant(long: u32, short: u32) -> BinaryAngle {
    // Scaled to 2^40 or more, so that the bits that the shifts drop are far below a step. The
    // rotations make the vector 1.65 times as long, which fits 64 bits easily.
    let lift = long.leading_zeros().wrapping_add(9);
    let (mut x, mut y) = ((long as i64) << lift, (short as i64) << lift);
    let mut angle = 0_i64;
    let mut rest: &[u32] = &ARCTANGENTS;
    let mut shift = 0;
    while let [step, others @ ..] = rest {
        let (across, up) = (x >> shift, y >> shift);
        if y > 0 {
            x = x.wrapping_add(up);
            y = y.wrapping_sub(across);
            angle = angle.wrapping_add(*step as i64);
        } else {
            x = x.wrapping_sub(up);
            y = y.wrapping_add(across);
            angle = angle.wrapping_sub(*step as i64);
        }
        rest = others;
        shift = 1_u32.wrapping_add(shift);
    }
    let rounded = angle.wrapping_add(1 << 15) >> 16;
    BinaryAngle::from_bits(wrapping_u16(wrapping_u32(rounded)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{FRAC_PI_2, TAU};
    use proptest::prelude::*;

    #[test]
    fn sine_coefficients_are_the_taylor_series() {
        let mut exact = FRAC_PI_2;
        for (k, &coefficient) in SINE.iter().enumerate() {
            let q30 = exact * f64::from(1 << 30);
            assert!(
                (q30 - coefficient as f64).abs() <= 0.51,
                "term {k}: {q30} vs {coefficient}"
            );
            let n = 2.0 * k as f64 + 2.0;
            exact *= -FRAC_PI_2 * FRAC_PI_2 / (n * (n + 1.0));
        }
    }

    #[test]
    fn every_direction_is_exact_to_four_billionths() {
        let mut worst = 0.0_f64;
        for steps in 0..=u16::MAX {
            let direction = BinaryAngle::from_bits(steps).direction();
            let (sin, cos) = (f64::from(steps) / 65536.0 * TAU).sin_cos();
            let scale = f64::from(1 << 30);
            worst = worst.max((f64::from(direction.sin()) / scale - sin).abs());
            worst = worst.max((f64::from(direction.cos()) / scale - cos).abs());
        }
        assert!(worst < 4e-9, "worst error {worst:e}");
        assert!(worst > 1e-10, "no integer series is this exact: {worst:e}");
    }

    #[test]
    fn directions_mirror_exactly() {
        for steps in 0..=u16::MAX {
            let angle = BinaryAngle::from_bits(steps);
            let mirrored = (-angle).direction();
            assert_eq!(mirrored.cos(), angle.direction().cos());
            assert_eq!(mirrored.sin(), -angle.direction().sin());
            let turned = (angle + BinaryAngle::QUARTER).direction();
            assert_eq!(
                (turned.cos(), turned.sin()),
                (-angle.direction().sin(), angle.direction().cos())
            );
        }
    }

    #[test]
    fn the_direction_of_a_vector_is_exact_to_four_billionths() {
        let numbers = [0, 1, 2, 3, 7, 1000, 65_535, 8_388_607, 1 << 40, 1 << 62];
        let signed: Vec<i64> = numbers.iter().flat_map(|&n| [n, -n]).collect();
        for &x in &signed {
            for &y in &signed {
                let Some(direction) = Direction::towards(x, y) else {
                    assert_eq!((x, y), (0, 0));
                    continue;
                };
                let length = (x as f64).hypot(y as f64);
                let scale = f64::from(1 << 30);
                let off = (f64::from(direction.cos()) / scale - x as f64 / length)
                    .abs()
                    .max((f64::from(direction.sin()) / scale - y as f64 / length).abs());
                assert!(off < 4e-9, "({x}, {y}): {off:e}");
                let mirrored = Direction::towards(-x, y).unwrap();
                assert_eq!(mirrored.cos(), -direction.cos(), "({x}, {y})");
            }
        }
    }

    #[test]
    fn sums_and_differences_wrap() {
        let step = BinaryAngle::from_bits(1);
        let last = BinaryAngle::from_bits(u16::MAX);
        assert_eq!(last + step, BinaryAngle::ZERO);
        assert_eq!(BinaryAngle::ZERO - step, last);
        assert_eq!(-step, last);
        assert_eq!(-BinaryAngle::ZERO, BinaryAngle::ZERO);
        assert_eq!(-BinaryAngle::HALF, BinaryAngle::HALF);
        let mut angle = last;
        angle += step + step;
        assert_eq!(angle, step);
        angle -= step + step;
        assert_eq!(angle, last);
    }

    #[test]
    fn millidegrees_round_to_the_nearest_step() {
        for millidegrees in [
            -720_000,
            -1,
            0,
            1,
            2,
            3,
            5,
            45_000,
            359_999,
            i32::MAX,
            i32::MIN,
        ] {
            let steps = f64::from(millidegrees) / 360_000.0 * 65536.0;
            let expected = (steps.rem_euclid(65536.0) + 0.5).floor() as u32 as u16;
            assert_eq!(
                BinaryAngle::from_millidegrees(millidegrees).to_bits(),
                expected
            );
        }
    }

    #[test]
    fn separation_is_the_smaller_angle() {
        let (a, b) = (
            BinaryAngle::from_millidegrees(350_000),
            BinaryAngle::from_millidegrees(10_000),
        );
        assert_eq!(a.separation(b), b.separation(a));
        assert_eq!(a.separation(b).to_bits(), 2 * 1820); // twice 10 degrees, rounded down
        assert_eq!(a.separation(a), BinaryAngle::ZERO);
    }

    #[test]
    fn the_rotation_steps_are_arctangents() {
        for (k, &step) in ARCTANGENTS.iter().enumerate() {
            let exact = 0.5_f64.powi(k as i32).atan() / TAU * 4_294_967_296.0;
            assert!((exact - f64::from(step)).abs() <= 0.5, "{k}: {exact}");
        }
    }

    #[test]
    fn towards_inverts_direction() {
        for bits in 0..=u16::MAX {
            let angle = BinaryAngle::from_bits(bits);
            let direction = angle.direction();
            let found = BinaryAngle::towards(direction.cos(), direction.sin());
            assert_eq!(found, Some(angle));
        }
    }

    #[test]
    fn the_largest_vectors_have_directions() {
        let towards = |x, y| BinaryAngle::towards(x, y).unwrap().to_bits();
        assert_eq!(towards(i32::MIN, i32::MIN), 5 << 13);
        assert_eq!(towards(i32::MAX, i32::MAX), 1 << 13);
        assert_eq!(towards(1, 0), 0);
        assert_eq!(towards(0, -1), 3 << 14);
    }

    proptest! {
        #[test]
        fn towards_is_the_nearest_step(x in -100_000_i32..100_000, y in -100_000_i32..100_000) {
            prop_assume!((x, y) != (0, 0));
            let exact = f64::from(y).atan2(f64::from(x)) / TAU * 65536.0;
            let found = BinaryAngle::towards(x, y).unwrap().to_bits();
            let error = (exact - f64::from(found)).rem_euclid(65536.0);
            prop_assert!(error.min(65536.0 - error) <= 0.51, "{exact} {found}");
        }

        #[test]
        fn mirrored_vectors_have_mirrored_directions(x in -i32::MAX.., y in -i32::MAX..) {
            prop_assume!((x, y) != (0, 0));
            let angle = BinaryAngle::towards(x, y).unwrap();
            prop_assert_eq!(BinaryAngle::towards(x, -y), Some(-angle));
            prop_assert_eq!(BinaryAngle::towards(-x, y), Some(BinaryAngle::HALF - angle));
        }
    }
}
