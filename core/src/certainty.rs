//! The 8-bit probability that a place is occupied.

use core::fmt;
use fixed::types::U0F8;

/// The probability that a cell is occupied, in steps of 1/256.
///
/// The landmarks are those of \[001\] §6.1: 0 is *free*, 128 *uncertain*, 255 *occupied*. There are
/// 128 steps below *uncertain* and 127 above it, so [`Self::deviation`] reaches −128 and +127.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct Certainty(u8);

impl Certainty {
    /// Certainly no obstacle.
    pub const FREE: Self = Self(0);
    /// Nothing is known: the maximum-entropy assumption of \[001\] §2.
    pub const UNCERTAIN: Self = Self(128);
    /// Certainly an obstacle.
    pub const OCCUPIED: Self = Self(255);

    /// Creates a certainty from the byte that a cell stores.
    #[must_use]
    pub const fn from_bits(bits: u8) -> Self {
        Self(bits)
    }

    /// Returns the byte that a cell stores.
    #[must_use]
    pub const fn to_bits(self) -> u8 {
        self.0
    }

    /// Returns the probability of being occupied as a fixed-point number.
    ///
    /// 128 is exactly 0.5; 255 is 0.996, the nearest that eight bits come to 1.
    #[must_use]
    pub const fn probability(self) -> U0F8 {
        U0F8::from_bits(self.0)
    }

    /// Returns how far this is from *uncertain*: `occ − 0.5` of \[001\] Fig. 3, in steps of 1/256.
    ///
    /// Units and range: `-128` (at [`Self::FREE`]) to `127` (at [`Self::OCCUPIED`]).
    #[must_use]
    pub const fn deviation(self) -> i8 {
        (self.0 ^ 0x80).cast_signed()
    }

    /// Creates the certainty that is `deviation` steps from *uncertain*.
    #[must_use]
    pub const fn from_deviation(deviation: i8) -> Self {
        Self(deviation.cast_unsigned() ^ 0x80)
    }
}

impl Default for Certainty {
    fn default() -> Self {
        Self::UNCERTAIN
    }
}

impl fmt::Display for Certainty {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviation_is_the_byte_less_one_half() {
        for bits in 0..=u8::MAX {
            let certainty = Certainty::from_bits(bits);
            assert_eq!(i16::from(certainty.deviation()), i16::from(bits) - 128);
            assert_eq!(Certainty::from_deviation(certainty.deviation()), certainty);
        }
    }
}
