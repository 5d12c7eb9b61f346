//! A recording: beams with poses, and the lines that were skipped.

use certainty_core::fusion::Beam;
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Point, Ticks};
use core::fmt;
use serde::Serialize;
use std::collections::BTreeMap;

/// One beam of a recording: time, sensor, origin, bearing and reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RecordedBeam {
    /// Time since the recording's first beam (CARMEN) or as in the file (readings).
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
    /// The number of virtual sensors or of sonars (CARMEN), or the highest sensor number (readings).
    pub sensors: u8,
    /// The file's format.
    pub format: Format,
    /// The beams' opening angle, if the file has a line such as `# beam-width: 20deg` (readings).
    pub beam_width: Option<BinaryAngle>,
    /// The lines that could not be used.
    pub skipped: Skipped,
    /// Lines of known messages whose beams are not used: odometry, parameters, a second laser.
    pub other_messages: u64,
    /// How often a line with beams has an earlier time than the line with beams before it.
    pub backward_steps: u64,
    /// What the file leaves open and was assumed, one line each.
    pub notes: Vec<String>,
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
            Self::NoObject => "no object",
            Self::TooNear => "too near",
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

/// A recording's format. Either may be packed with gzip, which [`load`](super::load) detects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Format {
    /// The log of the CARMEN toolkit: a message a line, scans of a laser or sonars with poses.
    Carmen,
    /// Our own interchange format: comma-separated, a beam a line.
    Readings,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Carmen => "CARMEN log",
            Self::Readings => "readings",
        })
    }
}

/// Why a line of a recording was skipped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SkipReason {
    /// The line is longer than [`Skipped::LONGEST_LINE`].
    TooLong,
    /// The line is not UTF-8.
    NotText,
    /// The line has another number of fields than its format or its own count announces.
    FieldCount,
    /// The line is a scan without beams.
    NoReadings,
    /// A field is not the number that it must be.
    NotANumber,
    /// The time is negative, not finite or past what 32 bits of milliseconds hold.
    BadTime,
    /// The sensor's number is not within 1 to 255.
    BadSensor,
    /// The pose is not finite.
    BadPose,
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
    /// The compressed file is cut short within this line.
    Truncated,
    /// Bytes follow the compressed data that are not part of it.
    TrailingBytes,
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
            Self::BadSensor => "sensor not within 1 to 255",
            Self::BadPose => "pose not finite",
            Self::NoPose => "no pose, and no whole ODOM line before",
            Self::OutOfReach => "pose out of a map's reach",
            Self::BadReading => "not a reading",
            Self::BadBeamWidth => "not a beam width such as 20deg",
            Self::UnknownMessage => "unknown message",
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

/// The skipped lines of a recording: all counted, the first few kept.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Skipped {
    counts: BTreeMap<SkipReason, u64>,
    first: Vec<SkippedLine>,
}

impl Skipped {
    /// How many lines are kept with their numbers.
    pub const KEPT: usize = 5;
    /// The longest line that is read, in bytes; a longer one is skipped and never held in memory.
    pub const LONGEST_LINE: usize = 1 << 20;

    /// Counts one line.
    pub(crate) fn add(&mut self, line: u64, reason: SkipReason) {
        *self.counts.entry(reason).or_default() += 1;
        if self.first.len() < Self::KEPT {
            self.first.push(SkippedLine { line, reason });
        }
    }

    /// Returns how many lines were skipped.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.counts.values().sum()
    }

    /// Returns how many lines were skipped for `reason`.
    #[must_use]
    pub fn count(&self, reason: SkipReason) -> u64 {
        self.counts.get(&reason).copied().unwrap_or(0)
    }

    /// Returns the reasons that occurred and how often, in the order of [`SkipReason`].
    pub fn counts(&self) -> impl Iterator<Item = (SkipReason, u64)> + '_ {
        self.counts.iter().map(|(&reason, &count)| (reason, count))
    }

    /// Returns the first few skipped lines, in file order.
    #[must_use]
    pub fn first(&self) -> &[SkippedLine] {
        &self.first
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
        assert_eq!(
            serde_json::to_string(&skipped).unwrap(),
            r#"{"counts":{"field_count":1},"first":[{"line":7,"reason":"field_count"}]}"#
        );
    }
}
