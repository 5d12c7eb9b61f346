//! Compares two maps cell by cell, on the coarser grid of the two.

use super::map_image::CellState;
use super::ros_map::RosMap;
use serde::Serialize;

/// How far map B agrees with the reference map A.
///
/// Cells are those of the coarser map, or of A if both have the same size. A fraction of nothing is
/// `None`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Cells that lie in both maps.
    pub overlap: u64,
    /// Cells that are free or occupied in both maps.
    pub known_in_both: u64,
    /// The cells known in both with the same state.
    pub agreeing: u64,
    /// `agreeing` as a fraction of `known_in_both`.
    pub agreement: Option<f64>,
    /// Cells of the overlap that are occupied in A and not in B: missed obstacles.
    pub missed: u64,
    /// `missed` as a fraction of the overlap's cells that are occupied in A.
    pub missed_fraction: Option<f64>,
    /// Cells of the overlap that are free in A and occupied in B: ghost obstacles.
    pub ghost: u64,
    /// `ghost` as a fraction of the overlap's cells that are free in A.
    pub ghost_fraction: Option<f64>,
    /// Cells that are known in A and unknown in B or beyond it.
    pub only_a: u64,
    /// Cells that are known in B and unknown in A or beyond it.
    pub only_b: u64,
    /// Whether the maps' cells lie more than a hundredth of a cell apart, or are turned against each
    /// other; then the nearest cell is taken, which blurs every border.
    pub misaligned: bool,
    /// What a user should know about the comparison, a line each.
    pub notes: Vec<String>,
}

/// Why two maps cannot be compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum CompareError {
    /// They have no cell in common.
    #[error("the maps have no cell in common; check their origins")]
    Apart,
}

/// The largest relative difference between two equal resolutions, from their decimal digits.
const SAME_RESOLUTION: f64 = 1e-6;

/// Up to this turn, in radians, two maps are not turned against each other.
const SAME_TURN: f64 = 1e-4;

