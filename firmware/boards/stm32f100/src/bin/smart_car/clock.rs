//! Time: `SysTick`'s interrupt every millisecond, and its counter between them.

use certainty_core::units::Ticks;
use certainty_firmware::board;
use certainty_firmware::executive::{Dispatcher, DueQueue};
use certainty_firmware::smart_car::{SCHEDULE, SLOTS, STATIONS};
use certainty_firmware::stopwatch::Stopwatch;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use cortex_m::asm;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{SCB, SYST};
use cortex_m_rt::exception;
use embedded_hal::delay::DelayNs;

/// Cycles in a microsecond: the internal oscillator has 8 MHz.
const CYCLES_PER_US: u32 = 8;

/// Cycles from one tick to the next.
const CYCLES_PER_TICK: u32 = 1000 * CYCLES_PER_US;

/// Where what is due waits for the main loop.
pub(crate) static DUE: DueQueue = DueQueue::new();

/// Ticks so far, modulo 2^32.
static TICKS: AtomicU32 = AtomicU32::new(0);

/// A tick came since the main loop last wanted to sleep.
static TICKED: AtomicBool = AtomicBool::new(false);

/// Starts the ticks; the first comes in a millisecond.
pub(crate) fn start(systick: &mut SYST) {
    systick.set_clock_source(SystClkSource::Core);
    systick.set_reload(CYCLES_PER_TICK - 1);
    systick.clear_current();
    systick.enable_interrupt();
    systick.enable_counter();
}

/// Only hands over: what is due waits in the queue for the main loop.
#[exception]
fn SysTick() {
    static mut DISPATCHER: Dispatcher<SLOTS, STATIONS> = Dispatcher::new(&SCHEDULE);

    DISPATCHER.tick(&DUE);
    TICKS.store(
        TICKS.load(Ordering::Relaxed).wrapping_add(1),
        Ordering::Relaxed,
    );
    TICKED.store(true, Ordering::Relaxed);
}

/// Returns the ticks so far, modulo 2^32.
#[cfg(feature = "defmt-rtt")]
pub(crate) fn ticks() -> u32 {
    TICKS.load(Ordering::Relaxed)
}

/// The schedule's clock.
pub(crate) struct Clock;

impl board::Clock for Clock {
    /// The dispatcher calls its first tick 0.
    fn now(&mut self) -> Ticks {
        Ticks::new(TICKS.load(Ordering::Relaxed).wrapping_sub(1))
    }

    /// A tick between the main loop's look into the queue and this must not be slept through.
    ///
    /// So the decision is made with interrupts held back: a held-back one wakes the processor too.
    fn sleep(&mut self) {
        critical_section::with(|_| {
            if !TICKED.swap(false, Ordering::Relaxed) {
                asm::wfi();
            }
        });
    }
}

/// Short waits and spans: ticks, and the cycles since the last one.
///
/// For the main loop only: within an interrupt the ticks stand still.
#[derive(Clone, Copy)]
pub(crate) struct Time;

impl Stopwatch for Time {
    fn micros(&mut self) -> u32 {
        loop {
            let ticks = TICKS.load(Ordering::Relaxed);
            let left = SYST::get_current();
            // The counter may have begun anew just before it was read.
            if SCB::is_pendst_pending() || TICKS.load(Ordering::Relaxed) != ticks {
                continue;
            }
            // The counter begins at the cycles of a tick less one.
            let since = (CYCLES_PER_TICK - 1).saturating_sub(left) / CYCLES_PER_US;
            // Modulo 2^32 throughout, as the ticks are.
            return ticks.wrapping_mul(1000).wrapping_add(since);
        }
    }
}

impl DelayNs for Time {
    fn delay_ns(&mut self, ns: u32) {
        self.delay_us(ns.div_ceil(1000));
    }

    /// Looks at the clock until the time is over; the watchdog is what bounds it, should the clock stop.
    fn delay_us(&mut self, us: u32) {
        let began = self.micros();
        while self.micros().wrapping_sub(began) <= us {}
    }

    fn delay_ms(&mut self, ms: u32) {
        self.delay_us(ms.saturating_mul(1000));
    }
}
