//! Which cells are compared.

use super::{Choices, Open};
use certainty_sim::simulation::ScoredCells;

impl Open for ScoredCells {
    const NAME: &'static str = "scored";
    const ALL: &'static [Self] = &[Self::All, Self::Known];
    const AFTER: bool = true;

    fn name(self) -> &'static str {
        match self {
            Self::All => "all",
            Self::Known => "known",
        }
    }

    fn reason(self) -> &'static str {
        match self {
            Self::All => "§6.2: the value of each grid cell has been compared",
            Self::Known => "cells that no sensor sees are alike in every grid",
        }
    }

    fn against(self) -> Option<&'static str> {
        match self {
            Self::All => None,
            Self::Known => Some("§6.2: the value of each grid cell has been compared"),
        }
    }

    fn of(choices: &mut Choices) -> &mut Self {
        &mut choices.scored
    }
}
