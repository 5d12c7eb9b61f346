//! Single frames: what is in them, and what is missed between them.

use super::*;

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
    fn every_report_comes_back_and_ends_with_the_only_zero(report in reports(), sequence: u16) {
        let mut encoder = Encoder { sequence };
        let frame = encoded(&mut encoder, &report);
        prop_assert!(frame.len() <= FRAME);
        prop_assert_eq!(frame.iter().position(|&byte| byte == 0), Some(frame.len() - 1));
        let receiver = heard(&frame);
        prop_assert_eq!(receiver.reports, [report]);
        let expected = Tally { frames: 1, ..Tally::default() };
        prop_assert_eq!(receiver.decoder.tally(), &expected);
    }

    #[test]
    fn a_stream_of_reports_comes_back_in_order(reports in prop::collection::vec(reports(), 0..40)) {
        let mut encoder = Encoder::new();
        let bytes: Vec<u8> = reports.iter().flat_map(|report| encoded(&mut encoder, report)).collect();
        let receiver = heard(&bytes);
        prop_assert_eq!(receiver.decoder.tally().lost, 0);
        prop_assert_eq!(receiver.decoder.tally().restarts, 0);
        prop_assert_eq!(receiver.reports, reports);
    }
}

#[test]
fn another_version_is_told_and_not_misread() {
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
fn what_arrived_as_sent_but_is_no_report_is_undecodable() {
    let cases: [(&str, &[u8]); 10] = [
        ("nothing", &[VERSION]),
        ("no report", &[VERSION, 0]),
        ("an unknown report", &[VERSION, 0, 8, 0, 0, 0, 0]),
        ("too short", &[VERSION, 0, 6, 0, 0, 0]),
        ("too long", &[VERSION, 0, 6, 0, 0, 0, 0, 0]),
        (
            "a drive for no known reason",
            &[VERSION, 0, 7, 0, 0, 0, 0, 0, 10, 0],
        ),
        ("sensor zero", &[VERSION, 0, 3, 0, 0, 1]),
        (
            "a grid without columns",
            &[VERSION, 0, 0, 0, 11, 100, 0, 0, 3, 2, 100],
        ),
        (
            "an endless number",
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
fn zeros_between_frames_say_nothing() {
    let mut encoder = Encoder::new();
    let bytes = [
        vec![0; 5],
        encoded(&mut encoder, &statistics(1)),
        vec![0; 3],
        encoded(&mut encoder, &statistics(2)),
    ]
    .concat();
    let receiver = heard(&bytes);
    assert_eq!(receiver.reports, [statistics(1), statistics(2)]);
    let expected = Tally {
        frames: 2,
        ..Tally::default()
    };
    assert_eq!(receiver.decoder.tally(), &expected);
}

#[test]
fn garbage_without_end_is_one_damage_and_takes_no_room() {
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

/// What a decoder counts of frames with these numbers: lost, restarts.
fn missed(sequences: &[u16]) -> (u64, u64) {
    let mut receiver = Receiver::new();
    for &sequence in sequences {
        receiver.hear(&encoded(&mut Encoder { sequence }, &statistics(0)));
    }
    let tally = receiver.decoder.tally();
    (tally.lost, tally.restarts)
}

#[test]
fn lost_frames_are_counted_by_the_gaps_and_a_restart_is_none() {
    assert_eq!(missed(&[0, 1, 2]), (0, 0));
    assert_eq!(missed(&[700, 701]), (0, 0), "who joins has missed nothing");
    assert_eq!(missed(&[0, 1, 5, 6, 8]), (3 + 1, 0));
    assert_eq!(
        missed(&[65_534, 65_535, 1, 2]),
        (0, 0),
        "zero never comes again"
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
fn an_encoder_numbers_from_zero_and_skips_it_after_the_highest() {
    let mut encoder = Encoder::new();
    let mut decoder = Decoder::new();
    let mut numbers = Vec::new();
    for _ in 0..65_538 {
        for byte in encoded(&mut encoder, &statistics(0)) {
            numbers.extend(decoder.push(byte).map(|heard| heard.unwrap().sequence));
        }
    }
    let expected: Vec<u16> = (0..=u16::MAX).chain([1, 2]).collect();
    assert!(numbers == expected);
    assert_eq!((decoder.tally().lost, decoder.tally().restarts), (0, 0));
}
