//! Pictures and maps out, and maps of others in.
//!
//! [`MapImage`] is what everything exports from. [`OutDir`] puts files in place whole or not at
//! all; [`write_grey_png`] and [`write_colour_png`] draw, [`write_ros_map`] writes what robots'
//! navigation reads, [`RosMap`] reads such maps back and [`compare`] holds two against each other.

mod compare;
mod image;
mod outdir;
mod picture;
mod ros_map;
mod shown;
mod state;

pub use compare::{CompareError, Comparison, compare};
pub use image::{ImageError, MapImage};
pub use outdir::{ExportError, OutDir};
pub use picture::{write_colour_png, write_grey_png};
pub use ros_map::{MapError, RosMap, RosMapFiles, write_ros_map};
pub use state::CellState;

pub use shown::shown;
