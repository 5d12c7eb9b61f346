//! Maps of ROS navigation: an image, and a YAML file with its scale and origin.
//!
//! The format is that of ROS `map_server` in its *trinary* mode; the reader also takes the modes
//! *scale* and *raw*, and images in PGM, PPM, PBM, PNG, BMP, JPEG and GIF.

use super::files::{ExportError, OutDir, display_path};
use super::map_image::{CellState, MapImage};
use super::map_yaml::{MapYaml, Mode, YamlError};
use super::pixels::{PixelError, Pixels, UNKNOWN_PIXEL, is_image};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

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
    yaw_rad: f64,
    states: Vec<CellState>,
}

/// A map as it was read, with what was assumed, skipped or read otherwise than usual.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadedMap {
    /// The map.
    pub map: RosMap,
    /// What a user should know about the reading, a line each that begins with the file.
    pub notes: Vec<String>,
}

impl RosMap {
    /// Loads the map that the YAML file at `path` describes; its image is relative to that file.
    ///
    /// A cell's probability is that of navigation2's `map_server`: 1 − pixel/255, or pixel/255 if
    /// negated; up to `free_thresh` it is free, else from `occupied_thresh` on occupied, else unknown.
    /// Pixels that are not opaque are unknown, unless the mode is *raw*.
    /// Differs from `map_server` in two points. The pixel 205 of a trinary map is unknown for every
    /// `free_thresh`: writers use it for *unknown*, and the common `free_thresh: 0.25` would make all
    /// unexplored space free. In the mode *raw* the thresholds apply to the percentage.
    ///
    /// # Errors
    /// If a file cannot be read or is not such a map: see [`MapError`].
    pub fn load(path: &Path) -> Result<LoadedMap, MapError> {
        let file = File::open(path).map_err(|source| open_error(path, source))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::read(file, path, folder)
    }

