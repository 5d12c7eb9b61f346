//! Recordings in: beams with poses, from files of other systems and of our own.
//!
//! [`load`] takes a file of any [`Format`], plain or gzip, and gives its beams in file order. It is
//! made for files as they are found: what cannot be read is skipped line by line and counted in
//! [`Skipped`], and only a file of which nothing can be used is an error. No file makes it panic or
//! take memory by what the file *announces*: memory grows with the beams that were really read, up
//! to [`LoadOptions::max_beams`].
//!
//! Order: one pass over the file. Memory: 24 bytes a beam, and one line.

mod carmen;
mod error;
mod format;
mod gunzip;
mod lines;
mod load;
mod readings;
mod robotlaser;
mod scan;
mod skipped;

pub use error::LoadError;
pub use format::Format;
pub use load::{LoadOptions, load};
pub use readings::{HEADER, write_readings};
pub use skipped::{SkipReason, Skipped, SkippedLine};

use certainty_core::fusion::Beam;
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Point, Ticks};

/// One beam of a recording: who looked, when, from where, which way, and what came back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RecordedBeam {
    /// When, since the recording's first beam (CARMEN) or as the file says (readings).
    pub at: Ticks,
    /// Which sensor.
    pub sensor: SensorId,
    /// Where the beam starts, in the map frame.
    pub origin: Point,
    /// Which way it goes, in the map frame.
    pub bearing: BinaryAngle,
    /// What came back.
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

/// What a file held.
///
/// Possession proves that at least one beam could be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recording {
    /// The beams, in file order.
    pub beams: Vec<RecordedBeam>,
    /// The highest sensor number that can occur: of virtual sensors (CARMEN) or seen (readings).
    pub sensors: u8,
    /// How the file was read.
    pub format: Format,
    /// The beams' opening angle, where the file says it: `# beam-width: 20deg` (readings).
    pub beam_width: Option<BinaryAngle>,
    /// The lines that could not be used.
    pub skipped: Skipped,
    /// Lines that are well known and carry no beams: odometry, parameters, a second laser.
    pub other_messages: u64,
    /// How often a line with beams was older than the line with beams before it.
    pub backward_steps: u64,
}

/// How many beams of a recording said what.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
pub struct Tally {
    /// Beams that met something.
    pub echo: u64,
    /// Beams that met nothing in range.
    pub no_object: u64,
    /// Beams that met something too near to measure.
    pub too_near: u64,
    /// Beams without a measurement.
    pub missing: u64,
}

impl Recording {
    /// Counts the beams by what they say.
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
    /// A single wild pose widens it without bound but [`Point::LIMIT`]: who makes a grid of this
    /// size checks it first.
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

#[cfg(test)]
mod tests;
