//! Which device hangs on which pin: the wiring of `docs/hardware.md` as a table.

use certainty_firmware::remote::{Channel, Line};

/// A GPIO port.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PortName {
    /// Port A.
    A,
    /// Port B.
    B,
    /// Port C.
    C,
}

/// All of them, in the order of their addresses.
pub(super) const PORTS: [PortName; 3] = [PortName::A, PortName::B, PortName::C];

/// A pin of a port.
pub(super) type Pin = (PortName, u8);

/// Where the firmware's serial output leaves the microcontroller.
pub(super) const SERIAL_OUT: Pin = (PortName::A, 9);

/// A timer with pulses on its channels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TimerName {
    /// TIM3.
    Tim3,
    /// TIM4.
    Tim4,
}

/// A timer's channel, from 0, its pin, and what hangs on it.
pub(super) type Pulsed = (TimerName, usize, Pin, Channel);

/// The channels with something on them.
pub(super) const PULSED: [Pulsed; 5] = [
    (TimerName::Tim3, 0, (PortName::A, 6), Channel::Servo(0)),
    (TimerName::Tim3, 1, (PortName::A, 7), Channel::Servo(1)),
    (TimerName::Tim3, 2, (PortName::B, 0), Channel::Servo(2)),
    (TimerName::Tim4, 0, (PortName::B, 6), Channel::Motor(0)),
    (TimerName::Tim4, 1, (PortName::B, 7), Channel::Motor(1)),
];

/// The lines and their pins.
pub(super) const LINES: [(Pin, Line); 10] = [
    ((PortName::B, 12), Line::Vin(0)),
    ((PortName::B, 13), Line::Vin(1)),
    ((PortName::B, 14), Line::Vin(2)),
    ((PortName::C, 10), Line::Vout(0)),
    ((PortName::C, 11), Line::Vout(1)),
    ((PortName::C, 12), Line::Vout(2)),
    ((PortName::C, 0), Line::Trigger(0)),
    ((PortName::C, 1), Line::Trigger(1)),
    ((PortName::B, 10), Line::Echo(0)),
    ((PortName::B, 11), Line::Echo(1)),
];
