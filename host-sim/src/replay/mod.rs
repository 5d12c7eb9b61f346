//! Recordings: beams with poses, from CARMEN logs and from CSV files.
//!
//! [`load`] reads a file of any [`Format`], plain or packed, and returns its beams in file order. A line
//! that cannot be read is skipped and counted in [`Skipped`]; a file without any usable beam, or with
//! more than a twentieth of its lines unreadable, is an error. No file causes a panic, and no number in a file decides how much memory is taken: memory
//! grows with the beams that were read, up to [`LoadOptions::max_beams`].
//!
//! Order: one pass over the file. Memory: 24 bytes a beam, and one line; 24 more for a beam's line where
//! lines without beams are between those with.

mod carmen;
mod layout;
mod line_index;
mod load;
mod readings;
mod recording;
mod steps;

pub use load::{LoadError, LoadOptions, load, read};
pub use readings::HEADER;
pub use recording::{
    AngleUnit, Format, LengthUnit, RangeUnit, RecordedBeam, Recording, SkipCount, SkipReason,
    Skipped, SkippedLine, Tally, TimeUnit, TooManySkipped, ZeroMeans,
};
pub use steps::StrayPose;
