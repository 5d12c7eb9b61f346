//! Which sensors have failed (**F** of \[004\] §3), and what that leaves: credibility and coverage.

use crate::motion::Effort;
use crate::sensors::RANGEFINDERS;
use certainty_core::health::{Confidence, Health, HealthRules, Status};
use certainty_core::transducer::Reading;

/// Sensors of \[004\]'s robot: the rangefinders in the order of their numbers, then the scanner.
pub const SENSORS: usize = RANGEFINDERS + 1;

/// How far something has failed: φ, from 0 (sound) to 1 (failed).
///
/// \[004\] has only 0 and 1. Values between them are failures that are diagnosed but not certain.
///
/// Possession proves that it is within 0..=1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Failure(Effort);

impl Failure {
    /// Sound.
    pub const NONE: Self = Self(Effort::ZERO);
    /// Failed.
    pub const TOTAL: Self = Self(Effort::ONE);

    /// Creates the failure φ = `part`; saturates at 0 and 1.
    #[must_use]
    pub const fn new_saturating(part: Effort) -> Self {
        let bits = part.to_bits();
        if bits <= 0 {
            Self::NONE
        } else if bits >= Effort::ONE.to_bits() {
            Self::TOTAL
        } else {
            Self(part)
        }
    }

    /// Returns φ.
    #[must_use]
    pub const fn part(self) -> Effort {
        self.0
    }

    /// Returns the trust that is left: 1 − φ.
    #[must_use]
    pub fn trust(self) -> Effort {
        Effort::ONE - self.0
    }

    /// Returns whether φ is at least a half.
    #[must_use]
    pub const fn is_failed(self) -> bool {
        self.0.to_bits() >= Effort::HALF.to_bits()
    }

    /// Returns the failure that a sensor's health stands for, by the limits of [`HealthRules`].
    ///
    /// Formula: *failed* or stale is 1; else 0 from the confidence of a healthy sensor upwards, 1 from
    /// that of a failed one downwards, linear between; a *recovering* sensor is at least half.
    #[must_use]
    pub fn of_health(health: &Health) -> Self {
        let failure = Self::of_confidence(health.confidence());
        match health.status() {
            _ if health.is_stale() => Self::TOTAL,
            Status::Failed => Self::TOTAL,
            Status::Recovering => failure.max(Self(Effort::HALF)),
            Status::Healthy | Status::Suspect => failure,
        }
    }

    /// The fraction of the way from a healthy to a failed confidence.
    fn of_confidence(confidence: Confidence) -> Self {
        let high = HealthRules::HEALTHY_FROM.to_bits();
        let below = i32::from(high.saturating_sub(confidence.to_bits()));
        let span = i32::from(high.saturating_sub(HealthRules::FAILED_BELOW.to_bits()));
        Self(Effort::fraction(below, span))
    }
}

/// One flag per sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SensorFlags<const R: usize = RANGEFINDERS> {
    /// The rangefinders' flags.
    pub rangefinders: [bool; R],
    /// The scanner's flag.
    pub scanner: bool,
}

impl<const R: usize> SensorFlags<R> {
    /// No sensor is flagged.
    pub const NONE: Self = Self {
        rangefinders: [false; R],
        scanner: false,
    };

    /// Every sensor is flagged.
    pub const ALL: Self = Self {
        rangefinders: [true; R],
        scanner: true,
    };

    /// Returns the flags in the order of the sensors' numbers: the rangefinders, then the scanner.
    pub fn iter(&self) -> impl Iterator<Item = bool> + '_ {
        self.rangefinders.iter().copied().chain([self.scanner])
    }

    /// Returns the flags for writing, in the same order.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut bool> {
        self.rangefinders.iter_mut().chain([&mut self.scanner])
    }
}

/// **F** of \[004\] §3: the failure of each sensor.
///
/// Where it comes from is open: an operator (*given*, as in \[004\]), the fusion level's [`Health`], a
/// [`CrossCheck`](crate::CrossCheck), a check of single readings. [`Self::worst`] combines two sources.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Failures<const R: usize = RANGEFINDERS> {
    /// `φ_1` to `φ_R`.
    pub rangefinders: [Failure; R],
    /// `φ_s`.
    pub scanner: Failure,
}

