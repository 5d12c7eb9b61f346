//! A recording: beams with poses, and what was skipped on the way.

use super::skipped::Skipped;
use certainty_core::fusion::Beam;
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Point, Ticks};
use core::fmt;
use serde::Serialize;

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
    /// The number of virtual sensors (CARMEN) or the highest sensor number (readings).
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
    /// The log of the CARMEN toolkit: a message a line, scans of a laser with corrected poses.
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
