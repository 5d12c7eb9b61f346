//! How far around an echo cells are told that they are occupied.

use super::{Choices, Open};

/// Half of the occupied spread, in standard deviations of the distance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spread {
    /// None: the cell of the echo alone.
    None,
    /// One.
    One,
    /// Two: 95 % of the errors.
    Two,
}

impl Spread {
    /// Returns the number of standard deviations.
    #[must_use]
    pub const fn deviations(self) -> f64 {
        match self {
            Self::None => 0.0,
            Self::One => 1.0,
            Self::Two => 2.0,
        }
    }
}

impl Open for Spread {
    const NAME: &'static str = "spread";
    const ALL: &'static [Self] = &[Self::None, Self::One, Self::Two];

    fn name(self) -> &'static str {
        match self {
            Self::None => "0",
            Self::One => "1",
            Self::Two => "2",
        }
    }

    fn reason(self) -> &'static str {
        match self {
            Self::None => "Fig. 1(b) draws 0, .5 and 1 and nothing between",
            Self::One => "§3: a probabilistic sensor model takes uncertainties into account",
            Self::Two => "the same; 95 % of the errors, as the shipped car has it",
        }
    }

    fn of(choices: &mut Choices) -> &mut Self {
        &mut choices.spread
    }
}