/// Compares map `b` with the reference `a`, cell by cell where both are.
///
/// Maps with the same resolution that are not turned against each other are compared as they are, each
/// cell with the nearest. Else the finer map is resampled to the cells of the coarser: a coarse cell is
/// occupied if the middle of an occupied fine cell lies in it, else free if that of a free one does; if
/// it has none, it is as the fine cell at its own middle. So no obstacle is lost. Known cells of the
/// finer map that lie beyond the coarser are counted by their area.
///
/// Time: each cell of both maps once. Memory: a byte for each cell of the coarser map.
///
/// # Errors
/// If they have no cell in common.
pub fn compare(a: &RosMap, b: &RosMap) -> Result<Comparison, CompareError> {
    let (a_m, b_m) = (a.resolution_m(), b.resolution_m());
    let same_size = (a_m - b_m).abs() <= SAME_RESOLUTION * a_m;
    let turned = (a.yaw_rad() - b.yaw_rad()).abs() > SAME_TURN;
    let swapped = !same_size && b_m > a_m;
    let (coarse, fine) = if swapped { (b, a) } else { (a, b) };
    let into = Placement::of(fine, coarse);
    // Where the fine map's first cell lies, in fine cells.
    let offset = into.origin.map(|cells| cells / into.scale);
    let apart = |cells: f64| (cells - cells.round()).abs() > 0.01;
    let whole = same_size || !apart(1.0 / into.scale);
    let misaligned = turned || !whole || offset.into_iter().any(apart);
    let mut notes = Vec::new();
    let mut count = Count::default();
    let (only_coarse, only_fine);
    if same_size && !turned {
        // An offset that is not a number is treated as beyond all cells.
        if offset
            .iter()
            .any(|cells| cells.is_nan() || cells.abs() > f64::from(u32::MAX))
        {
            return Err(CompareError::Apart);
        }
        let [dx, dy] = offset.map(|cells| cells.round() as i64);
        for y in 0..i64::from(a.height()) {
            for x in 0..i64::from(a.width()) {
                if let (Some(in_a), Some(in_b)) = (a.state(x, y), b.state(x - dx, y - dy)) {
                    count.add(in_a, in_b);
                }
            }
        }
        only_coarse = known(a.states()) - count.known_in_both;
        only_fine = known(b.states()) - count.known_in_both;
        if misaligned {
            notes.push("the maps' cells are not aligned: the nearest were compared".into());
        }
    } else {
        let (resampled, beyond) = resample(fine, coarse, &into);
        for (&of_coarse, &of_fine) in coarse.states().iter().zip(&resampled) {
            if let Some(of_fine) = of_fine {
                let (in_a, in_b) = if swapped {
                    (of_fine, of_coarse)
                } else {
                    (of_coarse, of_fine)
                };
                count.add(in_a, in_b);
            }
        }
        only_coarse = known(coarse.states()) - count.known_in_both;
        let area = beyond as f64 * into.scale * into.scale;
        let inside = known(resampled.iter().flatten()) - count.known_in_both;
        only_fine = inside + area.round() as u64;
        let finer = if swapped { "A" } else { "B" };
        if !same_size {
            let (from, to) = (fine.resolution_m(), coarse.resolution_m());
            notes.push(format!(
                "cells of {a_m} m in A and {b_m} m in B: {finer} was resampled from {from} to {to} m"
            ));
        }
        if turned {
            let degrees = (fine.yaw_rad() - coarse.yaw_rad()).to_degrees();
            notes.push(format!(
                "{finer} is turned by {degrees:.2} degrees against the other map: it was resampled to \
                 the other's cells"
            ));
        } else if misaligned {
            notes.push("the maps' cells are not aligned: the nearest were compared".into());
        }
    }
    if count.overlap == 0 {
        return Err(CompareError::Apart);
    }
    let (only_a, only_b) = if swapped {
        (only_fine, only_coarse)
    } else {
        (only_coarse, only_fine)
    };
    Ok(Comparison {
        overlap: count.overlap,
        known_in_both: count.known_in_both,
        agreeing: count.agreeing,
        agreement: fraction(count.agreeing, count.known_in_both),
        missed: count.missed,
        missed_fraction: fraction(count.missed, count.occupied_in_a),
        ghost: count.ghost,
        ghost_fraction: fraction(count.ghost, count.free_in_a),
        only_a,
        only_b,
        misaligned,
        notes,
    })
}

/// Where one map's cells lie in another map, in cells of the latter.
#[derive(Debug, Clone, Copy)]
struct Placement {
    /// The lower left corner.
    origin: [f64; 2],
    /// The width of a cell.
    scale: f64,
    /// Sine and cosine of the turn.
    turn: (f64, f64),
}

impl Placement {
    fn of(map: &RosMap, into: &RosMap) -> Self {
        let unit = into.resolution_m();
        let [x, y] = [0, 1].map(|axis| (map.origin_m()[axis] - into.origin_m()[axis]) / unit);
        let (sin, cos) = into.yaw_rad().sin_cos();
        Self {
            origin: [x * cos + y * sin, y * cos - x * sin],
            scale: map.resolution_m() / unit,
            turn: (map.yaw_rad() - into.yaw_rad()).sin_cos(),
        }
    }

    /// Returns the place of the middle of cell (`x`, `y`).
    fn middle(&self, x: u32, y: u32) -> [f64; 2] {
        let (sin, cos) = self.turn;
        let [x, y] = [x, y].map(|cell| (f64::from(cell) + 0.5) * self.scale);
        let [left, low] = self.origin;
        [left + x * cos - y * sin, low + x * sin + y * cos]
    }
}

