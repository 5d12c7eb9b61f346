//! One sensor's record.

use super::{Claim, Confidence, HealthRules, Learning, Status, learning::Beliefs};
use crate::transducer::Reading;
use crate::units::Ticks;

/// What is known about one sensor's condition.
///
/// The grid raises and lowers the confidence and counts what it compared; the fusion level records
/// which readings came and which were missing; [`Health::settle`] draws the conclusion.
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
    /// The last reading, or when watching began.
    silent_since: Ticks,
    beliefs: Beliefs,
    missing_in_a_row: u16,
    heard_in_a_row: u16,
    watched: bool,
    stale: bool,
    status: Status,
}

impl Health {
    /// Creates the record of a sensor that starts with `confidence`, an a-priori value or
    /// [`Confidence::FULL`] (\[002\] §4).
    #[must_use]
    pub const fn new(confidence: Confidence) -> Self {
        Self {
            confirmations: 0,
            contradictions: 0,
            readings: 0,
            missing: 0,
            silent_since: Ticks::new(0),
            beliefs: Beliefs {
                occupied: confidence,
                free: confidence,
            },
            missing_in_a_row: 0,
            heard_in_a_row: 0,
            watched: false,
            stale: false,
            status: Status::Healthy,
        }
    }

    /// Returns the confidence: the lesser of those in the sensor's two [`Claim`]s, as a sensor is no
    /// better than the way in which it errs more.
    #[must_use]
    pub const fn confidence(&self) -> Confidence {
        let Beliefs { occupied, free } = self.beliefs;
        if occupied.to_bits() < free.to_bits() {
            occupied
        } else {
            free
        }
    }

    /// Returns the confidence in what the sensor says when it says `word`.
    #[must_use]
    pub const fn confidence_in(&self, word: Claim) -> Confidence {
        match word {
            Claim::Occupied => self.beliefs.occupied,
            Claim::Free => self.beliefs.free,
        }
    }

    /// Returns how many cells the sensor and another one agreed on.
    #[must_use]
    pub const fn confirmations(&self) -> u32 {
        self.confirmations
    }

    /// Returns how many cells the sensor and another one disagreed on.
    #[must_use]
    pub const fn contradictions(&self) -> u32 {
        self.contradictions
    }

    /// Returns how many readings the sensor delivered, missing ones not among them.
    #[must_use]
    pub const fn readings(&self) -> u32 {
        self.readings
    }

    /// Returns how many readings were missing.
    #[must_use]
    pub const fn missing(&self) -> u32 {
        self.missing
    }

    /// Returns how many readings have been missing since the last that came.
    #[must_use]
    pub const fn missing_in_a_row(&self) -> u16 {
        self.missing_in_a_row
    }

    /// Returns how many readings have come since the last that was missing.
    #[must_use]
    pub const fn heard_in_a_row(&self) -> u16 {
        self.heard_in_a_row
    }

    /// Returns since when the sensor has been silent: its last reading, or, before the first, when it
    /// was first watched.
    #[must_use]
    pub const fn silent_since(&self) -> Ticks {
        self.silent_since
    }

    /// Returns whether the sensor had been silent for too long when last asked.
    #[must_use]
    pub const fn is_stale(&self) -> bool {
        self.stale
    }

    /// Returns the conclusion.
    #[must_use]
    pub const fn status(&self) -> Status {
        self.status
    }

    /// Records a turn of the sensor: what it said, or that it said nothing.
    pub const fn record(&mut self, reading: Reading, now: Ticks) {
        if matches!(reading, Reading::Missing(_)) {
            self.missing = self.missing.saturating_add(1);
            self.missing_in_a_row = self.missing_in_a_row.saturating_add(1);
            self.heard_in_a_row = 0;
        } else {
            self.readings = self.readings.saturating_add(1);
            self.missing_in_a_row = 0;
            // After a silence the count starts anew: one reading is no recovery.
            self.heard_in_a_row = if self.stale {
                1
            } else {
                self.heard_in_a_row.saturating_add(1)
            };
            self.stale = false;
            self.silent_since = now;
            self.watched = true;
        }
    }

