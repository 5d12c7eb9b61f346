//! Maps of ROS navigation: an image, and a YAML file with its scale and origin.
//!
//! The format is that of ROS `map_server` in its *trinary* mode; the reader also takes the modes
//! *scale* and *raw*, and images in PNG and BMP.

use super::files::{ExportError, OutDir, display_path, one_line};
use super::map_image::{CellState, MapImage, PixelError, Pixels};
use serde::Deserialize;
use serde_saphyr::{DuplicateKeyPolicy, Spanned, from_str_with_options, options};
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

/// What is wrong with a map's YAML file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum YamlError {
    /// It is not UTF-8.
    #[error("is not text; name the map's .yaml, not its image")]
    NotText,
    /// It is not YAML, or a value is of another kind; with the parser's message.
    #[error("is not a map description ({0}); correct it")]
    Syntax(String),
    /// It has no keys.
    #[error("is not a map description; write `key: value` lines, starting with `image:`")]
    NotKeys,
    /// A key is missing.
    #[error("`{0}` is missing; add it")]
    Missing(&'static str),
    /// A key's value is not what it must be.
    #[error("`{key}` must be {expected}; correct it")]
    Value {
        /// The key.
        key: &'static str,
        /// What its value must be.
        expected: &'static str,
    },
}

/// How pixels become probabilities.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    /// By brightness, into three states.
    Trinary,
    /// By brightness; transparent pixels are unknown.
    Scale,
    /// A pixel is a percentage; above 100 it is unknown.
    Raw,
}

/// A map's description.
///
/// Possession proves that the resolution is positive, all numbers are finite, and the free
/// threshold is below the occupied one.
#[derive(Debug, Clone, PartialEq)]
struct MapYaml {
    image: String,
    resolution_m: f64,
    origin_m: [f64; 2],
    negate: bool,
    occupied_thresh: f64,
    free_thresh: f64,
    mode: Mode,
}

/// The keys that are read, each value as it is written, with its line; others are ignored.
#[derive(Debug, Deserialize)]
struct Keys {
    image: Scalar,
    resolution: Scalar,
    origin: Option<Spanned<Vec<String>>>,
    negate: Scalar,
    occupied_thresh: Scalar,
    free_thresh: Scalar,
    mode: Scalar,
}

type Scalar = Option<Spanned<String>>;

type Parsed<T> = Result<T, (u64, YamlError)>;

impl MapYaml {
    /// Parses the file's bytes; an error comes with its line.
    ///
    /// Default thresholds are 0.65 and 0.196, the default negation is 0, the default mode trinary.
    fn parse(bytes: &[u8]) -> Parsed<Self> {
        let text = str::from_utf8(bytes).map_err(|_| (1, YamlError::NotText))?;
        let text = text.strip_prefix('\u{FEFF}').unwrap_or(text);
        // Nothing but blanks and comments is no mapping.
        let mut lines = text.lines().map(str::trim);
        if lines.all(|line| line.is_empty() || line.starts_with('#')) {
            return Err((1, YamlError::NotKeys));
        }
        let options = options! { duplicate_keys: DuplicateKeyPolicy::LastWins };
        let keys: Keys = from_str_with_options(text, options).map_err(|error| {
            let line = error.location().map_or(1, |at| at.line());
            let message = one_line(error.without_snippet().to_string());
            (line.max(1), YamlError::Syntax(message))
        })?;
        let (line, image) = scalar(&keys.image, "image")?;
        if image.is_empty() || image.contains('\0') {
            return Err(wrong(line, "image", "a file name"));
        }
        let thresh = |value: &Scalar, key, default| match value {
            Some(_) => number(value, key, "a probability from 0 to 1", |p| {
                (0.0..=1.0).contains(&p)
            }),
            None => Ok((1, default)),
        };
        let (_, occupied_thresh) = thresh(&keys.occupied_thresh, "occupied_thresh", 0.65)?;
        let (line, free_thresh) = thresh(&keys.free_thresh, "free_thresh", 0.196)?;
        if free_thresh >= occupied_thresh {
            return Err(wrong(line, "free_thresh", "below `occupied_thresh`"));
        }
        let resolution = number(
            &keys.resolution,
            "resolution",
            "metres a cell, above 0",
            |m| m > 0.0,
        );
        Ok(Self {
            image: image.to_owned(),
            resolution_m: resolution?.1,
            origin_m: origin(keys.origin.as_ref())?,
            negate: match &keys.negate {
                None => false,
                Some(value) => match value.value.as_str() {
                    "0" | "false" => false,
                    "1" | "true" => true,
                    _ => return Err(wrong(value.referenced.line(), "negate", "0 or 1")),
                },
            },
            occupied_thresh,
            free_thresh,
            mode: match &keys.mode {
                None => Mode::Trinary,
                Some(value) => match value.value.as_str() {
                    "trinary" => Mode::Trinary,
                    "scale" => Mode::Scale,
                    "raw" => Mode::Raw,
                    _ => {
                        let line = value.referenced.line();
                        return Err(wrong(line, "mode", "trinary, scale or raw"));
                    }
                },
            },
        })
    }
}

const fn wrong(line: u64, key: &'static str, expected: &'static str) -> (u64, YamlError) {
    (line, YamlError::Value { key, expected })
}

fn scalar<'a>(value: &'a Scalar, key: &'static str) -> Parsed<(u64, &'a str)> {
    let value = value.as_ref().ok_or((1, YamlError::Missing(key)))?;
    Ok((value.referenced.line(), &value.value))
}

