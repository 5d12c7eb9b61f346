//! Stdout, stderr and the exit code: reports, notes, progress bars and errors.

use certainty_sim::export::display_path;
use core::error::Error;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Why a subcommand failed.
#[derive(Debug)]
pub(super) enum Failure {
    /// Bad input or usage, as one line: what was wrong, where, and what was expected.
    Input(String),
    /// An internal error.
    Internal(String),
}

impl Failure {
    /// Creates the failure of bad input from `error`.
    pub(super) fn input(error: &dyn Error) -> Self {
        Self::Input(error.to_string())
    }

    /// Writes the line to stderr and returns the exit code.
    pub(super) fn report(&self) -> ExitCode {
        let (line, code) = match self {
            Self::Input(line) => (line, 2),
            Self::Internal(line) => (line, 1),
        };
        // A closed stderr is no failure.
        let _ = writeln!(std::io::stderr().lock(), "certainty: {}", one_line(line));
        ExitCode::from(code)
    }
}

/// Returns `text` on one line: white space becomes single spaces, control characters are escaped.
fn one_line(text: &str) -> String {
    let joined = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let mut line = String::with_capacity(joined.len());
    for c in joined.chars() {
        if c.is_control() {
            line.extend(c.escape_debug());
        } else {
            line.push(c);
        }
    }
    line
}

/// The result of a subcommand, as text and as one JSON document.
pub(super) trait Report {
    /// Returns the document of `--json`; its fields are a contract.
    fn document(&self) -> impl Serialize;

    /// Returns the text for a terminal.
    fn render(&self) -> String;
}

/// Writes a result to stdout.
///
/// A closed pipe (`certainty | head`) is no failure.
pub(super) fn print(text: &str) -> Result<(), Failure> {
    offer(text).map(|_open| ())
}

/// Writes to stdout; returns whether it is still open.
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
        let line = "--out: the folder's name is not UTF-8, and --json lists files in it: expected \
                    a name in UTF-8";
        return Err(Failure::Input(line.into()));
    }
    Ok(())
}

/// Returns paths as a JSON document lists them.
pub(super) fn listed(files: &[PathBuf]) -> Vec<String> {
    let text = |file: &PathBuf| file.to_string_lossy().into_owned();
    files.iter().map(text).collect()
}

/// Returns paths as a line of text.
pub(super) fn joined(files: &[PathBuf], separator: &str) -> String {
    let files: Vec<String> = files.iter().map(|file| display_path(file)).collect();
    files.join(separator)
}

/// Writes a line to stderr.
pub(super) fn note(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{line}"); // a closed stderr is no failure
}

/// Returns whether stdout is a terminal that may be coloured: not if `NO_COLOR` is set and not empty, and not
/// if `TERM` is `dumb`.
pub(super) fn coloured() -> bool {
    let forbidden = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    let is_dumb = std::env::var_os("TERM").is_some_and(|terminal| terminal == "dumb");
    !forbidden && !is_dumb && std::io::stdout().is_terminal()
}

/// Creates a progress bar of `total` steps on stderr, hidden unless stderr is a terminal.
pub(super) fn progress(what: &'static str, total: u64) -> ProgressBar {
    let target = if std::io::stderr().is_terminal() {
        ProgressDrawTarget::stderr()
    } else {
        ProgressDrawTarget::hidden()
    };
    let bar = ProgressBar::with_draw_target(Some(total), target).with_message(what);
    let style = ProgressStyle::with_template("{msg} {wide_bar} {percent:>3} % {eta} left");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_one_line_without_control_characters() {
        assert_eq!(one_line("a\n  b\u{1b}[2J"), "a b\\u{1b}[2J");
        assert_eq!(one_line("früh – 3 m²"), "früh – 3 m²");
    }
}
