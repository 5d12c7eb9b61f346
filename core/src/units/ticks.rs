//! Instants on the schedule's clock.

use core::ops::{Add, AddAssign, Sub};

/// An instant, in ticks of one millisecond since the clock's start; wraps after 49 days.
///
/// Ages are taken modulo the wrap, so they are right as long as they are under 24 days.
///
/// ```
/// use certainty_core::units::Ticks;
///
/// let start = Ticks::new(u32::MAX);
/// assert_eq!(start + 6, Ticks::new(5)); // across the wrap
/// assert_eq!((start + 6) - start, 6);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct Ticks(u32);

impl Ticks {
    /// Creates the instant `ticks` milliseconds after the clock's start.
    #[must_use]
    pub const fn new(ticks: u32) -> Self {
        Self(ticks)
    }

    /// Returns the milliseconds since the clock's start, modulo 2^32.
    #[must_use]
    pub const fn get(self) -> u32 {
        self.0
    }

    /// Returns the ticks that have passed since `earlier`; 0 if `earlier` is in the future.
    ///
    /// An instant that is up to 2^31 ticks ahead counts as future: a clock that was set back, as in
    /// some recordings, gives an age of 0 instead of weeks. To get the plain difference modulo 2^32,
    /// subtract the instants.
    ///
    /// ```
    /// use certainty_core::units::Ticks;
    ///
    /// assert_eq!(Ticks::new(5).since(Ticks::new(u32::MAX)), 6); // across the wrap
    /// assert_eq!(Ticks::new(5).since(Ticks::new(9)), 0);
    /// ```
    #[must_use]
    pub const fn since(self, earlier: Self) -> u32 {
        let age = self.0.wrapping_sub(earlier.0);
        if age > u32::MAX >> 1 { 0 } else { age }
    }
}

/// The instant that many ticks later; wraps with the clock.
impl Add<u32> for Ticks {
    type Output = Self;

    fn add(self, ticks: u32) -> Self {
        Self(self.0.wrapping_add(ticks))
    }
}

/// Wraps with the clock.
impl AddAssign<u32> for Ticks {
    fn add_assign(&mut self, ticks: u32) {
        *self = *self + ticks;
    }
}

/// The ticks from `earlier` to `self`; wraps with the clock. See [`Ticks::since`] for an age.
impl Sub for Ticks {
    type Output = u32;

    fn sub(self, earlier: Self) -> u32 {
        self.0.wrapping_sub(earlier.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_wrap() {
        let mut instant = Ticks::new(u32::MAX);
        assert_eq!(instant + 1, Ticks::new(0));
        instant += 3;
        assert_eq!(instant, Ticks::new(2));
        assert_eq!(instant - Ticks::new(u32::MAX), 3);
        assert_eq!(Ticks::new(0) - Ticks::new(1), u32::MAX);
    }

    #[test]
    fn an_instant_in_the_future_has_no_age() {
        let age = |now, earlier| Ticks::new(now).since(Ticks::new(earlier));
        assert_eq!(age(7, 7), 0);
        assert_eq!(age(7, 8), 0);
        assert_eq!(age((1 << 31) - 1, 0), (1 << 31) - 1);
        assert_eq!(age(1 << 31, 0), 0);
    }
}
