//! How comparing sensors teaches how far each is to be believed.

use super::Confidence;
use crate::certainty::Certainty;
use fixed::types::U0F16;

/// What a sensor says of a cell, and so the way in which it can be wrong.
///
/// \[001\] Table 1 has two error rates a sensor for the same reason: it may see what is not there, or
/// overlook what is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Claim {
    /// There is something.
    Occupied,
    /// There is nothing.
    Free,
}

impl Claim {
    /// Returns the side of *uncertain* that `certainty` is on; *uncertain* itself counts as free.
    #[must_use]
    #[inline]
    pub const fn of(certainty: Certainty) -> Self {
        Self::of_deviation(certainty.deviation() as i32)
    }

    /// The same of a certainty's deviation.
    #[inline]
    pub(crate) const fn of_deviation(deviation: i32) -> Self {
        if deviation > 0 {
            Self::Occupied
        } else {
            Self::Free
        }
    }
}

/// What `inc` and `dec` of \[001\] Fig. 3 take a step from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StepRule {
    /// The same step wherever the confidence is: it runs to one of its bounds, sooner or later.
    Fixed,
    /// A part of the way to the bound ahead: an exponential average, which settles where a sensor's
    /// own share of agreement puts it, however long the run.
    Proportional,
}

/// Whom a comparison teaches what.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FaultAttribution {
    /// Both sides alike, whatever they said: \[001\] Fig. 3.
    Alike,
    /// Each side for what it said, and a contradiction more the side that is more likely wrong.
    ///
    /// - Two sensors that find a cell occupied were both right, and neither overlooked anything: both
    ///   [`Claim`]s of both are raised. Two that find it free raise that word alone.
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
    pub stride: StepRule,
    /// Whom a comparison teaches what.
    pub blame: FaultAttribution,
    /// No confidence falls below this.
    pub floor: Confidence,
    /// No confidence rises above this.
    pub ceiling: Confidence,
}

/// How far a sensor is believed, word by word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Beliefs {
    pub(super) occupied: Confidence,
    pub(super) free: Confidence,
}

impl Beliefs {
    #[inline]
    const fn of(&mut self, word: Claim) -> &mut Confidence {
        match word {
            Claim::Occupied => &mut self.occupied,
            Claim::Free => &mut self.free,
        }
    }
}

impl Learning {
    /// Teaches two sensors that they agreed on `word`.
    #[inline]
    pub(super) fn agree(&self, sides: [&mut Beliefs; 2], word: Claim) {
        let step = match word {
            Claim::Occupied => self.raise,
            Claim::Free => self.raise_free,
        };
        // What most comparisons are by default: nothing to be learned from.
        if step.to_bits() == 0 {
            return;
        }
        match self.stride {
            StepRule::Fixed => self.each(sides, word, |confidence| {
                *confidence = confidence.raised(step, self.ceiling);
            }),
            StepRule::Proportional => self.each(sides, word, |confidence| {
                // 16 bits and 16 bits; never more than what is missing.
                let missing = confidence.missing_to(self.ceiling);
                let step = u32::from(step.to_bits()).wrapping_mul(missing) >> 16;
                *confidence = confidence.up(step);
            }),
        }
    }

    /// Teaches two sensors that they contradicted each other, one saying the one word and the other
    /// the other.
    #[inline]
    pub(super) fn disagree(&self, [a, b]: [&mut Beliefs; 2], [of_a, of_b]: [Claim; 2]) {
        match self.blame {
            FaultAttribution::Alike => {
                let lower = self.lower.to_bits().into();
                self.each([a, b], Claim::Occupied, |confidence| {
                    *confidence = self.lowered(*confidence, lower);
                });
            }
            FaultAttribution::Shared => {
                let (a, b) = (a.of(of_a), b.of(of_b));
                let (fall_a, fall_b) = self.falls(*a, *b);
                *a = self.lowered(*a, fall_a);
                *b = self.lowered(*b, fall_b);
            }
        }
    }

