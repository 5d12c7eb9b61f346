//! The arithmetic of `AddToGrid` (\[001\] Fig. 3), in integers.

use super::grid::Measurement;
use crate::health::{Claim, Confidence, FaultAttribution, Health, Learning, StepRule};
use crate::narrow::wrapping_u8;
use crate::sensor::SensorId;
use core::fmt;
use fixed::types::{I2F14, U0F16};

/// What \[001\] Fig. 3 leaves open, before it is checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RobustConfig {
    /// `CONFIRMATIONTHRESHOLD`: a comparison above it confirms.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub confirmation: I2F14,
    /// `CONTRADICTIONTHRESHOLD`: a comparison below it contradicts.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub contradiction: I2F14,
    /// `CONTRIBUTIONTHRESHOLD`: a contribution above it makes the sensor the owner.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub contribution: I2F14,
    /// What a comparison teaches of the two sensors: `inc` and `dec`.
    pub learning: Learning,
    /// What a sensor starts with; full, where nothing is known about it (\[002\] §4).
    pub start: Confidence,
}

impl RobustConfig {
    /// What the simulator's fault campaign chose.
    ///
    /// A quarter for both comparisons: each side must, on average, be half way from *uncertain* to
    /// sure. Nothing for the contribution: whoever is on the cell's side owns it. Agreeing on something
    /// occupied makes up for a quarter of what a confidence lacks, and agreeing on something free for
    /// nothing; a contradiction costs the side that is as likely wrong as the other 1/48 of it.
    pub const DEFAULT: Self = Self {
        confirmation: I2F14::from_bits(1 << 12),
        contradiction: I2F14::from_bits(-(1 << 12)),
        contribution: I2F14::from_bits(0),
        learning: Learning {
            raise: U0F16::from_bits(1 << 14),
            raise_free: U0F16::from_bits(0),
            lower: U0F16::from_bits(1365),
            step_rule: StepRule::Proportional,
            attribution: FaultAttribution::Shared,
            floor: Confidence::from_bits(1 << 10),
            ceiling: Confidence::FULL,
        },
        start: Confidence::FULL,
    };

    /// \[001\] §5.1 and \[002\] §4 to the letter: all agreement counts alike, both sides fall alike, and
    /// confidence falls by larger steps than it rises by.
    ///
    /// A contradiction weighs 7 confirmations: sound sensors of \[001\] Table 1 gather 9 to 22
    /// confirmations a contradiction, 8 beside a random one, which gathers 4 to 7. So these steps find
    /// a random sensor best, and one that is stuck far or biased hardly ever.
    pub const TO_THE_LETTER: Self = Self {
        learning: Learning {
            raise: U0F16::from_bits(1 << 7),
            raise_free: U0F16::from_bits(1 << 7),
            lower: U0F16::from_bits(7 << 7),
            step_rule: StepRule::Fixed,
            attribution: FaultAttribution::Alike,
            ..Self::DEFAULT.learning
        },
        ..Self::DEFAULT
    };
}

impl Default for RobustConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The checked [`RobustConfig`].
///
/// Possession proves that no comparison both confirms and contradicts, that confidence both rises and
/// falls (by more than agreeing on something free raises it), and that its bounds leave room.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RobustRules(RobustConfig);

/// Why a configuration was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RobustConfigError {
    /// The contradiction threshold is above the confirmation threshold.
    Thresholds,
    /// The step down is not larger than the step up for agreeing on something free, or there is no
    /// step up for agreeing on something occupied.
    Steps,
    /// The floor is zero, or not below the ceiling, or the start not between them.
    Bounds,
}

impl fmt::Display for RobustConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Thresholds => "the contradiction threshold must not exceed the confirmation one",
            Self::Steps => "confidence must rise, and fall by larger steps than agreement on free cells raises it",
            Self::Bounds => {
                "the lowest confidence must be above 0 and below the highest, the first between them"
            }
        })
    }
}

impl core::error::Error for RobustConfigError {}

impl RobustRules {
    /// The rules of [`RobustConfig::DEFAULT`].
    pub const DEFAULT: Self = Self(RobustConfig::DEFAULT);

