//! Three of the four behaviours of \[004\] eq. 1: Braitenberg, turning to the goal, going ahead.
//!
//! | behaviour | equations | item |
//! |---|---|---|
//! | Braitenberg on the rangefinders | 2, 4, 5 | [`Braitenberg::turn`] of [`nearness`](nearness()) |
//! | histogram on the scanner | 6 to 9, 11 | [`PolarHistogram`](crate::PolarHistogram), [`Valley`](crate::Valley) |
//! | turning to the goal | 12 | [`azimuth_turn`] |
//! | going ahead | 13 | [`linear_speed`] |

use crate::motion::{Effort, Side};
use crate::sensors::RANGEFINDERS;
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Millimeters};

/// Returns how near the object is that a rangefinder reports: `s_RF` of \[004\] eq. 5; `None` if the reading
/// is missing.
///
/// Formula: `1 − D / D_def` where D < `D_def`, else 0. Rounds down. *Too near* is 1, *no object* 0. `default`
/// is `D_def`, above zero, else all is 0.
///
/// Eq. 3, for rangefinders that look down and so see holes as well, is not here.
///
/// ```
/// use certainty_control::{Effort, nearness};
/// use certainty_core::transducer::Reading;
/// use certainty_core::units::Millimeters;
///
/// let default = Millimeters::new(2000);
/// let echo = |mm| Reading::Echo(Millimeters::new(mm));
/// assert_eq!(nearness(echo(500), default), Some(Effort::lit("0.75")));
/// assert_eq!(nearness(echo(3000), default), Some(Effort::ZERO));
/// ```
#[must_use]
pub fn nearness(reading: Reading, default: Millimeters) -> Option<Effort> {
    let nearer_by = match reading {
        Reading::Missing(_) => return None,
        Reading::TooNear => default,
        Reading::NoObject => Millimeters::ZERO,
        Reading::Echo(distance) => default - distance,
    };
    // At most one, in 32 bits and 16 more.
    let wide = u64::from(nearer_by.get()) << Effort::FRAC_NBITS;
    let part = wide.checked_div(default.get().into()).unwrap_or(0);
    Some(Effort::from_bits(i32::try_from(part).unwrap_or(i32::MAX)))
}

/// The Braitenberg behaviour: the weights `W` of \[004\] eq. 2.
///
/// Possession proves eq. 4: what a rangefinder adds to one side's wheels it subtracts from the other's, and
/// its mirror image does the opposite. So `R` / 2 weights determine all 2 `R`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Braitenberg<const R: usize = RANGEFINDERS> {
    right: [Effort; R],
}

impl<const R: usize> Braitenberg<R> {
    /// Creates the behaviour from `W_{1,1}`, `W_{1,2}` and so on: what each rangefinder on the left adds to the
    /// right wheels. Negative weights turn away from what is seen.
    ///
    /// `R` must be 2 `H`, else it does not compile.
    #[must_use]
    pub const fn new<const H: usize>(left: [Effort; H]) -> Self {
        const {
            assert!(
                2 * H == R,
                "one weight for each of the R / 2 rangefinders on the left"
            );
        }
        let mut right = [Effort::ZERO; R];
        let (mut weights, mut rest): (&[Effort], &mut [Effort]) = (&left, &mut right);
        while let ([weight, weights_left @ ..], [first, others @ .., last]) = (weights, rest) {
            *first = *weight;
            *last = Effort::from_bits(weight.to_bits().saturating_neg());
            (weights, rest) = (weights_left, others);
        }
        Self { right }
    }

    /// Returns `W_{1,i}` of every rangefinder; `W_{2,i}` is its opposite.
    #[must_use]
    pub const fn weights(&self) -> &[Effort; R] {
        &self.right
    }

    /// Returns `v_0R` of \[004\] eq. 2, from each rangefinder's [nearness](nearness()); `v_0L` is its
    /// opposite.
    ///
    /// ```
    /// use certainty_control::{Braitenberg, Effort};
    ///
    /// let half = Effort::lit("-0.5");
    /// let behaviour = Braitenberg::<6>::new([half, half, Effort::ZERO]);
    /// // An object 3/4 near ahead on the left and one 1/4 near ahead on the right: it turns right.
    /// let near = [0.75, 0.0, 0.0, 0.0, 0.0, 0.25].map(Effort::from_num);
    /// assert_eq!(behaviour.turn(&near), Effort::lit("-0.25"));
    /// ```
    #[must_use]
    pub fn turn(&self, nearness: &[Effort; R]) -> Effort {
        let weighted = self.right.iter().zip(nearness);
        weighted.map(|(&weight, &near)| near * weight).sum()
    }
}

