//! Errors of the program: one line on stderr and an exit code.

use core::error::Error;
use std::io::Write;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_one_line_without_control_characters() {
        assert_eq!(one_line("a\n  b\u{1b}[2J"), "a b\\u{1b}[2J");
        assert_eq!(one_line("früh – 3 m²"), "früh – 3 m²");
    }
}
