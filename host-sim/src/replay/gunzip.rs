//! Decompression that tells a file cut short from a damaged one.

use flate2::bufread::GzDecoder;
use std::io::{self, BufRead, Read};

/// The first bytes of every gzip file (RFC 1952 §2.3.1).
pub(super) const MAGIC: [u8; 2] = [0x1F, 0x8B];

/// Decompresses all members of a gzip file, one behind the other.
///
/// What follows the last member and is none itself (padding, say) is left alone and reported by
/// [`Self::trailing`]. A file that ends within a member fails with `UnexpectedEof`; any other
/// damage with another kind.
#[derive(Debug)]
pub(super) struct Gunzip<R> {
    state: State<R>,
    trailing: bool,
}

#[derive(Debug)]
enum State<R> {
    Member(Box<GzDecoder<R>>),
    Done,
}

impl<R: BufRead> Gunzip<R> {
    pub(super) fn new(inner: R) -> Self {
        Self {
            state: State::Member(Box::new(GzDecoder::new(inner))),
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
        loop {
            let State::Member(member) = &mut self.state else {
                return Ok(0);
            };
            let count = member.read(out)?;
            if count > 0 || out.is_empty() {
                return Ok(count);
            }
            let State::Member(member) = core::mem::replace(&mut self.state, State::Done) else {
                return Ok(0);
            };
            let mut inner = member.into_inner();
            let next = inner.fill_buf()?;
            if next.first() == Some(&MAGIC[0]) {
                self.state = State::Member(Box::new(GzDecoder::new(inner)));
            } else {
                self.trailing = !next.is_empty();
            }
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use flate2::{Compression, write::GzEncoder};
    use std::io::Write;

    pub(in crate::replay) fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

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
    fn padding_behind_the_last_member_is_reported_and_harmless() {
        let file = [gzip(b"one"), vec![0; 512]].concat();
        let mut gunzip = Gunzip::new(&file[..]);
        let mut out = Vec::new();
        gunzip.read_to_end(&mut out).unwrap();
        assert_eq!(out, b"one");
        assert!(gunzip.trailing());
    }

    #[test]
    fn every_cut_is_an_unexpected_end_and_a_flipped_bit_is_not() {
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
}
