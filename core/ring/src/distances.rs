//! One distance an echo path (\[003\] §5).

use super::confidence::RingRules;
use super::echoes::{Echoes, Heard};
use super::place::{FINE_BITS, FinePoint};
use super::ring::{ORDERS, Path, Ring};
use certainty_core::narrow::saturating_u16_of_u64;
use certainty_core::units::Millimeters;

/// What is known of one path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Folded {
    /// The distance, at most the range; the range also where there was no echo.
    Distance(Millimeters),
    /// The two directions of a cross path contradict each other: the error code of \[003\] §5.
    Inconsistent,
    /// No measurement, or not in both directions; or an echo over less than the sonars' distance.
    Unknown,
}

/// The 4-by-24 matrix of \[003\] §5: a distance a path, simulated or heard.
///
/// The distance of a cross path is that from the middle between its two sonars, straight ahead, to the
/// ellipse of all places that the echo may come from.
///
/// Memory: 8 bytes a sonar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Distances<const SENSORS: usize> {
    /// A row a sonar, a column an order; millimetres or one of the words below.
    known: [[u16; ORDERS]; SENSORS],
}

const UNKNOWN: u16 = u16::MAX;
const INCONSISTENT: u16 = u16::MAX - 1;

impl<const SENSORS: usize> Distances<SENSORS> {
    pub(super) const UNKNOWN: Self = Self {
        known: [[UNKNOWN; ORDERS]; SENSORS],
    };

    /// Folds the two directions of each path into one distance (\[003\] §5).
    ///
    /// Path lengths become distances, those beyond the range the range, and the two directions of a
    /// cross path their mean, or an error code where they differ by [`RingRules`]' limit or more. Differs
    /// from \[003\] §5, which does not know missing readings: a path of which one direction is unknown is
    /// unknown.
    #[must_use]
    pub fn fold(ring: &Ring<SENSORS>, echoes: &Echoes<SENSORS>, rules: &RingRules) -> Self {
        let mut folded = Self::UNKNOWN;
        let limit = rules.config().consistent.get();
        for path in ring.paths() {
            let [from, to] = Ring::<SENSORS>::ends(path);
            let there = heard_distance(ring, path, echoes.heard(from, to));
            let back = heard_distance(ring, path, echoes.heard(to, from));
            if let Some((there, back)) = there.zip(back) {
                let entry = if there.abs_diff(back) < limit {
                    let sum = u64::from(there).wrapping_add(back.into());
                    saturating_u16_of_u64(sum.wrapping_add(1) >> 1)
                } else {
                    INCONSISTENT
                };
                folded.set(path, entry);
            }
        }
        folded
    }

    /// Returns what is known of `path`.
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

    /// The same if it is nearer than the range: the distance of something that was heard.
    pub(super) fn echo(&self, ring: &Ring<SENSORS>, path: Path) -> Option<u16> {
        let distance = self.distance(path);
        distance.filter(|&distance| u32::from(distance) < ring.config().range.get())
    }

    fn raw(&self, path: Path) -> u16 {
        let row = self.known.get(usize::from(path.slot()));
        let entry = row.and_then(|row| row.get(usize::from(path.order())));
        entry.copied().unwrap_or(UNKNOWN)
    }

    pub(super) fn set(&mut self, path: Path, entry: u16) {
        let row = self.known.get_mut(usize::from(path.slot()));
        if let Some(place) = row.and_then(|row| row.get_mut(usize::from(path.order()))) {
            *place = entry;
        }
    }
}

/// What was heard, as a distance in millimetres; `None` if that is unknown.
fn heard_distance<const SENSORS: usize>(
    ring: &Ring<SENSORS>,
    path: Path,
    heard: Heard,
) -> Option<u32> {
    let range = ring.config().range.get();
    match heard {
        Heard::Unknown => None,
        Heard::Nothing => Some(range),
        Heard::Length(length) => {
            let distance = of_length(ring, path.order(), u64::from(length) << FINE_BITS)?;
            Some(u32::from(distance).min(range))
        }
    }
}

/// The distance in millimetres that belongs to a path of so many sixteenths of a millimetre; `None` if
/// the path is shorter than its sonars are apart.
///
/// Formula: `√((length / 2)² − c²)` with c half of how far the sonars are apart: for the wall straight
/// ahead exactly how far it is. Rounds to the nearest millimetre.
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
    Some(saturating_u16_of_u64(
        twice.wrapping_add(1 << FINE_BITS) >> TWICE,
    ))
}

/// The length, in sixteenths of a millimetre, of the path to a place `distance` away: the inverse of
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
