//! How much of what lies ahead is seen by sensors that can be believed.

use super::motion::{bounded, scaled};
use super::{Effort, PerRangefinder, RANGEFINDERS};

/// What each sensor sees of what lies ahead, and how much must be seen.
///
/// \[004\] has no such rule in its simulations; in its experiments it drove slower by hand, "especially
/// in case of laser scanner failure" (§5).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CoverageConfig {
    /// What each rangefinder sees, of all that a robot at full speed must; the first half looks to
    /// the left, as in \[004\] eq. 4.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub rangefinders: PerRangefinder<Effort>,
    /// What the scanner sees.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub scanner: Effort,
    /// The robot stands still where less than this is seen.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub least: Effort,
}

/// How much of what lies ahead is seen: 1 is enough for full speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Coverage(#[cfg_attr(feature = "defmt", defmt(Display2Format))] Effort);

impl Coverage {
    /// Returns what sensors see of which so much is left: 1 less their failure, 0 of a sensor that is
    /// silent.
    ///
    /// Formula: the scanner's seen · left and twice Σ seen · left of the rangefinders on the side that
    /// sees less, at most 1. What is seen on the right is no help against what stands on the left.
    #[must_use]
    pub fn of(config: &CoverageConfig, left: &PerRangefinder<Effort>, scanner: Effort) -> Self {
        const HALF: usize = RANGEFINDERS / 2;
        let parts = || config.rangefinders.iter().zip(left);
        let sum = |sum: Effort, (&sees, &left): (&Effort, &Effort)| {
            sum.saturating_add(scaled(left, sees))
        };
        let on_the_left = parts().take(HALF).fold(Effort::ZERO, sum);
        let on_the_right = parts().skip(HALF).fold(Effort::ZERO, sum);
        let weaker = on_the_left.min(on_the_right);
        let both = weaker.saturating_add(weaker);
        let seen = scaled(scanner, config.scanner).saturating_add(both);
        Self(bounded(seen, Effort::ZERO, Effort::ONE))
    }

    /// Returns the part, 0..=1.
    #[must_use]
    pub const fn part(self) -> Effort {
        self.0
    }

    /// Returns the fastest that is allowed: as much of full speed as is seen, nothing below the least.
    #[must_use]
    pub fn fastest(self, config: &CoverageConfig) -> Effort {
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

    fn config() -> CoverageConfig {
        CoverageConfig {
            rangefinders: [0.25, 0.125, 0.0, 0.0, 0.125, 0.25].map(Effort::from_num),
            scanner: Effort::ONE,
            least: Effort::lit("0.25"),
        }
    }

    fn fastest(left: [f64; 6], scanner: f64) -> f64 {
        let coverage = Coverage::of(
            &config(),
            &left.map(Effort::from_num),
            Effort::from_num(scanner),
        );
        coverage.fastest(&config()).to_num()
    }

    /// PEERS: a dead sensor must not stop everything.
    #[test]
    fn one_dead_sensor_does_not_stop_the_robot() {
        for dead in 0..6 {
            let mut left = [1.0; 6];
            left[dead] = 0.0;
            assert_eq!(fastest(left, 1.0), 1.0, "rangefinder {}", dead + 1);
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
