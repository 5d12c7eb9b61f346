//! Recordings as CSV: a beam a line, or a pose and several ranges a line.
//!
//! The *readings* form is the interchange format of this project, [`HEADER`]. The *wide* form has time,
//! pose (x, y and heading) and n numbered ranges in a line, such as `t_ms,x_m,y_m,heading_rad,range0_m,range1_m`.
//! [`Layout`] is what a header says of its columns.
//!
//! A value is a distance, or says why there is none: `none` and `inf` are no object, `near` and `-inf` too
//! near; `missing`, `nan`, an empty field and numbers below 0 are missing. 0 is what [`ZeroMeans`](super::recording::ZeroMeans) says.

use super::layout::{Beams, CsvOptions, Layout, TURN, lacking};
use super::recording::{LineKind, RecordedBeam, SkipReason, TimeUnit};
use crate::input::{Fields, Separator, number};
use crate::quantity::{self, Excerpt};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Missing, Reading};
use certainty_core::units::{BinaryAngle, Millimeters, Point, Ticks};

/// The first line of a readings file.
pub const HEADER: &str = "t_ms,sensor,x_mm,y_mm,bearing_mdeg,reading";

/// Why a line of a CSV has no beams.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum CsvError {
    /// The line alone cannot be used.
    Skip(SkipReason),
    /// The file cannot be read; what to do.
    File(String),
}

impl From<SkipReason> for CsvError {
    fn from(reason: SkipReason) -> Self {
        Self::Skip(reason)
    }
}

/// The beams' opening angle if `line` is a comment such as `# beam-width: 20deg`, or why it is not an
/// angle.
///
/// No column has the width of a beam; a file has it once.
pub(super) fn beam_width(line: &str) -> Option<Result<BinaryAngle, SkipReason>> {
    let note = line.strip_prefix('#')?.trim().strip_prefix("beam-width:")?;
    Some(quantity::opening(note.trim()).map_err(|_| SkipReason::BadBeamWidth))
}

/// The slots of the sensors that a file names, in the order in which they appear.
#[derive(Debug)]
struct Slots {
    /// One more than the slot of each id; 0 for an id that did not appear.
    slot_of: Vec<u8>,
    ids: Vec<u16>,
}

impl Slots {
    fn sensor(&mut self, id: u16) -> Result<SensorId, CsvError> {
        let slot = &mut self.slot_of[usize::from(id)];
        if *slot == 0 {
            let next = u8::try_from(self.ids.len() + 1).map_err(|_| {
                CsvError::File("more than 255 different sensors: split the recording".to_owned())
            })?;
            *slot = next;
            self.ids.push(id);
        }
        SensorId::try_new(*slot).ok_or(CsvError::Skip(SkipReason::BadSensor))
    }
}

/// Reads one CSV, line after line.
#[derive(Debug)]
pub(super) struct CsvLog {
    options: CsvOptions,
    /// Whether the file has a header; without one its columns are those of [`HEADER`].
    has_header: bool,
    layout: Option<Layout>,
    header: String,
    fields: Fields,
    slots: Slots,
    /// The time of the recording's clock at 0, in milliseconds.
    clock_start: Option<f64>,
    last_ms: f64,
    zeros: u64,
    notes: Vec<String>,
}

/// What is known at the end of a CSV.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct CsvSummary {
    /// The sensors' numbers in the file, ascending: that of slot 0 first.
    pub(super) names: Vec<u16>,
    pub(super) notes: Vec<String>,
}

impl CsvLog {
    pub(super) fn new(options: CsvOptions, has_header: bool) -> Self {
        Self {
            options,
            has_header,
            layout: None,
            header: String::new(),
            fields: Fields::new(Separator::Comma),
            slots: Slots {
                slot_of: vec![0; 1 << 16],
                ids: Vec::new(),
            },
            clock_start: None,
            last_ms: f64::NEG_INFINITY,
            zeros: 0,
            notes: Vec::new(),
        }
    }