impl<const R: usize> Failures<R> {
    /// No sensor has failed.
    pub const NONE: Self = Self {
        rangefinders: [Failure::NONE; R],
        scanner: Failure::NONE,
    };

    /// Every sensor has.
    pub const ALL: Self = Self {
        rangefinders: [Failure::TOTAL; R],
        scanner: Failure::TOTAL,
    };

    /// Returns the failures that the `health` of sensors 1, 2 and so on stands for; the scanner is number
    /// `R` + 1. A sensor that is not listed is sound.
    #[must_use]
    pub fn of_health<'a>(health: impl IntoIterator<Item = &'a Health>) -> Self {
        let mut failures = Self::NONE;
        for (failure, health) in failures.iter_mut().zip(health) {
            *failure = Failure::of_health(health);
        }
        failures
    }

    /// Returns the failures in the order of the sensors' numbers: the rangefinders, then the scanner.
    pub fn iter(&self) -> impl Iterator<Item = Failure> + '_ {
        self.rangefinders.iter().copied().chain([self.scanner])
    }

    /// Returns the failures for writing, in the same order.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Failure> {
        self.rangefinders.iter_mut().chain([&mut self.scanner])
    }

    /// Returns which sensors have failed by at least a half.
    #[must_use]
    pub fn failed(&self) -> SensorFlags<R> {
        let mut flags = SensorFlags::NONE;
        for (flag, failure) in flags.iter_mut().zip(self.iter()) {
            *flag = failure.is_failed();
        }
        flags
    }

    /// Returns these failures with each sensor that sends nothing now as failed: rangefinders whose reading
    /// is *missing*, and the scanner without a `scan` or by the part of its beams that are missing.
    ///
    /// Formula: the scanner's trust is `1 − φ` times the fraction of beams that are present in the right, the
    /// middle or the left third of its field, whichever is least: beams to both sides do not make up for
    /// missing ones ahead.
    #[must_use]
    pub fn or_missing<const B: usize>(
        mut self,
        rangefinders: &[Reading; R],
        scan: Option<&[Reading; B]>,
    ) -> Self {
        for (failure, reading) in self.rangefinders.iter_mut().zip(rangefinders) {
            if matches!(reading, Reading::Missing(_)) {
                *failure = Failure::TOTAL;
            }
        }
        let trust = scan.map_or(Effort::ZERO, |scan| self.scanner.trust() * present(scan));
        self.scanner = Failure::new_saturating(Effort::ONE - trust);
        self
    }

    /// Returns, sensor by sensor, the larger failure of the two.
    #[must_use]
    pub fn worst(self, other: Self) -> Self {
        let mut failures = self;
        for (own, others) in failures.iter_mut().zip(other.iter()) {
            *own = others.max(*own);
        }
        failures
    }
}

impl<const R: usize> Default for Failures<R> {
    fn default() -> Self {
        Self::NONE
    }
}

/// The fraction of beams that are present in the third of the field in which fewest are.
fn present<const B: usize>(scan: &[Reading; B]) -> Effort {
    // Of 101 beams 34, 33 and 34: as many to the right as to the left.
    let side = B.div_ceil(3);
    let middle = B.saturating_sub(side).saturating_sub(side);
    let part = |first: usize, count: usize| {
        let beams = scan.iter().skip(first).take(count);
        let (present, all) = beams.fold((0_i32, 0_i32), |(present, all), reading| {
            let is_present = !matches!(reading, Reading::Missing(_));
            (
                present.saturating_add(is_present.into()),
                all.saturating_add(1),
            )
        });
        Effort::fraction(present, all)
    };
    part(0, side)
        .min(part(side, middle))
        .min(part(side.saturating_add(middle), side))
}

/// How far each behaviour's output counts: μ of \[004\] eq. 1, eq. 14 and 15.
///
/// Range: 0..=1 each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Credibility {
    /// μ₀: the Braitenberg behaviour.
    pub braitenberg: Effort,
    /// μ₁: the histogram's.
    pub histogram: Effort,
    /// μ₂ and μ₃: turning to the goal and going ahead.
    pub goal: Effort,
}

