//! The fusion methods by name, their open numbers, and named sets of numbers for `AddToGrid`.

use certainty_core::fusion::{Middle, RobustConfig, RobustRules, Strength};
use certainty_core::health::{HealthRules, Learning};
use core::fmt;
use core::str::FromStr;
use fixed::types::{I2F14, U0F16};

/// A fusion method, by its name on the command line and in reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Method {
    /// Eq. 1 of \[001\]: [`BayesGrid`](certainty_core::fusion::BayesGrid).
    Bayes,
    /// `AddToGrid`, \[001\] Fig. 3: [`RobustGrid`](certainty_core::fusion::RobustGrid).
    Robust,
    /// Trim, then eq. 1, \[000\] §3.1: [`TrimmedGrid`](certainty_core::fusion::TrimmedGrid).
    Trimmed,
    /// Median selection, \[000\] §3.2: [`MedianGrid`](certainty_core::fusion::MedianGrid).
    Median,
}

impl Method {
    /// Every method, in the order in which reports list them.
    pub const ALL: [Self; 4] = [Self::Bayes, Self::Robust, Self::Trimmed, Self::Median];

    /// Returns the method's name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bayes => "bayes",
            Self::Robust => "robust",
            Self::Trimmed => "trimmed",
            Self::Median => "median",
        }
    }

    /// Returns the number of cell layers that this method keeps for `sensors` sensors.
    #[must_use]
    pub const fn layers(self, sensors: u8) -> u64 {
        match self {
            Self::Bayes | Self::Robust => 1,
            Self::Trimmed | Self::Median => sensors as u64,
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name of no method.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("unknown fusion method '{0}': expected bayes, robust, trimmed or median")]
pub struct UnknownMethod(pub String);

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        let found = Self::ALL.into_iter().find(|method| method.name() == name);
        found.ok_or_else(|| UnknownMethod(name.to_owned()))
    }
}

/// How each sensor's own grid is kept by the trimmed and the median method; \[000\] §3.1 leaves it open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Own {
    /// The cell holds the sensor's latest measurement.
    Latest,
    /// The cell holds the sensor's measurements, fused by eq. 1.
    Accumulated,
}

/// The input of eq. 1 of \[001\] for the measurements *free* and *occupied*.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Landmarks {
    /// Odds of at most [`FusionRules::strongest`].
    Bounded,
    /// Probabilities of 0 and 1, which no later measurement changes.
    Literal,
}

/// The open numbers of the methods; the defaults are the core's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FusionRules {
    /// How each sensor's own grid is kept; the trimmed and the median method.
    pub own: Own,
    /// The strongest measurement in a sensor's own grid that accumulates.
    pub own_strongest: Strength,
    /// The median of an even number of sensors; the median method.
    pub middle: Middle,
    /// The certainties that are dropped at each end; the trimmed method. None: the most that the number of
    /// sensors allows, ⌊(n − 1)/2⌋; then a cell that one sensor of an odd number did not see is *uncertain*. A
    /// larger one is limited to that.
    pub trim: Option<u8>,
    /// The strongest measurement; the Bayes method.
    pub strongest: Strength,
    /// Whether that bound applies; the Bayes method. The others always apply theirs.
    pub landmarks: Landmarks,
    /// The open numbers of `AddToGrid`; the robust method.
    pub robust: RobustRules,
    /// The thresholds of a sensor's status; every method.
    pub health: HealthRules,
}

impl FusionRules {
    /// Returns how many certainties the trimmed method drops at each end, of `sensors` sensors: at most
    /// ⌊(n − 1)/2⌋, any minority.
    #[must_use]
    pub fn trimmed(&self, sensors: u8) -> u8 {
        let most = sensors.saturating_sub(1) / 2;
        self.trim.unwrap_or(most).min(most)
    }
}

impl Default for FusionRules {
    /// Each sensor accumulates its own grid: beams a few degrees apart cross the same cells, and the
    /// latest measurement of a beam that grazes an obstacle's cell would erase a dozen before it.
    fn default() -> Self {
        Self {
            own: Own::Accumulated,
            own_strongest: Strength::OWN,
            middle: Middle::Higher,
            trim: None,
            strongest: Strength::MEASUREMENT,
            landmarks: Landmarks::Bounded,
            robust: RobustRules::DEFAULT,
            health: HealthRules::DEFAULT,
        }
    }
}

/// A named set of numbers for `AddToGrid`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Rules {
    /// The defaults.
    Shipped,
    /// All agreement counts alike: \[001\] to the letter.
    Letter,
    /// The same with steps eight times as large, and with thresholds of ±0.1: confidence changes within
    /// tens of readings, also that of sound sensors.
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

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::health::FaultAttribution;

    #[test]
    fn only_shipped_rules_weigh_free_agreement_apart() {
        for rules in [Rules::Letter, Rules::Coarse].map(Rules::robust) {
            let learning = rules.config().learning;
            assert_eq!(learning.raise, learning.raise_free);
            assert_eq!(learning.attribution, FaultAttribution::Alike);
        }
        let shipped = Rules::Shipped.robust().config().learning;
        assert!(shipped.raise > shipped.raise_free);
    }

    #[test]
    fn methods_are_parsed_by_name() {
        for method in Method::ALL {
            assert_eq!(method.name().parse(), Ok(method));
        }
        assert_eq!(
            "Bayes".parse::<Method>(),
            Err(UnknownMethod("Bayes".into()))
        );
    }
}
