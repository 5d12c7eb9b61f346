//! Unpacks gzip, xz, bzip2 and zip while it is read, in bounded memory.

use bzip2::bufread::MultiBzDecoder;
use core::fmt;
use flate2::Crc;
use flate2::bufread::{DeflateDecoder, GzDecoder};
use lzma_rust2::XzReader;
use std::io::{self, BufRead, Read};

/// How a file is packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Packing {
    /// It is not.
    Plain,
    /// By gzip (RFC 1952).
    Gzip,
    /// By xz.
    Xz,
    /// By bzip2.
    Bzip2,
    /// As the only file of a zip archive.
    Zip,
}

/// Length of the longest of the first bytes that show how a file is packed.
const LONGEST_MAGIC: u64 = 6;

/// Most memory for unpacking xz, in KiB: `xz -9` needs a quarter of it.
const XZ_KIBIBYTES: u32 = 256 << 10;

impl Packing {
    /// The packing of a file that begins with `start`.
    fn of(start: &[u8]) -> Self {
        match start {
            [0x1F, 0x8B, ..] => Self::Gzip,
            [0xFD, b'7', b'z', b'X', b'Z', 0, ..] => Self::Xz,
            [b'B', b'Z', b'h', b'1'..=b'9', ..] => Self::Bzip2,
            [b'P', b'K', 3, 4, ..] => Self::Zip,
            _ => Self::Plain,
        }
    }
}

impl fmt::Display for Packing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Plain => "plain",
            Self::Gzip => "gzip",
            Self::Xz => "xz",
            Self::Bzip2 => "bzip2",
            Self::Zip => "zip",
        })
    }
}

/// A file, unpacked while it is read.
///
/// Bytes behind gzip's last member that are not a member are ignored and reported by
/// [`Self::trailing`].
pub(super) enum Unpacked<R: Read> {
    Plain(R),
    Gzip(Gunzip<R>),
    Xz(Box<XzReader<R>>),
    Bzip2(Box<MultiBzDecoder<R>>),
    Zip(Box<Unzip<R>>),
}

impl<R: BufRead> Unpacked<R> {
    /// Examines the first bytes of `inner`.
    pub(super) fn new(mut inner: R) -> io::Result<Unpacked<io::Chain<io::Cursor<Vec<u8>>, R>>> {
        let mut magic = Vec::new();
        inner.by_ref().take(LONGEST_MAGIC).read_to_end(&mut magic)?;
        let packing = Packing::of(&magic);
        let whole = io::Cursor::new(magic).chain(inner);
        Ok(match packing {
            Packing::Plain => Unpacked::Plain(whole),
            Packing::Gzip => Unpacked::Gzip(Gunzip::new(whole)),
            Packing::Xz => {
                Unpacked::Xz(Box::new(XzReader::new_mem_limit(whole, true, XZ_KIBIBYTES)))
            }
            Packing::Bzip2 => Unpacked::Bzip2(Box::new(MultiBzDecoder::new(whole))),
            Packing::Zip => Unpacked::Zip(Box::new(Unzip::new(whole))),
        })
    }

    /// Returns how the file is packed.
    pub(super) const fn packing(&self) -> Packing {
        match self {
            Self::Plain(_) => Packing::Plain,
            Self::Gzip(_) => Packing::Gzip,
            Self::Xz(_) => Packing::Xz,
            Self::Bzip2(_) => Packing::Bzip2,
            Self::Zip(_) => Packing::Zip,
        }
    }

    /// Returns whether bytes followed the packed data; known once the end was read.
    pub(super) const fn trailing(&self) -> bool {
        match self {
            Self::Gzip(gunzip) => gunzip.trailing(),
            _ => false,
        }
    }
}

impl<R: BufRead> Read for Unpacked<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Plain(inner) => inner.read(out),
            Self::Gzip(inner) => inner.read(out),
            Self::Xz(inner) => inner.read(out),
            Self::Bzip2(inner) => inner.read(out),
            Self::Zip(inner) => inner.read(out),
        }
    }
}

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
    fn new(inner: R) -> Self {
        Self {
            member: Some(Box::new(GzDecoder::new(inner))),
            trailing: false,
        }
    }

    /// Whether bytes followed the last member; known once the end was read.
    const fn trailing(&self) -> bool {
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
            if next.first() == Some(&0x1F) {
                self.member = Some(Box::new(GzDecoder::new(inner)));
            } else {
                self.trailing = !next.is_empty();
            }
        }
        Ok(0)
    }
}

