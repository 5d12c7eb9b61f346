//! A robot like the IBIS of \[004\] that drives to a goal among obstacles while its sensors fail.
//!
//! | module | is |
//! |---|---|
//! | [`body`] | six wheels, skid-steered: lag, slip, what it bumps into |
//! | [`sensors`] | six rangefinders and a scanner, where they sit and what befalls them |
//! | [`modes`] | who tells the robot what has failed, what it sees obstacles in, who remembers |
//! | [`plausibility_filter`] | what a sensor's own readings say about it |
//! | [`diagnosis`] | what it finds out about its sensors: by themselves, by each other, by its map |
//! | [`drawn_map`] | the map that it draws, and what it remembers by it |
//! | [`pilot`] | the control level fed by all of them |
//! | [`course`] | where it drives: the built-in course, random ones, a world file |
//! | [`drive`] | one run, step by step |
//! | [`quality`] | \[004\] eq. 17 to 19 |
//!
//! The robot knows where it is: \[004\] has a receiver and a compass for that, and their errors are no
//! subject here.

pub mod body;
pub mod course;
pub mod diagnosis;
pub mod drawn_map;
pub mod drive;
pub mod modes;
pub mod pilot;
pub mod plausibility_filter;
pub mod quality;
pub mod sensors;

pub use body::Body;
pub use course::Course;
pub use drive::{Drive, Outcome};
pub use modes::{HealthMode, MapSource, Memory};
pub use pilot::PilotConfig;
pub use quality::Quality;
