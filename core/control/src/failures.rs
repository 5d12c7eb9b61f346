//! Which sensors have failed, and how far: **F** of \[004\] §3.

use super::Effort;
use super::braitenberg::{PerRangefinder, RANGEFINDERS};
use super::histogram::{BEAMS, PerBeam};
use super::motion::{HALF, scaled, share};
use certainty_core::health::{Confidence, Health, HealthRules, Status};
use certainty_core::narrow::low_u32;
use certainty_core::transducer::Reading;

/// Rangefinders and scanner, in the order of their numbers: the scanner last.
pub const SENSORS: usize = RANGEFINDERS + 1;

/// How far something has failed: 0 sound, 1 failed.
///
/// \[004\] has 0 and 1 alone; between them is what is diagnosed but not certain.
///
/// Possession proves that it is within 0..=1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Failure(#[cfg_attr(feature = "defmt", defmt(Display2Format))] Effort);

impl Failure {
    /// Sound.
    pub const NONE: Self = Self(Effort::ZERO);
    /// Failed.
    pub const TOTAL: Self = Self(Effort::ONE);

    /// Creates the failure of `part`, within 0..=1: beyond it saturates.
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

    /// Returns 1 − φ.
    #[must_use]
    pub const fn left(self) -> Effort {
        Effort::ONE.saturating_sub(self.0)
    }

    /// Returns whether it is at least a half: what it is of is taken for broken.
    #[must_use]
    pub const fn is_broken(self) -> bool {
        self.0.to_bits() >= HALF.to_bits()
    }

    /// Returns what a sensor's health says of it, by the limits of [`HealthRules`].
    ///
    /// Formula: *failed* or stale is 1; else 0 from the confidence of a healthy sensor upwards, 1 from
    /// that of a failed one downwards, linear between; a *recovering* sensor, which is not trusted yet, is
    /// at least half.
    #[must_use]
    pub fn of_health(health: &Health) -> Self {
        let doubt = Self::of_confidence(health.confidence());
        match health.status() {
            _ if health.is_stale() => Self::TOTAL,
            Status::Failed => Self::TOTAL,
            Status::Recovering => doubt.max(Self(HALF)),
            Status::Healthy | Status::Suspect => doubt,
        }
    }

    /// The part of the way from a healthy to a failed confidence.
    fn of_confidence(confidence: Confidence) -> Self {
        let high = HealthRules::HEALTHY_FROM.to_bits();
        let below = high.saturating_sub(confidence.to_bits());
        let span = high.saturating_sub(HealthRules::FAILED_BELOW.to_bits());
        let wide = u64::from(below) << Effort::FRAC_NBITS;
        // At most 2^32 where the span is one step.
        let part = wide.checked_div(span.into()).unwrap_or(0);
        Self::new_saturating(Effort::from_bits(
            low_u32(part.min(1 << Effort::FRAC_NBITS)).cast_signed(),
        ))
    }
}

/// **F** of \[004\] §3: how far each sensor has failed.
///
/// Whoever knows may make one: the operator (*given*), the fusion level's [`Health`], a
/// [`CrossCheck`](super::CrossCheck), a check of single readings. [`Self::worst`] joins them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Failures {
    /// `φ_1` to `φ_6`.
    pub rangefinders: PerRangefinder<Failure>,
    /// `φ_s`.
    pub scanner: Failure,
}

impl Failures {
    /// No sensor has failed.
    pub const NONE: Self = Self {
        rangefinders: [Failure::NONE; RANGEFINDERS],
        scanner: Failure::NONE,
    };

    /// Every sensor has.
    pub const ALL: Self = Self {
        rangefinders: [Failure::TOTAL; RANGEFINDERS],
        scanner: Failure::TOTAL,
    };

    /// Returns what the `health` of sensors 1 to 7 says, the scanner being number 7; a sensor that is
    /// not listed is sound.
    #[must_use]
    pub fn of_health<'a>(health: impl IntoIterator<Item = &'a Health>) -> Self {
        let mut failures = Self::NONE;
        let all = failures
            .rangefinders
            .iter_mut()
            .chain([&mut failures.scanner]);
        for (failure, health) in all.zip(health) {
            *failure = Failure::of_health(health);
        }
        failures
    }

    /// Returns these failures, and for now of those, too, who say nothing: rangefinders whose reading is
    /// *missing*, and the scanner; without a `scan` it says nothing at all.
    ///
    /// Formula: of the scanner's `1 − φ` the part is left that is heard of the third of its field, right,
    /// middle or left, of which least is: who sees to both sides does not see ahead.
    #[must_use]
    pub fn or_silent(
        mut self,
        rangefinders: &PerRangefinder<Reading>,
        scan: Option<&PerBeam<Reading>>,
    ) -> Self {
        for (failure, reading) in self.rangefinders.iter_mut().zip(rangefinders) {
            if matches!(reading, Reading::Missing(_)) {
                *failure = Failure::TOTAL;
            }
        }
        let left = scan.map_or(Effort::ZERO, |scan| {
            scaled(self.scanner.left(), heard(scan))
        });
        self.scanner = Failure::new_saturating(Effort::ONE.saturating_sub(left));
        self
    }

    /// Returns, sensor by sensor, the larger failure of the two.
    #[must_use]
    pub fn worst(self, other: Self) -> Self {
        let mut failures = self;
        for (own, &others) in failures.rangefinders.iter_mut().zip(&other.rangefinders) {
            *own = others.max(*own);
        }
        failures.scanner = failures.scanner.max(other.scanner);
        failures
    }
}

