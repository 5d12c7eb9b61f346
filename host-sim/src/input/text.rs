//! A file or stdin as numbered lines of text.

use super::foreign::{Foreign, foreign};
use super::lines::{BadLine, Counted, Lines, Started};
use super::unpack::{Packing, Unpacked};
use crate::export::display_path;
use core::cell::Cell;
use encoding_rs::{Encoding, UTF_16BE, UTF_16LE};
use encoding_rs_io::DecodeReaderBytesBuilder;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Why a file cannot be read as text; displays as one line that says what to do.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// The file cannot be opened.
    #[error("{}: cannot be opened ({source}); check its name and permissions", display_path(.path))]
    Open {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The file is a directory.
    #[error("{}: is a directory: expected {expected}", display_path(.path))]
    Directory {
        /// The directory.
        path: PathBuf,
        /// What was expected.
        expected: &'static str,
    },
    /// The file, unpacked, has no bytes.
    #[error("{}: is empty: expected {expected}", display_path(.path))]
    Empty {
        /// The file.
        path: PathBuf,
        /// What was expected.
        expected: &'static str,
    },
    /// The packed data are damaged, or cut short where that matters.
    #[error(
        "{}:{line}: the {packing} data are damaged ({source}); copy the file anew or repair it",
        display_path(.path)
    )]
    Damaged {
        /// The file.
        path: PathBuf,
        /// The line of the unpacked text at the damage.
        line: u64,
        /// How the file is packed.
        packing: Packing,
        /// The decoder's error.
        source: io::Error,
    },
    /// The packing is not supported.
    #[error("{}: this {packing} file cannot be read: {source}", display_path(.path))]
    Packing {
        /// The file.
        path: PathBuf,
        /// How the file is packed.
        packing: Packing,
        /// What is not supported, and what to do.
        source: io::Error,
    },
    /// Reading failed.
    #[error("{}:{line}: reading failed ({source}); check the disk and try again", display_path(.path))]
    Read {
        /// The file.
        path: PathBuf,
        /// The line that it failed in.
        line: u64,
        /// The system's error.
        source: io::Error,
    },
    /// The file has no end, or much that is of no use.
    #[error("{}: {source}; give a recording or a table", display_path(.path))]
    Endless {
        /// The file.
        path: PathBuf,
        /// How much was read.
        source: io::Error,
    },
    /// The file has another format.
    #[error("{}: {foreign}", display_path(.path))]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What it looks like, and how to bring it in.
        foreign: Foreign,
    },
}

/// The name that means stdin.
const STDIN: &str = "-";

/// The lines of a file.
pub(crate) struct Text<'a> {
    path: PathBuf,
    lines: Lines<BufReader<Started<Box<dyn Read + 'a>>>>,
    packing: Packing,
    trailing: Rc<Cell<bool>>,
    start: Vec<u8>,
}

/// Notes when an unpacked file has bytes behind its packed data.
struct Noted<R: Read> {
    inner: Unpacked<R>,
    trailing: Rc<Cell<bool>>,
}

impl<R: io::BufRead> Read for Noted<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(out)?;
        self.trailing.set(self.inner.trailing());
        Ok(count)
    }
}

impl<'a> Text<'a> {
    /// Opens the file at `path`, or stdin for `-`; returns its length too, 0 if it is not known.
    ///
    /// `done` counts the bytes that were read, before they are unpacked. `expected` is what the file
    /// is to be, for messages.
    pub(crate) fn open(
        path: &Path,
        expected: &'static str,
        done: &'a Cell<u64>,
    ) -> Result<(Self, u64), InputError> {
        if path.as_os_str() == STDIN {
            let counted = Counted {
                inner: io::stdin().lock(),
                count: done,
            };
            let name = Path::new("stdin");
            return Ok((Self::new(name, expected, counted)?, 0));
        }
        let open = |source| InputError::Open {
            path: path.into(),
            source,
        };
        let file = File::open(path).map_err(open)?;
        let metadata = file.metadata().map_err(open)?;
        if metadata.is_dir() {
            let path = path.into();
            return Err(InputError::Directory { path, expected });
        }
        let counted = Counted {
            inner: file,
            count: done,
        };
        Ok((Self::new(path, expected, counted)?, metadata.len()))
    }

    /// Reads `source`; `path` is for messages.
    pub(crate) fn new(
        path: &Path,
        expected: &'static str,
        source: impl Read + 'a,
    ) -> Result<Self, InputError> {
        let trailing = Rc::new(Cell::new(false));
        let unpacked = Unpacked::new(BufReader::with_capacity(1 << 16, source));
        let unpacked = unpacked.map_err(|source| InputError::Read {
            path: path.into(),
            line: 1,
            source,
        })?;
        let packing = unpacked.packing();
        let noted = Noted {
            inner: unpacked,
            trailing: Rc::clone(&trailing),
        };
        let started = line_feeds(utf8(noted));
        let start = started.start().to_vec();
        let mut text = Self {
            path: path.into(),
            lines: Lines::new(BufReader::with_capacity(1 << 16, started)),
            packing,
            trailing,
            start,
        };
        if text.start.is_empty() {
            // The error within the start, if there is one.
            text.next()?;
            let path = path.into();
            return Err(InputError::Empty { path, expected });
        }
        if let Some(foreign) = Foreign::binary(&text.start) {
            let path = path.into();
            return Err(InputError::Foreign { path, foreign });
        }
        Ok(text)
    }

    /// Returns the first bytes of the text.
    pub(crate) fn start(&self) -> &[u8] {
        &self.start
    }

