//! IWDG: the independent watchdog, with its own oscillator.

/// Cycles of the processor at 8 MHz for one of the watchdog's oscillator at its nominal 40 kHz.
///
/// A real chip's lies between 30 and 60 kHz (STM32F100 datasheet, LSI oscillator).
const OSCILLATOR_CYCLES: u64 = 200;

const START: u32 = 0xcccc;
const FEED: u32 = 0xaaaa;
const UNLOCK: u32 = 0x5555;

/// A written register is busy for five cycles of the oscillator.
const UPDATE_CYCLES: u64 = 5 * OSCILLATOR_CYCLES;

/// The watchdog's registers.
#[derive(Debug)]
pub(crate) struct Watchdog {
    prescaler: u32,
    reload: u32,
    unlocked: bool,
    expires_at: Option<u64>,
    prescaler_busy_until: u64,
    reload_busy_until: u64,
}

impl Default for Watchdog {
    fn default() -> Self {
        Self {
            prescaler: 0,
            reload: 0xfff,
            unlocked: false,
            expires_at: None,
            prescaler_busy_until: 0,
            reload_busy_until: 0,
        }
    }
}

impl Watchdog {
    pub(crate) fn read(&self, offset: u32, now: u64) -> Option<u32> {
        Some(match offset {
            0x00 => 0,
            0x04 => self.prescaler,
            0x08 => self.reload,
            0x0c => {
                u32::from(now < self.prescaler_busy_until)
                    | u32::from(now < self.reload_busy_until) << 1
            }
            _ => return None,
        })
    }

    /// Returns whether there is such a register.
    pub(crate) fn write(&mut self, offset: u32, value: u32, now: u64) -> bool {
        match offset {
            0x00 => self.key(value & 0xffff, now),
            // A write to a register that is locked or still busy is lost.
            0x04 => {
                if self.unlocked && now >= self.prescaler_busy_until {
                    self.prescaler = value & 0b111;
                    self.prescaler_busy_until = now + UPDATE_CYCLES;
                }
            }
            0x08 => {
                if self.unlocked && now >= self.reload_busy_until {
                    self.reload = value & 0xfff;
                    self.reload_busy_until = now + UPDATE_CYCLES;
                }
            }
            0x0c => {}
            _ => return false,
        }
        true
    }

    fn key(&mut self, key: u32, now: u64) {
        self.unlocked = key == UNLOCK;
        let starts = key == START && self.expires_at.is_none();
        if starts || (key == FEED && self.expires_at.is_some()) {
            self.expires_at = Some(now + self.timeout());
        }
    }

    /// The cycles from a feed to the expiry.
    fn timeout(&self) -> u64 {
        let divider = 4 << self.prescaler.min(6);
        (u64::from(self.reload) + 1) * divider * OSCILLATOR_CYCLES
    }

    /// The cycle in which it expires unless it is fed; `None` before its start.
    pub(crate) const fn expires_at(&self) -> Option<u64> {
        self.expires_at
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MILLISECOND: u64 = 8_000;

    fn started() -> Watchdog {
        let mut watchdog = Watchdog::default();
        watchdog.write(0x00, START, 0);
        watchdog.write(0x00, UNLOCK, 0);
        watchdog.write(0x04, 4, 0); // 40 kHz / 64: 1.6 ms a count
        watchdog.write(0x08, 999, 0);
        watchdog
    }

    #[test]
    fn it_expires_unless_it_is_fed() {
        let mut watchdog = started();
        // Until it is fed it runs with its reset values: 4096 counts of 0.1 ms.
        assert_eq!(watchdog.expires_at(), Some(4096 * MILLISECOND / 10));
        watchdog.write(0x00, FEED, 100 * MILLISECOND);
        assert_eq!(watchdog.expires_at(), Some((100 + 1_600) * MILLISECOND));
        watchdog.write(0x00, FEED, 1_000 * MILLISECOND);
        assert_eq!(watchdog.expires_at(), Some(2_600 * MILLISECOND));
    }

    #[test]
    fn once_started_it_cannot_be_stopped() {
        let mut watchdog = Watchdog::default();
        watchdog.write(0x00, FEED, 0);
        assert_eq!(watchdog.expires_at(), None);
        watchdog.write(0x00, START, 0);
        let expires_at = watchdog.expires_at();
        watchdog.write(0x00, START, 500);
        watchdog.write(0x00, 0, 500);
        assert_eq!(watchdog.expires_at(), expires_at);
    }

    #[test]
    fn its_settings_are_locked_and_take_time() {
        let mut watchdog = started();
        assert_eq!(watchdog.read(0x0c, UPDATE_CYCLES - 1), Some(0b11));
        assert_eq!(watchdog.read(0x0c, UPDATE_CYCLES), Some(0));
        watchdog.write(0x08, 5, 10); // still busy
        assert_eq!(watchdog.read(0x08, 10), Some(999));
        watchdog.write(0x00, FEED, UPDATE_CYCLES); // any other key locks
        watchdog.write(0x08, 5, UPDATE_CYCLES);
        assert_eq!(watchdog.read(0x08, UPDATE_CYCLES), Some(999));
        assert_eq!(watchdog.read(0x04, UPDATE_CYCLES), Some(4));
    }
}
