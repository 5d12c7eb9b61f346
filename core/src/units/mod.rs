//! Lengths, angles, instants and positions, each a type of its own.
//!
//! The public functions take no bare integers for these, so that a bearing cannot be passed for a
//! distance. All are integers: the results are the same bits on every machine. Their operators do
//! not panic: lengths and positions saturate, angles and instants wrap.

mod angle;
mod length;
mod place;
mod ticks;

pub use angle::{BinaryAngle, Direction, fine_sine_q30};
pub use length::Millimeters;
pub use place::{Point, Pose};
pub use ticks::Ticks;
