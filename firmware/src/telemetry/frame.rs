//! Frames: reports as bytes, and back.

use super::report::{PART_CELLS, Report};
use core::{fmt, slice};
use postcard::ser_flavors::Flavor;

/// The version of the wire format, the first byte of every frame.
pub const VERSION: u8 = 3;

/// The length of the longest frame, its end included, in bytes.
///
/// Formula: 1 code byte, 1 version, 3 sequence, [`PART_CELLS`] + 16 for the longest report (the last part of
/// a map), 4 CRC, 1 end. COBS needs one code byte for up to 254 bytes.
pub const FRAME: usize = 10 + PART_CELLS + 16;

/// The checksum of a frame; the version without a table takes the least flash.
const CRC: crc::Crc<u32, crc::NoTable> = crc::Crc::<u32, crc::NoTable>::new(&crc::CRC_32_ISO_HDLC);

/// Bytes of [`CRC`].
const CRC_BYTES: usize = 4;

/// The sequence number after `sequence`: after the highest comes 1.
const fn next_sequence(sequence: u16) -> u16 {
    match sequence.checked_add(1) {
        Some(next) => next,
        None => 1,
    }
}

/// A report does not fit into [`FRAME`] bytes; tests show that every report fits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EncodeError;

impl fmt::Display for EncodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the report does not fit into a frame")
    }
}

impl core::error::Error for EncodeError {}

/// Numbers reports and encodes them as frames.
///
/// ```
/// use certainty_firmware::telemetry::{Decoder, Encoder, FRAME, Report, Statistics};
///
/// let report = Report::Statistics(Statistics::default());
/// let mut frame = [0; FRAME];
/// let mut encoder = Encoder::new();
/// let mut decoder = Decoder::new();
/// let bytes = encoder.encode(&report, &mut frame)?;
/// let mut received = bytes.iter().filter_map(|&byte| decoder.push(byte));
/// assert_eq!(received.next().unwrap().unwrap().report, report);
/// # Ok::<(), certainty_firmware::telemetry::EncodeError>(())
/// ```
#[derive(Debug, Clone, Default)]
#[expect(
    missing_copy_implementations,
    reason = "a copy would give two frames the same number"
)]
pub struct Encoder {
    sequence: u16,
}

impl Encoder {
    /// Creates an encoder; its first frame has number 0, which marks a start.
    #[must_use]
    pub const fn new() -> Self {
        Self { sequence: 0 }
    }

    /// Encodes `report` into `frame` and returns the bytes to send.
    ///
    /// Every call uses up a number, so the receiver notices frames that were not sent.
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
        // The code byte, the content and its checksum.
        length = length.saturating_add(1).saturating_add(crc.len());
        let (stuffed, rest) = frame.split_at_mut_checked(length).ok_or(EncodeError)?;
        stuff(stuffed);
        *rest.first_mut().ok_or(EncodeError)? = 0;
        frame.get(..=length).ok_or(EncodeError)
    }
}

/// The output of postcard; postcard's own slice flavor links an overflow panic.
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

/// Replaces every zero by the distance to the next zero or to the end (COBS), in place.
///
/// The first byte must be zero; it becomes the code byte. Correct for up to 254 bytes after it, where COBS
/// needs one code byte.
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

/// A report with its number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Frame {
    /// The frame's number.
    pub sequence: u16,
    /// The number of frames missing before this one.
    pub lost: u16,
    /// The report in it.
    pub report: Report,
}

/// Why the bytes between two zeros are not a report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Damage {
    /// More than [`FRAME`] bytes.
    TooLong,
    /// Stuffing or checksum is wrong: bytes were changed, lost or added.
    Checksum,
    /// The frame is intact but in this other version of the wire format.
    OtherVersion(u8),
    /// The frame is intact but its content is not a report.
    Undecodable,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLong => write!(f, "too long: expected at most {FRAME} bytes"),
            Self::Checksum => f.write_str("wrong checksum"),
            Self::OtherVersion(version) => {
                write!(f, "version {version} of the format: expected {VERSION}")
            }
            Self::Undecodable => f.write_str("not a report"),
        }
    }
}

impl core::error::Error for Damage {}

/// Counts of a decoder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Decoded reports.
    pub frames: u64,
    /// Missing numbers between reports: frames that were damaged or lost.
    pub lost: u64,
    /// Restarts of the numbers: the sender started again, or another sender uses the line.
    pub restarts: u64,
    /// [`Damage::TooLong`].
    pub too_long: u64,
    /// [`Damage::Checksum`].
    pub checksum: u64,
    /// [`Damage::OtherVersion`].
    pub other_version: u64,
    /// [`Damage::Undecodable`].
    pub undecodable: u64,
    /// Frames that the end of the stream cut off.
    pub truncated: u64,
}

