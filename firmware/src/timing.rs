//! Time and pulse widths as the drivers use them.

/// A clock that counts microseconds, to measure short spans.
pub trait Stopwatch {
    /// Returns the microseconds since an arbitrary start, modulo 2^32.
    ///
    /// A span is the wrapping difference of two of these values; it is right up to 71 minutes.
    fn micros(&mut self) -> u32;
}

/// The longest that one pin operation, one reading of the clock, or the call around one wait may take
/// beyond the time waited, in µs.
///
/// The durations that the drivers state hold within this limit: 40 cycles of a microcontroller at 8 MHz.
pub const OPERATION_US: u32 = 5;

/// Returns the longest that `operations` operations and waits of `waited_us` in total take, in µs.
pub(crate) const fn longest(operations: u32, waited_us: u32) -> u32 {
    operations
        .saturating_mul(OPERATION_US)
        .saturating_add(waited_us)
}

/// Returns the duty cycle, out of `full`, of a pulse at a period of `period_us`, which is at most 2^15.
///
/// Rounds to the nearest, ties up. A pulse longer than the period counts as the period. Where `full` is
/// the period in µs or more, each whole µs has its own duty, so the pulse can be computed back from it.
///
/// ```
/// use certainty_firmware::timing::duty;
///
/// assert_eq!(duty(1_500, 20_000, 40_000), 3_000);
/// ```
#[must_use]
pub const fn duty(pulse_us: u16, period_us: u16, full: u16) -> u16 {
    let period = period_us as u32;
    let pulse = if pulse_us < period_us {
        pulse_us as u32
    } else {
        period
    };
    // At most 2^15 · 2^16 and half a period: 32 bits hold it.
    let product = pulse.wrapping_mul(full as u32).wrapping_add(period >> 1);
    match product.checked_div(period) {
        Some(duty) => low_half(duty), // at most `full`
        None => 0,
    }
}

/// Returns the low 16 bits.
#[expect(
    clippy::cast_possible_truncation,
    reason = "dropping bits is what it is for"
)]
pub(crate) const fn low_half(value: u32) -> u16 {
    value as u16
}