    /// Reads a map's YAML from `yaml`, such as stdin, and then its image, which is relative to `folder`;
    /// errors and notes name the YAML `name`.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn read(yaml: impl Read, name: &Path, folder: &Path) -> Result<LoadedMap, MapError> {
        let mut bytes = Vec::new();
        let mut yaml = yaml.take(LARGEST_YAML + 1);
        yaml.read_to_end(&mut bytes)
            .map_err(|source| open_error(name, source))?;
        if is_image(&bytes) {
            return Err(MapError::IsImage { path: name.into() });
        }
        check_size(name, &bytes, LARGEST_YAML)?;
        let yaml = parse(&bytes, name)?;
        let image = folder.join(&yaml.image);
        let file = File::open(&image).map_err(|source| open_error(&image, source))?;
        let mut bytes = Vec::new();
        let mut file = file.take(LARGEST_IMAGE + 1);
        file.read_to_end(&mut bytes)
            .map_err(|source| open_error(&image, source))?;
        check_size(&image, &bytes, LARGEST_IMAGE)?;
        Self::from_parts(&yaml, name, &bytes, &image)
    }

    /// Creates a map from the bytes of its YAML and of its image.
    ///
    /// # Errors
    /// As [`Self::load`].
    ///
    /// # Examples
    /// ```
    /// use certainty_sim::export::{CellState, RosMap};
    ///
    /// let yaml = b"image: m.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: no\n";
    /// let loaded = RosMap::from_bytes(yaml, b"P2 2 1 255 0 254")?;
    /// assert_eq!(loaded.map.states(), [CellState::Occupied, CellState::Free]);
    /// assert!(loaded.notes[0].contains("`occupied_thresh: 0.65`"));
    /// # Ok::<(), certainty_sim::export::MapError>(())
    /// ```
    pub fn from_bytes(yaml: &[u8], image: &[u8]) -> Result<LoadedMap, MapError> {
        let name = Path::new("map.yaml");
        let yaml = parse(yaml, name)?;
        let image_name = Path::new(&yaml.image);
        Self::from_parts(&yaml, name, image, image_name)
    }

    /// Puts a map together from its description and the bytes of its image, with their names.
    fn from_parts(
        yaml: &MapYaml,
        name: &Path,
        image: &[u8],
        image_name: &Path,
    ) -> Result<LoadedMap, MapError> {
        let found = Pixels::decode(image).map_err(|source| MapError::Image {
            path: image_name.into(),
            source,
        })?;
        let Pixels { width, height, .. } = found;
        let mut kept_unknown = 0_u64;
        let states = found.pixels.iter().map(|&(grey, alpha)| {
            let by_thresholds = state_of(yaml, grey, alpha);
            let marked = yaml.mode == Mode::Trinary && !yaml.negate && grey == found.unknown_grey;
            if marked && by_thresholds.is_known() {
                kept_unknown += 1;
                return CellState::Unknown;
            }
            by_thresholds
        });
        let mut states: Vec<CellState> = states.collect();
        turn_upside_down(&mut states, width as usize);
        let (name, image_name) = (display_path(name), display_path(image_name));
        let mut notes: Vec<String> = yaml
            .notes
            .iter()
            .map(|note| format!("{name}: {note}"))
            .collect();
        if kept_unknown > 0 {
            notes.push(format!(
                "{name}: {kept_unknown} pixels of {UNKNOWN_PIXEL}, which is written for unknown, stay \
                 unknown, unlike in map_server"
            ));
        }
        notes.extend(
            found
                .notes
                .iter()
                .map(|note| format!("{image_name}: {note}")),
        );
        let map = Self {
            width,
            height,
            resolution_m: yaml.resolution_m,
            origin_m: yaml.origin_m,
            yaw_rad: yaml.yaw_rad,
            states,
        };
        Ok(LoadedMap { map, notes })
    }

    /// Converts a [`MapImage`] to three states.
    #[must_use]
    pub fn from_image(map: &MapImage<'_>) -> Self {
        Self {
            width: map.width(),
            height: map.height(),
            resolution_m: f64::from(map.cell_mm()) / 1000.0,
            origin_m: [map.origin().x_mm(), map.origin().y_mm()].map(|mm| f64::from(mm) / 1000.0),
            yaw_rad: 0.0,
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

    /// Returns the angle by which the map is turned about its lower left corner, counter-clockwise, above
    /// −π and up to π.
    #[must_use]
    pub const fn yaw_rad(&self) -> f64 {
        self.yaw_rad
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

/// The state of a pixel with its alpha, by the thresholds alone.
///
/// In single precision, as navigation2 computes it: of two thresholds that a pixel meets exactly the
/// same one decides.
fn state_of(yaml: &MapYaml, grey: u8, alpha: u8) -> CellState {
    let part = f32::from(grey) / 255.0;
    let probability = match yaml.mode {
        Mode::Trinary | Mode::Scale if alpha < u8::MAX => return CellState::Unknown,
        Mode::Trinary | Mode::Scale if yaml.negate => part,
        Mode::Trinary | Mode::Scale => 1.0 - part,
        Mode::Raw if grey > 100 => return CellState::Unknown,
        Mode::Raw => f32::from(grey) / 100.0,
    };
    if probability <= yaml.free_thresh as f32 {
        CellState::Free
    } else if probability >= yaml.occupied_thresh as f32 {
        CellState::Occupied
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

fn parse(bytes: &[u8], name: &Path) -> Result<MapYaml, MapError> {
    MapYaml::parse(bytes).map_err(|(line, source)| MapError::Yaml {
        path: name.into(),
        line,
        source,
    })
}

fn open_error(path: &Path, source: io::Error) -> MapError {
    MapError::Open {
        path: path.into(),
        source,
    }
}

fn check_size(path: &Path, bytes: &[u8], limit: u64) -> Result<(), MapError> {
    if bytes.len() as u64 > limit {
        return Err(MapError::TooLarge {
            path: path.into(),
            limit,
        });
    }
    Ok(())
}

/// Why a map cannot be loaded; each reads as one line that says what to do.
#[derive(Debug, thiserror::Error)]
pub enum MapError {
    /// A file cannot be read.
    #[error(
        "{}: cannot be read ({source}); name the map's .yaml, and keep its image where that names it",
        display_path(.path)
    )]
    Open {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// A file is larger than the limit for such files.
    #[error("{}: is larger than {limit} bytes; name the map's .yaml", display_path(.path))]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// The limit in bytes.
        limit: u64,
    },
    /// An image was given in place of the YAML file.
    #[error(
        "{}: is an image; give the .yaml that names it and has its resolution and origin{}",
        display_path(.path),
        beside(.path)
    )]
    IsImage {
        /// The file.
        path: PathBuf,
    },
    /// The YAML file does not describe a map.
    #[error("{}:{line}: {source}", display_path(.path))]
    Yaml {
        /// The file.
        path: PathBuf,
        /// The line.
        line: u64,
        /// What is wrong there.
        source: YamlError,
    },
    /// The image cannot be used.
    #[error("{}: {source}", display_path(.path))]
    Image {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: PixelError,
    },
}

/// The YAML file beside an image, if there is one of that name.
fn beside(image: &Path) -> String {
    let yaml = image.with_extension("yaml");
    if yaml.is_file() {
        format!(", {}", display_path(&yaml))
    } else {
        String::new()
    }
}

/// The two files of a map.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RosMapFiles {
    /// The image.
    pub pgm: PathBuf,
    /// The description, which names the image.
    pub yaml: PathBuf,
}

