//! Turning towards the goal: \[004\] eq. 12.

use super::{Effort, Side};
use certainty_core::units::BinaryAngle;

/// Returns `v_2R` of \[004\] eq. 12 for a goal that lies `goal` to the left of straight ahead; `v_2L` is
/// its opposite.
///
/// Formula: `β₂ (A − A_C)`, β₂ = 1/180°, the short way round. Range: ±1; exactly behind, the turn is to the
/// side `kept`.
///
/// The sign is for angles that count counter-clockwise, as all here do; for the azimuths of a compass,
/// which \[004\] eq. 10 yields, eq. 12 as printed turns away from the goal.
///
/// ```
/// use certainty_control::{Side, Effort, azimuth_turn};
/// use certainty_core::units::BinaryAngle;
///
/// let left = BinaryAngle::from_millidegrees(45_000);
/// assert_eq!(azimuth_turn(left, Side::Left), Effort::lit("0.25"));
/// assert_eq!(azimuth_turn(BinaryAngle::HALF, Side::Right), Effort::lit("-1"));
/// ```
#[must_use]
pub const fn azimuth_turn(goal: BinaryAngle, kept: Side) -> Effort {
    if goal.to_bits() == BinaryAngle::HALF.to_bits() {
        return kept.signed(Effort::ONE);
    }
    // Half a turn is 2^15 steps, full speed 2^16.
    let steps = goal.to_bits().cast_signed() as i32;
    Effort::from_bits(steps.wrapping_mul(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eq_12_by_hand() {
        for (degrees, expected) in [
            (0, 0.0),
            (90, 0.5),
            (-90, -0.5),
            (135, 0.75),
            (-135, -0.75),
            (225, -0.75),
        ] {
            let goal = BinaryAngle::from_millidegrees(degrees * 1000);
            assert_eq!(
                azimuth_turn(goal, Side::Left),
                Effort::from_num(expected),
                "{degrees}"
            );
        }
    }

    #[test]
    fn every_direction_is_the_opposite_of_its_mirror_image() {
        for bits in 0..=u16::MAX {
            let goal = BinaryAngle::from_bits(bits);
            let mirrored = BinaryAngle::ZERO.wrapping_sub(goal);
            let turn = azimuth_turn(goal, Side::Left);
            assert_eq!(azimuth_turn(mirrored, Side::Right), -turn);
            assert!(turn.abs() <= Effort::ONE);
        }
    }
}
