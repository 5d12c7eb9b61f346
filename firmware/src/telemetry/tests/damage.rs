//! A line that changes, loses, adds and mixes bytes.

use super::*;

/// Everything that is heard was sent: no report is made up, no map is shown as complete that was not
/// one of `maps`, and the counts add up.
fn assert_nothing_made_up(bytes: &[u8], sent: &[&Sent]) -> Receiver {
    let receiver = heard(bytes);
    for report in &receiver.reports {
        assert!(
            sent.iter().any(|sent| sent.reports.contains(report)),
            "made up: {report:?}"
        );
    }
    for map in &receiver.complete {
        assert!(
            sent.iter().any(|sent| sent.maps.contains(map)),
            "a wrong map shown as right"
        );
    }
    let tally = receiver.decoder.tally();
    let told = tally.frames + tally.checksum + tally.too_long + tally.undecodable;
    let told = told + tally.other_version + tally.truncated;
    let pieces = bytes
        .split(|&byte| byte == 0)
        .filter(|piece| !piece.is_empty());
    assert_eq!(told, pieces.count() as u64, "every piece is told once");
    receiver
}

#[test]
fn any_single_bit_flipped_costs_two_frames_at_most() {
    let sent = rounds(3, 7, 2);
    for place in 0..sent.bytes.len() {
        for bit in 0..8 {
            let mut bytes = sent.bytes.clone();
            bytes[place] ^= 1 << bit;
            let receiver = assert_nothing_made_up(&bytes, &[&sent]);
            // An end that is flipped joins two frames; a byte that becomes one cuts its own.
            assert!(receiver.reports.len() + 2 >= sent.reports.len());
            assert!(receiver.reports.len() < sent.reports.len());
        }
    }
}

#[test]
fn a_byte_lost_or_added_anywhere_costs_two_frames_at_most() {
    let sent = rounds(3, 7, 2);
    for place in 0..sent.bytes.len() {
        let mut bytes = sent.bytes.clone();
        bytes.remove(place);
        let receiver = assert_nothing_made_up(&bytes, &[&sent]);
        assert!(receiver.reports.len() + 2 >= sent.reports.len());
        for added in [0, 1, 0x55, 0xFF] {
            let mut bytes = sent.bytes.clone();
            bytes.insert(place, added);
            let receiver = assert_nothing_made_up(&bytes, &[&sent]);
            assert!(receiver.reports.len() + 1 >= sent.reports.len());
        }
    }
}

#[test]
fn a_stream_cut_anywhere_is_heard_up_to_there_and_from_there() {
    let sent = rounds(3, 7, 2);
    let ends = |bytes: &[u8]| bytes.iter().filter(|&&byte| byte == 0).count();
    for place in 0..=sent.bytes.len() {
        let (before, after) = sent.bytes.split_at(place);
        let receiver = assert_nothing_made_up(before, &[&sent]);
        assert_eq!(receiver.reports.len(), ends(before));
        let open = u64::from(!before.is_empty() && !before.ends_with(&[0]));
        assert_eq!(receiver.decoder.tally().truncated, open);
        let receiver = assert_nothing_made_up(after, &[&sent]);
        assert!(receiver.reports.len() + 1 >= ends(after));
    }
}

/// One thing that happens to a stream.
#[derive(Debug, Clone)]
enum Accident {
    Flip {
        place: prop::sample::Index,
        burst: Vec<u8>,
    },
    Lose {
        place: prop::sample::Index,
        count: usize,
    },
    Add {
        place: prop::sample::Index,
        noise: Vec<u8>,
    },
    Repeat {
        place: prop::sample::Index,
        count: usize,
    },
}

fn accidents() -> impl Strategy<Value = Accident> {
    let place = any::<prop::sample::Index>;
    let noise = || prop::collection::vec(any::<u8>(), 1..200);
    prop_oneof![
        (place(), noise()).prop_map(|(place, burst)| Accident::Flip { place, burst }),
        (place(), 1..300_usize).prop_map(|(place, count)| Accident::Lose { place, count }),
        (place(), noise()).prop_map(|(place, noise)| Accident::Add { place, noise }),
        (place(), 1..300_usize).prop_map(|(place, count)| Accident::Repeat { place, count }),
    ]
}