    /// Appends the beams of `line`, if it has any; all or none.
    pub(super) fn line(
        &mut self,
        line: &str,
        beams: &mut Vec<RecordedBeam>,
    ) -> Result<LineKind, CsvError> {
        let line = line.trim();
        if line.is_empty() || (self.layout.is_some() && line == self.header) {
            return Ok(LineKind::Nothing);
        }
        if self.take_header(line)? {
            return Ok(LineKind::Nothing);
        }
        if line.starts_with(['#', '%']) {
            return Ok(LineKind::Nothing);
        }
        if self.layout.is_some()
            && !line.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '-' | '+' | '.'))
            && let Some(lacks) = lacking(line)
        {
            return Err(CsvError::File(format!(
                "a second header, which has no column of {lacks}: correct it, or split the recording here"
            )));
        }
        if self.layout.is_none() {
            if self.has_header {
                return Err(CsvError::Skip(SkipReason::BeforeHeader));
            }
            self.take_header(HEADER)?;
        }
        let before = beams.len();
        let taken = self.row(line, beams);
        if taken.is_err() {
            beams.truncate(before);
        }
        taken
    }

    /// Takes `line` as the header of the lines below it, if it is one.
    ///
    /// Recordings that were put together have several: each must have the sensors of the one before.
    fn take_header(&mut self, line: &str) -> Result<bool, CsvError> {
        match Layout::of(line, &self.options) {
            None => Ok(false),
            Some(Err(problem)) => Err(CsvError::File(problem)),
            Some(Ok((separator, mut layout, notes))) => {
                if let Some(before) = &self.layout {
                    if !before.beams.same_sensors(&layout.beams) {
                        return Err(CsvError::File(
                            "a second header with other sensors: split the recording here"
                                .to_owned(),
                        ));
                    }
                    // The clock is the same one.
                    layout.time_unit = layout.time_unit.or(before.time_unit);
                }
                self.fields = Fields::new(separator);
                self.layout = Some(layout);
                self.header = line.to_owned();
                for note in notes {
                    if !self.notes.contains(&note) {
                        self.notes.push(note);
                    }
                }
                Ok(true)
            }
        }
    }

    fn row(&mut self, line: &str, beams: &mut Vec<RecordedBeam>) -> Result<LineKind, CsvError> {
        let Some(layout) = &mut self.layout else {
            return Err(CsvError::Skip(SkipReason::BeforeHeader));
        };
        let fields = &mut self.fields;
        fields.split(line);
        // Spreadsheets add separators at the end.
        let blank = |index: usize| fields.get(index).is_none_or(str::is_empty);
        if fields.len() < layout.columns || !(layout.columns..fields.len()).all(blank) {
            return Err(CsvError::Skip(SkipReason::FieldCount));
        }
        let value = |place: usize| fields.number(place).ok_or(SkipReason::NotANumber);
        let time = value(layout.time)?;
        let unit = *layout.time_unit.get_or_insert_with(|| {
            let unit = TimeUnit::guess(time);
            self.notes.push(format!(
                "the column {} has no unit and is taken as {unit}: --time-unit s, ms, us or ns says it",
                Excerpt::new(&layout.time_name)
            ));
            unit
        });
        let ms = (time * unit.milliseconds()).round();
        let (at, start) = ticks(ms, self.clock_start)?;
        let (x, y) = (value(layout.x)?, value(layout.y)?);
        if layout.pose_assumed && x.abs().max(y.abs()) > FARTHEST_ASSUMED_M {
            return Err(CsvError::File(format!(
                "a pose at {x}, {y} without a unit: give --pose-unit mm, cm or m"
            )));
        }
        let origin = Point::from_mm(coordinate(x * layout.x_mm)?, coordinate(y * layout.y_mm)?);
        let heading = value(layout.heading)?;
        if layout.heading_assumed && heading.abs() > MOST_ASSUMED_RAD {
            return Err(CsvError::File(format!(
                "a heading of {heading} without a unit: give --heading-unit deg or rad"
            )));
        }
        let heading_mdeg = heading * layout.heading_mdeg;
        if !heading_mdeg.is_finite() {
            return Err(CsvError::Skip(SkipReason::BadPose));
        }
        let mut zeros = 0;
        let mut beam = |sensor, mdeg: f64, place: usize, mm: f64| -> Result<(), CsvError> {
            let text = fields.get(place).unwrap_or_default();
            let reading = reading(text, fields.separator(), mm, &self.options, &mut zeros)?;
            beams.push(RecordedBeam {
                at,
                sensor,
                origin,
                bearing: nearest_angle(mdeg),
                reading,
            });
            Ok(())
        };
        match &layout.beams {
            Beams::One {
                sensor,
                reading,
                mm,
            } => {
                let id = value(*sensor)?;
                if !(0.0..=65535.0).contains(&id) || id.fract() != 0.0 {
                    return Err(CsvError::Skip(SkipReason::BadSensor));
                }
                // Parsed first: a line that is left out names no sensor.
                let first = SensorId::new(1);
                beam(first, heading_mdeg, *reading, *mm)?;
                let sensor = self.slots.sensor(id as u16)?;
                if let Some(beam) = beams.last_mut() {
                    beam.sensor = sensor;
                }
            }
            Beams::Wide(columns) => {
                for column in columns {
                    let sensor = self.slots.sensor(column.sensor)?;
                    beam(
                        sensor,
                        heading_mdeg + column.aside_mdeg,
                        column.place,
                        column.mm,
                    )?;
                }
            }
        }
        self.zeros += zeros;
        self.clock_start = Some(start);
        let backward = ms < self.last_ms;
        self.last_ms = ms;
        Ok(LineKind::Beams { backward })
    }

    /// Numbers the sensors of `beams` in the order of their numbers in the file.
    pub(super) fn finish(mut self, beams: &mut [RecordedBeam]) -> CsvSummary {
        let mut names = self.slots.ids.clone();
        names.sort_unstable();
        if names != self.slots.ids {
            let slots: Vec<SensorId> = self
                .slots
                .ids
                .iter()
                .filter_map(|id| SensorId::from_slot(names.binary_search(id).ok()?))
                .collect();
            for beam in beams {
                beam.sensor = slots[beam.sensor.slot()];
            }
        }
        if self.zeros > 0 {
            self.notes.push(format!(
                "{} readings of 0 are taken as {}",
                self.zeros, self.options.zero
            ));
        }
        CsvSummary {
            names,
            notes: self.notes,
        }
    }
}

