//! Time and instructions by `SysTick`.

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// `SysTick` has 24 bits and counts down; no measured span is longer.
const FULL: u32 = 0x00FF_FFFF;

/// Returns the ticks from `before` to `after`.
pub(crate) const fn ticks_between(before: u32, after: u32) -> u32 {
    before.wrapping_sub(after) & FULL
}

/// Converts ticks of `SysTick` to instructions, at 32 ns an instruction and 24 MHz.
pub(crate) const fn instructions(ticks: u32) -> u32 {
    // 1e9 / 24e6 / 32 = 1.302083… = 125 / 96. At most 2^24 ticks: 32 bits hold the product.
    ticks.wrapping_mul(125).wrapping_div(96)
}

/// Returns how many ticks `work` takes, the two readings of the clock included.
pub(crate) fn ticks_of<T>(work: impl FnOnce() -> T) -> (u32, T) {
    let before = SYST::get_current();
    let result = work();
    let after = SYST::get_current();
    (ticks_between(before, after), result)
}

/// Starts the clock.
pub(crate) fn start(mut timer: SYST) {
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(FULL);
    timer.clear_current();
    timer.enable_counter();
}
