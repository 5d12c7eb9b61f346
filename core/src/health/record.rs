//! The health record of one sensor.

use super::confidence::Confidence;
use super::learning::{Claim, Confidences, Learning};
use super::status::{Condition, HealthRules, Status};
use crate::transducer::Reading;
use crate::units::Ticks;

/// The health of one sensor.
///
/// The grid changes the confidence and counts comparisons ([`Health::confirm`],
/// [`Health::contradict`]); the fusion level records readings and missing ones ([`Health::record`]);
/// [`Health::settle`] updates the status.
///
/// Memory: 32 bytes a sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Health {
    confirmations: u32,
    contradictions: u32,
    readings: u32,
    missing: u32,
    /// When the last reading came; before the first, when the status was first updated.
    silent_since: Ticks,
    confidences: Confidences,
    missing_in_a_row: u16,
    received_in_a_row: u16,
    started: bool,
    stale: bool,
    status: Status,
}

impl Health {
    /// Creates the record of a sensor with the first confidence `confidence`: an a-priori value or
    /// [`Confidence::FULL`] (\[002\] §4).
    #[must_use]
    pub const fn new(confidence: Confidence) -> Self {
        Self {
            confirmations: 0,
            contradictions: 0,
            readings: 0,
            missing: 0,
            silent_since: Ticks::new(0),
            confidences: Confidences {
                occupied: confidence,
                free: confidence,
            },
            missing_in_a_row: 0,
            received_in_a_row: 0,
            started: false,
            stale: false,
            status: Status::Healthy,
        }
    }

    /// Returns the confidence: the lower of those in the sensor's two [`Claim`]s, because the more
    /// frequent kind of error limits how reliable a sensor is.
    #[must_use]
    pub const fn confidence(&self) -> Confidence {
        let Confidences { occupied, free } = self.confidences;
        if occupied.to_bits() < free.to_bits() {
            occupied
        } else {
            free
        }
    }

    /// Returns the confidence that the sensor is correct when it makes this claim.
    #[must_use]
    pub const fn confidence_in(&self, claim: Claim) -> Confidence {
        match claim {
            Claim::Occupied => self.confidences.occupied,
            Claim::Free => self.confidences.free,
        }
    }

    /// Returns the number of cells about which the sensor agreed with another.
    #[must_use]
    pub const fn confirmations(&self) -> u32 {
        self.confirmations
    }

    /// Returns the number of cells about which the sensor disagreed with another.
    #[must_use]
    pub const fn contradictions(&self) -> u32 {
        self.contradictions
    }

    /// Returns the number of readings, without the missing ones.
    #[must_use]
    pub const fn readings(&self) -> u32 {
        self.readings
    }

    /// Returns the number of missing readings.
    #[must_use]
    pub const fn missing(&self) -> u32 {
        self.missing
    }

    /// Returns the number of missing readings since the last reading.
    #[must_use]
    pub const fn missing_in_a_row(&self) -> u16 {
        self.missing_in_a_row
    }

    /// Returns the number of readings since the last missing one.
    #[must_use]
    pub const fn received_in_a_row(&self) -> u16 {
        self.received_in_a_row
    }

    /// Returns when the last reading came; before the first, when the status was first updated.
    #[must_use]
    pub const fn silent_since(&self) -> Ticks {
        self.silent_since
    }

    /// Returns whether, at the last [`Self::settle`], the last reading was too long ago.
    #[must_use]
    pub const fn is_stale(&self) -> bool {
        self.stale
    }

    /// Returns the status.
    #[must_use]
    pub const fn status(&self) -> Status {
        self.status
    }

    /// Records a reading, or a missing one, at `now`.
    pub const fn record(&mut self, reading: Reading, now: Ticks) {
        if matches!(reading, Reading::Missing(_)) {
            self.missing = self.missing.saturating_add(1);
            self.missing_in_a_row = self.missing_in_a_row.saturating_add(1);
            self.received_in_a_row = 0;
        } else {
            self.readings = self.readings.saturating_add(1);
            self.missing_in_a_row = 0;
            // After a stale period the count restarts: one reading is no recovery.
            self.received_in_a_row = if self.stale {
                1
            } else {
                self.received_in_a_row.saturating_add(1)
            };
            self.stale = false;
            self.silent_since = now;
            self.started = true;
        }
    }

    /// Records a cell about which two sensors made the same claim; `inc` of \[001\] Fig. 3.
    #[inline]
    pub fn confirm([a, b]: [&mut Self; 2], claim: Claim, learning: &Learning) {
        a.confirmations = a.confirmations.saturating_add(1);
        b.confirmations = b.confirmations.saturating_add(1);
        learning.agree([&mut a.confidences, &mut b.confidences], claim);
    }

