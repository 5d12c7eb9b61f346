//! The direction of a vector, in integers.

use super::BinaryAngle;
use crate::narrow::{wrapping_u16, wrapping_u32};

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
    /// Returns the direction of the vector (`x`, `y`); `None` for one of no length.
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
        // Folded into the first octant, where rounding is the same for all mirror images.
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
    // Scaled to 2^40 or more, so that what the shifts drop is far below a step; the rotations make
    // the vector 1.65 times as long, which is far from what 64 bits hold.
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
    use core::f64::consts::TAU;
    use proptest::prelude::*;

    #[test]
    fn the_steps_are_arctangents() {
        for (k, &step) in ARCTANGENTS.iter().enumerate() {
            let exact = 0.5_f64.powi(k as i32).atan() / TAU * 4_294_967_296.0;
            assert!((exact - f64::from(step)).abs() <= 0.5, "{k}: {exact}");
        }
    }

    #[test]
    fn every_direction_is_found_again() {
        for bits in 0..=u16::MAX {
            let angle = BinaryAngle::from_bits(bits);
            let direction = angle.direction();
            let found = BinaryAngle::towards(direction.cos(), direction.sin());
            assert_eq!(found, Some(angle));
        }
    }

    #[test]
    fn the_extremes_have_directions() {
        let towards = |x, y| BinaryAngle::towards(x, y).unwrap().to_bits();
        assert_eq!(towards(i32::MIN, i32::MIN), 5 << 13);
        assert_eq!(towards(i32::MAX, i32::MAX), 1 << 13);
        assert_eq!(towards(1, 0), 0);
        assert_eq!(towards(0, -1), 3 << 14);
    }

    proptest! {
        #[test]
        fn a_direction_is_the_nearest_step(x in -100_000_i32..100_000, y in -100_000_i32..100_000) {
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
            prop_assert_eq!(BinaryAngle::towards(x, -y), Some(BinaryAngle::ZERO.wrapping_sub(angle)));
            prop_assert_eq!(BinaryAngle::towards(-x, y), Some(BinaryAngle::HALF.wrapping_sub(angle)));
        }
    }
}