/// The part that is heard of the third of the field of which least is.
fn heard(scan: &PerBeam<Reading>) -> Effort {
    // 34, 33 and 34 beams: as many to the right as to the left.
    const SIDE: usize = BEAMS.div_ceil(3);
    const MIDDLE: usize = BEAMS - 2 * SIDE;
    let part = |first: usize, count: usize| {
        let beams = scan.iter().skip(first).take(count);
        let (heard, all) = beams.fold((0_i32, 0_i32), |(heard, all), reading| {
            let is_heard = !matches!(reading, Reading::Missing(_));
            (heard.saturating_add(is_heard.into()), all.saturating_add(1))
        });
        share(heard, all)
    };
    part(0, SIDE)
        .min(part(SIDE, MIDDLE))
        .min(part(SIDE + MIDDLE, SIDE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::transducer::Missing;
    use certainty_core::units::Ticks;

    const SILENT: Reading = Reading::Missing(Missing::Timeout);

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
    fn a_silent_sensor_has_failed_whatever_its_confidence() {
        let rules = HealthRules::DEFAULT;
        let mut health = Health::default();
        for _ in 0..HealthRules::FAILED_MISSING {
            health.record(SILENT, Ticks::new(0));
            health.settle(&rules, Ticks::new(0));
        }
        assert_eq!(part(&health), 1.0);
        // One reading later it is recovering, and half trusted at most.
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
        assert_eq!(Failures::NONE.worst(Failures::ALL), Failures::ALL);
    }

    #[test]
    fn who_says_nothing_has_failed_for_now() {
        let open = [Reading::NoObject; BEAMS];
        let mut readings = [Reading::NoObject; RANGEFINDERS];
        assert_eq!(
            Failures::NONE.or_silent(&readings, Some(&open)),
            Failures::NONE
        );
        readings[4] = SILENT;
        let mut expected = Failures::NONE;
        expected.rangefinders[4] = Failure::TOTAL;
        assert_eq!(Failures::NONE.or_silent(&readings, Some(&open)), expected);
        expected.scanner = Failure::TOTAL;
        assert_eq!(Failures::NONE.or_silent(&readings, None), expected);
        assert_eq!(
            Failures::ALL.or_silent(&readings, Some(&open)),
            Failures::ALL
        );
    }

    /// By hand: of 34 beams on a side and 33 in the middle.
    #[test]
    fn a_scanner_sees_no_better_than_in_the_third_where_it_sees_least() {
        let left = |silent: core::ops::Range<usize>| -> f64 {
            let mut scan = [Reading::NoObject; BEAMS];
            scan[silent].fill(SILENT);
            let readings = [Reading::NoObject; RANGEFINDERS];
            let failures = Failures::NONE.or_silent(&readings, Some(&scan));
            failures.scanner.left().to_num()
        };
        assert_eq!(left(0..17), 0.5);
        assert_eq!(left(84..101), 0.5);
        assert_eq!((left(0..34), left(34..67), left(67..101)), (0.0, 0.0, 0.0));
        assert!((left(34..45) - 2.0 / 3.0).abs() < 1e-4);
        // A half is left of what was half believed.
        let half = Failures {
            scanner: Failure::new_saturating(HALF),
            ..Failures::NONE
        };
        let mut scan = [Reading::NoObject; BEAMS];
        scan[..17].fill(SILENT);
        let readings = [Reading::NoObject; RANGEFINDERS];
        let failures = half.or_silent(&readings, Some(&scan));
        assert_eq!(failures.scanner.part(), Effort::lit("0.75"));
    }

    #[test]
    fn broken_is_from_a_half_on() {
        assert!(Failure::TOTAL.is_broken() && !Failure::NONE.is_broken());
        assert!(Failure::new_saturating(HALF).is_broken());
        assert!(!Failure::new_saturating(HALF - Effort::DELTA).is_broken());
    }

    #[test]
    fn no_failure_is_beyond_its_ends() {
        assert_eq!(Failure::new_saturating(Effort::MAX), Failure::TOTAL);
        assert_eq!(Failure::new_saturating(Effort::MIN), Failure::NONE);
    }
}
