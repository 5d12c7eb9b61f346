//! The sender: encodes a round's reports and gives them to an outbox.

use super::frame::{Encoder, FRAME};
use super::map::{MapReporter, TooManyCells};
use super::report::{Hello, Report, SensorHealth};
use certainty_core::fusion::{CertaintyGrid, Environment};

/// Takes frames, usually into a queue that a serial port sends.
pub trait Outbox {
    /// Takes the whole `frame`, at most [`FRAME`] bytes, or nothing if there is not enough room; returns
    /// whether it was taken. Must not block.
    fn send(&mut self, frame: &[u8]) -> bool;
}

impl<O: Outbox + ?Sized> Outbox for &mut O {
    fn send(&mut self, frame: &[u8]) -> bool {
        (**self).send(frame)
    }
}

/// Encodes reports, gives them to an outbox and counts those that it refused.
#[derive(Debug, Clone)]
struct Sender<O> {
    encoder: Encoder,
    outbox: O,
    unsent: u32,
}

impl<O: Outbox> Sender<O> {
    fn send(&mut self, report: &Report) -> bool {
        let mut frame = [0; FRAME];
        let encoded = self.encoder.encode(report, &mut frame);
        let sent = encoded.is_ok_and(|frame| self.outbox.send(frame));
        if !sent {
            #[cfg(feature = "defmt")]
            defmt::debug!("telemetry: frame refused by the outbox");
            self.unsent = self.unsent.saturating_add(1);
        }
        sent
    }
}

/// Reports the state of a robot whose map has `CELLS` cells.
///
/// ```
/// use certainty_core::fusion::{BayesGrid, Environment, Strength};
/// use certainty_core::health::Health;
/// use certainty_firmware::smart_car::{CELLS, SENSORS, SmartCarShape};
/// use certainty_core::fusion::Shape;
/// use certainty_firmware::telemetry::{Hello, Outbox, Reporter, Statistics, Report};
///
/// /// A queue of 256 bytes.
/// #[derive(Default)]
/// struct Queue(heapless::Vec<u8, 256>);
///
/// impl Outbox for Queue {
///     fn send(&mut self, frame: &[u8]) -> bool {
///         self.0.extend_from_slice(frame).is_ok()
///     }
/// }
///
/// let hello = Hello { geometry: SmartCarShape.geometry(), sensors: SENSORS, rangers: 2, round_ms: 100 };
/// let mut reporter = Reporter::<_, CELLS>::try_new(Queue::default(), hello, 50).ok().unwrap();
/// let grid = BayesGrid::try_new(SmartCarShape, Strength::UNLIMITED, [0; CELLS])?;
/// let health = [Health::default(); SENSORS as usize];
/// let map = Environment::new(&grid, &health);
///
/// // A round: at most two parts of the map, then the other reports.
/// let whole = reporter.send_map(&map, 2);
/// assert!(!whole, "the first generation has four parts");
/// reporter.send_health(&map);
/// reporter.send(&Report::Statistics(Statistics { unsent: reporter.unsent(), ..Statistics::default() }));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Reporter<O, const CELLS: usize> {
    sender: Sender<O>,
    map: MapReporter<CELLS>,
    hello: Hello,
}

impl<O: Outbox, const CELLS: usize> Reporter<O, CELLS> {
    /// Creates a reporter; one in `keyframe_every` generations of the map is a keyframe.
    ///
    /// # Errors
    ///
    /// [`TooManyCells`] as in [`MapReporter::try_new`], and the outbox.
    pub fn try_new(
        outbox: O,
        hello: Hello,
        keyframe_every: u16,
    ) -> Result<Self, (TooManyCells, O)> {
        match MapReporter::try_new(hello.geometry, keyframe_every) {
            Ok(map) => Ok(Self {
                sender: Sender {
                    encoder: Encoder::new(),
                    outbox,
                    unsent: 0,
                },
                map,
                hello,
            }),
            Err(error) => Err((error, outbox)),
        }
    }

    /// Sends a report; returns whether the outbox took it.
    pub fn send(&mut self, report: &Report) -> bool {
        self.sender.send(report)
    }

    /// Sends the next parts of `map`, at most `parts`; before a keyframe the [`Hello`] first.
    ///
    /// Returns whether a generation is finished. Parts that the outbox refused are sent at the next call.
    pub fn send_map<G: CertaintyGrid>(&mut self, map: &Environment<'_, G>, parts: u8) -> bool {
        if self.map.begins_keyframe() && !self.sender.send(&Report::Hello(self.hello)) {
            return false;
        }
        let sender = &mut self.sender;
        self.map.report(map, parts, |report| sender.send(report))
    }

    /// Sends the health of every sensor of `map`, a frame each.
    pub fn send_health<G: CertaintyGrid>(&mut self, map: &Environment<'_, G>) {
        for (sensor, health) in map.sensors() {
            self.send(&Report::Health(SensorHealth::new(sensor, health)));
        }
    }

    /// Returns how many frames the outbox refused since the start; saturates.
    #[must_use]
    pub const fn unsent(&self) -> u32 {
        self.sender.unsent
    }

    /// Returns the outbox.
    pub const fn outbox_mut(&mut self) -> &mut O {
        &mut self.sender.outbox
    }

