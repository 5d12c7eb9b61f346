//! Time as the drivers see it.

/// A clock that counts microseconds, to measure short spans.
pub trait Stopwatch {
    /// Returns the microseconds since some instant, modulo 2^32.
    ///
    /// A span is the wrapping difference of two of them, right up to 71 minutes.
    fn micros(&mut self) -> u32;
}

/// The longest that one pin operation, one look at the clock, or the call around one wait may take
/// beyond the time waited, in µs, for the drivers' stated durations to hold.
///
/// 40 cycles of a microcontroller at 8 MHz.
pub const OPERATION_US: u32 = 5;

/// The longest that so many operations and waits of `waited_us` in all take, in µs.
pub(crate) const fn longest(operations: u32, waited_us: u32) -> u32 {
    operations
        .saturating_mul(OPERATION_US)
        .saturating_add(waited_us)
}
