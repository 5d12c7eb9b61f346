//! Output files: pictures of maps, ROS maps, and their comparison.
//!
//! [`MapImage`] is the input of everything here. [`OutDir`] puts files in place whole or not at all.
//! [`write_grey_png`] and [`write_colour_png`] draw a map, [`write_ros_map`] writes one for ROS
//! navigation, [`RosMap`] reads such maps, and [`compare`] compares two of them.

mod compare;
mod files;
mod map_image;
mod map_yaml;
mod pixels;
mod ros_map;

pub use compare::{CompareError, Comparison, compare};
pub use files::{ExportError, OutDir, display_path};
pub use map_image::{CellState, ImageError, MapImage, write_colour_png, write_grey_png};
pub use map_yaml::YamlError;
pub use pixels::PixelError;
pub use ros_map::{LoadedMap, MapError, RosMap, RosMapFiles, write_ros_map};