/// The constants of \[004\] eq. 14 for `R` rangefinders, in Q32: those that make μ₀ 1 for no failure and 0
/// for all.
///
/// With √ = √(R² + 4R): `c_1` = (√ − R) / 2 and `c_2` = −2 / (R + √). For six they are the paper's −3 + √15
/// and −1 / (3 + √15).
struct Eq14<const R: usize>;

impl<const R: usize> Eq14<R> {
    /// R in Q40, and √(R² + 4R).
    const TERMS_Q40: (u128, u128) = {
        assert!(R >= 1 && R <= 254, "from 1 to 254 rangefinders");
        let number = R as u128;
        (number << 40, ((number * number + 4 * number) << 80).isqrt())
    };

    #[expect(clippy::cast_possible_truncation, reason = "below 2^32")]
    const C1_Q32: i64 = {
        let (number, root) = Self::TERMS_Q40;
        ((root - number + (1 << 8)) >> 9) as i64
    };

    #[expect(clippy::cast_possible_truncation, reason = "below 2^32")]
    const C2_Q32: i64 = {
        let (number, root) = Self::TERMS_Q40;
        let divisor = number + root;
        -((((1 << 73) + divisor / 2) / divisor) as i64)
    };

    /// Eq. 14 for a sum of failures: `1 / (Σ φ_i + c₁) + c₂`, rounded to the nearest.
    fn credibility(sum: Effort) -> Effort {
        const Q48: i64 = 1 << 48;
        // For six, 0.87 to 6.87 in Q32, whose inverse in Q16 is 2^48 over it; 8 bits more to round them once.
        let divisor = (i64::from(sum.to_bits()) << 16).saturating_add(Self::C1_Q32);
        let inverse = (Q48 << 8).checked_div(divisor).unwrap_or(0);
        let exact = inverse.saturating_add(Self::C2_Q32 >> 8);
        let rounded = exact.saturating_add(1 << 7) >> 8;
        let bits = i32::try_from(rounded).unwrap_or(i32::MAX);
        Effort::from_bits(bits).limited(Effort::ZERO, Effort::ONE)
    }
}

impl Credibility {
    /// Returns the credibility of each behaviour when sensors have failed.
    ///
    /// Formula (\[004\] eq. 14, 15): `μ₀ = 1 / (Σ φ_i + c₁) + c₂`, `μ₁ = 1 − φ_s`,
    /// `μ₂ = μ₃ = 1 − φ_s Π φ_i`, over the rangefinders. Rounds to the nearest; exactly 1 for no failure, 0
    /// for all.
    ///
    /// Differs from \[004\] in that φ may lie between 0 and 1; at the ends it is \[004\].
    ///
    /// ```
    /// use certainty_control::{Credibility, Failures, Effort};
    ///
    /// assert_eq!(Credibility::of::<6>(&Failures::NONE).braitenberg, Effort::ONE);
    /// assert_eq!(Credibility::of::<6>(&Failures::ALL).goal, Effort::ZERO);
    /// ```
    #[must_use]
    pub fn of<const R: usize>(failures: &Failures<R>) -> Self {
        let parts = failures.rangefinders.map(Failure::part);
        // Pair by pair, so that left and right are rounded alike.
        let pairs = parts.iter().zip(parts.iter().rev()).take(R >> 1);
        let product = pairs.fold(failures.scanner.part(), |product, (&left, &right)| {
            product * (left * right)
        });
        Self {
            braitenberg: Eq14::<R>::credibility(parts.into_iter().sum()),
            histogram: failures.scanner.trust(),
            goal: Effort::ONE - product,
        }
    }
}

/// What part of what lies ahead each sensor sees, and how much must be seen.
///
/// \[004\] has no such rule in its simulations; in its experiments it drove slower by hand, "especially
/// in case of laser scanner failure" (§5).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CoverageConfig<const R: usize = RANGEFINDERS> {
    /// The part that each rangefinder sees of what a robot at full speed must see; the first half looks to
    /// the left, as in \[004\] eq. 4.
    pub rangefinders: [Effort; R],
    /// The part that the scanner sees.
    pub scanner: Effort,
    /// The robot stands still if less than this is seen.
    pub least: Effort,
}

