//! A GP2D02 as its two pins show it.

use super::{LineFault, MICROSECOND, MILLISECOND};

/// A simulated Sharp GP2D02, pin by pin.
///
/// It is as slow and as strict as a sensor may be: a conversion takes nearly its 70 ms, a clock's
/// high half of under 50 µs is not seen, and nothing but 2 ms of high Vin brings it back to idle,
/// from wherever it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Gp2d02Line {
    /// What the sensor was doing at the last edge of Vin.
    state: State,
    vin: bool,
    /// When Vin last changed.
    vin_since_ns: u64,
    fault: Option<LineFault>,
    /// From when on the sensor is pulled off.
    gone_ns: Option<u64>,
}

/// What the sensor does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Waits for Vin to fall; Vout is high.
    Idle,
    /// Converts; Vout is low, and high from `over_ns` on, if ever.
    Converting { over_ns: Option<u64>, byte: u8 },
    /// Shows the bit that is number `shown`, from 1.
    Bits { byte: u8, shown: u8 },
    /// Has lost its supply, and needs Vin high to come up again; Vout is low.
    Off,
}

impl Default for Gp2d02Line {
    fn default() -> Self {
        Self::new()
    }
}

impl Gp2d02Line {
    /// How long a conversion takes.
    pub const CONVERSION_NS: u64 = 68 * MILLISECOND;

    /// How long Vin must be high until the sensor idles.
    pub const RECOVERY_NS: u64 = 2 * MILLISECOND;

    /// The same after a loss of supply.
    pub const RESTART_NS: u64 = 10 * MILLISECOND;

    /// The shortest high half of a clock's period that the sensor sees.
    pub const SHORTEST_CLOCK_NS: u64 = 50 * MICROSECOND;

    /// How long into a conversion [`LineFault::UnpluggedMidConversion`] strikes.
    pub const UNPLUGGED_AFTER_NS: u64 = 20 * MILLISECOND;

    /// Creates a sensor that idles, its Vin high.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            state: State::Idle,
            vin: true,
            vin_since_ns: 0,
            fault: None,
            gone_ns: None,
        }
    }

    /// Sets Vin, which is high when it is let go.
    ///
    /// If a conversion starts, `convert` is asked for its byte; `None` is a sensor that never gets
    /// done. It is asked whatever is wrong with the line, but not for a sensor that is unplugged.
    pub fn set_vin(&mut self, high: bool, now_ns: u64, convert: impl FnOnce() -> Option<u8>) {
        if high == self.vin {
            return;
        }
        self.state = match self.state_at(now_ns) {
            _ if self.is_gone(now_ns) => State::Off,
            State::Idle => self.converting(convert(), now_ns),
            state if high || !self.is_clock(now_ns) => state,
            State::Converting { byte, .. } if self.is_over(now_ns) => {
                State::Bits { byte, shown: 1 }
            }
            State::Bits { shown: 4, .. } if self.fault == Some(LineFault::CutShort) => State::Off,
            State::Bits { byte, shown } if shown < 8 => State::Bits {
                byte,
                shown: shown + 1,
            },
            state => state,
        };
        self.vin = high;
        self.vin_since_ns = now_ns;
    }

    /// Returns the level of Vout, with a pull-down where it is connected to nothing.
    #[must_use]
    pub fn vout(&self, now_ns: u64) -> bool {
        if let Some(level) = self.fault.and_then(|fault| fault.level(now_ns)) {
            return level;
        }
        if self.is_gone(now_ns) {
            return false;
        }
        match self.state_at(now_ns) {
            State::Idle => true,
            State::Converting { .. } => self.is_over(now_ns),
            State::Bits { byte, shown } => byte >> (8 - shown) & 1 == 1,
            State::Off => false,
        }
    }

    /// Puts a fault on the line, or heals it.
    ///
    /// A sensor that was unplugged comes back by [`RESTART_NS`](Self::RESTART_NS) of high Vin, as
    /// does one whose bits were cut short.
    pub fn set_fault(&mut self, fault: Option<LineFault>, now_ns: u64) {
        let unplug = fault == Some(LineFault::UnpluggedMidConversion);
        if unplug {
            if matches!(self.state_at(now_ns), State::Converting { .. }) {
                self.gone_ns.get_or_insert(now_ns);
            }
        } else {
            if self.is_gone(now_ns) {
                self.state = State::Off;
                self.vin_since_ns = now_ns;
            }
            self.gone_ns = None;
        }
        self.fault = fault;
    }

    /// Returns the fault that is on the line.
    #[must_use]
    pub const fn fault(&self) -> Option<LineFault> {
        self.fault
    }

    fn converting(&mut self, byte: Option<u8>, now_ns: u64) -> State {
        if self.fault == Some(LineFault::UnpluggedMidConversion) {
            self.gone_ns = Some(now_ns + Self::UNPLUGGED_AFTER_NS);
        }
        State::Converting {
            over_ns: byte.map(|_| now_ns + Self::CONVERSION_NS),
            byte: byte.unwrap_or(0),
        }
    }

    /// What the sensor does now: idle after a long enough high Vin, else what it did.
    fn state_at(&self, now_ns: u64) -> State {
        let rest = match self.state {
            State::Off => Self::RESTART_NS,
            _ => Self::RECOVERY_NS,
        };
        if self.vin && self.held(now_ns) >= rest {
            State::Idle
        } else {
            self.state
        }
    }

    fn is_over(&self, now_ns: u64) -> bool {
        match self.state_at(now_ns) {
            State::Converting {
                over_ns: Some(over_ns),
                ..
            } => now_ns >= over_ns && self.fault != Some(LineFault::Mute),
            _ => false,
        }
    }

    fn is_gone(&self, now_ns: u64) -> bool {
        self.gone_ns.is_some_and(|gone_ns| now_ns >= gone_ns)
    }

    fn is_clock(&self, now_ns: u64) -> bool {
        self.held(now_ns) >= Self::SHORTEST_CLOCK_NS
    }

    /// How long Vin has been what it is.
    fn held(&self, now_ns: u64) -> u64 {
        now_ns.saturating_sub(self.vin_since_ns)
    }
}