/// Returns `v_2R` of \[004\] eq. 12 for a goal that lies `goal` to the left of straight ahead; `v_2L` is
/// its opposite.
///
/// Formula: `β₂ (A − A_C)`, β₂ = 1/180°, the short way round. Range: ±1; a goal exactly behind is turned to
/// on the side `kept`.
///
/// The sign is for angles that count counter-clockwise, as all here do. For the azimuths of a compass, as
/// \[004\] eq. 10 yields them, eq. 12 as printed turns away from the goal.
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
pub fn azimuth_turn(goal: BinaryAngle, kept: Side) -> Effort {
    if goal == BinaryAngle::HALF {
        return kept.signed(Effort::ONE);
    }
    // Half a turn is 2^15 steps, full speed 2^16.
    let steps = i32::from(goal.to_bits().cast_signed());
    Effort::from_bits(steps.wrapping_mul(2))
}

/// Returns `v_3` of \[004\] eq. 13 from the turns `v_0R`, `v_1R` and `v_2R`; the same for both sides.
///
/// Formula: `1 − max(Σ v_R, Σ v_L)`, which is `1 − |Σ v_R|`, as each `v_L` is the opposite of its `v_R`.
///
/// Differs from \[004\] eq. 13 in that it is at least 0: three turns that add up to more than 1 would make
/// the robot back up, where no scanner looks.
///
/// ```
/// use certainty_control::{Effort, linear_speed};
///
/// let turns = [0.5, -0.25, 0.125].map(Effort::from_num);
/// assert_eq!(linear_speed(turns), Effort::lit("0.625"));
/// ```
#[must_use]
pub fn linear_speed(turns: [Effort; 3]) -> Effort {
    let sum: Effort = turns.into_iter().sum();
    (Effort::ONE - sum.abs()).max(Effort::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::transducer::Missing;

    fn behaviour() -> Braitenberg {
        Braitenberg::new([-0.5, -0.25, -0.125].map(Effort::from_num))
    }

    #[test]
    fn eq_5_by_hand() {
        let near = |reading| nearness(reading, Millimeters::new(1600)).map(Effort::to_num);
        for (mm, expected) in [
            (0, 1.0),
            (400, 0.75),
            (1200, 0.25),
            (1600, 0.0),
            (9000, 0.0),
        ] {
            let echo = Reading::Echo(Millimeters::new(mm));
            assert_eq!(near(echo), Some(expected), "{mm}");
        }
        assert_eq!(near(Reading::NoObject), Some(0.0));
        assert_eq!(near(Reading::TooNear), Some(1.0));
        assert_eq!(near(Reading::Missing(Missing::Timeout)), None);
    }

    #[test]
    fn a_default_distance_of_zero_makes_nothing_near() {
        let echo = Reading::Echo(Millimeters::new(3));
        assert_eq!(nearness(echo, Millimeters::ZERO), Some(Effort::ZERO));
    }

    #[test]
    fn eq_4_holds_for_all_twelve_weights() {
        let right = behaviour();
        let right = right.weights();
        for i in 0..3 {
            assert_eq!(right[i], -right[5 - i], "W(1,{}) = -W(1,{})", i + 1, 6 - i);
        }
        assert_eq!(right[0], Effort::lit("-0.5"));
    }

    #[test]
    fn eq_2_by_hand() {
        // −0.5·0.5 − 0.25·1 − 0.125·0.25 + 0.125·0 + 0.25·0.5 + 0.5·0.125 = −0.34375
        let near = [0.5, 1.0, 0.25, 0.0, 0.5, 0.125].map(Effort::from_num);
        assert_eq!(behaviour().turn(&near), Effort::lit("-0.34375"));
    }

    #[test]
    fn objects_alike_on_both_sides_cause_no_turn() {
        let near = [0.3, 0.77, 0.1, 0.1, 0.77, 0.3].map(Effort::from_num);
        assert_eq!(behaviour().turn(&near), Effort::ZERO);
    }

    #[test]
    fn two_rangefinders_are_enough() {
        let pair = Braitenberg::<2>::new([Effort::NEG_ONE]);
        let near = [Effort::HALF, Effort::ZERO];
        assert_eq!(pair.turn(&near), Effort::lit("-0.5"));
    }

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
            let turn: f64 = azimuth_turn(goal, Side::Left).to_num();
            assert_eq!(turn, expected, "{degrees}");
        }
    }

    #[test]
    fn a_turn_is_the_opposite_of_its_mirror_image() {
        for bits in 0..=u16::MAX {
            let goal = BinaryAngle::from_bits(bits);
            let mirrored = -goal;
            let turn = azimuth_turn(goal, Side::Left);
            assert_eq!(azimuth_turn(mirrored, Side::Right), -turn);
            assert!(turn.abs() <= Effort::ONE);
        }
    }

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