    /// Returns the file's name for messages.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the number of the line that [`Self::next`] returned or failed in, from 1.
    pub(crate) const fn number(&self) -> u64 {
        self.lines.number()
    }

    /// Notes that the last line had something to use: reading fails after too many without.
    pub(crate) const fn mark_used(&mut self) {
        self.lines.mark_used();
    }

    /// Returns whether bytes followed the packed data; known at the end.
    pub(crate) fn trailing(&self) -> bool {
        self.trailing.get()
    }

    /// Returns the next line, or why it cannot be read; `None` at the end.
    pub(crate) fn next(&mut self) -> Result<Option<Result<&str, BadLine>>, InputError> {
        let (path, packing) = (&self.path, self.packing);
        let line = self.lines.number() + 1;
        self.lines
            .next()
            .map_err(|source| failed(path, line, packing, source))
    }

    /// The error for a file of an unknown format, if it looks like a known one of others.
    pub(crate) fn foreign(&self) -> Option<InputError> {
        let foreign = foreign(&self.start)?;
        let path = self.path.clone();
        Some(InputError::Foreign { path, foreign })
    }
}

impl InputError {
    /// Whether packed data are cut short: what was read before is sound.
    pub(crate) fn is_cut(&self) -> bool {
        matches!(self, Self::Damaged { source, .. } if source.kind() == io::ErrorKind::UnexpectedEof)
    }
}

/// The error of a reader that failed in `line`: the decoder's kinds of error mean a damaged file.
fn failed(path: &Path, line: u64, packing: Packing, source: io::Error) -> InputError {
    let path = path.into();
    match source.kind() {
        io::ErrorKind::InvalidData if packing == Packing::Plain => {
            InputError::Endless { path, source }
        }
        _ if packing == Packing::Plain => InputError::Read { path, line, source },
        io::ErrorKind::Unsupported => InputError::Packing {
            path,
            packing,
            source,
        },
        io::ErrorKind::OutOfMemory => InputError::Packing {
            path,
            packing,
            source: io::Error::other("it needs over 256 MiB of memory: unpack it first"),
        },
        io::ErrorKind::UnexpectedEof
        | io::ErrorKind::InvalidData
        | io::ErrorKind::InvalidInput
        | io::ErrorKind::Other => InputError::Damaged {
            path,
            line,
            packing,
            source,
        },
        _ => InputError::Read { path, line, source },
    }
}

/// Text with line feeds: those of the old Macintosh, whose lines end with a carriage return alone, in
/// their place.
fn line_feeds<'a>(started: Started<Box<dyn Read + 'a>>) -> Started<Box<dyn Read + 'a>> {
    let start = started.start();
    let old = start.contains(&b'\r') && !start.contains(&b'\n') && Foreign::binary(start).is_none();
    if !old {
        return started;
    }
    Started::new(Box::new(LineFeeds(started)))
}

/// A reader with a line feed in the place of each carriage return.
struct LineFeeds<R>(R);

impl<R: Read> Read for LineFeeds<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = self.0.read(out)?;
        for byte in out.iter_mut().take(count).filter(|byte| **byte == b'\r') {
            *byte = b'\n';
        }
        Ok(count)
    }
}

/// Text in UTF-8, whatever the byte order mark announces.
fn utf8<'a>(source: impl Read + 'a) -> Started<Box<dyn Read + 'a>> {
    let boxed: Box<dyn Read + 'a> = Box::new(source);
    let started = Started::new(boxed);
    let encoding: &'static Encoding = match started.start() {
        [0xFF, 0xFE, ..] => UTF_16LE,
        [0xFE, 0xFF, ..] => UTF_16BE,
        _ => return started,
    };
    let decoded = DecodeReaderBytesBuilder::new()
        .encoding(Some(encoding))
        .build(started);
    Started::new(Box::new(decoded))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(bytes: &[u8]) -> Result<Vec<String>, String> {
        let text = Text::new(Path::new("f"), "a table", bytes);
        let mut text = text.map_err(|error| error.to_string())?;
        let mut all = Vec::new();
        while let Some(line) = text.next().map_err(|error| error.to_string())? {
            all.push(line.map_err(|bad| format!("{bad:?}"))?.to_owned());
        }
        Ok(all)
    }

    #[test]
    fn utf_16_of_a_spreadsheet_is_read() {
        let text = "dist_cm\tleft\r\n10\t22,5\r\n";
        let little = text.encode_utf16().flat_map(u16::to_le_bytes);
        let little: Vec<u8> = [0xFF, 0xFE].into_iter().chain(little).collect();
        let big = text.encode_utf16().flat_map(u16::to_be_bytes);
        let big: Vec<u8> = [0xFE, 0xFF].into_iter().chain(big).collect();
        let expected = Ok(vec!["dist_cm\tleft".to_owned(), "10\t22,5".to_owned()]);
        assert_eq!(lines(&little), expected);
        assert_eq!(lines(&big), expected);
    }

    #[test]
    fn every_refusal_is_one_line_with_the_file() {
        for (bytes, words) in [
            (&b""[..], "f: is empty: expected a table"),
            (
                b"\x28\xB5\x2F\xFD....",
                "f: it is packed by zstd: unpack it with",
            ),
            (b"PK\x03\x04", "f:1: the zip data are damaged"),
            (b"BZh9", "f:1: the bzip2 data are damaged"),
            (b"\xFD7zXZ\0", "f:1: the xz data are damaged"),
        ] {
            let line = lines(bytes).unwrap_err();
            assert!(line.starts_with(words), "{line}");
            assert_eq!(line.lines().count(), 1);
        }
    }
}