fn number(
    value: &Scalar,
    key: &'static str,
    expected: &'static str,
    fits: impl Fn(f64) -> bool,
) -> Parsed<(u64, f64)> {
    let (line, text) = scalar(value, key)?;
    let number = finite(text).filter(|&number| fits(number));
    Ok((line, number.ok_or(wrong(line, key, expected))?))
}

fn origin(value: Option<&Spanned<Vec<String>>>) -> Parsed<[f64; 2]> {
    let key = "origin";
    let value = value.ok_or((1, YamlError::Missing(key)))?;
    let line = value.referenced.line();
    let numbers: Option<Vec<f64>> = value.value.iter().map(|text| finite(text)).collect();
    match numbers.as_deref() {
        Some(&[x, y] | &[x, y, 0.0]) => Ok([x, y]),
        Some(&[_, _, _]) => Err(wrong(line, key, "without rotation: [x, y, 0.0]")),
        _ => Err(wrong(line, key, "numbers: [x, y, yaw]")),
    }
}

fn finite(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

/// The pixel of trinary maps that means *unknown*.
const UNKNOWN_PIXEL: u8 = 205;

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
/// assert_eq!(RosMap::load(&files.yaml).unwrap(), RosMap::from_image(&map));
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

    const WHOLE: &str = "image: map.pgm\nresolution: 0.05\norigin: [-1.5, 2, 0.0]\nnegate: 0\n\
                         occupied_thresh: 0.65\nfree_thresh: 0.196\n";

    fn yaml_message(text: &str) -> String {
        let (line, error) = MapYaml::parse(text.as_bytes()).unwrap_err();
        format!("{line}: {error}")
    }

    #[test]
    fn map_saver_description_is_read() {
        let expected = MapYaml {
            image: "map.pgm".to_owned(),
            resolution_m: 0.05,
            origin_m: [-1.5, 2.0],
            negate: false,
            occupied_thresh: 0.65,
            free_thresh: 0.196,
            mode: Mode::Trinary,
        };
        assert_eq!(MapYaml::parse(WHOLE.as_bytes()).unwrap(), expected);
        let block = WHOLE.replace(" [-1.5, 2, 0.0]", "\n  - -1.5\n  - 2\n  - 0.0");
        assert_eq!(MapYaml::parse(block.as_bytes()).unwrap(), expected);
        let short = "{image: 'map.pgm', resolution: 5e-2, origin: [-1.5, 2.0]}";
        assert_eq!(MapYaml::parse(short.as_bytes()).unwrap(), expected);
        let twice = format!("resolution: 7\n{WHOLE}");
        assert_eq!(MapYaml::parse(twice.as_bytes()).unwrap(), expected);
    }

    #[test]
    fn unknown_keys_are_ignored_however_nested() {
        let more =
            format!("{WHOLE}mode: raw\nnotes: {{a: [1, {{b: c}}], origin: [9, 9, 0]}}\nx: &y 1\n");
        let yaml = MapYaml::parse(more.as_bytes()).unwrap();
        assert_eq!((yaml.mode, yaml.origin_m), (Mode::Raw, [-1.5, 2.0]));
    }

    #[test]
    fn wrong_value_is_named_with_its_line() {
        for (from, to, expected) in [
            ("image: map.pgm\n", "", "1: `image` is missing; add it"),
            (
                "0.05",
                "0",
                "2: `resolution` must be metres a cell, above 0; correct it",
            ),
            (
                "0.05",
                "nan",
                "2: `resolution` must be metres a cell, above 0; correct it",
            ),
            (
                "2, 0.0",
                "2, 1.57",
                "3: `origin` must be without rotation: [x, y, 0.0]; correct it",
            ),
            (
                "-1.5, 2, 0.0",
                "1",
                "3: `origin` must be numbers: [x, y, yaw]; correct it",
            ),
            (
                "negate: 0",
                "negate: maybe",
                "4: `negate` must be 0 or 1; correct it",
            ),
            (
                "0.65",
                "1.5",
                "5: `occupied_thresh` must be a probability from 0 to 1; correct it",
            ),
            (
                "0.196",
                "0.7",
                "6: `free_thresh` must be below `occupied_thresh`; correct it",
            ),
        ] {
            assert_eq!(
                yaml_message(&WHOLE.replace(from, to)),
                expected,
                "{from:?} -> {to:?}"
            );
        }
        // A value of another kind is reported by the parser.
        for (from, to, line) in [("0.05", "[0.05]", "2"), ("2, 0.0", "[2], 0.0", "3")] {
            let message = yaml_message(&WHOLE.replace(from, to));
            assert!(message.starts_with(&format!("{line}: ")), "{message}");
            assert_eq!(message.lines().count(), 1, "{message}");
        }
    }

    #[test]
    fn other_text_is_refused_in_one_line() {
        for text in ["", "\n", "# only a note\n"] {
            assert!(
                yaml_message(text).ends_with("starting with `image:`"),
                "{text:?}"
            );
        }
        for text in [
            "just words",
            "- image: map.pgm\n",
            "? [a]\n: b\n",
            "image: \"map",
        ] {
            let message = yaml_message(text);
            assert!(message.contains("is not a map description ("), "{message}");
            assert_eq!(message.lines().count(), 1, "{message}");
        }
        assert_eq!(
            MapYaml::parse(b"image: \xff").unwrap_err().1,
            YamlError::NotText
        );
    }

    #[test]
    fn no_nesting_overflows_the_stack() {
        for nest in ["[", "{a: ", "- ", "? ", "a:\n "] {
            let deep = nest.repeat((1 << 16) / nest.len());
            assert!(MapYaml::parse(deep.as_bytes()).is_err());
            let deep = format!("image: map.pgm\nx: {deep}");
            assert!(MapYaml::parse(deep.as_bytes()).is_err());
        }
    }

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
