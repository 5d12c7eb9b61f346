//! Instants on the schedule's clock.

/// An instant, in ticks of one millisecond since the clock's start; wraps after 49 days.
///
/// Ages are taken modulo the wrap, so they are right as long as they are under 24 days.
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

    /// Returns how many ticks ago `earlier` was; 0 where it is not earlier.
    ///
    /// An instant that is up to 2^31 ticks ahead counts as not earlier: a clock that was set
    /// back, as recordings have, yields an age of 0 and never one of weeks.
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
