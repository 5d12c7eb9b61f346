//! What every certainty grid can do, whatever its fusion.

use super::{Cell, Geometry};
use crate::certainty::Certainty;
use crate::health::Health;
use crate::sensor::SensorId;
use core::fmt;

/// What one sensor says about one cell: `sensor.measurement` of \[001\] Fig. 3.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Measurement {
    /// Who says so.
    pub sensor: SensorId,
    /// What the cell is, going by this sensor alone.
    pub certainty: Certainty,
}

/// A certainty grid: a shape, storage, and a way to fuse what sensors say.
///
/// The four ways differ in what they need to survive a faulty sensor:
///
/// | grid | survives | needs a cell | depends on order |
/// |---|---|---|---|
/// | [`BayesGrid`](super::BayesGrid) | single wrong readings | 1 byte | once a cell saturates |
/// | [`RobustGrid`](super::RobustGrid) | a wrong sensor, attenuated; learns which | 1 byte and an owner | yes |
/// | [`TrimmedGrid`](super::TrimmedGrid) | t wrong sensors, where 2t + 1 see the cell | 1 byte a sensor | not between sensors |
/// | [`MedianGrid`](super::MedianGrid) | any minority of wrong sensors | 1 byte a sensor | not between sensors |
pub trait CertaintyGrid {
    /// Returns where the grid lies and how it is divided.
    fn geometry(&self) -> Geometry;

    /// Adds what one sensor says about one cell.
    ///
    /// `sensors` holds every sensor's health in the order of their numbers; a grid that compares
    /// sensors ([`RobustGrid`](super::RobustGrid)) reads confidences there and writes what it found, and
    /// does not add a sensor that is not listed. The others do not look at it. No grid adds a sensor
    /// that it has no room for.
    fn add(&mut self, cell: Cell, measurement: Measurement, sensors: &mut [Health]);

    /// Adds the same word of one sensor about each of `cells`, in their order, to the last.
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

    /// Returns the belief that `cell` is occupied; fused on demand where the grid keeps each
    /// sensor's word apart.
    fn certainty(&self, cell: Cell) -> Certainty;

    /// Returns the bytes of storage that the cells and their owners take (\[001\] §7).
    fn memory_bytes(&self) -> usize;
}

/// Why a grid could not be made.
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
        /// The most that it has room for.
        most: usize,
    },
    /// Trimming would leave nothing even of the words of all sensors.
    Trim,
}

impl fmt::Display for GridErrorKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Storage { needed } => {
                write!(f, "the grid needs exactly {needed} bytes of storage")
            }
            Self::Sensors { most } => write!(f, "the grid needs 1 to {most} sensors"),
            Self::Trim => f.write_str("trimming t words each way needs 2t + 1 sensors"),
        }
    }
}

/// A grid could not be made; hands the storage back.
#[derive(Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GridError<S> {
    /// Why.
    pub why: GridErrorKind,
    /// The storage that was handed in.
    pub storage: S,
}

impl<S> fmt::Debug for GridError<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("GridError")
            .field("why", &self.why)
            .finish_non_exhaustive()
    }
}

impl<S> fmt::Display for GridError<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.why.fmt(f)
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
            why: GridErrorKind::Storage { needed },
            storage,
        })
    }
}
