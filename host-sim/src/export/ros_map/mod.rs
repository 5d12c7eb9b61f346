//! Maps of ROS navigation: an image, and a YAML file with its scale and origin.
//!
//! The format is that of ROS `map_server` in its *trinary* mode; the reader also takes the modes
//! *scale* and *raw*, and images in PNG and BMP.

mod description;
mod error;
mod pixels;
mod write;

pub use error::MapError;
pub use write::{RosMapFiles, write_ros_map};

use super::map_image::{CellState, MapImage};
use description::{MapYaml, Mode};
use error::PixelError;
use pixels::Pixels;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use write::UNKNOWN_PIXEL;

/// The largest image file that is read, in bytes.
const LARGEST_IMAGE: u64 = 1 << 29;
/// The largest YAML file that is read, in bytes.
const LARGEST_YAML: u64 = 1 << 16;

/// A map in three states, read from files or taken from a [`MapImage`].
///
/// Possession proves that it has width × height cells and at least one, a positive resolution, and a
/// finite origin.
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
    /// Differs from `map_server` in one point: the pixel 205 of a trinary map is unknown for every
    /// `free_thresh`. Writers use it for *unknown*, and the common `free_thresh: 0.25` would make all
    /// unexplored space free.
    ///
    /// # Errors
    /// If a file cannot be read or is not such a map: see [`MapError`].
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
        let Pixels {
            width,
            height,
            pixels,
        } = Pixels::decode(image)?;
        let states = pixels
            .iter()
            .map(|&(grey, alpha)| state_of(yaml, grey, alpha));
        let mut states: Vec<CellState> = states.collect();
        turn_upside_down(&mut states, width as usize);
        Ok(Self {
            width,
            height,
            resolution_m: yaml.resolution_m,
            origin_m: yaml.origin_m,
            states,
        })
    }

    /// Converts a [`MapImage`] to three states.
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

/// The state of a pixel with its alpha.
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

/// Reads a file of at most `limit` bytes.
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
mod tests {
    use super::*;
    use crate::export::files::OutDir;
    use crate::export::picture::write_grey_png;
    use certainty_core::certainty::Certainty;
    use certainty_core::units::Point;
    use core::num::NonZeroU32;
    use proptest::prelude::*;
    use std::fs;

    const FREE: CellState = CellState::Free;
    const UNKNOWN: CellState = CellState::Unknown;
    const OCCUPIED: CellState = CellState::Occupied;

    fn yaml(more: &str) -> MapYaml {
        let text = format!("image: m.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n{more}");
        MapYaml::parse(text.as_bytes()).unwrap()
    }

    /// The states that pixels have in a map one row high.
    fn states(more: &str, pixels: &[u8]) -> Vec<CellState> {
        let mut image = format!("P5\n{} 1\n255\n", pixels.len()).into_bytes();
        image.extend_from_slice(pixels);
        RosMap::from_parts(&yaml(more), &image).unwrap().states
    }

    #[test]
    fn files_are_as_ros_expects() {
        let cells = [0, 50, 51, 128, 166, 167].map(Certainty::from_bits);
        let map = MapImage::try_new(3, 2, &cells, 50, Point::from_mm(-12_300, 4)).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let files = write_ros_map(&OutDir::create(folder.path()).unwrap(), "hall", &map).unwrap();
        assert_eq!(
            fs::read(&files.pgm).unwrap(),
            b"P5\n3 2\n255\n\xCD\xCD\x00\xFE\xFE\xCD"
        );
        assert_eq!(
            fs::read_to_string(&files.yaml).unwrap(),
            "image: hall.pgm\nresolution: 0.05\norigin: [-12.3, 0.004, 0.0]\nnegate: 0\n\
             occupied_thresh: 0.65\nfree_thresh: 0.196\n"
        );
        let map = RosMap::load(&files.yaml).unwrap();
        assert_eq!(
            map.states(),
            [FREE, FREE, UNKNOWN, UNKNOWN, UNKNOWN, OCCUPIED]
        );
        assert_eq!(
            (map.width(), map.height(), map.resolution_m()),
            (3, 2, 0.05)
        );
        assert_eq!(map.origin_m(), [-12.3, 0.004]);
        assert_eq!(
            (map.state(2, 1), map.state(0, 0)),
            (Some(OCCUPIED), Some(FREE))
        );
        for (x, y) in [(-1, 0), (3, 0), (0, 2), (0, -1), (i64::MAX, i64::MIN)] {
            assert_eq!(map.state(x, y), None);
        }
    }

    #[test]
    fn rows_keep_their_order() {
        for height in 1..=7_u8 {
            // As many occupied cells in a row as its number, counted from the lowest.
            let cell = |y, x| if x < y { 255 } else { 0 };
            let cells = (0..height).flat_map(|y| (0..8).map(move |x| cell(y, x)));
            let cells: Vec<Certainty> = cells.map(Certainty::from_bits).collect();
            let map = MapImage::try_new(8, height.into(), &cells, 100, Point::ORIGIN).unwrap();
            let folder = tempfile::tempdir().unwrap();
            let files = write_ros_map(&OutDir::create(folder.path()).unwrap(), "m", &map).unwrap();
            let back = RosMap::load(&files.yaml).unwrap();
            assert_eq!(back, RosMap::from_image(&map), "{height} rows");
        }
    }

