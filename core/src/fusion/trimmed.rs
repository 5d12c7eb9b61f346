//! Trim, then Bayes: the fault-tolerant average of [000] §3.1.

use super::grid::{CertaintyGrid, Measurement, WrongStorage};
use super::layers::{Latest, Layers, OwnGrid};
use super::{Cell, Geometry, LogOdds, Shape};
use crate::certainty::Certainty;
use crate::health::Health;

/// A grid that drops, cell by cell, the t lowest and the t highest of what the sensors say and fuses
/// the rest by eq. 1.
///
/// Any t of the sensors that saw a cell may be wrong. A cell seen by fewer than 2t + 1 sensors is
/// *uncertain*: nothing would be left after trimming, and the grid does not say what it could not
/// defend. Prefer the median grid where sensors overlap only partly.
///
/// Memory: n bytes a cell ([000] §5). Cost: adding is one store; reading sorts n votes.
#[derive(Debug, Clone)]
pub struct TrimmedGrid<Sh, S, const N: usize, K = Latest> {
    layers: Layers<Sh, S, N, K>,
    trim: u8,
    strongest: LogOdds,
}

impl<Sh, S, const N: usize, K> TrimmedGrid<Sh, S, N, K>
where
    Sh: Shape,
    S: AsRef<[u8]> + AsMut<[u8]>,
    K: OwnGrid,
{
    /// Creates a grid for sensors 1 to `sensors`, of which `trim` may be wrong at a time.
    ///
    /// `strongest` is the surest that one sensor's word may be in eq. 1; see
    /// [`BayesGrid`](super::BayesGrid).
    ///
    /// # Errors
    ///
    /// [`WrongStorage`] unless `sensors` is 1 to `N` and `storage` has a byte for each cell and sensor.
    pub fn try_new(
        shape: Sh,
        sensors: u8,
        trim: u8,
        strongest: LogOdds,
        storage: S,
    ) -> Result<Self, WrongStorage<S>> {
        Layers::try_new(shape, sensors, storage).map(|layers| Self {
            layers,
            trim,
            strongest,
        })
    }
}

impl<Sh, S, const N: usize, K> CertaintyGrid for TrimmedGrid<Sh, S, N, K>
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
        trimmed(&self.layers.votes(cell), self.trim.into(), self.strongest)
    }

    fn memory_bytes(&self) -> usize {
        self.layers.memory_bytes()
    }
}

/// Eq. 1 of sorted votes without the `trim` lowest and highest.
fn trimmed(votes: &[Certainty], trim: usize, strongest: LogOdds) -> Certainty {
    let end = votes.len().saturating_sub(trim);
    let kept = votes.get(trim..end).unwrap_or(&[]);
    kept.iter()
        .map(|&vote| LogOdds::of(vote).at_most(strongest))
        .fold(LogOdds::EVEN, LogOdds::saturating_add)
        .certainty()
}
