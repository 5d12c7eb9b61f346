//! How comparisons between sensors change their confidence.

use super::confidence::Confidence;
use crate::certainty::Certainty;
use fixed::types::U0F16;

/// What a sensor claims of a cell: occupied or free.
///
/// The two claims have separate confidences, as \[001\] Table 1 has two error rates a sensor: it may
/// report an object that is not there, or miss one that is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Claim {
    /// There is an object.
    Occupied,
    /// There is no object.
    Free,
}

impl Claim {
    /// Returns the claim that `certainty` makes; *uncertain* counts as free.
    #[must_use]
    #[inline]
    pub const fn of(certainty: Certainty) -> Self {
        Self::of_deviation(certainty.deviation() as i32)
    }

    /// Returns the claim of a certainty with this deviation.
    #[inline]
    pub(crate) const fn of_deviation(deviation: i32) -> Self {
        if deviation > 0 {
            Self::Occupied
        } else {
            Self::Free
        }
    }
}

/// The size of a step of `inc` and `dec` of \[001\] Fig. 3.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StepRule {
    /// The same step at every confidence, which therefore reaches one of its bounds in the end.
    Fixed,
    /// A part of the distance to the bound: an exponential average, which settles at a value that
    /// depends on the sensor's share of agreements.
    Proportional,
}

/// Which confidences a comparison changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FaultAttribution {
    /// Both claims of both sensors by the same step: \[001\] Fig. 3.
    Alike,
    /// The claims that were made, and in a contradiction more for the sensor that is more likely wrong.
    ///
    /// - Two sensors that claim *occupied* were both right and neither missed the object: both
    ///   [`Claim`]s of both are raised. Two that claim *free* have only that claim raised.
    /// - Of two that contradict each other one is wrong: the one with confidence a in its claim, with
    ///   probability (1 − a) · b / ((1 − a) · b + (1 − b) · a), where b is the other's confidence. Each
    ///   falls by twice its probability times the step, so that two equal sensors fall by a step each.
    Shared,
}

/// How much a comparison changes a sensor's confidence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Learning {
    /// The step up if two sensors agree that a cell is occupied.
    ///
    /// Units: parts of full confidence with [`StepRule::Fixed`], else of the distance to the ceiling.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub raise: U0F16,
    /// The step up if two sensors agree that a cell is free.
    ///
    /// Each beam frees many cells and hits one, so that even a sensor that never detects an object agrees
    /// with the others about nearly every cell: agreement about a free cell is weak evidence. \[001\]
    /// Fig. 3 makes no difference; set this equal to [`Self::raise`] for it.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub raise_free: U0F16,
    /// The step down at a contradiction; more than [`Self::raise_free`].
    ///
    /// Units: parts of full confidence with [`StepRule::Fixed`], else of the confidence itself. Differs
    /// from \[002\] §4, where the step down is larger than the step up: that presumes that agreement is
    /// frequent, which is true only of free cells.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub lower: U0F16,
    /// What the steps are parts of.
    pub step_rule: StepRule,
    /// Which confidences a comparison changes.
    pub attribution: FaultAttribution,
    /// No confidence falls below this.
    pub floor: Confidence,
    /// No confidence rises above this.
    pub ceiling: Confidence,
}

/// The confidence in each of a sensor's claims.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Confidences {
    pub(super) occupied: Confidence,
    pub(super) free: Confidence,
}

impl Confidences {
    #[inline]
    const fn of(&mut self, claim: Claim) -> &mut Confidence {
        match claim {
            Claim::Occupied => &mut self.occupied,
            Claim::Free => &mut self.free,
        }
    }
}

impl Learning {
    /// Raises the confidences of two sensors that made the same claim.
    #[inline]
    pub(super) fn agree(&self, sides: [&mut Confidences; 2], claim: Claim) {
        let step = match claim {
            Claim::Occupied => self.raise,
            Claim::Free => self.raise_free,
        };
        // By default most comparisons: agreement about a free cell changes nothing.
        if step.to_bits() == 0 {
            return;
        }
        match self.step_rule {
            StepRule::Fixed => self.each(sides, claim, |confidence| {
                *confidence = confidence.raised(step, self.ceiling);
            }),
            StepRule::Proportional => self.each(sides, claim, |confidence| {
                // A product of two 16-bit numbers, at most `missing`.
                let missing = confidence.missing_to(self.ceiling);
                let step = u32::from(step.to_bits()).wrapping_mul(missing) >> 16;
                *confidence = confidence.up(step);
            }),
        }
    }