    #[test]
    fn any_file_name_reads_back() {
        let cells = [Certainty::OCCUPIED];
        let map = MapImage::try_new(1, 1, &cells, 100, Point::ORIGIN).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let out = OutDir::create(folder.path()).unwrap();
        for name in [
            "plain-1_2",
            "it's: #1",
            "a b",
            "[x]",
            "\"q\" \\",
            "tab\there",
            "früh",
            "-",
        ] {
            let files = write_ros_map(&out, name, &map).unwrap();
            assert_eq!(
                RosMap::load(&files.yaml).unwrap(),
                RosMap::from_image(&map),
                "{name}"
            );
        }
        assert!(write_ros_map(&out, "../up", &map).is_err());
    }

    #[test]
    fn png_image_is_read() {
        let cells = [255, 10, 128, 0].map(Certainty::from_bits);
        let map = MapImage::try_new(2, 2, &cells, 100, Point::ORIGIN).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let out = OutDir::create(folder.path()).unwrap();
        out.write("m.png", |file| write_grey_png(&map, NonZeroU32::MIN, file))
            .unwrap();
        let text = b"image: m.png\nresolution: 0.1\norigin: [0, 0, 0]\n";
        let path = out.write_bytes("m.yaml", text).unwrap();
        assert_eq!(RosMap::load(&path).unwrap(), RosMap::from_image(&map));
    }

    #[test]
    fn unknown_stays_unknown_at_any_free_thresh() {
        let pixels = [254, 206, 205, 204, 0];
        let expected = [FREE, UNKNOWN, UNKNOWN, UNKNOWN, OCCUPIED];
        assert_eq!(states("free_thresh: 0.19", &pixels), expected);
        let expected = [FREE, FREE, UNKNOWN, FREE, OCCUPIED];
        assert_eq!(states("free_thresh: 0.25", &pixels), expected);
    }

    #[test]
    fn modes_and_negation_are_those_of_map_server() {
        assert_eq!(
            states("negate: 1", &[0, 50, 255]),
            [FREE, UNKNOWN, OCCUPIED]
        );
        let raw = [0, 19, 20, 65, 66, 100, 101, 255];
        let expected = [
            FREE, FREE, UNKNOWN, UNKNOWN, OCCUPIED, OCCUPIED, UNKNOWN, UNKNOWN,
        ];
        assert_eq!(states("mode: raw", &raw), expected);
        let scale = yaml("mode: scale");
        assert_eq!(state_of(&scale, 255, 255), FREE);
        assert_eq!(state_of(&scale, 255, 254), UNKNOWN);
    }

    #[test]
    fn errors_name_the_wrong_file() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let message = |name: &str| {
            let message = RosMap::load(&at(name)).unwrap_err().to_string();
            assert_eq!(message.lines().count(), 1, "{message}");
            message
        };
        let starts = |message: &str, name: &str, rest: &str| {
            let expected = format!("{}{rest}", at(name).display());
            assert!(message.starts_with(&expected), "{message}");
        };
        starts(&message("none.yaml"), "none.yaml", ": cannot be read (");
        starts(&message("."), ".", ": cannot be read (");
        let text = "image: gone.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n";
        fs::write(at("a.yaml"), text).unwrap();
        starts(&message("a.yaml"), "gone.pgm", ": cannot be read (");
        fs::write(at("gone.pgm"), "P5 9 9 255\n123").unwrap();
        starts(&message("a.yaml"), "gone.pgm", ": announces 9 x 9 pixels");
        starts(
            &message("gone.pgm"),
            "gone.pgm",
            ":1: is not a map description",
        );
        fs::write(at("b.yaml"), "image: [\u{1b}\n\n").unwrap();
        starts(&message("b.yaml"), "b.yaml", ":");
        fs::write(at("c.yaml"), vec![b'#'; 70_000]).unwrap();
        starts(&message("c.yaml"), "c.yaml", ": is larger than 65536 bytes");
    }

    proptest! {
        #[test]
        fn no_description_panics(bytes: Vec<u8>, text in "[-?:,\\[\\]{}#&*!|>'\"%@` a0\n\t]{0,60}") {
            let _ = MapYaml::parse(&bytes);
            let _ = MapYaml::parse(text.as_bytes());
            let _ = MapYaml::parse(format!("image: m\nresolution: 1\norigin: {text}\n").as_bytes());
        }

        #[test]
        fn no_image_panics(
            kind in 0_usize..5,
            header in "[ #0-9\n]{0,20}",
            bytes: Vec<u8>,
            place: usize,
            byte: u8,
        ) {
            let image = match kind {
                0 => bytes,
                1 => [b"P5", header.as_bytes(), &bytes].concat(),
                2 => [b"P2", header.as_bytes(), &bytes].concat(),
                3 => [&b"\x89PNG\r\n\x1a\n"[..], &bytes].concat(),
                _ => {
                    let cells = [0, 99, 200, 255, 128, 1].map(Certainty::from_bits);
                    let map = MapImage::try_new(3, 2, &cells, 100, Point::ORIGIN).unwrap();
                    let mut file = Vec::new();
                    write_grey_png(&map, NonZeroU32::MIN, &mut file).unwrap();
                    let place = place % file.len();
                    file[place] = byte;
                    file
                }
            };
            if let Ok(map) = RosMap::from_parts(&yaml(""), &image) {
                let count = u64::from(map.width) * u64::from(map.height);
                prop_assert_eq!(map.states.len() as u64, count);
            }
        }
    }
}
