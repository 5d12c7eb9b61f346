//! A sensor's confidence.

use fixed::types::U0F16;

/// The belief that a sensor is correct: 0 is *appears to be wrong*, 1 *appears to be correct*
/// (\[002\] §4).
///
/// Units and range: steps of 2^-16, 0 to 65535; the largest, 0.99998, stands for 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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

    /// Returns the confidence `step` higher, but no higher than `ceiling`, or unchanged if it is
    /// beyond; `inc` of \[001\] Fig. 3.
    #[must_use]
    pub const fn raised(self, step: U0F16, ceiling: Self) -> Self {
        let raised = self.0.saturating_add(step.to_bits());
        if self.0 > ceiling.0 {
            self
        } else if raised > ceiling.0 {
            ceiling
        } else {
            Self(raised)
        }
    }

    /// Returns the confidence `step` lower, but no lower than `floor`, or unchanged if it is below;
    /// `dec` of \[001\] Fig. 3.
    #[must_use]
    pub const fn lowered(self, step: U0F16, floor: Self) -> Self {
        let lowered = self.0.saturating_sub(step.to_bits());
        if self.0 < floor.0 {
            self
        } else if lowered < floor.0 {
            floor
        } else {
            Self(lowered)
        }
    }
}

impl Default for Confidence {
    /// Full: without knowledge about a sensor, it is believed (\[002\] §4).
    fn default() -> Self {
        Self::FULL
    }
}
