//! The map of perfect sensors, and the distance of another map from it.

use crate::export::CellState;
use crate::transducer::{Look, PerfectSensor, Sensor};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::{Beam, BeamModel, Cell, Geometry};
use serde::Serialize;

/// The state of a cell for perfect sensors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Truth {
    /// Never seen, or only behind an obstacle.
    Unseen,
    /// Passed by beams and never hit.
    Free,
    /// Hit at least once.
    Occupied,
}

impl Truth {
    /// Returns the certainty of a perfect grid.
    #[must_use]
    pub const fn certainty(self) -> Certainty {
        match self {
            Self::Unseen => Certainty::UNCERTAIN,
            Self::Free => Certainty::FREE,
            Self::Occupied => Certainty::OCCUPIED,
        }
    }
}

/// The grid of perfect sensors with the looks of the real ones.
///
/// A cell hit once is occupied, also if later beams pass it: perfect sensors have no errors, and a cell
/// with an obstacle at its edge is both hit and passed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reference {
    geometry: Geometry,
    cells: Vec<Truth>,
}

impl Reference {
    /// Creates the grid from a perfect sensor and the looks of all real ones.
    pub fn new(
        geometry: Geometry,
        model: &BeamModel,
        mut perfect: PerfectSensor,
        looks: impl IntoIterator<Item = Look>,
    ) -> Self {
        let mut cells = vec![Truth::Unseen; geometry.cells() as usize];
        for look in looks {
            let beam = Beam {
                origin: look.origin,
                bearing: look.bearing,
                reading: perfect.sense(&look),
            };
            beam.interpret(&geometry, model, &mut |cell: Cell, certainty: Certainty| {
                let truth = &mut cells[cell.index()];
                *truth = match (*truth, certainty) {
                    (_, Certainty::OCCUPIED) => Truth::Occupied,
                    (Truth::Unseen, Certainty::FREE) => Truth::Free,
                    (unchanged, _) => unchanged,
                };
            });
        }
        Self { geometry, cells }
    }

    /// Returns the geometry of the grid.
    #[must_use]
    pub const fn geometry(&self) -> Geometry {
        self.geometry
    }

    /// Returns the state of every cell, row after row from the lowest.
    #[must_use]
    pub fn cells(&self) -> &[Truth] {
        &self.cells
    }
}

/// The distance of a map from the grid of perfect sensors.
///
/// MAE and MSE are those of \[001\] §6.2. They average out the errors that endanger a robot, which `missed`
/// and `ghost` count.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Score {
    /// Mean over all cells of the distance between the certainties, 0 to 1.
    pub mae: f64,
    /// Mean over all cells of its square.
    pub mse: f64,
    /// Share of the obstacle cells that the map does not show as occupied.
    pub missed: f64,
    /// Share of the free cells that the map shows as occupied.
    pub ghost: f64,
}

/// The cells of which MAE and MSE are the mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScoredCells {
    /// Every cell of the grid.
    All,
    /// The cells that perfect sensors have seen: free or occupied.
    Known,
}

impl Score {
    /// The score of equal maps.
    pub const ZERO: Self = Self {
        mae: 0.0,
        mse: 0.0,
        missed: 0.0,
        ghost: 0.0,
    };