/// Returns the cells of `coarse` with the states that `fine` has there, `None` beyond it, and the number of
/// known fine cells beyond `coarse`.
fn resample(fine: &RosMap, coarse: &RosMap, into: &Placement) -> (Vec<Option<CellState>>, u64) {
    let mut found: Vec<Option<CellState>> = vec![None; coarse.states().len()];
    let mut beyond = 0;
    let cells = (0..fine.height()).flat_map(|y| (0..fine.width()).map(move |x| (x, y)));
    for ((x, y), &state) in cells.zip(fine.states()) {
        let place = cell_at(coarse, into.middle(x, y));
        match place.and_then(|place| found.get_mut(place)) {
            Some(cell) => *cell = Some(cell.map_or(state, |other| stronger(other, state))),
            None => beyond += u64::from(state.is_known()),
        }
    }
    let back = Placement::of(coarse, fine);
    let cells = (0..coarse.height()).flat_map(|y| (0..coarse.width()).map(move |x| (x, y)));
    for ((x, y), cell) in cells.zip(&mut found) {
        if cell.is_none() {
            let place = cell_at(fine, back.middle(x, y));
            *cell = place.and_then(|place| fine.states().get(place).copied());
        }
    }
    (found, beyond)
}

/// Returns the index of the cell of `map` at `place`, which is in cells; `None` beyond the map.
fn cell_at(map: &RosMap, place: [f64; 2]) -> Option<usize> {
    let inside = |at: f64, cells: u32| at >= 0.0 && at < f64::from(cells);
    let [x, y] = place;
    let inside = inside(x, map.width()) && inside(y, map.height());
    // Only then the casts are exact, and the product is an index.
    inside.then(|| y as usize * map.width() as usize + x as usize)
}

/// Occupied before free before unknown.
const fn stronger(a: CellState, b: CellState) -> CellState {
    match (a, b) {
        (CellState::Occupied, _) | (_, CellState::Occupied) => CellState::Occupied,
        (CellState::Free, _) | (_, CellState::Free) => CellState::Free,
        (CellState::Unknown, CellState::Unknown) => CellState::Unknown,
    }
}

/// Counts over the overlap.
#[derive(Debug, Default)]
struct Count {
    overlap: u64,
    known_in_both: u64,
    agreeing: u64,
    missed: u64,
    ghost: u64,
    occupied_in_a: u64,
    free_in_a: u64,
}

impl Count {
    fn add(&mut self, in_a: CellState, in_b: CellState) {
        let both = in_a.is_known() && in_b.is_known();
        self.overlap += 1;
        self.known_in_both += u64::from(both);
        self.agreeing += u64::from(both && in_a == in_b);
        match in_a {
            CellState::Occupied => {
                self.occupied_in_a += 1;
                self.missed += u64::from(in_b != CellState::Occupied);
            }
            CellState::Free => {
                self.free_in_a += 1;
                self.ghost += u64::from(in_b == CellState::Occupied);
            }
            CellState::Unknown => {}
        }
    }
}

/// How many of `states` are free or occupied.
fn known<'a>(states: impl IntoIterator<Item = &'a CellState>) -> u64 {
    let known = states.into_iter().filter(|state| state.is_known());
    known.count() as u64
}

