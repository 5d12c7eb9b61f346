//! A recording: beams with poses, and the lines that were skipped.

use super::line_index::LineIndex;
use crate::input::{BadLine, Unit};
use certainty_core::fusion::Beam;
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Point, Ticks};
use core::fmt;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;

/// One beam of a recording: time, sensor, origin, bearing and reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RecordedBeam {
    /// Time since the recording's first beam (CARMEN), or as in the file if that fits 32 bits (CSV).
    pub at: Ticks,
    /// The sensor.
    pub sensor: SensorId,
    /// The beam's origin in the map frame.
    pub origin: Point,
    /// The beam's direction in the map frame.
    pub bearing: BinaryAngle,
    /// The reading.
    pub reading: Reading,
}

impl From<&RecordedBeam> for Beam {
    fn from(recorded: &RecordedBeam) -> Self {
        Self {
            origin: recorded.origin,
            bearing: recorded.bearing,
            reading: recorded.reading,
        }
    }
}

/// The content of a recording's file.
///
/// Possession proves that it has at least one beam.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recording {
    /// The beams, in file order.
    pub beams: Vec<RecordedBeam>,
    /// The number of virtual sensors (CARMEN) or of sensors that the file names (CSV).
    pub sensors: u8,
    /// The file's format.
    pub format: Format,
    /// The beams' opening angle, if the file has a line such as `# beam-width: 20deg` (readings).
    pub beam_width: Option<BinaryAngle>,
    /// The lines that could not be used.
    pub skipped: Skipped,
    /// Lines of known messages without beams: odometry, parameters, a second laser.
    pub other_messages: u64,
    /// How often a line with beams has an earlier time than the line with beams before it.
    pub backward_steps: u64,
    /// What the file leaves open and was assumed, one line each.
    pub notes: Vec<String>,
    /// The sensors' numbers in the file, ascending, that of slot 0 first; from 1 (CARMEN).
    pub names: Vec<u16>,
    /// The lines of the beams.
    pub(super) lines: LineIndex,
}

/// What a reading of 0 means, which differs between sensors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum ZeroMeans {
    /// No object in range: many drivers return 0 if no echo came.
    #[default]
    NoObject,
    /// An object too near to measure.
    TooNear,
}

impl ZeroMeans {
    /// Returns the reading that 0 stands for.
    #[must_use]
    pub const fn reading(self) -> Reading {
        match self {
            Self::NoObject => Reading::NoObject,
            Self::TooNear => Reading::TooNear,
        }
    }
}

impl fmt::Display for ZeroMeans {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoObject => "no object; --zero near takes them as too near",
            Self::TooNear => "too near",
        })
    }
}

/// The unit of a CSV's readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RangeUnit {
    /// Distances in millimetres.
    Millimeters,
    /// Distances in centimetres.
    Centimeters,
    /// Distances in metres.
    Meters,
    /// Times of a sonar's echo, there and back, in seconds.
    EchoSeconds,
    /// The same in milliseconds.
    EchoMilliseconds,
    /// The same in microseconds.
    EchoMicroseconds,
}

/// The speed of sound in air of 20 °C, in millimetres a second.
const SOUND: f64 = 343_000.0;

impl RangeUnit {
    /// Returns the unit of ranges that a column's name ends with.
    pub(crate) const fn of(unit: Unit) -> Option<Self> {
        Some(match unit {
            Unit::Millimeters => Self::Millimeters,
            Unit::Centimeters => Self::Centimeters,
            Unit::Meters => Self::Meters,
            Unit::Seconds => Self::EchoSeconds,
            Unit::Milliseconds => Self::EchoMilliseconds,
            Unit::Microseconds => Self::EchoMicroseconds,
            _ => return None,
        })
    }

    /// Returns the millimetres that a unit is. An echo travels there and back.
    pub(crate) const fn millimetres(self) -> f64 {
        match self {
            Self::Millimeters => 1.0,
            Self::Centimeters => 10.0,
            Self::Meters => 1000.0,
            Self::EchoSeconds => SOUND / 2.0,
            Self::EchoMilliseconds => SOUND / 2e3,
            Self::EchoMicroseconds => SOUND / 2e6,
        }
    }
}

