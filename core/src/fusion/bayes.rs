//! The classic certainty grid: eq. 1 of \[001\], one byte a cell.

use super::grid::{CertaintyGrid, GridError, Measurement, zeroed};
use super::{Cell, Geometry, LogOdds, Shape, Strength};
use crate::certainty::Certainty;
use crate::health::Health;

/// A grid that fuses by Bayes' rule (\[001\] §3, eq. 1).
///
/// Cells keep log-odds, so a measurement is one saturating addition. Every measurement counts alike,
/// whoever made it: a sensor that is always wrong is believed as often as it speaks. Prefer it where
/// sensors are sound; it is the smallest and the fastest.
///
/// Order: no influence, as long as no cell reaches the bound of [`LogOdds`] on the way. (A cell's sum
/// may rest at −128, one step below it, and reads as −127.)
///
/// Memory: one byte a cell. Cost: one table look-up and one addition a cell.
#[derive(Debug, Clone)]
pub struct BayesGrid<Sh, S> {
    shape: Sh,
    strongest: Strength,
    cells: S,
}

impl<Sh: Shape, S: AsRef<[u8]> + AsMut<[u8]>> BayesGrid<Sh, S> {
    /// Creates a grid in which every cell is uncertain.
    ///
    /// `strongest` is the surest that one measurement may be, [`Strength::MEASUREMENT`] for instance.
    ///
    /// # Errors
    ///
    /// [`GridError`] unless `storage` has a byte for each cell.
    ///
    /// # Examples
    ///
    /// ```
    /// use certainty_core::certainty::Certainty;
    /// use certainty_core::fusion::{BayesGrid, CertaintyGrid, Geometry, Measurement};
    /// use certainty_core::fusion::Strength;
    /// use certainty_core::sensor::SensorId;
    /// use certainty_core::units::{Millimeters, Point};
    ///
    /// let shape = Geometry::try_new(17, 11, Millimeters::new(100), Point::ORIGIN)?;
    /// let mut grid = BayesGrid::try_new(shape, Strength::MEASUREMENT, [0; 187])?;
    /// let cell = shape.cell(3, 4).ok_or("outside")?;
    /// let sensor = SensorId::try_new(1).ok_or("zero")?;
    /// for _ in 0..2 {
    ///     grid.add(cell, Measurement { sensor, certainty: Certainty::OCCUPIED }, &mut []);
    /// }
    /// assert_eq!(grid.certainty(cell).to_bits(), 253); // 81 to 1
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    pub fn try_new(shape: Sh, strongest: Strength, storage: S) -> Result<Self, GridError<S>> {
        let cells = zeroed(storage, shape.geometry().cells() as usize)?;
        Ok(Self {
            shape,
            strongest,
            cells,
        })
    }
}

impl<Sh: Shape, S: AsRef<[u8]> + AsMut<[u8]>> CertaintyGrid for BayesGrid<Sh, S> {
    fn geometry(&self) -> Geometry {
        self.shape.geometry()
    }

    #[inline]
    fn add(&mut self, cell: Cell, measurement: Measurement, sensors: &mut [Health]) {
        self.add_all(core::iter::once(cell), measurement, sensors);
    }

    #[inline]
    fn add_all(
        &mut self,
        cells: impl Iterator<Item = Cell>,
        measurement: Measurement,
        _sensors: &mut [Health],
    ) {
        let opinion = self.strongest.odds(measurement.certainty);
        let stored = self.cells.as_mut();
        cells.for_each(|cell| {
            if let Some(stored) = stored.get_mut(cell.index()) {
                let sum = stored.cast_signed().saturating_add(opinion.steps());
                *stored = sum.cast_unsigned();
            }
        });
    }

    fn certainty(&self, cell: Cell) -> Certainty {
        let stored = self.cells.as_ref().get(cell.index()).copied();
        LogOdds::from_steps(stored.unwrap_or(0).cast_signed()).certainty()
    }

    fn memory_bytes(&self) -> usize {
        self.cells.as_ref().len()
    }
}

#[cfg(test)]
mod tests {
    use super::super::grid::GridErrorKind;
    use super::*;
    use crate::sensor::SensorId;
    use crate::units::{Millimeters, Point};
    use proptest::prelude::*;

    fn one_cell(strongest: Strength) -> (BayesGrid<Geometry, [u8; 1]>, Cell) {
        let shape = Geometry::try_new(1, 1, Millimeters::new(100), Point::ORIGIN).unwrap();
        let grid = BayesGrid::try_new(shape, strongest, [7]).unwrap();
        (grid, shape.cell(0, 0).unwrap())
    }