    /// Returns the outbox, and ends the reporter.
    pub fn release(self) -> O {
        self.sender.outbox
    }
}

#[cfg(test)]
mod tests {
    // These tests use a line that changes, loses, adds and mixes bytes.

    use crate::telemetry::MapState;
    use crate::telemetry::fixtures::{Receiver, Sent, received, rounds};
    use proptest::prelude::*;

    /// Asserts that every received report was sent, that every complete map was one of the sender's, and that
    /// the counts add up.
    fn assert_nothing_invented(bytes: &[u8], sent: &[&Sent]) -> Receiver {
        let receiver = received(bytes);
        for report in &receiver.reports {
            assert!(
                sent.iter().any(|sent| sent.reports.contains(report)),
                "never sent: {report:?}"
            );
        }
        for map in &receiver.complete {
            assert!(
                sent.iter().any(|sent| sent.maps.contains(map)),
                "a wrong map shown as complete"
            );
        }
        let tally = receiver.decoder.tally();
        let counted = tally.frames + tally.checksum + tally.too_long + tally.undecodable;
        let counted = counted + tally.other_version + tally.truncated;
        let pieces = bytes
            .split(|&byte| byte == 0)
            .filter(|piece| !piece.is_empty());
        assert_eq!(
            counted,
            pieces.count() as u64,
            "every piece is counted once"
        );
        receiver
    }

    #[test]
    fn a_flipped_bit_costs_at_most_two_frames() {
        let sent = rounds(3, 7, 2);
        for place in 0..sent.bytes.len() {
            for bit in 0..8 {
                let mut bytes = sent.bytes.clone();
                bytes[place] ^= 1 << bit;
                let receiver = assert_nothing_invented(&bytes, &[&sent]);
                // A flipped end joins two frames; a byte that becomes zero splits its frame.
                assert!(receiver.reports.len() + 2 >= sent.reports.len());
                assert!(receiver.reports.len() < sent.reports.len());
            }
        }
    }

    #[test]
    fn a_lost_or_added_byte_costs_at_most_two_frames() {
        let sent = rounds(3, 7, 2);
        for place in 0..sent.bytes.len() {
            let mut bytes = sent.bytes.clone();
            bytes.remove(place);
            let receiver = assert_nothing_invented(&bytes, &[&sent]);
            assert!(receiver.reports.len() + 2 >= sent.reports.len());
            for added in [0, 1, 0x55, 0xFF] {
                let mut bytes = sent.bytes.clone();
                bytes.insert(place, added);
                let receiver = assert_nothing_invented(&bytes, &[&sent]);
                assert!(receiver.reports.len() + 1 >= sent.reports.len());
            }
        }
    }

    #[test]
    fn a_stream_cut_in_two_is_decoded_on_both_sides() {
        let sent = rounds(3, 7, 2);
        let ends = |bytes: &[u8]| bytes.iter().filter(|&&byte| byte == 0).count();
        for place in 0..=sent.bytes.len() {
            let (before, after) = sent.bytes.split_at(place);
            let receiver = assert_nothing_invented(before, &[&sent]);
            assert_eq!(receiver.reports.len(), ends(before));
            let open = u64::from(!before.is_empty() && !before.ends_with(&[0]));
            assert_eq!(receiver.decoder.tally().truncated, open);
            let receiver = assert_nothing_invented(after, &[&sent]);
            assert!(receiver.reports.len() + 1 >= ends(after));
        }
    }

    /// One kind of damage to a stream.
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

    fn damage(bytes: &mut Vec<u8>, accident: Accident) {
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
        fn a_damaged_stream_yields_no_invented_reports(
            seed: u32,
            keyframe_every in 0..5_u16,
            accidents in prop::collection::vec(accidents(), 1..12),
        ) {
            let sent = rounds(6, seed, keyframe_every);
            let mut bytes = sent.bytes.clone();
            for accident in accidents {
                damage(&mut bytes, accident);
            }
            let after = rounds(1, 99, 1);
            // The zero separates the last frame before from the first after; this generation is complete.
            bytes.extend([0].iter().chain(&after.bytes));
            let receiver = assert_nothing_invented(&bytes, &[&sent, &after]);
            prop_assert_eq!(receiver.view.state(), MapState::Complete { generation: 0 });
            prop_assert_eq!(&receiver.cells(), &after.maps[0]);
        }

        /// Two boards on one line, byte by byte and in bursts.
        #[test]
        fn two_mixed_streams_yield_no_invented_reports(
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
            assert_nothing_invented(&mixed, &[&one, &other]);
        }

        /// Two boards take turns frame by frame: every frame is decoded, and their maps are not mixed.
        #[test]
        fn two_streams_of_whole_frames_never_mix_maps(
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
            let receiver = assert_nothing_invented(&mixed, &[&one, &other]);
            let frames = mixed.iter().filter(|&&byte| byte == 0).count();
            prop_assert_eq!(receiver.reports.len(), frames);
        }

        #[test]
        fn random_bytes_are_never_a_report(bytes in prop::collection::vec(any::<u8>(), 0..4000)) {
            let receiver = received(&bytes);
            prop_assert!(receiver.reports.is_empty(), "one in 2^32 frames passes its checksum");
            prop_assert_eq!(receiver.view.state(), MapState::Unknown);
        }
    }
}
