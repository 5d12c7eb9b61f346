//! What the median is of an even number of sensors.

use super::{Choices, Open};
use certainty_core::fusion::Middle;

impl Open for Middle {
    const NAME: &'static str = "middle";
    const ALL: &'static [Self] = &[Self::Mean, Self::Higher];
    const AFTER: bool = true;

    fn name(self) -> &'static str {
        match self {
            Self::Mean => "mean",
            Self::Higher => "higher",
        }
    }

    fn reason(self) -> &'static str {
        match self {
            Self::Mean => "what the median of an even number commonly is",
            Self::Higher => "§4: the median value is selected; of the two, the one that says more",
        }
    }

    fn of(choices: &mut Choices) -> &mut Self {
        &mut choices.middle
    }
}
