//! Recordings of real rings: 24 direct distances per row, without cross echoes.
//!
//! Distances in metres, separated by commas, semicolons, tabs or blanks; further columns are ignored, as is
//! a line of names before the first row. `inf` is no object, `-inf` too near; `nan`, an empty field and a
//! number below 0 are missing; 0 is what [`RingOptions::zero`] says.

use super::acoustics::SONARS;
use crate::export::display_path;
use crate::input::{Fields, InputError, Separator, Text};
use crate::quantity::Excerpt;
use crate::replay::{SkipReason, Skipped, TooManySkipped, ZeroMeans};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Missing, Reading};
use certainty_core::units::Millimeters;
use certainty_ring::{
    Distances, Echoes, Overlap, Ring, RingRules, independent_overlaps, intersection_based,
};
use core::cell::Cell;
use serde::Serialize;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// How to read a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RingOptions {
    /// Distances of this or more are *no object*.
    pub range: Millimeters,
    /// The meaning of a reading of 0.
    pub zero: ZeroMeans,
    /// Whether a file is read of which more than a twentieth of the lines are no rows.
    pub lenient: bool,
}

/// Largest accepted recording, in bytes of text.
const MOST_BYTES: u64 = 64 << 20;

/// A recording: rows of 24 direct readings.
#[derive(Debug, Clone, PartialEq)]
pub struct RingRecording {
    rows: Vec<Row>,
    skipped: Skipped,
    first_skipped: Option<(u64, String)>,
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
    /// The file cannot be read as text.
    #[error(transparent)]
    Input(#[from] InputError),
    /// Too many lines are no rows.
    #[error("{}:{}: {too_many}", display_path(.path), .too_many.first.line)]
    TooManySkipped {
        /// The file.
        path: PathBuf,
        /// How many.
        too_many: TooManySkipped,
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
        first: Option<(u64, String)>,
    },
}

/// The part of the error after the file's name if it has no rows.
fn no_rows(first: Option<&(u64, String)>) -> String {
    let format = "expected 24 distances in metres per line, separated by commas";
    match first {
        Some((line, why)) => format!(":{line}: {why}; {format}"),
        None => format!(": is empty; {format}"),
    }
}

impl RingRecording {
    /// Reads the recording at `path`, or from stdin if it is `-`; plain or packed.
    ///
    /// # Errors
    ///
    /// [`RecordingError`] if the file cannot be read, is too long, has no rows or too many other lines.
    pub fn load(path: &Path, options: &RingOptions) -> Result<Self, RecordingError> {
        let done = Cell::new(0);
        let (text, _) = Text::open(path, "a recording", &done)?;
        Self::read(text, options)
    }

    /// Reads the rows; lines that are not rows are skipped and counted.
    fn read(mut text: Text<'_>, options: &RingOptions) -> Result<Self, RecordingError> {
        let path = text.path().to_owned();
        let mut recording = Self {
            rows: Vec::new(),
            skipped: Skipped::default(),
            first_skipped: None,
        };
        let mut fields: Option<Fields> = None;
        let mut bytes = 0;
        let mut named = false;
        while let Some(line) = text.next()? {
            let row = match line {
                Err(bad) => Err((bad.into(), "is not text".to_owned())),
                Ok(line) => {
                    bytes += line.len() as u64 + 1;
                    let line = line.trim();
                    if line.is_empty() || line.starts_with('#') {
                        continue;
                    }
                    let fields = fields.get_or_insert_with(|| Fields::new(Separator::of(line)));
                    fields.split(line);
                    // The first line may name the columns.
                    if !named && recording.rows.is_empty() && names(fields) {
                        named = true;
                        continue;
                    }
                    row(fields, options)
                }
            };
            if bytes > MOST_BYTES {
                return Err(RecordingError::TooLong { path });
            }
            let number = text.number();
            match row {
                Ok(readings) => {
                    recording.rows.push(Row {
                        line: usize::try_from(number).unwrap_or(usize::MAX),
                        readings,
                    });
                    text.mark_used();
                }
                Err((reason, why)) => {
                    recording.skipped.add(number, reason);
                    recording.first_skipped.get_or_insert((number, why));
                }
            }
        }
        if recording.rows.is_empty() {
            if let Some(foreign) = text.foreign() {
                return Err(foreign.into());
            }
            let first = recording.first_skipped;
            return Err(RecordingError::NoRows { path, first });
        }
        match recording.skipped.too_many(recording.rows.len() as u64) {
            Some(too_many) if !options.lenient => {
                Err(RecordingError::TooManySkipped { path, too_many })
            }
            _ => Ok(recording),
        }
    }

