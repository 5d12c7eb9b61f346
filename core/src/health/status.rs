//! The conclusion about a sensor, with hysteresis.

use super::{Confidence, Health};
use core::fmt;

/// What is concluded about a sensor.
///
/// ```text
///            confidence or readings fail            fail further
///  Healthy ──────────────────────────────► Suspect ─────────────► Failed
///     ▲  ◄──────────── well again ────────────┘                     │ better again
///     └───────────── well again ──────────── Recovering ◄───────────┘
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Status {
    /// Trusted.
    Healthy,
    /// Contradicted or silent more often than a sound sensor is.
    Suspect,
    /// Not to be relied on; due for maintenance.
    Failed,
    /// Failed before, agreeing again; not yet trusted.
    Recovering,
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Healthy => "healthy",
            Self::Suspect => "suspect",
            Self::Failed => "failed",
            Self::Recovering => "recovering",
        })
    }
}

/// The limits between one status and the next, before they are checked.
///
/// No paper gives them; the gaps between the limits are the hysteresis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HealthConfig {
    /// A healthy sensor below this confidence is suspect.
    pub suspect_below: Confidence,
    /// A suspect or recovering one below this has failed.
    pub failed_below: Confidence,
    /// A failed one at or above this is recovering.
    pub recovering_from: Confidence,
    /// A suspect or recovering one at or above this is healthy.
    pub healthy_from: Confidence,
    /// So many missing readings in a row make a sensor suspect.
    pub suspect_missing: u16,
    /// So many missing readings in a row make it failed.
    pub failed_missing: u16,
    /// A suspect or recovering one is healthy only after so many readings in a row.
    pub healthy_heard: u16,
    /// A sensor that was silent for longer than so many ticks has failed.
    pub stale_after: u32,
}

impl HealthConfig {
    /// A quarter and 0.15 of full confidence downwards, a quarter and a half upwards; three and ten
    /// missing readings, ten that came; two seconds of silence. The simulator's fault campaign chose
    /// the confidences.
    pub const DEFAULT: Self = Self {
        suspect_below: Confidence::from_bits(1 << 14),
        failed_below: Confidence::from_bits(9830),
        recovering_from: Confidence::from_bits(1 << 14),
        healthy_from: Confidence::from_bits(1 << 15),
        suspect_missing: 3,
        failed_missing: 10,
        healthy_heard: 10,
        stale_after: 2000,
    };
}

impl Default for HealthConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The checked [`HealthConfig`].
///
/// Possession proves that the limits leave a gap: failed < recovering ≤ healthy, failed < suspect <
/// healthy, so that no status flickers at a constant confidence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HealthRules(HealthConfig);

/// Why limits were refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum HealthConfigError {
    /// The confidences are not in order, or leave no gap.
    Confidences,
    /// The counts of missing readings are zero or not in order.
    Missing,
}

impl fmt::Display for HealthConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Confidences => {
                "confidences must be in the order failed < suspect < healthy and failed < \
                 recovering <= healthy"
            }
            Self::Missing => "missing readings must be in the order 0 < suspect < failed",
        })
    }
}

impl core::error::Error for HealthConfigError {}

impl HealthRules {
    /// The rules of [`HealthConfig::DEFAULT`].
    pub const DEFAULT: Self = Self(HealthConfig::DEFAULT);

    /// Checks the limits.
    ///
    /// # Errors
    ///
    /// [`HealthConfigError`] names what is out of order.
    pub const fn try_new(config: HealthConfig) -> Result<Self, HealthConfigError> {
        let failed = config.failed_below.to_bits();
        let suspect = config.suspect_below.to_bits();
        let recovering = config.recovering_from.to_bits();
        let healthy = config.healthy_from.to_bits();
        let ordered = failed < suspect && suspect < healthy;
        if !ordered || failed >= recovering || recovering > healthy {
            Err(HealthConfigError::Confidences)
        } else if config.suspect_missing == 0 || config.failed_missing <= config.suspect_missing {
            Err(HealthConfigError::Missing)
        } else {
            Ok(Self(config))
        }
    }

