//! Telemetry: the robot's reports as frames on a serial line.
//!
//! A [`Reporter`] encodes the map, the sensors' health and the application's other reports as frames and
//! gives them to an [`Outbox`]. A [`Decoder`] takes bytes one by one, returns the reports and counts lost
//! frames; a [`MapView`] reassembles the map and checks whether it is complete.
//!
//! | a frame's bytes | content |
//! |---|---|
//! | COBS | stuffing, so that the frame contains no zero |
//! | ‥ version | [`VERSION`] of the wire format |
//! | ‥ sequence | `u16`, postcard: 0 is the first frame after a start; after 65,535 follows 1 |
//! | ‥ report | [`Report`], postcard |
//! | ‥ CRC-32 | of version, sequence and report (ISO-HDLC, as in Ethernet), low byte first |
//! | `0x00` | the end |
//!
//! The map is sent in *generations*. Each generation scans the whole grid once and sends the cells that
//! changed, in parts; the last part has a digest of the whole map as sent so far. Periodically a generation
//! is a *keyframe*: it sends all cells, after a [`Hello`]. A receiver that joins late or loses frames marks
//! its map as incomplete until a digest matches.
//!
//! Sending uses no heap, no panic and no formatting, and is bounded: a call of [`Reporter::send_map`] reads
//! each cell at most once a part. Memory: the map as sent last, a byte a cell, and one frame of [`FRAME`]
//! bytes on the stack.

#[cfg(test)]
mod fixtures;
mod frame;
mod map;
mod report;
mod reporter;

pub use frame::{Damage, Decoder, EncodeError, Encoder, FRAME, Frame, Tally, VERSION};
pub use map::{MapReporter, MapState, MapView, TooManyCells};
pub use report::{
    Drive, DriveState, Head, Hello, MapEnd, MapPart, PART_CELLS, Ranger, Report, SensorHealth,
    Statistics,
};
pub use reporter::{Outbox, Reporter};