/// Writes `map` as `NAME.pgm` and then `NAME.yaml`, so that a description always has its image.
///
/// Free is 254, unknown 205, occupied 0, the thresholds are 0.65 and 0.196: every loader reads the
/// states of [`CellState::of`], whether its thresholds are inclusive or not. A larger `free_thresh`,
/// such as the common 0.25, would turn unknown into free. The image's top row is the highest y.
///
/// # Errors
/// If `name` is not a plain file name or a file cannot be written.
///
/// # Examples
/// ```
/// use certainty_core::{certainty::Certainty, units::Point};
/// use certainty_sim::export::{MapImage, OutDir, RosMap, write_ros_map};
///
/// let cells = [Certainty::FREE, Certainty::UNCERTAIN, Certainty::OCCUPIED];
/// let map = MapImage::try_new(3, 1, &cells, 100, Point::from_mm(-1500, 0)).unwrap();
/// let folder = tempfile::tempdir().unwrap();
/// let files = write_ros_map(&OutDir::create(folder.path())?, "room", &map)?;
/// assert_eq!(RosMap::load(&files.yaml).unwrap().map, RosMap::from_image(&map));
/// # Ok::<(), certainty_sim::export::ExportError>(())
/// ```
pub fn write_ros_map(
    out: &OutDir,
    name: &str,
    map: &MapImage<'_>,
) -> Result<RosMapFiles, ExportError> {
    let image = format!("{name}.pgm");
    let pgm = out.write(&image, |file| {
        write!(file, "P5\n{} {}\n255\n", map.width(), map.height())?;
        let mut pixels = Vec::with_capacity(map.width() as usize);
        for y in (0..map.height()).rev() {
            pixels.clear();
            pixels.extend(map.row(y).iter().map(|&cell| match CellState::of(cell) {
                CellState::Free => 254,
                CellState::Unknown => UNKNOWN_PIXEL,
                CellState::Occupied => 0,
            }));
            file.write_all(&pixels)?;
        }
        Ok(())
    })?;
    let metres = |mm: i64| mm as f64 / 1000.0;
    let yaml = out.write(&format!("{name}.yaml"), |file| {
        writeln!(file, "image: {}", quoted(&image))?;
        writeln!(file, "resolution: {:?}", metres(map.cell_mm().into()))?;
        let (x, y) = (map.origin().x_mm(), map.origin().y_mm());
        writeln!(
            file,
            "origin: [{:?}, {:?}, 0.0]",
            metres(x.into()),
            metres(y.into())
        )?;
        writeln!(file, "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196")
    })?;
    Ok(RosMapFiles { pgm, yaml })
}

/// `name` as a YAML scalar: in quotes if it has more than letters, digits, `_`, `-` and `.`, or does
/// not begin with a letter or digit.
fn quoted(name: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
    if name.chars().all(plain) && name.starts_with(|c: char| c.is_ascii_alphanumeric()) {
        name.to_owned()
    } else if name.contains(char::is_control) {
        let escaped: Vec<String> = name.chars().map(escaped).collect();
        format!("\"{}\"", escaped.concat())
    } else {
        // Within single quotes only the single quote is special.
        format!("'{}'", name.replace('\'', "''"))
    }
}

