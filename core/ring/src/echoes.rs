//! What the sonars of a ring heard of each other's pulses (\[003\] §5).

use super::ring::{NEIGHBOURS, Ring};
use certainty_core::narrow::saturating_u16_of_u64;
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use core::fmt;

/// A row's length: a sonar itself, and its neighbours on both sides.
const HEARERS: usize = 2 * NEIGHBOURS as usize + 1;

/// The 7-by-24 matrix of \[003\] §5: each sonar's pulse as heard by itself and by its neighbours.
///
/// Memory: 14 bytes a sonar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Echoes<const SENSORS: usize> {
    /// A row a transmitter; path lengths in millimetres, or one of the words below.
    heard: [[u16; HEARERS]; SENSORS],
}

const UNKNOWN: u16 = u16::MAX;
const NOTHING: u16 = u16::MAX - 1;
const LONGEST: u16 = u16::MAX - 2;

/// What is known of one path in one direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Heard {
    /// An echo over so many millimetres, there and back.
    Length(u16),
    /// No echo.
    Nothing,
    /// No measurement, or a path too short to measure.
    Unknown,
}

/// Two sonars do not hear each other: one is not in the ring, or they are too far apart in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NoSuchPath {
    /// Who sent.
    pub transmitter: SensorId,
    /// Who heard.
    pub receiver: SensorId,
}

impl fmt::Display for NoSuchPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (from, to) = (self.transmitter, self.receiver);
        write!(f, "there is no echo path from sonar {from} to sonar {to}")
    }
}

impl core::error::Error for NoSuchPath {}

impl<const SENSORS: usize> Echoes<SENSORS> {
    /// Creates a matrix in which nothing is known of any path.
    #[must_use]
    pub const fn unknown() -> Self {
        let heard = [[UNKNOWN; HEARERS]; SENSORS];
        Self { heard }
    }

    /// Creates a matrix in which no sonar heard anything.
    #[must_use]
    pub const fn silent() -> Self {
        let heard = [[NOTHING; HEARERS]; SENSORS];
        Self { heard }
    }

    /// Sets what `receiver` heard of `transmitter`'s pulse: an echo is the length of the whole path,
    /// from the one to the obstacle and on to the other.
    ///
    /// # Errors
    ///
    /// [`NoSuchPath`] if the two are no neighbours; nothing has changed then.
    pub fn set(
        &mut self,
        transmitter: SensorId,
        receiver: SensorId,
        reading: Reading,
    ) -> Result<(), NoSuchPath> {
        let wrong = NoSuchPath {
            transmitter,
            receiver,
        };
        let column = Self::column(transmitter, receiver).ok_or(wrong)?;
        let row = self.heard.get_mut(transmitter.slot()).ok_or(wrong)?;
        let place = row.get_mut(column).ok_or(wrong)?;
        *place = match reading {
            Reading::Echo(length) => saturating_u16_of_u64(length.get().into()).min(LONGEST),
            Reading::NoObject => NOTHING,
            Reading::TooNear | Reading::Missing(_) => UNKNOWN,
        };
        Ok(())
    }

    /// The receiver's column in the transmitter's row.
    fn column(transmitter: SensorId, receiver: SensorId) -> Option<usize> {
        let around = i32::from(Ring::<SENSORS>::SLOTS);
        let (from, to) = (
            i32::from(transmitter.number()),
            i32::from(receiver.number()),
        );
        if from > around || to > around {
            return None;
        }
        let places = to.wrapping_sub(from).wrapping_add(NEIGHBOURS.into());
        let column = usize::try_from(places.checked_rem_euclid(around)?);
        column.ok().filter(|&column| column < HEARERS)
    }

    /// What the sonar in place `receiver` heard of that in place `transmitter`.
    pub(super) fn heard(&self, transmitter: u8, receiver: u8) -> Heard {
        let sensor = |slot: u8| SensorId::from_slot(slot.into());
        let entry = sensor(transmitter)
            .zip(sensor(receiver))
            .and_then(|(from, to)| {
                let row = self.heard.get(from.slot())?;
                row.get(Self::column(from, to)?).copied()
            });
        match entry {
            None | Some(UNKNOWN) => Heard::Unknown,
            Some(NOTHING) => Heard::Nothing,
            Some(length) => Heard::Length(length),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::units::Millimeters;

    fn id(number: u8) -> SensorId {
        SensorId::try_new(number).unwrap()
    }

    fn echo(mm: u32) -> Reading {
        Reading::Echo(Millimeters::new(mm))
    }

    #[test]
    fn neighbours_hear_each_other_around_the_ring() {
        let mut echoes = Echoes::<24>::unknown();
        for (from, to, length) in [
            (1, 22, 10),
            (22, 1, 20),
            (24, 3, 30),
            (5, 5, 40),
            (12, 9, 50),
        ] {
            echoes.set(id(from), id(to), echo(length)).unwrap();
        }
        assert_eq!(echoes.heard(0, 21), Heard::Length(10));
        assert_eq!(echoes.heard(21, 0), Heard::Length(20));
        assert_eq!(echoes.heard(23, 2), Heard::Length(30));
        assert_eq!(echoes.heard(4, 4), Heard::Length(40));
        assert_eq!(echoes.heard(11, 8), Heard::Length(50));
        assert_eq!(echoes.heard(8, 11), Heard::Unknown);
    }

    #[test]
    fn others_do_not() {
        let mut echoes = Echoes::<24>::silent();
        for (from, to) in [
            (1, 5),
            (5, 1),
            (1, 13),
            (25, 1),
            (1, 25),
            (255, 255),
            (24, 4),
        ] {
            let refused = echoes.set(id(from), id(to), echo(1));
            let (transmitter, receiver) = (id(from), id(to));
            assert_eq!(
                refused,
                Err(NoSuchPath {
                    transmitter,
                    receiver
                })
            );
        }
        assert_eq!(echoes, Echoes::silent());
    }

    #[test]
    fn no_length_is_mistaken_for_a_word() {
        let mut echoes = Echoes::<24>::unknown();
        for length in [65_533, 65_534, 65_535, u32::MAX] {
            echoes.set(id(1), id(1), echo(length)).unwrap();
            assert_eq!(echoes.heard(0, 0), Heard::Length(LONGEST));
        }
    }
}
