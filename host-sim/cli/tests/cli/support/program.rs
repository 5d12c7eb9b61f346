//! Runs of the program `certainty`.

use certainty_tests::process::{PATIENCE, Ran, run};
use std::ffi::OsStr;
use std::path::Path;
use std::process::{Command, Stdio};

/// Returns the program with `arguments`, to be run in `folder`.
///
/// Variables for colours and backtraces are removed from its environment.
pub(crate) fn command<A: AsRef<OsStr>>(
    folder: &Path,
    arguments: impl IntoIterator<Item = A>,
) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_certainty"));
    command.args(arguments).current_dir(folder);
    for variable in ["NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE", "RUST_BACKTRACE"] {
        command.env_remove(variable);
    }
    command.stdin(Stdio::null());
    command
}

/// Runs the program in `folder` with `arguments` separated by spaces.
///
/// # Panics
/// If it cannot be started or runs longer than [`PATIENCE`].
#[must_use]
pub(crate) fn certainty(folder: &Path, arguments: &str) -> Ran {
    run(command(folder, arguments.split_whitespace()), PATIENCE)
}
