//! A grid for each sensor, kept apart until someone asks.

use super::grid::{GridError, GridErrorKind, Measurement, zeroed};
use super::{Cell, Geometry, LogOdds, Shape, Strength};
use crate::certainty::Certainty;
use heapless::Vec;

/// How a sensor's own grid takes the sensor's next word about a cell.
///
/// \[000\] §3.1 lets "each sensor produce its own grid" and does not say how.
pub trait OwnGrid {
    /// Returns what is stored after `measurement`; 0 is a cell that the sensor never saw.
    fn updated(&self, stored: u8, measurement: Certainty) -> u8;

    /// Returns what the sensor says about the cell; `None` if it never saw it.
    fn certainty(stored: u8) -> Option<Certainty>;
}

/// The sensor's latest word counts, as `AddToGrid` takes an owner's word "as is".
///
/// Stored is the deviation from *uncertain*; 0 being taken by *never seen*, certainty 127 is read back as
/// 128, its neighbour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Latest;

impl OwnGrid for Latest {
    #[inline]
    fn updated(&self, _stored: u8, measurement: Certainty) -> u8 {
        match measurement.deviation() {
            0 => (-1_i8).cast_unsigned(),
            deviation => deviation.cast_unsigned(),
        }
    }

    #[inline]
    fn certainty(stored: u8) -> Option<Certainty> {
        match stored.cast_signed() {
            0 => None,
            -1 => Some(Certainty::UNCERTAIN),
            deviation => Some(Certainty::from_deviation(deviation)),
        }
    }
}

/// The sensor's words are fused by eq. 1, so that a single wrong one among many is forgotten.
///
/// Stored are log-odds; even odds that were seen take the code −128.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Accumulated {
    /// The surest that one of its words may be.
    pub strongest: Strength,
}

impl Default for Accumulated {
    fn default() -> Self {
        Self {
            strongest: Strength::OWN,
        }
    }
}

impl OwnGrid for Accumulated {
    #[inline]
    fn updated(&self, stored: u8, measurement: Certainty) -> u8 {
        let before = match stored.cast_signed() {
            i8::MIN => LogOdds::EVEN,
            steps => LogOdds::from_steps(steps),
        };
        let opinion = self.strongest.odds(measurement);
        match before.saturating_add(opinion).steps() {
            0 => i8::MIN.cast_unsigned(),
            steps => steps.cast_unsigned(),
        }
    }

    #[inline]
    fn certainty(stored: u8) -> Option<Certainty> {
        match stored.cast_signed() {
            0 => None,
            i8::MIN => Some(Certainty::UNCERTAIN),
            steps => Some(LogOdds::from_steps(steps).certainty()),
        }
    }
}

/// One layer of cells a sensor, layer after layer, and a vote on demand.
///
/// `N` is the largest number of sensors, and with it the length of a vote on the stack.
#[derive(Debug, Clone)]
pub(super) struct Layers<Sh, S, const N: usize, K> {
    pub(super) shape: Sh,
    storage: S,
    sensors: u8,
    own: K,
}

impl<Sh, S, const N: usize, K> Layers<Sh, S, N, K>
where
    Sh: Shape,
    S: AsRef<[u8]> + AsMut<[u8]>,
    K: OwnGrid,
{
    pub(super) fn try_new(
        shape: Sh,
        sensors: u8,
        own: K,
        storage: S,
    ) -> Result<Self, GridError<S>> {
        let cells = shape.geometry().cells() as usize;
        if sensors == 0 || usize::from(sensors) > N {
            let why = GridErrorKind::Sensors { most: N };
            return Err(GridError { why, storage });
        }
        let storage = zeroed(storage, cells.saturating_mul(sensors.into()))?;
        Ok(Self {
            shape,
            storage,
            sensors,
            own,
        })
    }

    pub(super) fn geometry(&self) -> Geometry {
        self.shape.geometry()
    }

    #[inline]
    pub(super) fn add(&mut self, cell: Cell, measurement: Measurement) {
        let cells = self.shape.geometry().cells() as usize;
        if measurement.sensor.number() > self.sensors || cell.index() >= cells {
            return;
        }
        let layer = measurement.sensor.slot().wrapping_mul(cells);
        let place = layer.wrapping_add(cell.index());
        if let Some(stored) = self.storage.as_mut().get_mut(place) {
            *stored = self.own.updated(*stored, measurement.certainty);
        }
    }

    /// What the sensors that saw the cell say about it, in rising order.
    pub(super) fn votes(&self, cell: Cell) -> Vec<Certainty, N> {
        let cells = self.shape.geometry().cells() as usize;
        let mut votes = Vec::new();
        for layer in self.storage.as_ref().chunks_exact(cells.max(1)) {
            let stored = layer.get(cell.index()).copied().unwrap_or(0);
            if let Some(certainty) = K::certainty(stored) {
                let place = votes.partition_point(|&vote| vote <= certainty);
                // There are at most N layers, so there is room.
                let _full = votes.insert(place, certainty);
            }
        }
        votes
    }

    pub(super) fn memory_bytes(&self) -> usize {
        self.storage.as_ref().len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_latest_word_is_kept_but_for_the_code_of_never_seen() {
        assert_eq!(Latest::certainty(0), None);
        for bits in 0..=u8::MAX {
            let stored = Latest.updated(77, Certainty::from_bits(bits));
            let expected = if bits == 127 { 128 } else { bits };
            assert_eq!(
                Latest::certainty(stored),
                Some(Certainty::from_bits(expected))
            );
        }
    }

    #[test]
    fn accumulated_words_are_eq_1_and_always_seen() {
        assert_eq!(Accumulated::certainty(0), None);
        let own = Accumulated {
            strongest: Strength::MEASUREMENT,
        };
        let occupied = own.updated(0, Certainty::OCCUPIED);
        assert_eq!(
            Accumulated::certainty(occupied).map(Certainty::to_bits),
            Some(230)
        ); // 0.9
        // 35 steps up, and 14 down five times over: even, yet seen.
        let words = [Certainty::OCCUPIED, Certainty::OCCUPIED];
        let words = words.into_iter().chain([Certainty::FREE; 5]);
        let balanced = words.fold(0, |stored, word| own.updated(stored, word));
        assert_eq!(Accumulated::certainty(balanced), Some(Certainty::UNCERTAIN));
        let again = own.updated(balanced, Certainty::OCCUPIED);
        assert_eq!(again, occupied);
    }
}
