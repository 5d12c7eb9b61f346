//! Bytes into reports, whatever the bytes are.

use super::{CRC, CRC_BYTES, FRAME, Report, VERSION, next_sequence};
use core::fmt;

/// A report with its number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Frame {
    /// The frame's number.
    pub sequence: u16,
    /// How many frames are missing before this one.
    pub lost: u16,
    /// What it carries.
    pub report: Report,
}

/// Why what lies between two zeros is no report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Damage {
    /// More bytes than a frame has.
    TooLong,
    /// The stuffing or the checksum is wrong: bytes were changed, lost or added.
    Checksum,
    /// It arrived as it was sent, in this other version of the wire format.
    OtherVersion(u8),
    /// It arrived as it was sent, but is no report.
    Undecodable,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLong => f.write_str("longer than a frame"),
            Self::Checksum => f.write_str("damaged"),
            Self::OtherVersion(version) => {
                write!(f, "version {version} of the format, not {VERSION}")
            }
            Self::Undecodable => f.write_str("not a report"),
        }
    }
}

impl core::error::Error for Damage {}

/// What a decoder heard so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Reports.
    pub frames: u64,
    /// Numbers missing between two reports: frames that came damaged or not at all.
    pub lost: u64,
    /// Times that the numbers began anew: the sender started, or another one talks.
    pub restarts: u64,
    /// [`Damage::TooLong`].
    pub too_long: u64,
    /// [`Damage::Checksum`].
    pub checksum: u64,
    /// [`Damage::OtherVersion`].
    pub other_version: u64,
    /// [`Damage::Undecodable`].
    pub undecodable: u64,
    /// Beginnings of a frame that the stream ended in.
    pub truncated: u64,
}

/// Takes bytes one by one and gives reports.
///
/// After anything that is no frame it goes on at the next zero. Cost: a byte is stored, and a zero
/// looks at no more than [`FRAME`] bytes twice.
#[derive(Debug, Clone)]
pub struct Decoder {
    bytes: heapless::Vec<u8, FRAME>,
    /// More came since the last zero than there is room for.
    overflown: bool,
    expected: Option<u16>,
    tally: Tally,
}

impl Decoder {
    /// Creates a decoder that has heard nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            bytes: heapless::Vec::new(),
            overflown: false,
            expected: None,
            tally: Tally {
                frames: 0,
                lost: 0,
                restarts: 0,
                too_long: 0,
                checksum: 0,
                other_version: 0,
                undecodable: 0,
                truncated: 0,
            },
        }
    }

    /// Returns what was heard so far.
    #[must_use]
    pub const fn tally(&self) -> &Tally {
        &self.tally
    }

    /// Takes a byte; returns the report that it ends, or what is wrong with what it ends.
    pub fn push(&mut self, byte: u8) -> Option<Result<Frame, Damage>> {
        if byte != 0 {
            self.overflown |= self.bytes.push(byte).is_err();
            return None;
        }
        if self.bytes.is_empty() {
            return None; // a zero more between two frames says nothing
        }
        let outcome = if self.overflown {
            Err(Damage::TooLong)
        } else {
            opened(&self.bytes)
        };
        self.bytes.clear();
        self.overflown = false;
        let count = match outcome {
            Ok(_) => &mut self.tally.frames,
            Err(Damage::TooLong) => &mut self.tally.too_long,
            Err(Damage::Checksum) => &mut self.tally.checksum,
            Err(Damage::OtherVersion(_)) => &mut self.tally.other_version,
            Err(Damage::Undecodable) => &mut self.tally.undecodable,
        };
        *count = count.saturating_add(1);
        Some(outcome.map(|(sequence, report)| Frame {
            sequence,
            lost: self.missing_before(sequence),
            report,
        }))
    }

    /// Says that no more bytes come: what has begun is counted as truncated.
    pub fn finish(&mut self) {
        if !self.bytes.is_empty() {
            self.tally.truncated = self.tally.truncated.saturating_add(1);
        }
        self.bytes.clear();
        self.overflown = false;
    }

    /// How many frames are missing before number `sequence`; counts them.
    fn missing_before(&mut self, sequence: u16) -> u16 {
        let expected = self.expected.replace(next_sequence(sequence));
        let Some(expected) = expected else {
            return 0; // who begins to listen has missed nothing
        };
        if sequence == expected {
            return 0;
        }
        // Numbers are 1 to 65535 after the first; zero is before them all.
        let ahead = if sequence >= expected {
            sequence.wrapping_sub(expected)
        } else {
            sequence.wrapping_sub(expected).wrapping_sub(1)
        };
        if sequence == 0 || ahead > u16::MAX / 2 {
            self.tally.restarts = self.tally.restarts.saturating_add(1);
            return 0;
        }
        self.tally.lost = self.tally.lost.saturating_add(ahead.into());
        ahead
    }
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

/// The number and the report in a frame without its end.
fn opened(frame: &[u8]) -> Result<(u16, Report), Damage> {
    let mut content = [0; FRAME];
    let length = cobs::decode(frame, &mut content)
        .map_err(|_| Damage::Checksum)?
        .frame_size();
    let (content, _) = content.split_at_checked(length).ok_or(Damage::Checksum)?;
    let (content, crc) = content
        .split_last_chunk::<CRC_BYTES>()
        .ok_or(Damage::Checksum)?;
    if CRC.checksum(content) != u32::from_le_bytes(*crc) {
        return Err(Damage::Checksum);
    }
    match content.split_first() {
        Some((&VERSION, body)) => match postcard::take_from_bytes(body) {
            Ok((numbered, [])) => Ok(numbered),
            _ => Err(Damage::Undecodable),
        },
        Some((&other, _)) => Err(Damage::OtherVersion(other)),
        None => Err(Damage::Undecodable),
    }
}
