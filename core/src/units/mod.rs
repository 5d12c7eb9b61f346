//! Lengths, angles, instants and places, each a type of its own.
//!
//! Nothing in the public interface takes a bare integer for one of these, so a bearing cannot be
//! passed for a distance. All are integers: the same bits come out on every machine.

mod angle;
mod length;
mod place;
mod ticks;

pub use angle::{BinaryAngle, Direction, fine_sine_q30};
pub use length::Millimeters;
pub use place::{Point, Pose};
pub use ticks::Ticks;
