//! A bench with the Smart Car's devices on it, and the lines that a board is wired to them with.

mod wires;

pub use wires::Wires;

/// A line between the board and a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Line {
    /// To the pivoted sensor in this slot: starts it and clocks its bits.
    Vin(u8),
    /// From the pivoted sensor in this slot.
    Vout(u8),
    /// To the ranger in this slot.
    Trigger(u8),
    /// From the ranger in this slot.
    Echo(u8),
}
