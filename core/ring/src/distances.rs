//! The echoes that a ring measures, and the one distance per path made of them (\[003\] §5).
//!
//! [`Echoes`] holds the length of each path in both directions; [`Distances`] one distance per path.

use super::geometry::{FINE_BITS, FinePoint};
use super::ring::{NEIGHBOURS, ORDERS, Path, Ring, RingRules};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::Millimeters;
use core::fmt;

/// Receivers of a pulse: the sonar itself, and its neighbours on both sides.
const RECEIVERS: usize = 2 * NEIGHBOURS as usize + 1;

/// The 7-by-24 matrix of \[003\] §5: each sonar's pulse as received by itself and by its neighbours.
///
/// Memory: 14 bytes per sonar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Echoes<const SENSORS: usize> {
    /// A row per transmitter; path lengths in millimetres, or [`UNKNOWN`] or [`NO_ECHO`].
    lengths: [[u16; RECEIVERS]; SENSORS],
}

/// An entry without a value, in both matrices.
const UNKNOWN: u16 = u16::MAX;
/// An entry of [`Echoes`] for which nothing was received.
const NO_ECHO: u16 = u16::MAX - 1;
/// An entry of [`Distances`] whose two directions contradict each other.
const INCONSISTENT: u16 = u16::MAX - 1;
/// The longest path; longer ones saturate.
const LONGEST: u16 = u16::MAX - 2;

/// A measurement of one path in one direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Received {
    /// An echo; the path length in millimetres, there and back.
    Length(u16),
    /// No echo.
    NoEcho,
    /// No measurement, or a path too short to measure.
    Unknown,
}

/// There is no echo path between two sonars: one is not in the ring, or they are too far apart in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NoSuchPath {
    /// The sonar that sends.
    pub transmitter: SensorId,
    /// The sonar that receives.
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
    /// Creates a matrix in which no path has been measured.
    #[must_use]
    pub const fn unknown() -> Self {
        let lengths = [[UNKNOWN; RECEIVERS]; SENSORS];
        Self { lengths }
    }

    /// Creates a matrix in which every path has been measured and none has an echo.
    #[must_use]
    pub const fn silent() -> Self {
        let lengths = [[NO_ECHO; RECEIVERS]; SENSORS];
        Self { lengths }
    }

    /// Sets what `receiver` measured of `transmitter`'s pulse.
    ///
    /// An echo is the length of the whole path, from the transmitter to the obstacle and on to the
    /// receiver: twice the distance for the direct path. It saturates at 65 533 mm. *Too near* and
    /// *missing* are unknown.
    ///
    /// # Errors
    ///
    /// [`NoSuchPath`] if the two are not neighbours; the matrix is then unchanged.
    pub fn set(
        &mut self,
        transmitter: SensorId,
        receiver: SensorId,
        reading: Reading,
    ) -> Result<(), NoSuchPath> {
        let no_path = NoSuchPath {
            transmitter,
            receiver,
        };
        let column = Self::column(transmitter, receiver).ok_or(no_path)?;
        let row = self.lengths.get_mut(transmitter.slot()).ok_or(no_path)?;
        let entry = row.get_mut(column).ok_or(no_path)?;
        *entry = match reading {
            Reading::Echo(length) => u16::try_from(length.get()).unwrap_or(LONGEST).min(LONGEST),
            Reading::NoObject => NO_ECHO,
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
        column.ok().filter(|&column| column < RECEIVERS)
    }

    /// What the sonar in slot `receiver` measured of the pulse of that in slot `transmitter`.
    fn received(&self, transmitter: u8, receiver: u8) -> Received {
        let sensor = |slot: u8| SensorId::from_slot(slot.into());
        let entry = sensor(transmitter)
            .zip(sensor(receiver))
            .and_then(|(from, to)| {
                let row = self.lengths.get(from.slot())?;
                row.get(Self::column(from, to)?).copied()
            });
        match entry {
            None | Some(UNKNOWN) => Received::Unknown,
            Some(NO_ECHO) => Received::NoEcho,
            Some(length) => Received::Length(length),
        }
    }
}

/// The distance of one path, or why there is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Folded {
    /// The distance, at most the range; equal to the range if there was no echo.
    Distance(Millimeters),
    /// The two directions of a cross path contradict each other: the error code of \[003\] §5.
    Inconsistent,
    /// No measurement in at least one direction, or a path shorter than its sonars are apart.
    Unknown,
}

/// The 4-by-24 matrix of \[003\] §5: one distance per path, simulated or measured.
///
/// The distance of a cross path is measured straight ahead, from the midpoint between its two sonars to
/// the ellipse of all points from which the echo may have come.
///
/// Memory: 8 bytes per sonar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Distances<const SENSORS: usize> {
    /// A row per sonar, a column per order; millimetres, or [`UNKNOWN`] or [`INCONSISTENT`].
    distances: [[u16; ORDERS]; SENSORS],
}

impl<const SENSORS: usize> Distances<SENSORS> {
    pub(super) const UNKNOWN: Self = Self {
        distances: [[UNKNOWN; ORDERS]; SENSORS],
    };

