//! Which cells of the map to send, and when.

use super::report::WINDOW;
use super::{MapEnd, MapPart, Report};
use crate::digest::Digest;
use certainty_core::fusion::{CertaintyGrid, Environment, Geometry};
use core::fmt;
use heapless::Vec;

/// The map has more cells than its reporter can keep or a part can number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TooManyCells;

impl fmt::Display for TooManyCells {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the map has more cells than its reporter keeps")
    }
}

impl core::error::Error for TooManyCells {}

/// Sends a map's changed cells in parts, a generation after the other, and now and then all cells.
///
/// A generation takes at most one part for each begun [`PART_CELLS`](super::PART_CELLS) cells of the
/// map.
///
/// A cell is in its generation as it was when its part was sent. The digest in the last part is of
/// what was sent, not of the grid, which goes on changing meanwhile.
///
/// Memory: `CELLS` bytes and some 30 more.
#[derive(Debug, Clone)]
pub struct MapReporter<const CELLS: usize> {
    /// The map as it was sent last.
    sent: [u8; CELLS],
    geometry: Geometry,
    cells: u16,
    /// The first cell that this generation has not come to.
    at: u16,
    generation: u16,
    keyframe_every: u16,
    /// Generations until the next keyframe; zero in one.
    until_keyframe: u16,
}

impl<const CELLS: usize> MapReporter<CELLS> {
    /// Creates a reporter that sends all cells at first and then in one of `keyframe_every`
    /// generations; in every one if that is 0 or 1.
    ///
    /// # Errors
    ///
    /// [`TooManyCells`] if the map has more than `CELLS` cells or than 65,535.
    pub fn try_new(geometry: Geometry, keyframe_every: u16) -> Result<Self, TooManyCells> {
        let cells = u16::try_from(geometry.cells()).map_err(|_| TooManyCells)?;
        if usize::from(cells) > CELLS {
            return Err(TooManyCells);
        }
        Ok(Self {
            sent: [0; CELLS],
            geometry,
            cells,
            at: 0,
            generation: 0,
            keyframe_every,
            until_keyframe: 0,
        })
    }

    /// Returns whether the next part is the first of a keyframe: when a
    /// [`Hello`](super::Hello) is due.
    #[must_use]
    pub const fn begins_keyframe(&self) -> bool {
        self.at == 0 && self.until_keyframe == 0
    }

    /// Sends what is next of `map`: at most `parts` parts, none beyond the generation's last.
    ///
    /// Where `send` finds no room, the part is sent again at the next call, with the cells as they
    /// are then. Returns whether the generation is finished.
    ///
    /// Cost: looks at every cell at most once a part, and takes the digest once.
    pub fn report<G: CertaintyGrid>(
        &mut self,
        map: &Environment<'_, G>,
        parts: u8,
        mut send: impl FnMut(&Report) -> bool,
    ) -> bool {
        for _ in 0..parts {
            let report = Report::Map(self.next_part(map));
            if !send(&report) {
                return false;
            }
            if let Report::Map(part) = &report
                && self.take_as_sent(part)
            {
                return true;
            }
        }
        false
    }

    /// The changed cells that come next, from the first to the last of them within a part's length.
    fn next_part<G: CertaintyGrid>(&self, map: &Environment<'_, G>) -> MapPart {
        let all = self.until_keyframe == 0;
        let mut cells = Vec::new();
        let mut start = self.at;
        let mut changed_cells = 0;
        let mut more = false;
        let indices = 0..self.cells;
        let known = indices.zip(map.geometry().iter()).zip(&self.sent);
        for ((index, cell), &sent) in known.skip(self.at.into()) {
            let now = map.certainty(cell).to_bits();
            let changed = all || now != sent;
            if cells.is_empty() {
                if !changed {
                    continue;
                }
                start = index;
            }
            if cells.push(now).is_err() {
                // The part is full: what is left to know is whether it is the last.
                more |= changed;
                if more {
                    break;
                }
            } else if changed {
                changed_cells = cells.len();
            }
        }
        cells.truncate(changed_cells);
        let end = (!more).then(|| MapEnd {
            cells: self.cells,
            digest: self.digest(start, &cells),
        });
        MapPart {
            generation: self.generation,
            start,
            cells,
            end,
        }
    }

    /// The digest of the map once `cells` from `start` on are sent.
    fn digest(&self, start: u16, cells: &[u8]) -> u32 {
        let (start, count) = (usize::from(start), usize::from(self.cells));
        let before = self.sent.iter().take(start);
        let after = self.sent.iter().take(count).skip(start).skip(cells.len());
        map_digest(&self.geometry, before.chain(cells).chain(after))
    }

    /// Notes that `part` is out; returns whether it was the last.
    fn take_as_sent(&mut self, part: &MapPart) -> bool {
        let kept = self.sent.iter_mut().skip(part.start.into());
        for (kept, &sent) in kept.zip(&part.cells) {
            *kept = sent;
        }
        if part.end.is_none() {
            // Past the whole window, whatever was left off at its end: so many windows fit a map.
            self.at = part.start.saturating_add(WINDOW);
            return false;
        }
        self.at = 0;
        self.generation = self.generation.wrapping_add(1);
        self.until_keyframe = match self.until_keyframe.checked_sub(1) {
            Some(left) => left,
            None => self.keyframe_every.saturating_sub(1),
        };
        true
    }
}

/// The digest of a map: where it lies, and all its cells.
///
/// The place is in it because a map at another place, or with its rows cut otherwise, is another map.
pub(super) fn map_digest<'a>(geometry: &Geometry, cells: impl IntoIterator<Item = &'a u8>) -> u32 {
    let mut digest = Digest::NEW;
    digest.word(geometry.columns().into());
    digest.word(geometry.rows().into());
    digest.word(geometry.cell_size().get());
    digest.word(geometry.corner().x_mm().cast_unsigned());
    digest.word(geometry.corner().y_mm().cast_unsigned());
    digest.bytes(cells);
    digest.value()
}
