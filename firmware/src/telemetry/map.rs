//! The map in parts: which cells to send and when, and how a receiver puts them together.

use super::report::{MapEnd, MapPart, Report, WINDOW};
use crate::digest::Digest;
use certainty_core::certainty::Certainty;
use certainty_core::fusion::{CertaintyGrid, Environment, Geometry};
use core::fmt;

/// The map has more cells than its reporter stores or a part can address.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TooManyCells;

impl fmt::Display for TooManyCells {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the map has more cells than its reporter stores")
    }
}

impl core::error::Error for TooManyCells {}

/// Sends a map's changed cells in parts, generation after generation, and periodically all cells.
///
/// A generation has at most one part for each begun [`PART_CELLS`](super::PART_CELLS) cells of the map.
///
/// A cell is sent as it is at the time of its part. The digest in the last part is of the cells as sent, not
/// of the grid, which may change meanwhile.
///
/// Memory: `CELLS` bytes and about 30 more.
#[derive(Debug, Clone)]
pub struct MapReporter<const CELLS: usize> {
    /// The map as sent last.
    sent: [u8; CELLS],
    geometry: Geometry,
    cells: u16,
    /// The first cell that this generation has not scanned.
    at: u16,
    generation: u16,
    keyframe_every: u16,
    /// Generations until the next keyframe; zero during one.
    until_keyframe: u16,
}

impl<const CELLS: usize> MapReporter<CELLS> {
    /// Creates a reporter whose first generation is a keyframe, and then one in `keyframe_every`; all of them
    /// if that is 0 or 1.
    ///
    /// # Errors
    ///
    /// [`TooManyCells`] if the map has more than `CELLS` or more than 65,535 cells.
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

    /// Returns whether the next part is the first of a keyframe; a [`Hello`](super::Hello) must be sent
    /// before it.
    #[must_use]
    pub const fn begins_keyframe(&self) -> bool {
        self.at == 0 && self.until_keyframe == 0
    }