    /// Folds the two directions of each path into one distance (\[003\] §5).
    ///
    /// Path lengths become distances, limited to the range. A cross path gets the mean of its two
    /// directions, rounded up, or [`Folded::Inconsistent`] if they differ by the limit of the [`RingRules`]
    /// or more. Beyond \[003\] §5, which has no missing readings: a path is unknown if one of its directions
    /// is.
    #[must_use]
    pub fn fold(ring: &Ring<SENSORS>, echoes: &Echoes<SENSORS>, rules: &RingRules) -> Self {
        let mut folded = Self::UNKNOWN;
        let limit = rules.config().consistent.get();
        for path in ring.paths() {
            let [from, to] = Ring::<SENSORS>::ends(path);
            let there = distance(ring, path, echoes.received(from, to));
            let back = distance(ring, path, echoes.received(to, from));
            if let Some((there, back)) = there.zip(back) {
                let entry = if there.abs_diff(back) < limit {
                    let sum = u64::from(there).wrapping_add(back.into());
                    saturating_u16(sum.wrapping_add(1) >> 1)
                } else {
                    INCONSISTENT
                };
                folded.set(path, entry);
            }
        }
        folded
    }

    /// Returns the distance of `path`, or why there is none.
    #[must_use]
    pub fn get(&self, path: Path) -> Folded {
        match self.raw(path) {
            UNKNOWN => Folded::Unknown,
            INCONSISTENT => Folded::Inconsistent,
            distance => Folded::Distance(Millimeters::new(distance.into())),
        }
    }

    /// The path's distance in millimetres, if there is one.
    pub(super) fn distance(&self, path: Path) -> Option<u16> {
        Some(self.raw(path)).filter(|&distance| distance < INCONSISTENT)
    }

    /// The same if it is below the range: the distance of an echo.
    pub(super) fn echo(&self, ring: &Ring<SENSORS>, path: Path) -> Option<u16> {
        let distance = self.distance(path);
        distance.filter(|&distance| u32::from(distance) < ring.config().range.get())
    }

    fn raw(&self, path: Path) -> u16 {
        let row = self.distances.get(usize::from(path.slot()));
        let entry = row.and_then(|row| row.get(usize::from(path.order())));
        entry.copied().unwrap_or(UNKNOWN)
    }

    pub(super) fn set(&mut self, path: Path, entry: u16) {
        let row = self.distances.get_mut(usize::from(path.slot()));
        if let Some(place) = row.and_then(|row| row.get_mut(usize::from(path.order()))) {
            *place = entry;
        }
    }
}

/// A measurement as a distance in millimetres, at most the range; `None` if it is unknown.
fn distance<const SENSORS: usize>(
    ring: &Ring<SENSORS>,
    path: Path,
    received: Received,
) -> Option<u32> {
    let range = ring.config().range.get();
    match received {
        Received::Unknown => None,
        Received::NoEcho => Some(range),
        Received::Length(length) => {
            let distance = of_length(ring, path.order(), u64::from(length) << FINE_BITS)?;
            Some(u32::from(distance).min(range))
        }
    }
}

/// The distance in millimetres of a path whose length is given in sixteenths of a millimetre; `None` if
/// the path is shorter than its sonars are apart.
///
/// Formula: `√((length / 2)² − c²)`, with c half the distance between the sonars. Exact for a wall
/// straight ahead. Rounds to the nearest millimetre.
pub(super) fn of_length<const SENSORS: usize>(
    ring: &Ring<SENSORS>,
    order: u8,
    length: u64,
) -> Option<u16> {
    /// Twice sixteenths of a millimetre.
    const TWICE: u32 = FINE_BITS + 1;
    let (_, half_apart) = ring.chord(order);
    let apart = half_apart.wrapping_mul(2);
    let square = length.saturating_mul(length);
    let twice = square.checked_sub(apart.wrapping_mul(apart))?.isqrt();
    Some(saturating_u16(twice.wrapping_add(1 << FINE_BITS) >> TWICE))
}

/// The length of a path, in sixteenths of a millimetre, whose distance is given: the inverse of
/// [`of_length`].
pub(super) fn length_of<const SENSORS: usize>(
    ring: &Ring<SENSORS>,
    order: u8,
    distance: Millimeters,
) -> u64 {
    let (_, half_apart) = ring.chord(order);
    let ahead = u64::from(distance.get()).wrapping_mul(FinePoint::STEPS.unsigned_abs().into());
    let square = ahead.wrapping_mul(ahead);
    let half = square.wrapping_add(half_apart.wrapping_mul(half_apart));
    half.wrapping_mul(4).isqrt()
}

/// The nearest value of 16 bits.
pub(super) fn saturating_u16(value: u64) -> u16 {
    u16::try_from(value).unwrap_or(u16::MAX)
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
    fn neighbours_have_paths_around_the_ring() {
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
        assert_eq!(echoes.received(0, 21), Received::Length(10));
        assert_eq!(echoes.received(21, 0), Received::Length(20));
        assert_eq!(echoes.received(23, 2), Received::Length(30));
        assert_eq!(echoes.received(4, 4), Received::Length(40));
        assert_eq!(echoes.received(11, 8), Received::Length(50));
        assert_eq!(echoes.received(8, 11), Received::Unknown);
    }

    #[test]
    fn sonars_that_are_not_neighbours_have_no_path() {
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
    fn no_length_is_mistaken_for_a_code() {
        let mut echoes = Echoes::<24>::unknown();
        for length in [65_533, 65_534, 65_535, u32::MAX] {
            echoes.set(id(1), id(1), echo(length)).unwrap();
            assert_eq!(echoes.received(0, 0), Received::Length(LONGEST));
        }
    }
}
