//! Reads TOML files: of bounded size, and with the line of every error.

use serde::de::DeserializeOwned;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Largest file that is read, in bytes: about 40 000 obstacles.
const MOST_BYTES: u64 = 4 << 20;

/// Why a file was refused; displays as one line.
#[derive(Debug, Error)]
pub enum TomlError {
    /// The file cannot be read.
    #[error("{}: cannot read the {what}: {source}; check the path", file.display())]
    Unreadable {
        /// Its path.
        file: PathBuf,
        /// Its expected content.
        what: &'static str,
        /// The system's error.
        source: io::Error,
    },
    /// The file is a directory.
    #[error("{}: is a directory: expected a {what}", file.display())]
    Directory {
        /// Its path.
        file: PathBuf,
        /// Its expected content.
        what: &'static str,
    },
    /// The file is larger than 4 MiB.
    #[error("{}: over 4 MiB, too large for a {what}; check the path", file.display())]
    TooLong {
        /// Its path.
        file: PathBuf,
        /// Its expected content.
        what: &'static str,
    },
    /// Something in the file is not valid.
    #[error("{file}:{line}: {problem}")]
    Invalid {
        /// Its name.
        file: String,
        /// The line, from 1.
        line: usize,
        /// What is wrong and what is expected.
        problem: String,
    },
}

/// Reads the file at `path`; `what` names its content in errors.
///
/// # Errors
///
/// [`TomlError`] if it cannot be read or is too long.
pub fn read(path: &Path, what: &'static str) -> Result<Vec<u8>, TomlError> {
    let unreadable = |source: io::Error| {
        let file = path.to_owned();
        match source.kind() {
            io::ErrorKind::IsADirectory => TomlError::Directory { file, what },
            _ => TomlError::Unreadable { file, what, source },
        }
    };
    let mut bytes = Vec::new();
    // One byte more than allowed shows a longer file, or a device without end.
    File::open(path)
        .map_err(unreadable)?
        .take(MOST_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(unreadable)?;
    if bytes.len() as u64 > MOST_BYTES {
        let file = path.to_owned();
        return Err(TomlError::TooLong { file, what });
    }
    Ok(bytes)
}

/// The bytes of a file, and its name in errors.
#[derive(Debug, Clone, Copy)]
pub struct TomlFile<'a> {
    /// Its name.
    pub file: &'a str,
    /// Its content.
    pub bytes: &'a [u8],
    /// Its expected content.
    pub what: &'static str,
    /// A part of such a file, on one line.
    pub sample: &'static str,
}

impl TomlFile<'_> {
    /// Reads the content as a `T`.
    ///
    /// # Errors
    ///
    /// [`TomlError::Invalid`] with the line, and what is expected.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, TomlError> {
        let text = core::str::from_utf8(self.bytes).map_err(|e| {
            let problem = format!("not UTF-8 text; a {} is TOML", self.what);
            self.invalid(e.valid_up_to(), problem)
        })?;
        toml::from_str(text).map_err(|e| {
            let offset = e.span().map_or(0, |span| span.start);
            let mut problem = one_line(e.message());
            // The parser's message for a value of the wrong form has no example.
            let of_form = ["invalid type: ", "invalid length ", "missing field "];
            let hinted = problem.contains("such as");
            if !hinted && of_form.iter().any(|start| problem.starts_with(start)) {
                problem += &format!("; write for example: {}", self.sample);
            }
            self.invalid(offset, problem)
        })
    }

    /// The error for the byte at `offset`.
    #[must_use]
    pub fn invalid(&self, offset: usize, problem: String) -> TomlError {
        let before = self.bytes.get(..offset).unwrap_or(self.bytes);
        TomlError::Invalid {
            file: self.file.to_owned(),
            line: 1 + before.iter().filter(|&&byte| byte == b'\n').count(),
            problem,
        }
    }
}

/// A message as one line: breaks joined, control characters escaped, and cut at 300 characters.
fn one_line(message: &str) -> String {
    const MOST: usize = 300;
    let joined = message
        .lines()
        .map(str::trim)
        .filter(|line| !line.is_empty())
        .collect::<Vec<_>>()
        .join("; ");
    let mut line = String::new();
    for c in joined.chars().take(MOST) {
        if c.is_control() {
            line.extend(c.escape_default());
        } else {
            line.push(c);
        }
    }
    line
}
