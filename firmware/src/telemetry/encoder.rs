//! Reports into frames.

use super::{CRC, FRAME, Report, VERSION, next_sequence};
use core::{fmt, slice};
use postcard::ser_flavors::Flavor;

/// A report does not fit [`FRAME`], which a test rules out for every report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EncodeError;

impl fmt::Display for EncodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the report is longer than a frame")
    }
}

impl core::error::Error for EncodeError {}

/// Numbers reports and turns them into frames.
///
/// ```
/// use certainty_firmware::telemetry::{Decoder, Encoder, FRAME, Report, Statistics};
///
/// let report = Report::Statistics(Statistics::default());
/// let mut frame = [0; FRAME];
/// let mut encoder = Encoder::new();
/// let mut decoder = Decoder::new();
/// let bytes = encoder.encode(&report, &mut frame)?;
/// let mut heard = bytes.iter().filter_map(|&byte| decoder.push(byte));
/// assert_eq!(heard.next().unwrap().unwrap().report, report);
/// # Ok::<(), certainty_firmware::telemetry::EncodeError>(())
/// ```
#[derive(Debug, Clone, Default)]
#[expect(
    missing_copy_implementations,
    reason = "a copy made by accident would give two frames one number"
)]
pub struct Encoder {
    pub(super) sequence: u16,
}

impl Encoder {
    /// Creates an encoder whose first frame says that the sender has just started.
    #[must_use]
    pub const fn new() -> Self {
        Self { sequence: 0 }
    }

    /// Encodes `report` into `frame` and returns the part of it that is to be sent.
    ///
    /// Every call takes a number, so that a frame that is never sent is missed by the receiver.
    ///
    /// # Errors
    ///
    /// [`EncodeError`] if the report does not fit.
    pub fn encode<'f>(
        &mut self,
        report: &Report,
        frame: &'f mut [u8; FRAME],
    ) -> Result<&'f [u8], EncodeError> {
        let sequence = self.sequence;
        self.sequence = next_sequence(sequence);
        let [code, content @ ..] = &mut *frame;
        *code = 0;
        let mut body = Body::new(content);
        body.push(VERSION)?;
        let body = postcard::serialize_with_flavor(&(sequence, report), body);
        let mut length = body.map_err(|_| EncodeError)?;
        let (written, rest) = content.split_at_mut_checked(length).ok_or(EncodeError)?;
        let crc = CRC.checksum(written).to_le_bytes();
        *rest.first_chunk_mut().ok_or(EncodeError)? = crc;
        // The code byte, what was written, and its checksum.
        length = length.saturating_add(1).saturating_add(crc.len());
        let (stuffed, rest) = frame.split_at_mut_checked(length).ok_or(EncodeError)?;
        stuff(stuffed);
        *rest.first_mut().ok_or(EncodeError)? = 0;
        frame.get(..=length).ok_or(EncodeError)
    }
}

/// Where postcard writes; its own slice has a subtraction that the compiler cannot prove.
struct Body<'f> {
    rest: slice::IterMut<'f, u8>,
    length: usize,
}

impl<'f> Body<'f> {
    fn new(bytes: &'f mut [u8]) -> Self {
        Self {
            rest: bytes.iter_mut(),
            length: 0,
        }
    }

    fn push(&mut self, byte: u8) -> Result<(), EncodeError> {
        *self.rest.next().ok_or(EncodeError)? = byte;
        self.length = self.length.saturating_add(1);
        Ok(())
    }
}

impl Flavor for Body<'_> {
    type Output = usize;

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.try_extend(&[byte])
    }

    #[inline(never)]
    fn try_extend(&mut self, bytes: &[u8]) -> postcard::Result<()> {
        for &byte in bytes {
            self.push(byte)
                .map_err(|EncodeError| postcard::Error::SerializeBufferFull)?;
        }
        Ok(())
    }

    fn finalize(self) -> postcard::Result<usize> {
        Ok(self.length)
    }
}

/// Replaces every zero by the distance to the next one or to the end (COBS).
///
/// The first byte is made a zero before, and so becomes the code byte. Needs no second buffer; right
/// for up to 254 bytes after the first, where COBS needs one code byte.
fn stuff(bytes: &mut [u8]) {
    const { assert!(FRAME - 2 <= 254) }
    let mut distance = 1_u8;
    for byte in bytes.iter_mut().rev() {
        if *byte == 0 {
            *byte = distance;
            distance = 1;
        } else {
            distance = distance.saturating_add(1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The crate that decodes is the oracle.
        #[test]
        fn stuffing_in_place_is_cobs(
            content in prop::collection::vec(prop_oneof![Just(0), any::<u8>()], 0..=254),
        ) {
            let mut ours = [&[0], &*content].concat();
            stuff(&mut ours);
            let mut theirs = vec![0; cobs::max_encoding_length(content.len())];
            let length = cobs::encode(&content, &mut theirs);
            // A full run of 254 may be closed by a further code byte or not.
            prop_assert_eq!(&ours[..], &theirs[..length.min(ours.len())]);
            let mut back = vec![0; content.len() + 1];
            let report = cobs::decode(&ours, &mut back).unwrap();
            prop_assert_eq!(&back[..report.frame_size()], &content[..]);
        }
    }
}
