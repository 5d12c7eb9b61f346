//! Numbered lines of text, in bounded memory.

use core::cell::Cell;
use std::io::{self, BufRead, Cursor, Read};

/// Why a line cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BadLine {
    /// It is longer than [`LONGEST_LINE`].
    TooLong,
    /// It has a byte 0, which no text has.
    NotText,
}

/// The longest line that is read, in bytes; a longer one is never held in memory.
pub(crate) const LONGEST_LINE: usize = 1 << 20;

/// A reader that counts the bytes that were read.
pub(crate) struct Counted<'a, R> {
    pub(crate) inner: R,
    pub(crate) count: &'a Cell<u64>,
}

impl<R: Read> Read for Counted<'_, R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(out)?;
        self.count.set(self.count.get() + count as u64);
        Ok(count)
    }
}

/// How much of the start shows the format, in bytes.
pub(crate) const START: u64 = 64 * 1024;

/// A reader whose first [`START`] bytes can be examined; an error met there is returned again in its
/// place.
pub(crate) struct Started<R> {
    start: Cursor<Vec<u8>>,
    /// The error within the start.
    pub(crate) pending: Option<io::Error>,
    pub(crate) rest: R,
}

impl<R: Read> Started<R> {
    pub(crate) fn new(mut rest: R) -> Self {
        let mut start = Vec::new();
        // The bytes before an error are kept.
        let pending = rest.by_ref().take(START).read_to_end(&mut start).err();
        Self {
            start: Cursor::new(start),
            pending,
            rest,
        }
    }

    pub(crate) fn start(&self) -> &[u8] {
        self.start.get_ref()
    }
}

impl<R: Read> Read for Started<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = self.start.read(out)?;
        if count > 0 || out.is_empty() {
            return Ok(count);
        }
        match self.pending.take() {
            Some(error) => Err(error),
            None => self.rest.read(out),
        }
    }
}

/// Splits a reader into numbered lines, none longer than [`LONGEST_LINE`].
///
/// Removes line feeds, carriage returns before them, and a byte order mark at the start. Bytes that are
/// not UTF-8 become U+FFFD: a name in another encoding, such as a host's, costs nothing, and a number
/// with such a byte is no number.
#[derive(Debug)]
pub(crate) struct Lines<R> {
    inner: R,
    buffer: Vec<u8>,
    number: u64,
    /// Bytes since the last line with beams.
    unused: u64,
}

/// After this many bytes without a beam reading fails: the source may have no end.
const LONGEST_UNUSED: u64 = 256 << 20;

impl<R: BufRead> Lines<R> {
    pub(crate) const fn new(inner: R) -> Self {
        Self {
            inner,
            buffer: Vec::new(),
            number: 0,
            unused: 0,
        }
    }

    /// Notes that the last line had beams.
    pub(crate) const fn mark_used(&mut self) {
        self.unused = 0;
    }

    /// The number of the line that [`Self::next`] returned or failed in, from 1.
    pub(crate) const fn number(&self) -> u64 {
        self.number
    }

    /// The next line or why it cannot be read; `None` at the end.
    ///
    /// If the reader fails within a line, that line is lost: half a line can look like a whole one with
    /// a wrong last number.
    pub(crate) fn next(&mut self) -> io::Result<Option<Result<&str, BadLine>>> {
        self.buffer.clear();
        self.number += 1;
        let mut any = false;
        let mut too_long = false;
        loop {
            let chunk = match self.inner.fill_buf() {
                Ok(chunk) => chunk,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) => return Err(error),
            };
            if chunk.is_empty() {
                if !any {
                    return Ok(None);
                }
                break;
            }
            any = true;
            let end = chunk.iter().position(|&byte| byte == b'\n');
            let part = &chunk[..end.unwrap_or(chunk.len())];
            if self.buffer.len() + part.len() > LONGEST_LINE {
                too_long = true;
                self.buffer.clear();
            }
            if !too_long {
                self.buffer.extend_from_slice(part);
            }
            let taken = part.len() + usize::from(end.is_some());
            self.unused += taken as u64;
            if self.unused > LONGEST_UNUSED {
                let mebibytes = LONGEST_UNUSED >> 20;
                let message = format!("{mebibytes} MiB and no beam in them");
                return Err(io::Error::new(io::ErrorKind::InvalidData, message));
            }
            self.inner.consume(taken);
            if end.is_some() {
                break;
            }
        }
        if too_long {
            return Ok(Some(Err(BadLine::TooLong)));
        }
        if self.buffer.contains(&0) {
            return Ok(Some(Err(BadLine::NotText)));
        }
        if str::from_utf8(&self.buffer).is_err() {
            let replaced = String::from_utf8_lossy(&self.buffer).into_owned();
            self.buffer = replaced.into_bytes();
        }
        // It is UTF-8 now.
        let text = str::from_utf8(&self.buffer).unwrap_or_default();
        let text = text.strip_suffix('\r').unwrap_or(text);
        let text = if self.number == 1 {
            text.strip_prefix('\u{FEFF}').unwrap_or(text)
        } else {
            text
        };
        Ok(Some(Ok(text)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::BufReader;

    fn all(reader: impl Read) -> Vec<Result<String, BadLine>> {
        // A tiny buffer, so that lines straddle it.
        let mut lines = Lines::new(BufReader::with_capacity(3, reader));
        let mut out = Vec::new();
        while let Some(line) = lines.next().unwrap() {
            out.push(line.map(str::to_owned));
        }
        out
    }

    #[test]
    fn line_ends_and_byte_order_mark_are_removed() {
        let text = "\u{FEFF}first\r\nsecond\n\nlast";
        let expected = ["first", "second", "", "last"].map(|line| Ok(line.to_owned()));
        assert_eq!(all(text.as_bytes()), expected);
    }

    #[test]
    fn endless_line_is_skipped_in_bounded_memory() {
        let endless = io::repeat(b'x').take(3 * LONGEST_LINE as u64);
        let file = endless.chain(&b"\nnext\n"[..]);
        let mut lines = Lines::new(BufReader::new(file));
        assert_eq!(lines.next().unwrap(), Some(Err(BadLine::TooLong)));
        assert!(lines.buffer.capacity() <= 2 * LONGEST_LINE);
        assert_eq!(lines.next().unwrap(), Some(Ok("next")));
        assert_eq!(lines.number(), 2);
        assert_eq!(lines.next().unwrap(), None);
    }

    #[test]
    fn longest_line_is_read() {
        let longest = io::repeat(b'x').take(LONGEST_LINE as u64);
        let mut lines = Lines::new(BufReader::new(longest.chain(&b"\n"[..])));
        assert_eq!(lines.next().unwrap().unwrap().unwrap().len(), LONGEST_LINE);
    }

    #[test]
    fn a_name_in_another_encoding_costs_nothing() {
        let expected = ["a", "h\u{FFFD}st 1", "b"].map(|line| Ok(line.to_owned()));
        assert_eq!(all(&b"a\nh\xF6st 1\nb\n"[..]), expected);
    }

    #[test]
    fn a_zero_byte_costs_its_line() {
        let b = Ok("b".to_owned());
        assert_eq!(all(&b"a\0\nb\n"[..]), [Err(BadLine::NotText), b]);
    }
}
