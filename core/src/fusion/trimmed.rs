//! Trim, then Bayes: the fault-tolerant average of \[000\] §3.1.

use super::grid::{CertaintyGrid, GridError, GridErrorKind, Measurement};
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
/// Memory: n bytes a cell (\[000\] §5). Cost: adding is one store; reading inserts n votes in order.
#[derive(Debug, Clone)]
pub struct TrimmedGrid<Sh, S, const N: usize, K = Latest> {
    layers: Layers<Sh, S, N, K>,
    trim: u8,
}

impl<Sh, S, const N: usize, K> TrimmedGrid<Sh, S, N, K>
where
    Sh: Shape,
    S: AsRef<[u8]> + AsMut<[u8]>,
    K: OwnGrid,
{
    /// Creates a grid for sensors 1 to `sensors`, of which `trim` may be wrong at a time.
    ///
    /// Each keeps its words as `own` does; what is left of the votes enters eq. 1 as it is.
    ///
    /// # Errors
    ///
    /// [`GridError`] unless `sensors` is 1 to `N` and at least 2 · `trim` + 1, and `storage` has a byte for
    /// each cell and sensor.
    pub fn try_new(
        shape: Sh,
        sensors: u8,
        trim: u8,
        own: K,
        storage: S,
    ) -> Result<Self, GridError<S>> {
        if u16::from(trim).wrapping_mul(2) >= u16::from(sensors) {
            let why = GridErrorKind::Trim;
            return Err(GridError { why, storage });
        }
        Layers::try_new(shape, sensors, own, storage).map(|layers| Self { layers, trim })
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
        trimmed(&self.layers.votes(cell), self.trim.into())
    }

    fn memory_bytes(&self) -> usize {
        self.layers.memory_bytes()
    }
}

/// Eq. 1 of sorted votes without the `trim` lowest and highest.
fn trimmed(votes: &[Certainty], trim: usize) -> Certainty {
    let end = votes.len().saturating_sub(trim);
    let kept = votes.get(trim..end).unwrap_or(&[]);
    kept.iter()
        .map(|&vote| LogOdds::of(vote))
        .fold(LogOdds::EVEN, LogOdds::saturating_add)
        .certainty()
}

#[cfg(test)]
mod tests {
    use super::super::fault_hypothesis::every_minority;
    use super::*;
    use crate::units::{Millimeters, Point};

    fn fused(bits: &[u8], trim: usize) -> Certainty {
        let mut votes: Vec<_> = bits.iter().copied().map(Certainty::from_bits).collect();
        votes.sort();
        trimmed(&votes, trim)
    }

    #[test]
    fn what_is_kept_is_fused_by_eq_1() {
        // 0.75 and 0.75 of [0, 0.75, 0.75, 1]: odds 3 · 3, so 0.9, which is 230.4; each vote is
        // rounded to a step of log-odds, 1.4 of these at most.
        for (votes, trim) in [([0, 192, 255, 192].as_slice(), 1), (&[192, 192], 0)] {
            assert!(fused(votes, trim).to_bits().abs_diff(230) <= 2);
        }
    }

    #[test]
    fn a_trim_that_leaves_nothing_of_all_sensors_is_refused() {
        let shape = Geometry::try_new(1, 1, Millimeters::new(100), Point::ORIGIN).unwrap();
        let with = |trim| TrimmedGrid::<_, _, 3>::try_new(shape, 3, trim, Latest, [0; 3]);
        assert!(with(1).is_ok());
        assert_eq!(with(2).unwrap_err().why, GridErrorKind::Trim);
    }

    #[test]
    fn three_votes_trimmed_by_one_are_their_median() {
        // But for the rounding to a step of log-odds.
        for (votes, middle) in [([0, 200, 255], 200), ([0, 0, 255], 0), ([255, 7, 255], 255)] {
            assert!(
                fused(&votes, 1).to_bits().abs_diff(middle) <= 2,
                "{votes:?}"
            );
        }
    }

    #[test]
    fn fewer_than_2t_plus_1_votes_are_uncertain() {
        for trim in 1..4_usize {
            for votes in 0..2 * trim + 1 {
                assert_eq!(fused(&vec![255; votes], trim), Certainty::UNCERTAIN);
            }
            assert_eq!(fused(&vec![255; 2 * trim + 1], trim), Certainty::OCCUPIED);
        }
    }

    /// Of an odd number of words one is left, which is a correct one or lies between two. Of an even
    /// number two are, and eq. 1 makes agreement surer than either: the value is between what it makes
    /// of the lowest and of the highest correct word, twice.
    #[test]
    fn any_minority_of_liars_that_is_trimmed_leaves_the_value_between_correct_ones() {
        const ROUNDING: u8 = 2;
        every_minority(|told, correct| {
            let trim = (told.len() - 1) / 2;
            let kept = told.len() - 2 * trim;
            let agreed = |word: u8| fused(&vec![word; kept], 0).to_bits();
            let lowest = agreed(correct[0]) - ROUNDING;
            let highest = agreed(correct[correct.len() - 1]) + ROUNDING;
            let value = fused(told, trim).to_bits();
            assert!((lowest..=highest).contains(&value), "{told:?}: {value}");
        });
    }

    /// \[000\] §3.1: values outside are removed, values between two correct ones do no harm.
    #[test]
    fn t_liars_among_2t_plus_1_cannot_turn_agreeing_sensors() {
        for trim in 1..4_usize {
            for lie in 0..=u8::MAX {
                let mut votes = vec![230; trim + 1];
                votes.extend(vec![lie; trim]);
                let certainty = fused(&votes, trim).to_bits();
                assert!(certainty >= 229, "{trim} liars say {lie}: {certainty}");
            }
        }
    }
}
