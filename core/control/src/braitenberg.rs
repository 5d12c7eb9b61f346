//! The Braitenberg behaviour on six rangefinders: \[004\] eq. 2 and 4.

use super::Effort;
use super::motion::scaled;

/// How many rangefinders there are, an even number.
pub const RANGEFINDERS: usize = 6;

/// One value a rangefinder, number 1 first.
///
/// The first three look to the left, number *i* the mirror image of number 7 − *i*: 1 and 6 ahead, 2
/// and 5 aside, 3 and 4 behind. \[004\] Fig. 1 numbers them so that eq. 4 can hold.
pub type PerRangefinder<T> = [T; RANGEFINDERS];

/// The weights `W` of \[004\] eq. 2.
///
/// Possession proves eq. 4: what a rangefinder gives one side's wheels it takes from the other's, and
/// its mirror image does the opposite. So three weights say all twelve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Braitenberg {
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    right: [Effort; 3],
}

impl Braitenberg {
    /// Creates the behaviour from `W_{1,1}`, `W_{1,2}` and `W_{1,3}`: what the rangefinders on the left
    /// give the right wheels; negative turns away from what they see.
    #[must_use]
    pub const fn new(right: [Effort; 3]) -> Self {
        Self { right }
    }

    /// Returns `W_{1,i}` for every rangefinder; `W_{2,i}` is its opposite.
    #[must_use]
    pub const fn weights(&self) -> PerRangefinder<Effort> {
        let [a, b, c] = self.right;
        [
            a,
            b,
            c,
            c.saturating_neg(),
            b.saturating_neg(),
            a.saturating_neg(),
        ]
    }

    /// Returns `v_0R` of \[004\] eq. 2, from each rangefinder's [nearness](super::nearness()); `v_0L` is
    /// its opposite.
    ///
    /// ```
    /// use certainty_control::{Braitenberg, Effort};
    ///
    /// let half = Effort::lit("-0.5");
    /// let behaviour = Braitenberg::new([half, half, Effort::ZERO]);
    /// // Something 3/4 near ahead on the left, 1/4 near ahead on the right: to the right.
    /// let near = [0.75, 0.0, 0.0, 0.0, 0.0, 0.25].map(Effort::from_num);
    /// assert_eq!(behaviour.turn(&near), Effort::lit("-0.25"));
    /// ```
    #[must_use]
    pub fn turn(&self, nearness: &PerRangefinder<Effort>) -> Effort {
        let weighted = self.weights().into_iter().zip(nearness);
        weighted.fold(Effort::ZERO, |sum, (weight, &near)| {
            sum.saturating_add(scaled(near, weight))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn behaviour() -> Braitenberg {
        Braitenberg::new([-0.5, -0.25, -0.125].map(Effort::from_num))
    }

    #[test]
    fn eq_4_holds_for_all_twelve() {
        let right = behaviour().weights();
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
    fn the_same_on_both_sides_does_not_turn() {
        let near = [0.3, 0.77, 0.1, 0.1, 0.77, 0.3].map(Effort::from_num);
        assert_eq!(behaviour().turn(&near), Effort::ZERO);
    }
}
