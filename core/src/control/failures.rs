//! Which sensors have failed, and how far: **F** of \[004\] §3.

use super::Signal;
use super::braitenberg::{PerRangefinder, RANGEFINDERS};
use super::motion::HALF;
use crate::health::{Confidence, Health, HealthConfig, Status};
use crate::narrow::low_u32;

/// Rangefinders and scanner, in the order of their numbers: the scanner last.
pub const SENSORS: usize = RANGEFINDERS + 1;

/// How far something has failed: 0 sound, 1 failed.
///
/// \[004\] has 0 and 1 alone; between them is what is diagnosed but not certain.
///
/// Possession proves that it is within 0..=1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Failure(#[cfg_attr(feature = "defmt", defmt(Display2Format))] Signal);

impl Failure {
    /// Sound.
    pub const NONE: Self = Self(Signal::ZERO);
    /// Failed.
    pub const TOTAL: Self = Self(Signal::ONE);

    /// Creates the failure of `part`, within 0..=1: beyond it saturates.
    #[must_use]
    pub const fn new_saturating(part: Signal) -> Self {
        let bits = part.to_bits();
        if bits <= 0 {
            Self::NONE
        } else if bits >= Signal::ONE.to_bits() {
            Self::TOTAL
        } else {
            Self(part)
        }
    }

    /// Returns φ.
    #[must_use]
    pub const fn part(self) -> Signal {
        self.0
    }

    /// Returns 1 − φ.
    #[must_use]
    pub const fn left(self) -> Signal {
        Signal::ONE.saturating_sub(self.0)
    }

    /// Returns what a sensor's health says of it, by the limits of `config`.
    ///
    /// Formula: *failed* or stale is 1; else 0 from the confidence of a healthy sensor upwards, 1 from
    /// that of a failed one downwards, linear between; a *recovering* sensor, which is not trusted yet, is
    /// at least half.
    #[must_use]
    pub fn of_health(health: &Health, config: &HealthConfig) -> Self {
        let doubt = Self::of_confidence(health.confidence(), config);
        match health.status() {
            _ if health.is_stale() => Self::TOTAL,
            Status::Failed => Self::TOTAL,
            Status::Recovering => doubt.max(Self(HALF)),
            Status::Healthy | Status::Suspect => doubt,
        }
    }

    /// The part of the way from a healthy to a failed confidence.
    fn of_confidence(confidence: Confidence, config: &HealthConfig) -> Self {
        let high = config.healthy_from.to_bits();
        let below = high.saturating_sub(confidence.to_bits());
        let span = high.saturating_sub(config.failed_below.to_bits());
        let wide = u64::from(below) << Signal::FRAC_NBITS;
        // At most 2^32 where the span is one step.
        let part = wide.checked_div(span.into()).unwrap_or(0);
        Self::new_saturating(Signal::from_bits(
            low_u32(part.min(1 << Signal::FRAC_NBITS)).cast_signed(),
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
    pub fn of_health<'a>(
        health: impl IntoIterator<Item = &'a Health>,
        config: &HealthConfig,
    ) -> Self {
        let mut failures = Self::NONE;
        let all = failures
            .rangefinders
            .iter_mut()
            .chain([&mut failures.scanner]);
        for (failure, health) in all.zip(health) {
            *failure = Failure::of_health(health, config);
        }
        failures
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::health::HealthRules;
    use crate::transducer::{Missing, Reading};
    use crate::units::Ticks;

    fn part(health: &Health) -> f64 {
        Failure::of_health(health, &HealthConfig::DEFAULT)
            .part()
            .to_num()
    }

    #[test]
    fn confidence_drives_the_failure_continuously() {
        let config = HealthConfig {
            healthy_from: Confidence::from_bits(3 << 14),
            failed_below: Confidence::from_bits(1 << 14),
            ..HealthConfig::DEFAULT
        };
        for (bits, expected) in [
            (u16::MAX, 0.0),
            (3 << 14, 0.0),
            (1 << 15, 0.5),
            (3 << 13, 0.75),
            (1 << 14, 1.0),
            (0, 1.0),
        ] {
            let health = Health::new(Confidence::from_bits(bits));
            let part: f64 = Failure::of_health(&health, &config).part().to_num();
            assert_eq!(part, expected, "{bits}");
        }
    }

    #[test]
    fn a_silent_sensor_has_failed_whatever_its_confidence() {
        let rules = HealthRules::DEFAULT;
        let mut health = Health::default();
        let timeout = Reading::Missing(Missing::Timeout);
        for _ in 0..rules.config().failed_missing {
            health.record(timeout, Ticks::new(0));
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
        let failures = Failures::of_health(&health, &HealthConfig::DEFAULT);
        assert_eq!(failures.scanner, Failure::TOTAL);
        assert_eq!(failures.rangefinders, [Failure::NONE; RANGEFINDERS]);
        assert_eq!(failures.worst(Failures::NONE), failures);
        assert_eq!(Failures::NONE.worst(Failures::ALL), Failures::ALL);
    }

    #[test]
    fn no_failure_is_beyond_its_ends() {
        assert_eq!(Failure::new_saturating(Signal::MAX), Failure::TOTAL);
        assert_eq!(Failure::new_saturating(Signal::MIN), Failure::NONE);
    }
}