/// The farthest pose, in metres, of a column whose unit is assumed.
const FARTHEST_ASSUMED_M: f64 = 1000.0;

/// The largest heading, in radians, of a column whose unit is assumed.
const MOST_ASSUMED_RAD: f64 = 6.3;

/// The instant `ms` on the recording's clock, and the clock's start.
///
/// The clock starts at 0, or at the first time if that does not fit 32 bits, as milliseconds since 1970
/// do not; then an earlier time is the start.
fn ticks(ms: f64, start: Option<f64>) -> Result<(Ticks, f64), SkipReason> {
    const MOST: f64 = u32::MAX as f64;
    const EXACT: f64 = 9_007_199_254_740_992.0; // 2^53
    if !ms.is_finite() || ms.abs() > EXACT {
        return Err(SkipReason::BadTime);
    }
    let start = start.unwrap_or(if ms > MOST { ms } else { 0.0 });
    let since = if start > 0.0 {
        (ms - start).max(0.0)
    } else {
        ms
    };
    if !(0.0..=MOST).contains(&since) {
        return Err(SkipReason::BadTime);
    }
    Ok((Ticks::new(since as u32), start))
}

/// A coordinate that a [`Point`] can hold, rounded to the nearest millimetre.
fn coordinate(mm: f64) -> Result<i32, SkipReason> {
    if mm.is_nan() {
        return Err(SkipReason::BadPose);
    }
    let mm = mm.round();
    if mm.abs() > f64::from(Point::LIMIT) {
        return Err(SkipReason::OutOfReach);
    }
    Ok(mm as i32)
}

