//! Sets of numbers for `AddToGrid`, by their names on the command line.

use super::FusionRules;
use certainty_core::fusion::{RobustConfig, RobustRules};
use certainty_core::health::Learning;
use core::str::FromStr;
use fixed::types::{I2F14, U0F16};

/// Which numbers `AddToGrid` has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Rules {
    /// The defaults.
    Shipped,
    /// All agreement counts alike: \[001\] to the letter.
    Letter,
    /// The same in steps eight times as large, and with thresholds of ±0.1: confidence moves within
    /// tens of readings, that of sound sensors too.
    Coarse,
}

/// `AddToGrid` to the letter.
const LETTER: RobustRules = RobustRules::new(RobustConfig::TO_THE_LETTER);

/// The letter in large steps.
const COARSE: RobustRules = RobustRules::new(RobustConfig {
    confirmation: I2F14::from_bits(1638), // 0.1
    contradiction: I2F14::from_bits(-1638),
    learning: Learning {
        raise: U0F16::from_bits(1 << 10),
        raise_free: U0F16::from_bits(1 << 10),
        lower: U0F16::from_bits(7 << 10),
        ..RobustConfig::TO_THE_LETTER.learning
    },
    ..RobustConfig::TO_THE_LETTER
});

impl Rules {
    /// All of them, the defaults first.
    pub const ALL: [Self; 3] = [Self::Shipped, Self::Letter, Self::Coarse];

    /// Returns the name it has on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Shipped => "shipped",
            Self::Letter => "letter",
            Self::Coarse => "coarse",
        }
    }

    /// Returns the numbers.
    #[must_use]
    pub const fn robust(self) -> RobustRules {
        match self {
            Self::Shipped => RobustRules::DEFAULT,
            Self::Letter => LETTER,
            Self::Coarse => COARSE,
        }
    }

    /// Returns the methods' defaults with these numbers.
    #[must_use]
    pub fn fusion(self) -> FusionRules {
        FusionRules {
            robust: self.robust(),
            ..FusionRules::default()
        }
    }
}

/// The name is none of a set's.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' are no rules: write shipped, letter or coarse")]
pub struct UnknownRules(String);

impl FromStr for Rules {
    type Err = UnknownRules;

    fn from_str(text: &str) -> Result<Self, UnknownRules> {
        let found = Self::ALL.into_iter().find(|rules| rules.name() == text);
        found.ok_or_else(|| UnknownRules(text.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::health::FaultAttribution;

    #[test]
    fn names_are_read_back_and_others_refused() {
        for rules in Rules::ALL {
            assert_eq!(rules.name().parse(), Ok(rules));
        }
        assert!("Letter".parse::<Rules>().is_err());
    }

    #[test]
    fn only_the_shipped_rules_tell_free_from_occupied_agreement() {
        for rules in [Rules::Letter, Rules::Coarse].map(Rules::robust) {
            let learning = rules.config().learning;
            assert_eq!(learning.raise, learning.raise_free);
            assert_eq!(learning.attribution, FaultAttribution::Alike);
        }
        let shipped = Rules::Shipped.robust().config().learning;
        assert!(shipped.raise > shipped.raise_free);
    }
}
