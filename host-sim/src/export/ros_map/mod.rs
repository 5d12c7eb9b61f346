//! Maps as the navigation of ROS keeps them: an image, and a YAML file that says where it lies.
//!
//! The format is that of ROS `map_server` in its *trinary* mode; the reader also takes the modes
//! *scale* and *raw*, images in PNG, and the maps of other programs.

mod error;
mod pgm;
mod png_image;
mod write;
mod yaml;

pub use error::MapError;
pub use write::{RosMapFiles, write_ros_map};

use super::{CellState, MapImage};
use error::PixelError;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use yaml::{MapYaml, Mode};

/// The largest image file that is read, in bytes.
const LARGEST_IMAGE: u64 = 1 << 29;
/// The largest YAML file that is read, in bytes.
const LARGEST_YAML: u64 = 1 << 16;
/// The most cells that a map may have: a square of 1.6 km in cells of 10 cm.
const MOST_CELLS: u64 = 1 << 28;
/// The pixel by which trinary maps say *unknown*.
const UNKNOWN_PIXEL: u8 = 205;

/// A map in three states, read from files or taken from a [`MapImage`].
///
/// Possession proves that it has width × height cells, at least one, that its resolution is a
/// positive number, and that its origin is finite.
#[derive(Debug, Clone, PartialEq)]
pub struct RosMap {
    width: u32,
    height: u32,
    resolution_m: f64,
    origin_m: [f64; 2],
    states: Vec<CellState>,
}

impl RosMap {
    /// Loads the map that the YAML file at `path` describes.
    ///
    /// A cell's probability is that of `map_server`: (255 − pixel)/255, or pixel/255 if negated;
    /// above `occupied_thresh` it is occupied, below `free_thresh` free, else unknown.
    /// Differs from `map_server` in one point: the pixel 205 of a trinary map is unknown whatever
    /// `free_thresh` says. Writers mean *unknown* by it, and the common `free_thresh: 0.25` would
    /// make all unexplored space free.
    ///
    /// # Errors
    /// If a file cannot be read or is no such map: see [`MapError`].
    pub fn load(path: &Path) -> Result<Self, MapError> {
        let bytes = read_bounded(path, LARGEST_YAML)?;
        let yaml = MapYaml::parse(&bytes).map_err(|(line, source)| MapError::Yaml {
            path: path.into(),
            line,
            source,
        })?;
        let image = match path.parent() {
            Some(folder) => folder.join(&yaml.image),
            None => yaml.image.clone().into(),
        };
        let bytes = read_bounded(&image, LARGEST_IMAGE)?;
        Self::from_parts(&yaml, &bytes).map_err(|source| MapError::Image {
            path: image,
            source,
        })
    }

    /// Puts a map together from its description and the bytes of its image.
    fn from_parts(yaml: &MapYaml, image: &[u8]) -> Result<Self, PixelError> {
        let mut states = Vec::new();
        let mut pixel = |grey, alpha| states.push(state_of(yaml, grey, alpha));
        let (width, height) = if image.starts_with(&png_image::MAGIC) {
            png_image::decode(image, &mut pixel)?
        } else {
            pgm::decode(image, &mut pixel)?
        };
        turn_upside_down(&mut states, width as usize);
        Ok(Self {
            width,
            height,
            resolution_m: yaml.resolution_m,
            origin_m: yaml.origin_m,
            states,
        })
    }

    /// Takes the three states of a map of ours.
    #[must_use]
    pub fn from_image(map: &MapImage<'_>) -> Self {
        Self {
            width: map.width(),
            height: map.height(),
            resolution_m: f64::from(map.cell_mm()) / 1000.0,
            origin_m: [map.origin().x_mm(), map.origin().y_mm()].map(|mm| f64::from(mm) / 1000.0),
            states: map
                .cells()
                .iter()
                .map(|&cell| CellState::of(cell))
                .collect(),
        }
    }

    /// Returns the number of cells along x.
    #[must_use]
    pub const fn width(&self) -> u32 {
        self.width
    }

    /// Returns the number of cells along y.
    #[must_use]
    pub const fn height(&self) -> u32 {
        self.height
    }

    /// Returns the side of a cell in metres.
    #[must_use]
    pub const fn resolution_m(&self) -> f64 {
        self.resolution_m
    }

    /// Returns x and y of the lower left corner in metres.
    #[must_use]
    pub const fn origin_m(&self) -> [f64; 2] {
        self.origin_m
    }

    /// Returns the cells, row by row from the lowest y, each from the lowest x.
    #[must_use]
    pub fn states(&self) -> &[CellState] {
        &self.states
    }

    /// Returns the cell in column `x` of row `y`, counted from the lowest; `None` beyond the map.
    #[must_use]
    pub fn state(&self, x: i64, y: i64) -> Option<CellState> {
        let x = u32::try_from(x).ok().filter(|&x| x < self.width)?;
        let y = u32::try_from(y).ok().filter(|&y| y < self.height)?;
        let index = y as usize * self.width as usize + x as usize;
        self.states.get(index).copied()
    }
}

/// What a pixel says, and how opaque it is.
fn state_of(yaml: &MapYaml, grey: u8, alpha: u8) -> CellState {
    let probability = match yaml.mode {
        Mode::Trinary if grey == UNKNOWN_PIXEL && !yaml.negate => return CellState::Unknown,
        Mode::Scale if alpha < u8::MAX => return CellState::Unknown,
        Mode::Raw if grey > 100 => return CellState::Unknown,
        Mode::Raw => f64::from(grey) / 100.0,
        Mode::Trinary | Mode::Scale => {
            let dark = if yaml.negate { grey } else { u8::MAX - grey };
            f64::from(dark) / 255.0
        }
    };
    if probability > yaml.occupied_thresh {
        CellState::Occupied
    } else if probability < yaml.free_thresh {
        CellState::Free
    } else {
        CellState::Unknown
    }
}

/// Swaps the first row with the last and so on: images start at the top, maps at the bottom.
fn turn_upside_down(states: &mut [CellState], width: usize) {
    let rows = states.len() / width.max(1);
    for row in 0..rows / 2 {
        let (low, high) = states.split_at_mut((rows - 1 - row) * width);
        low[row * width..(row + 1) * width].swap_with_slice(&mut high[..width]);
    }
}

/// Reads a file that is no larger than `limit`.
fn read_bounded(path: &Path, limit: u64) -> Result<Vec<u8>, MapError> {
    let open = |source: io::Error| MapError::Open {
        path: path.into(),
        source,
    };
    let file = File::open(path).map_err(open)?;
    let mut bytes = Vec::new();
    file.take(limit + 1).read_to_end(&mut bytes).map_err(open)?;
    if bytes.len() as u64 > limit {
        return Err(MapError::TooLarge {
            path: path.into(),
            limit,
        });
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests;
