//! Damaged recordings: what is sound is mapped; random bytes give valid beams or an error of one line.

use crate::support::{
    BEAMS, PLACE, Place, certainty_quickly, flaser, folder_with, gzip, robotlaser, scan,
};
use certainty_sim::replay::{HEADER, LoadOptions, load};
use core::num::NonZeroU8;
use proptest::prelude::*;
use std::fs;

/// Damage that leaves something: the number of lines skipped, of beams and of missing ones.
#[test]
fn damaged_lines_are_skipped_counted_and_reported() {
    let one = scan(2.0);
    let cut = one[..one.len() / 2].to_owned();
    let wrong_pose = flaser(
        &[2.0; BEAMS],
        Place {
            x: f64::NAN,
            ..PLACE
        },
        1.0,
    );
    let beyond = flaser(&[2.0; BEAMS], Place { x: 1e12, ..PLACE }, 1.0);
    let announced = one.replacen("FLASER 180", "FLASER 1000000000", 1);
    let latin = b"FLASER 1 2.0 \xE9 0 0 0 0 0 1 h 1\n".to_vec();
    let cases: [(&str, Vec<u8>, u64, usize); 9] = [
        (
            "cut in the middle of its last line",
            (one.clone() + &cut).into_bytes(),
            1,
            1,
        ),
        (
            "cut in the middle of a line within",
            (one.clone() + &cut + "\n" + &one).into_bytes(),
            1,
            2,
        ),
        (
            "10^9 beams announced",
            (announced + &one).into_bytes(),
            1,
            1,
        ),
        (
            "a pose that is no number",
            (wrong_pose + &one).into_bytes(),
            1,
            1,
        ),
        ("a pose beyond any map", (beyond + &one).into_bytes(), 1, 1),
        (
            "an unknown message",
            ("WEATHER sunny\n".to_owned() + &one).into_bytes(),
            1,
            1,
        ),
        (
            "not UTF-8",
            [one.clone().into_bytes(), latin].concat(),
            1,
            1,
        ),
        (
            "a range that is a word",
            (one.clone() + &one.replacen(" 2 ", " two ", 1)).into_bytes(),
            1,
            1,
        ),
        (
            "line ends of another system",
            one.replace('\n', "\r\n").into_bytes(),
            0,
            1,
        ),
    ];
    for (what, content, skipped, scans) in cases {
        let folder = folder_with(content);
        let strict = certainty_quickly(folder.path(), "replay input");
        let unknown = what == "an unknown message";
        assert_eq!(
            strict.code,
            Some(if skipped > 0 && !unknown { 2 } else { 0 }),
            "{what}"
        );
        let lenient = "replay input --lenient";
        let document = certainty_quickly(folder.path(), &format!("{lenient} --json")).json();
        assert_eq!(document["skipped_lines"], skipped, "{what}");
        assert_eq!(
            document["skipped"].as_array().unwrap().len() as u64,
            skipped,
            "{what}"
        );
        assert_eq!(document["readings"], scans * BEAMS, "{what}");
        let text = certainty_quickly(folder.path(), lenient).stdout;
        let lines = if skipped == 1 { "line" } else { "lines" };
        let reported = text.contains(&format!("{skipped} {lines} skipped:"));
        assert_eq!(reported, skipped > 0, "{what}: {text}");
    }
}

#[test]
fn ranges_that_are_no_distance_map_no_obstacle() {
    for (word, kind) in [
        ("NaN", "missing"),
        ("-1", "missing"),
        ("-inf", "too_near"),
        ("inf", "no_object"),
        ("1e300", "no_object"),
        ("0", "no_object"),
    ] {
        let line = scan(2.0).replace(" 2 ", &format!(" {word} "));
        let line = line.replace(" 2 ", &format!(" {word} "));
        assert!(line.contains(&format!("{word} {word} {word}")), "{line}");
        let folder = folder_with(&line);
        let document = certainty_quickly(folder.path(), "replay input --json").json();
        assert_eq!(document[kind], BEAMS, "{word}: {document}");
        assert_eq!(document["echo"], 0, "{word}");
    }
}

#[test]
fn damaged_readings_are_counted_or_refused() {
    let sound =
        "0,1,0,0,0,500\n0,300,0,0,0,inf\n1,0,0,0,0,-5\n2,1,0,0,0,NaN\n5,1,0,0,0,near\n".repeat(8);
    let folder = folder_with(format!(
        "{HEADER}\n{sound}7,1,99999999999,0,0,500\n8,1,0,0\n"
    ));
    let document = certainty_quickly(folder.path(), "replay input --json").json();
    assert_eq!(
        (&document["skipped_lines"], &document["readings"]),
        (&2.into(), &40.into())
    );
    let expected = serde_json::json!([
        {"reason": "field_count", "lines": 1, "first_line": 43},
        {"reason": "out_of_reach", "lines": 1, "first_line": 42},
    ]);
    assert_eq!(document["skipped"], expected);
    let kinds = ["echo", "too_near", "no_object", "missing"].map(|kind| document[kind].as_u64());
    assert_eq!(kinds, [Some(8), Some(8), Some(8), Some(16)]);
    let ids: Vec<_> = document["sensors"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| one["id"].clone())
        .collect();
    assert_eq!(ids, [0, 1, 300]);

    let words = sound.replacen(",500", ",far", 5);
    let folder = folder_with(format!("{HEADER}\n{words}"));
    let ran = certainty_quickly(folder.path(), "replay input");
    let line = ran.refusal();
    assert!(
        line.contains("input:2: 5 of 40 lines") && line.contains("--lenient"),
        "{line}"
    );
}

#[test]
fn backward_time_is_reported_and_no_reading_is_lost() {
    let times = [5.0, 6.0, 1.0, 7.0, 0.0];
    let log: String = times
        .iter()
        .map(|&time| flaser(&[2.0; BEAMS], PLACE, time))
        .collect();
    let folder = folder_with(log);
    let document = certainty_quickly(folder.path(), "replay input --json").json();
    assert_eq!(document["readings"], times.len() * BEAMS);
    for sensor in document["sensors"].as_array().unwrap() {
        assert_eq!(
            sensor["status"], "healthy",
            "a backward step makes no sensor stale"
        );
    }
    let text = certainty_quickly(folder.path(), "replay input").stdout;
    assert!(text.contains("2 backward steps of the clock"), "{text}");
}

#[test]
fn a_cut_gzip_gives_the_part_before_the_cut() {
    let log: String = (0..60)
        .map(|second| {
            // Ranges with many digits, so that a cut falls between lines that are there.
            let ranges: Vec<f64> = (0..180)
                .map(|beam| 1.0 + f64::from(second * beam).sqrt() / 99.0)
                .collect();
            flaser(&ranges, PLACE, second.into())
        })
        .collect();
    let mut packed = gzip(log.as_bytes());
    packed.truncate(packed.len() * 9 / 10);
    let folder = folder_with(packed);
    let document = certainty_quickly(folder.path(), "replay input --json").json();
    assert_eq!(document["skipped_lines"], 1);
    let scans = document["readings"].as_u64().unwrap() / 180;
    assert!((40..60).contains(&scans), "{scans}");
    let text = certainty_quickly(folder.path(), "replay input").stdout;
    assert!(text.contains("compressed file cut short"), "{text}");
}

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
