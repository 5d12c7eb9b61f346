//! What these tests share: runs of the program, its input files, synthetic recordings, a reader of maps, and
//! the shapes of JSON documents.

use certainty_tests::pgm::pgm;
use certainty_tests::process::{PATIENCE, Ran, run};
use core::f64::consts::{FRAC_PI_2, PI};
use core::fmt;
use core::time::Duration;
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::Value;
use std::ffi::OsStr;
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// Returns the program with `arguments`, to be run in `folder`.
///
/// Variables for colours and backtraces are removed from its environment.
pub(crate) fn command<A: AsRef<OsStr>>(
    folder: &Path,
    arguments: impl IntoIterator<Item = A>,
) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_certainty"));
    command.args(arguments).current_dir(folder);
    for variable in ["NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE", "RUST_BACKTRACE"] {
        command.env_remove(variable);
    }
    command.stdin(Stdio::null());
    command
}

/// Runs the program in `folder` with `arguments` separated by spaces.
///
/// # Panics
/// If it cannot be started or runs longer than [`PATIENCE`].
#[must_use]
pub(crate) fn certainty(folder: &Path, arguments: &str) -> Ran {
    run(command(folder, arguments.split_whitespace()), PATIENCE)
}

/// Limit for runs that fail or have little to do; enough for a busy machine too.
pub(crate) const QUICKLY: Duration = Duration::from_secs(15);

/// The pose of the synthetic scans.
pub(crate) const PLACE: Place = Place {
    x: 0.0,
    y: 0.0,
    heading: 0.0,
};

/// Returns a scan with every range the same.
#[must_use]
pub(crate) fn scan(metres: f64) -> String {
    flaser(&[metres; BEAMS], PLACE, 1.0)
}

/// Returns a folder with one file, `input`.
///
/// # Panics
/// If it cannot be made.
pub(crate) fn folder_with(content: impl AsRef<[u8]>) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("input"), content).unwrap();
    folder
}

/// Runs the program in `folder` with `arguments` separated by spaces, for at most [`QUICKLY`].
///
/// # Panics
/// If it takes longer.
#[must_use]
pub(crate) fn certainty_quickly(folder: &Path, arguments: &str) -> Ran {
    run(command(folder, arguments.split_whitespace()), QUICKLY)
}

/// A wall from one corner to the next, in metres.
type Wall = ([f64; 2], [f64; 2]);

/// A room: a closed line of walls.
#[derive(Debug, Clone)]
pub(crate) struct Room {
    corners: Vec<[f64; 2]>,
}

/// The laser's pose: metres and radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    /// Metres.
    pub(crate) x: f64,
    /// Metres.
    pub(crate) y: f64,
    /// Radians, counter-clockwise from +x.
    pub(crate) heading: f64,
}

/// A laser's range without an echo, in metres.
pub(crate) const NO_ECHO_M: f64 = 81.83;

/// Beams of a scan, over the half circle ahead.
pub(crate) const BEAMS: usize = 180;

impl Room {
    /// Creates the room between `corners`, each joined to the next and the last to the first.
    #[must_use]
    pub(crate) fn new(corners: &[[f64; 2]]) -> Self {
        Self {
            corners: corners.to_vec(),
        }
    }

    fn walls(&self) -> impl Iterator<Item = Wall> + '_ {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().copied().zip(next.copied())
    }

    /// Returns how far it is from (`x`, `y`) along `bearing` to the nearest wall.
    #[must_use]
    pub(crate) fn distance(&self, x: f64, y: f64, bearing: f64) -> f64 {
        let (dy, dx) = bearing.sin_cos();
        let hits = self.walls().filter_map(|([ax, ay], [bx, by])| {
            let (ex, ey) = (bx - ax, by - ay);
            let cross = dx * ey - dy * ex;
            let along = ((ax - x) * ey - (ay - y) * ex) / cross;
            let part = ((ax - x) * dy - (ay - y) * dx) / cross;
            (along > 0.0 && (0.0..=1.0).contains(&part)).then_some(along)
        });
        hits.fold(f64::INFINITY, f64::min)
    }

    /// Returns the ranges of a scan of [`BEAMS`] beams, the first a quarter turn to the right.
    #[must_use]
    pub(crate) fn scan(&self, place: Place) -> Vec<f64> {
        let bearing = |beam: usize| place.heading - FRAC_PI_2 + beam as f64 * PI / BEAMS as f64;
        (0..BEAMS)
            .map(|beam| self.distance(place.x, place.y, bearing(beam)))
            .map(|metres| {
                if metres < NO_ECHO_M {
                    metres
                } else {
                    NO_ECHO_M
                }
            })
            .collect()
    }
}

/// Returns four poses at (`x`, `y`): their half circles cover every direction twice.
#[must_use]
pub(crate) fn all_around(x: f64, y: f64) -> [Place; 4] {
    let place = |quarter: u8| Place {
        x,
        y,
        heading: f64::from(quarter) * FRAC_PI_2,
    };
    [0, 1, 2, 3].map(place)
}

/// Returns a `FLASER` line of a CARMEN log.
#[must_use]
pub(crate) fn flaser(ranges: &[f64], place: Place, time_s: f64) -> String {
    let Place { x, y, heading } = place;
    format!(
        "FLASER {} {} {x} {y} {heading} {x} {y} {heading} {time_s} robot {time_s}\n",
        ranges.len(),
        joined(ranges)
    )
}