    /// Records a cell about which two sensors made different claims, `claims` in the order of the
    /// sensors; `dec` of \[001\] Fig. 3.
    #[inline]
    pub fn contradict([a, b]: [&mut Self; 2], claims: [Claim; 2], learning: &Learning) {
        a.contradictions = a.contradictions.saturating_add(1);
        b.contradictions = b.contradictions.saturating_add(1);
        learning.disagree([&mut a.confidences, &mut b.confidences], claims);
    }

    /// Updates the status from everything recorded up to `now`.
    ///
    /// The time without readings counts from the first call at the earliest, so that a clock that does
    /// not start at 0 makes no sensor stale.
    pub const fn settle(&mut self, rules: &HealthRules, now: Ticks) {
        if !self.started {
            self.started = true;
            self.silent_since = now;
        }
        // Latched until the next reading, because ages wrap after 24 days.
        self.stale |= now.since(self.silent_since) > rules.stale_after();
        self.status = self.status.next(&Condition {
            confidence: self.confidence(),
            missing_in_a_row: self.missing_in_a_row,
            received_in_a_row: self.received_in_a_row,
            stale: self.stale,
        });
    }
}

impl Default for Health {
    fn default() -> Self {
        Self::new(Confidence::FULL)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transducer::Missing;
    use crate::units::Millimeters;

    const ECHO: Reading = Reading::Echo(Millimeters::new(500));
    const TIMEOUT: Reading = Reading::Missing(Missing::Timeout);

    #[test]
    fn a_record_takes_32_bytes() {
        assert_eq!(size_of::<Health>(), 32);
    }

    /// Each sensor has its own timeout: a shared one lets the readings of one sensor hide the failure
    /// of another.
    #[test]
    fn one_sensor_can_fail_and_recover_while_another_works() {
        let rules = HealthRules::default();
        let (mut silent, mut active) = (Health::default(), Health::default());
        let limit = rules.stale_after();
        for now in 0..=limit.saturating_mul(2) {
            let now = Ticks::new(now);
            active.record(ECHO, now);
            active.settle(&rules, now);
            silent.settle(&rules, now);
            let over = now.get() > limit;
            assert_eq!(silent.is_stale(), over);
            assert_eq!(silent.status() == Status::Failed, over);
            assert_eq!(active.status(), Status::Healthy);
        }
        let back = Ticks::new(limit.saturating_mul(2));
        for received in 1..=HealthRules::HEALTHY_RECEIVED {
            assert_ne!(
                silent.status(),
                Status::Healthy,
                "after {received} readings"
            );
            silent.record(ECHO, back);
            silent.settle(&rules, back);
            // The readings of other sensors settle it too, and change nothing.
            silent.settle(&rules, back);
        }
        assert_eq!(silent.status(), Status::Healthy);
    }

    #[test]
    fn a_stale_sensor_stays_so_when_the_clock_wraps() {
        let rules = HealthRules::default();
        let mut health = Health::default();
        for now in [0, 3000, (1 << 31) - 1, (1 << 31) + 1, u32::MAX, 0, 1] {
            health.settle(&rules, Ticks::new(now));
            assert_eq!(health.status() == Status::Failed, health.is_stale());
        }
        assert!(health.is_stale());
    }

    #[test]
    fn one_reading_in_eleven_never_makes_healthy() {
        let rules = HealthRules::default();
        let mut health = Health::default();
        let now = Ticks::new(1);
        for turn in 1..200 {
            let reading = if turn % 11 == 0 { ECHO } else { TIMEOUT };
            health.record(reading, now);
            health.settle(&rules, now);
            health.settle(&rules, now);
            assert!(
                turn < 3 || health.status() != Status::Healthy,
                "turn {turn}"
            );
        }
    }

    #[test]
    fn a_clock_that_starts_late_makes_no_sensor_stale() {
        let rules = HealthRules::default();
        let mut health = Health::default();
        let start = 3_000_000_000;
        health.settle(&rules, Ticks::new(start));
        assert_eq!(health.status(), Status::Healthy);
        health.settle(&rules, Ticks::new(start + rules.stale_after()));
        assert_eq!(health.status(), Status::Healthy);
        health.settle(&rules, Ticks::new(start + rules.stale_after() + 1));
        assert_eq!(health.status(), Status::Failed);
    }

    #[test]
    fn missing_readings_in_a_row_make_a_sensor_suspect_and_then_failed() {
        let rules = HealthRules::default();
        let mut health = Health::default();
        let now = Ticks::new(1);
        let mut seen = [0_u16; 4];
        for _ in 0..HealthRules::FAILED_MISSING {
            health.record(TIMEOUT, now);
            health.settle(&rules, now);
            seen[health.status() as usize] += 1;
        }
        assert_eq!(
            seen[Status::Healthy as usize],
            HealthRules::SUSPECT_MISSING - 1
        );
        assert_eq!(
            seen[Status::Suspect as usize],
            HealthRules::FAILED_MISSING - HealthRules::SUSPECT_MISSING
        );
        assert_eq!(health.status(), Status::Failed);
        assert_eq!(health.missing(), u32::from(HealthRules::FAILED_MISSING));
    }
}