    /// Checks the configuration.
    ///
    /// # Errors
    ///
    /// [`RobustConfigError`] names what cannot be.
    pub const fn try_new(config: RobustConfig) -> Result<Self, RobustConfigError> {
        let learning = &config.learning;
        if config.contradiction.to_bits() > config.confirmation.to_bits() {
            Err(RobustConfigError::Thresholds)
        } else if learning.raise.to_bits() == 0
            || learning.lower.to_bits() <= learning.raise_free.to_bits()
        {
            Err(RobustConfigError::Steps)
        } else if learning.floor.to_bits() == 0
            || learning.floor.to_bits() >= learning.ceiling.to_bits()
            || config.start.to_bits() < learning.floor.to_bits()
            || config.start.to_bits() > learning.ceiling.to_bits()
        {
            Err(RobustConfigError::Bounds)
        } else {
            Ok(Self(config))
        }
    }

    /// Returns the configuration.
    #[must_use]
    pub const fn config(&self) -> &RobustConfig {
        &self.0
    }

    /// Returns the record that a sensor starts with.
    #[must_use]
    pub const fn first_health(&self) -> Health {
        Health::new(self.0.start)
    }
}

impl Default for RobustRules {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What one sensor says of some cells, as it meets what others said of them.
#[derive(Debug)]
pub(super) struct Update<'a> {
    /// The sensor's own record, beside the list until the last cell.
    own: Health,
    rules: &'a RobustRules,
    /// The certainty's deviation.
    said: i32,
    sensor: SensorId,
}

impl<'a> Update<'a> {
    #[inline]
    pub(super) fn new(rules: &'a RobustRules, measurement: Measurement, own: &Health) -> Self {
        Self {
            own: *own,
            rules,
            said: measurement.certainty.deviation().into(),
            sensor: measurement.sensor,
        }
    }

    /// Meets the word of `owner` in a cell, `stored` as its deviation; returns who owns the cell then.
    ///
    /// \[001\] Fig. 3 from the comparison on, in the figure's order. Not generic, so that an image has
    /// it once, whatever grids it has.
    pub(super) fn meet(&mut self, stored: &mut u8, owner: &mut Health) -> Option<SensorId> {
        let Self {
            own, rules, said, ..
        } = self;
        let (RobustRules(config), said) = (rules, *said);
        let occ = i32::from(stored.cast_signed());
        let comparison = agreement(occ, said);
        // The mean of two equal values is that value, at any weights: what most cells see, undivided.
        let mut contribution = comparison;
        if occ != said {
            // The confidences are still the old ones here.
            let fused = weighted_mean(occ, owner.confidence(), said, own.confidence());
            *stored = wrapping_u8(fused.cast_unsigned());
            contribution = agreement(fused, said);
        }
        if comparison > i32::from(config.confirmation.to_bits()) {
            Health::confirm([owner, own], Claim::of_deviation(said), &config.learning);
        } else if comparison < i32::from(config.contradiction.to_bits()) {
            let words = [Claim::of_deviation(occ), Claim::of_deviation(said)];
            Health::contradict([owner, own], words, &config.learning);
        }
        (contribution > i32::from(config.contribution.to_bits())).then_some(self.sensor)
    }

    /// Returns the sensor's record, with what it learned.
    #[inline]
    pub(super) const fn into_own(self) -> Health {
        self.own
    }
}

/// How far a cell and a measurement agree: `comparison` and `contribution` of \[001\] Fig. 3.
///
/// Formula: 4 · (occ − 0.5) · (measurement − 0.5). With deviations in 1/256 the product is the result
/// in 1/2^14, exactly.
///
/// Range: −0.992 (free against occupied) to 1 (free and free).
#[inline]
const fn agreement(occ: i32, measurement: i32) -> i32 {
    occ.wrapping_mul(measurement)
}

