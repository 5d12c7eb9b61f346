//! The number that identifies a sensor.

use core::fmt;
use core::num::NonZeroU8;

/// A sensor's number, `1..=255`; zero stands for *no owner* in a grid (\[001\] §5.1).
///
/// An `Option<SensorId>` takes one byte, which is the paper's `cell.owner`.
///
/// ```
/// use certainty_core::sensor::SensorId;
///
/// const FRONT: SensorId = SensorId::new(1); // a zero here does not build
/// assert_eq!(SensorId::try_new(1), Some(FRONT));
/// assert_eq!(SensorId::try_new(0), None);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct SensorId(NonZeroU8);

impl SensorId {
    /// Creates the id of sensor `number`, for constants.
    ///
    /// # Panics
    ///
    /// For zero: a constant then does not build. Use [`Self::try_new`] at run time.
    #[expect(clippy::panic, reason = "refuses a constant at compile time")]
    #[must_use]
    pub const fn new(number: u8) -> Self {
        match Self::try_new(number) {
            Some(id) => id,
            None => panic!("a sensor's number must be 1..=255"),
        }
    }

    /// Creates the id of sensor `number`; `None` for zero.
    #[must_use]
    pub const fn try_new(number: u8) -> Option<Self> {
        match NonZeroU8::new(number) {
            Some(number) => Some(Self(number)),
            None => None,
        }
    }

    /// Creates the id of the sensor at index `slot` of a list; `None` above 254.
    #[must_use]
    pub const fn from_slot(slot: usize) -> Option<Self> {
        if slot < u8::MAX as usize {
            let [low, ..] = slot.to_le_bytes();
            Self::try_new(low.wrapping_add(1))
        } else {
            None
        }
    }

    /// Returns the number, `1..=255`.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.0.get()
    }

    /// Returns the sensor's index in a list of sensors, `0..=254`.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slots_and_numbers_are_one_apart() {
        assert_eq!(SensorId::from_slot(0), Some(SensorId::new(1)));
        assert_eq!(SensorId::from_slot(254), Some(SensorId::new(255)));
        assert_eq!(SensorId::from_slot(255), None);
        assert_eq!(SensorId::new(255).slot(), 254);
    }
}