fn befall(bytes: &mut Vec<u8>, accident: Accident) {
    if bytes.is_empty() {
        return;
    }
    match accident {
        Accident::Flip { place, burst } => {
            let place = place.index(bytes.len());
            for (byte, flip) in bytes[place..].iter_mut().zip(burst) {
                *byte ^= flip;
            }
        }
        Accident::Lose { place, count } => {
            let place = place.index(bytes.len());
            bytes.drain(place..(place + count).min(bytes.len()));
        }
        Accident::Add { place, noise } => {
            let place = place.index(bytes.len());
            bytes.splice(place..place, noise);
        }
        Accident::Repeat { place, count } => {
            let place = place.index(bytes.len());
            let again = bytes[place..(place + count).min(bytes.len())].to_vec();
            bytes.splice(place..place, again);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn whatever_befalls_a_stream_nothing_is_made_up(
        seed: u32,
        keyframe_every in 0..5_u16,
        accidents in prop::collection::vec(accidents(), 1..12),
    ) {
        let sent = rounds(6, seed, keyframe_every);
        let mut bytes = sent.bytes.clone();
        for accident in accidents {
            befall(&mut bytes, accident);
        }
        let after = rounds(1, 99, 1);
        // The last frame before may run into the first after; the second generation is whole.
        bytes.extend([0].iter().chain(&after.bytes));
        let receiver = assert_nothing_made_up(&bytes, &[&sent, &after]);
        prop_assert_eq!(receiver.view.state(), MapState::Complete { generation: 0 });
        prop_assert_eq!(&receiver.cells(), &after.maps[0]);
    }

    /// Two boards on one line, byte by byte and in bursts.
    #[test]
    fn two_streams_mixed_make_nothing_up(
        seeds: (u32, u32),
        bursts in prop::collection::vec((1..160_usize, 1..160_usize), 1..60),
    ) {
        let (one, other) = (rounds(6, seeds.0, 2), rounds(6, seeds.1, 2));
        let (mut a, mut b) = (&one.bytes[..], &other.bytes[..]);
        let mut mixed = Vec::new();
        for (from_a, from_b) in bursts {
            for (stream, count) in [(&mut a, from_a), (&mut b, from_b)] {
                let (now, later) = stream.split_at(count.min(stream.len()));
                mixed.extend_from_slice(now);
                *stream = later;
            }
        }
        assert_nothing_made_up(&mixed, &[&one, &other]);
    }

    /// Two boards that take turns frame by frame: every frame is heard, and their maps are kept apart.
    #[test]
    fn two_streams_of_whole_frames_never_make_a_map_of_both(
        seeds: (u32, u32),
        turns in prop::collection::vec(any::<bool>(), 0..120),
    ) {
        let (one, other) = (rounds(6, seeds.0, 2), rounds(6, seeds.1, 3));
        let frames = |sent: &Sent| -> Vec<Vec<u8>> {
            sent.bytes.split_inclusive(|&byte| byte == 0).map(<[u8]>::to_vec).collect()
        };
        let (a, b) = (frames(&one), frames(&other));
        let (mut a, mut b) = (a.iter(), b.iter());
        let mixed: Vec<u8> = turns
            .into_iter()
            .filter_map(|turn| if turn { a.next() } else { b.next() })
            .flatten()
            .copied()
            .collect();
        let receiver = assert_nothing_made_up(&mixed, &[&one, &other]);
        let frames = mixed.iter().filter(|&&byte| byte == 0).count();
        prop_assert_eq!(receiver.reports.len(), frames);
    }

    #[test]
    fn random_bytes_are_never_a_report(bytes in prop::collection::vec(any::<u8>(), 0..4000)) {
        let receiver = heard(&bytes);
        prop_assert!(receiver.reports.is_empty(), "one in 2^32 frames passes its checksum");
        prop_assert_eq!(receiver.view.state(), MapState::Unknown);
    }
}
