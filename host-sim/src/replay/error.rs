//! Why a recording cannot be loaded at all.

use super::readings::HEADER;
use super::skipped::SkippedLine;
use crate::export::shown;
use std::io;
use std::path::PathBuf;

/// Why a recording cannot be loaded; each reads as one line that says what to do.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The file cannot be opened.
    #[error("{}: cannot be opened ({source}); check its name and permissions", shown(.path))]
    Open {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The file is a directory.
    #[error("{}: is a directory; name one recording in it", shown(.path))]
    Directory {
        /// The directory.
        path: PathBuf,
    },
    /// The file, unpacked, has no bytes.
    #[error("{}: is empty; a recording needs at least one beam", shown(.path))]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// The file is binary.
    #[error(
        "{}: is not text; give a CARMEN log or a readings file (.csv), plain or gzip",
        shown(.path)
    )]
    NotText {
        /// The file.
        path: PathBuf,
    },
    /// The file is text of no known format.
    #[error(
        "{}: no line of its start is a CARMEN message or the header \"{HEADER}\"; \
         add the header or name the format",
        shown(.path)
    )]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// The compressed data are damaged, or cut before the first beam.
    #[error(
        "{}:{line}: the gzip data are damaged ({source}); copy the file anew or repair it",
        shown(.path)
    )]
    Gzip {
        /// The file.
        path: PathBuf,
        /// The line of the unpacked text in which it was noticed.
        line: u64,
        /// What the decoder said.
        source: io::Error,
    },
    /// Reading failed.
    #[error("{}:{line}: reading failed ({source}); check the disk and try again", shown(.path))]
    Read {
        /// The file.
        path: PathBuf,
        /// The line it failed in.
        line: u64,
        /// What the system said.
        source: io::Error,
    },
    /// No line gave a beam.
    #[error("{}{}", shown(.path), no_beams(*.skipped, .first.as_ref()))]
    NoBeams {
        /// The file.
        path: PathBuf,
        /// How many lines were skipped.
        skipped: u64,
        /// The first of them.
        first: Option<SkippedLine>,
    },
    /// The file has more beams than are allowed.
    #[error(
        "{}:{line}: more than {limit} beams; split the recording into shorter ones",
        shown(.path)
    )]
    TooManyBeams {
        /// The file.
        path: PathBuf,
        /// The line with the beam that was too many.
        line: u64,
        /// How many are allowed.
        limit: usize,
    },
}

/// What follows the file's name where it has no beams.
fn no_beams(skipped: u64, first: Option<&SkippedLine>) -> String {
    match first {
        Some(first) => format!(
            ":{}: no usable beam: {} ({skipped} lines skipped in all); repair these lines",
            first.line, first.reason
        ),
        None => ": no beam in it (no line skipped); record range readings with poses".to_owned(),
    }
}
