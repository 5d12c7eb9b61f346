//! Maps as other programs see them: a reader of PGM + YAML that shares no code with ours.

use crate::support::program::command;
use certainty_tests::pgm::pgm;
use certainty_tests::process::run;
use core::fmt;
use core::time::Duration;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// A pixel's state by the thresholds 0.65 and 0.196 of `map_server`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Cell {
    /// Darkness below 0.196.
    Free,
    /// Neither.
    Unknown,
    /// Darkness above 0.65.
    Occupied,
}

/// A map with its place, rows from the lowest.
#[derive(Clone, PartialEq)]
pub(crate) struct Map {
    /// Cells along x.
    pub(crate) width: usize,
    /// Cells along y.
    pub(crate) height: usize,
    /// Metres a cell.
    pub(crate) resolution: f64,
    /// x and y of the lower left corner in metres.
    pub(crate) origin: [f64; 2],
    cells: Vec<Cell>,
}

impl Map {
    /// Reads `map.yaml` and `map.pgm` in `folder`.
    ///
    /// # Panics
    /// If they are not there or not as `map_server` wants them.
    #[must_use]
    pub(crate) fn read(folder: &Path) -> Self {
        let text = fs::read_to_string(folder.join("map.yaml")).expect("there is a map.yaml");
        let value = |key: &str| {
            let found = text.lines().find_map(|line| line.strip_prefix(key));
            found.unwrap_or_else(|| panic!("no {key} in {text}")).trim()
        };
        assert_eq!(value("image:"), "map.pgm");
        let number = |text: &str| text.trim().parse::<f64>().expect("a number");
        let origin: Vec<f64> = value("origin:")
            .trim_matches(['[', ']'])
            .split(',')
            .map(number)
            .collect();
        let image = fs::read(folder.join("map.pgm")).expect("there is a map.pgm");
        let (width, height, pixels) = pgm(&image);
        let rows = pixels.chunks(width).rev();
        Self {
            width,
            height,
            resolution: number(value("resolution:")),
            origin: [origin[0], origin[1]],
            cells: rows.flatten().map(|&pixel| cell(pixel)).collect(),
        }
    }

    /// Returns the cell in column `x` of row `y`, counted from the lower left.
    #[must_use]
    pub(crate) fn at(&self, x: usize, y: usize) -> Cell {
        self.cells[y * self.width + x]
    }

    /// Returns the state at a place in metres; unknown outside the map.
    #[must_use]
    pub(crate) fn at_place(&self, x: f64, y: f64) -> Cell {
        let column = ((x - self.origin[0]) / self.resolution).floor();
        let row = ((y - self.origin[1]) / self.resolution).floor();
        let inside = |cell: f64, cells: usize| (0.0..cells as f64).contains(&cell);
        if inside(column, self.width) && inside(row, self.height) {
            self.at(column as usize, row as usize)
        } else {
            Cell::Unknown
        }
    }

    /// Returns the middle of every cell that is `wanted`, in metres.
    #[must_use]
    pub(crate) fn places(&self, wanted: Cell) -> Vec<[f64; 2]> {
        let all = (0..self.height).flat_map(|y| (0..self.width).map(move |x| (x, y)));
        let found = all.filter(|&(x, y)| self.at(x, y) == wanted);
        let middle = |cells: usize, origin: f64| origin + (cells as f64 + 0.5) * self.resolution;
        found
            .map(|(x, y)| [middle(x, self.origin[0]), middle(y, self.origin[1])])
            .collect()
    }
}

/// The highest row first: `#` occupied, `.` free, `?` unknown.
impl fmt::Display for Map {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for row in self.cells.chunks(self.width).rev() {
            let drawn = row.iter().map(|cell| match cell {
                Cell::Free => '.',
                Cell::Unknown => '?',
                Cell::Occupied => '#',
            });
            writeln!(f, "{}", drawn.collect::<String>())?;
        }
        Ok(())
    }
}

impl fmt::Debug for Map {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} m at {:?}\n{self}", self.resolution, self.origin)
    }
}

/// Trinary mode of `map_server`: darkness against both thresholds.
fn cell(pixel: u8) -> Cell {
    let darkness = f64::from(255 - pixel) / 255.0;
    if darkness > 0.65 {
        Cell::Occupied
    } else if darkness < 0.196 {
        Cell::Free
    } else {
        Cell::Unknown
    }
}

/// Writes a map drawn as `#`, `.` and `?` (the highest row first) as `NAME.pgm` and `NAME.yaml`.
///
/// # Panics
/// If it cannot be written or the drawing has another character.
pub(crate) fn write_drawn(
    folder: &Path,
    name: &str,
    rows: &[&str],
    resolution: f64,
    origin: [f64; 2],
) {
    let mut image = format!("P5\n{} {}\n255\n", rows[0].len(), rows.len()).into_bytes();
    image.extend(rows.concat().bytes().map(|byte| match byte {
        b'#' => 0,
        b'.' => 254,
        b'?' => 205,
        _ => panic!("{byte} is no cell"),
    }));
    let [x, y] = origin;
    let yaml = format!(
        "image: {name}.pgm\nresolution: {resolution}\norigin: [{x}, {y}, 0.0]\nnegate: 0\n\
         occupied_thresh: 0.65\nfree_thresh: 0.196\n"
    );
    fs::write(folder.join(format!("{name}.pgm")), image).expect("a file can be written");
    fs::write(folder.join(format!("{name}.yaml")), yaml).expect("a file can be written");
}

/// Replays the file at `path` in a folder of its own; returns the report and the map.
///
/// # Panics
/// If it fails, takes longer than two minutes, or writes no map.
#[must_use]
pub(crate) fn replay_file(path: &Path, options: &str) -> (Value, Map) {
    let folder = tempfile::tempdir().unwrap();
    let mut arguments = vec!["replay", path.to_str().unwrap(), "--json"];
    arguments.extend(options.split_whitespace());
    let ran = run(command(folder.path(), arguments), Duration::from_secs(120));
    (ran.json(), Map::read(&folder.path().join("out")))
}
