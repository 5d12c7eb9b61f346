//! Recordings of real rings: 24 direct distances per row, without cross echoes.

use super::acoustics::SONARS;
use crate::export::display_path;
use crate::quantity::Excerpt;
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Missing, Reading};
use certainty_core::units::Millimeters;
use certainty_ring::{
    Distances, Echoes, Overlap, Ring, RingRules, independent_overlaps, intersection_based,
};
use serde::Serialize;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Largest accepted recording, in bytes.
const MOST_BYTES: u64 = 64 << 20;

/// A recording: rows of 24 direct readings.
#[derive(Debug, Clone, PartialEq)]
pub struct RingRecording {
    rows: Vec<Row>,
    skipped: u64,
    first_skipped: Option<(usize, String)>,
}

/// A row: its line in the file, from 1, and the reading of each sonar.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Row {
    line: usize,
    readings: [Reading; SONARS],
}

/// Why a recording cannot be read; displays as one line.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// The file cannot be read.
    #[error("{}: cannot be read ({source}); check its name and permissions", display_path(.path))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The file is a directory.
    #[error("{}: is a directory: expected a recording", display_path(.path))]
    Directory {
        /// The directory.
        path: PathBuf,
    },
    /// The file is too long.
    #[error("{}: over 64 MiB; split the recording into shorter ones", display_path(.path))]
    TooLong {
        /// The file.
        path: PathBuf,
    },
    /// No line is a row.
    #[error("{}{}", display_path(.path), no_rows(.first.as_ref()))]
    NoRows {
        /// The file.
        path: PathBuf,
        /// The first line that is not a row, from 1, and why.
        first: Option<(usize, String)>,
    },
}

/// The part of the error after the file's name if it has no rows.
fn no_rows(first: Option<&(usize, String)>) -> String {
    let format = "expected 24 distances in metres per line, separated by commas";
    match first {
        Some((line, why)) => format!(":{line}: {why}; {format}"),
        None => format!(": is empty; {format}"),
    }
}

impl RingRecording {
    /// Reads the recording at `path`; distances of `range` or more are *no object*.
    ///
    /// # Errors
    ///
    /// [`RecordingError`] if the file cannot be read, is too long or has no rows.
    pub fn load(path: &Path, range: Millimeters) -> Result<Self, RecordingError> {
        let unreadable = |source: io::Error| {
            let path = path.to_owned();
            match source.kind() {
                io::ErrorKind::IsADirectory => RecordingError::Directory { path },
                _ => RecordingError::Unreadable { path, source },
            }
        };
        let mut bytes = Vec::new();
        let file = File::open(path).map_err(unreadable)?;
        file.take(MOST_BYTES + 1)
            .read_to_end(&mut bytes)
            .map_err(unreadable)?;
        if bytes.len() as u64 > MOST_BYTES {
            return Err(RecordingError::TooLong {
                path: path.to_owned(),
            });
        }
        let recording = Self::parse(&bytes, range);
        if recording.rows.is_empty() {
            return Err(RecordingError::NoRows {
                path: path.to_owned(),
                first: recording.first_skipped,
            });
        }
        Ok(recording)
    }

    /// Reads a recording from arbitrary bytes; lines that are not rows are skipped and counted.
    ///
    /// NaN or a number below zero is a missing reading of its sonar.
    #[must_use]
    pub fn parse(bytes: &[u8], range: Millimeters) -> Self {
        let mut recording = Self {
            rows: Vec::new(),
            skipped: 0,
            first_skipped: None,
        };
        for (number, line) in (1..).zip(bytes.split(|&byte| byte == b'\n')) {
            if line.iter().all(u8::is_ascii_whitespace) {
                continue;
            }
            match row(line, range) {
                Ok(readings) => recording.rows.push(Row {
                    line: number,
                    readings,
                }),
                Err(why) => {
                    recording.skipped += 1;
                    recording.first_skipped.get_or_insert((number, why));
                }
            }
        }
        recording
    }

    /// Returns the number of rows.
    #[must_use]
    pub const fn rows(&self) -> usize {
        self.rows.len()
    }

    /// Returns the number of lines that are not rows.
    #[must_use]
    pub const fn skipped(&self) -> u64 {
        self.skipped
    }
}

/// Parses a row: 24 numbers; further columns are ignored.
fn row(line: &[u8], range: Millimeters) -> Result<[Reading; SONARS], String> {
    let text = str::from_utf8(line).map_err(|_| "is not text".to_owned())?;
    let mut readings = [Reading::Missing(Missing::Timeout); SONARS];
    let mut fields = text.trim_start_matches('\u{FEFF}').split(',');
    for (column, reading) in (1..).zip(&mut readings) {
        let field = fields.next().ok_or_else(|| {
            let found = column - 1;
            format!("has {found} columns where there are 24 sonars")
        })?;
        let number: f64 = field.trim().parse().map_err(|_| {
            let field = Excerpt::new(field);
            format!("'{field}' in column {column} is not a number")
        })?;
        *reading = if number.is_nan() || number < 0.0 {
            Reading::Missing(Missing::Implausible)
        } else if number * 1000.0 >= f64::from(range.get()) {
            Reading::NoObject
        } else {
            Reading::Echo(Millimeters::new((number * 1000.0).round() as u32))
        };
    }
    Ok(readings)
}

