//! What tests share: building firmware images, running programs, the shared recordings.

pub mod firmware;
pub mod pgm;
pub mod process;

use std::path::{Path, PathBuf};

/// Returns the root of the workspace.
#[must_use]
pub fn workspace() -> &'static Path {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    tests.parent().unwrap_or(tests)
}

/// Returns the file `name` of the shared recordings, or says that the test is skipped.
///
/// They are real logs whose licence keeps them out of the project: `$CERTAINTY_DATA`, or
/// `shared/data` beside the workspace.
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

/// Says that a test does not run here, and why.
pub fn skipped(why: &str) {
    eprintln!("skipped: {why}");
}