/// The unit of a CSV's positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LengthUnit {
    /// Millimetres.
    Millimeters,
    /// Centimetres.
    Centimeters,
    /// Metres.
    Meters,
}

impl LengthUnit {
    /// Returns the millimetres that a unit is.
    pub(super) const fn millimetres(self) -> f64 {
        match self {
            Self::Millimeters => 1.0,
            Self::Centimeters => 10.0,
            Self::Meters => 1000.0,
        }
    }
}

/// The unit of a CSV's directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AngleUnit {
    /// Degrees.
    Degrees,
    /// Thousandths of a degree.
    Millidegrees,
    /// Radians.
    Radians,
}

impl AngleUnit {
    /// Returns the millidegrees that a unit is.
    pub(super) const fn millidegrees(self) -> f64 {
        match self {
            Self::Degrees => 1000.0,
            Self::Millidegrees => 1.0,
            Self::Radians => 180_000.0 / core::f64::consts::PI,
        }
    }
}

/// The unit of a CSV's times.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TimeUnit {
    /// Seconds.
    Seconds,
    /// Milliseconds.
    Milliseconds,
    /// Microseconds.
    Microseconds,
    /// Nanoseconds.
    Nanoseconds,
}

impl TimeUnit {
    /// Returns the milliseconds that a unit is.
    pub(super) const fn milliseconds(self) -> f64 {
        match self {
            Self::Seconds => 1e3,
            Self::Milliseconds => 1.0,
            Self::Microseconds => 1e-3,
            Self::Nanoseconds => 1e-6,
        }
    }

    /// The unit of `time` by its form: seconds have a fraction; since 1970 there are 10^9 seconds, 10^12
    /// milliseconds, 10^15 microseconds and 10^18 nanoseconds.
    pub(super) fn guess(time: f64) -> Self {
        // 10^9 milliseconds are twelve days without a pause.
        if time.fract() != 0.0 || (1e9..1e10).contains(&time) {
            Self::Seconds
        } else if time.abs() >= 1e17 {
            Self::Nanoseconds
        } else if time.abs() >= 1e14 {
            Self::Microseconds
        } else {
            Self::Milliseconds
        }
    }
}

impl fmt::Display for TimeUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Seconds => "seconds",
            Self::Milliseconds => "milliseconds",
            Self::Microseconds => "microseconds",
            Self::Nanoseconds => "nanoseconds",
        })
    }
}

/// How many beams of a recording have each kind of reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Tally {
    /// Beams with an echo.
    pub echo: u64,
    /// Beams without an object in range.
    pub no_object: u64,
    /// Beams with an object too near to measure.
    pub too_near: u64,
    /// Beams without a measurement.
    pub missing: u64,
}

impl Recording {
    /// Counts the beams by their readings.
    #[must_use]
    pub fn tally(&self) -> Tally {
        let mut tally = Tally::default();
        for beam in &self.beams {
            match beam.reading {
                Reading::Echo(_) => tally.echo += 1,
                Reading::NoObject => tally.no_object += 1,
                Reading::TooNear => tally.too_near += 1,
                Reading::Missing(_) => tally.missing += 1,
            }
        }
        tally
    }

    /// Returns the lower left and the upper right corner of all beams' origins and echoes.
    ///
    /// A single wrong pose can widen it up to [`Point::LIMIT`]: check it before you create a grid of
    /// this size.
    #[must_use]
    pub fn extent(&self) -> (Point, Point) {
        let first = self.beams.first().map_or(Point::ORIGIN, |beam| beam.origin);
        let places = self.beams.iter().flat_map(|beam| {
            let end = match beam.reading {
                Reading::Echo(distance) => beam.origin.ahead(beam.bearing.direction(), distance),
                _ => beam.origin,
            };
            [beam.origin, end]
        });
        places.fold((first, first), |(low, high), place| {
            (
                Point::from_mm(low.x_mm().min(place.x_mm()), low.y_mm().min(place.y_mm())),
                Point::from_mm(high.x_mm().max(place.x_mm()), high.y_mm().max(place.y_mm())),
            )
        })
    }
}

