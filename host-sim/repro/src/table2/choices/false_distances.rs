//! What a sensor says that fails to see that there is no object.

use super::{Choices, Open};

/// Where the distance comes from that stands for *no object* with Table 1's `P_failed_inf`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FalseDistances {
    /// Uniformly from the far half of the range.
    FarHalf,
    /// Uniformly from all of it.
    WholeRange,
}

impl FalseDistances {
    /// Returns the part of the range, 0 being its nearest distance and 1 its farthest.
    #[must_use]
    pub const fn part(self) -> (f64, f64) {
        match self {
            Self::FarHalf => (0.5, 1.0),
            Self::WholeRange => (0.0, 1.0),
        }
    }
}

impl Open for FalseDistances {
    const NAME: &'static str = "false_distances";
    const ALL: &'static [Self] = &[Self::FarHalf, Self::WholeRange];

    fn name(self) -> &'static str {
        match self {
            Self::FarHalf => "far half",
            Self::WholeRange => "whole range",
        }
    }

    fn reason(self) -> &'static str {
        match self {
            Self::FarHalf => {
                "§6.1: hard to tell a measurement from none; so it is, where both are faint"
            }
            Self::WholeRange => "the text does not say which distance",
        }
    }

    fn of(choices: &mut Choices) -> &mut Self {
        &mut choices.false_distances
    }
}
