//! Writing a map for ROS.

use crate::export::files::{ExportError, OutDir};
use crate::export::map_image::{CellState, MapImage};
use std::path::PathBuf;

/// The pixel of trinary maps that means *unknown*.
pub(super) const UNKNOWN_PIXEL: u8 = 205;

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
