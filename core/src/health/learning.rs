//! How comparing sensors teaches how far each is to be believed.

use super::Confidence;
use crate::certainty::Certainty;
use crate::narrow::saturating_u16;
use fixed::types::U0F16;

/// What a sensor says of a cell, and so the way in which it can be wrong.
///
/// \[001\] Table 1 has two error rates a sensor for the same reason: it may see what is not there, or
/// overlook what is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Word {
    /// There is something.
    Occupied,
    /// There is nothing.
    Free,
}

impl Word {
    /// Returns the side of *uncertain* that `certainty` is on; *uncertain* itself counts as free.
    #[must_use]
    #[inline]
    pub const fn of(certainty: Certainty) -> Self {
        if certainty.deviation() > 0 {
            Self::Occupied
        } else {
            Self::Free
        }
    }
}

/// What `inc` and `dec` of \[001\] Fig. 3 take a step from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Stride {
    /// The same step wherever the confidence is: it runs to one of its bounds, sooner or later.
    Fixed,
    /// A part of the way to the bound ahead: an exponential average, which settles where a sensor's
    /// own share of agreement puts it, however long the run.
    Proportional,
}

/// Whom a comparison teaches what.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Blame {
    /// Both sides alike, whatever they said: \[001\] Fig. 3.
    Alike,
    /// Each side for what it said, and a contradiction more the side that is more likely wrong.
    ///
    /// - Two sensors that find a cell occupied were both right, and neither overlooked anything: both
    ///   [`Word`]s of both are raised. Two that find it free raise that word alone.
    /// - Of two that contradict each other one is wrong: the one, by its words so far, with probability
    ///   (1 − a) · b / ((1 − a) · b + (1 − b) · a), a and b being the confidences in the two words.
    ///   Twice this share of the step down is its own, so that two equal sides fall by a step each.
    Shared,
}

/// How far each comparison moves a sensor's confidence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Learning {
    /// How much it raises a confidence that two sensors agree on something occupied.
    ///
    /// Units: of full confidence where the stride is fixed, else of what is missing to the ceiling.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub raise: U0F16,
    /// How much it raises a confidence that two sensors agree on something free.
    ///
    /// Each beam frees many cells and hits one, so that even a sensor that never sees anything agrees
    /// with the others about nearly every cell: that two sensors find the same cell free says little of
    /// either. Equal to [`Self::raise`], it is \[001\] Fig. 3, which makes no difference.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub raise_free: U0F16,
    /// How much a contradiction lowers a confidence; more than [`Self::raise_free`].
    ///
    /// Units: of full confidence where the stride is fixed, else of the confidence itself. Differs from
    /// \[002\] §4, where confidence falls by larger steps than it rises by: that presumes that agreement
    /// is frequent, which it is only about what is free.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub lower: U0F16,
    /// What these are parts of.
    pub stride: Stride,
    /// Whom a comparison teaches what.
    pub blame: Blame,
    /// No confidence falls below this.
    pub floor: Confidence,
    /// No confidence rises above this.
    pub ceiling: Confidence,
}

impl Learning {
    /// Returns `confidence` after an agreement that raises it by `step`.
    #[inline]
    const fn raised(&self, confidence: Confidence, step: U0F16) -> Confidence {
        let step = match self.stride {
            Stride::Fixed => step,
            Stride::Proportional => {
                let missing = self.ceiling.to_bits().saturating_sub(confidence.to_bits());
                part(step, missing)
            }
        };
        confidence.raised(step, self.ceiling)
    }

    /// Returns the confidences in what is occupied and in what is free after agreeing on `word`.
    #[inline]
    pub(super) const fn agreed(
        &self,
        (occupied, free): (Confidence, Confidence),
        word: Word,
    ) -> (Confidence, Confidence) {
        let step = match word {
            Word::Occupied => self.raise,
            Word::Free => self.raise_free,
        };
        // What most comparisons are by default: nothing to be learned from.
        if step.to_bits() == 0 {
            return (occupied, free);
        }
        match (self.blame, word) {
            (Blame::Shared, Word::Free) => (occupied, self.raised(free, step)),
            (Blame::Shared, Word::Occupied) | (Blame::Alike, _) => {
                (self.raised(occupied, step), self.raised(free, step))
            }
        }
    }

    /// Returns the confidences after saying `word` where a sensor that is believed as far as `other`
    /// said the opposite.
    #[inline]
    pub(super) const fn disagreed(
        &self,
        (occupied, free): (Confidence, Confidence),
        word: Word,
        other: Confidence,
    ) -> (Confidence, Confidence) {
        match (self.blame, word) {
            (Blame::Alike, _) => (
                self.lowered(occupied, self.lower),
                self.lowered(free, self.lower),
            ),
            (Blame::Shared, Word::Occupied) => {
                (self.lowered(occupied, self.fall(occupied, other)), free)
            }
            (Blame::Shared, Word::Free) => (occupied, self.lowered(free, self.fall(free, other))),
        }
    }

    #[inline]
    const fn lowered(&self, confidence: Confidence, step: U0F16) -> Confidence {
        let step = match self.stride {
            Stride::Fixed => step,
            Stride::Proportional => part(step, confidence.to_bits()),
        };
        confidence.lowered(step, self.floor)
    }