/// Decodes reports from single bytes.
///
/// After invalid bytes it resumes at the next zero. Cost: each byte is stored; a zero processes at most
/// [`FRAME`] bytes twice.
#[derive(Debug, Clone)]
pub struct Decoder {
    bytes: heapless::Vec<u8, FRAME>,
    /// More than [`FRAME`] bytes came since the last zero.
    overflowed: bool,
    expected: Option<u16>,
    tally: Tally,
}

impl Decoder {
    /// Creates a decoder that has received nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            bytes: heapless::Vec::new(),
            overflowed: false,
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

    /// Returns the counts since the start.
    #[must_use]
    pub const fn tally(&self) -> &Tally {
        &self.tally
    }

    /// Takes a byte; if it ends a frame, returns the report or what is wrong with the frame.
    pub fn push(&mut self, byte: u8) -> Option<Result<Frame, Damage>> {
        if byte != 0 {
            self.overflowed |= self.bytes.push(byte).is_err();
            return None;
        }
        if self.bytes.is_empty() {
            return None; // further zeros between two frames are allowed
        }
        let outcome = if self.overflowed {
            Err(Damage::TooLong)
        } else {
            decode(&self.bytes)
        };
        self.bytes.clear();
        self.overflowed = false;
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

    /// Ends the stream: a frame that has begun is counted as truncated.
    pub fn finish(&mut self) {
        if !self.bytes.is_empty() {
            self.tally.truncated = self.tally.truncated.saturating_add(1);
        }
        self.bytes.clear();
        self.overflowed = false;
    }

    /// Returns the number of frames missing before number `sequence` and counts them.
    fn missing_before(&mut self, sequence: u16) -> u16 {
        let expected = self.expected.replace(next_sequence(sequence));
        let Some(expected) = expected else {
            return 0; // the first frame received
        };
        if sequence == expected {
            return 0;
        }
        // After the first frame, 0, numbers are 1 to 65535.
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

/// Returns the number and the report in a frame without its end.
fn decode(frame: &[u8]) -> Result<(u16, Report), Damage> {
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
            Ok((decoded, [])) => Ok(decoded),
            _ => Err(Damage::Undecodable),
        },
        Some((&other, _)) => Err(Damage::OtherVersion(other)),
        None => Err(Damage::Undecodable),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::digest::Digest;
    use crate::smart_car::CELLS;
    use crate::telemetry::fixtures::{HELLO, Receiver, received, reports};
    use crate::telemetry::{
        Drive, DriveState, Head, MapEnd, MapPart, Ranger, SensorHealth, Statistics,
    };
    use certainty_control::{Effort, Wheels};
    use certainty_core::health::{Confidence, Status};
    use certainty_core::sensor::SensorId;
    use certainty_core::transducer::{Finding, Missing, Reading};
    use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose};
    use proptest::prelude::*;

    /// `content`, a version byte and what follows, as a frame.
    fn framed(content: &[u8]) -> Vec<u8> {
        let content = [content, &CRC.checksum(content).to_le_bytes()].concat();
        let mut frame = vec![0; cobs::max_encoding_length(content.len())];
        let length = cobs::encode(&content, &mut frame);
        frame.truncate(length);
        frame.push(0);
        frame
    }

    fn encoded(encoder: &mut Encoder, report: &Report) -> Vec<u8> {
        let mut frame = [0xAA; FRAME];
        encoder.encode(report, &mut frame).unwrap().to_vec()
    }

    fn statistics(round: u32) -> Report {
        Report::Statistics(Statistics {
            round,
            ..Statistics::default()
        })
    }

    /// By hand: version 3, sequence 0, variant 6, four zeros; zlib's CRC-32 of these seven bytes is
    /// 0x23C43043; each zero and the start become the distance to the next zero or the end.
    #[test]
    fn the_first_frame_of_statistics_is_these_bytes() {
        assert_eq!(
            encoded(&mut Encoder::new(), &statistics(0)),
            [2, 3, 2, 6, 1, 1, 1, 5, 0x43, 0x30, 0xC4, 0x23, 0]
        );
    }

    /// One report of each kind with large values: a change of this digest is a change of the wire format.
    #[test]
    fn every_kind_of_report_keeps_its_bytes() {
        let sensor = SensorId::try_new(200).unwrap();
        let pose = Pose::new(Point::from_mm(-70_000, 300), BinaryAngle::from_bits(0xC123));
        let readings = [
            Reading::Echo(Millimeters::new(70_000)),
            Reading::NoObject,
            Reading::TooNear,
            Reading::Missing(Missing::Timeout),
            Reading::Missing(Missing::Bus),
            Reading::Missing(Missing::Implausible),
            Reading::Missing(Missing::Late),
        ];
        let mut all = vec![
            Report::Hello(HELLO),
            Report::Map(MapPart {
                generation: 300,
                start: 5,
                cells: [1, 2, 3].into_iter().collect(),
                end: Some(MapEnd {
                    cells: 187,
                    digest: 0x8000_0001,
                }),
            }),
            Report::Pose(pose),
            statistics(70_000),
        ];
        for reading in readings {
            all.push(Report::Ranger(Ranger {
                number: 200,
                reading,
            }));
        }
        for finding in Finding::ALL {
            all.push(Report::Head(Head {
                sensor,
                direction: BinaryAngle::from_bits(0x1234),
                reading: Reading::NoObject,
                finding,
            }));
        }
        for status in [
            Status::Healthy,
            Status::Suspect,
            Status::Failed,
            Status::Recovering,
        ] {
            all.push(Report::Health(SensorHealth {
                sensor,
                status,
                confidence: Confidence::from_bits(0xABCD),
                readings: 70_000,
                missing: 300,
                confirmations: 1,
                contradictions: 0,
            }));
        }
        for state in [DriveState::Looking, DriveState::Restarted] {
            all.push(Report::Drive(Drive {
                pose,
                wheels: Wheels {
                    right: Effort::from_num(-1),
                    left: Effort::from_num(1),
                },
                state,
                to_goal: Millimeters::new(70_000),
            }));
        }
        let mut encoder = Encoder::new();
        let mut digest = Digest::NEW;
        for report in &all {
            digest.bytes(&encoded(&mut encoder, report));
        }
        assert_eq!(digest.value(), 0xD18E_B284);
    }

    #[test]
    fn the_longest_report_fills_a_frame_to_the_last_byte() {
        let longest = Report::Map(MapPart {
            generation: u16::MAX,
            start: u16::MAX,
            cells: [u8::MAX; PART_CELLS].into_iter().collect(),
            end: Some(MapEnd {
                cells: u16::MAX,
                digest: u32::MAX,
            }),
        });
        let mut encoder = Encoder { sequence: u16::MAX };
        assert_eq!(encoded(&mut encoder, &longest).len(), FRAME);
        const { assert!(FRAME <= 80) }
    }

    #[test]
    fn four_parts_hold_the_smart_cars_map() {
        assert_eq!(CELLS.div_ceil(PART_CELLS), 4);
    }

    proptest! {
        #[test]
        fn every_report_round_trips_in_one_frame(report in reports(), sequence: u16) {
            let mut encoder = Encoder { sequence };
            let frame = encoded(&mut encoder, &report);
            prop_assert!(frame.len() <= FRAME);
            prop_assert_eq!(frame.iter().position(|&byte| byte == 0), Some(frame.len() - 1));
            let receiver = received(&frame);
            prop_assert_eq!(receiver.reports, [report]);
            let expected = Tally { frames: 1, ..Tally::default() };
            prop_assert_eq!(receiver.decoder.tally(), &expected);
        }

        #[test]
        fn a_stream_of_reports_round_trips_in_order(reports in prop::collection::vec(reports(), 0..40)) {
            let mut encoder = Encoder::new();
            let bytes: Vec<u8> = reports.iter().flat_map(|report| encoded(&mut encoder, report)).collect();
            let receiver = received(&bytes);
            prop_assert_eq!(receiver.decoder.tally().lost, 0);
            prop_assert_eq!(receiver.decoder.tally().restarts, 0);
            prop_assert_eq!(receiver.reports, reports);
        }
    }

    #[test]
    fn another_version_is_reported_as_such() {
        for version in (0..=u8::MAX).filter(|&version| version != VERSION) {
            let frame = framed(&[version, 0, 6, 0, 0, 0, 0]);
            let mut decoder = Decoder::new();
            let outcomes: Vec<_> = frame
                .iter()
                .filter_map(|&byte| decoder.push(byte))
                .collect();
            assert_eq!(outcomes, [Err(Damage::OtherVersion(version))]);
        }
    }

    #[test]
    fn an_intact_frame_without_a_report_is_undecodable() {
        let cases: [(&str, &[u8]); 10] = [
            ("nothing", &[VERSION]),
            ("no report", &[VERSION, 0]),
            ("an unknown report", &[VERSION, 0, 8, 0, 0, 0, 0]),
            ("too short", &[VERSION, 0, 6, 0, 0, 0]),
            ("too long", &[VERSION, 0, 6, 0, 0, 0, 0, 0]),
            (
                "an unknown drive state",
                &[VERSION, 0, 7, 0, 0, 0, 0, 0, 10, 0],
            ),
            ("sensor zero", &[VERSION, 0, 3, 0, 0, 1]),
            (
                "a grid without columns",
                &[VERSION, 0, 0, 0, 11, 100, 0, 0, 3, 2, 100],
            ),
            (
                "a number that is too long",
                &[VERSION, 0, 6, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF],
            ),
            (
                "49 cells",
                &[&[VERSION, 0, 1, 0, 0, 49][..], &[1; 49], &[0]].concat(),
            ),
        ];
        for (what, content) in cases {
            let mut decoder = Decoder::new();
            let frame = framed(content);
            let outcomes: Vec<_> = frame
                .iter()
                .filter_map(|&byte| decoder.push(byte))
                .collect();
            assert_eq!(outcomes, [Err(Damage::Undecodable)], "{what}");
        }
    }

    #[test]
    fn zeros_between_frames_are_ignored() {
        let mut encoder = Encoder::new();
        let bytes = [
            vec![0; 5],
            encoded(&mut encoder, &statistics(1)),
            vec![0; 3],
            encoded(&mut encoder, &statistics(2)),
        ]
        .concat();
        let receiver = received(&bytes);
        assert_eq!(receiver.reports, [statistics(1), statistics(2)]);
        let expected = Tally {
            frames: 2,
            ..Tally::default()
        };
        assert_eq!(receiver.decoder.tally(), &expected);
    }

    #[test]
    fn endless_garbage_is_one_damage_in_bounded_memory() {
        let mut decoder = Decoder::new();
        for _ in 0..1_000_000 {
            assert_eq!(decoder.push(0x55), None);
        }
        assert_eq!(decoder.push(0), Some(Err(Damage::TooLong)));
        let frame = encoded(&mut Encoder::new(), &statistics(9));
        let last = frame.iter().filter_map(|&byte| decoder.push(byte)).last();
        assert_eq!(last.unwrap().unwrap().report, statistics(9));
        assert!(size_of::<Decoder>() < 200);
    }

    /// Counts of a decoder after frames with these numbers: lost, restarts.
    fn missed(sequences: &[u16]) -> (u64, u64) {
        let mut receiver = Receiver::new();
        for &sequence in sequences {
            receiver.receive(&encoded(&mut Encoder { sequence }, &statistics(0)));
        }
        let tally = receiver.decoder.tally();
        (tally.lost, tally.restarts)
    }

    #[test]
    fn gaps_count_as_lost_frames_restarts_do_not() {
        assert_eq!(missed(&[0, 1, 2]), (0, 0));
        assert_eq!(missed(&[700, 701]), (0, 0), "joining late is no loss");
        assert_eq!(missed(&[0, 1, 5, 6, 8]), (3 + 1, 0));
        assert_eq!(
            missed(&[65_534, 65_535, 1, 2]),
            (0, 0),
            "after the highest comes one"
        );
        assert_eq!(missed(&[65_534, 1]), (1, 0));
        assert_eq!(missed(&[65_534, 3]), (3, 0));
        assert_eq!(missed(&[40, 41, 0, 1]), (0, 1));
        assert_eq!(
            missed(&[40, 41, 1, 2]),
            (0, 1),
            "the first frame after a start was lost"
        );
        assert_eq!(missed(&[5, 5]), (0, 1), "a frame twice is no gap of 65,534");
    }

    #[test]
    fn numbers_start_at_zero_and_wrap_to_one() {
        let mut encoder = Encoder::new();
        let mut decoder = Decoder::new();
        let mut numbers = Vec::new();
        for _ in 0..65_538 {
            for byte in encoded(&mut encoder, &statistics(0)) {
                numbers.extend(decoder.push(byte).map(|frame| frame.unwrap().sequence));
            }
        }
        let expected: Vec<u16> = (0..=u16::MAX).chain([1, 2]).collect();
        assert!(numbers == expected);
        assert_eq!((decoder.tally().lost, decoder.tally().restarts), (0, 0));
    }

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
