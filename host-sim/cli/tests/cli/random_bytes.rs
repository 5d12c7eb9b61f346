//! Recordings of random bytes: valid beams, or an error of one line.

use crate::support::recording::{Place, flaser, gzip, robotlaser};
use certainty_sim::replay::{HEADER, LoadOptions, load};
use core::num::NonZeroU8;
use proptest::prelude::*;
use std::fs;

const PLACE: Place = Place {
    x: 0.0,
    y: 0.0,
    heading: 0.0,
};

/// Loads `bytes` as a recording and asserts valid beams or an error of one line.
fn assert_loads_or_is_refused(bytes: &[u8]) -> Result<(), TestCaseError> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("input");
    fs::write(&file, bytes).unwrap();
    let options = LoadOptions {
        sensors: NonZeroU8::new(3).unwrap(),
        max_beams: 10_000,
        ..LoadOptions::default()
    };
    match load(&file, &options, &mut |_, _| {}) {
        Ok(recording) => {
            prop_assert!(!recording.beams.is_empty());
            let highest = recording
                .beams
                .iter()
                .map(|beam| beam.sensor.number())
                .max();
            prop_assert!(highest <= Some(recording.sensors));
            let tally = recording.tally();
            let counted = tally.echo + tally.no_object + tally.too_near + tally.missing;
            prop_assert_eq!(counted, recording.beams.len() as u64);
            // Not more beams than the bytes can hold, unless they are compressed.
            if !bytes.starts_with(&[0x1F, 0x8B]) {
                prop_assert!(recording.beams.len() <= bytes.len() / 2);
            }
        }
        Err(error) => {
            let line = error.to_string();
            prop_assert!(
                line.lines().count() == 1 && line.contains("input"),
                "{}",
                line
            );
        }
    }
    Ok(())
}

/// A small recording of either format.
fn small(kind: u8) -> Vec<u8> {
    let ranges = [1.0, 2.5, 81.83, 0.25];
    match kind % 4 {
        0 => {
            format!("{HEADER}\n0,1,0,0,0,500\n5,2,-10,7,90000,none\n9,3,4,4,-1,near\n").into_bytes()
        }
        1 => flaser(&ranges, PLACE, 1.0).repeat(3).into_bytes(),
        2 => robotlaser(&ranges, PLACE, 1.0).repeat(3).into_bytes(),
        _ => gzip(flaser(&ranges, PLACE, 1.0).repeat(3).as_bytes()),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..2000), magic in any::<bool>()) {
        let start: &[u8] = if magic { &[0x1F, 0x8B, 8] } else { &[] };
        assert_loads_or_is_refused(&[start, &bytes].concat())?;
    }

    #[test]
    fn a_recording_changed_anywhere_never_panics(
        kind in any::<u8>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..3_u8), 1..12),
    ) {
        let mut bytes = small(kind);
        for (place, byte, how) in changes {
            if bytes.is_empty() {
                break;
            }
            let place = place.index(bytes.len());
            match how {
                0 => bytes[place] = byte,
                1 => bytes.insert(place, byte),
                _ => _ = bytes.remove(place),
            }
        }
        assert_loads_or_is_refused(&bytes)?;
    }

    #[test]
    fn a_recording_with_its_numbers_replaced_never_panics(
        kind in 0..3_u8,
        changes in prop::collection::vec(
            (any::<prop::sample::Index>(), prop::sample::select(vec![
                "", "-", "NaN", "inf", "-inf", "1e308", "-1e308", "1e-308", "1000000000",
                "18446744073709551615", "18446744073709551616", "-9223372036854775808", "0", "-0",
                "4294967295", "4294967296", "\u{FEFF}", "\r", "none", "FLASER",
            ])), 1..6),
    ) {
        let text = String::from_utf8(small(kind)).unwrap();
        let mut words: Vec<&str> = text.split_inclusive([' ', ',', '\n']).collect();
        let replaced: Vec<String> = changes.iter().map(|(_, word)| format!("{word} ")).collect();
        for ((place, _), word) in changes.iter().zip(&replaced) {
            let place = place.index(words.len());
            words[place] = word;
        }
        assert_loads_or_is_refused(words.concat().as_bytes())?;
    }
}
