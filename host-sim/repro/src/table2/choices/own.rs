//! How each sensor's own grid is kept.

use super::{Choices, Open};
use certainty_sim::fusion::Own;

impl Open for Own {
    const NAME: &'static str = "own";
    const ALL: &'static [Self] = &[Self::Accumulated, Self::Latest];
    const AFTER: bool = true;

    fn name(self) -> &'static str {
        match self {
            Self::Accumulated => "accumulated",
            Self::Latest => "latest",
        }
    }

    fn reason(self) -> &'static str {
        match self {
            Self::Accumulated => "§4: each sensor produces its own grid, and §3 fuses one by eq. 1",
            Self::Latest => "§4: a separate entry of an occupancy value for each sensor",
        }
    }

    fn of(choices: &mut Choices) -> &mut Self {
        &mut choices.own
    }
}
