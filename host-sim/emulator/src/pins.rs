//! The pins of the microcontroller, and the devices that are connected to them.

use core::fmt;

/// A GPIO port whose pins are emulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Port {
    /// Port A.
    A,
    /// Port B.
    B,
    /// Port C.
    C,
}

impl Port {
    /// All of them, in the order of their addresses.
    pub(crate) const ALL: [Self; 3] = [Self::A, Self::B, Self::C];
}

/// A pin of a port; displays as `PB13`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Pin {
    port: Port,
    number: u8,
}

impl Pin {
    /// Names pin `number` of `port`.
    ///
    /// # Panics
    ///
    /// For a number above 15.
    #[must_use]
    pub const fn new(port: Port, number: u8) -> Self {
        assert!(number < 16, "a port has the pins 0 to 15");
        Self { port, number }
    }

    /// Returns its port.
    #[must_use]
    pub const fn port(self) -> Port {
        self.port
    }

    /// Returns its number, from 0 to 15.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.number
    }
}

impl fmt::Display for Pin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "P{:?}{}", self.port, self.number)
    }
}

/// A timer whose pulses leave on pins.
///
/// The pins of its channels 0, 1 and 2 are fixed: no remapping of the chip is emulated but that it takes
/// the pulses away.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Timer {
    /// TIM3, on PA6, PA7 and PB0.
    Tim3,
    /// TIM4, on PB6, PB7 and PB8.
    Tim4,
}

/// How a device is connected to a pin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Connection {
    /// The device drives the line: the microcontroller reads [`Pins::level`], whatever its own pulls.
    FromDevice,
    /// The microcontroller drives the line, which is low while it does not.
    ToDevice,
    /// The device pulls the line up to at most 3 V, and the microcontroller may only pull it low.
    ///
    /// A microcontroller that drives it high, or pulls it up, ends the run with
    /// [`RunError::DrivenHigh`](crate::RunError::DrivenHigh), which gives this name of the line.
    OpenDrain(&'static str),
}

impl Connection {
    /// The level of the line while the microcontroller does not drive it.
    pub(crate) const fn idle_level(self) -> bool {
        matches!(self, Self::OpenDrain(_))
    }
}

/// The devices on the pins of the microcontroller.
///
/// Times are nanoseconds since the reset and never decrease from one call to the next.
pub trait Pins {
    /// Takes over that the microcontroller changes the level of `pin` from now on.
    ///
    /// Called for changes of connected pins only. Before the first one a [`Connection::OpenDrain`] is high,
    /// a [`Connection::ToDevice`] low.
    fn set_level(&mut self, pin: Pin, high: bool, now_ns: u64);

    /// Returns whether the device on `pin`, a [`Connection::FromDevice`], drives it high.
    ///
    /// A program reads a whole port at once, so this is called for pins that it does not look at. The
    /// answer must depend on the pin and the time, not on how often it is called.
    fn level(&mut self, pin: Pin, now_ns: u64) -> bool;

    /// Takes over that `channel`, 0 to 2, of `timer` gives pulses of `width_us` from now on; 0 for none.
    ///
    /// Called for changes only; before the first one there are no pulses. The width is rounded to the
    /// nearest microsecond.
    fn set_pulse(&mut self, timer: Timer, channel: u8, width_us: u32, now_ns: u64);
}

/// Pins with nothing connected: every input reads low.
impl Pins for () {
    fn set_level(&mut self, _: Pin, _: bool, _: u64) {}

    fn level(&mut self, _: Pin, _: u64) -> bool {
        false
    }

    fn set_pulse(&mut self, _: Timer, _: u8, _: u32, _: u64) {}
}
