//! The telemetry decoder on arbitrary bytes.
//!
//! The first byte chooses what the others are: bytes on the line, the content of valid frames, or damage to a
//! real stream.
#![no_main]

use certainty_core::certainty::Certainty;
use certainty_core::fusion::{BayesGrid, CertaintyGrid, Environment, Measurement, Shape, Strength};
use certainty_core::health::Health;
use certainty_core::sensor::SensorId;
use certainty_firmware::smart_car::{CELLS, SENSORS, SmartCarShape};
use certainty_firmware::telemetry::{
    Decoder, Encoder, FRAME, Frame, Hello, MapState, MapView, Outbox, Reporter, VERSION,
};
use libfuzzer_sys::fuzz_target;
use std::sync::LazyLock;

fuzz_target!(|data: &[u8]| {
    match data.split_first() {
        Some((0, line)) => _ = received(line),
        Some((1, contents)) => {
            for content in contents.split(|&byte| byte == 0xFE) {
                decoded_reports_round_trip(content);
            }
        }
        Some((_, damage)) => damaged_streams_show_no_wrong_map(damage),
        None => {}
    }
});

/// Returns the reports in `line` and the maps that were complete; checks that every piece is counted once.
fn received(line: &[u8]) -> (Vec<Frame>, Vec<Vec<u8>>) {
    let mut decoder = Decoder::new();
    let mut view = MapView::new([0; CELLS], [0; CELLS]);
    let (mut frames, mut complete) = (Vec::new(), Vec::new());
    for &byte in line {
        if let Some(Ok(frame)) = decoder.push(byte) {
            view.take(&frame.report);
            frames.push(frame);
        }
        if let MapState::Complete { .. } = view.state() {
            let cells: Vec<u8> = view.cells().map(Certainty::to_bits).collect();
            if complete.last() != Some(&cells) {
                complete.push(cells);
            }
        }
    }
    decoder.finish();
    let tally = decoder.tally();
    let counted = tally.frames + tally.checksum + tally.too_long + tally.undecodable;
    let counted = counted + tally.other_version + tally.truncated;
    let pieces = line
        .split(|&byte| byte == 0)
        .filter(|piece| !piece.is_empty());
    assert_eq!(counted, pieces.count() as u64);
    (frames, complete)
}

/// Decodes a valid frame of any content; a report in it must round-trip.
fn decoded_reports_round_trip(content: &[u8]) {
    const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
    if content.len() > FRAME - 7 {
        return;
    }
    let content = [&[VERSION], content].concat();
    let content = [&content[..], &CRC.checksum(&content).to_le_bytes()].concat();
    let mut frame = vec![0; cobs::max_encoding_length(content.len()) + 1];
    cobs::encode(&content, &mut frame);
    for frame in received(&frame).0 {
        let mut bytes = [0; FRAME];
        let again = Encoder::new().encode(&frame.report, &mut bytes).unwrap();
        assert_eq!(received(again).0[0].report, frame.report);
    }
}

/// Removes, repeats and moves pieces of a stream: each map that is complete must be one of the sender's.
///
/// Four bytes a damage: kind, place, length.
fn damaged_streams_show_no_wrong_map(damage: &[u8]) {
    let (stream, maps) = &*SENT;
    let mut bytes = stream.clone();
    for part in damage.chunks_exact(4).take(40) {
        let &[what, low, high, count] = part else {
            return;
        };
        let place = usize::from(u16::from_le_bytes([low, high])) % (bytes.len() + 1);
        let end = (place + usize::from(count)).min(bytes.len());
        let piece = bytes[place..end].to_vec();
        match what % 3 {
            0 => _ = bytes.drain(place..end),
            1 => _ = bytes.splice(place..place, piece),
            _ => {
                bytes.drain(place..end);
                bytes.extend(piece);
            }
        }
    }
    for map in received(&bytes).1 {
        assert!(maps.contains(&map), "a wrong map is shown as complete");
    }
}

/// The bytes that a board sends in some rounds, and its maps.
static SENT: LazyLock<(Vec<u8>, Vec<Vec<u8>>)> = LazyLock::new(|| {
    struct Line(Vec<u8>);

    impl Outbox for Line {
        fn send(&mut self, frame: &[u8]) -> bool {
            self.0.extend_from_slice(frame);
            true
        }
    }

    let geometry = SmartCarShape.geometry();
    let hello = Hello {
        geometry,
        sensors: SENSORS,
        rangers: 2,
        round_ms: 100,
    };
    let mut grid = BayesGrid::try_new(SmartCarShape, Strength::UNLIMITED, [0; CELLS]).unwrap();
    let mut reporter = Reporter::<_, CELLS>::try_new(Line(Vec::new()), hello, 3)
        .ok()
        .unwrap();
    let sensor = SensorId::try_new(1).unwrap();
    let health = [Health::default(); SENSORS as usize];
    let mut maps = Vec::new();
    for round in 0..8 {
        for cell in geometry.iter().skip(round * 5).step_by(23) {
            let certainty = Certainty::from_bits(200 + round as u8);
            grid.add(cell, Measurement { sensor, certainty }, &mut []);
        }
        let map = Environment::new(&grid, &health);
        assert!(reporter.send_map(&map, 4));
        reporter.send_health(&map);
        maps.push(
            geometry
                .iter()
                .map(|cell| grid.certainty(cell).to_bits())
                .collect(),
        );
    }
    (reporter.release().0, maps)
});
