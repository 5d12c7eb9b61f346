//! What Table 1 calls accuracy.

use super::{Choices, Open};

/// What the first column of \[001\] Table 1 measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Accuracy {
    /// The standard deviation of the relative error.
    Deviation,
    /// A bound that 95 % of the relative errors keep to: two standard deviations.
    Bound,
}

impl Accuracy {
    /// Returns how many standard deviations the printed figure is.
    #[must_use]
    pub const fn deviations(self) -> f64 {
        match self {
            Self::Deviation => 1.0,
            Self::Bound => 2.0,
        }
    }
}

impl Open for Accuracy {
    const NAME: &'static str = "accuracy";
    const ALL: &'static [Self] = &[Self::Deviation, Self::Bound];

    fn name(self) -> &'static str {
        match self {
            Self::Deviation => "deviation",
            Self::Bound => "bound",
        }
    }

    fn reason(self) -> &'static str {
        match self {
            Self::Deviation => "§6.1: the statistical behaviour, from histograms of the errors",
            Self::Bound => "data sheets give accuracies as bounds",
        }
    }

    fn of(choices: &mut Choices) -> &mut Self {
        &mut choices.accuracy
    }
}
