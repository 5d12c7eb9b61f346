//! Pulses of hobby devices: their length in microseconds, and the part of the period that it is.

/// Returns the duty cycle of a pulse, of `full`, at a period of `period_us`, which is at most 2^15.
///
/// Rounds to the nearest, ties up. Where `full` is the period in µs or more, no two pulses have the same
/// duty, so that the pulse can be told from it.
///
/// ```
/// use certainty_firmware::pulse::duty;
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

/// The low 16 bits.
#[expect(
    clippy::cast_possible_truncation,
    reason = "dropping bits is what it is for"
)]
pub(crate) const fn low_half(value: u32) -> u16 {
    value as u16
}