    /// Reads a recording from arbitrary bytes.
    ///
    /// # Errors
    ///
    /// [`RecordingError`] as for [`Self::load`].
    pub fn parse(bytes: &[u8], options: &RingOptions) -> Result<Self, RecordingError> {
        Self::read(
            Text::new(Path::new("recording"), "a recording", bytes)?,
            options,
        )
    }

    /// Returns the number of rows.
    #[must_use]
    pub const fn rows(&self) -> usize {
        self.rows.len()
    }

    /// Returns the lines that are not rows.
    #[must_use]
    pub const fn skipped(&self) -> &Skipped {
        &self.skipped
    }
}

/// Whether a line has names alone.
fn names(fields: &Fields) -> bool {
    let numbers = (0..fields.len()).any(|place| fields.number(place).is_some());
    fields.len() >= SONARS && !numbers
}

/// Parses a row: 24 numbers; further columns are ignored.
fn row(fields: &Fields, options: &RingOptions) -> Result<[Reading; SONARS], (SkipReason, String)> {
    let mut readings = [Reading::Missing(Missing::Timeout); SONARS];
    for (place, reading) in readings.iter_mut().enumerate() {
        let field = fields.get(place).ok_or_else(|| {
            let found = fields.len();
            let why = format!("has {found} columns where there are 24 sonars");
            (SkipReason::FieldCount, why)
        })?;
        if field.is_empty() {
            continue;
        }
        let number = fields.number(place).ok_or_else(|| {
            let field = Excerpt::new(field);
            let why = format!("'{field}' in column {} is not a number", place + 1);
            (SkipReason::NotANumber, why)
        })?;
        let mm = number * 1000.0;
        *reading = if number == f64::NEG_INFINITY {
            Reading::TooNear
        } else if number.is_nan() || number < 0.0 {
            Reading::Missing(Missing::Implausible)
        } else if number == 0.0 {
            options.zero.reading()
        } else if mm >= f64::from(options.range.get()) {
            Reading::NoObject
        } else if mm < 0.5 {
            Reading::TooNear
        } else {
            Reading::Echo(Millimeters::new(mm.round() as u32))
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

    const OPTIONS: RingOptions = RingOptions {
        range: RANGE,
        zero: ZeroMeans::NoObject,
        lenient: false,
    };

    fn ring() -> Ring<SONARS> {
        let config = RingConfig {
            range: RANGE,
            ..RingConfig::DEFAULT
        };
        Ring::try_new(config).unwrap()
    }

    fn recording(rows: impl Iterator<Item = [f64; SONARS]>) -> RingRecording {
        let lines = rows.map(|row| row.map(|metres| format!("{metres:.3}")).join(",") + ",Turn\n");
        RingRecording::parse(lines.collect::<String>().as_bytes(), &OPTIONS).unwrap()
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
        assert_eq!((recording.rows(), recording.skipped().total()), (40, 0));
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
        let odd: Vec<_> = ["nan", "inf", "-1", "", "0", "-inf"]
            .into_iter()
            .chain(["2.0"; 18])
            .collect();
        let text = format!("{sound}\nmetres\n{}\n\n1,2,3\r\n", odd.join(","));
        let mut bytes = text.into_bytes();
        bytes.extend(b"\xff\xfe\n");
        let error = RingRecording::parse(&bytes, &OPTIONS)
            .unwrap_err()
            .to_string();
        assert!(error.starts_with("recording:2: 3 of 5 lines"), "{error}");
        let lenient = RingOptions {
            lenient: true,
            ..OPTIONS
        };
        let recording = RingRecording::parse(&bytes, &lenient).unwrap();
        assert_eq!((recording.rows(), recording.skipped().total()), (2, 3));
        let odd = recording.rows[1].readings;
        assert_eq!(odd[0], Reading::Missing(Missing::Implausible));
        assert_eq!(odd[1], Reading::NoObject);
        assert_eq!(odd[2], Reading::Missing(Missing::Implausible));
        assert_eq!(odd[3], Reading::Missing(Missing::Timeout));
        assert_eq!((odd[4], odd[5]), (Reading::NoObject, Reading::TooNear));
        assert_eq!(odd[6], Reading::Echo(Millimeters::new(2000)));
    }

    #[test]
    fn rows_of_spreadsheets_are_read() {
        let names = (1..=24)
            .map(|sonar| format!("US{sonar}"))
            .collect::<Vec<_>>();
        for (separator, number) in [(";", "1,5"), ("\t", "1.5"), (" ", "1.5"), (",", "1.5")] {
            let rows = [names.join(separator), [number; 24].join(separator)];
            let text = rows.join("\r\n");
            let recording = RingRecording::parse(text.as_bytes(), &OPTIONS).unwrap();
            let echo = Reading::Echo(Millimeters::new(1500));
            assert_eq!(recording.rows[0].readings, [echo; SONARS], "{separator:?}");
            assert_eq!(recording.skipped().total(), 0);
        }
    }
}
