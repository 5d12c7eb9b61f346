//! How far a map is from the truth.

use super::Truth;
use crate::export::CellState;
use certainty_core::certainty::Certainty;
use serde::Serialize;

/// The distance of a map from the grid of perfect sensors.
///
/// MAE and MSE are \[001\] §6.2's; they hide what hurts a robot, which is why `missed` and `ghost` stand
/// beside them.
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

/// Which cells MAE and MSE are the mean over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scored {
    /// Every cell of the grid.
    All,
    /// Those that perfect sensors know: free or occupied.
    Known,
}

impl Score {
    /// No distance at all.
    pub const ZERO: Self = Self {
        mae: 0.0,
        mse: 0.0,
        missed: 0.0,
        ghost: 0.0,
    };

    /// The sum of two, for a mean.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            mae: self.mae + other.mae,
            mse: self.mse + other.mse,
            missed: self.missed + other.missed,
            ghost: self.ghost + other.ghost,
        }
    }

    /// A part of it, for a mean.
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
    /// Certainties count as bytes over 255, so that *free* and *occupied* are 1 apart. Where there is
    /// no obstacle (or no free) cell, nothing of it can be missed (or be a ghost): 0.
    ///
    /// # Panics
    ///
    /// If the two are of different sizes.
    #[must_use]
    pub fn of(map: &[Certainty], truth: &[Truth]) -> Self {
        let landmarks: Vec<_> = truth.iter().map(|cell| cell.certainty()).collect();
        Self::against(map, &landmarks, truth, Scored::All)
    }

    /// Compares a map with another one, `ideal`, over the `scored` cells.
    ///
    /// What is missed and what is a ghost, only the truth can say; of no cell the distance is 0.
    ///
    /// # Panics
    ///
    /// If the three are of different sizes.
    #[must_use]
    pub fn against(
        map: &[Certainty],
        ideal: &[Certainty],
        truth: &[Truth],
        scored: Scored,
    ) -> Self {
        assert!(
            map.len() == truth.len() && ideal.len() == truth.len(),
            "a map and its truth cover the same cells"
        );
        let mut sums = (0.0, 0.0);
        let mut cells = 0_u32;
        let (mut occupied, mut missed, mut free, mut ghost) = (0_u32, 0_u32, 0_u32, 0_u32);
        for ((&shown, &ideal), &true_cell) in map.iter().zip(ideal).zip(truth) {
            if scored == Scored::All || true_cell != Truth::Unseen {
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
    fn a_missed_obstacle_and_a_ghost_count_as_such() {
        let wrong = score([0, 255, 0, 128]);
        assert_eq!((wrong.mae, wrong.mse), (0.5, 0.5));
        assert_eq!((wrong.missed, wrong.ghost), (1.0, 0.5));
    }

    #[test]
    fn an_uncertain_obstacle_is_missed_but_no_ghost() {
        let vague = score([128, 128, 128, 128]);
        assert_eq!((vague.missed, vague.ghost), (1.0, 0.0));
        let error = 128.0 / 255.0;
        assert!((vague.mae - (2.0 * error + 127.0 / 255.0) / 4.0).abs() < 1e-12);
    }

    #[test]
    fn where_perfect_sensors_know_nothing_an_error_may_count_or_not() {
        let map = [0, 0, 255, 0].map(Certainty::from_bits);
        let ideal = TRUTH.map(Truth::certainty);
        let mae = |scored| Score::against(&map, &ideal, &TRUTH, scored).mae;
        assert_eq!(mae(Scored::Known), 0.0);
        assert!((mae(Scored::All) - 128.0 / 255.0 / 4.0).abs() < 1e-12);
    }

    #[test]
    fn a_map_is_compared_with_the_ideal_that_is_given() {
        let map = [51, 0, 204, 128].map(Certainty::from_bits);
        let score = Score::against(&map, &map, &TRUTH, Scored::All);
        assert_eq!((score.mae, score.mse), (0.0, 0.0));
        assert_eq!((score.missed, score.ghost), (0.0, 0.0));
    }
}
