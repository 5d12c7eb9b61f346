//! Time: the tick interrupt, short waits, and the watchdog with its light.
//!
//! `SysTick` interrupts every millisecond; its counter gives the time between the ticks.

use certainty_core::units::Ticks;
use certainty_firmware::board::{self, Watchdog};
use certainty_firmware::executive::{Dispatcher, DueQueue};
use certainty_firmware::smart_car::{SCHEDULE, SLOTS, STATIONS};
use certainty_firmware::timing::Stopwatch;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use cortex_m::asm;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{SCB, SYST};
use cortex_m_rt::exception;
use embedded_hal::delay::DelayNs;
use stm32f1xx_hal::gpio::{Output, PC9, PushPull};
use stm32f1xx_hal::pac::IWDG;

/// Cycles a microsecond: the internal oscillator has 8 MHz.
const CYCLES_PER_US: u32 = 8;

/// Cycles from one tick to the next.
const CYCLES_PER_TICK: u32 = 1000 * CYCLES_PER_US;

/// The due slots, from the tick interrupt to the main loop.
pub(crate) static DUE: DueQueue = DueQueue::new();

/// Ticks since the start, modulo 2^32.
static TICKS: AtomicU32 = AtomicU32::new(0);

/// Whether a tick came since the last call of [`Clock::sleep`](board::Clock::sleep).
static TICKED: AtomicBool = AtomicBool::new(false);

/// Starts the ticks; the first comes in a millisecond.
pub(crate) fn start(systick: &mut SYST) {
    systick.set_clock_source(SystClkSource::Core);
    systick.set_reload(CYCLES_PER_TICK - 1);
    systick.clear_current();
    systick.enable_interrupt();
    systick.enable_counter();
}

/// Puts the slot that is due, if any, into the queue for the main loop.
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

/// Returns the ticks since the start, modulo 2^32.
#[cfg(feature = "defmt-rtt")]
pub(crate) fn ticks() -> u32 {
    TICKS.load(Ordering::Relaxed)
}

/// The schedule's clock.
pub(crate) struct Clock;

impl board::Clock for Clock {
    /// The dispatcher numbers its ticks from 0.
    fn now(&mut self) -> Ticks {
        Ticks::new(TICKS.load(Ordering::Relaxed).wrapping_sub(1))
    }

    /// Does not sleep if a tick came after the main loop last read its queue.
    ///
    /// That is decided with interrupts disabled; a pending interrupt still wakes the processor.
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
/// For the main loop only: within an interrupt the ticks do not count.
#[derive(Clone, Copy)]
pub(crate) struct Time;

impl Stopwatch for Time {
    fn micros(&mut self) -> u32 {
        loop {
            let ticks = TICKS.load(Ordering::Relaxed);
            let left = SYST::get_current();
            // The counter may have wrapped just before it was read.
            if SCB::is_pendst_pending() || TICKS.load(Ordering::Relaxed) != ticks {
                continue;
            }
            // The counter starts at the cycles of a tick less one.
            let since = (CYCLES_PER_TICK - 1).saturating_sub(left) / CYCLES_PER_US;
            // Modulo 2^32, like the ticks.
            return ticks.wrapping_mul(1000).wrapping_add(since);
        }
    }
}

impl DelayNs for Time {
    fn delay_ns(&mut self, ns: u32) {
        self.delay_us(ns.div_ceil(1000));
    }

    /// Polls the clock until the time is over; if the clock stops, the watchdog ends it.
    fn delay_us(&mut self, us: u32) {
        let began = self.micros();
        while self.micros().wrapping_sub(began) <= us {}
    }

    fn delay_ms(&mut self, ms: u32) {
        self.delay_us(ms.saturating_mul(1000));
    }
}

/// The heartbeat light: green on the discovery board.
pub(crate) type Light = PC9<Output<PushPull>>;

/// Watchdog counts of 1.6 ms at its oscillator's nominal 40 kHz: 2 s, two and a half rounds.
///
/// The oscillator has 30 to 60 kHz, so it is 1.3 to 2.7 s: always more than a round.
const COUNTS: u16 = 1250;

/// Feeds the independent watchdog and toggles the light, once a round.
pub(crate) struct Heartbeat {
    watchdog: IWDG,
    light: Light,
}

impl Heartbeat {
    /// Starts the watchdog; it cannot be stopped.
    pub(crate) fn start(watchdog: IWDG, light: Light) -> Self {
        watchdog.kr().write(|w| w.key().start());
        watchdog.kr().write(|w| w.key().unlock());
        watchdog.pr().write(|w| w.pr().divide_by64());
        watchdog.rlr().write(|w| w.rl().set(COUNTS - 1));
        // Takes five cycles of its oscillator; if it never ends, the watchdog resets.
        while watchdog.sr().read().bits() != 0 {}
        watchdog.kr().write(|w| w.key().feed());
        Self { watchdog, light }
    }
}

impl Watchdog for Heartbeat {
    fn feed(&mut self) {
        self.watchdog.kr().write(|w| w.key().feed());
        self.light.toggle();
    }
}
