//! Reads a file of measured points.

use crate::export::display_path;
use crate::transducer::{MeasuredUnit, TableError, TableProblem};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Largest file that is read, in bytes.
pub const MOST_BYTES: u64 = 8 << 20;

/// Why a file of measured points was refused; displays as one line that says what to do.
#[derive(Debug, Error)]
pub enum MeasurementsError {
    /// The file cannot be read.
    #[error("{}: cannot be read ({source}); check its name and permissions", display_path(.path))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The file is a directory.
    #[error("{}: is a directory: expected a table of measured points", display_path(.path))]
    Directory {
        /// The directory.
        path: PathBuf,
    },
    /// The file is larger than [`MOST_BYTES`].
    #[error("{}: over 8 MiB; give a table of at most {} points", display_path(.path), MeasuredUnit::MOST_POINTS)]
    TooLong {
        /// The file.
        path: PathBuf,
    },
    /// The file is binary.
    #[error("{}:{line}: not text; give a table of distances and bytes (.csv)", display_path(.path))]
    NotText {
        /// The file.
        path: PathBuf,
        /// The first line that is not UTF-8, from 1.
        line: usize,
    },
    /// A line is not valid.
    #[error("{}:{line}: {problem}", display_path(.path))]
    Table {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        problem: TableProblem,
    },
}

/// Reads the table of measured points at `path`; see [`MeasuredUnit::parse`] for its format.
///
/// Memory: the file, at most [`MOST_BYTES`], and 16 bytes a point.
///
/// # Errors
/// [`MeasurementsError`] with the file and, if there is one, the line.
///
/// # Examples
/// ```
/// let path = concat!(env!("CARGO_MANIFEST_DIR"), "/data/gp2d02-units.csv");
/// let units = certainty_sim::calibration::load(path.as_ref())?;
/// assert_eq!((units.len(), units[0].points().len()), (16, 22));
/// # Ok::<(), certainty_sim::calibration::MeasurementsError>(())
/// ```
pub fn load(path: &Path) -> Result<Vec<MeasuredUnit>, MeasurementsError> {
    let unreadable = |source| MeasurementsError::Unreadable {
        path: path.into(),
        source,
    };
    let file = File::open(path).map_err(unreadable)?;
    if file.metadata().map_err(unreadable)?.is_dir() {
        return Err(MeasurementsError::Directory { path: path.into() });
    }
    let mut bytes = Vec::new();
    // One byte more than allowed shows a longer file, or a device without end.
    file.take(MOST_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(unreadable)?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(MeasurementsError::TooLong { path: path.into() });
    }
    let text = str::from_utf8(&bytes).map_err(|error| {
        let before = &bytes[..error.valid_up_to()];
        MeasurementsError::NotText {
            path: path.into(),
            line: 1 + before.iter().filter(|&&byte| byte == b'\n').count(),
        }
    })?;
    MeasuredUnit::parse(text).map_err(|TableError { line, problem }| MeasurementsError::Table {
        path: path.into(),
        line,
        problem,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::fs;

    fn loaded(bytes: &[u8]) -> Result<Vec<MeasuredUnit>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("input");
        fs::write(&path, bytes).unwrap();
        let prefix = format!("{}/", folder.path().display());
        load(&path).map_err(|error| error.to_string().replace(&prefix, ""))
    }

    #[test]
    fn error_names_file_and_line() {
        let line = |bytes: &[u8]| loaded(bytes).unwrap_err();
        assert!(line(b"").starts_with("input:1: name the columns"));
        assert!(line(b"distance_mm,raw\n1,2\n\xFF\xFE\n").starts_with("input:3: not text"));
        assert!(line(b"distance_mm,raw\n1,2\n3").starts_with("input:3: 1 columns"));
        let long = vec![b'1'; MOST_BYTES as usize + 1];
        assert!(line(&long).starts_with("input: over 8 MiB"));
    }

    proptest! {
        #[test]
        fn any_bytes_are_a_table_or_a_one_line_error(bytes in any::<Vec<u8>>()) {
            for header in ["", "distance_mm,raw\n", "dist_cm,A,B\n1,2,3\n"] {
                let bytes = [header.as_bytes(), &bytes].concat();
                if let Err(line) = loaded(&bytes) {
                    prop_assert!(line.starts_with("input:") && line.lines().count() == 1, "{}", line);
                }
            }
        }
    }
}
