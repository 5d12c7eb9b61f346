//! The classic certainty grid: eq. 1 of [001], one byte a cell.

use super::grid::{CertaintyGrid, Measurement, WrongStorage, zeroed};
use super::{Cell, Geometry, LogOdds, Shape};
use crate::certainty::Certainty;
use crate::health::Health;

/// A grid that fuses by Bayes' rule ([001] §3, eq. 1).
///
/// Cells keep log-odds, so a measurement is one saturating addition. Every measurement counts alike,
/// whoever made it: a sensor that is always wrong is believed as often as it speaks. Prefer it where
/// sensors are sound; it is the smallest and the fastest.
///
/// Order: no influence, as long as no cell reaches the bound of [`LogOdds`] on the way.
///
/// Memory: one byte a cell. Cost: one table look-up and one addition a cell.
#[derive(Debug, Clone)]
pub struct BayesGrid<Sh, S> {
    shape: Sh,
    strongest: LogOdds,
    cells: S,
}

/// The surest that one measurement may be: 0.9 or 0.1, the odds of 35/16 nat.
///
/// Table 1 of [001] has sensors that err in 4 to 18 % of their readings; nine to one is about what a
/// single reading of theirs is worth.
pub const STRONGEST_MEASUREMENT: LogOdds = LogOdds::from_steps(35);

impl<Sh: Shape, S: AsRef<[u8]> + AsMut<[u8]>> BayesGrid<Sh, S> {
    /// Creates a grid in which every cell is uncertain.
    ///
    /// `strongest` is the surest that one measurement may be, [`STRONGEST_MEASUREMENT`] for instance:
    /// a measurement of *free* or *occupied* has infinite odds, which eq. 1 could never take back.
    ///
    /// # Errors
    ///
    /// [`WrongStorage`] unless `storage` has a byte for each cell.
    ///
    /// # Examples
    ///
    /// ```
    /// use certainty_core::certainty::Certainty;
    /// use certainty_core::fusion::{BayesGrid, CertaintyGrid, Geometry, Measurement};
    /// use certainty_core::fusion::STRONGEST_MEASUREMENT;
    /// use certainty_core::sensor::SensorId;
    /// use certainty_core::units::{Millimeters, Point};
    ///
    /// let shape = Geometry::try_new(17, 11, Millimeters::new(100), Point::ORIGIN)?;
    /// let mut grid = BayesGrid::try_new(shape, STRONGEST_MEASUREMENT, [0; 187])?;
    /// let cell = shape.cell(3, 4).ok_or("outside")?;
    /// let sensor = SensorId::new(1).ok_or("zero")?;
    /// for _ in 0..2 {
    ///     grid.add(cell, Measurement { sensor, certainty: Certainty::OCCUPIED }, &mut []);
    /// }
    /// assert_eq!(grid.certainty(cell).to_bits(), 253); // 81 to 1
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    pub fn try_new(shape: Sh, strongest: LogOdds, storage: S) -> Result<Self, WrongStorage<S>> {
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
    fn add(&mut self, cell: Cell, measurement: Measurement, _sensors: &mut [Health]) {
        let opinion = LogOdds::of(measurement.certainty).at_most(self.strongest);
        if let Some(stored) = self.cells.as_mut().get_mut(cell.index()) {
            let before = LogOdds::from_steps(stored.cast_signed());
            *stored = before.saturating_add(opinion).steps().cast_unsigned();
        }
    }

    fn certainty(&self, cell: Cell) -> Certainty {
        let stored = self.cells.as_ref().get(cell.index()).copied();
        LogOdds::from_steps(stored.unwrap_or(0).cast_signed()).certainty()
    }

    fn memory_bytes(&self) -> usize {
        self.cells.as_ref().len()
    }
}
