//! What tests share: firmware images, running programs, recordings.

pub mod firmware;
pub mod pgm;
pub mod process;

use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Returns the root of the workspace.
#[must_use]
pub fn workspace() -> &'static Path {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    tests.parent().unwrap_or(tests)
}

/// Returns the recording `name`, or prints that the test is skipped.
///
/// The recordings are real logs that are not part of the project because of their licence. They are searched in
/// the folder `$CERTAINTY_DATA`, or in `shared/data` beside the workspace.
#[must_use]
pub fn shared_data(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("CERTAINTY_DATA")
        .map_or_else(|| workspace().join("../shared/data"), PathBuf::from);
    let file = folder.join(name);
    if file.exists() {
        Some(file)
    } else {
        skipped(&format!("there is no {}", file.display()));
        None
    }
}

/// Prints that a test is skipped, and why; `tests/run` counts it.
///
/// For what a machine may lack for good, such as recordings that are not part of the project.
///
/// # Panics
/// If that list cannot be written.
pub fn skipped(why: &str) {
    eprintln!("skipped: {why}");
    // One line a test, so that a run that tested less does not look like one that tested all.
    if let Some(list) = std::env::var_os("CERTAINTY_SKIPPED") {
        let list = OpenOptions::new().append(true).create(true).open(list);
        let written = list.and_then(|mut list| writeln!(list, "{why}"));
        written.expect("the list of skipped tests can be written");
    }
}

/// The same for a tool that `tests/run` installs.
///
/// # Panics
/// If the environment variable `CI` is set: there a missing tool must not pass for a tested program.
pub fn tool_is_missing(why: &str) {
    assert!(std::env::var_os("CI").is_none(), "a tool is missing: {why}");
    skipped(why);
}

/// The example of the front page compiles and runs.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct FrontPage;
