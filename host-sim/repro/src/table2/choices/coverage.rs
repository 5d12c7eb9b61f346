//! How much of the arc every sensor sweeps.

use super::{Choices, Open};
use certainty_sim::simulation::SweepOverlap;

impl Open for SweepOverlap {
    const NAME: &'static str = "coverage";
    const ALL: &'static [Self] = &[Self::Full, Self::Partial];

    fn name(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::Partial => "partial",
        }
    }

    fn reason(self) -> &'static str {
        match self {
            Self::Full => "§4: the fault-tolerant grid needs three sensors at every cell",
            Self::Partial => "Fig. 1(a) draws three areas that overlap in part",
        }
    }

    fn against(self) -> Option<&'static str> {
        match self {
            Self::Full => None,
            Self::Partial => Some("§4: a cell that fewer than three see is not fault-tolerant"),
        }
    }

    fn of(choices: &mut Choices) -> &mut Self {
        &mut choices.coverage
    }
}
