//! How sure eq. 1 of \[001\] takes a single measurement to be.

use super::LogOdds;
use crate::certainty::Certainty;

/// The surest that one measurement may be, each way.
///
/// A measurement of *free* or *occupied* has infinite odds, which eq. 1 could never take back; and the
/// two ways are not alike. An echo comes from an obstacle somewhere in its cell. A beam that passes has
/// seen a line through the cell and not the cell, so that it passes many cells that hold an obstacle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Strength {
    /// Not above zero.
    free: LogOdds,
    /// Not below zero.
    occupied: LogOdds,
}

impl Strength {
    /// What the simulator's fault campaign chose: 0.29 and 0.9, the odds of -14/16 and 35/16 nat.
    ///
    /// Table 1 of \[001\] has sensors that err in 4 to 18 % of their readings, and nine to one is about
    /// what an echo of theirs is worth. How little a beam that passes is worth, the mean squared error of
    /// the maps over all faults decided.
    pub const MEASUREMENT: Self = Self::new(LogOdds::from_steps(-14), LogOdds::from_steps(35));

    /// What the fault campaign chose for a sensor's own grid: 0.29 and 0.98, the odds of -14/16 and 64/16
    /// nat.
    ///
    /// Surer of an echo than [`Self::MEASUREMENT`]: what is wrong in one sensor's grid the others outvote,
    /// while what it forgets nobody brings back.
    pub const OWN: Self = Self::new(LogOdds::from_steps(-14), LogOdds::from_steps(64));

    /// No limit but that of [`LogOdds`].
    pub const UNLIMITED: Self = Self::new(LogOdds::MIN, LogOdds::MAX);

    /// Creates the limits: the least odds that *free* may have, and the most that *occupied* may.
    ///
    /// Odds on the wrong side of even count as even: the measurement then says nothing that way.
    #[must_use]
    pub const fn new(free: LogOdds, occupied: LogOdds) -> Self {
        let even = LogOdds::EVEN;
        Self {
            free: if free.steps() < 0 { free } else { even },
            occupied: if occupied.steps() > 0 { occupied } else { even },
        }
    }

    /// Returns the odds of a measurement, within the limits.
    ///
    /// ```
    /// use certainty_core::certainty::Certainty;
    /// use certainty_core::fusion::Strength;
    ///
    /// assert_eq!(Strength::MEASUREMENT.odds(Certainty::FREE).steps(), -14);
    /// assert_eq!(Strength::MEASUREMENT.odds(Certainty::OCCUPIED).steps(), 35);
    /// assert_eq!(Strength::MEASUREMENT.odds(Certainty::UNCERTAIN).steps(), 0);
    /// ```
    #[must_use]
    #[inline]
    pub const fn odds(self, measurement: Certainty) -> LogOdds {
        let odds = LogOdds::of(measurement);
        if odds.steps() > self.occupied.steps() {
            self.occupied
        } else if odds.steps() < self.free.steps() {
            self.free
        } else {
            odds
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_measurement_is_within_the_limits_and_on_its_side() {
        let limits = Strength::new(LogOdds::from_steps(-8), LogOdds::from_steps(20));
        for bits in 0..=u8::MAX {
            let certainty = Certainty::from_bits(bits);
            let (exact, limited) = (
                LogOdds::of(certainty).steps(),
                limits.odds(certainty).steps(),
            );
            assert_eq!(limited, exact.clamp(-8, 20), "{bits}");
            assert_eq!(Strength::UNLIMITED.odds(certainty).steps(), exact);
        }
    }

    #[test]
    fn limits_on_the_wrong_side_silence_that_side() {
        let crossed = Strength::new(LogOdds::from_steps(5), LogOdds::from_steps(-5));
        for bits in 0..=u8::MAX {
            assert_eq!(crossed.odds(Certainty::from_bits(bits)), LogOdds::EVEN);
        }
    }
}
