//! The world of simulated sensors: obstacles on a plane.
//!
//! Distances are exact: each ray is intersected with each obstacle's outline in closed form, not
//! marched over a raster. Directions come from the core's integer sines, and the rest is additions,
//! products and square roots, so the same bits come out on every machine.
//!
//! Obstacles lie at their coordinates to the millimetre: a box from x = 200 to 400 covers
//! the square millimetres 200 to 399. Rays start, and [`World::occupied`] tests, at the *centre* of
//! a [`Point`](certainty_core::units::Point)'s square millimetre, which is never on the edge of an upright box.
//!
//! Cost: one intersection an obstacle and a ray; no allocation.

mod file;
mod obstacle;
mod random;
mod scene;

pub use file::{OFFICE, SMART_CAR};
pub use obstacle::{Bounds, Obstacle, ObstacleError, Shape};
pub use random::{Layout, LayoutError};
pub use scene::World;
