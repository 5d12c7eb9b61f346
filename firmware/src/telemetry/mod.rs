//! Telemetry: what the robot knows, as frames on a serial line.
//!
//! A [`Reporter`] turns the map, the sensors' health and whatever else the application reports into
//! frames and hands them to an [`Outbox`]. A [`Decoder`] takes bytes one by one and gives the reports
//! back, counting what was lost; a [`MapView`] puts the map together again and says whether it is
//! whole.
//!
//! | a frame's bytes | are |
//! |---|---|
//! | COBS | stuffing, so that no zero is within |
//! | ‥ version | [`VERSION`] of the wire format |
//! | ‥ sequence | `u16`, postcard: 0 is the first frame after a start and never comes again |
//! | ‥ report | [`Report`], postcard |
//! | ‥ CRC-32 | of version, sequence and report (ISO-HDLC, as Ethernet has), low byte first |
//! | `0x00` | the end |
//!
//! The map goes out in *generations*: in each the whole grid is looked through once, the cells that
//! changed are sent in parts, and the last part carries a digest of the whole map as it is known by
//! then. Every so often a generation is a *keyframe*, which sends all cells, after a [`Hello`]. So a
//! receiver that starts to listen anywhere, or loses frames, has no right map until a digest agrees,
//! and knows it.
//!
//! Sending has no heap, no panic and no formatting, and is bounded: a call of
//! [`Reporter::send_map`] looks at each cell once a part. Memory: the map as it was sent last, a byte
//! a cell, and one frame of [`FRAME`] bytes on the stack.

mod decoder;
mod encoder;
mod map_reporter;
mod map_view;
mod report;
mod reporter;
#[cfg(test)]
mod tests;
mod wire;

pub use decoder::{Damage, Decoder, Frame, Tally};
pub use encoder::{EncodeError, Encoder};
pub use map_reporter::{MapReporter, TooManyCells};
pub use map_view::{MapState, MapView};
pub use report::{
    Drive, DriveState, Head, Hello, MapEnd, MapPart, PART_CELLS, Ranger, Report, SensorHealth,
    Statistics,
};
pub use reporter::{Outbox, Reporter};

/// The version of the wire format, the first byte of every frame.
pub const VERSION: u8 = 3;

/// The longest frame, its end included, in bytes.
///
/// Formula: 1 code byte, 1 of version, 3 of sequence, [`PART_CELLS`] + 16 of the longest report,
/// which is a last part of a map, 4 of CRC, 1 end. One code byte suffices for up to 254 bytes.
pub const FRAME: usize = 10 + PART_CELLS + 16;

/// The checksum of a frame; without a table it takes least flash.
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
