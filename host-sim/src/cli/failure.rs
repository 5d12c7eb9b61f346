//! How the program ends when it cannot do what it was asked.

use super::output;
use clap::error::ErrorKind;
use core::error::Error;
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

/// What clap has to say: help and version on stdout, a usage error as one line.
pub(super) fn usage(error: &clap::Error) -> Result<(), Failure> {
    let text = error.render();
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => output::print(&text.to_string()),
        _ => {
            let text = text.to_string();
            let text = text.strip_prefix("error: ").unwrap_or(&text);
            let what = text.split("\n\nUsage:").next().unwrap_or(text);
            let what = what
                .split("\n\nFor more information")
                .next()
                .unwrap_or(what);
            Err(Failure::Input(format!("{what}; see certainty --help")))
        }
    }
}

/// `text` on one line: runs of white space, line ends among them, become one space.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
