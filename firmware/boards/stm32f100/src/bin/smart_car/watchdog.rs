//! The independent watchdog, and the light that shows that it is fed.

use certainty_firmware::board::Watchdog;
use stm32f1xx_hal::gpio::{Output, PC9, PushPull};
use stm32f1xx_hal::pac::IWDG;

/// The heartbeat's light: green on the discovery board.
pub(crate) type Light = PC9<Output<PushPull>>;

/// Watchdog counts of 1.6 ms at its oscillator's nominal 40 kHz: 2 s, two and a half rounds.
///
/// That oscillator has 30 to 60 kHz, so it is 1.3 to 2.7 s: more than a round in any case.
const COUNTS: u16 = 1250;

/// Feeds the watchdog and blinks, once a round.
pub(crate) struct Heartbeat {
    watchdog: IWDG,
    light: Light,
}

impl Heartbeat {
    /// Starts the watchdog, which then runs for ever.
    pub(crate) fn start(watchdog: IWDG, light: Light) -> Self {
        watchdog.kr().write(|w| w.key().start());
        watchdog.kr().write(|w| w.key().unlock());
        watchdog.pr().write(|w| w.pr().divide_by64());
        watchdog.rlr().write(|w| w.rl().set(COUNTS - 1));
        // Five of its oscillator's cycles each; should they never end, it bites.
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
