//! Three words for a certainty.

use certainty_core::certainty::Certainty;
use serde::Serialize;

/// What a cell is held to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CellState {
    /// No obstacle.
    Free,
    /// Neither is known.
    Unknown,
    /// An obstacle.
    Occupied,
}

impl CellState {
    /// From this probability up, in thousandths, a cell is occupied.
    pub const OCCUPIED_FROM: u32 = 650;
    /// Up to this probability, in thousandths, a cell is free.
    ///
    /// It is below the 0.19608 that the pixel 205 means, by which ROS maps say *unknown*.
    pub const FREE_UP_TO: u32 = 196;

    /// Classifies a certainty; the probability is its byte in steps of 1/256.
    ///
    /// So a byte of 167 (0.652) or more is occupied and one of 50 (0.195) or less is free.
    ///
    /// ```
    /// use certainty_core::certainty::Certainty;
    /// use certainty_sim::export::CellState;
    ///
    /// assert_eq!(CellState::of(Certainty::UNCERTAIN), CellState::Unknown);
    /// assert_eq!(CellState::of(Certainty::from_bits(167)), CellState::Occupied);
    /// assert_eq!(CellState::of(Certainty::from_bits(50)), CellState::Free);
    /// ```
    #[must_use]
    pub const fn of(certainty: Certainty) -> Self {
        let thousand_256ths = certainty.to_bits() as u32 * 1000;
        if thousand_256ths >= Self::OCCUPIED_FROM * 256 {
            Self::Occupied
        } else if thousand_256ths <= Self::FREE_UP_TO * 256 {
            Self::Free
        } else {
            Self::Unknown
        }
    }

    /// Whether the cell is free or occupied.
    #[must_use]
    pub const fn is_known(self) -> bool {
        !matches!(self, Self::Unknown)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_is_what_its_probability_says() {
        for bits in 0..=u8::MAX {
            let probability = f64::from(bits) / 256.0;
            let expected = if probability >= 0.65 {
                CellState::Occupied
            } else if probability <= 0.196 {
                CellState::Free
            } else {
                CellState::Unknown
            };
            assert_eq!(
                CellState::of(Certainty::from_bits(bits)),
                expected,
                "{bits}"
            );
        }
    }
}