    /// The step down for the side believed as far as `own`, against one believed as far as `other`.
    ///
    /// Doubt is 1 − confidence, raised by the floor so that nobody is beyond it: it is never zero, as
    /// no confidence at the floor or above is. Precision: 2^-12 of the step; one division.
    const fn fall(&self, own: Confidence, other: Confidence) -> U0F16 {
        let (wrong, right) = (self.doubt(own), self.doubt(other));
        // Each a product of two 16-bit numbers.
        let own_wrong = wrong.wrapping_mul(other.to_bits() as u32);
        let other_wrong = right.wrapping_mul(own.to_bits() as u32);
        // Half the sum fits 32 bits where the sum may not.
        let half = (own_wrong >> 1).wrapping_add(other_wrong >> 1);
        // Twice the share, at most 2, in steps of 2^-14.
        let share = match own_wrong.checked_div(half >> 14) {
            Some(share) if share < 2 << 14 => share,
            _ if own_wrong == 0 => 1 << 14,
            _ => 2 << 14,
        };
        // 16 bits and 16 bits.
        let fall = (self.lower.to_bits() as u32).wrapping_mul(share) >> 14;
        U0F16::from_bits(saturating_u16(fall))
    }

    const fn doubt(&self, confidence: Confidence) -> u32 {
        let certain = confidence.to_bits().saturating_sub(self.floor.to_bits());
        u16::MAX.saturating_sub(certain) as u32
    }
}

/// `step` of `bits`, rounded down.
const fn part(step: U0F16, bits: u16) -> U0F16 {
    // 16 bits and 16 bits; what is left after the shift are 16.
    let product = (step.to_bits() as u32).wrapping_mul(bits as u32);
    U0F16::from_bits(saturating_u16(product >> 16))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHARED: Learning = Learning {
        raise: U0F16::from_bits(1 << 14),
        raise_free: U0F16::ZERO,
        lower: U0F16::from_bits(1 << 12),
        stride: Stride::Proportional,
        blame: Blame::Shared,
        floor: Confidence::from_bits(1 << 10),
        ceiling: Confidence::FULL,
    };

    fn confidences() -> impl Iterator<Item = u16> + Clone {
        (1 << 10..=u16::MAX).step_by(251).chain([u16::MAX])
    }

    /// The share of the step that Bayes' rule gives, in real numbers, twice over.
    fn naive_share(own: u16, other: u16, floor: u16) -> f64 {
        let (own, other, floor) = (f64::from(own), f64::from(other), f64::from(floor));
        let wrong = (65_535.0 - own + floor) * other;
        let right = (65_535.0 - other + floor) * own;
        2.0 * wrong / (wrong + right)
    }

    #[test]
    fn blame_is_shared_as_bayes_rule_says() {
        for (own, other) in confidences().flat_map(|a| confidences().map(move |b| (a, b))) {
            let fall = SHARED.fall(Confidence::from_bits(own), Confidence::from_bits(other));
            let exact = 4096.0 * naive_share(own, other, 1 << 10);
            let error = (f64::from(fall.to_bits()) - exact).abs();
            assert!(
                error <= 1.0 + exact / 4096.0,
                "{own} against {other}: {fall:?}, {exact}"
            );
        }
    }

    #[test]
    fn equals_fall_by_one_step_each_and_the_doubted_one_by_more() {
        for bits in confidences() {
            let same = Confidence::from_bits(bits);
            let fall = SHARED.fall(same, same).to_bits();
            assert!(fall.abs_diff(1 << 12) <= 1, "{bits}: {fall}");
        }
        let (trusted, doubted) = (Confidence::from_bits(60_000), Confidence::from_bits(20_000));
        assert!(SHARED.fall(doubted, trusted).to_bits() > (1 << 12) + 1000);
        assert!(SHARED.fall(trusted, doubted).to_bits() < (1 << 12) - 1000);
    }

    #[test]
    fn a_contradiction_teaches_only_what_was_said() {
        let full = (Confidence::FULL, Confidence::FULL);
        let (occupied, free) = SHARED.disagreed(full, Word::Occupied, Confidence::FULL);
        assert!(occupied < Confidence::FULL);
        assert_eq!(free, Confidence::FULL);
        let (occupied, free) = SHARED.disagreed(full, Word::Free, Confidence::FULL);
        assert_eq!(occupied, Confidence::FULL);
        assert!(free < Confidence::FULL);
    }

    /// A sensor that is contradicted once in so many comparisons settles at the same confidence from
    /// wherever it comes; in fixed steps it would run to a bound.
    #[test]
    fn proportional_steps_settle_where_the_share_of_agreement_puts_them() {
        let rules = Learning {
            raise: U0F16::from_bits(1 << 12),
            ..SHARED
        };
        let settle = |start: u16| {
            let mut pair = (Confidence::from_bits(start), Confidence::FULL);
            for _ in 0..2000 {
                pair = rules.agreed(pair, Word::Occupied);
                pair = rules.disagreed(pair, Word::Occupied, pair.0);
            }
            f64::from(pair.0.to_bits()) / 65_536.0
        };
        // Up by a 16th of what is missing, down by a 16th of what is there: 15/31 after a fall.
        for start in [1 << 10, 1 << 15, u16::MAX] {
            assert!(
                (settle(start) - 15.0 / 31.0).abs() < 0.001,
                "{}",
                settle(start)
            );
        }
    }

    #[test]
    fn no_confidence_leaves_its_bounds() {
        for stride in [Stride::Fixed, Stride::Proportional] {
            let rules = Learning {
                stride,
                lower: U0F16::MAX,
                raise: U0F16::MAX,
                ..SHARED
            };
            for (own, other) in confidences().flat_map(|a| confidences().map(move |b| (a, b))) {
                let own = Confidence::from_bits(own);
                let down =
                    rules.disagreed((own, own), Word::Occupied, Confidence::from_bits(other));
                let up = rules.agreed((own, own), Word::Occupied);
                assert!(down.0 >= rules.floor && down.0 <= own);
                assert!(up.0 <= rules.ceiling && up.0 >= own);
            }
        }
    }
}
