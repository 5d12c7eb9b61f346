//! How sure one measurement is to eq. 1.

use super::{Choices, Open};
use certainty_core::fusion::{LogOdds, Strength};
use certainty_sim::fusion::{FusionRules, Landmarks};

/// What a measurement of *free* or *occupied* is worth to the Bayes grid.
///
/// A sensor's own grid that accumulates takes it for p = 0.1 or 0.9, whatever Bayes is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Evidence {
    /// p = 0.1 or 0.9.
    Nine,
    /// p = 0.02 or 0.98.
    FortyNine,
    /// p = 0 or 1, which eq. 1 never takes back.
    Hard,
}

impl Evidence {
    /// Sets what the methods are told.
    pub(in crate::table2) const fn set(self, rules: &mut FusionRules) {
        rules.own_strongest = both_ways(35);
        match self {
            Self::Nine => rules.strongest = both_ways(35),
            Self::FortyNine => rules.strongest = both_ways(62),
            Self::Hard => {
                rules.strongest = Strength::UNLIMITED;
                rules.landmarks = Landmarks::Literal;
            }
        }
    }
}

/// As sure of *free* as of *occupied*, in steps of log-odds.
const fn both_ways(steps: i8) -> Strength {
    Strength::new(LogOdds::from_steps(-steps), LogOdds::from_steps(steps))
}

impl Open for Evidence {
    const NAME: &'static str = "evidence";
    const ALL: &'static [Self] = &[Self::Nine, Self::FortyNine, Self::Hard];
    const AFTER: bool = true;

    fn name(self) -> &'static str {
        match self {
            Self::Nine => "0.9",
            Self::FortyNine => "0.98",
            Self::Hard => "hard",
        }
    }

    fn reason(self) -> &'static str {
        match self {
            Self::Nine => "§3 takes uncertainties into account; Table 1 errs in up to 18 %",
            Self::FortyNine => "a common sensor model; nearer to the 0 and 1 of Fig. 1(b)",
            Self::Hard => "Fig. 1(b) draws 0 and 1, though eq. 1 divides by zero there",
        }
    }

    fn of(choices: &mut Choices) -> &mut Self {
        &mut choices.evidence
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::certainty::Certainty;

    #[test]
    fn the_odds_are_those_of_the_name() {
        for (evidence, p) in [(Evidence::Nine, 0.9), (Evidence::FortyNine, 0.98)] {
            let mut rules = FusionRules::default();
            evidence.set(&mut rules);
            let exact: f64 = 16.0 * (p / (1.0_f64 - p)).ln();
            let told = rules.strongest.odds(Certainty::OCCUPIED);
            assert_eq!(f64::from(told.steps()), exact.round());
            assert_eq!(rules.strongest.odds(Certainty::FREE).steps(), -told.steps());
            assert_eq!(rules.landmarks, Landmarks::Bounded);
        }
    }
}