    /// Records a cell that both sensors called `word`; `inc` of \[001\] Fig. 3.
    #[inline]
    pub fn confirm([a, b]: [&mut Self; 2], word: Claim, learning: &Learning) {
        a.confirmations = a.confirmations.saturating_add(1);
        b.confirmations = b.confirmations.saturating_add(1);
        learning.agree([&mut a.beliefs, &mut b.beliefs], word);
    }

    /// Records a cell that the two sensors called `words`, which contradict each other; `dec` of
    /// \[001\] Fig. 3.
    #[inline]
    pub fn contradict([a, b]: [&mut Self; 2], words: [Claim; 2], learning: &Learning) {
        a.contradictions = a.contradictions.saturating_add(1);
        b.contradictions = b.contradictions.saturating_add(1);
        learning.disagree([&mut a.beliefs, &mut b.beliefs], words);
    }

    /// Draws the conclusion from everything recorded up to `now`.
    ///
    /// The first call starts the watch: a sensor that was never heard is stale only after the same
    /// silence as any other, whatever the clock showed when it all began.
    pub const fn settle(&mut self, rules: &HealthRules, now: Ticks) {
        if !self.watched {
            self.watched = true;
            self.silent_since = now;
        }
        // Latched until the next reading: ages wrap after 24 days, a dead sensor stays dead.
        self.stale |= now.since(self.silent_since) > rules.config().stale_after;
        self.status = rules.next(self.status, self);
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
    fn a_record_is_as_small_as_it_says() {
        assert_eq!(size_of::<Health>(), 32);
    }

    /// PEERS: a shared timeout let one live sensor hide a dead one (nav2); elsewhere a dead one
    /// stopped everything, or went unnoticed.
    #[test]
    fn a_silent_sensor_is_seen_while_the_others_live_and_comes_back_by_itself() {
        let rules = HealthRules::default();
        let (mut dead, mut live) = (Health::default(), Health::default());
        let patience = rules.config().stale_after;
        for now in 0..=patience.saturating_mul(2) {
            let now = Ticks::new(now);
            live.record(ECHO, now);
            live.settle(&rules, now);
            dead.settle(&rules, now);
            let over = now.get() > patience;
            assert_eq!(dead.is_stale(), over);
            assert_eq!(dead.status() == Status::Failed, over);
            assert_eq!(live.status(), Status::Healthy);
        }
        let back = Ticks::new(patience.saturating_mul(2));
        for heard in 1..=rules.config().healthy_heard {
            assert_ne!(dead.status(), Status::Healthy, "after {heard} readings");
            dead.record(ECHO, back);
            dead.settle(&rules, back);
            // The turns of other sensors settle it too, and change nothing.
            dead.settle(&rules, back);
        }
        assert_eq!(dead.status(), Status::Healthy);
    }

    #[test]
    fn a_dead_sensor_stays_dead_when_the_clock_comes_round() {
        let rules = HealthRules::default();
        let mut health = Health::default();
        for now in [0, 3000, (1 << 31) - 1, (1 << 31) + 1, u32::MAX, 0, 1] {
            health.settle(&rules, Ticks::new(now));
            assert_eq!(health.status() == Status::Failed, health.is_stale());
        }
        assert!(health.is_stale());
    }

    #[test]
    fn a_sensor_that_answers_one_time_in_eleven_is_never_healthy_again() {
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
        health.settle(&rules, Ticks::new(start + rules.config().stale_after));
        assert_eq!(health.status(), Status::Healthy);
        health.settle(&rules, Ticks::new(start + rules.config().stale_after + 1));
        assert_eq!(health.status(), Status::Failed);
    }

    #[test]
    fn missing_readings_in_a_row_make_a_sensor_suspect_and_then_failed() {
        let rules = HealthRules::default();
        let mut health = Health::default();
        let now = Ticks::new(1);
        let mut seen = [0_u16; 4];
        for _ in 0..rules.config().failed_missing {
            health.record(TIMEOUT, now);
            health.settle(&rules, now);
            seen[health.status() as usize] += 1;
        }
        let config = rules.config();
        assert_eq!(seen[Status::Healthy as usize], config.suspect_missing - 1);
        assert_eq!(
            seen[Status::Suspect as usize],
            config.failed_missing - config.suspect_missing
        );
        assert_eq!(health.status(), Status::Failed);
        assert_eq!(health.missing(), u32::from(config.failed_missing));
    }
}
