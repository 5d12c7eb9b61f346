//! Stdout and stderr, which may be closed, no terminal, or without colour.

use super::Failure;
use certainty_sim::export::shown;
use serde::Serialize;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};

/// Writes a result to stdout.
///
/// A reader that went away (`certainty | head`) has seen what it wanted: that is no failure.
pub(super) fn print(text: &str) -> Result<(), Failure> {
    offer(text).map(|_read| ())
}

/// Writes to stdout; returns whether anyone is still reading.
pub(super) fn offer(text: &str) -> Result<bool, Failure> {
    let mut stdout = std::io::stdout().lock();
    match stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush())
    {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(false),
        Err(error) => Err(Failure::Input(format!(
            "stdout: cannot write: {error}; free space, or send it to another file or program"
        ))),
    }
}

/// Writes exactly one JSON document to stdout.
pub(super) fn print_json(document: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(document)
        .map_err(|error| Failure::Internal(format!("cannot write JSON: {error}")))?;
    print(&(text + "\n"))
}

/// Refuses a folder whose name a JSON document could not hold.
pub(super) fn check_listable(json: bool, out: &Path) -> Result<(), Failure> {
    if json && out.to_str().is_none() {
        let line =
            "--out: the folder's name is not text, and --json must list files in it; name another";
        return Err(Failure::Input(line.into()));
    }
    Ok(())
}

/// Paths as a report lists them.
pub(super) fn listed(files: &[PathBuf]) -> Vec<String> {
    let text = |file: &PathBuf| file.to_string_lossy().into_owned();
    files.iter().map(text).collect()
}

/// Paths as a line for people has them.
pub(super) fn told(files: &[PathBuf]) -> String {
    let files: Vec<String> = files.iter().map(|file| shown(file)).collect();
    files.join(" ")
}

/// Writes a line to stderr, if there is anyone to read it.
pub(super) fn note(line: &str) {
    let _unread = writeln!(std::io::stderr().lock(), "{line}");
}

/// Whether stdout is a terminal that may be coloured.
///
/// `NO_COLOR`, with any value but an empty one, says no.
pub(super) fn coloured() -> bool {
    let forbidden = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    !forbidden && std::io::stdout().is_terminal()
}
