//! How the 1560 measurements are divided.

use super::{Choices, Open};

/// Directions × sweeps × layouts: 130 looks of every sensor, so 130 · (3 + 4 + 5) = 1560 measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sweeps {
    /// 13 directions, one sweep, ten layouts.
    D13S1L10,
    /// 26 directions, one sweep, five layouts.
    D26S1L5,
    /// 13 directions, two sweeps, five layouts.
    D13S2L5,
    /// 13 directions, five sweeps, two layouts.
    D13S5L2,
    /// 65 directions, one sweep, two layouts.
    D65S1L2,
}

impl Sweeps {
    /// Returns the directions of a sweep.
    #[must_use]
    pub const fn directions(self) -> u16 {
        match self {
            Self::D13S1L10 | Self::D13S2L5 | Self::D13S5L2 => 13,
            Self::D26S1L5 => 26,
            Self::D65S1L2 => 65,
        }
    }

    /// Returns the sweeps that a grid is built from.
    #[must_use]
    pub const fn sweeps(self) -> u32 {
        match self {
            Self::D13S1L10 | Self::D26S1L5 | Self::D65S1L2 => 1,
            Self::D13S2L5 => 2,
            Self::D13S5L2 => 5,
        }
    }

    /// Returns the obstacle layouts.
    #[must_use]
    pub const fn layouts(self) -> u32 {
        match self {
            Self::D13S1L10 => 10,
            Self::D26S1L5 | Self::D13S2L5 => 5,
            Self::D13S5L2 | Self::D65S1L2 => 2,
        }
    }
}

impl Open for Sweeps {
    const NAME: &'static str = "sweeps";
    const ALL: &'static [Self] = &[
        Self::D13S1L10,
        Self::D26S1L5,
        Self::D13S2L5,
        Self::D13S5L2,
        Self::D65S1L2,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::D13S1L10 => "13x1x10",
            Self::D26S1L5 => "26x1x5",
            Self::D13S2L5 => "13x2x5",
            Self::D13S5L2 => "13x5x2",
            Self::D65S1L2 => "65x1x2",
        }
    }

    fn reason(self) -> &'static str {
        match self {
            Self::D13S1L10 => "1560 = 13·12·10: straight ahead is one of 13 directions",
            Self::D26S1L5 => "a finer sweep, five layouts",
            Self::D13S2L5 => "\"swept around\" may be to and fro",
            Self::D13S5L2 => "\"swept around\" may be again and again",
            Self::D65S1L2 => "so fine that no cell is left out",
        }
    }

    fn of(choices: &mut Choices) -> &mut Self {
        &mut choices.sweeps
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_division_takes_1560_measurements_and_is_named_after_it() {
        for &division in Sweeps::ALL {
            let (directions, sweeps, layouts) = (
                u32::from(division.directions()),
                division.sweeps(),
                division.layouts(),
            );
            assert_eq!(directions * sweeps * layouts * (3 + 4 + 5), 1560);
            assert_eq!(division.name(), format!("{directions}x{sweeps}x{layouts}"));
        }
    }
}
