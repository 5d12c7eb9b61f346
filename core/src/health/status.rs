//! The status of a sensor, with hysteresis.

use super::confidence::Confidence;
use core::fmt;

/// The status of a sensor, for maintenance and control.
///
/// ```text
///       low confidence or missing readings     lower, or more missing
///  Healthy ──────────────────────────────► Suspect ─────────────► Failed
///     ▲  ◄──────────── healthy again ──────────┘                    │ agrees again
///     └───────────── healthy again ───────── Recovering ◄───────────┘
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Status {
    /// Reliable.
    Healthy,
    /// Contradicted, or without a reading, more often than a correct sensor.
    Suspect,
    /// Not to be used; due for maintenance.
    Failed,
    /// Failed before and agrees again; not yet reliable.
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

/// What a status is concluded from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Condition {
    pub(super) confidence: Confidence,
    pub(super) missing_in_a_row: u16,
    pub(super) received_in_a_row: u16,
    /// No reading came for longer than [`HealthRules::stale_after`].
    pub(super) stale: bool,
}

impl Status {
    /// Returns the status that follows this one: the next in the diagram, or *failed* at once if no
    /// readings come.
    pub(super) const fn next(self, condition: &Condition) -> Self {
        let confidence = condition.confidence.to_bits();
        let missing = condition.missing_in_a_row;
        if condition.stale || missing >= HealthRules::FAILED_MISSING {
            return Self::Failed;
        }
        let healthy = condition.received_in_a_row >= HealthRules::HEALTHY_RECEIVED
            && confidence >= HealthRules::HEALTHY_FROM.to_bits();
        let suspect = missing >= HealthRules::SUSPECT_MISSING
            || confidence < HealthRules::SUSPECT_BELOW.to_bits();
        let failed = confidence < HealthRules::FAILED_BELOW.to_bits();
        match self {
            Self::Healthy if suspect => Self::Suspect,
            Self::Suspect | Self::Recovering if failed => Self::Failed,
            Self::Suspect | Self::Recovering if healthy => Self::Healthy,
            Self::Failed
                if missing == 0 && confidence >= HealthRules::RECOVERING_FROM.to_bits() =>
            {
                Self::Recovering
            }
            unchanged => unchanged,
        }
    }
}

/// The limits between one status and the next.
///
/// The papers give none. The gaps between the limits are the hysteresis: at a constant confidence no
/// status alternates. Only the time without readings depends on the robot, so it alone is set; the
/// simulator's fault campaign chose the confidences.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HealthRules {
    stale_after: u32,
}

impl HealthRules {
    /// A healthy sensor with a confidence below this becomes suspect: a quarter.
    pub const SUSPECT_BELOW: Confidence = Confidence::from_bits(1 << 14);
    /// A suspect or recovering sensor with a confidence below this fails: 0.15.
    pub const FAILED_BELOW: Confidence = Confidence::from_bits(9830);
    /// A failed sensor with a confidence at or above this recovers: a quarter.
    pub const RECOVERING_FROM: Confidence = Confidence::from_bits(1 << 14);
    /// A suspect or recovering sensor with a confidence at or above this becomes healthy: a half.
    pub const HEALTHY_FROM: Confidence = Confidence::from_bits(1 << 15);
    /// This many missing readings in a row make a healthy sensor suspect.
    pub const SUSPECT_MISSING: u16 = 3;
    /// This many missing readings in a row make any sensor fail.
    pub const FAILED_MISSING: u16 = 10;
    /// A suspect or recovering sensor becomes healthy only after this many readings in a row.
    pub const HEALTHY_RECEIVED: u16 = 10;

    /// Sensors fail after two seconds without a reading.
    pub const DEFAULT: Self = Self::new(2000);

    /// Creates rules by which a sensor fails after more than `stale_after` ms without a reading.
    #[must_use]
    pub const fn new(stale_after: u32) -> Self {
        Self { stale_after }
    }

    /// Returns the longest time without a reading that is no failure, in ms.
    #[must_use]
    pub const fn stale_after(&self) -> u32 {
        self.stale_after
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

    /// A sensor with this confidence and no missing readings.
    fn received(bits: u16) -> Condition {
        Condition {
            confidence: Confidence::from_bits(bits),
            missing_in_a_row: 0,
            received_in_a_row: HealthRules::HEALTHY_RECEIVED,
            stale: false,
        }
    }

    /// The statuses that a sensor goes through, from *healthy*.
    fn statuses(confidences: impl IntoIterator<Item = u16>) -> Vec<Status> {
        let mut status = Status::Healthy;
        let mut statuses = vec![status];
        for bits in confidences {
            status = status.next(&received(bits));
            if statuses.last() != Some(&status) {
                statuses.push(status);
            }
        }
        statuses
    }

    #[test]
    fn confidence_down_and_up_again_goes_round_once() {
        let down = (0..=u16::MAX).rev();
        let up = 0..=u16::MAX;
        assert_eq!(
            statuses(down.chain(up)),
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
    fn no_status_alternates_at_a_constant_confidence() {
        for bits in 0..=u16::MAX {
            for start in [
                Status::Healthy,
                Status::Suspect,
                Status::Failed,
                Status::Recovering,
            ] {
                let next = |status: Status| status.next(&received(bits));
                let settled = next(next(start));
                assert_eq!(next(settled), settled, "{bits} from {start}");
            }
        }
    }

    #[test]
    fn the_limits_leave_a_gap() {
        let [failed, suspect, recovering, healthy] = [
            HealthRules::FAILED_BELOW,
            HealthRules::SUSPECT_BELOW,
            HealthRules::RECOVERING_FROM,
            HealthRules::HEALTHY_FROM,
        ];
        assert!(failed < suspect && suspect < healthy);
        assert!(failed < recovering && recovering <= healthy);
        let missing = [HealthRules::SUSPECT_MISSING, HealthRules::FAILED_MISSING];
        assert!(0 < missing[0] && missing[0] < missing[1]);
    }
}
