//! The fusion level: readings become cells, cells become one map.
//!
//! ```text
//! Beam ──interpret──► (Cell, Certainty) ──CertaintyGrid::add──► grid ──► Environment
//!  origin, bearing,        free, occupied,       bayes | robust             map + health
//!  Reading, BeamModel      uncertain behind      trimmed | median
//! ```
//!
//! [`Mapper`] runs that flow. The parts stand alone too: [`Ray`] walks cells, [`Beam::interpret`] says
//! what a reading means, and every grid is a [`Shape`] plus storage that implements
//! [`CertaintyGrid`].

mod add_to_grid;
mod bayes;
mod beam;
mod cone;
mod environment;
#[cfg(test)]
mod fault_hypothesis;
mod geometry;
mod grid;
mod layers;
mod log_odds;
mod mapper;
mod median;
mod owners;
#[cfg(test)]
mod picture;
mod ray;
mod robust;
mod strength;
mod trimmed;

pub use add_to_grid::{RobustConfig, RobustConfigError, RobustRules};
pub use bayes::BayesGrid;
pub use beam::{Beam, BeamConfig, BeamError, BeamModel, Behind, Listener};
pub use environment::Environment;
pub use geometry::{Cell, Geometry, GeometryError, Shape};
pub use grid::{CertaintyGrid, GridError, GridErrorKind, Measurement};
pub use layers::{Accumulated, Latest, OwnGrid};
pub use log_odds::LogOdds;
pub use mapper::{Mapper, UnknownSensor};
pub use median::{MedianGrid, Middle};
pub use owners::{owner_bits, owner_bytes};
pub use ray::Ray;
pub use robust::RobustGrid;
pub use strength::Strength;
pub use trimmed::TrimmedGrid;
