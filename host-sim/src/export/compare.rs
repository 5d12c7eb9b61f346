//! Compares two maps cell by cell.

use super::map_image::CellState;
use super::ros_map::RosMap;
use serde::Serialize;

/// How far map B agrees with the reference map A.
///
/// A fraction of nothing is `None`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
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
    /// Whether the maps' cells lie more than a hundredth of a cell apart; then the nearest cell is
    /// taken, which blurs every border.
    pub misaligned: bool,
}

/// Why two maps cannot be compared.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum CompareError {
    /// Their cells have different sizes.
    #[error(
        "the maps' cells are {a_m} m and {b_m} m wide; make both maps with the same resolution"
    )]
    Resolution {
        /// Metres a cell of A.
        a_m: f64,
        /// Metres a cell of B.
        b_m: f64,
    },
    /// They have no cell in common.
    #[error("the maps have no cell in common; check their origins")]
    Apart,
}

/// The largest relative difference between two equal resolutions, from their decimal digits.
const SAME_RESOLUTION: f64 = 1e-6;

/// Compares map `b` with the reference `a`, cell by cell where both are.
///
/// # Errors
/// If their resolutions differ or they have no cell in common.
pub fn compare(a: &RosMap, b: &RosMap) -> Result<Comparison, CompareError> {
    let (a_m, b_m) = (a.resolution_m(), b.resolution_m());
    if (a_m - b_m).abs() > SAME_RESOLUTION * a_m {
        return Err(CompareError::Resolution { a_m, b_m });
    }
    // Where B's first cell lies, in cells of A.
    let offset = [0, 1].map(|axis| (b.origin_m()[axis] - a.origin_m()[axis]) / a_m);
    // An offset that is not a number is treated as beyond all cells.
    if offset
        .iter()
        .any(|cells| cells.is_nan() || cells.abs() > f64::from(u32::MAX))
    {
        return Err(CompareError::Apart);
    }
    let misaligned = offset
        .iter()
        .any(|cells| (cells - cells.round()).abs() > 0.01);
    let [dx, dy] = offset.map(|cells| cells.round() as i64);
    let mut count = Count::default();
    for y in 0..i64::from(a.height()) {
        for x in 0..i64::from(a.width()) {
            if let (Some(in_a), Some(in_b)) = (a.state(x, y), b.state(x - dx, y - dy)) {
                count.add(in_a, in_b);
            }
        }
    }
    if count.overlap == 0 {
        return Err(CompareError::Apart);
    }
    Ok(Comparison {
        overlap: count.overlap,
        known_in_both: count.known_in_both,
        agreeing: count.agreeing,
        agreement: fraction(count.agreeing, count.known_in_both),
        missed: count.missed,
        missed_fraction: fraction(count.missed, count.occupied_in_a),
        ghost: count.ghost,
        ghost_fraction: fraction(count.ghost, count.free_in_a),
        only_a: known(a) - count.known_in_both,
        only_b: known(b) - count.known_in_both,
        misaligned,
    })
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

/// How many cells of `map` are free or occupied.
fn known(map: &RosMap) -> u64 {
    map.states().iter().filter(|state| state.is_known()).count() as u64
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
    fn maps_that_cannot_be_aligned_are_refused() {
        let a = drawn(["#."], 100, 0, 0);
        let finer = drawn(["#."], 50, 0, 0);
        assert_eq!(
            compare(&a, &finer).unwrap_err().to_string(),
            "the maps' cells are 0.1 m and 0.05 m wide; make both maps with the same resolution"
        );
        for (x_mm, y_mm) in [(200, 0), (-200, 0), (0, 100), (0, -100), (Point::LIMIT, 0)] {
            assert_eq!(
                compare(&a, &drawn(["#."], 100, x_mm, y_mm)),
                Err(CompareError::Apart)
            );
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