    /// Returns the sum of two scores, for a mean.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            mae: self.mae + other.mae,
            mse: self.mse + other.mse,
            missed: self.missed + other.missed,
            ghost: self.ghost + other.ghost,
        }
    }

    /// Returns the score divided by `count`, for a mean.
    #[must_use]
    pub fn over(&self, count: f64) -> Self {
        Self {
            mae: self.mae / count,
            mse: self.mse / count,
            missed: self.missed / count,
            ghost: self.ghost / count,
        }
    }

    /// Compares a map with the truth, cell by cell.
    ///
    /// Certainties count as bytes over 255, so that *free* and *occupied* are 1 apart. Without an
    /// obstacle cell `missed` is 0, without a free cell `ghost`.
    ///
    /// # Panics
    ///
    /// If the two are of different sizes.
    #[must_use]
    pub fn of(map: &[Certainty], truth: &[Truth]) -> Self {
        let landmarks: Vec<_> = truth.iter().map(|cell| cell.certainty()).collect();
        Self::against(map, &landmarks, truth, ScoredCells::All)
    }

    /// Compares a map with another one, `ideal`, over the `scored` cells.
    ///
    /// `missed` and `ghost` compare with the truth. The distance over no cell is 0.
    ///
    /// # Panics
    ///
    /// If the three are of different sizes.
    #[must_use]
    pub fn against(
        map: &[Certainty],
        ideal: &[Certainty],
        truth: &[Truth],
        scored: ScoredCells,
    ) -> Self {
        assert!(
            map.len() == truth.len() && ideal.len() == truth.len(),
            "a map and its truth cover the same cells"
        );
        let mut sums = (0.0, 0.0);
        let mut cells = 0_u32;
        let (mut occupied, mut missed, mut free, mut ghost) = (0_u32, 0_u32, 0_u32, 0_u32);
        for ((&shown, &ideal), &true_cell) in map.iter().zip(ideal).zip(truth) {
            if scored == ScoredCells::All || true_cell != Truth::Unseen {
                let error = f64::from(shown.to_bits().abs_diff(ideal.to_bits())) / 255.0;
                sums = (sums.0 + error, sums.1 + error * error);
                cells += 1;
            }
            let shown_occupied = CellState::of(shown) == CellState::Occupied;
            match true_cell {
                Truth::Occupied => {
                    occupied += 1;
                    missed += u32::from(!shown_occupied);
                }
                Truth::Free => {
                    free += 1;
                    ghost += u32::from(shown_occupied);
                }
                Truth::Unseen => {}
            }
        }
        let cells = f64::from(cells.max(1));
        let share = |part: u32, whole: u32| f64::from(part) / f64::from(whole.max(1));
        Self {
            mae: sums.0 / cells,
            mse: sums.1 / cells,
            missed: share(missed, occupied),
            ghost: share(ghost, free),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRUTH: [Truth; 4] = [Truth::Free, Truth::Free, Truth::Occupied, Truth::Unseen];

    fn score(bytes: [u8; 4]) -> Score {
        Score::of(&bytes.map(Certainty::from_bits), &TRUTH)
    }

    #[test]
    fn the_perfect_map_scores_zero() {
        let perfect = Score {
            mae: 0.0,
            mse: 0.0,
            missed: 0.0,
            ghost: 0.0,
        };
        assert_eq!(score([0, 0, 255, 128]), perfect);
    }

    #[test]
    fn missed_obstacles_and_ghosts_are_counted() {
        let wrong = score([0, 255, 0, 128]);
        assert_eq!((wrong.mae, wrong.mse), (0.5, 0.5));
        assert_eq!((wrong.missed, wrong.ghost), (1.0, 0.5));
    }

    #[test]
    fn an_uncertain_cell_is_missed_but_no_ghost() {
        let vague = score([128, 128, 128, 128]);
        assert_eq!((vague.missed, vague.ghost), (1.0, 0.0));
        let error = 128.0 / 255.0;
        assert!((vague.mae - (2.0 * error + 127.0 / 255.0) / 4.0).abs() < 1e-12);
    }

    #[test]
    fn unseen_cells_count_only_if_all_are_scored() {
        let map = [0, 0, 255, 0].map(Certainty::from_bits);
        let ideal = TRUTH.map(Truth::certainty);
        let mae = |scored| Score::against(&map, &ideal, &TRUTH, scored).mae;
        assert_eq!(mae(ScoredCells::Known), 0.0);
        assert!((mae(ScoredCells::All) - 128.0 / 255.0 / 4.0).abs() < 1e-12);
    }

    #[test]
    fn a_map_is_compared_with_the_given_ideal() {
        let map = [51, 0, 204, 128].map(Certainty::from_bits);
        let score = Score::against(&map, &map, &TRUTH, ScoredCells::All);
        assert_eq!((score.mae, score.mse), (0.0, 0.0));
        assert_eq!((score.missed, score.ghost), (0.0, 0.0));
    }
}
