//! Distances in millimetres.

use crate::narrow::low_u32;
use core::fmt;
use core::ops::{Add, AddAssign, Sub, SubAssign};

/// A distance, in millimetres; never negative.
///
/// Units and range: `0..=4_294_967_295` mm. Sums and differences saturate. Positions, which can be
/// negative, are [`Point`](super::Point)s.
///
/// ```
/// use certainty_core::units::Millimeters;
///
/// let (near, far) = (Millimeters::new(100), Millimeters::new(800));
/// assert_eq!(far - near, Millimeters::new(700));
/// assert_eq!(near - far, Millimeters::ZERO);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct Millimeters(u32);

impl Millimeters {
    /// A distance of 0 mm.
    pub const ZERO: Self = Self(0);
    /// The longest distance, 4295 km.
    pub const MAX: Self = Self(u32::MAX);

    /// Creates a distance of `mm` millimetres.
    #[must_use]
    pub const fn new(mm: u32) -> Self {
        Self(mm)
    }

    /// Creates a distance of `mm` millimetres; [`Self::MAX`] if it does not fit.
    #[must_use]
    pub const fn from_saturating(mm: u64) -> Self {
        if mm > u32::MAX as u64 {
            Self::MAX
        } else {
            Self(low_u32(mm))
        }
    }

    /// Returns the number of millimetres.
    #[must_use]
    pub const fn get(self) -> u32 {
        self.0
    }

    /// Returns the sum; saturates at [`Self::MAX`]. In a `const fn`; elsewhere write `+`.
    #[must_use]
    pub const fn saturating_add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }

    /// Returns the difference; saturates at 0 mm. In a `const fn`; elsewhere write `-`.
    #[must_use]
    pub const fn saturating_sub(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}

/// Saturates at [`Millimeters::MAX`].
impl Add for Millimeters {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        self.saturating_add(other)
    }
}

/// Saturates at [`Millimeters::MAX`].
impl AddAssign for Millimeters {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// Saturates at [`Millimeters::ZERO`].
impl Sub for Millimeters {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self.saturating_sub(other)
    }
}

/// Saturates at [`Millimeters::ZERO`].
impl SubAssign for Millimeters {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl fmt::Display for Millimeters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}mm", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_and_differences_saturate() {
        let (one, two) = (Millimeters::new(1), Millimeters::new(2));
        assert_eq!(one + one, two);
        assert_eq!(two - one, one);
        assert_eq!(Millimeters::MAX + one, Millimeters::MAX);
        assert_eq!(one - two, Millimeters::ZERO);
        let mut length = Millimeters::MAX;
        length += two;
        assert_eq!(length, Millimeters::MAX);
        length -= one;
        assert_eq!(length, Millimeters::new(u32::MAX - 1));
    }

    #[test]
    fn lengths_beyond_32_bits_saturate() {
        let from = Millimeters::from_saturating;
        assert_eq!(from(u32::MAX.into()), Millimeters::MAX);
        assert_eq!(from(1 << 32), Millimeters::MAX);
        assert_eq!(from(7), Millimeters::new(7));
    }
}