/// The step of an angle that is nearest to so many millidegrees, any number of turns.
fn nearest_angle(mdeg: f64) -> BinaryAngle {
    let steps = (mdeg.rem_euclid(TURN) / TURN * 65536.0 + 0.5).floor();
    // At most 65536, which is the full turn and wraps to zero.
    BinaryAngle::from_bits((steps as u32 & 0xFFFF) as u16)
}

/// Parses a reading of which a unit has `mm` millimetres; counts those of 0.
fn reading(
    text: &str,
    separator: Separator,
    mm: f64,
    options: &CsvOptions,
    zeros: &mut u64,
) -> Result<Reading, SkipReason> {
    let is = |words: &[&str]| words.iter().any(|word| text.eq_ignore_ascii_case(word));
    if is(&["none"]) {
        return Ok(Reading::NoObject);
    }
    if is(&["near"]) {
        return Ok(Reading::TooNear);
    }
    if is(&["", "missing", "nan", "na", "n/a", "null", "-"]) {
        return Ok(Reading::Missing(Missing::Timeout));
    }
    let value = number(text, separator).ok_or(SkipReason::BadReading)?;
    let distance = value * mm;
    let limit = options
        .max_range
        .map_or(f64::INFINITY, |limit| limit.get().into());
    if value.is_nan() {
        Ok(Reading::Missing(Missing::Timeout))
    } else if value == f64::NEG_INFINITY {
        Ok(Reading::TooNear)
    } else if value < 0.0 {
        Ok(Reading::Missing(Missing::Implausible))
    } else if value == 0.0 {
        *zeros += 1;
        Ok(options.zero.reading())
    } else if value == f64::INFINITY || distance >= limit {
        Ok(Reading::NoObject)
    } else if distance < 0.5 {
        Ok(Reading::TooNear)
    } else if distance.round() > f64::from(u32::MAX) {
        Err(SkipReason::BadReading)
    } else {
        Ok(Reading::Echo(Millimeters::new(distance.round() as u32)))
    }
}

