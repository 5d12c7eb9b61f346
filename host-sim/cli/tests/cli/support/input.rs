//! One file of input, good or bad, and the program run on it.

use crate::support::program::command;
use crate::support::recording::{BEAMS, Place, flaser};
use certainty_tests::process::{Ran, run};
use core::time::Duration;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// Limit for runs that fail or have little to do; enough for a busy machine too.
pub(crate) const QUICKLY: Duration = Duration::from_secs(15);

/// The pose of the synthetic scans.
pub(crate) const PLACE: Place = Place {
    x: 0.0,
    y: 0.0,
    heading: 0.0,
};

/// Returns a scan with every range the same.
#[must_use]
pub(crate) fn scan(metres: f64) -> String {
    flaser(&[metres; BEAMS], PLACE, 1.0)
}

/// Returns a folder with one file, `input`.
///
/// # Panics
/// If it cannot be made.
pub(crate) fn folder_with(content: impl AsRef<[u8]>) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("input"), content).unwrap();
    folder
}

/// Runs the program in `folder` with `arguments` separated by spaces, for at most [`QUICKLY`].
///
/// # Panics
/// If it takes longer.
#[must_use]
pub(crate) fn certainty(folder: &Path, arguments: &str) -> Ran {
    run(command(folder, arguments.split_whitespace()), QUICKLY)
}
