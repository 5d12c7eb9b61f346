//! A simulated robot like the IBIS of \[004\] that drives to a goal among obstacles while its sensors fail.
//!
//! | module | is |
//! |---|---|
//! | [`body`] | six wheels, skid-steered: lag, slip, collisions |
//! | [`course`] | the obstacles, the start and the goal: built in, random, or from a world file |
//! | [`drive`] | one run, step by step, and its quality |
//! | [`pilot`] | settings of the control level: source of the failures, memory, source of the histogram |
//! | [`sensors`] | six rangefinders and a scanner: mountings, noise, faults |
//!
//! The control level itself, with the diagnosis of the sensors and the map, is
//! [`certainty_control::Pilot`]. The robot's pose is exact: \[004\] has a receiver and a compass for it, and
//! their errors are not simulated.

pub mod body;
pub mod course;
pub mod drive;
pub mod pilot;
pub mod sensors;

pub use body::Body;
pub use course::Course;
pub use drive::{Drive, Outcome, Quality};
pub use pilot::{HealthMode, MapSource, Memory, PilotConfig};
