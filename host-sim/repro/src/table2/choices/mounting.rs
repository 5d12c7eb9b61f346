//! Where the sensors sit.

use super::{Choices, Open};
use certainty_sim::simulation::HeadPlacement;

impl Open for HeadPlacement {
    const NAME: &'static str = "mounting";
    const ALL: &'static [Self] = &[Self::Bumper, Self::OnePoint];

    fn name(self) -> &'static str {
        match self {
            Self::Bumper => "bumper",
            Self::OnePoint => "one point",
        }
    }

    fn reason(self) -> &'static str {
        match self {
            Self::Bumper => "§2: a replicated sensor is always slightly offside",
            Self::OnePoint => "a simulation may leave that out",
        }
    }

    fn of(choices: &mut Choices) -> &mut Self {
        &mut choices.mounting
    }
}
