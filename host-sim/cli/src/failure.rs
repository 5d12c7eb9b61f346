//! How the program ends when it cannot do what it was asked.

use super::output;
use clap::Command;
use clap::error::ErrorKind;
use core::error::Error;
use core::num::{IntErrorKind, ParseIntError};
use std::ffi::OsString;
use std::process::ExitCode;

/// Why a command could not be carried out.
#[derive(Debug)]
pub(super) enum Failure {
    /// The input or the usage is bad; the line says what, where and what to do.
    Input(String),
    /// A fault of our own.
    Internal(String),
}

impl Failure {
    /// What `error` says, as a fault of the input.
    pub(super) fn input(error: &dyn Error) -> Self {
        Self::Input(error.to_string())
    }

    /// Says so in one line on stderr and returns the exit code.
    pub(super) fn report(&self) -> ExitCode {
        let (line, code) = match self {
            Self::Input(line) => (line, 2),
            Self::Internal(line) => (line, 1),
        };
        output::note(&format!("certainty: {}", one_line(line)));
        ExitCode::from(code)
    }
}

/// What clap has to say of `arguments`: help and version on stdout, a usage error as one line that names
/// the help of the subcommand that was meant.
pub(super) fn usage(
    error: &clap::Error,
    command: &Command,
    arguments: &[OsString],
) -> Result<(), Failure> {
    let text = error.render().to_string();
    if let ErrorKind::DisplayHelp | ErrorKind::DisplayVersion = error.kind() {
        return output::print(&text);
    }
    let text = text.strip_prefix("error: ").unwrap_or(&text);
    let what = text.split("\n\nUsage:").next().unwrap_or(text);
    let what = what.split("\n\nFor more information").next();
    let what = what.unwrap_or(text).trim_end();
    let what = match error.kind() {
        ErrorKind::InvalidUtf8 => not_text(arguments),
        _ => in_words(what, error),
    };
    let first = arguments.first().and_then(|first| first.to_str());
    let subcommand = first.and_then(|name| command.find_subcommand(name));
    let of = subcommand.map_or_else(String::new, |meant| format!("{} ", meant.get_name()));
    Err(Failure::Input(format!("{what}; see certainty {of}--help")))
}

/// `what`, a complaint about a number in the words of a parser, in ours.
fn in_words(what: &str, error: &clap::Error) -> String {
    let source = error.source();
    let Some(number) = source.and_then(|source| source.downcast_ref::<ParseIntError>()) else {
        return what.to_owned();
    };
    let write = match number.kind() {
        IntErrorKind::Zero => "write a whole number from 1 on",
        IntErrorKind::PosOverflow => "too large; write a smaller whole number",
        _ => "write a whole number in digits alone, such as 7",
    };
    let what = what.strip_suffix(&number.to_string()).unwrap_or(what);
    format!("{what}{write}")
}

/// Where in `arguments` something is no text; a path need not be.
fn not_text(arguments: &[OsString]) -> String {
    let mut places: Vec<String> = Vec::new();
    let mut before: Option<&str> = None;
    for argument in arguments {
        let lossy = argument.to_string_lossy();
        if argument.to_str().is_none() {
            let option = match (lossy.strip_prefix("--"), before) {
                (Some(_), _) => lossy.split('=').next().unwrap_or(&lossy).to_owned(),
                (None, Some(option)) => option.to_owned(),
                (None, None) => format!("'{lossy}'"),
            };
            places.push(option);
        }
        before = argument.to_str().filter(|text| text.starts_with("--"));
    }
    let places = places.join(" or ");
    format!("{places}: what is written there is no text in UTF-8; write it anew")
}

/// `text` on one line: runs of white space, line ends among them, become one space; what would move a
/// terminal's cursor or change its colours is escaped.
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
    fn a_complaint_is_one_line_that_the_terminal_only_prints() {
        assert_eq!(one_line("a\n  b\u{1b}[2J"), "a b\\u{1b}[2J");
        assert_eq!(one_line("früh – 3 m²"), "früh – 3 m²");
    }
}
