//! What cells behind a hit receive.

use super::{Choices, Open};
use certainty_core::fusion::Behind;

impl Open for Behind {
    const NAME: &'static str = "behind";
    const ALL: &'static [Self] = &[Self::Uncertain, Self::Untouched];

    fn name(self) -> &'static str {
        match self {
            Self::Uncertain => "uncertain",
            Self::Untouched => "untouched",
        }
    }

    fn reason(self) -> &'static str {
        match self {
            Self::Uncertain => "Fig. 1(b) draws .5 behind the obstacle, and §2 says so",
            Self::Untouched => "the .5 of Fig. 1(b) may be what cells start with",
        }
    }

    fn of(choices: &mut Choices) -> &mut Self {
        &mut choices.behind
    }
}