/// Unpacks the only file of a zip archive, front to back: a pipe has no end that could be read first.
///
/// Folders, and what macOS adds beside a file (`__MACOSX/`), are left out. The checksum is compared.
/// An archive of several files, an encrypted one, and a packing other than deflate is an error of
/// the kind [`io::ErrorKind::Unsupported`].
pub(super) struct Unzip<R> {
    state: UnzipState<R>,
    /// Whether a file was read.
    found: bool,
}

enum UnzipState<R> {
    /// Before a local header.
    Between(R),
    /// In a file; `wanted` if its content is returned.
    Within {
        body: Body<R>,
        crc: Crc,
        /// Bytes that were unpacked.
        length: u64,
        /// The checksum; `None` if it follows the file.
        expected: Option<u32>,
        wanted: bool,
    },
    /// Behind the last file, or an error.
    Done,
}

/// A file's content.
enum Body<R> {
    Stored(io::Take<R>),
    Deflated(Box<DeflateDecoder<R>>),
}

impl<R: BufRead> Body<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Stored(inner) => {
                let count = inner.read(out)?;
                if count == 0 && inner.limit() > 0 && !out.is_empty() {
                    return Err(io::ErrorKind::UnexpectedEof.into());
                }
                Ok(count)
            }
            Self::Deflated(inner) => inner.read(out),
        }
    }

    fn into_inner(self) -> R {
        match self {
            Self::Stored(inner) => inner.into_inner(),
            Self::Deflated(inner) => inner.into_inner(),
        }
    }
}

fn unsupported(what: &'static str) -> io::Error {
    io::Error::new(io::ErrorKind::Unsupported, what)
}

fn damaged(what: &'static str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what)
}

/// Reads the descriptor behind a file of `length` bytes (APPNOTE.TXT §4.3.9): its checksum.
///
/// Its signature may be absent, and its two lengths have 4 bytes each or, of zip64, 8: the length tells.
fn descriptor(inner: &mut impl Read, length: u64) -> io::Result<u32> {
    let mut word = [0; 4];
    inner.read_exact(&mut word)?;
    if word == *b"PK\x07\x08" {
        inner.read_exact(&mut word)?;
    }
    let mut packed = [0; 4];
    let mut unpacked = [0; 4];
    inner.read_exact(&mut packed)?;
    inner.read_exact(&mut unpacked)?;
    let low = (length & u64::from(u32::MAX)) as u32;
    if u32::from_le_bytes(unpacked) != low {
        let mut long = [0; 8];
        inner.read_exact(&mut long)?;
        if u64::from_le_bytes(long) != length {
            return Err(damaged("wrong length"));
        }
    }
    Ok(u32::from_le_bytes(word))
}

impl<R: BufRead> Unzip<R> {
    const fn new(inner: R) -> Self {
        Self {
            state: UnzipState::Between(inner),
            found: false,
        }
    }

    /// Reads a local header (APPNOTE.TXT §4.3.7) and enters its file; `None` at the central directory.
    fn enter(&mut self, mut inner: R) -> io::Result<UnzipState<R>> {
        const FILE: [u8; 4] = *b"PK\x03\x04";
        // A file in the central directory, the directory's end, and that of zip64.
        const DIRECTORY: [[u8; 4]; 3] = [*b"PK\x01\x02", *b"PK\x05\x06", *b"PK\x06\x06"];
        let mut signature = [0; 4];
        inner.read_exact(&mut signature)?;
        match signature {
            FILE => {}
            end if DIRECTORY.contains(&end) && self.found => return Ok(UnzipState::Done),
            end if DIRECTORY.contains(&end) => return Err(unsupported("the archive has no file")),
            _ => return Err(damaged("no header of a file")),
        }
        let mut header = [0; 26];
        inner.read_exact(&mut header)?;
        let short = |at: usize| u16::from_le_bytes([header[at], header[at + 1]]);
        let long = |at: usize| {
            u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]])
        };
        let (flags, method) = (short(2), short(4));
        let (crc, packed) = (long(10), long(14));
        let mut name = vec![0; short(22).into()];
        inner.read_exact(&mut name)?;
        let mut extra = vec![0; short(24).into()];
        inner.read_exact(&mut extra)?;
        let wanted = !name.ends_with(b"/") && !name.starts_with(b"__MACOSX/");
        if name.starts_with(b"[Content_Types].xml") || name.starts_with(b"xl/") {
            return Err(unsupported("it is a spreadsheet: save the sheet as CSV"));
        }
        if wanted && self.found {
            return Err(unsupported(
                "it has more than one file: unpack it and name one",
            ));
        }
        if flags & 1 != 0 {
            return Err(unsupported("it is encrypted: unpack it first"));
        }
        // Bit 3: checksum and lengths follow the file.
        let follows = flags & 8 != 0;
        let body = match method {
            0 if follows && wanted => {
                return Err(unsupported("its file has no length: unpack it first"));
            }
            0 => Body::Stored(inner.take(if follows { 0 } else { packed.into() })), // a folder has no bytes
            8 => Body::Deflated(Box::new(DeflateDecoder::new(inner))),
            _ => return Err(unsupported("it is not packed by deflate: unpack it first")),
        };
        self.found |= wanted;
        Ok(UnzipState::Within {
            body,
            crc: Crc::new(),
            length: 0,
            expected: (!follows).then_some(crc),
            wanted,
        })
    }
}

