//! Fault-tolerant median selection: [000] §3.2, [001] §4.

use super::grid::{CertaintyGrid, Measurement, WrongStorage};
use super::layers::{Latest, Layers, OwnGrid};
use super::{Cell, Geometry, Shape};
use crate::certainty::Certainty;
use crate::health::Health;
use crate::narrow::wrapping_u8;

/// A grid that takes, cell by cell, the middle of what the sensors say.
///
/// Adapts to how many sensors saw a cell: of n, any ⌊(n − 1)/2⌋ may be wrong, and the value still is
/// one that a correct sensor gave, or lies between two of them. Prefer it where sensors overlap fully
/// and memory allows; it needs no configuration and no history of the sensors.
///
/// With an even number of votes the value is the mean of the middle two, ties up.
///
/// Memory: n bytes a cell ([001] §7). Cost: adding is one store; reading sorts n votes.
#[derive(Debug, Clone)]
pub struct MedianGrid<Sh, S, const N: usize, K = Latest> {
    layers: Layers<Sh, S, N, K>,
}

impl<Sh, S, const N: usize, K> MedianGrid<Sh, S, N, K>
where
    Sh: Shape,
    S: AsRef<[u8]> + AsMut<[u8]>,
    K: OwnGrid,
{
    /// Creates a grid for sensors 1 to `sensors` that have seen nothing yet.
    ///
    /// # Errors
    ///
    /// [`WrongStorage`] unless `sensors` is 1 to `N` and `storage` has a byte for each cell and sensor.
    pub fn try_new(shape: Sh, sensors: u8, storage: S) -> Result<Self, WrongStorage<S>> {
        Layers::try_new(shape, sensors, storage).map(|layers| Self { layers })
    }
}

impl<Sh, S, const N: usize, K> CertaintyGrid for MedianGrid<Sh, S, N, K>
where
    Sh: Shape,
    S: AsRef<[u8]> + AsMut<[u8]>,
    K: OwnGrid,
{
    fn geometry(&self) -> Geometry {
        self.layers.geometry()
    }

    #[inline]
    fn add(&mut self, cell: Cell, measurement: Measurement, _sensors: &mut [Health]) {
        self.layers.add(cell, measurement);
    }

    fn certainty(&self, cell: Cell) -> Certainty {
        median(&self.layers.votes(cell))
    }

    fn memory_bytes(&self) -> usize {
        self.layers.memory_bytes()
    }
}

/// The middle of sorted votes; *uncertain* of none.
fn median(votes: &[Certainty]) -> Certainty {
    let upper = votes.len() / 2;
    let lower = votes.len().saturating_sub(1) / 2;
    match (votes.get(lower), votes.get(upper)) {
        (Some(low), Some(high)) => {
            let sum = u32::from(low.to_bits()).wrapping_add(high.to_bits().into());
            Certainty::from_bits(wrapping_u8(sum.wrapping_add(1) >> 1))
        }
        _ => Certainty::UNCERTAIN,
    }
}
