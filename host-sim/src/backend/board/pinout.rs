//! Which device hangs on which pin: the wiring of `docs/hardware.md` as a table.

use certainty_firmware::remote::Line;

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

/// The pins of TIM3's channels 1 to 3, each with a servo on it.
pub(super) const SERVOS: [Pin; 3] = [(PortName::A, 6), (PortName::A, 7), (PortName::B, 0)];

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
