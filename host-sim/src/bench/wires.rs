//! What hangs on a board's pins.

use super::Bench;
use certainty_firmware::remote::{Channel, Line};

/// The devices on a board's pins, as an emulated board sees them.
///
/// Time is the board's own, in nanoseconds since its reset, and never runs backwards.
pub trait Wires {
    /// Is told that the board drives `line` high or low from now on.
    ///
    /// Only *changes* are told. Before the first one a Vin is high, by the sensor's own pull-up, and a
    /// trigger low.
    fn set_level(&mut self, line: Line, high: bool, now_ns: u64);

    /// Returns whether `line` is high.
    ///
    /// A board reads a whole port at a time, so this is asked of lines that the firmware does not
    /// look at; the answer must depend on the line and the time, not on how often it is asked.
    fn level(&mut self, line: Line, now_ns: u64) -> bool;

    /// Is told that `channel` gives pulses of `width_us` from now on; 0 is none at all.
    fn set_pulse(&mut self, channel: Channel, width_us: u32, now_ns: u64);
}

impl<W: Wires + ?Sized> Wires for &mut W {
    fn set_level(&mut self, line: Line, high: bool, now_ns: u64) {
        (**self).set_level(line, high, now_ns);
    }

    fn level(&mut self, line: Line, now_ns: u64) -> bool {
        (**self).level(line, now_ns)
    }

    fn set_pulse(&mut self, channel: Channel, width_us: u32, now_ns: u64) {
        (**self).set_pulse(channel, width_us, now_ns);
    }
}

/// A device that is not there is not wired: it hears nothing, and its line reads low.
impl Wires for Bench {
    fn set_level(&mut self, line: Line, high: bool, now_ns: u64) {
        let _not_wired = self.set_level(line, high, now_ns);
    }

    fn level(&mut self, line: Line, now_ns: u64) -> bool {
        self.level(line, now_ns).unwrap_or(false)
    }

    fn set_pulse(&mut self, channel: Channel, width_us: u32, now_ns: u64) {
        let _not_wired = self.set_pulse(channel, width_us, now_ns);
    }
}
