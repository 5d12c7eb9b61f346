//! The interface of every certainty grid.

use super::geometry::{Cell, Geometry};
use crate::certainty::Certainty;
use crate::health::{Confidence, Health};
use crate::sensor::SensorId;
use core::fmt;

/// The certainty that one sensor's reading gives a cell: `sensor.measurement` of \[001\] Fig. 3.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Measurement {
    /// The sensor.
    pub sensor: SensorId,
    /// The certainty that the cell is occupied, by this sensor alone.
    pub certainty: Certainty,
}

/// A certainty grid: a shape, storage, and a way to fuse the measurements of several sensors.
///
/// The four ways differ in which faults they survive and in what that costs:
///
/// | grid | survives | needs a cell | depends on order |
/// |---|---|---|---|
/// | [`BayesGrid`](super::BayesGrid) | single wrong readings | 1 byte | once a cell saturates |
/// | [`RobustGrid`](super::RobustGrid) | a faulty sensor, attenuated; learns which one | 1 byte and an owner | yes |
/// | [`TrimmedGrid`](super::TrimmedGrid) | t faulty sensors, where 2t + 1 see the cell | 1 byte a sensor | not between sensors |
/// | [`MedianGrid`](super::MedianGrid) | any minority of faulty sensors | 1 byte a sensor | not between sensors |
///
/// `&mut G` is a grid too: a grid that is a `static` can be borrowed by a [`Mapper`](super::Mapper).
pub trait CertaintyGrid {
    /// Returns where the grid lies and how it is divided.
    fn geometry(&self) -> Geometry;

    /// Returns the number of sensors that the grid has room for: sensors 1 to this number.
    ///
    /// The default is for a grid that keeps nothing apart by sensor: all that there can be.
    fn sensors(&self) -> u8 {
        u8::MAX
    }

    /// Returns the record that each sensor of this grid starts with; full confidence by default.
    fn first_health(&self) -> Health {
        Health::new(Confidence::FULL)
    }

    /// Adds one sensor's measurement of one cell.
    ///
    /// `sensors` holds every sensor's health in the order of their numbers. A grid that compares sensors
    /// ([`RobustGrid`](super::RobustGrid)) reads confidences there and writes what the comparison
    /// taught; it does not add a sensor without a record. The others ignore it. No grid adds a sensor
    /// that it has no room for.
    fn add(&mut self, cell: Cell, measurement: Measurement, sensors: &mut [Health]);

    /// Adds the same measurement to each of `cells`, in their order.
    ///
    /// Implementations must exhaust `cells`.
    #[inline]
    fn add_all(
        &mut self,
        cells: impl Iterator<Item = Cell>,
        measurement: Measurement,
        sensors: &mut [Health],
    ) where
        Self: Sized,
    {
        cells.for_each(|cell| self.add(cell, measurement, sensors));
    }

    /// Makes every cell *uncertain* and unowned, as in a new grid.
    fn clear(&mut self);

    /// Returns the certainty that `cell` is occupied; fused on demand where the grid keeps the sensors'
    /// measurements apart.
    fn certainty(&self, cell: Cell) -> Certainty;

    /// Returns the bytes of storage that the cells and their owners take (\[001\] §7).
    fn memory_bytes(&self) -> usize;
}

impl<G: CertaintyGrid> CertaintyGrid for &mut G {
    fn geometry(&self) -> Geometry {
        (**self).geometry()
    }

    fn sensors(&self) -> u8 {
        (**self).sensors()
    }

    fn first_health(&self) -> Health {
        (**self).first_health()
    }

    #[inline]
    fn add(&mut self, cell: Cell, measurement: Measurement, sensors: &mut [Health]) {
        (**self).add(cell, measurement, sensors);
    }

    #[inline]
    fn add_all(
        &mut self,
        cells: impl Iterator<Item = Cell>,
        measurement: Measurement,
        sensors: &mut [Health],
    ) {
        (**self).add_all(cells, measurement, sensors);
    }

    fn clear(&mut self) {
        (**self).clear();
    }

    fn certainty(&self, cell: Cell) -> Certainty {
        (**self).certainty(cell)
    }

    fn memory_bytes(&self) -> usize {
        (**self).memory_bytes()
    }
}

/// Why a grid cannot be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum GridErrorKind {
    /// The storage has not exactly the bytes that the shape takes.
    Storage {
        /// The bytes that it takes.
        needed: usize,
    },
    /// There is no sensor, or more of them than the type has room for.
    Sensors {
        /// The number that it has room for.
        most: usize,
    },
    /// Trimming would leave nothing even of the measurements of all sensors.
    Trim,
}

impl fmt::Display for GridErrorKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Storage { needed } => {
                write!(
                    f,
                    "storage of the wrong size: expected exactly {needed} bytes"
                )
            }
            Self::Sensors { most } => {
                write!(f, "wrong number of sensors: expected 1 to {most}")
            }
            Self::Trim => f.write_str("too few sensors: trimming t at each end needs 2t + 1"),
        }
    }
}

/// A grid could not be made; hands the storage back.
#[derive(Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GridError<S> {
    /// What was wrong.
    pub kind: GridErrorKind,
    /// The storage that was handed in.
    pub storage: S,
}

impl<S> fmt::Debug for GridError<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("GridError")
            .field("kind", &self.kind)
            .finish_non_exhaustive()
    }
}

impl<S> fmt::Display for GridError<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.kind.fmt(f)
    }
}

impl<S> core::error::Error for GridError<S> {}

/// Returns `storage` filled with zeros, if it has exactly `needed` bytes.
pub(super) fn zeroed<S: AsMut<[u8]>>(mut storage: S, needed: usize) -> Result<S, GridError<S>> {
    if storage.as_mut().len() == needed {
        storage.as_mut().fill(0);
        Ok(storage)
    } else {
        Err(GridError {
            kind: GridErrorKind::Storage { needed },
            storage,
        })
    }
}