    /// Lowers the confidences of two sensors that made different claims.
    #[inline]
    pub(super) fn disagree(&self, [a, b]: [&mut Confidences; 2], [of_a, of_b]: [Claim; 2]) {
        match self.attribution {
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

    /// Applies `step` to both sensors' confidence in *free* and, if the comparison concerns it, in
    /// *occupied*.
    #[inline]
    fn each(&self, [a, b]: [&mut Confidences; 2], claim: Claim, step: impl Fn(&mut Confidence)) {
        step(&mut a.free);
        step(&mut b.free);
        if claim == Claim::Occupied || self.attribution == FaultAttribution::Alike {
            step(&mut a.occupied);
            step(&mut b.occupied);
        }
    }

    /// Returns the confidence lowered by a step of 16 bits, to the floor at least.
    #[inline]
    const fn lowered(&self, confidence: Confidence, step: u32) -> Confidence {
        let step = match self.step_rule {
            StepRule::Fixed => step,
            // A product of two 16-bit numbers.
            StepRule::Proportional => step.wrapping_mul(confidence.to_bits() as u32) >> 16,
        };
        let room = confidence.room_to(self.floor);
        confidence.down(if step > room { room } else { step })
    }

    /// Returns the steps down for a sensor with confidence `a` and for one with confidence `b`, 16 bits.
    ///
    /// The doubt in each is 1 − confidence + floor, which is zero only if the floor is and the
    /// confidence is full. Precision: 2^-12 of the step. Cost: two divisions.
    #[inline]
    const fn falls(&self, a: Confidence, b: Confidence) -> (u32, u32) {
        // Each a product of two 16-bit numbers.
        let a_wrong = self.doubt(a).wrapping_mul(b.to_bits() as u32);
        let b_wrong = self.doubt(b).wrapping_mul(a.to_bits() as u32);
        // Half the sum fits 32 bits where the sum may not.
        let half = (a_wrong >> 1).wrapping_add(b_wrong >> 1);
        (self.fall(a_wrong, half), self.fall(b_wrong, half))
    }

    /// Returns the step down times `wrong` / `half`, 16 bits.
    #[inline]
    const fn fall(&self, wrong: u32, half: u32) -> u32 {
        // At most 2, in steps of 2^-14.
        let share = match wrong.checked_div(half >> 14) {
            Some(share) if share < 2 << 14 => share,
            None if wrong == 0 => 1 << 14,
            _ => 2 << 14,
        };
        // A product of two 16-bit numbers.
        let fall = (self.lower.to_bits() as u32).wrapping_mul(share);
        let fall = fall.cast_signed() >> 14;
        if fall > u16::MAX as i32 {
            u16::MAX as u32
        } else {
            fall.cast_unsigned()
        }
    }

    /// Returns 1 − `confidence` + floor, 16 bits.
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
        step_rule: StepRule::Proportional,
        attribution: FaultAttribution::Shared,
        floor: Confidence::from_bits(1 << 10),
        ceiling: Confidence::FULL,
    };

    fn pair_of((occupied, free): (Confidence, Confidence)) -> Confidences {
        Confidences { occupied, free }
    }

    /// One sensor's confidences after an agreement with an equal one.
    fn agreed(rules: &Learning, pair: (Confidence, Confidence), claim: Claim) -> Confidences {
        let (mut own, mut other) = (pair_of(pair), pair_of(pair));
        rules.agree([&mut own, &mut other], claim);
        assert_eq!(own, other);
        own
    }

    /// One sensor's confidences after a contradiction by one with the confidence `other`.
    fn disagreed(
        rules: &Learning,
        pair: (Confidence, Confidence),
        claim: Claim,
        other: Confidence,
    ) -> Confidences {
        let opposite = match claim {
            Claim::Occupied => Claim::Free,
            Claim::Free => Claim::Occupied,
        };
        let (mut own, mut other) = (pair_of(pair), pair_of((other, other)));
        rules.disagree([&mut own, &mut other], [claim, opposite]);
        own
    }

    fn fall(own: Confidence, other: Confidence) -> u16 {
        u16::try_from(SHARED.falls(own, other).0).unwrap()
    }

    fn confidences() -> impl Iterator<Item = u16> + Clone {
        (1 << 10..=u16::MAX).step_by(251).chain([u16::MAX])
    }

    /// Twice the probability of being wrong by Bayes' rule, in real numbers.
    fn naive_share(own: u16, other: u16, floor: u16) -> f64 {
        let (own, other, floor) = (f64::from(own), f64::from(other), f64::from(floor));
        let wrong = (65_535.0 - own + floor) * other;
        let right = (65_535.0 - other + floor) * own;
        2.0 * wrong / (wrong + right)
    }

    #[test]
    fn a_contradiction_is_shared_by_bayes_rule() {
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
    fn equal_sensors_fall_by_one_step_each() {
        for bits in confidences() {
            let same = Confidence::from_bits(bits);
            let fall = fall(same, same);
            assert!(fall.abs_diff(1 << 12) <= 1, "{bits}: {fall}");
        }
        let (high, low) = (Confidence::from_bits(60_000), Confidence::from_bits(20_000));
        assert!(fall(low, high) > (1 << 12) + 1000);
        assert!(fall(high, low) < (1 << 12) - 1000);
    }

    #[test]
    fn a_contradiction_changes_only_the_claims_made() {
        let full = (Confidence::FULL, Confidence::FULL);
        let Confidences { occupied, free } =
            disagreed(&SHARED, full, Claim::Occupied, Confidence::FULL);
        assert!(occupied < Confidence::FULL);
        assert_eq!(free, Confidence::FULL);
        let Confidences { occupied, free } =
            disagreed(&SHARED, full, Claim::Free, Confidence::FULL);
        assert_eq!(occupied, Confidence::FULL);
        assert!(free < Confidence::FULL);
    }

    /// A sensor with a constant share of contradictions settles at the same confidence from every
    /// start; with fixed steps it would reach a bound.
    #[test]
    fn proportional_steps_settle_by_share_of_agreement() {
        let rules = Learning {
            raise: U0F16::from_bits(1 << 12),
            ..SHARED
        };
        let settle = |start: u16| {
            let mut pair = pair_of((Confidence::from_bits(start), Confidence::FULL));
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
        for step_rule in [StepRule::Fixed, StepRule::Proportional] {
            let rules = Learning {
                step_rule,
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

    /// The rules step by step, each sensor and each claim separately, in 64 bits.
    struct Naive(Learning);

    impl Naive {
        fn scaled(&self, step: u64, whole: u64) -> u64 {
            match self.0.step_rule {
                StepRule::Fixed => step,
                StepRule::Proportional => (step * whole) >> 16,
            }
        }

        fn concerns(&self, made: Claim, of: Claim) -> bool {
            self.0.attribution == FaultAttribution::Alike || made == of
        }

        fn raised(&self, bits: u64, step: u64) -> u64 {
            let ceiling = u64::from(self.0.ceiling.to_bits());
            let raised = bits + self.scaled(step, ceiling.saturating_sub(bits));
            if bits > ceiling {
                bits
            } else {
                raised.min(ceiling)
            }
        }

        fn lowered(&self, bits: u64, step: u64) -> u64 {
            let floor = u64::from(self.0.floor.to_bits());
            let lowered = bits.saturating_sub(self.scaled(step, bits));
            if bits < floor {
                bits
            } else {
                lowered.max(floor)
            }
        }

        fn agreed(&self, own: [u64; 2], claim: Claim) -> [u64; 2] {
            let step = match claim {
                Claim::Occupied => self.0.raise,
                Claim::Free => self.0.raise_free,
            };
            let step = u64::from(step.to_bits());
            let both = claim == Claim::Occupied;
            [(Claim::Occupied, own[0]), (Claim::Free, own[1])].map(|(of, bits)| {
                let concerned = both || self.concerns(claim, of);
                if concerned {
                    self.raised(bits, step)
                } else {
                    bits
                }
            })
        }

        fn fall(&self, own: u64, other: u64) -> u64 {
            let lower = u64::from(self.0.lower.to_bits());
            if self.0.attribution == FaultAttribution::Alike {
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

        fn disagreed(&self, own: [u64; 2], claim: Claim, other: u64) -> [u64; 2] {
            [(Claim::Occupied, own[0]), (Claim::Free, own[1])].map(|(of, bits)| {
                if self.concerns(claim, of) {
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

    fn any_claim() -> impl Strategy<Value = Claim> {
        prop_oneof![Just(Claim::Occupied), Just(Claim::Free)]
    }

    fn any_rules() -> impl Strategy<Value = Learning> {
        let kinds = any::<(bool, bool)>();
        (kinds, [bits(), bits(), bits(), bits(), bits()]).prop_map(
            |((fixed, alike), [raise, raise_free, lower, floor, ceiling])| Learning {
                raise: U0F16::from_bits(raise),
                raise_free: U0F16::from_bits(raise_free),
                lower: U0F16::from_bits(lower),
                step_rule: if fixed {
                    StepRule::Fixed
                } else {
                    StepRule::Proportional
                },
                attribution: if alike {
                    FaultAttribution::Alike
                } else {
                    FaultAttribution::Shared
                },
                floor: Confidence::from_bits(floor),
                ceiling: Confidence::from_bits(ceiling),
            },
        )
    }

    fn plain(pair: Confidences) -> [u64; 2] {
        [pair.occupied, pair.free].map(|confidence| confidence.to_bits().into())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        /// To the last bit for any rules, also those that no grid accepts.
        #[test]
        fn both_sensors_change_as_the_naive_rules_change_each(
            rules in any_rules(),
            confidences in [bits(), bits(), bits(), bits()],
            claims in [any_claim(), any_claim()],
        ) {
            let naive = Naive(rules);
            let [a, b, c, d] = confidences.map(Confidence::from_bits);
            let (one, two) = (pair_of((a, b)), pair_of((c, d)));

            let (mut own, mut other) = (one, two);
            rules.agree([&mut own, &mut other], claims[0]);
            prop_assert_eq!(plain(own), naive.agreed(plain(one), claims[0]));
            prop_assert_eq!(plain(other), naive.agreed(plain(two), claims[0]));

            let (mut own, mut other) = (one, two);
            let mut before = [one, two];
            let [of_one, of_two] =
                [0, 1].map(|side| u64::from(before[side].of(claims[side]).to_bits()));
            rules.disagree([&mut own, &mut other], claims);
            prop_assert_eq!(plain(own), naive.disagreed(plain(one), claims[0], of_two));
            prop_assert_eq!(plain(other), naive.disagreed(plain(two), claims[1], of_one));
        }
    }
}