impl<R: BufRead> Read for Unzip<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let mut aside = [0; 4096];
        loop {
            match core::mem::replace(&mut self.state, UnzipState::Done) {
                UnzipState::Done => return Ok(0),
                UnzipState::Between(inner) => self.state = self.enter(inner)?,
                UnzipState::Within {
                    mut body,
                    mut crc,
                    mut length,
                    expected,
                    wanted,
                } => {
                    if out.is_empty() && wanted {
                        self.state = UnzipState::Within {
                            body,
                            crc,
                            length,
                            expected,
                            wanted,
                        };
                        return Ok(0);
                    }
                    let part = if wanted { &mut *out } else { &mut aside[..] };
                    let count = body.read(part)?;
                    if count > 0 {
                        crc.update(&part[..count]);
                        length += count as u64;
                        self.state = UnzipState::Within {
                            body,
                            crc,
                            length,
                            expected,
                            wanted,
                        };
                        if wanted {
                            return Ok(count);
                        }
                        continue;
                    }
                    let mut inner = body.into_inner();
                    let expected = match expected {
                        Some(expected) => expected,
                        None => descriptor(&mut inner, length)?,
                    };
                    if expected != crc.sum() {
                        return Err(damaged("wrong checksum"));
                    }
                    self.state = UnzipState::Between(inner);
                }
            }
        }
    }
}