    /// Returns the limits.
    #[must_use]
    pub const fn config(&self) -> &HealthConfig {
        &self.0
    }

    /// Returns the status that follows `status`; one step at a time, except that silence fails at
    /// once.
    pub(super) const fn next(&self, status: Status, health: &Health) -> Status {
        let limits = &self.0;
        let confidence = health.confidence().to_bits();
        let missing = health.missing_in_a_row();
        if health.is_stale() || missing >= limits.failed_missing {
            return Status::Failed;
        }
        let wavering = missing >= limits.suspect_missing;
        let well = health.heard_in_a_row() >= limits.healthy_heard
            && confidence >= limits.healthy_from.to_bits();
        match status {
            Status::Healthy if wavering || confidence < limits.suspect_below.to_bits() => {
                Status::Suspect
            }
            Status::Suspect | Status::Recovering if confidence < limits.failed_below.to_bits() => {
                Status::Failed
            }
            Status::Suspect | Status::Recovering if well => Status::Healthy,
            Status::Failed if missing == 0 && confidence >= limits.recovering_from.to_bits() => {
                Status::Recovering
            }
            unchanged => unchanged,
        }
    }
}

impl Default for HealthRules {
    fn default() -> Self {
        Self::DEFAULT
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transducer::Reading;
    use crate::units::Ticks;

    /// A sensor heard without a gap, with this confidence.
    fn heard(bits: u16) -> Health {
        let mut health = Health::new(Confidence::from_bits(bits));
        for _ in 0..HealthConfig::DEFAULT.healthy_heard {
            health.record(Reading::NoObject, Ticks::new(0));
        }
        health
    }

    fn walk(confidences: impl IntoIterator<Item = u16>) -> Vec<Status> {
        let rules = HealthRules::DEFAULT;
        let mut status = Status::Healthy;
        let mut walked = vec![status];
        for bits in confidences {
            status = rules.next(status, &heard(bits));
            if walked.last() != Some(&status) {
                walked.push(status);
            }
        }
        walked
    }

    #[test]
    fn confidence_down_and_up_again_goes_round_once() {
        let down = (0..=u16::MAX).rev();
        let up = 0..=u16::MAX;
        assert_eq!(
            walk(down.chain(up)),
            [
                Status::Healthy,
                Status::Suspect,
                Status::Failed,
                Status::Recovering,
                Status::Healthy
            ]
        );
    }

    #[test]
    fn no_status_flickers_at_a_constant_confidence() {
        for bits in 0..=u16::MAX {
            let rules = HealthRules::DEFAULT;
            for start in [
                Status::Healthy,
                Status::Suspect,
                Status::Failed,
                Status::Recovering,
            ] {
                let next = |s| rules.next(s, &heard(bits));
                let settled = next(next(start));
                assert_eq!(next(settled), settled, "{bits} from {start}");
            }
        }
    }

    #[test]
    fn the_default_limits_pass_their_own_check() {
        assert_eq!(
            HealthRules::try_new(HealthConfig::DEFAULT),
            Ok(HealthRules::DEFAULT)
        );
    }

    #[test]
    fn limits_without_a_gap_are_refused() {
        let base = HealthConfig::DEFAULT;
        let no_gap = HealthConfig {
            suspect_below: base.failed_below,
            ..base
        };
        assert_eq!(
            HealthRules::try_new(no_gap),
            Err(HealthConfigError::Confidences)
        );
        let too_early = HealthConfig {
            recovering_from: base.failed_below,
            ..base
        };
        assert_eq!(
            HealthRules::try_new(too_early),
            Err(HealthConfigError::Confidences)
        );
        let never = HealthConfig {
            failed_missing: base.suspect_missing,
            ..base
        };
        assert_eq!(HealthRules::try_new(never), Err(HealthConfigError::Missing));
    }
}
