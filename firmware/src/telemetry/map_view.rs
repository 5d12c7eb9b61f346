//! The map as a receiver puts it together, and whether it is whole.

use super::map_reporter::map_digest;
use super::{MapPart, Report};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::Geometry;

/// What a receiver knows about the map that it shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapState {
    /// Nobody has said how large the map is.
    Unknown,
    /// The map that was announced has more cells than there is room for.
    TooLarge,
    /// Parts are missing, or the digest did not agree: cells may be wrong.
    Incomplete,
    /// The map is what the sender's was at the end of this generation, which is the newest or the one
    /// before.
    Complete {
        /// The generation.
        generation: u16,
    },
}

/// Puts a map together from reports.
///
/// Keeps two maps: the one that parts are written to, and a copy of it from when a digest last
/// agreed. The copy is shown as long as at most one generation has begun since; so a map is shown as
/// complete while the next one arrives, but not once a last part was lost.
///
/// `S` is storage for as many cells as there are bytes in it.
#[derive(Debug, Clone)]
pub struct MapView<S> {
    arriving: S,
    agreed: S,
    geometry: Option<Geometry>,
    state: MapState,
}

impl<S: AsRef<[u8]> + AsMut<[u8]>> MapView<S> {
    /// Creates an empty view; the contents of both storages do not matter.
    pub const fn new(arriving: S, agreed: S) -> Self {
        Self {
            arriving,
            agreed,
            geometry: None,
            state: MapState::Unknown,
        }
    }

    /// Returns the grid's geometry, once it was announced.
    #[must_use]
    pub const fn geometry(&self) -> Option<Geometry> {
        self.geometry
    }

    /// Returns what is known about the map.
    #[must_use]
    pub const fn state(&self) -> MapState {
        self.state
    }

    /// Returns the map's cells, row after row from the lowest: right ones in
    /// [`MapState::Complete`], what has arrived in [`MapState::Incomplete`], otherwise none.
    pub fn cells(&self) -> impl Iterator<Item = Certainty> + '_ {
        let (cells, count) = match self.state {
            MapState::Complete { .. } => (self.agreed.as_ref(), self.count()),
            MapState::Incomplete => (self.arriving.as_ref(), self.count()),
            MapState::Unknown | MapState::TooLarge => (self.arriving.as_ref(), 0),
        };
        let cells = cells.iter().take(count);
        cells.map(|&bits| Certainty::from_bits(bits))
    }

    /// Takes a report; those that are not about the map change nothing.
    pub fn take(&mut self, report: &Report) {
        match report {
            Report::Hello(hello) => self.begin(hello.geometry),
            Report::Map(part) => self.take_part(part),
            _ => {}
        }
    }

    /// How many cells the map has.
    fn count(&self) -> usize {
        self.geometry.map_or(0, cells_of)
    }

    /// Forgets the map, unless it is the one that is known.
    fn begin(&mut self, geometry: Geometry) {
        if self.geometry == Some(geometry) {
            return;
        }
        self.geometry = Some(geometry);
        let room = self.arriving.as_ref().len().min(self.agreed.as_ref().len());
        self.state = if cells_of(geometry) > room {
            MapState::TooLarge
        } else {
            MapState::Incomplete
        };
        let uncertain = Certainty::UNCERTAIN.to_bits();
        self.arriving.as_mut().fill(uncertain);
    }

    fn take_part(&mut self, part: &MapPart) {
        let Some(geometry) = self.geometry else {
            return;
        };
        if self.state == MapState::TooLarge {
            return;
        }
        let count = cells_of(geometry);
        let Some(arriving) = self.arriving.as_mut().get_mut(..count) else {
            return;
        };
        let start = usize::from(part.start);
        let end = start.saturating_add(part.cells.len());
        let Some(place) = arriving.get_mut(start..end) else {
            // A part of another map.
            self.state = MapState::Incomplete;
            return;
        };
        place.copy_from_slice(&part.cells);
        match part.end {
            Some(end) => {
                let agrees = usize::from(end.cells) == count
                    && end.digest == map_digest(&geometry, &*arriving);
                self.state = if agrees {
                    for (agreed, &cell) in self.agreed.as_mut().iter_mut().zip(&*arriving) {
                        *agreed = cell;
                    }
                    MapState::Complete {
                        generation: part.generation,
                    }
                } else {
                    MapState::Incomplete
                };
            }
            None => {
                if let MapState::Complete { generation } = self.state
                    && part.generation != generation.wrapping_add(1)
                {
                    self.state = MapState::Incomplete;
                }
            }
        }
    }
}

/// How many cells a grid has.
fn cells_of(geometry: Geometry) -> usize {
    usize::try_from(geometry.cells()).unwrap_or(usize::MAX)
}