/// Returns a `ROBOTLASER1` line of a CARMEN log for the same beams as [`flaser`].
#[must_use]
pub(crate) fn robotlaser(ranges: &[f64], place: Place, time_s: f64) -> String {
    let Place { x, y, heading } = place;
    format!(
        "ROBOTLASER1 0 {} {PI} {} {NO_ECHO_M} 0.01 0 {} {} 0 {x} {y} {heading} {x} {y} {heading} \
         0 0 0.5 0.5 1000000 {time_s} robot {time_s}\n",
        -FRAC_PI_2,
        PI / ranges.len() as f64,
        ranges.len(),
        joined(ranges)
    )
}

/// Returns a log of `room` seen from `places`, a scan every 100 ms, a line each by `line`.
#[must_use]
pub(crate) fn log(
    room: &Room,
    places: &[Place],
    line: impl Fn(&[f64], Place, f64) -> String,
) -> String {
    let scans = places.iter().zip(0_u32..);
    scans
        .map(|(&place, number)| line(&room.scan(place), place, f64::from(number) / 10.0))
        .collect()
}

/// Compresses `bytes`; writing to memory never fails.
#[must_use]
pub(crate) fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).expect("memory takes every byte");
    encoder.finish().expect("memory takes every byte")
}

fn joined(ranges: &[f64]) -> String {
    let texts: Vec<String> = ranges.iter().map(f64::to_string).collect();
    texts.join(" ")
}

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

/// Returns the document with every value replaced by its type.
///
/// All elements of an array share one shape. A value of several types has the shape `{"any of": […]}`, with
/// `absent` for an object's optional key.
#[must_use]
pub(crate) fn shape(document: &Value) -> Value {
    match document {
        Value::Null => "null".into(),
        Value::Bool(_) => "boolean".into(),
        Value::Number(_) => "number".into(),
        Value::String(_) => "string".into(),
        Value::Array(elements) => elements
            .iter()
            .map(shape)
            .reduce(merge)
            .into_iter()
            .collect(),
        Value::Object(fields) => fields
            .iter()
            .map(|(key, value)| (key.clone(), shape(value)))
            .collect(),
    }
}

const ANY_OF: &str = "any of";

/// The shape of a value that has one shape or the other.
fn merge(a: Value, b: Value) -> Value {
    let mut shapes: Vec<Value> = Vec::new();
    for shape in [alternatives(a), alternatives(b)].concat() {
        let same_kind = |known: &&mut Value| match &shape {
            Value::Object(_) => known.is_object(),
            Value::Array(_) => known.is_array(),
            scalar => **known == *scalar,
        };
        match shapes.iter_mut().find(same_kind) {
            Some(known) => *known = merge_alike(known.take(), shape),
            None => shapes.push(shape),
        }
    }
    shapes.sort_by_key(ToString::to_string);
    match shapes.as_slice() {
        [one] => one.clone(),
        _ => serde_json::Map::from_iter([(ANY_OF.to_owned(), Value::from(shapes))]).into(),
    }
}

fn alternatives(shape: Value) -> Vec<Value> {
    match shape.get(ANY_OF) {
        Some(Value::Array(shapes)) => shapes.clone(),
        _ => vec![shape],
    }
}

/// Merges two objects, two arrays or two equal scalars.
fn merge_alike(a: Value, b: Value) -> Value {
    match (a, b) {
        (Value::Object(mut a), Value::Object(mut b)) => {
            let keys: Vec<String> = a.keys().chain(b.keys()).cloned().collect();
            let absent = || Value::from("absent");
            let fields = keys.into_iter().filter_map(|key| {
                let (a, b) = (a.remove(&key), b.remove(&key));
                let merged = match (a, b) {
                    (None, None) => return None, // the key is in both, and was merged before
                    (a, b) => merge(a.unwrap_or_else(absent), b.unwrap_or_else(absent)),
                };
                Some((key, merged))
            });
            fields.collect()
        }
        (Value::Array(a), Value::Array(b)) => {
            a.into_iter().chain(b).reduce(merge).into_iter().collect()
        }
        (a, _) => a,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_scan_of_a_square_has_the_right_ranges() {
        let room = Room::new(&[[-1.0, -1.0], [3.0, -1.0], [3.0, 1.0], [-1.0, 1.0]]);
        let place = Place {
            x: 0.0,
            y: 0.0,
            heading: 0.0,
        };
        let scan = room.scan(place);
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        assert!(near(scan[0], 1.0), "right");
        assert!(near(scan[90], 3.0), "ahead");
        assert!(
            near(scan[135], 2.0_f64.sqrt()),
            "left ahead, to the wall above"
        );
        assert!(
            near(scan[30], 2.0 / 3.0_f64.sqrt()),
            "60 degrees to the right"
        );
    }

    #[test]
    fn elements_share_a_shape() {
        let document = json!({"list": [{"a": 1, "b": null}, {"a": 2, "b": [true]}, {"a": 3}]});
        let b = json!({"any of": ["absent", "null", ["boolean"]]});
        let expected = json!({"list": [{"a": "number", "b": b}]});
        assert_eq!(shape(&document), expected);
        assert_eq!(shape(&json!([])), json!([]));
    }
}
