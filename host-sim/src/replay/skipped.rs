//! The lines of a recording that were skipped, and why.

use core::fmt;
use serde::Serialize;
use std::collections::BTreeMap;

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