/// The new value of a cell: the mean of old value and measurement, each weighted by its distance from
/// *uncertain* and by its sensor's confidence. All three are deviations.
///
/// Formula (\[001\] Fig. 3): (occ · weight1 + measurement · weight2) / (weight1 + weight2), with
/// weight = |value − 0.5| · conf; the plain mean where both weights are equal. Rounds to the nearest
/// step of 1/256, ties up.
///
/// Range: a weight is at most 128 · 65535, a numerator with its rounding at most 255.5 · 2 of them,
/// 4 286 513 280, which 32 bits hold.
#[inline]
fn weighted_mean(occ: i32, owner: Confidence, measurement: i32, sensor: Confidence) -> i32 {
    let weight = |value: i32, confidence: Confidence| {
        value
            .unsigned_abs()
            .wrapping_mul(confidence.to_bits().into())
    };
    let (weight1, weight2) = (weight(occ, owner), weight(measurement, sensor));
    // As certainties, 0 to 255, so that nothing is negative.
    let certainty = |deviation: i32| deviation.wrapping_add(128).cast_unsigned();
    let (occ, measurement) = (certainty(occ), certainty(measurement));
    // Not only for speed: both may be zero.
    let mean = if weight1 == weight2 {
        occ.wrapping_add(measurement).wrapping_add(1) >> 1
    } else {
        let total = weight1.wrapping_add(weight2);
        let sum = occ
            .wrapping_mul(weight1)
            .wrapping_add(measurement.wrapping_mul(weight2))
            .wrapping_add(total >> 1);
        // Different weights are not both zero.
        sum.checked_div(total).unwrap_or(occ)
    };
    mean.cast_signed().wrapping_sub(128)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// \[001\] Fig. 3 in real numbers, 0 to 1 in steps of 1/256, rounded once at the end.
    fn naive_mean(occ: u8, conf1: u16, measurement: u8, conf2: u16) -> u8 {
        let (occ, measurement) = (f64::from(occ), f64::from(measurement));
        let weight1 = (occ - 128.0).abs() * f64::from(conf1);
        let weight2 = (measurement - 128.0).abs() * f64::from(conf2);
        let mean = if weight1 == weight2 {
            f64::midpoint(occ, measurement)
        } else {
            (occ * weight1 + measurement * weight2) / (weight1 + weight2)
        };
        (mean + 0.5).floor() as u8
    }

    #[test]
    fn the_mean_is_the_figures_for_all_values_at_many_confidences() {
        let confidences = [0, 1, 2, 1 << 10, 20_000, 1 << 15, 65_534, u16::MAX];
        for (conf1, conf2) in confidences
            .iter()
            .flat_map(|&a| confidences.map(|b| (a, b)))
        {
            for (occ, measurement) in (0..=u8::MAX).flat_map(|a| (0..=u8::MAX).map(move |b| (a, b)))
            {
                let mean = weighted_mean(
                    i32::from(occ) - 128,
                    Confidence::from_bits(conf1),
                    i32::from(measurement) - 128,
                    Confidence::from_bits(conf2),
                );
                let naive = naive_mean(occ, conf1, measurement, conf2);
                assert_eq!(
                    mean + 128,
                    i32::from(naive),
                    "{occ} at {conf1}, {measurement} at {conf2}"
                );
            }
        }
    }

    #[test]
    fn agreement_is_the_figures_for_all_values() {
        for (a, b) in (0..=u8::MAX).flat_map(|a| (0..=u8::MAX).map(move |b| (a, b))) {
            let exact = 4.0 * (f64::from(a) / 256.0 - 0.5) * (f64::from(b) / 256.0 - 0.5);
            let agreement = agreement(i32::from(a) - 128, i32::from(b) - 128);
            assert_eq!(f64::from(agreement) / 16_384.0, exact);
        }
    }

    #[test]
    fn the_shipped_configurations_pass_their_own_check() {
        assert_eq!(
            RobustRules::try_new(RobustConfig::DEFAULT),
            Ok(RobustRules::DEFAULT)
        );
        assert!(RobustRules::try_new(RobustConfig::TO_THE_LETTER).is_ok());
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let base = RobustConfig::TO_THE_LETTER;
        let crossed = RobustConfig {
            contradiction: I2F14::ONE,
            ..base
        };
        assert_eq!(
            RobustRules::try_new(crossed),
            Err(RobustConfigError::Thresholds)
        );
        let learns = |learning: Learning| RobustConfig { learning, ..base };
        let learning = base.learning;
        let forgiving = learns(Learning {
            lower: learning.raise_free,
            ..learning
        });
        assert_eq!(
            RobustRules::try_new(forgiving),
            Err(RobustConfigError::Steps)
        );
        let hopeless = learns(Learning {
            raise: U0F16::ZERO,
            ..learning
        });
        assert_eq!(
            RobustRules::try_new(hopeless),
            Err(RobustConfigError::Steps)
        );
        let no_room = learns(Learning {
            ceiling: learning.floor,
            ..learning
        });
        let bottomless = learns(Learning {
            floor: Confidence::NONE,
            ..learning
        });
        let below = RobustConfig {
            start: Confidence::NONE,
            ..base
        };
        for config in [below, no_room, bottomless] {
            assert_eq!(RobustRules::try_new(config), Err(RobustConfigError::Bounds));
        }
    }
}