/// `part` of `whole`; `None` if `whole` is 0.
fn fraction(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::map_image::MapImage;
    use certainty_core::certainty::Certainty;
    use certainty_core::units::Point;

    /// A map as drawn, the top row first: `#` occupied, `.` free, `?` unknown.
    fn drawn<const ROWS: usize>(rows: [&str; ROWS], cell_mm: u32, x_mm: i32, y_mm: i32) -> RosMap {
        let certainty = |byte| match byte {
            b'#' => Certainty::OCCUPIED,
            b'.' => Certainty::FREE,
            b'?' => Certainty::UNCERTAIN,
            _ => panic!("{byte} is not a cell"),
        };
        let cells: Vec<Certainty> = rows
            .iter()
            .rev()
            .flat_map(|row| row.bytes().map(certainty))
            .collect();
        let origin = Point::from_mm(x_mm, y_mm);
        let width = rows[0].len() as u32;
        RosMap::from_image(&MapImage::try_new(width, ROWS as u32, &cells, cell_mm, origin).unwrap())
    }

    #[test]
    fn map_agrees_with_itself() {
        let map = drawn(["##?", "#..", "?.#"], 100, -300, 700);
        let expected = Comparison {
            overlap: 9,
            known_in_both: 7,
            agreeing: 7,
            agreement: Some(1.0),
            missed: 0,
            missed_fraction: Some(0.0),
            ghost: 0,
            ghost_fraction: Some(0.0),
            only_a: 0,
            only_b: 0,
            misaligned: false,
            notes: Vec::new(),
        };
        assert_eq!(compare(&map, &map), Ok(expected));
    }

    #[test]
    fn missed_and_ghost_cells_are_counted_apart() {
        let a = drawn(["####", "....", "????"], 100, 0, 0);
        let b = drawn(["##.?", "..#?", ".#??"], 100, 0, 0);
        let comparison = compare(&a, &b).unwrap();
        assert_eq!((comparison.known_in_both, comparison.agreeing), (6, 4));
        assert_eq!(
            (comparison.missed, comparison.missed_fraction),
            (2, Some(0.5))
        );
        assert_eq!(
            (comparison.ghost, comparison.ghost_fraction),
            (1, Some(0.25))
        );
        assert_eq!((comparison.only_a, comparison.only_b), (2, 2));
    }

    #[test]
    fn maps_are_aligned_by_their_origins() {
        let a = drawn(["....", ".##.", "...."], 100, -1000, -1000);
        // One cell right of and above A's origin; it reaches two cells beyond A.
        let b = drawn(["...?", "##.#"], 100, -900, -900);
        let comparison = compare(&a, &b).unwrap();
        assert_eq!((comparison.overlap, comparison.known_in_both), (6, 6));
        assert_eq!(comparison.agreement, Some(1.0));
        assert_eq!((comparison.only_a, comparison.only_b), (6, 1));
        assert!(!comparison.misaligned);
        let mirrored = compare(&b, &a).unwrap();
        assert_eq!((mirrored.only_a, mirrored.only_b), (1, 6));
        assert_eq!(mirrored.agreement, Some(1.0));
    }

    #[test]
    fn misaligned_cells_use_the_nearest() {
        let a = drawn(["#.."], 100, 0, 0);
        for (x_mm, misaligned) in [(101, false), (104, true), (99, false), (96, true)] {
            let comparison = compare(&drawn(["#.."], 100, x_mm - 100, 0), &a).unwrap();
            assert_eq!(
                (comparison.agreement, comparison.misaligned),
                (Some(1.0), misaligned)
            );
        }
        assert!(compare(&a, &drawn(["#.."], 100, 0, 49)).unwrap().misaligned);
    }

    #[test]
    fn maps_without_common_cells_are_refused() {
        let a = drawn(["#."], 100, 0, 0);
        for cell_mm in [100, 200] {
            for (x_mm, y_mm) in [(200, 0), (-400, 0), (0, 100), (0, -200), (Point::LIMIT, 0)] {
                assert_eq!(
                    compare(&a, &drawn(["#."], cell_mm, x_mm, y_mm)),
                    Err(CompareError::Apart)
                );
            }
        }
    }

    #[test]
    fn finer_map_is_resampled_to_the_coarser() {
        let coarse = drawn(["#.?", "..?"], 100, 0, 0);
        let fine = drawn(
            [
                "#...??", //
                ".....?", //
                "??...?", //
                "??..?#", //
            ],
            50,
            0,
            0,
        );
        // Resampled: `#..` above `?.#`.
        let comparison = compare(&coarse, &fine).unwrap();
        assert_eq!((comparison.overlap, comparison.known_in_both), (6, 3));
        assert_eq!((comparison.agreeing, comparison.missed), (3, 0));
        assert_eq!((comparison.only_a, comparison.only_b), (1, 2));
        assert!(!comparison.misaligned);
        assert_eq!(
            comparison.notes,
            ["cells of 0.1 m in A and 0.05 m in B: B was resampled from 0.05 to 0.1 m"]
        );
        let swapped = compare(&fine, &coarse).unwrap();
        assert_eq!((swapped.only_a, swapped.only_b), (2, 1));
        assert_eq!((swapped.overlap, swapped.agreement), (6, Some(1.0)));
        assert!(swapped.notes[0].contains("A was resampled from 0.05 to 0.1 m"));
    }

    #[test]
    fn cells_beyond_the_coarser_map_count_by_area() {
        let coarse = drawn(["."], 100, 0, 0);
        let fine = drawn(["....?", "..##?"], 50, 0, 0);
        let comparison = compare(&coarse, &fine).unwrap();
        assert_eq!((comparison.overlap, comparison.only_b), (1, 1));
        assert_eq!(compare(&fine, &coarse).unwrap().only_a, 1);
    }

    #[test]
    fn odd_ratios_are_misaligned() {
        let coarse = drawn(["##", ".."], 150, 0, 0);
        let fine = drawn(["###", "...", "..."], 100, 0, 0);
        let comparison = compare(&coarse, &fine).unwrap();
        assert!(comparison.misaligned);
        assert_eq!((comparison.overlap, comparison.agreement), (4, Some(1.0)));
        assert_eq!(comparison.notes.len(), 2);
        // Three fine cells are a coarse one.
        let fine = drawn(["######", "......"], 50, 0, 0);
        assert!(!compare(&coarse, &fine).unwrap().misaligned);
    }

    /// `map` with its lower left corner at (x, y), turned by `yaw`.
    fn placed(rows: &[&str], place: &str) -> RosMap {
        let pixels: String = rows
            .concat()
            .chars()
            .map(|c| match c {
                '#' => "0 ",
                '.' => "254 ",
                _ => "205 ",
            })
            .collect();
        let image = format!("P2 {} {} 255 {pixels}", rows[0].len(), rows.len());
        let yaml = format!("{{image: m, resolution: 0.1, origin: {place}}}");
        let loaded = RosMap::from_bytes(yaml.as_bytes(), image.as_bytes());
        loaded.unwrap().map
    }

    #[test]
    fn turned_maps_are_placed() {
        let a = placed(&["##.?", "...?", "?..#"], "[0, 0, 0]");
        // The same map, each time drawn from another corner.
        let half = placed(&["#..?", "?...", "?.##"], "[0.4, 0.3, 3.14159265]");
        let quarter = placed(&["?.#", "..#", "...", "#??"], "[0.4, 0, 1.57079633]");
        let comparison = compare(&a, &half).unwrap();
        assert_eq!((comparison.overlap, comparison.known_in_both), (12, 9));
        assert_eq!((comparison.agreement, comparison.only_b), (Some(1.0), 0));
        assert!(comparison.misaligned);
        assert_eq!(
            comparison.notes,
            [
                "B is turned by 180.00 degrees against the other map: it was resampled to the other's cells"
            ]
        );
        assert_eq!(compare(&half, &a).unwrap().agreement, Some(1.0));
        assert_eq!(compare(&half, &half).unwrap().notes, [""; 0]);
        let comparison = compare(&a, &quarter).unwrap();
        assert_eq!((comparison.overlap, comparison.known_in_both), (12, 9));
        assert_eq!((comparison.agreement, comparison.only_b), (Some(1.0), 0));
    }

    #[test]
    fn no_cell_is_lost_by_a_turn() {
        let a = placed(&["#".repeat(30).as_str(); 30], "[0, 0, 0]");
        for yaw in [0.3, 0.785, 1.1, -0.5] {
            let b = placed(
                &["#".repeat(10).as_str(); 10],
                &format!("[1.5, 1.2, {yaw}]"),
            );
            let comparison = compare(&a, &b).unwrap();
            assert!(
                comparison.overlap.abs_diff(100) <= 20,
                "{}",
                comparison.overlap
            );
            assert_eq!((comparison.agreement, comparison.only_b), (Some(1.0), 0));
            assert_eq!(comparison.only_a, 900 - comparison.overlap);
        }
    }

    #[test]
    fn fraction_of_nothing_is_none() {
        let a = drawn(["??"], 100, 0, 0);
        let comparison = compare(&a, &drawn(["#."], 100, 0, 0)).unwrap();
        assert_eq!(comparison.agreement, None);
        assert_eq!(
            (comparison.missed_fraction, comparison.ghost_fraction),
            (None, None)
        );
        let json = serde_json::to_value(comparison).unwrap();
        assert!(json["agreement"].is_null());
        assert_eq!(json["only_b"], 2);
    }
}