    /// Sends the next parts of `map`: at most `parts`, and not beyond the end of the generation.
    ///
    /// If `send` returns false, the part is sent again at the next call, with the cells as they are then.
    /// Returns whether the generation is finished.
    ///
    /// Cost: reads every cell at most once a part, and computes the digest once.
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
                && self.mark_sent(part)
            {
                return true;
            }
        }
        false
    }

    /// Returns the next changed cells, from the first to the last of them within a part's length.
    fn next_part<G: CertaintyGrid>(&self, map: &Environment<'_, G>) -> MapPart {
        let all = self.until_keyframe == 0;
        let mut cells = heapless::Vec::new();
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
                // The part is full; check whether it is the last.
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

    /// Returns the digest of the map once `cells` from `start` on are sent.
    fn digest(&self, start: u16, cells: &[u8]) -> u32 {
        let (start, count) = (usize::from(start), usize::from(self.cells));
        let before = self.sent.iter().take(start);
        let after = self.sent.iter().take(count).skip(start).skip(cells.len());
        map_digest(&self.geometry, before.chain(cells).chain(after))
    }

    /// Records that `part` was sent; returns whether it was the last.
    fn mark_sent(&mut self, part: &MapPart) -> bool {
        let stored = self.sent.iter_mut().skip(part.start.into());
        for (stored, &sent) in stored.zip(&part.cells) {
            *stored = sent;
        }
        if part.end.is_none() {
            // Past the whole window, even if its last cells were left out, so that the number of parts is
            // bounded.
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

/// Returns the digest of a map: its geometry and all its cells.
///
/// The geometry is included because the same cells at another place or in other rows are another map.
fn map_digest<'a>(geometry: &Geometry, cells: impl IntoIterator<Item = &'a u8>) -> u32 {
    let mut digest = Digest::NEW;
    digest.word(geometry.columns().into());
    digest.word(geometry.rows().into());
    digest.word(geometry.cell_size().get());
    digest.word(geometry.corner().x_mm().cast_unsigned());
    digest.word(geometry.corner().y_mm().cast_unsigned());
    digest.bytes(cells);
    digest.value()
}

/// Whether a receiver's map is known and complete.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapState {
    /// No [`Hello`](super::Hello) has arrived: the size of the map is unknown.
    Unknown,
    /// The map has more cells than the storage.
    TooLarge,
    /// Parts are missing or the digest did not match: cells may be wrong.
    Incomplete,
    /// The map equals the sender's at the end of this generation, the newest or the one before.
    Complete {
        /// The generation.
        generation: u16,
    },
}

/// Reassembles a map from reports.
///
/// Holds two maps: one that parts are written to, and a copy of it from the last time that a digest matched.
/// The copy is shown while at most one generation has begun since. So a map stays complete while the next
/// one arrives, but not after a last part was lost.
///
/// `S` is storage with a byte a cell.
#[derive(Debug, Clone)]
pub struct MapView<S> {
    arriving: S,
    verified: S,
    geometry: Option<Geometry>,
    state: MapState,
}

impl<S: AsRef<[u8]> + AsMut<[u8]>> MapView<S> {
    /// Creates an empty view; the contents of both storages do not matter.
    pub const fn new(arriving: S, verified: S) -> Self {
        Self {
            arriving,
            verified,
            geometry: None,
            state: MapState::Unknown,
        }
    }

    /// Returns the grid's geometry once a [`Hello`](super::Hello) has arrived.
    #[must_use]
    pub const fn geometry(&self) -> Option<Geometry> {
        self.geometry
    }

    /// Returns whether the map is known and complete.
    #[must_use]
    pub const fn state(&self) -> MapState {
        self.state
    }

    /// Returns the map's cells, row after row from the lowest: verified ones in [`MapState::Complete`], the
    /// ones that have arrived in [`MapState::Incomplete`], otherwise none.
    pub fn cells(&self) -> impl Iterator<Item = Certainty> + '_ {
        let (cells, count) = match self.state {
            MapState::Complete { .. } => (self.verified.as_ref(), self.count()),
            MapState::Incomplete => (self.arriving.as_ref(), self.count()),
            MapState::Unknown | MapState::TooLarge => (self.arriving.as_ref(), 0),
        };
        let cells = cells.iter().take(count);
        cells.map(|&bits| Certainty::from_bits(bits))
    }

    /// Takes a report; reports that are not about the map change nothing.
    pub fn take(&mut self, report: &Report) {
        match report {
            Report::Hello(hello) => self.begin(hello.geometry),
            Report::Map(part) => self.take_part(part),
            _ => {}
        }
    }

    /// Returns the number of cells of the map.
    fn count(&self) -> usize {
        self.geometry.map_or(0, cells_of)
    }

    /// Starts a new map unless its geometry is the current one.
    fn begin(&mut self, geometry: Geometry) {
        if self.geometry == Some(geometry) {
            return;
        }
        self.geometry = Some(geometry);
        let room = self
            .arriving
            .as_ref()
            .len()
            .min(self.verified.as_ref().len());
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
            // The part belongs to another map.
            self.state = MapState::Incomplete;
            return;
        };
        place.copy_from_slice(&part.cells);
        match part.end {
            Some(end) => {
                let matches = usize::from(end.cells) == count
                    && end.digest == map_digest(&geometry, &*arriving);
                self.state = if matches {
                    for (verified, &cell) in self.verified.as_mut().iter_mut().zip(&*arriving) {
                        *verified = cell;
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

/// Returns the number of cells of a grid.
fn cells_of(geometry: Geometry) -> usize {
    usize::try_from(geometry.cells()).unwrap_or(usize::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smart_car::{CELLS, SmartCarShape};
    use crate::telemetry::Hello;
    use crate::telemetry::Reporter;
    use crate::telemetry::fixtures::{Drawn, HELLO, Line, Receiver, received, reporter, rounds};
    use certainty_core::fusion::Shape;
    use certainty_core::health::Health;
    use certainty_core::units::{Millimeters, Point};
    use proptest::prelude::*;

    const NO_HEALTH: [Health; 0] = [];

    /// Returns what `reporter` sends of a map with these cells in one call, and whether the generation ended.
    fn sent(
        reporter: &mut Reporter<Line, CELLS>,
        cells: &[u8; CELLS],
        parts: u8,
    ) -> (Vec<Report>, bool) {
        let grid = Drawn::smart_car(cells);
        let done = reporter.send_map(&Environment::new(&grid, &NO_HEALTH), parts);
        let bytes = core::mem::take(&mut reporter.outbox_mut().bytes);
        (received(&bytes).reports, done)
    }

    /// Returns the parts among `reports`: first cell and number of cells.
    fn runs(reports: &[Report]) -> Vec<(u16, usize)> {
        let parts = reports.iter().filter_map(|report| match report {
            Report::Map(part) => Some((part.start, part.cells.len())),
            _ => None,
        });
        parts.collect()
    }

    #[test]
    fn the_first_generation_is_a_hello_and_all_cells() {
        let cells = core::array::from_fn(|index| index as u8);
        let (reports, done) = sent(&mut reporter(50), &cells, 4);
        assert!(done);
        assert_eq!(reports[0], Report::Hello(HELLO));
        assert_eq!(runs(&reports), [(0, 48), (48, 48), (96, 48), (144, 43)]);
        let ends: Vec<bool> = reports[1..]
            .iter()
            .map(|report| matches!(report, Report::Map(MapPart { end: Some(_), .. })))
            .collect();
        assert_eq!(ends, [false, false, false, true]);
    }

    #[test]
    fn later_generations_send_changed_cells_only() {
        let mut reporter = reporter(50);
        let mut cells = [128; CELLS];
        sent(&mut reporter, &cells, 4);
        assert_eq!(
            runs(&sent(&mut reporter, &cells, 4).0),
            [(0, 0)],
            "only the digest"
        );
        cells[60] = 1;
        assert_eq!(runs(&sent(&mut reporter, &cells, 4).0), [(60, 1)]);
        cells[0] = 2;
        cells[40] = 2;
        cells[186] = 2;
        assert_eq!(runs(&sent(&mut reporter, &cells, 4).0), [(0, 41), (186, 1)]);
    }

    #[test]
    fn a_call_sends_at_most_parts_and_the_next_continues() {
        let mut reporter = reporter(50);
        let cells = [9; CELLS];
        let (reports, done) = sent(&mut reporter, &cells, 3);
        assert_eq!((runs(&reports).len(), done), (3, false));
        let (reports, done) = sent(&mut reporter, &cells, 3);
        assert_eq!((runs(&reports), done), (vec![(144, 43)], true));
        assert!(sent(&mut reporter, &cells, 0).0.is_empty());
    }

    #[test]
    fn one_in_keyframe_every_generations_is_a_keyframe() {
        for (every, expected) in [(0, "kkkkkk"), (1, "kkkkkk"), (3, "k--k--k"), (5, "k----k")] {
            let mut reporter = reporter(every);
            let kinds: String = (0..expected.len())
                .map(|_| {
                    let (reports, done) = sent(&mut reporter, &[128; CELLS], 4);
                    assert!(done);
                    if reports[0] == Report::Hello(HELLO) {
                        assert_eq!(runs(&reports).len(), 4);
                        'k'
                    } else {
                        '-'
                    }
                })
                .collect();
            assert_eq!(kinds, expected, "every {every}");
        }
    }

    #[test]
    fn a_refused_part_is_sent_again_and_counted() {
        let mut reporter = reporter(50);
        let cells = [5; CELLS];
        let mut receiver = Receiver::new();
        let mut unsent = 0;
        for room in [0, 1, 0, 2, 1, 0, 3, 9] {
            reporter.outbox_mut().room = Some(room);
            let grid = Drawn::smart_car(&cells);
            let done = reporter.send_map(&Environment::new(&grid, &NO_HEALTH), 9);
            unsent += u32::from(!done);
            assert_eq!(reporter.unsent(), unsent);
            let bytes = core::mem::take(&mut reporter.outbox_mut().bytes);
            receiver.receive(&bytes);
        }
        assert!(matches!(receiver.view.state(), MapState::Complete { .. }));
        assert_eq!(receiver.cells(), cells);
        assert!(unsent > 0 && receiver.decoder.tally().lost > 0);
    }

    #[test]
    fn a_map_larger_than_the_storage_is_refused() {
        assert!(MapReporter::<186>::try_new(SmartCarShape.geometry(), 1).is_err());
        assert!(MapReporter::<187>::try_new(SmartCarShape.geometry(), 1).is_ok());
        let (_, line) = Reporter::<_, 3>::try_new(Line::default(), HELLO, 1).unwrap_err();
        assert!(line.bytes.is_empty(), "the outbox is returned");
    }

    #[test]
    fn a_map_is_complete_only_if_its_digest_matches() {
        let sent = rounds(6, 1, 3);
        let mut receiver = Receiver::new();
        let mut states = Vec::new();
        for frame in sent.bytes.split_inclusive(|&byte| byte == 0) {
            receiver.receive(frame);
            states.push(receiver.view.state());
        }
        // A hello and three parts of the first map, then its last.
        assert_eq!(states[..4], [MapState::Incomplete; 4]);
        assert_eq!(states[4], MapState::Complete { generation: 0 });
        assert_eq!(states.last(), Some(&MapState::Complete { generation: 5 }));
        assert_eq!(receiver.cells(), sent.maps[5]);
    }

    /// Each frame is lost once: a map with a missing part is never shown as complete until the next keyframe.
    #[test]
    fn a_lost_frame_never_shows_a_wrong_map() {
        let sent = rounds(7, 3, 3);
        let frames: Vec<&[u8]> = sent.bytes.split_inclusive(|&byte| byte == 0).collect();
        let mut damaged = 0;
        for lost in 0..frames.len() {
            let rest: Vec<u8> = (0..frames.len())
                .filter(|&index| index != lost)
                .flat_map(|index| frames[index].to_vec())
                .collect();
            let receiver = received(&rest);
            for map in &receiver.complete {
                assert!(sent.maps.contains(map), "frame {lost}");
            }
            let maps = |receiver: &Receiver| receiver.complete.len();
            damaged += usize::from(maps(&receiver) + 1 < maps(&received(&sent.bytes)));
            // The last generation is a keyframe, which repairs all earlier losses.
            if lost + 9 < frames.len() {
                assert_eq!(receiver.view.state(), MapState::Complete { generation: 6 });
            }
        }
        assert!(damaged > 10, "the loss of a part shows");
    }

    #[test]
    fn without_last_parts_a_map_becomes_incomplete() {
        let sent = rounds(4, 5, 50);
        let mut receiver = Receiver::new();
        let mut ends = 0;
        for frame in sent.bytes.split_inclusive(|&byte| byte == 0) {
            let report = received(frame).reports.pop();
            if matches!(report, Some(Report::Map(MapPart { end: Some(_), .. }))) {
                ends += 1;
                if ends > 1 {
                    continue;
                }
            }
            receiver.receive(frame);
        }
        assert_eq!(receiver.view.state(), MapState::Incomplete);
    }

    #[test]
    fn the_same_cells_in_another_grid_do_not_match() {
        let cells = [77; CELLS];
        let (reports, _) = sent(&mut reporter(1), &cells, 9);
        for (columns, rows, cell, x) in [(11, 17, 100, -850), (17, 11, 50, -850), (17, 11, 100, 0)]
        {
            let cell = Millimeters::new(cell);
            let geometry = Geometry::try_new(columns, rows, cell, Point::from_mm(x, 0)).unwrap();
            let mut view = MapView::new([0; CELLS], [0; CELLS]);
            view.take(&Report::Hello(Hello { geometry, ..HELLO }));
            reports[1..].iter().for_each(|report| view.take(report));
            assert_eq!(view.state(), MapState::Incomplete);
        }
    }

    #[test]
    fn a_map_too_large_to_store_is_reported() {
        let mut view = MapView::new([0; CELLS - 1], [0; CELLS - 1]);
        let (reports, _) = sent(&mut reporter(1), &[77; CELLS], 9);
        reports.iter().for_each(|report| view.take(report));
        assert_eq!(view.state(), MapState::TooLarge);
        assert_eq!(view.cells().count(), 0);
    }

    #[test]
    fn parts_without_a_hello_are_no_map() {
        let (reports, _) = sent(&mut reporter(1), &[77; CELLS], 9);
        let mut view = MapView::new([0; CELLS], [0; CELLS]);
        reports[1..].iter().for_each(|report| view.take(report));
        assert_eq!((view.state(), view.cells().count()), (MapState::Unknown, 0));
    }

    proptest! {
        /// Cells may change while parts are sent: a generation has at most four parts, and the map matches once
        /// the cells are constant.
        #[test]
        fn a_map_that_changes_while_sent_matches_in_the_end(
            changes in prop::collection::vec((0..CELLS, any::<u8>(), 0..3_u8, 0..4_usize), 0..60),
            keyframe_every in 0..6_u16,
        ) {
            let mut reporter = reporter(keyframe_every);
            let mut cells = [128; CELLS];
            let mut receiver = Receiver::new();
            let mut parts = 0;
            for (place, value, calls, room) in changes {
                cells[place] = value;
                reporter.outbox_mut().room = Some(room);
                let grid = Drawn::smart_car(&cells);
                let done = reporter.send_map(&Environment::new(&grid, &NO_HEALTH), calls);
                let bytes = core::mem::take(&mut reporter.outbox_mut().bytes);
                parts += runs(&received(&bytes).reports).len();
                receiver.receive(&bytes);
                prop_assert!(parts <= 4, "a generation of {parts} parts");
                if done {
                    parts = 0;
                    let complete = matches!(receiver.view.state(), MapState::Complete { .. });
                    prop_assert!(complete);
                }
            }
            reporter.outbox_mut().room = None;
            let grid = Drawn::smart_car(&cells);
            for _ in 0..2 {
                while !reporter.send_map(&Environment::new(&grid, &NO_HEALTH), 1) {}
            }
            receiver.receive(&reporter.release().bytes);
            prop_assert_eq!(receiver.cells(), cells);
        }
    }
}