/// A recording's format. Each may be packed, which [`load`](super::load) detects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Format {
    /// The log of the CARMEN toolkit: a message a line, scans of a laser with corrected poses.
    Carmen,
    /// Our own interchange format: CSV with a beam a line.
    Readings,
    /// CSV with a pose and several ranges a line.
    Wide,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Carmen => "CARMEN log",
            Self::Readings => "readings",
            Self::Wide => "wide CSV",
        })
    }
}

/// Why a line of a recording was skipped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SkipReason {
    /// The line is longer than [`Skipped::LONGEST_LINE`].
    TooLong,
    /// The line has a byte 0.
    NotText,
    /// The line has another number of fields than its format or its own count announces.
    FieldCount,
    /// The line is a scan without beams.
    NoReadings,
    /// A field is not the number that it must be.
    NotANumber,
    /// The time is negative, not finite or past what 32 bits of milliseconds hold.
    BadTime,
    /// The sensor's number is not within 0 to 65535.
    BadSensor,
    /// The pose is not finite.
    BadPose,
    /// An angle of the laser is more than a turn of radians.
    BadAngle,
    /// The readings have no pose and no odometry before them.
    NoPose,
    /// The pose is beyond the largest coordinate of a map.
    OutOfReach,
    /// The reading is neither a distance nor `none`, `near` or `missing`.
    BadReading,
    /// The comment with the beams' width has no valid angle.
    BadBeamWidth,
    /// The line does not start with the name of a known message.
    UnknownMessage,
    /// The line is before the table's header.
    BeforeHeader,
    /// The step to the pose is longer than [`LoadOptions::max_step`](super::LoadOptions::max_step).
    FarStep,
    /// The compressed file is cut short within this line.
    Truncated,
    /// Bytes follow the compressed data that are not part of it.
    TrailingBytes,
}

impl SkipReason {
    /// Whether a line of a kind that is read could not be: too many of them, and the file is refused.
    ///
    /// Lines of other kinds, what is left out by an option, and the end of a packed file are not
    /// counted.
    #[must_use]
    pub const fn is_unreadable(self) -> bool {
        !matches!(
            self,
            Self::BadBeamWidth
                | Self::UnknownMessage
                | Self::BeforeHeader
                | Self::FarStep
                | Self::Truncated
                | Self::TrailingBytes
        )
    }
}

impl From<BadLine> for SkipReason {
    fn from(bad: BadLine) -> Self {
        match bad {
            BadLine::TooLong => Self::TooLong,
            BadLine::NotText => Self::NotText,
        }
    }
}

impl fmt::Display for SkipReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TooLong => "line too long",
            Self::NotText => "not text",
            Self::FieldCount => "wrong number of fields",
            Self::NoReadings => "scan without readings",
            Self::NotANumber => "not a number",
            Self::BadTime => "time out of range",
            Self::BadSensor => "sensor not within 0 to 65535",
            Self::BadPose => "pose not finite",
            Self::BadAngle => "angle out of range; CARMEN writes radians: --fov sets others",
            Self::NoPose => "no pose, and no whole ODOM line before",
            Self::OutOfReach => "pose out of a map's reach",
            Self::BadReading => "not a reading",
            Self::BadBeamWidth => "not a beam width such as 20deg",
            Self::UnknownMessage => "unknown message",
            Self::BeforeHeader => "before the header",
            Self::FarStep => "step beyond --max-step",
            Self::Truncated => "compressed file cut short",
            Self::TrailingBytes => "bytes after the compressed data",
        })
    }
}

/// What a line of a recording is, if it is not skipped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LineKind {
    /// It has beams; `backward` if its time is before that of the beams before.
    Beams { backward: bool },
    /// A known message without beams.
    Other,
    /// A comment, a header, or blank.
    Nothing,
}

/// A skipped line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct SkippedLine {
    /// Its number in the file, from 1.
    pub line: u64,
    /// Why it was skipped.
    pub reason: SkipReason,
}

impl fmt::Display for SkippedLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.line, self.reason)
    }
}

/// The lines that were skipped for one reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct SkipCount {
    /// The reason.
    pub reason: SkipReason,
    /// How many lines.
    pub lines: u64,
    /// The first of them, from 1.
    pub first_line: u64,
}

/// The skipped lines of a recording: all counted, the first few kept.
///
/// As JSON it is the list of [`Self::counts`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Skipped {
    counts: BTreeMap<SkipReason, SkipCount>,
    first: Vec<SkippedLine>,
}

