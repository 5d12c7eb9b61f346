//! The text of a recording's file: unpacked, split into lines, in bounded memory.

use super::recording::{SkipReason, Skipped};
use core::cell::Cell;
use flate2::bufread::GzDecoder;
use std::io::{self, BufRead, Cursor, Read};

/// A reader that counts the bytes that were read.
pub(super) struct Counted<'a, R> {
    pub(super) inner: R,
    pub(super) count: &'a Cell<u64>,
}

impl<R: Read> Read for Counted<'_, R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(out)?;
        self.count.set(self.count.get() + count as u64);
        Ok(count)
    }
}

/// The first bytes of every gzip file (RFC 1952 §2.3.1).
pub(super) const MAGIC: [u8; 2] = [0x1F, 0x8B];

/// Decompresses all members of a gzip file, one after the other.
///
/// Bytes behind the last member that are not a member (such as padding) are ignored and reported by
/// [`Self::trailing`]; `flate2`'s own reader of several members would fail on them as on damaged
/// data. A file that ends within a member fails with `UnexpectedEof`; other damage fails with another
/// kind.
#[derive(Debug)]
pub(super) struct Gunzip<R> {
    /// `None` behind the last member.
    member: Option<Box<GzDecoder<R>>>,
    trailing: bool,
}

impl<R: BufRead> Gunzip<R> {
    pub(super) fn new(inner: R) -> Self {
        Self {
            member: Some(Box::new(GzDecoder::new(inner))),
            trailing: false,
        }
    }

    /// Whether bytes followed the last member; known once the end was read.
    pub(super) const fn trailing(&self) -> bool {
        self.trailing
    }
}

impl<R: BufRead> Read for Gunzip<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        while let Some(mut member) = self.member.take() {
            let read = member.read(out);
            if out.is_empty() || !matches!(read, Ok(0)) {
                self.member = Some(member);
                return read;
            }
            let mut inner = member.into_inner();
            let next = inner.fill_buf()?;
            if next.first() == Some(&MAGIC[0]) {
                self.member = Some(Box::new(GzDecoder::new(inner)));
            } else {
                self.trailing = !next.is_empty();
            }
        }
        Ok(0)
    }
}

/// How much of the start shows the format, in bytes.
pub(super) const START: u64 = 64 * 1024;

/// A reader whose first [`START`] bytes can be examined; an error met there is returned again in its
/// place.
pub(super) struct Started<R> {
    start: Cursor<Vec<u8>>,
    /// The error within the start.
    pub(super) pending: Option<io::Error>,
    pub(super) rest: R,
}

impl<R: Read> Started<R> {
    pub(super) fn new(mut rest: R) -> Self {
        let mut start = Vec::new();
        // The bytes before an error are kept.
        let pending = rest.by_ref().take(START).read_to_end(&mut start).err();
        Self {
            start: Cursor::new(start),
            pending,
            rest,
        }
    }

    pub(super) fn start(&self) -> &[u8] {
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

/// Splits a reader into numbered lines, none longer than [`Skipped::LONGEST_LINE`].
///
/// Removes line feeds, carriage returns before them, and a byte order mark at the start.
#[derive(Debug)]
pub(super) struct Lines<R> {
    inner: R,
    buffer: Vec<u8>,
    /// Whether bytes that are not UTF-8 are replaced; otherwise they cost their line.
    lossy: bool,
    number: u64,
    /// Bytes since the last line with beams.
    unused: u64,
}

/// After this many bytes without a beam reading fails: the source may have no end.
const LONGEST_UNUSED: u64 = 256 << 20;

impl<R: BufRead> Lines<R> {
    pub(super) const fn new(inner: R) -> Self {
        Self {
            inner,
            buffer: Vec::new(),
            lossy: false,
            number: 0,
            unused: 0,
        }
    }

    /// Replaces bytes that are not UTF-8 by U+FFFD.
    pub(super) const fn lossy(mut self, lossy: bool) -> Self {
        self.lossy = lossy;
        self
    }

    /// Notes that the last line had beams.
    pub(super) const fn mark_used(&mut self) {
        self.unused = 0;
    }

    /// The number of the line that [`Self::next`] returned or failed in, from 1.
    pub(super) const fn number(&self) -> u64 {
        self.number
    }

    /// Returns the reader.
    pub(super) fn into_inner(self) -> R {
        self.inner
    }

    /// The next line or why it cannot be read; `None` at the end.
    ///
    /// If the reader fails within a line, that line is lost: half a line can look like a whole one with
    /// a wrong last number.
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
            return Ok(Some(Err(SkipReason::TooLong)));
        }
        if self.lossy && str::from_utf8(&self.buffer).is_err() {
            self.buffer = String::from_utf8_lossy(&self.buffer)
                .into_owned()
                .into_bytes();
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

/// `bytes` packed with gzip.
#[cfg(test)]
pub(super) fn gzip(bytes: &[u8]) -> Vec<u8> {
    use flate2::{Compression, write::GzEncoder};
    use std::io::Write;
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::BufReader;

    #[test]
    fn members_are_joined() {
        let file = [gzip(b"one "), gzip(b""), gzip(b"two")].concat();
        let mut gunzip = Gunzip::new(&file[..]);
        let mut out = Vec::new();
        gunzip.read_to_end(&mut out).unwrap();
        assert_eq!(out, b"one two");
        assert!(!gunzip.trailing());
    }

    #[test]
    fn padding_is_reported_and_harmless() {
        let file = [gzip(b"one"), vec![0; 512]].concat();
        let mut gunzip = Gunzip::new(&file[..]);
        let mut out = Vec::new();
        gunzip.read_to_end(&mut out).unwrap();
        assert_eq!(out, b"one");
        assert!(gunzip.trailing());
    }

    #[test]
    fn cut_is_an_unexpected_end_and_damage_is_not() {
        let whole = gzip(b"some text that is worth a few bytes, some text, some more text");
        for end in 2..whole.len() {
            let error = Gunzip::new(&whole[..end])
                .read_to_end(&mut Vec::new())
                .unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::UnexpectedEof, "cut at {end}");
        }
        let mut damaged = whole;
        let checksum = damaged.len() - 8;
        damaged[checksum] ^= 1;
        let error = Gunzip::new(&damaged[..])
            .read_to_end(&mut Vec::new())
            .unwrap_err();
        assert_ne!(error.kind(), io::ErrorKind::UnexpectedEof);
    }

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
    fn line_ends_and_byte_order_mark_are_removed() {
        let text = "\u{FEFF}first\r\nsecond\n\nlast";
        let expected = ["first", "second", "", "last"].map(|line| Ok(line.to_owned()));
        assert_eq!(all(text.as_bytes()), expected);
    }

    #[test]
    fn endless_line_is_skipped_in_bounded_memory() {
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
    fn longest_line_is_read() {
        let longest = io::repeat(b'x').take(Skipped::LONGEST_LINE as u64);
        let mut lines = Lines::new(BufReader::new(longest.chain(&b"\n"[..])));
        assert_eq!(
            lines.next().unwrap().unwrap().unwrap().len(),
            Skipped::LONGEST_LINE
        );
    }

    #[test]
    fn invalid_utf8_costs_one_line() {
        assert_eq!(
            all(&b"a\n\xff\xfe\nb\n"[..]),
            [
                Ok("a".to_owned()),
                Err(SkipReason::NotText),
                Ok("b".to_owned())
            ]
        );
        let mut lines = Lines::new(&b"a \xE4 b\n"[..]).lossy(true);
        assert_eq!(lines.next().unwrap(), Some(Ok("a \u{FFFD} b")));
    }
}