/// `bytes` packed with gzip.
#[cfg(test)]
pub(crate) fn gzip(bytes: &[u8]) -> Vec<u8> {
    use flate2::{Compression, write::GzEncoder};
    use std::io::Write;
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

#[cfg(test)]
mod tests {
    use super::*;

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

    fn unpacked(file: &[u8]) -> io::Result<(Packing, Vec<u8>)> {
        let mut unpacked = Unpacked::new(file)?;
        let mut out = Vec::new();
        unpacked.read_to_end(&mut out)?;
        Ok((unpacked.packing(), out))
    }

    /// `hello, hello, hello\n`, packed by liblzma, libbz2 and Python.
    const XZ: &[u8] =
        b"\xfd\x37\x7a\x58\x5a\x00\x00\x04\xe6\xd6\xb4\x46\x02\x00\x21\x01\x16\x00\x00\x00\x74\x2f\
        \xe5\xa3\xe0\x00\x13\x00\x0e\x5d\x00\x34\x19\x49\xee\x8d\xef\x8c\x87\x31\xf5\x2f\x64\x00\
        \x00\x00\x00\x00\xb0\x48\x85\x59\xd7\xa9\xae\x4b\x00\x01\x2a\x14\x7e\xad\x37\x55\x1f\xb6\
        \xf3\x7d\x01\x00\x00\x00\x00\x04\x59\x5a";
    const BZIP2: &[u8] =
        b"\x42\x5a\x68\x39\x31\x41\x59\x26\x53\x59\xcb\x52\xe5\x67\x00\x00\x05\x51\x00\x00\x10\x40\
        \x04\x02\x44\xa0\x00\x21\x24\x31\x08\x60\x2f\x18\x44\xc7\x15\x17\x8b\xb9\x22\x9c\x28\x48\
        \x65\xa9\x72\xb3\x80";
    const ZIP: &[u8] =
        b"\x50\x4b\x03\x04\x14\x00\x00\x00\x08\x00\x00\x00\x21\x5c\xe7\x42\x6e\x52\x0c\x00\x00\x00\
        \x14\x00\x00\x00\x05\x00\x00\x00\x61\x2e\x63\x73\x76\xcb\x48\xcd\xc9\xc9\xd7\x51\xc8\x40\
        \xa2\xb8\x00\x50\x4b\x01\x02\x14\x03\x14\x00\x00\x00\x08\x00\x00\x00\x21\x5c\xe7\x42\x6e\
        \x52\x0c\x00\x00\x00\x14\x00\x00\x00\x05\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x80\
        \x01\x00\x00\x00\x00\x61\x2e\x63\x73\x76\x50\x4b\x05\x06\x00\x00\x00\x00\x01\x00\x01\x00\
        \x33\x00\x00\x00\x2f\x00\x00\x00\x00\x00";

    #[test]
    fn every_packing_gives_the_same_text() {
        let text = b"hello, hello, hello\n";
        let gzip = gzip(text);
        for (file, packing) in [
            (&text[..], Packing::Plain),
            (&gzip, Packing::Gzip),
            (XZ, Packing::Xz),
            (BZIP2, Packing::Bzip2),
            (ZIP, Packing::Zip),
        ] {
            assert_eq!(unpacked(file).unwrap(), (packing, text.to_vec()));
        }
    }

    #[test]
    fn a_cut_anywhere_is_an_error() {
        for file in [XZ, BZIP2] {
            for end in 6..file.len() {
                assert!(unpacked(&file[..end]).is_err(), "cut at {end}");
            }
        }
        // The central directory of a zip is not needed.
        let directory = ZIP
            .windows(4)
            .position(|four| four == b"PK\x01\x02")
            .unwrap();
        for end in 6..directory {
            let error = unpacked(&ZIP[..end]).unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::UnexpectedEof, "cut at {end}");
        }
    }

    #[test]
    fn an_archive_of_two_files_is_refused() {
        let directory = ZIP
            .windows(4)
            .position(|four| four == b"PK\x01\x02")
            .unwrap();
        let twice = [&ZIP[..directory], ZIP].concat();
        let error = unpacked(&twice).unwrap_err();
        assert!(error.to_string().contains("more than one file"), "{error}");
    }

    /// [`ZIP`] as a program writes it to a pipe: checksum and lengths behind the file.
    fn streamed(signature: &[u8], lengths: usize, checksum: u32) -> Vec<u8> {
        let directory = ZIP
            .windows(4)
            .position(|four| four == b"PK\x01\x02")
            .unwrap();
        let (file, rest) = ZIP.split_at(directory);
        let mut file = file.to_vec();
        file[6] |= 8;
        file[14..26].fill(0);
        let length = |bytes: u64| bytes.to_le_bytes()[..lengths].to_vec();
        let lengths = [length(12), length(20)].concat();
        [&file, signature, &checksum.to_le_bytes(), &lengths, rest].concat()
    }

    #[test]
    fn a_streamed_zip_is_checked_too() {
        let text = b"hello, hello, hello\n".to_vec();
        let checksum = u32::from_le_bytes([ZIP[14], ZIP[15], ZIP[16], ZIP[17]]);
        for signature in [&b"PK\x07\x08"[..], b""] {
            for lengths in [4, 8] {
                let file = streamed(signature, lengths, checksum);
                assert_eq!(unpacked(&file).unwrap(), (Packing::Zip, text.clone()));
                let damaged = streamed(signature, lengths, checksum ^ 1);
                assert_eq!(
                    unpacked(&damaged).unwrap_err().to_string(),
                    "wrong checksum"
                );
                let local = file
                    .windows(4)
                    .position(|four| four == b"PK\x01\x02")
                    .unwrap();
                let twice = [&file[..local], &file].concat();
                let error = unpacked(&twice).unwrap_err();
                assert!(error.to_string().contains("more than one file"), "{error}");
            }
        }
    }

    #[test]
    fn a_wrong_checksum_of_a_zip_is_an_error() {
        let mut damaged = ZIP.to_vec();
        damaged[14] ^= 1;
        let error = unpacked(&damaged).unwrap_err();
        assert_eq!(error.to_string(), "wrong checksum");
    }
}
