//! Reads a file of measured points.

use crate::export::display_path;
use crate::input::{BadLine, InputError, Text};
use crate::transducer::{Adc, MeasuredUnit, TableError, TableProblem};
use core::cell::Cell;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Largest table that is read, in bytes of text.
pub const MOST_BYTES: u64 = 8 << 20;

/// Why a file of measured points was refused; displays as one line that says what to do.
#[derive(Debug, Error)]
pub enum MeasurementsError {
    /// The file cannot be read as text.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The file is larger than [`MOST_BYTES`].
    #[error("{}: over 8 MiB; give a table of at most {} points", display_path(.path), MeasuredUnit::MOST_POINTS)]
    TooLong {
        /// The file.
        path: PathBuf,
    },
    /// The file is binary.
    #[error("{}:{line}: not text; give a table of distances and readings (.csv)", display_path(.path))]
    NotText {
        /// The file.
        path: PathBuf,
        /// The first line that is no text, from 1.
        line: u64,
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

/// Reads the table of measured points at `path`, or from stdin if it is `-`; plain or packed. See
/// [`MeasuredUnit::parse_as`] for its format.
///
/// Memory: the text, at most [`MOST_BYTES`], and 16 bytes a point.
///
/// # Errors
/// [`MeasurementsError`] with the file and, if there is one, the line.
///
/// # Examples
/// ```
/// use certainty_sim::transducer::Adc;
///
/// let path = concat!(env!("CARGO_MANIFEST_DIR"), "/data/gp2d02-units.csv");
/// let units = certainty_sim::calibration::load(path.as_ref(), Adc::BYTE)?;
/// assert_eq!((units.len(), units[0].points().len()), (16, 22));
/// # Ok::<(), certainty_sim::calibration::MeasurementsError>(())
/// ```
pub fn load(path: &Path, adc: Adc) -> Result<Vec<MeasuredUnit>, MeasurementsError> {
    let done = Cell::new(0);
    let (mut lines, _) = Text::open(path, "a table of measured points", &done)?;
    let path = lines.path().to_owned();
    let mut table = String::new();
    while let Some(line) = lines.next()? {
        let line = match line {
            Ok(line) => line,
            Err(BadLine::TooLong) => return Err(MeasurementsError::TooLong { path }),
            Err(BadLine::NotText) => {
                let line = lines.number();
                return Err(MeasurementsError::NotText { path, line });
            }
        };
        table.push_str(line);
        table.push('\n');
        if table.len() as u64 > MOST_BYTES {
            return Err(MeasurementsError::TooLong { path });
        }
    }
    MeasuredUnit::parse_as(&table, adc).map_err(|TableError { line, problem }| {
        let other = lines
            .foreign()
            .filter(|_| problem == TableProblem::NoHeader);
        other.map_or(
            MeasurementsError::Table {
                path,
                line,
                problem,
            },
            Into::into,
        )
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
        load(&path, Adc::BYTE).map_err(|error| error.to_string().replace(&prefix, ""))
    }

    #[test]
    fn error_names_file_and_line() {
        let line = |bytes: &[u8]| loaded(bytes).unwrap_err();
        assert!(line(b"").starts_with("input: is empty: expected a table of measured points"));
        assert!(line(b"a,b\n1,2\n").starts_with("input:1: name the columns"));
        assert!(line(b"distance_mm,raw\n1,2\n\0\n").starts_with("input:3: not text"));
        assert!(line(b"\x89PNG\r\n\x1A\n").starts_with("input: it is a PNG picture"));
        assert!(line(b"distance_mm,raw\n1,2\n3").starts_with("input:3: 1 columns"));
        let long = b"1,2\n".repeat(MOST_BYTES as usize / 4 + 1);
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