    /// Teaches both sides about what is free and, unless `word` says nothing of it, about what is
    /// occupied.
    #[inline]
    fn each(&self, [a, b]: [&mut Beliefs; 2], word: Claim, teach: impl Fn(&mut Confidence)) {
        teach(&mut a.free);
        teach(&mut b.free);
        if word == Claim::Occupied || self.blame == FaultAttribution::Alike {
            teach(&mut a.occupied);
            teach(&mut b.occupied);
        }
    }

    /// The confidence lower by `step` of the stride, 16 bits, and no lower than the floor.
    #[inline]
    const fn lowered(&self, confidence: Confidence, step: u32) -> Confidence {
        let step = match self.stride {
            StepRule::Fixed => step,
            // 16 bits and 16 bits.
            StepRule::Proportional => step.wrapping_mul(confidence.to_bits() as u32) >> 16,
        };
        let room = confidence.room_to(self.floor);
        confidence.down(if step > room { room } else { step })
    }

    /// The steps down for a side believed as far as `a` and for one believed as far as `b`, 16 bits.
    ///
    /// Doubt is 1 − confidence, raised by the floor so that nobody is beyond it: it is never zero, as
    /// no confidence at the floor or above is. Precision: 2^-12 of the step; two divisions.
    #[inline]
    const fn falls(&self, a: Confidence, b: Confidence) -> (u32, u32) {
        // Each a product of two 16-bit numbers.
        let a_wrong = self.doubt(a).wrapping_mul(b.to_bits() as u32);
        let b_wrong = self.doubt(b).wrapping_mul(a.to_bits() as u32);
        // Half the sum fits 32 bits where the sum may not.
        let half = (a_wrong >> 1).wrapping_add(b_wrong >> 1);
        (self.fall(a_wrong, half), self.fall(b_wrong, half))
    }

    /// The step down for a side that is wrong in so many of `half` cases, twice over.
    #[inline]
    const fn fall(&self, wrong: u32, half: u32) -> u32 {
        // Twice the share, at most 2, in steps of 2^-14.
        let share = match wrong.checked_div(half >> 14) {
            Some(share) if share < 2 << 14 => share,
            None if wrong == 0 => 1 << 14,
            _ => 2 << 14,
        };
        // 16 bits and 16 bits.
        let fall = (self.lower.to_bits() as u32).wrapping_mul(share);
        let fall = fall.cast_signed() >> 14;
        if fall > u16::MAX as i32 {
            u16::MAX as u32
        } else {
            fall.cast_unsigned()
        }
    }

