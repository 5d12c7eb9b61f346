//! Distances in millimetres.

use core::fmt;

/// A distance, in millimetres; never negative.
///
/// Units and range: `0..=4_294_967_295` mm. Places, which can be negative, are
/// [`Point`](super::Point)s.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct Millimeters(u32);

impl Millimeters {
    /// No distance at all.
    pub const ZERO: Self = Self(0);

    /// Creates a distance of `mm` millimetres.
    #[must_use]
    pub const fn new(mm: u32) -> Self {
        Self(mm)
    }

    /// Returns the number of millimetres.
    #[must_use]
    pub const fn get(self) -> u32 {
        self.0
    }

    /// Returns the sum; the largest distance where it would be larger.
    #[must_use]
    pub const fn saturating_add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }

    /// Returns the difference; zero where it would be negative.
    #[must_use]
    pub const fn saturating_sub(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}

impl fmt::Display for Millimeters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}mm", self.0)
    }
}
