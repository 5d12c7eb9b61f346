//! Fault-tolerant median selection: \[000\] §3.2, \[001\] §4.

use super::grid::{CertaintyGrid, GridError, Measurement};
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
/// What it takes of an even number of votes is said by its [`Middle`].
///
/// Memory: n bytes a cell (\[001\] §7). Cost: adding is one store; reading inserts n votes in order.
#[derive(Debug, Clone)]
pub struct MedianGrid<Sh, S, const N: usize, K = Latest> {
    layers: Layers<Sh, S, N, K>,
    middle: Middle,
}

/// Which value is in the middle of an even number of votes; \[000\] §3.2 and \[001\] §4 do not say.
///
/// Either lies between two correct votes while no more than ⌊(n − 1)/2⌋ are wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Middle {
    /// The higher of the middle two: the median is *selected*, as both papers put it, and where two
    /// sensors disagree, one of which says *occupied*, a robot had better believe that one.
    #[default]
    Higher,
    /// The mean of the middle two, ties up: a value that no sensor gave, in doubt *uncertain*.
    Mean,
}

impl<Sh, S, const N: usize, K> MedianGrid<Sh, S, N, K>
where
    Sh: Shape,
    S: AsRef<[u8]> + AsMut<[u8]>,
    K: OwnGrid,
{
    /// Creates a grid for sensors 1 to `sensors` that have seen nothing yet and keep their words as
    /// `own` does.
    ///
    /// # Errors
    ///
    /// [`GridError`] unless `sensors` is 1 to `N` and `storage` has a byte for each cell and sensor.
    pub fn try_new(
        shape: Sh,
        sensors: u8,
        middle: Middle,
        own: K,
        storage: S,
    ) -> Result<Self, GridError<S>> {
        Layers::try_new(shape, sensors, own, storage).map(|layers| Self { layers, middle })
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
        self.middle.of(&self.layers.votes(cell))
    }

    fn memory_bytes(&self) -> usize {
        self.layers.memory_bytes()
    }
}

impl Middle {
    /// The middle of sorted votes; *uncertain* of none.
    fn of(self, votes: &[Certainty]) -> Certainty {
        let upper = votes.len() / 2;
        let lower = match self {
            Self::Higher => upper,
            Self::Mean => votes.len().saturating_sub(1) / 2,
        };
        match (votes.get(lower), votes.get(upper)) {
            (Some(low), Some(high)) => {
                let sum = u32::from(low.to_bits()).wrapping_add(high.to_bits().into());
                Certainty::from_bits(wrapping_u8(sum.wrapping_add(1) >> 1))
            }
            _ => Certainty::UNCERTAIN,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fault_hypothesis::every_minority;
    use super::super::grid::GridErrorKind;
    use super::super::layers::Accumulated;
    use super::super::picture::draw_grid;
    use super::*;
    use crate::sensor::SensorId;
    use crate::units::{Millimeters, Point};

    fn votes(bits: &[u8]) -> Vec<Certainty> {
        let mut votes: Vec<_> = bits.iter().copied().map(Certainty::from_bits).collect();
        votes.sort();
        votes
    }

    #[test]
    fn the_middle_of_an_odd_number_is_one_of_them() {
        for middle in [Middle::Higher, Middle::Mean] {
            assert_eq!(middle.of(&votes(&[9, 255, 3])).to_bits(), 9);
            assert_eq!(middle.of(&votes(&[77])).to_bits(), 77);
        }
    }

    #[test]
    fn the_middle_of_an_even_number_is_the_higher_of_two_or_their_mean_ties_up() {
        assert_eq!(Middle::Higher.of(&votes(&[0, 255])).to_bits(), 255);
        assert_eq!(Middle::Higher.of(&votes(&[0, 10, 12, 255])).to_bits(), 12);
        assert_eq!(Middle::Mean.of(&votes(&[0, 255])).to_bits(), 128);
        assert_eq!(Middle::Mean.of(&votes(&[0, 10, 11, 255])).to_bits(), 11);
    }

    #[test]
    fn no_vote_is_uncertain() {
        for middle in [Middle::Higher, Middle::Mean] {
            assert_eq!(middle.of(&[]), Certainty::UNCERTAIN);
        }
    }

    #[test]
    fn any_minority_of_liars_leaves_the_value_between_correct_ones() {
        every_minority(|told, correct| {
            for middle in [Middle::Higher, Middle::Mean] {
                let value = middle.of(&votes(told)).to_bits();
                let between = correct[0]..=correct[correct.len() - 1];
                assert!(between.contains(&value), "{middle:?} of {told:?}: {value}");
            }
        });
    }

    #[test]
    fn the_vote_adapts_to_who_saw_the_cell() {
        let shape = Geometry::try_new(4, 1, Millimeters::new(100), Point::ORIGIN).unwrap();
        let mut grid =
            MedianGrid::<_, _, 3>::try_new(shape, 3, Middle::Higher, Latest, [0; 12]).unwrap();
        // Sensor 3 lies everywhere; ever fewer sensors see the cells from left to right.
        for (column, seen_by) in [(0, [1, 2, 3].as_slice()), (1, &[1, 3]), (2, &[3])] {
            let cell = shape.cell(column, 0).unwrap();
            for &number in seen_by {
                let certainty = if number == 3 {
                    Certainty::FREE
                } else {
                    Certainty::OCCUPIED
                };
                let sensor = SensorId::try_new(number).unwrap();
                grid.add(cell, Measurement { sensor, certainty }, &mut []);
            }
        }
        assert_eq!(draw_grid(&grid), ["##.?"]);
    }

    #[test]
    fn more_sensors_than_the_type_has_room_for_are_refused() {
        let shape = Geometry::try_new(1, 1, Millimeters::new(100), Point::ORIGIN).unwrap();
        for sensors in [0, 4] {
            let storage = vec![0; sensors.into()];
            let own = Accumulated::default();
            let middle = Middle::Higher;
            let refused = MedianGrid::<_, _, 3, _>::try_new(shape, sensors, middle, own, storage);
            assert_eq!(refused.unwrap_err().why, GridErrorKind::Sensors { most: 3 });
        }
    }
}