/// How much of what lies ahead is seen: 1 is enough for full speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Coverage(Effort);

impl Coverage {
    /// Computes the coverage from each sensor's trust (1 − failure; 0 if it sends nothing).
    ///
    /// Formula: the scanner's part · trust, and twice Σ part · trust of the rangefinders on the side that
    /// sees less, at most 1. What is seen on the right does not help against an obstacle on the left.
    #[must_use]
    pub fn of<const R: usize>(
        config: &CoverageConfig<R>,
        trust: &[Effort; R],
        scanner: Effort,
    ) -> Self {
        let seen = || (config.rangefinders.iter().zip(trust)).map(|(&part, &trust)| trust * part);
        let half = R >> 1;
        let left: Effort = seen().take(half).sum();
        let right: Effort = seen().skip(half).sum();
        let weaker = left.min(right);
        let seen = scanner * config.scanner + (weaker + weaker);
        Self(seen.limited(Effort::ZERO, Effort::ONE))
    }

    /// Returns the part, 0..=1.
    #[must_use]
    pub const fn part(self) -> Effort {
        self.0
    }

    /// Returns the highest speed allowed: the covered part of full speed, 0 below the least coverage.
    #[must_use]
    pub fn fastest<const R: usize>(self, config: &CoverageConfig<R>) -> Effort {
        if self.0 < config.least {
            Effort::ZERO
        } else {
            self.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::BEAMS;
    use certainty_core::transducer::Missing;
    use certainty_core::units::Ticks;

    const MISSING: Reading = Reading::Missing(Missing::Timeout);
    const OPEN: [Reading; BEAMS] = [Reading::NoObject; BEAMS];

    fn part(health: &Health) -> f64 {
        Failure::of_health(health).part().to_num()
    }

    #[test]
    fn confidence_drives_the_failure_continuously() {
        for (bits, expected) in [
            (u16::MAX, 0.0),
            (1 << 15, 0.0),
            (((1 << 15) + 9830) / 2, 0.5),
            (9830 + 3823, 5.0 / 6.0), // of 22,938 steps between the limits
            (9830, 1.0),
            (0, 1.0),
        ] {
            let health = Health::new(Confidence::from_bits(bits));
            let part = part(&health);
            assert!((part - expected).abs() < 1e-4, "{bits}: {part}");
        }
    }

    #[test]
    fn a_missing_sensor_has_failed_at_any_confidence() {
        let rules = HealthRules::DEFAULT;
        let mut health = Health::default();
        for _ in 0..HealthRules::FAILED_MISSING {
            health.record(MISSING, Ticks::new(0));
            health.settle(&rules, Ticks::new(0));
        }
        assert_eq!(part(&health), 1.0);
        // One reading later it is recovering, and trusted by half at most.
        health.record(Reading::NoObject, Ticks::new(1));
        health.settle(&rules, Ticks::new(1));
        assert_eq!(part(&health), 0.5);
    }

    #[test]
    fn the_seventh_health_is_the_scanners() {
        let mut health = [Health::default(); SENSORS];
        health[6] = Health::new(Confidence::NONE);
        let failures = Failures::of_health(&health);
        assert_eq!(failures.scanner, Failure::TOTAL);
        assert_eq!(failures.rangefinders, [Failure::NONE; RANGEFINDERS]);
        assert_eq!(failures.worst(Failures::NONE), failures);
        assert_eq!(failures.worst(Failures::ALL), Failures::ALL);
    }

    #[test]
    fn a_sensor_that_sends_nothing_has_failed_for_now() {
        let mut readings = [Reading::NoObject; RANGEFINDERS];
        assert_eq!(
            Failures::NONE.or_missing(&readings, Some(&OPEN)),
            Failures::NONE
        );
        readings[4] = MISSING;
        let mut expected = Failures::NONE;
        expected.rangefinders[4] = Failure::TOTAL;
        assert_eq!(Failures::NONE.or_missing(&readings, Some(&OPEN)), expected);
        expected.scanner = Failure::TOTAL;
        let no_scan: Option<&[Reading; BEAMS]> = None;
        assert_eq!(Failures::NONE.or_missing(&readings, no_scan), expected);
        assert_eq!(
            Failures::ALL.or_missing(&readings, Some(&OPEN)),
            Failures::ALL
        );
    }

    /// By hand: of 34 beams on a side and 33 in the middle.
    #[test]
    fn a_scanner_counts_as_its_worst_third() {
        let left = |silent: core::ops::Range<usize>| -> f64 {
            let mut scan = [Reading::NoObject; BEAMS];
            scan[silent].fill(MISSING);
            let readings = [Reading::NoObject; RANGEFINDERS];
            let failures = Failures::NONE.or_missing(&readings, Some(&scan));
            failures.scanner.trust().to_num()
        };
        assert_eq!(left(0..17), 0.5);
        assert_eq!(left(84..101), 0.5);
        assert_eq!((left(0..34), left(34..67), left(67..101)), (0.0, 0.0, 0.0));
        assert!((left(34..45) - 2.0 / 3.0).abs() < 1e-4);
        // Half of the beams of a scanner that is half trusted.
        let half = Failures {
            scanner: Failure::new_saturating(Effort::HALF),
            ..Failures::NONE
        };
        let mut scan = [Reading::NoObject; BEAMS];
        scan[..17].fill(MISSING);
        let readings = [Reading::NoObject; RANGEFINDERS];
        let failures = half.or_missing(&readings, Some(&scan));
        assert_eq!(failures.scanner.part(), Effort::lit("0.75"));
    }

    #[test]
    fn failed_is_from_a_half_on() {
        assert!(Failure::TOTAL.is_failed() && !Failure::NONE.is_failed());
        assert!(Failure::new_saturating(Effort::HALF).is_failed());
        assert!(!Failure::new_saturating(Effort::HALF - Effort::DELTA).is_failed());
    }

    #[test]
    fn a_failure_saturates_at_both_ends() {
        assert_eq!(Failure::new_saturating(Effort::MAX), Failure::TOTAL);
        assert_eq!(Failure::new_saturating(Effort::MIN), Failure::NONE);
    }

    /// The flags in the order of the sensors' numbers.
    #[test]
    fn flags_are_set_from_a_half_on() {
        let mut failures: Failures = Failures::NONE;
        assert_eq!(failures.failed(), SensorFlags::NONE);
        failures.rangefinders[2] = Failure::new_saturating(Effort::HALF);
        failures.scanner = Failure::new_saturating(Effort::lit("0.49"));
        let expected = [false, false, true, false, false, false, false];
        assert!(failures.failed().iter().eq(expected));
        let all: Failures = Failures::ALL;
        assert_eq!(all.failed(), SensorFlags::ALL);
    }

    fn failed(rangefinders: usize, scanner: bool) -> Credibility {
        let mut failures = Failures::<6>::NONE;
        failures.rangefinders[..rangefinders].fill(Failure::TOTAL);
        if scanner {
            failures.scanner = Failure::TOTAL;
        }
        Credibility::of(&failures)
    }

    #[test]
    fn the_constants_are_the_papers() {
        let root = 15.0_f64.sqrt();
        let q32 = 4_294_967_296.0;
        assert!(((root - 3.0) * q32 - Eq14::<6>::C1_Q32 as f64).abs() <= 0.5);
        assert!((-1.0 / (3.0 + root) * q32 - Eq14::<6>::C2_Q32 as f64).abs() <= 0.5);
    }

    /// By hand, with √15 = 3.872983: 1/1.872983 − 0.145497 = 0.388410 for one failure, and so on.
    #[test]
    fn eq_14_by_hand() {
        let expected = [
            1.0, 0.388_410, 0.202_573, 0.112_702, 0.059_725, 0.024_776, 0.0,
        ];
        for (failures, expected) in expected.into_iter().enumerate() {
            let ours: f64 = failed(failures, false).braitenberg.to_num();
            assert!(
                (ours - expected).abs() < 1e-5,
                "{failures}: {ours} {expected}"
            );
        }
        assert_eq!(failed(0, false).braitenberg, Effort::ONE);
        assert_eq!(failed(6, false).braitenberg, Effort::ZERO);
    }

    #[test]
    fn eq_15_by_hand() {
        assert_eq!(failed(0, true).histogram, Effort::ZERO);
        assert_eq!(failed(6, false).histogram, Effort::ONE);
        assert_eq!(failed(5, true).goal, Effort::ONE);
        assert_eq!(failed(6, false).goal, Effort::ONE);
        assert_eq!(failed(6, true).goal, Effort::ZERO);
    }

    #[test]
    fn no_failure_leaves_full_credibility() {
        let all = Credibility {
            braitenberg: Effort::ONE,
            histogram: Effort::ONE,
            goal: Effort::ONE,
        };
        assert_eq!(Credibility::of(&Failures::<6>::NONE), all);
    }

    #[test]
    fn more_failure_never_raises_credibility() {
        let of = |bits: i32| {
            let half = Failure::new_saturating(Effort::from_bits(bits));
            Credibility::of(&Failures {
                rangefinders: [half; 6],
                scanner: half,
            })
        };
        for bits in (0..65536).step_by(7) {
            let (less, more) = (of(bits), of(bits + 7));
            assert!(more.braitenberg <= less.braitenberg && more.goal <= less.goal);
            assert!((Effort::ZERO..=Effort::ONE).contains(&more.braitenberg));
        }
    }

    #[test]
    fn any_number_of_rangefinders_goes_from_one_to_zero() {
        fn check<const R: usize>() {
            let sound = Credibility::of(&Failures::<R>::NONE);
            let failed = Credibility::of(&Failures::<R>::ALL);
            assert_eq!(sound.braitenberg, Effort::ONE, "{R}");
            assert_eq!(failed.braitenberg, Effort::ZERO, "{R}");
        }
        check::<2>();
        check::<4>();
        check::<8>();
        check::<16>();
    }

    fn config() -> CoverageConfig {
        CoverageConfig {
            rangefinders: [0.25, 0.125, 0.0, 0.0, 0.125, 0.25].map(Effort::from_num),
            scanner: Effort::ONE,
            least: Effort::lit("0.25"),
        }
    }

    fn fastest(trust: [f64; 6], scanner: f64) -> f64 {
        let coverage = Coverage::of(
            &config(),
            &trust.map(Effort::from_num),
            Effort::from_num(scanner),
        );
        coverage.fastest(&config()).to_num()
    }

    #[test]
    fn one_dead_sensor_does_not_stop_the_robot() {
        for dead in 0..6 {
            let mut trust = [1.0; 6];
            trust[dead] = 0.0;
            assert_eq!(fastest(trust, 1.0), 1.0, "rangefinder {}", dead + 1);
        }
        assert_eq!(fastest([1.0; 6], 0.0), 0.75);
    }

    #[test]
    fn one_side_does_not_make_up_for_the_other() {
        assert_eq!(fastest([1.0, 1.0, 1.0, 0.0, 0.0, 0.0], 0.0), 0.0);
        assert_eq!(fastest([0.0, 0.0, 0.0, 1.0, 1.0, 1.0], 0.5), 0.5);
    }

    #[test]
    fn too_little_coverage_slows_and_then_stops_it() {
        // 2 · (0.25 / 2 + 0.125), and 2 · 0.125 with one or both that look ahead failed.
        assert_eq!(fastest([0.5, 1.0, 1.0, 1.0, 1.0, 1.0], 0.0), 0.5);
        assert_eq!(fastest([0.0, 1.0, 1.0, 1.0, 1.0, 1.0], 0.0), 0.25);
        assert_eq!(fastest([0.0, 1.0, 1.0, 1.0, 1.0, 0.0], 0.0), 0.25);
        assert_eq!(fastest([0.0, 0.0, 1.0, 1.0, 1.0, 0.0], 0.0), 0.0);
        assert_eq!(fastest([0.0; 6], 0.0), 0.0);
        assert_eq!(fastest([0.0; 6], 0.5), 0.5);
    }
}
