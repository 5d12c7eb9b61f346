//! A sensor's confidence.

use crate::narrow::wrapping_u16;
use fixed::types::U0F16;

/// The probability that a sensor is correct: 0 is *appears to be wrong*, 1 *appears to be correct*
/// (\[002\] §4).
///
/// Units and range: steps of 2^-16, 0 to 65535; the largest, 0.99998, stands for 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct Confidence(u16);

impl Confidence {
    /// The sensor appears to be wrong.
    pub const NONE: Self = Self(0);
    /// The sensor appears to be correct.
    pub const FULL: Self = Self(u16::MAX);

    /// Creates a confidence of `bits` / 2^16.
    #[must_use]
    pub const fn from_bits(bits: u16) -> Self {
        Self(bits)
    }

    /// Returns the confidence in steps of 2^-16.
    #[must_use]
    pub const fn to_bits(self) -> u16 {
        self.0
    }

    /// Creates the confidence `value`.
    ///
    /// ```
    /// use certainty_core::health::Confidence;
    /// use fixed::types::U0F16;
    ///
    /// assert_eq!(Confidence::new(U0F16::lit("0.5")).to_bits(), 1 << 15);
    /// ```
    #[must_use]
    pub const fn new(value: U0F16) -> Self {
        Self(value.to_bits())
    }

    /// Returns the confidence as a fixed-point number.
    #[must_use]
    pub const fn value(self) -> U0F16 {
        U0F16::from_bits(self.0)
    }

    /// Returns the confidence raised by `step`, to `ceiling` at most; unchanged if it is above that.
    ///
    /// `inc` of \[001\] Fig. 3.
    #[must_use]
    pub const fn raised(self, step: U0F16, ceiling: Self) -> Self {
        let (step, missing) = (step.to_bits() as u32, self.missing_to(ceiling));
        self.up(if step > missing { missing } else { step })
    }

    /// Returns the confidence lowered by `step`, to `floor` at least; unchanged if it is below that.
    ///
    /// `dec` of \[001\] Fig. 3.
    #[must_use]
    pub const fn lowered(self, step: U0F16, floor: Self) -> Self {
        let (step, room) = (step.to_bits() as u32, self.room_to(floor));
        self.down(if step > room { room } else { step })
    }

    /// `ceiling − self`, 16 bits; 0 if negative.
    #[inline]
    pub(super) const fn missing_to(self, ceiling: Self) -> u32 {
        excess(ceiling.0, self.0)
    }

    /// `self − floor`, 16 bits; 0 if negative.
    #[inline]
    pub(super) const fn room_to(self, floor: Self) -> u32 {
        excess(self.0, floor.0)
    }

    /// `self + step`, where `step` is at most [`Self::FULL`] − `self`.
    #[inline]
    pub(super) const fn up(self, step: u32) -> Self {
        Self(wrapping_u16((self.0 as u32).wrapping_add(step)))
    }

    /// `self − step`, where `step` is at most `self`.
    #[inline]
    pub(super) const fn down(self, step: u32) -> Self {
        Self(wrapping_u16((self.0 as u32).wrapping_sub(step)))
    }
}

/// `more − less`; 0 if negative.
///
/// Computed as a signed number, which takes two instructions.
#[inline]
const fn excess(more: u16, less: u16) -> u32 {
    let difference = (more as i32).wrapping_sub(less as i32);
    (if difference > 0 { difference } else { 0 }).cast_unsigned()
}

impl Default for Confidence {
    /// Full: a sensor about which nothing is known counts as correct (\[002\] §4).
    fn default() -> Self {
        Self::FULL
    }
}
