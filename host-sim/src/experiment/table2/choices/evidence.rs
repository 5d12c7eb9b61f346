//! How sure one measurement is to eq. 1.

use super::{Choices, Open};
use crate::fusion::{FusionRules, Landmarks};
use certainty_core::fusion::LogOdds;

/// What a measurement of *free* or *occupied* is worth to the Bayes grid, and to the trimmed one on
/// latest words.
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
    pub(in crate::experiment::table2) const fn set(self, rules: &mut FusionRules) {
        match self {
            Self::Nine => rules.strongest = LogOdds::from_steps(35),
            Self::FortyNine => rules.strongest = LogOdds::from_steps(62),
            Self::Hard => {
                rules.strongest = LogOdds::MAX;
                rules.landmarks = Landmarks::Literal;
            }
        }
    }
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

    #[test]
    fn the_odds_are_those_of_the_name() {
        for (evidence, p) in [(Evidence::Nine, 0.9), (Evidence::FortyNine, 0.98)] {
            let mut rules = FusionRules::default();
            evidence.set(&mut rules);
            let exact: f64 = 16.0 * (p / (1.0_f64 - p)).ln();
            assert_eq!(f64::from(rules.strongest.steps()), exact.round());
            assert_eq!(rules.landmarks, Landmarks::Bounded);
        }
    }
}
