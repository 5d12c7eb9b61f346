//! Lines of a file of any bytes, with bounded memory.

use super::skipped::{SkipReason, Skipped};
use std::io::{self, BufRead};

/// Splits a reader into numbered lines, none longer than [`Skipped::LONGEST_LINE`].
///
/// Takes off line feeds, carriage returns before them, and a byte order mark at the start.
#[derive(Debug)]
pub(super) struct Lines<R> {
    inner: R,
    buffer: Vec<u8>,
    number: u64,
    /// Bytes since the last line that was of use.
    barren: u64,
}

/// So many bytes without a line of use, and the source is given up: it may have no end.
const LONGEST_WASTE: u64 = 256 << 20;

impl<R: BufRead> Lines<R> {
    pub(super) const fn new(inner: R) -> Self {
        Self {
            inner,
            buffer: Vec::new(),
            number: 0,
            barren: 0,
        }
    }

    /// Says that the last line was of use.
    pub(super) const fn was_of_use(&mut self) {
        self.barren = 0;
    }

    /// The number of the line that [`Self::next`] gave or failed in, from 1.
    pub(super) const fn number(&self) -> u64 {
        self.number
    }

    /// Gives the reader back.
    pub(super) fn into_inner(self) -> R {
        self.inner
    }

    /// The next line or why it cannot be read; `None` at the end.
    ///
    /// Where the reader fails in the middle of a line, that line is lost: half a line may read as a
    /// whole one with a wrong number at its end.
    pub(super) fn next(&mut self) -> io::Result<Option<Result<&str, SkipReason>>> {
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
            if self.buffer.len() + part.len() > Skipped::LONGEST_LINE {
                too_long = true;
                self.buffer.clear();
            }
            if !too_long {
                self.buffer.extend_from_slice(part);
            }
            let taken = part.len() + usize::from(end.is_some());
            self.barren += taken as u64;
            if self.barren > LONGEST_WASTE {
                let mebibytes = LONGEST_WASTE >> 20;
                let message = format!("{mebibytes} MiB and no beam in them");
                return Err(io::Error::new(io::ErrorKind::InvalidData, message));
            }
            self.inner.consume(taken);
            if end.is_some() {
                break;
            }
        }
        if too_long {
            return Ok(Some(Err(SkipReason::TooLong)));
        }
        let Ok(text) = str::from_utf8(&self.buffer) else {
            return Ok(Some(Err(SkipReason::NotText)));
        };
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
    use std::io::{BufReader, Read};

    fn all(reader: impl Read) -> Vec<Result<String, SkipReason>> {
        // A tiny buffer, so that lines straddle it.
        let mut lines = Lines::new(BufReader::with_capacity(3, reader));
        let mut out = Vec::new();
        while let Some(line) = lines.next().unwrap() {
            out.push(line.map(str::to_owned));
        }
        out
    }

    #[test]
    fn line_ends_and_a_byte_order_mark_are_taken_off() {
        let text = "\u{FEFF}first\r\nsecond\n\nlast";
        let expected = ["first", "second", "", "last"].map(|line| Ok(line.to_owned()));
        assert_eq!(all(text.as_bytes()), expected);
    }

    #[test]
    fn a_line_without_end_is_skipped_and_not_held() {
        let endless = io::repeat(b'x').take(3 * Skipped::LONGEST_LINE as u64);
        let file = endless.chain(&b"\nnext\n"[..]);
        let mut lines = Lines::new(BufReader::new(file));
        assert_eq!(lines.next().unwrap(), Some(Err(SkipReason::TooLong)));
        assert!(lines.buffer.capacity() <= 2 * Skipped::LONGEST_LINE);
        assert_eq!(lines.next().unwrap(), Some(Ok("next")));
        assert_eq!(lines.number(), 2);
        assert_eq!(lines.next().unwrap(), None);
    }

    #[test]
    fn the_longest_line_is_read() {
        let longest = io::repeat(b'x').take(Skipped::LONGEST_LINE as u64);
        let mut lines = Lines::new(BufReader::new(longest.chain(&b"\n"[..])));
        assert_eq!(
            lines.next().unwrap().unwrap().unwrap().len(),
            Skipped::LONGEST_LINE
        );
    }

    #[test]
    fn bytes_that_are_no_text_cost_one_line() {
        assert_eq!(
            all(&b"a\n\xff\xfe\nb\n"[..]),
            [
                Ok("a".to_owned()),
                Err(SkipReason::NotText),
                Ok("b".to_owned())
            ]
        );
    }
}
