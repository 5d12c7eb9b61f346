//! Recordings of real rings: 24 direct distances per row, without cross echoes.
//!
//! With a header, the sonars are the 24 columns of one name with the numbers 1 to 24 or 0 to 23, in any order:
//! `time,US1,US2…`. A unit can be part of a name (`US1_cm`); without one a distance is in metres. Other
//! columns are not used, and noted. Without a header a row has exactly 24 numbers, in metres, and may have words
//! behind them. Columns are separated by commas, semicolons, tabs or blanks. `inf` is no object, `-inf` too near; `nan`, an empty field and a
//! number below 0 are missing; 0 is what [`RingOptions::zero`] says.

use super::acoustics::SONARS;
use crate::export::display_path;
use crate::input::{Column, Fields, InputError, Separator, Text, number};
use crate::quantity::Excerpt;
use crate::replay::{RangeUnit, SkipReason, Skipped, TooManySkipped, ZeroMeans};
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
    notes: Vec<String>,
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
    /// The header does not name 24 sonars.
    #[error("{}:{line}: {problem}", display_path(.path))]
    Header {
        /// The file.
        path: PathBuf,
        /// The line.
        line: u64,
        /// What is wrong, and what to do.
        problem: String,
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
    let format = "expected 24 distances in metres per line, separated by commas, or a header with US1 to US24";
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
            notes: Vec::new(),
        };
        let mut bytes = 0;
        let mut table = Table::default();
        while let Some(line) = text.next()? {
            let row = match line {
                Err(bad) => Err((bad.into(), "is not text".to_owned())),
                Ok(line) => {
                    bytes += line.len() as u64 + 1;
                    let line = line.trim();
                    if line.is_empty() {
                        continue;
                    }
                    match table.header(line, recording.rows.is_empty()) {
                        Ok(true) => continue,
                        Ok(false) if line.starts_with('#') => continue,
                        Ok(false) => table.row(line, options),
                        Err(problem) => {
                            let line = text.number();
                            return Err(RecordingError::Header {
                                path,
                                line,
                                problem,
                            });
                        }
                    }
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
        recording.notes = table.notes;
        let echo = |row: &Row| row.readings.iter().any(|r| matches!(r, Reading::Echo(_)));
        if !recording.rows.iter().any(echo) {
            recording.notes.push(format!(
                "no echo within --range {}: check --range and the units",
                options.range
            ));
        }
        if recording.rows.is_empty() {
            // Rows of numbers are of a ring, if of another number of sonars.
            let numbers = recording.skipped.count(SkipReason::FieldCount) > 0;
            if let Some(foreign) = text.foreign().filter(|_| !numbers) {
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

    /// Returns what was assumed and what was not used, one line each.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }
}

/// Where the distances of a row are.
#[derive(Debug, Clone, PartialEq)]
struct Sonars {
    /// The column of each sonar, and its millimetres a unit.
    places: [(usize, f64); SONARS],
    /// The number of named columns; those behind them have no numbers.
    columns: usize,
}

impl Default for Sonars {
    /// 24 columns of metres.
    fn default() -> Self {
        Self {
            places: core::array::from_fn(|slot| (slot, 1000.0)),
            columns: SONARS,
        }
    }
}

/// The lines of a recording as rows.
#[derive(Debug, Default)]
struct Table {
    sonars: Sonars,
    /// Not known before the header or the first row.
    fields: Option<Fields>,
    notes: Vec<String>,
}

impl Table {
    /// Takes `line` as the header of the rows below it; returns whether it is one, or why it names no 24
    /// sonars.
    fn header(&mut self, line: &str, first: bool) -> Result<bool, String> {
        // Most lines are rows. Names can be numbers alone, but only before the first row.
        let is_digit = |c: char| c.is_ascii_digit() || matches!(c, '-' | '+' | '.');
        if !first && line.starts_with(is_digit) {
            return Ok(false);
        }
        let (separator, mut columns) = Column::all(line);
        while columns
            .last()
            .is_some_and(|column| column.written.is_empty())
        {
            columns.pop();
        }
        let found = match named(&columns, separator) {
            Ok(found) => found,
            // A comment can be about anything.
            Err(_) if line.starts_with('#') => None,
            Err(problem) => return Err(problem),
        };
        let in_order = found.is_none() && first && !line.starts_with('#');
        let sonars = match found {
            Some(sonars) => sonars,
            None if in_order && are_names(&columns, separator) => Sonars::default(),
            None => return Ok(false),
        };
        let unused: Vec<String> = (0..)
            .zip(&columns)
            .filter(|(place, column)| {
                !column.written.is_empty() && sonars.places.iter().all(|(used, _)| used != place)
            })
            .map(|(_, column)| Excerpt::new(&column.written).to_string())
            .collect();
        if !unused.is_empty() {
            let more = unused.len().saturating_sub(8);
            let more = if more > 0 {
                format!(" and {more} more")
            } else {
                String::new()
            };
            let names = unused[..unused.len().min(8)].join(", ");
            self.note(format!("columns that are not used: {names}{more}"));
        }
        self.sonars = sonars;
        // The rows decide what separates them if the line could be a sentence.
        self.fields = (!in_order).then(|| Fields::new(separator));
        if in_order {
            self.note("the columns have no numbers: they are taken as sonars 1 to 24".to_owned());
        }
        Ok(true)
    }

    fn note(&mut self, note: String) {
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }

    /// Parses a row.
    fn row(
        &mut self,
        line: &str,
        options: &RingOptions,
    ) -> Result<[Reading; SONARS], (SkipReason, String)> {
        let sonars = &self.sonars;
        if let Some(fields) = &mut self.fields {
            fields.split(line);
            return row(fields, sonars, options);
        }
        // A comma can be within numbers, and a blank behind commas: the separator is the first that gives 24.
        let all = [
            Separator::Semicolon,
            Separator::Tab,
            Separator::Comma,
            Separator::Blanks,
        ];
        for separator in all {
            let mut fields = Fields::new(separator);
            fields.split(line);
            if let Ok(readings) = row(&fields, sonars, options) {
                self.fields = Some(fields);
                return Ok(readings);
            }
        }
        let mut fields = Fields::new(Separator::of(line));
        fields.split(line);
        row(&fields, sonars, options)
    }
}

/// Whether a line has names alone, at least 24.
fn are_names(columns: &[Column], separator: Separator) -> bool {
    columns.len() >= SONARS
        && columns
            .iter()
            .all(|column| number(&column.written, separator).is_none())
}

/// The sonars that a line names by numbers; `None` if it does not, an error if they are other than 24.
fn named(columns: &[Column], separator: Separator) -> Result<Option<Sonars>, String> {
    let is_row = columns
        .iter()
        .any(|column| number(&column.written, separator).is_some());
    let mut stems: Vec<&str> = Vec::new();
    for column in columns {
        if column.number.is_some() && !stems.contains(&column.stem.as_str()) {
            stems.push(&column.stem);
        }
    }
    let of = |stem: &str| -> Vec<(usize, &Column, u32)> {
        let all = (0..).zip(columns);
        let mut of: Vec<_> = all
            .filter(|(_, column)| column.stem == stem)
            .filter_map(|(place, column)| Some((place, column, column.number?)))
            .collect();
        of.sort_by_key(|&(_, _, number)| number);
        of
    };
    let is_full = |of: &[(usize, &Column, u32)]| {
        let first = of.first().map_or(0, |&(_, _, number)| number);
        let numbers = of.iter().map(|&(_, _, number)| number);
        first <= 1 && of.len() == SONARS && numbers.eq(first..first + SONARS as u32)
    };
    let full: Vec<_> = stems
        .iter()
        .map(|stem| of(stem))
        .filter(|of| is_full(of))
        .collect();
    if is_row && full.first().is_none_or(|of| !of[0].1.stem.is_empty()) {
        return Ok(None);
    }
    let advice =
        "expected 24 columns of one name with the numbers 1 to 24 or 0 to 23, such as US1 to US24";
    match &full[..] {
        [sonars] => {
            let mut found = Sonars {
                columns: columns.len(),
                ..Sonars::default()
            };
            for (slot, &(place, column, _)) in found.places.iter_mut().zip(sonars) {
                let unit = column.unit.map_or(Some(RangeUnit::Meters), RangeUnit::of);
                let unit = unit.ok_or_else(|| {
                    let name = Excerpt::new(&column.written);
                    format!(
                        "the column {name} has no unit of a distance: name it {}{}_m",
                        column.stem, sonars[0].2
                    )
                })?;
                *slot = (place, unit.millimetres());
            }
            Ok(Some(found))
        }
        [one, other, ..] => {
            let name = |of: &[(usize, &Column, u32)]| Excerpt::new(&of[0].1.written).to_string();
            Err(format!(
                "two names have 24 columns, {} and {}: remove the columns of one",
                name(one),
                name(other)
            ))
        }
        [] => {
            let longest = stems.iter().map(|stem| of(stem)).max_by_key(Vec::len);
            // A sentence can have such a word or two.
            match longest.filter(|of| of.len() > 2 && 2 * of.len() >= columns.len()) {
                Some(of) => Err(format!(
                    "{} columns from {} to {} are not 24 sonars: {advice}",
                    of.len(),
                    Excerpt::new(&of[0].1.written),
                    Excerpt::new(&of[of.len() - 1].1.written)
                )),
                None => Ok(None),
            }
        }
    }
}

/// Parses a row: as many columns as are named, or 24; behind them words alone.
fn row(
    fields: &Fields,
    sonars: &Sonars,
    options: &RingOptions,
) -> Result<[Reading; SONARS], (SkipReason, String)> {
    let mut readings = [Reading::Missing(Missing::Timeout); SONARS];
    let behind = (sonars.columns..fields.len()).any(|place| fields.number(place).is_some());
    let mut counted = (0..fields.len()).filter(|&place| fields.number(place).is_some());
    if (behind || fields.len() < sonars.columns) && counted.next().is_some() {
        let found = fields.len();
        let why = if *sonars == Sonars::default() {
            format!("has {found} columns where there are 24 sonars")
        } else {
            format!(
                "has {found} columns where the header has {}",
                sonars.columns
            )
        };
        return Err((SkipReason::FieldCount, why));
    }
    for (&(place, unit_mm), reading) in sonars.places.iter().zip(&mut readings) {
        let field = fields.get(place).unwrap_or_default();
        if field.is_empty() && place < fields.len() {
            continue;
        }
        let number = fields.number(place).ok_or_else(|| {
            let field = Excerpt::new(field);
            let why = format!("'{field}' in column {} is not a number", place + 1);
            (SkipReason::NotANumber, why)
        })?;
        let mm = number * unit_mm;
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
    /// Rows with an object too near to measure.
    pub too_near: usize,
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
                too_near: of(|reading| *reading == Reading::TooNear),
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

    /// The readings of the first row, in millimetres.
    fn first_row(text: &str) -> Vec<u32> {
        let recording = RingRecording::parse(text.as_bytes(), &OPTIONS).unwrap();
        let echo = |reading: &Reading| match reading {
            Reading::Echo(distance) => distance.get(),
            other => panic!("{other:?}"),
        };
        recording.rows[0].readings.iter().map(echo).collect()
    }

    /// What a recording is refused with.
    fn refusal(text: &str) -> String {
        let line = RingRecording::parse(text.as_bytes(), &OPTIONS)
            .unwrap_err()
            .to_string();
        assert_eq!(line.lines().count(), 1, "{line}");
        line
    }

    fn joined(items: impl IntoIterator<Item = String>, separator: &str) -> String {
        items.into_iter().collect::<Vec<_>>().join(separator)
    }

    #[test]
    fn names_say_which_column_a_sonar_has() {
        let expected: Vec<u32> = (1..=24).map(|sonar| sonar * 100).collect();
        let metres = |sonar: u32| format!("{}", f64::from(sonar) / 10.0);
        let up = joined((1..=24).map(metres), ",");
        let down = joined((1..=24).rev().map(metres), ",");
        let names = |numbers: &mut dyn Iterator<Item = u32>, end: &str| {
            joined(numbers.map(|sonar| format!("US{sonar}{end}")), ",")
        };
        let ordered = names(&mut (1..=24), "");
        let mut by_text: Vec<u32> = (1..=24).collect();
        by_text.sort_by_key(u32::to_string);
        let sorted = names(&mut by_text.iter().copied(), "");
        let sorted_row = joined(by_text.iter().copied().map(metres), ",");
        let tens = joined((1..=24).map(|sonar| (sonar * 10).to_string()), ",");
        let hundreds = joined((1..=24).map(|sonar| (sonar * 100).to_string()), ",");
        for text in [
            format!("time,{ordered}\n17,{up}\n"),
            format!("{ordered},time,class\n{up},17,Turn\n"),
            format!("{}\n{down}\n", names(&mut (1..=24).rev(), "")),
            format!("# {}\n{down}\n", names(&mut (1..=24).rev(), "")),
            format!("{sorted}\n{sorted_row}\n"),
            format!("{}\n{up}\n", names(&mut (0..24), "")),
            format!("{}\n{tens}\n", names(&mut (1..=24), "_cm")),
            format!("{}\n{hundreds}\n", names(&mut (1..=24), " [mm]")),
            format!(
                "t,{}\n9,{down}\n",
                joined((1..=24).rev().map(|n| n.to_string()), ",")
            ),
        ] {
            assert_eq!(first_row(&text), expected, "{text}");
        }
        let noted = RingRecording::parse(format!("time,{ordered}\n17,{up}\n").as_bytes(), &OPTIONS);
        assert_eq!(noted.unwrap().notes(), ["columns that are not used: time"]);
        let numbered = joined((1..=24).map(|n| n.to_string()), ",") + "\n" + &up;
        let recording = RingRecording::parse(numbered.as_bytes(), &OPTIONS).unwrap();
        assert_eq!(recording.rows(), 1);
        // A second header holds for the rows below it.
        let twice = format!(
            "{ordered}\n{up}\n{}\n{down}\n",
            names(&mut (1..=24).rev(), "")
        );
        let recording = RingRecording::parse(twice.as_bytes(), &OPTIONS).unwrap();
        assert_eq!(recording.rows[0].readings, recording.rows[1].readings);
        assert_eq!(recording.skipped().total(), 0);
    }

    #[test]
    fn names_of_other_than_24_sonars_are_refused() {
        let names = |of: &str, count: usize| joined((1..=count).map(|n| format!("{of}{n}")), ",");
        for (header, word) in [
            (names("US", 23), "recording:1: 23 columns from US1 to US23"),
            (names("V", 25), "recording:1: 25 columns from V1 to V25"),
            (names("US", 24) + ",US3", "recording:1: 25 columns"),
            (names("US", 24) + "," + &names("IR", 24), "US1 and IR1"),
            (names("US", 24).replace(',', "_deg,"), "US1_deg has no unit"),
        ] {
            let line = refusal(&format!("{header}\n{}\n", ["1"; 24].join(",")));
            assert!(line.contains(word), "{line}");
        }
    }

    #[test]
    fn names_without_numbers_are_in_order() {
        let names = joined(('a'..='x').map(String::from), ",");
        for (header, row) in [
            (names.clone(), "1"),
            (names + ",class", "1"),
            ("a ring of sonars in a room ".repeat(4), "1"),
        ] {
            let text = format!("{header}\n{},Turn\n", [row; 24].join(","));
            let recording = RingRecording::parse(text.as_bytes(), &OPTIONS).unwrap();
            assert_eq!(recording.rows(), 1);
            let last = recording.notes().last().unwrap();
            assert_eq!(
                last,
                "the columns have no numbers: they are taken as sonars 1 to 24"
            );
        }
        let shifted = format!("{}\n{}\n", ["n"; 25].join(","), ["1"; 25].join(","));
        assert!(refusal(&shifted).contains("has 25 columns"));
        // Comments and sentences are no header.
        let row = ["1,5"; 24].join("\t") + "\tTurn\tleft";
        let text = format!("# sonars s1 s2 s3 s4\n{row}\n{}\n", ["nan"; 24].join("\t"));
        assert_eq!(first_row(&text), [1500; 24]);
    }

    #[test]
    fn a_row_without_names_has_exactly_24_numbers() {
        for count in [4, 8, 23, 25, 26] {
            for separator in [",", " ", ";"] {
                let line = refusal(&format!("{}\n", vec!["1.5"; count].join(separator)));
                let expected =
                    format!("recording:1: has {count} columns where there are 24 sonars");
                assert!(line.starts_with(&expected), "{line}");
            }
        }
    }

    #[test]
    fn a_decimal_comma_needs_no_names() {
        for separator in [";", "\t", "; ", " "] {
            let row = ["1,5"; 24].join(separator);
            assert_eq!(
                first_row(&format!("{row}\n{row}\n")),
                [1500; 24],
                "{separator:?}"
            );
        }
        for separator in [",", ", ", ",\t"] {
            assert_eq!(
                first_row(&["1.5"; 24].join(separator)),
                [1500; 24],
                "{separator:?}"
            );
        }
    }

    #[test]
    fn too_near_readings_are_counted() {
        let rows = [
            ["-inf"; 24].join(","),
            ["1"; 24].join(","),
            ["-inf"; 24].join(","),
        ];
        let recording = RingRecording::parse(rows.join("\n").as_bytes(), &OPTIONS).unwrap();
        let assessed = DirectAssessment::of(&recording, &ring(), &RingRules::DEFAULT);
        assert!(assessed.sensors.iter().all(|sensor| sensor.too_near == 2));
    }

    #[test]
    fn rows_without_an_echo_are_noted() {
        let row = ["150"; 24].join(",");
        let recording = RingRecording::parse(row.as_bytes(), &OPTIONS).unwrap();
        assert_eq!(
            recording.notes(),
            ["no echo within --range 5000mm: check --range and the units"]
        );
    }

    proptest::proptest! {
        #[test]
        fn no_bytes_panic(bytes: Vec<u8>, names in "[USa-c0-9,; _#\n.]{0,300}") {
            let _ = RingRecording::parse(&bytes, &OPTIONS);
            let _ = RingRecording::parse(names.as_bytes(), &OPTIONS);
        }
    }
}