    #[inline]
    const fn doubt(&self, confidence: Confidence) -> u32 {
        (u16::MAX as u32).wrapping_sub(confidence.room_to(self.floor))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SHARED: Learning = Learning {
        raise: U0F16::from_bits(1 << 14),
        raise_free: U0F16::ZERO,
        lower: U0F16::from_bits(1 << 12),
        stride: StepRule::Proportional,
        blame: FaultAttribution::Shared,
        floor: Confidence::from_bits(1 << 10),
        ceiling: Confidence::FULL,
    };

    fn beliefs((occupied, free): (Confidence, Confidence)) -> Beliefs {
        Beliefs { occupied, free }
    }

    /// What one side takes from an agreement; the other side does not count.
    fn agreed(rules: &Learning, pair: (Confidence, Confidence), word: Claim) -> Beliefs {
        let (mut own, mut other) = (beliefs(pair), beliefs(pair));
        rules.agree([&mut own, &mut other], word);
        assert_eq!(own, other);
        own
    }

    /// What one side takes from a contradiction by one that is believed as far as `other`.
    fn disagreed(
        rules: &Learning,
        pair: (Confidence, Confidence),
        word: Claim,
        other: Confidence,
    ) -> Beliefs {
        let opposite = match word {
            Claim::Occupied => Claim::Free,
            Claim::Free => Claim::Occupied,
        };
        let (mut own, mut other) = (beliefs(pair), beliefs((other, other)));
        rules.disagree([&mut own, &mut other], [word, opposite]);
        own
    }

    fn fall(own: Confidence, other: Confidence) -> u16 {
        u16::try_from(SHARED.falls(own, other).0).unwrap()
    }

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
            let fall = fall(Confidence::from_bits(own), Confidence::from_bits(other));
            let exact = 4096.0 * naive_share(own, other, 1 << 10);
            let error = (f64::from(fall) - exact).abs();
            assert!(
                error <= 1.0 + exact / 4096.0,
                "{own} against {other}: {fall}, {exact}"
            );
        }
    }

    #[test]
    fn equals_fall_by_one_step_each_and_the_doubted_one_by_more() {
        for bits in confidences() {
            let same = Confidence::from_bits(bits);
            let fall = fall(same, same);
            assert!(fall.abs_diff(1 << 12) <= 1, "{bits}: {fall}");
        }
        let (trusted, doubted) = (Confidence::from_bits(60_000), Confidence::from_bits(20_000));
        assert!(fall(doubted, trusted) > (1 << 12) + 1000);
        assert!(fall(trusted, doubted) < (1 << 12) - 1000);
    }

    #[test]
    fn a_contradiction_teaches_only_what_was_said() {
        let full = (Confidence::FULL, Confidence::FULL);
        let Beliefs { occupied, free } =
            disagreed(&SHARED, full, Claim::Occupied, Confidence::FULL);
        assert!(occupied < Confidence::FULL);
        assert_eq!(free, Confidence::FULL);
        let Beliefs { occupied, free } = disagreed(&SHARED, full, Claim::Free, Confidence::FULL);
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
            let mut pair = beliefs((Confidence::from_bits(start), Confidence::FULL));
            for _ in 0..2000 {
                pair = agreed(&rules, (pair.occupied, pair.free), Claim::Occupied);
                let same = (pair.occupied, pair.free);
                pair = disagreed(&rules, same, Claim::Occupied, pair.occupied);
            }
            f64::from(pair.occupied.to_bits()) / 65_536.0
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
        for stride in [StepRule::Fixed, StepRule::Proportional] {
            let rules = Learning {
                stride,
                lower: U0F16::MAX,
                raise: U0F16::MAX,
                ..SHARED
            };
            for (own, other) in confidences().flat_map(|a| confidences().map(move |b| (a, b))) {
                let own = Confidence::from_bits(own);
                let other = Confidence::from_bits(other);
                let down = disagreed(&rules, (own, own), Claim::Occupied, other).occupied;
                let up = agreed(&rules, (own, own), Claim::Occupied).occupied;
                assert!(down >= rules.floor && down <= own);
                assert!(up <= rules.ceiling && up >= own);
            }
        }
    }

    /// The rules step by step, each sensor and each word for itself, in 64 bits.
    struct Naive(Learning);

    impl Naive {
        fn stride(&self, step: u64, whole: u64) -> u64 {
            match self.0.stride {
                StepRule::Fixed => step,
                StepRule::Proportional => (step * whole) >> 16,
            }
        }

        fn teaches(&self, said: Claim, of: Claim) -> bool {
            self.0.blame == FaultAttribution::Alike || said == of
        }

        fn raised(&self, bits: u64, step: u64) -> u64 {
            let ceiling = u64::from(self.0.ceiling.to_bits());
            let raised = bits + self.stride(step, ceiling.saturating_sub(bits));
            if bits > ceiling {
                bits
            } else {
                raised.min(ceiling)
            }
        }

        fn lowered(&self, bits: u64, step: u64) -> u64 {
            let floor = u64::from(self.0.floor.to_bits());
            let lowered = bits.saturating_sub(self.stride(step, bits));
            if bits < floor {
                bits
            } else {
                lowered.max(floor)
            }
        }

        fn agreed(&self, own: [u64; 2], word: Claim) -> [u64; 2] {
            let step = match word {
                Claim::Occupied => self.0.raise,
                Claim::Free => self.0.raise_free,
            };
            let step = u64::from(step.to_bits());
            let both = word == Claim::Occupied;
            [(Claim::Occupied, own[0]), (Claim::Free, own[1])].map(|(of, bits)| {
                let taught = both || self.teaches(word, of);
                if taught {
                    self.raised(bits, step)
                } else {
                    bits
                }
            })
        }

        fn fall(&self, own: u64, other: u64) -> u64 {
            let lower = u64::from(self.0.lower.to_bits());
            if self.0.blame == FaultAttribution::Alike {
                return lower;
            }
            let floor = u64::from(self.0.floor.to_bits());
            let doubt = |bits: u64| 65_535 - bits.saturating_sub(floor);
            let (wrong, right) = (doubt(own) * other, doubt(other) * own);
            let share = match wrong.checked_div((wrong / 2 + right / 2) >> 14) {
                Some(share) => share.min(2 << 14),
                None if wrong == 0 => 1 << 14,
                None => 2 << 14,
            };
            ((lower * share) >> 14).min(65_535)
        }

        fn disagreed(&self, own: [u64; 2], word: Claim, other: u64) -> [u64; 2] {
            [(Claim::Occupied, own[0]), (Claim::Free, own[1])].map(|(of, bits)| {
                if self.teaches(word, of) {
                    self.lowered(bits, self.fall(bits, other))
                } else {
                    bits
                }
            })
        }
    }

    /// A number of 16 bits, the bounds more often than any other.
    fn bits() -> impl Strategy<Value = u16> {
        prop_oneof![
            4 => any::<u16>(),
            2 => 0..=3_u16,
            2 => u16::MAX - 3..=u16::MAX,
            1 => (1 << 15) - 1..=(1 << 15) + 1_u16,
        ]
    }

    fn word() -> impl Strategy<Value = Claim> {
        prop_oneof![Just(Claim::Occupied), Just(Claim::Free)]
    }

    fn any_rules() -> impl Strategy<Value = Learning> {
        let kinds = any::<(bool, bool)>();
        (kinds, [bits(), bits(), bits(), bits(), bits()]).prop_map(
            |((fixed, alike), [raise, raise_free, lower, floor, ceiling])| Learning {
                raise: U0F16::from_bits(raise),
                raise_free: U0F16::from_bits(raise_free),
                lower: U0F16::from_bits(lower),
                stride: if fixed {
                    StepRule::Fixed
                } else {
                    StepRule::Proportional
                },
                blame: if alike {
                    FaultAttribution::Alike
                } else {
                    FaultAttribution::Shared
                },
                floor: Confidence::from_bits(floor),
                ceiling: Confidence::from_bits(ceiling),
            },
        )
    }

    fn plain(beliefs: Beliefs) -> [u64; 2] {
        [beliefs.occupied, beliefs.free].map(|confidence| confidence.to_bits().into())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        /// To the last bit, whatever the rules, those that no grid accepts among them.
        #[test]
        fn two_sides_learn_at_once_what_each_would_learn_for_itself(
            rules in any_rules(),
            confidences in [bits(), bits(), bits(), bits()],
            words in [word(), word()],
        ) {
            let naive = Naive(rules);
            let [a, b, c, d] = confidences.map(Confidence::from_bits);
            let (one, two) = (beliefs((a, b)), beliefs((c, d)));

            let (mut own, mut other) = (one, two);
            rules.agree([&mut own, &mut other], words[0]);
            prop_assert_eq!(plain(own), naive.agreed(plain(one), words[0]));
            prop_assert_eq!(plain(other), naive.agreed(plain(two), words[0]));

            let (mut own, mut other) = (one, two);
            let mut said = [one, two];
            let [of_one, of_two] =
                [0, 1].map(|side| u64::from(said[side].of(words[side]).to_bits()));
            rules.disagree([&mut own, &mut other], words);
            prop_assert_eq!(plain(own), naive.disagreed(plain(one), words[0], of_two));
            prop_assert_eq!(plain(other), naive.disagreed(plain(two), words[1], of_one));
        }
    }
}