    fn fused(strongest: Strength, measurements: &[u8]) -> Certainty {
        let (mut grid, cell) = one_cell(strongest);
        let sensor = SensorId::try_new(1).unwrap();
        for &bits in measurements {
            let certainty = Certainty::from_bits(bits);
            grid.add(cell, Measurement { sensor, certainty }, &mut []);
        }
        grid.certainty(cell)
    }

    /// Eq. 1 of \[001\] in real numbers: the product of the odds against.
    fn naive(measurements: &[u8]) -> f64 {
        let against = |bits: u8| 256.0 / f64::from(bits) - 1.0;
        let product: f64 = measurements.iter().map(|&bits| against(bits)).product();
        1.0 / (product + 1.0)
    }

    #[test]
    fn a_new_grid_is_uncertain_whatever_its_storage_held() {
        let (grid, cell) = one_cell(Strength::MEASUREMENT);
        assert_eq!(grid.certainty(cell), Certainty::UNCERTAIN);
    }

    /// PEERS: a cell driven to 0 stayed 0 after 1,000 occupied readings (nav2).
    #[test]
    fn a_cell_driven_to_either_end_recovers() {
        for (wrong, right) in [(0, 255), (255, 0)] {
            let driven = [wrong; 1000];
            assert_eq!(fused(Strength::MEASUREMENT, &driven).to_bits(), wrong);
            let back: Vec<u8> = driven.into_iter().chain([right; 20]).collect();
            assert_eq!(fused(Strength::MEASUREMENT, &back).to_bits(), right);
        }
    }

    #[test]
    fn storage_of_another_size_is_handed_back() {
        let shape = Geometry::try_new(2, 2, Millimeters::new(100), Point::ORIGIN).unwrap();
        let refused = BayesGrid::try_new(shape, Strength::MEASUREMENT, [9; 3]).unwrap_err();
        assert_eq!(
            (refused.why, refused.storage),
            (GridErrorKind::Storage { needed: 4 }, [9; 3])
        );
    }

    proptest! {
        /// Eight bits allow it until a sum passes the bound: then what was cut off is lost.
        #[test]
        fn order_is_irrelevant_while_no_cell_reaches_the_bound(
            measurements in prop::collection::vec(0..=255_u8, 0..4), order: prop::sample::Index,
        ) {
            // Three measurements of at most 35 steps stay below 127.
            let mut other = measurements.clone();
            if !other.is_empty() {
                let turn = order.index(other.len());
                other.rotate_left(turn);
                other.reverse();
            }
            prop_assert_eq!(
                fused(Strength::MEASUREMENT, &measurements),
                fused(Strength::MEASUREMENT, &other)
            );
        }

        #[test]
        fn beyond_the_bound_order_moves_a_cell_by_less_than_what_was_cut_off(
            ups in 0..30_usize, downs in 0..30_usize,
        ) {
            let (ups, downs) = (vec![255_u8; ups], vec![0_u8; downs]);
            let steps = |measurements: Vec<u8>| {
                let (mut grid, cell) = one_cell(Strength::MEASUREMENT);
                let sensor = SensorId::try_new(1).unwrap();
                for bits in measurements {
                    let certainty = Certainty::from_bits(bits);
                    grid.add(cell, Measurement { sensor, certainty }, &mut []);
                }
                i32::from(grid.cells[0].cast_signed())
            };
            let cut = |n: usize| (35 * n as i32 - 127).max(0);
            let bound = cut(ups.len()) + cut(downs.len());
            let one_way = steps([ups.clone(), downs.clone()].concat());
            let other_way = steps([downs, ups].concat());
            prop_assert!((one_way - other_way).abs() <= bound);
        }

        #[test]
        fn fusion_is_eq_1_to_within_the_rounding_of_its_inputs(
            measurements in prop::collection::vec(30..=226_u8, 1..4),
        ) {
            let fused = f64::from(fused(Strength::UNLIMITED, &measurements).to_bits()) / 256.0;
            // Half a step of 1/16 nat each, where the odds move fastest a quarter as much of p.
            let tolerance = 0.5 / 16.0 / 4.0 * measurements.len() as f64 + 0.5 / 256.0 + 1e-9;
            prop_assert!((fused - naive(&measurements)).abs() <= tolerance);
        }
    }
}
