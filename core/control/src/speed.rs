//! How fast to go ahead: \[004\] eq. 13.

use super::Effort;

/// Returns `v_3` of \[004\] eq. 13 from the turns `v_0R`, `v_1R` and `v_2R`; the same for both sides.
///
/// Formula: `1 − max(Σ v_R, Σ v_L)`, which is `1 − |Σ v_R|`, as each `v_L` is the opposite of its `v_R`.
///
/// Differs from \[004\] eq. 13 in that it is at least 0: three turns that add up to more than 1 would
/// let the robot back up, where no scanner looks.
///
/// ```
/// use certainty_control::{Effort, linear_speed};
///
/// let turns = [0.5, -0.25, 0.125].map(Effort::from_num);
/// assert_eq!(linear_speed(turns), Effort::lit("0.625"));
/// ```
#[must_use]
pub fn linear_speed(turns: [Effort; 3]) -> Effort {
    let sum = turns.into_iter().fold(Effort::ZERO, Effort::saturating_add);
    Effort::ONE
        .saturating_sub(sum.saturating_abs())
        .max(Effort::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eq_13_by_hand() {
        let speed = |a, b, c| linear_speed([a, b, c].map(Effort::from_num)).to_num::<f64>();
        assert_eq!(speed(0.0, 0.0, 0.0), 1.0);
        assert_eq!(speed(-0.5, 0.25, -0.5), 0.25);
        assert_eq!(speed(0.5, -0.25, 0.5), 0.25);
        assert_eq!(speed(1.0, 0.5, 0.5), 0.0);
        assert_eq!(linear_speed([Effort::MIN; 3]), Effort::ZERO);
    }
}