/// Consecutive rows that indicate a fault of a sonar; lines of the file, from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct FrozenRun {
    /// Its first line.
    pub from_line: usize,
    /// Its last line.
    pub to_line: usize,
    /// The number of rows.
    pub rows: usize,
    /// The constant reading of the sonar; `None` for *no object*.
    pub reading_mm: Option<u32>,
}

/// The readings of one sonar over a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SensorSummary {
    /// The sonar's number.
    pub sensor: u8,
    /// Rows with an echo.
    pub echoes: usize,
    /// Rows with no object in range.
    pub no_object: usize,
    /// Rows without a reading.
    pub missing: usize,
    /// Rows in which its direct arc intersects that of at least one neighbour.
    pub confirmed: usize,
    /// Mean number of intersections with neighbours' arcs, of six in the paper's ring.
    pub mean_intersections: f64,
    /// The longest run of equal echoes, whatever the neighbours' readings.
    pub longest_equal: Option<FrozenRun>,
    /// Runs of equal echoes during which both neighbours changed by more than 0.1 m.
    pub stuck: Vec<FrozenRun>,
    /// Runs without an echo during which both neighbours had an echo in every row, within half the range.
    pub blind: Vec<FrozenRun>,
}

/// The assessment of a ring from direct echoes alone, without cross echoes and lasers.
#[derive(Debug, Clone, PartialEq)]
pub struct DirectAssessment {
    /// Each sonar, in order.
    pub sensors: Vec<SensorSummary>,
    /// Number of independent overlaps of direct echoes, and of all.
    pub overlaps: (u32, u32),
}

impl DirectAssessment {
    /// The least length of a run.
    pub const LEAST_ROWS: usize = 10;

    /// Assesses a recording by the overlaps of direct echoes (\[003\] §6), and finds frozen sonars.
    #[must_use]
    pub fn of(recording: &RingRecording, ring: &Ring<SONARS>, rules: &RingRules) -> Self {
        let mut sums = [0_u64; SONARS];
        let mut confirmed = [0; SONARS];
        for row in &recording.rows {
            let measured = Distances::fold(ring, &direct(row), rules);
            let vector = intersection_based(ring, &measured, &[false; SONARS], rules);
            for (slot, &count) in vector.iter().enumerate() {
                sums[slot] += u64::from(count);
                confirmed[slot] += usize::from(count > 0);
            }
        }
        let sensors = (0..SONARS).map(|slot| {
            let of = |wanted: fn(&Reading) -> bool| {
                let readings = recording.rows.iter().map(|row| &row.readings[slot]);
                readings.filter(|reading| wanted(reading)).count()
            };
            let equal = runs(&recording.rows, slot, |reading| {
                matches!(reading, Reading::Echo(_))
            });
            let silent = runs(&recording.rows, slot, |reading| {
                *reading == Reading::NoObject
            });
            let half = Millimeters::new(ring.config().range.get() / 2);
            SensorSummary {
                sensor: slot as u8 + 1,
                echoes: of(|reading| matches!(reading, Reading::Echo(_))),
                no_object: of(|reading| *reading == Reading::NoObject),
                missing: of(|reading| matches!(reading, Reading::Missing(_))),
                confirmed: confirmed[slot],
                mean_intersections: sums[slot] as f64 / recording.rows.len().max(1) as f64,
                longest_equal: equal
                    .iter()
                    .max_by_key(|run| run.len())
                    .map(|run| frozen(run, slot)),
                stuck: long(&equal)
                    .filter(|run| neighbours(slot).iter().all(|&other| moved(run, other)))
                    .map(|run| frozen(run, slot))
                    .collect(),
                blind: long(&silent)
                    .filter(|run| neighbours(slot).iter().all(|&other| near(run, other, half)))
                    .map(|run| frozen(run, slot))
                    .collect(),
            }
        });
        let possible = |direct: bool| {
            // All sonars have the same number.
            let sensor = ring.sensors().next();
            let overlaps = sensor.map(|sensor| independent_overlaps(ring, sensor));
            let is_direct = |o: &Overlap| o.own.order() == 0 && o.other.order() == 0;
            let counted = overlaps.into_iter().flatten();
            counted.filter(|o| !direct || is_direct(o)).count() as u32
        };
        Self {
            sensors: sensors.collect(),
            overlaps: (possible(true), possible(false)),
        }
    }
}

/// A row's direct echoes: a path length is twice the distance.
fn direct(row: &Row) -> Echoes<SONARS> {
    let mut echoes = Echoes::unknown();
    for (slot, &reading) in row.readings.iter().enumerate() {
        let reading = match reading {
            Reading::Echo(distance) => Reading::Echo(Millimeters::new(2 * distance.get())),
            other => other,
        };
        if let Some(sensor) = SensorId::from_slot(slot) {
            let set = echoes.set(sensor, sensor, reading);
            debug_assert!(set.is_ok(), "a sonar has a path to itself");
        }
    }
    echoes
}