/// `c` within double quotes.
fn escaped(c: char) -> String {
    match c {
        '"' | '\\' => format!("\\{c}"),
        c if c.is_control() => format!("\\U{:08X}", u32::from(c)),
        c => c.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::map_image::write_grey_png;
    use certainty_core::certainty::Certainty;
    use certainty_core::units::Point;
    use core::num::NonZeroU32;
    use proptest::prelude::*;
    use std::fs;

    const FREE: CellState = CellState::Free;
    const UNKNOWN: CellState = CellState::Unknown;
    const OCCUPIED: CellState = CellState::Occupied;

    fn loaded(more: &str, image: &[u8]) -> LoadedMap {
        let text = format!("image: m.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n{more}");
        RosMap::from_bytes(text.as_bytes(), image).unwrap()
    }

    /// The states that pixels have in a map one row high.
    fn states(more: &str, pixels: &[u8]) -> Vec<CellState> {
        let mut image = format!("P5\n{} 1\n255\n", pixels.len()).into_bytes();
        image.extend_from_slice(pixels);
        loaded(more, &image).map.states
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
        let map = RosMap::load(&files.yaml).unwrap().map;
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
            let back = RosMap::load(&files.yaml).unwrap().map;
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
                RosMap::load(&files.yaml).unwrap().map,
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
        assert_eq!(RosMap::load(&path).unwrap().map, RosMap::from_image(&map));
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
            states("negate: 1", &[0, 50, 205, 255]),
            [FREE, UNKNOWN, OCCUPIED, OCCUPIED]
        );
        let raw = [0, 19, 20, 64, 65, 66, 100, 101, 255];
        let expected = [
            FREE, FREE, UNKNOWN, UNKNOWN, OCCUPIED, OCCUPIED, OCCUPIED, UNKNOWN, UNKNOWN,
        ];
        assert_eq!(states("mode: raw", &raw), expected);
        assert_eq!(
            states("mode: scale\nfree_thresh: 0.25", &[255, 205, 100, 0]),
            [FREE, FREE, UNKNOWN, OCCUPIED]
        );
    }

    #[test]
    fn pixels_on_a_threshold_meet_it() {
        // 51 of 255 is 0.2, in single precision too.
        let more = "free_thresh: 0.2\noccupied_thresh: 0.8";
        assert_eq!(
            states(more, &[203, 204, 52, 51]),
            [UNKNOWN, FREE, UNKNOWN, OCCUPIED]
        );
        let more = "free_thresh: 0\noccupied_thresh: 1";
        assert_eq!(
            states(more, &[255, 254, 1, 0]),
            [FREE, UNKNOWN, UNKNOWN, OCCUPIED]
        );
        // Free where both are met: 102 of 255 is 0.4.
        let more = "free_thresh: 0.6\noccupied_thresh: 0.6";
        assert_eq!(states(more, &[103, 102, 101]), [FREE, FREE, OCCUPIED]);
        let more = "free_thresh: 0.7\noccupied_thresh: 0.3";
        assert_eq!(states(more, &[254, 120, 0]), [FREE, FREE, OCCUPIED]);
        assert_eq!(
            states("occupied_thresh: 0.1", &[254, 220, 205, 0]),
            [FREE, FREE, UNKNOWN, OCCUPIED]
        );
    }

    #[test]
    fn transparent_pixels_are_unknown() {
        let pam = b"P7\nWIDTH 3\nHEIGHT 1\nDEPTH 2\nMAXVAL 255\nTUPLTYPE GRAYSCALE_ALPHA\nENDHDR\n\xFE\xFF\xFE\0\0\xFE";
        for mode in ["trinary", "scale"] {
            let map = loaded(&format!("mode: {mode}"), pam).map;
            assert_eq!(map.states, [FREE, UNKNOWN, UNKNOWN], "{mode}");
        }
        assert_eq!(
            loaded("mode: raw\nnegate: 0", pam).map.states,
            [UNKNOWN, UNKNOWN, FREE]
        );
    }

    #[test]
    fn notes_name_their_file() {
        let more = "free_thresh: 0.25\noccupied_thresh: 0.65\nnegate: 0\nx: 1";
        assert_eq!(
            loaded(more, b"P2 3 1 255 205 254 205 19 9").notes,
            [
                "map.yaml: keys that are not read: `x`",
                "map.yaml: 2 pixels of 205, which is written for unknown, stay unknown, unlike in map_server",
                "m.pgm: 4 bytes follow the pixels that the header announces; they are not read",
            ]
        );
        assert!(
            loaded(
                "free_thresh: 0.196\noccupied_thresh: 0.65\nnegate: 0",
                b"P1 1 1 1"
            )
            .notes
            .is_empty()
        );
        // The 205 of a file whose largest value is 254.
        assert_eq!(
            loaded("", b"P5 2 1 254\n\xCD\xFE").map.states,
            [UNKNOWN, FREE]
        );
    }

    #[test]
    fn yaml_may_come_from_a_stream() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("m.pgm"), "P2 1 1 255 0").unwrap();
        let text = b"image: m.pgm\nresolution: 0.1\norigin: [0, 0, 1.5]\n";
        let read = |text: &[u8]| RosMap::read(text, Path::new("stdin"), folder.path());
        let loaded = read(text).unwrap();
        assert_eq!(
            (loaded.map.state(0, 0), loaded.map.yaw_rad()),
            (Some(OCCUPIED), 1.5)
        );
        assert!(loaded.notes[0].starts_with("stdin: "));
        let error = read(b"P5 1 1 255\n\xff").unwrap_err().to_string();
        assert!(
            error.starts_with("stdin: is an image; give the .yaml"),
            "{error}"
        );
    }

    #[test]
    fn absolute_image_path_is_taken() {
        let (a, b) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let image = a.path().join("m.pgm");
        fs::write(&image, "P2 1 1 255 254").unwrap();
        let text = format!(
            "image: {:?}\nresolution: 0.1\norigin: [0, 0, 0]\n",
            image.display().to_string()
        );
        let yaml = b.path().join("m.yaml");
        fs::write(&yaml, text).unwrap();
        assert_eq!(RosMap::load(&yaml).unwrap().map.states, [FREE]);
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
        let expected =
            ": is an image; give the .yaml that names it and has its resolution and origin";
        starts(&message("gone.pgm"), "gone.pgm", expected);
        fs::write(at("gone.yaml"), "").unwrap();
        let given = message("gone.pgm");
        assert!(
            given.ends_with(&format!(", {}", at("gone.yaml").display())),
            "{given}"
        );
        fs::write(
            at("large.pgm"),
            [b"P5 300 300 255\n".as_slice(), &[0; 90_000]].concat(),
        )
        .unwrap();
        starts(&message("large.pgm"), "large.pgm", ": is an image");
        fs::write(at("b.yaml"), "image: [\u{1b}\n\n").unwrap();
        starts(&message("b.yaml"), "b.yaml", ":");
        fs::write(at("c.yaml"), vec![b'#'; 70_000]).unwrap();
        starts(&message("c.yaml"), "c.yaml", ": is larger than 65536 bytes");
    }

    proptest! {
        #[test]
        fn no_map_panics(
            kind in 0_usize..9,
            header in "[ #0-9\n]{0,20}",
            bytes: Vec<u8>,
            changes: Vec<(usize, u8)>,
            more in "(mode: (raw|scale)\n)?(negate: [a-z0-9]{1,5}\n)?[ -~]{0,20}",
            numbers: [f64; 3],
        ) {
            let mut image = match kind {
                0 => bytes,
                1 => [b"P5", header.as_bytes(), &bytes].concat(),
                2 => [b"P2", header.as_bytes(), &bytes].concat(),
                3 => [&b"\x89PNG\r\n\x1a\n"[..], &bytes].concat(),
                4 => [b"P4", header.as_bytes(), &bytes].concat(),
                kind => picture(kind),
            };
            for (place, byte) in changes {
                let length = image.len().max(1);
                if let Some(found) = image.get_mut(place % length) {
                    *found = byte;
                }
            }
            let yaml = format!("image: m\nresolution: 1\norigin: {numbers:?}\n{more}\n");
            for yaml in [yaml.as_bytes(), b"{image: m, resolution: 1, origin: [0, 0]}"] {
                if let Ok(LoadedMap { map, .. }) = RosMap::from_bytes(yaml, &image) {
                    let count = u64::from(map.width) * u64::from(map.height);
                    prop_assert_eq!(map.states.len() as u64, count);
                    prop_assert!(count <= image.len() as u64 * 8 * 1100);
                }
            }
        }
    }

    /// A small picture in one of the packed formats.
    fn picture(kind: usize) -> Vec<u8> {
        let greys: Vec<u8> = (0..=255).collect();
        let format = match kind {
            5 => image::ImageFormat::Png,
            6 => image::ImageFormat::Bmp,
            7 => image::ImageFormat::Gif,
            _ => image::ImageFormat::Jpeg,
        };
        let image = image::GrayImage::from_raw(16, 16, greys).unwrap();
        let image = image::DynamicImage::from(image).to_rgb8();
        let mut file = io::Cursor::new(Vec::new());
        image.write_to(&mut file, format).unwrap();
        file.into_inner()
    }
}
