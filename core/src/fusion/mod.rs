//! The fusion level: readings become cells, cells become one map.
//!
//! ```text
//! Beam ──interpret──► (Cell, Certainty) ──CertaintyGrid::add──► grid ──► Environment
//!  origin, bearing,        free, occupied,       bayes | robust             map + health
//!  Reading, BeamModel      uncertain behind      trimmed | median
//! ```
//!
//! [`Mapper`] runs that flow. Its parts can be used alone: [`Ray`] lists the cells that a line crosses,
//! [`Beam::interpret`] turns a reading into certainties of cells, and every grid is a [`Shape`] plus
//! storage that implements [`CertaintyGrid`].
//!
//! Each grid has two forms:
//!
//! | | shape | storage | made by |
//! |---|---|---|---|
//! | on a host | a [`Geometry`] | any bytes, such as a `Vec<u8>` | `try_new` |
//! | on a microcontroller | [`Area`] or another [`FixedShape`] | arrays of fixed size | `const fn new` |
//!
//! The aliases [`BayesArray`], [`RobustArray`], [`TrimmedArray`] and [`MedianArray`] name the second form.
//! Such a grid is a `static` of zeros, which takes no flash:
//!
//! ```
//! use certainty_core::fusion::{Area, CertaintyGrid, MedianArray, RobustArray, owner_bytes};
//! use std::sync::Mutex; // on a microcontroller: a critical section's, or static_cell
//!
//! // 17 × 11 cells of 100 mm, the lower left corner at (-850, 0) mm; three sensors.
//! type Yard = Area<17, 11, 100, -850, 0>;
//! static MEDIAN: Mutex<MedianArray<Yard, 3>> = Mutex::new(MedianArray::new(Area));
//!
//! const OWNERS: usize = owner_bytes(Yard::CELLS, 3);
//! static ROBUST: Mutex<RobustArray<Yard, 3, OWNERS>> = Mutex::new(RobustArray::new(Area));
//!
//! assert_eq!(MEDIAN.lock()?.memory_bytes(), 561);
//! assert_eq!(ROBUST.lock()?.memory_bytes(), 234);
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```

mod bayes;
mod beam;
mod cone;
mod geometry;
mod grid;
mod layers;
mod mapper;
mod owners;
#[cfg(test)]
mod picture;
mod ray;
mod robust;
mod shape;

pub use bayes::{BayesArray, BayesGrid, DefaultStrength, LogOdds, Strength, StrengthError};
pub use beam::{Beam, BeamConfig, BeamError, BeamModel, Behind, CellSink};
pub use geometry::{Cell, Geometry, GeometryError};
pub use grid::{CertaintyGrid, GridError, GridErrorKind, Measurement};
pub use layers::{
    Accumulated, Latest, MedianArray, MedianGrid, Middle, OwnGrid, TrimmedArray, TrimmedGrid,
};
pub use mapper::{Environment, Mapper, UnknownSensor};
pub use owners::{owner_bits, owner_bytes};
pub use ray::Ray;
pub use robust::{
    DefaultRules, RobustArray, RobustConfig, RobustConfigError, RobustGrid, RobustRules,
    RobustSetup,
};
pub use shape::{Area, ByteArray, CellArray, FixedShape, Shape};