/// Returns `beams` as a readings file, for tests.
///
/// Reading the file gives the same beams, bit for bit, with two exceptions: all kinds of missing
/// readings are written as `missing`, which is read as [`Missing::Timeout`], and an echo at 0 mm is read
/// as [`ZeroMeans`] says. A step of
/// [`BinaryAngle`] is 5.5 millidegrees, so a bearing in whole millidegrees identifies its step.
#[cfg(test)]
pub(super) fn written(beams: &[RecordedBeam]) -> String {
    let mut text = format!("{HEADER}\n");
    for beam in beams {
        let mdeg = (i64::from(beam.bearing.to_bits()) * 360_000 + (1 << 15)) >> 16;
        text += &format!(
            "{},{},{},{},{mdeg},",
            beam.at.get(),
            beam.sensor,
            beam.origin.x_mm(),
            beam.origin.y_mm()
        );
        text += &match beam.reading {
            Reading::Echo(distance) => format!("{}\n", distance.get()),
            Reading::NoObject => "none\n".to_owned(),
            Reading::TooNear => "near\n".to_owned(),
            Reading::Missing(_) => "missing\n".to_owned(),
        };
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::layout::header_of;
    use super::super::recording::{RangeUnit, ZeroMeans};
    use super::*;
    use crate::quantity::FieldOfView;

    fn options() -> CsvOptions {
        CsvOptions {
            max_range: None,
            zero: ZeroMeans::NoObject,
            unit: None,
            pose_unit: None,
            heading_unit: None,
            time_unit: None,
            fov: None,
            start_angle: Some(BinaryAngle::ZERO),
        }
    }

    /// The beams and the summary of `text`, or its first error.
    fn read_with(
        text: &str,
        options: CsvOptions,
    ) -> Result<(Vec<RecordedBeam>, CsvSummary), CsvError> {
        let mut log = CsvLog::new(options, text.lines().any(|line| header_of(line).is_some()));
        let mut beams = Vec::new();
        for line in text.lines() {
            log.line(line, &mut beams)?;
        }
        let summary = log.finish(&mut beams);
        Ok((beams, summary))
    }

    fn read(text: &str) -> Result<(Vec<RecordedBeam>, CsvSummary), CsvError> {
        read_with(text, options())
    }

    fn parse(line: &str, max_range: Option<Millimeters>) -> Result<RecordedBeam, CsvError> {
        let options = CsvOptions {
            max_range,
            ..options()
        };
        read_with(line, options).map(|(beams, _)| beams[0])
    }

    #[test]
    fn line_of_each_kind_is_parsed() {
        let reading = |word: &str| {
            let line = format!("1500,3,-20,40,-90000,{word}");
            parse(&line, None).unwrap()
        };
        let beam = reading("1234");
        assert_eq!(beam.at, Ticks::new(1500));
        assert_eq!(beam.origin, Point::from_mm(-20, 40));
        assert_eq!(beam.bearing.to_bits(), 0xC000);
        let echo = |mm| Reading::Echo(Millimeters::new(mm));
        let missing = Reading::Missing(Missing::Timeout);
        for (word, expected) in [
            ("1234", echo(1234)),
            ("1233.5", echo(1234)),
            ("1e3", echo(1000)),
            ("none", Reading::NoObject),
            ("inf", Reading::NoObject),
            ("Infinity", Reading::NoObject),
            ("0", Reading::NoObject),
            ("near", Reading::TooNear),
            ("-inf", Reading::TooNear),
            ("0.3", Reading::TooNear),
            ("missing", missing),
            ("NaN", missing),
            ("", missing),
            ("-1", Reading::Missing(Missing::Implausible)),
            ("-0.5", Reading::Missing(Missing::Implausible)),
        ] {
            assert_eq!(reading(word).reading, expected, "{word}");
        }
    }

    #[test]
    fn header_comments_and_blanks_have_no_beams() {
        let text = format!("\n# 1,2,3\n{HEADER}\n\n# note\n0,1,0,0,0,5\n{HEADER}\n0,1,0,0,0,6\n");
        assert_eq!(read(&text).unwrap().0.len(), 2);
    }

    #[test]
    fn wrong_field_names_its_reason() {
        for (line, reason) in [
            ("0,1,0,0,0", SkipReason::FieldCount),
            ("0,1,0,0,0,5,6", SkipReason::FieldCount),
            ("0,1,0,0,0,far", SkipReason::BadReading),
            ("0,1,0,0,0,4294967296", SkipReason::BadReading),
            ("0,1.5,0,0,0,5", SkipReason::BadSensor),
            ("0,65536,0,0,0,5", SkipReason::BadSensor),
            ("0,-1,0,0,0,5", SkipReason::BadSensor),
            ("-1,1,0,0,0,5", SkipReason::BadTime),
            ("nan,1,0,0,0,5", SkipReason::BadTime),
            ("1e300,1,0,0,0,5", SkipReason::BadTime),
            ("0,1,268435457,0,0,5", SkipReason::OutOfReach),
            ("0,1,0,-2147483648,0,5", SkipReason::OutOfReach),
            ("0,1,inf,0,0,5", SkipReason::OutOfReach),
            ("0,1,nan,0,0,5", SkipReason::BadPose),
            ("0,1,0,0,nan,5", SkipReason::BadPose),
            ("0,1,x,0,0,5", SkipReason::NotANumber),
        ] {
            assert_eq!(parse(line, None), Err(CsvError::Skip(reason)), "{line}");
        }
    }

    #[test]
    fn far_echoes_become_no_object() {
        let reading = |mm: u32, limit: u32| {
            let line = format!("0,1,0,0,0,{mm}");
            parse(&line, Some(Millimeters::new(limit))).unwrap().reading
        };
        assert_eq!(reading(3999, 4000), Reading::Echo(Millimeters::new(3999)));
        assert_eq!(reading(4000, 4000), Reading::NoObject);
        assert_eq!(reading(u32::MAX, 4000), Reading::NoObject);
    }

    #[test]
    fn headers_of_loggers_mean_the_same() {
        let expected = read(&format!(
            "{HEADER}\n40,2,-100,250,90000,1500\n50,3,0,0,0,none"
        ))
        .unwrap();
        for text in [
            "T_MS, Sensor, X_MM, Y_MM, Bearing_mdeg, Reading\n40, 2, -100, 250, 90000, 1500\n50, 3, 0, 0, 0, none",
            "# note\n\"t_ms\";\"sensor\";\"x_mm\";\"y_mm\";\"bearing_mdeg\";\"reading\"\n40;2;-100;250;90000;1500,0\n50;3;0;0;0;none;",
            "t_ms\tsensor\tx_mm\ty_mm\tbearing_mdeg\treading\n40\t2\t-100\t250\t90000\t1500\n50\t3\t0\t0\t0\tnone",
            "time_s sensor x_m y_m heading_deg distance_cm\n0.04 2 -0.1 0.25 90 150\n0.05 3 0 0 0 none",
            "# reading,bearing_mdeg,y_mm,x_mm,sensor,t_ms\n1500,90000,250,-100,2,40\nnone,0,0,0,3,50",
        ] {
            assert_eq!(read(text), Ok(expected.clone()), "{text}");
        }
    }

    #[test]
    fn further_columns_are_named() {
        let text = "t_ms,battery,sensor,x_mm,y_mm,bearing_mdeg,reading,temp\n40,7.2,2,-100,250,90000,1500,21";
        let (beams, summary) = read(text).unwrap();
        assert_eq!(beams.len(), 1);
        assert_eq!(summary.notes, ["columns that are not used: battery, temp"]);
    }

    #[test]
    fn sensors_keep_their_numbers() {
        let lines = [700, 65535, 0, 700].map(|id| format!("0,{id},0,0,0,{}\n", id + 1));
        let (beams, summary) = read(&format!("{HEADER}\n{}", lines.concat())).unwrap();
        assert_eq!(summary.names, [0, 700, 65535]);
        let slots: Vec<usize> = beams.iter().map(|beam| beam.sensor.slot()).collect();
        assert_eq!(slots, [1, 2, 0, 1]);
        let many = |count: u32| {
            let lines = (0..count).map(|id| format!("0,{},0,0,0,5\n", id * 3));
            read(&format!("{HEADER}\n{}", lines.collect::<String>()))
        };
        assert_eq!(many(255).unwrap().1.names.len(), 255);
        assert!(matches!(many(256), Err(CsvError::File(line)) if line.contains("255")));
    }

    #[test]
    fn a_clock_beyond_32_bits_starts_at_the_first_line() {
        let times = |times: [&str; 3]| {
            let lines = times.map(|time| format!("{time},1,0,0,0,5\n"));
            let beams = read(&format!("{HEADER}\n{}", lines.concat())).unwrap().0;
            beams.iter().map(|beam| beam.at.get()).collect::<Vec<_>>()
        };
        let epoch = times(["1700000000000", "1700000000250.4", "1699999999999"]);
        assert_eq!(epoch, [0, 250, 0]);
        assert_eq!(times(["4294967295", "7", "8"]), [u32::MAX, 7, 8]);
    }

    #[test]
    fn the_unit_of_times_is_guessed_and_said() {
        for (time, ms, unit) in [("12", 12, "milliseconds"), ("0.5", 500, "seconds")] {
            let text = format!("timestamp,sensor,x_mm,y_mm,bearing_mdeg,reading\n{time},1,0,0,0,5");
            let (beams, summary) = read(&text).unwrap();
            assert_eq!(beams[0].at, Ticks::new(ms));
            assert!(summary.notes[0].contains(unit), "{:?}", summary.notes);
        }
        assert_eq!(TimeUnit::guess(1.7e18), TimeUnit::Nanoseconds);
        assert_eq!(TimeUnit::guess(1.7e15), TimeUnit::Microseconds);
        assert_eq!(TimeUnit::guess(1.7e12), TimeUnit::Milliseconds);
        assert_eq!(TimeUnit::guess(1.7e9), TimeUnit::Seconds);
    }

    const WIDE: &str = "# timestamp, pos_x, pos_y, heading, sonar0, sonar1, sonar2, sonar3\n\
                        10, 1.0, 2.0, 0.0, 2.5, inf, , 0\n";

    #[test]
    fn a_wide_line_is_a_beam_a_sensor() {
        let metres = CsvOptions {
            unit: Some(RangeUnit::Meters),
            ..options()
        };
        let (beams, summary) = read_with(WIDE, metres).unwrap();
        assert_eq!(summary.names, [0, 1, 2, 3]);
        let bearings: Vec<u16> = beams.iter().map(|beam| beam.bearing.to_bits()).collect();
        assert_eq!(bearings, [0, 0x4000, 0x8000, 0xC000]);
        let readings: Vec<Reading> = beams.iter().map(|beam| beam.reading).collect();
        let missing = Reading::Missing(Missing::Timeout);
        let echo = Reading::Echo(Millimeters::new(2500));
        assert_eq!(
            readings,
            [echo, Reading::NoObject, missing, Reading::NoObject]
        );
        assert!(
            beams
                .iter()
                .all(|beam| beam.origin == Point::from_mm(1000, 2000))
        );
        for word in [
            "--pose-unit",
            "--heading-unit",
            "--start-angle",
            "--time-unit",
            "--zero",
        ] {
            assert!(
                summary.notes.iter().any(|note| note.contains(word)),
                "{word}"
            );
        }
    }

    #[test]
    fn the_unit_of_ranges_is_never_guessed() {
        let Err(CsvError::File(line)) = read(WIDE) else {
            panic!("a unit was guessed");
        };
        assert!(line.contains("--unit"), "{line}");
        for (unit, value, mm) in [
            ("_mm", 2500.0, 2500),
            ("_s", 0.01, 1715),
            ("_us", 10_000.0, 1715),
        ] {
            let text = format!("t_ms,x_mm,y_mm,heading_deg,us1{unit}\n0,0,0,0,{value}");
            let beams = read(&text).unwrap().0;
            assert_eq!(
                beams[0].reading,
                Reading::Echo(Millimeters::new(mm)),
                "{unit}"
            );
        }
    }

    #[test]
    fn the_mounting_is_an_option() {
        let bearings = |fov, start_angle| {
            let unit = Some(RangeUnit::Meters);
            let options = CsvOptions {
                unit,
                fov,
                start_angle,
                ..options()
            };
            let beams = read_with(WIDE, options).unwrap().0;
            beams
                .iter()
                .map(|beam| beam.bearing.to_bits())
                .collect::<Vec<_>>()
        };
        let unknown = CsvOptions {
            start_angle: None,
            unit: Some(RangeUnit::Meters),
            ..options()
        };
        let Err(CsvError::File(line)) = read_with(WIDE, unknown) else {
            panic!("a mounting was guessed");
        };
        assert!(line.contains("--start-angle"), "{line}");
        let eighth = Some(BinaryAngle::from_bits(0x2000));
        assert_eq!(bearings(None, eighth), [0x2000, 0x6000, 0xA000, 0xE000]);
        let half = FieldOfView::try_new(180_000);
        assert_eq!(bearings(half, None), [0xC000, 0xEAAB, 0x1555, 0x4000]);
    }

    #[test]
    fn an_assumed_unit_that_cannot_be_is_an_error() {
        for (row, option) in [
            ("0, 2500, 0, 0, 1", "--pose-unit"),
            ("0, 0, 0, 90, 1", "--heading-unit"),
        ] {
            let text = format!("t_ms, x, y, heading, range0_m\n{row}");
            let Err(CsvError::File(line)) = read(&text) else {
                panic!("{row} was read");
            };
            assert!(line.contains(option), "{line}");
        }
    }

    #[test]
    fn directions_follow_the_numbers_of_ranges() {
        let text =
            "t_ms,x_m,y_m,heading_deg,range_0_m,range_1_m,range_10_m,range_2_m\n0,0,0,0,1,2,4,3";
        let (beams, summary) = read(text).unwrap();
        let looks: Vec<_> = beams
            .iter()
            .map(|beam| (beam.reading, beam.bearing.to_bits()))
            .collect();
        let echo = |metres: u32| Reading::Echo(Millimeters::new(metres * 1000));
        let expected = [(1, 0), (2, 0x4000), (3, 0x8000), (4, 0xC000)];
        assert_eq!(looks, expected.map(|(metres, bits)| (echo(metres), bits)));
        assert!(
            summary.notes[0]
                .contains("range_0_m=0, range_1_m=90, range_2_m=180, range_10_m=270 degrees")
        );
        let names: Vec<String> = (0..12).map(|n| format!("r{n}_m")).collect();
        let text = format!(
            "t_ms,x_m,y_m,heading_deg,{}\n0,0,0,0{}",
            names.join(","),
            ",1".repeat(12)
        );
        let note = &read(&text).unwrap().1.notes[0];
        assert!(
            note.contains("r0_m=0, r1_m=30, r2_m=60, r3_m=90, …, r11_m=330 degrees"),
            "{note}"
        );
    }

    #[test]
    fn a_second_header_holds_for_the_lines_below() {
        let swapped = "t_ms,sensor,y_mm,x_mm,bearing_mdeg,reading";
        let text =
            format!("{HEADER}\n0,1,10,20,0,5\n{swapped}\n1,1,20,10,0,5\n# {HEADER}\n2,1,10,20,0,5");
        let (beams, _) = read(&text).unwrap();
        assert_eq!(beams.len(), 3);
        assert!(
            beams
                .iter()
                .all(|beam| beam.origin == Point::from_mm(10, 20))
        );
        let wide = "t_ms,x_m,y_m,heading_deg,range0_m,range1_m";
        let third = format!("{wide},range2_m");
        let lacks = "t_ms,sensor,x_mm,y_mm,bearing_mdeg";
        for (first, second, word) in [
            (HEADER, wide, "other sensors"),
            (wide, HEADER, "other sensors"),
            (wide, &third, "other sensors"),
            (HEADER, lacks, "no column of distance (reading)"),
        ] {
            let Err(CsvError::File(line)) = read(&format!("{first}\n{second}\n")) else {
                panic!("{second} was read");
            };
            assert!(line.contains(word), "{line}");
        }
    }

    #[test]
    fn what_a_header_lacks_is_named() {
        assert_eq!(
            lacking("t_ms,x_mm,y_mm,reading").unwrap(),
            "direction (bearing_mdeg), sensor number (sensor)"
        );
        assert_eq!(lacking(HEADER), None);
        assert_eq!(lacking("Dear all, this is an echo"), None);
    }

    #[test]
    fn a_beam_is_a_line_below_the_header() {
        let beam = RecordedBeam {
            at: Ticks::new(40),
            sensor: SensorId::try_new(2).unwrap(),
            origin: Point::from_mm(-100, 250),
            bearing: BinaryAngle::QUARTER,
            reading: Reading::NoObject,
        };
        let expected = "t_ms,sensor,x_mm,y_mm,bearing_mdeg,reading\n40,2,-100,250,90000,none\n";
        assert_eq!(written(&[beam]), expected);
    }

    #[test]
    fn every_bearing_survives_millidegrees() {
        let beam = |bits| RecordedBeam {
            at: Ticks::new(0),
            sensor: SensorId::try_new(1).unwrap(),
            origin: Point::ORIGIN,
            bearing: BinaryAngle::from_bits(bits),
            reading: Reading::TooNear,
        };
        let beams: Vec<_> = (0..=u16::MAX).map(beam).collect();
        assert_eq!(read(&written(&beams)).unwrap().0, beams);
    }

    #[test]
    fn whole_millidegrees_are_rounded_as_the_core_does() {
        for mdeg in (-360_000..=360_000).step_by(7) {
            let expected = BinaryAngle::from_millidegrees(mdeg);
            assert_eq!(nearest_angle(mdeg.into()), expected, "{mdeg}");
        }
    }
}
