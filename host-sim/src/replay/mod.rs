//! Recordings: beams with poses, from CARMEN logs and from readings files.
//!
//! [`load`] reads a file of any [`Format`], plain or gzip, and returns its beams in file order. A line
//! that cannot be read is skipped and counted in [`Skipped`]; only a file without any usable beam is
//! an error. No file causes a panic, and no number in a file decides how much memory is taken: memory
//! grows with the beams that were read, up to [`LoadOptions::max_beams`].
//!
//! Order: one pass over the file. Memory: 24 bytes a beam, and one line.

mod carmen;
mod load;
mod readings;
mod recording;
mod source;

pub use load::{LoadError, LoadOptions, load};
pub use readings::HEADER;
pub use recording::{
    Format, RecordedBeam, Recording, SkipReason, Skipped, SkippedLine, Tally, ZeroMeans,
};