/// The runs of rows in which a sonar's reading is constant and of the given kind.
fn runs(rows: &[Row], slot: usize, counts: fn(&Reading) -> bool) -> Vec<&[Row]> {
    let same = rows.chunk_by(|a, b| a.readings[slot] == b.readings[slot]);
    same.filter(|run| counts(&run[0].readings[slot])).collect()
}

fn long<'a>(runs: &'a [&'a [Row]]) -> impl Iterator<Item = &'a [Row]> {
    let runs = runs.iter().copied();
    runs.filter(|run| run.len() >= DirectAssessment::LEAST_ROWS)
}

const fn neighbours(slot: usize) -> [usize; 2] {
    [(slot + SONARS - 1) % SONARS, (slot + 1) % SONARS]
}

/// Whether a sonar's echoes vary by more than 0.1 m in these rows.
fn moved(run: &[Row], slot: usize) -> bool {
    let echoes = run.iter().filter_map(|row| match row.readings[slot] {
        Reading::Echo(distance) => Some(distance.get()),
        _ => None,
    });
    let (low, high) = echoes.fold((u32::MAX, 0), |(low, high), distance| {
        (low.min(distance), high.max(distance))
    });
    high.saturating_sub(low) > 100
}

/// Whether a sonar has an echo within `limit` in each of these rows.
fn near(run: &[Row], slot: usize, limit: Millimeters) -> bool {
    run.iter()
        .all(|row| matches!(row.readings[slot], Reading::Echo(distance) if distance < limit))
}

fn frozen(run: &[Row], slot: usize) -> FrozenRun {
    FrozenRun {
        from_line: run[0].line,
        to_line: run[run.len() - 1].line,
        rows: run.len(),
        reading_mm: match run[0].readings[slot] {
            Reading::Echo(distance) => Some(distance.get()),
            _ => None,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_ring::RingConfig;

    const RANGE: Millimeters = Millimeters::new(5000);

    fn ring() -> Ring<SONARS> {
        let config = RingConfig {
            range: RANGE,
            ..RingConfig::DEFAULT
        };
        Ring::try_new(config).unwrap()
    }

    fn recording(rows: impl Iterator<Item = [f64; SONARS]>) -> RingRecording {
        let lines = rows.map(|row| row.map(|metres| format!("{metres:.3}")).join(",") + ",Turn\n");
        RingRecording::parse(lines.collect::<String>().as_bytes(), RANGE)
    }

    #[test]
    fn stuck_and_blind_sonars_are_found_with_their_rows() {
        let rows = (0..40).map(|row| {
            let mut distances = [1.0 + f64::from(row) * 0.01; SONARS];
            if (10..30).contains(&row) {
                distances[3] = 0.7;
                distances[11] = 5.0;
            }
            distances
        });
        let recording = recording(rows);
        assert_eq!((recording.rows(), recording.skipped()), (40, 0));
        let assessed = DirectAssessment::of(&recording, &ring(), &RingRules::DEFAULT);
        let run = |reading_mm| FrozenRun {
            from_line: 11,
            to_line: 30,
            rows: 20,
            reading_mm,
        };
        assert_eq!(assessed.sensors[3].stuck, [run(Some(700))]);
        assert_eq!(assessed.sensors[11].blind, [run(None)]);
        let others = assessed
            .sensors
            .iter()
            .filter(|s| ![4, 12].contains(&s.sensor));
        assert!(
            others
                .clone()
                .all(|s| s.stuck.is_empty() && s.blind.is_empty())
        );
        // Equal distances all around: each arc intersects those of all six neighbours, except the frozen ones.
        assert_eq!(assessed.overlaps, (6, 35));
        assert!((assessed.sensors[20].mean_intersections - 6.0).abs() < 1e-9);
        assert_eq!(assessed.sensors[3].confirmed, 20);
    }

    #[test]
    fn lines_that_are_not_rows_are_counted() {
        let sound = ["1.0"; 24].join(",");
        let odd: Vec<_> = ["nan", "inf", "-1"]
            .into_iter()
            .chain(["2.0"; 21])
            .collect();
        let text = format!("{sound}\nmetres\n{}\n\n1,2,3\r\n", odd.join(","));
        let mut bytes = text.into_bytes();
        bytes.extend(b"\xff\xfe\n");
        let recording = RingRecording::parse(&bytes, RANGE);
        assert_eq!((recording.rows(), recording.skipped()), (2, 3));
        let odd = recording.rows[1].readings;
        assert_eq!(odd[0], Reading::Missing(Missing::Implausible));
        assert_eq!(odd[1], Reading::NoObject);
        assert_eq!(odd[2], Reading::Missing(Missing::Implausible));
        assert_eq!(odd[3], Reading::Echo(Millimeters::new(2000)));
    }
}