impl Skipped {
    /// How many lines are kept with their numbers.
    pub const KEPT: usize = 5;
    /// The longest line that is read, in bytes; a longer one is skipped and never held in memory.
    pub const LONGEST_LINE: usize = crate::input::LONGEST_LINE;

    /// Counts one line.
    pub(crate) fn add(&mut self, line: u64, reason: SkipReason) {
        let count = self.counts.entry(reason).or_insert(SkipCount {
            reason,
            lines: 0,
            first_line: line,
        });
        count.lines += 1;
        if self.first.len() < Self::KEPT {
            self.first.push(SkippedLine { line, reason });
        }
    }

    /// Removes the lines that were skipped for `reason`; returns how many.
    pub(crate) fn forget(&mut self, reason: SkipReason) -> u64 {
        self.first.retain(|skipped| skipped.reason != reason);
        self.counts.remove(&reason).map_or(0, |count| count.lines)
    }

    /// Returns how many lines were skipped.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.counts.values().map(|count| count.lines).sum()
    }

    /// Returns how many lines were skipped for `reason`.
    #[must_use]
    pub fn count(&self, reason: SkipReason) -> u64 {
        self.counts.get(&reason).map_or(0, |count| count.lines)
    }

    /// Returns the reasons that occurred, in the order of [`SkipReason`].
    pub fn counts(&self) -> impl Iterator<Item = SkipCount> + '_ {
        self.counts.values().copied()
    }

    /// Returns the first few skipped lines, in file order.
    #[must_use]
    pub fn first(&self) -> &[SkippedLine] {
        &self.first
    }

    /// Returns what is unreadable of `read` lines of a kind that is read and those that were skipped, if
    /// it is more than a twentieth.
    pub(crate) fn too_many(&self, read: u64) -> Option<TooManySkipped> {
        let unreadable = || self.counts().filter(|count| count.reason.is_unreadable());
        let lines: u64 = unreadable().map(|count| count.lines).sum();
        let first = unreadable().min_by_key(|count| count.first_line)?;
        let of = lines + read;
        (lines * 20 > of).then_some(TooManySkipped {
            lines,
            of,
            first: SkippedLine {
                line: first.first_line,
                reason: first.reason,
            },
        })
    }
}

impl Serialize for Skipped {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.counts())
    }
}

/// More lines are unreadable than a file may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TooManySkipped {
    /// How many are unreadable.
    pub lines: u64,
    /// Of how many of the kinds that are read.
    pub of: u64,
    /// The first one.
    pub first: SkippedLine,
}

impl fmt::Display for TooManySkipped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} of {} lines with readings are unreadable, first: {}; correct them, or give --lenient to leave \
             them out",
            self.lines, self.of, self.first.reason
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_are_counted_and_first_few_kept() {
        let mut skipped = Skipped::default();
        for line in 1..=100 {
            skipped.add(line, SkipReason::NotText);
        }
        skipped.add(101, SkipReason::BadPose);
        assert_eq!(skipped.total(), 101);
        assert_eq!(skipped.count(SkipReason::NotText), 100);
        assert_eq!(skipped.count(SkipReason::TooLong), 0);
        let kept: Vec<u64> = skipped.first().iter().map(|one| one.line).collect();
        assert_eq!(kept, [1, 2, 3, 4, 5]);
    }

    #[test]
    fn json_counts_by_reason() {
        let mut skipped = Skipped::default();
        skipped.add(7, SkipReason::FieldCount);
        skipped.add(9, SkipReason::FieldCount);
        assert_eq!(
            serde_json::to_string(&skipped).unwrap(),
            r#"[{"reason":"field_count","lines":2,"first_line":7}]"#
        );
    }

    #[test]
    fn more_than_a_twentieth_is_too_many() {
        let mut skipped = Skipped::default();
        skipped.add(3, SkipReason::UnknownMessage);
        skipped.add(4, SkipReason::NotANumber);
        assert_eq!(skipped.too_many(19), None);
        let too_many = skipped.too_many(18).unwrap();
        assert_eq!(
            (too_many.lines, too_many.of, too_many.first.line),
            (1, 19, 4)
        );
    }
}
