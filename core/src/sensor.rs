//! Which sensor said so.

use core::fmt;
use core::num::NonZeroU8;

/// A sensor's number, `1..=255`; zero is taken by an unknown owner (\[001\] §5.1).
///
/// An `Option<SensorId>` takes one byte, and its byte is the paper's `cell.owner`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct SensorId(NonZeroU8);

impl SensorId {
    /// Creates the id of sensor `number`; `None` for zero.
    #[must_use]
    pub const fn new(number: u8) -> Option<Self> {
        match NonZeroU8::new(number) {
            Some(number) => Some(Self(number)),
            None => None,
        }
    }

    /// Creates the id of the sensor in place `slot` of a list, counted from 0; `None` past 254.
    #[must_use]
    pub const fn from_slot(slot: usize) -> Option<Self> {
        if slot < u8::MAX as usize {
            let [low, ..] = slot.to_le_bytes();
            Self::new(low.wrapping_add(1))
        } else {
            None
        }
    }

    /// Returns the number, `1..=255`.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.0.get()
    }

    /// Returns the sensor's place in a list of sensors, counted from 0.
    #[must_use]
    pub const fn slot(self) -> usize {
        (self.0.get() as usize).wrapping_sub(1)
    }
}

impl fmt::Display for SensorId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}
