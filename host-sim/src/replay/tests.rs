//! Claims about whole files, made up and real.

use super::gunzip::tests::gzip;
use super::load::read;
use super::*;
use certainty_core::transducer::Missing;
use certainty_core::units::Millimeters;
use core::num::NonZeroU8;
use flate2::{Compression, write::GzEncoder};
use proptest::prelude::*;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

fn read_with(bytes: &[u8], options: &LoadOptions) -> Result<Recording, LoadError> {
    read(Path::new("f.log"), bytes, options, &mut || ())
}

fn read_bytes(bytes: &[u8]) -> Result<Recording, LoadError> {
    read_with(bytes, &LoadOptions::default())
}

/// The error as a user sees it.
fn message(bytes: &[u8]) -> String {
    let message = read_bytes(bytes).unwrap_err().to_string();
    assert_eq!(message.lines().count(), 1, "{message}");
    message
}

/// A readings file of `count` beams.
fn many_readings(count: u32) -> Vec<u8> {
    let beam = |at| RecordedBeam {
        at: Ticks::new(at),
        sensor: SensorId::try_new(1 + (at % 7) as u8).unwrap(),
        origin: Point::from_mm(at as i32 * 13 % 9001, -(at as i32)),
        bearing: BinaryAngle::from_bits((at * 977 % 65536) as u16),
        reading: Reading::Echo(Millimeters::new(at * 31 % 5000)),
    };
    let mut file = Vec::new();
    write_readings(&mut file, &(0..count).map(beam).collect::<Vec<_>>()).unwrap();
    file
}

#[test]
fn a_packed_file_reads_as_the_plain_one() {
    let plain = many_readings(20_000);
    let recording = read_bytes(&plain).unwrap();
    assert_eq!(recording.beams.len(), 20_000);
    assert_eq!((recording.sensors, recording.format), (7, Format::Readings));
    assert_eq!(recording.skipped.total(), 0);
    assert_eq!(read_bytes(&gzip(&plain)).unwrap(), recording);
}

#[test]
fn a_packed_file_that_was_cut_keeps_what_came_before() {
    let plain = many_readings(20_000);
    let whole = read_bytes(&plain).unwrap();
    let packed = gzip(&plain);
    for end in [packed.len() - 1, packed.len() / 2, packed.len() / 4] {
        let cut = read_bytes(&packed[..end]).unwrap();
        assert_eq!(cut.skipped.total(), 1);
        assert_eq!(cut.skipped.count(SkipReason::Truncated), 1);
        assert!(!cut.beams.is_empty() && cut.beams.len() <= whole.beams.len());
        // No half line was taken for a whole one.
        assert_eq!(cut.beams, whole.beams[..cut.beams.len()]);
    }
    assert!(message(&packed[..12]).starts_with("f.log:1: the gzip data are damaged"));
}

#[test]
fn damage_in_packed_data_is_an_error_and_padding_behind_them_is_not() {
    let packed = gzip(&many_readings(100));
    let mut damaged = packed.clone();
    let checksum = damaged.len() - 8;
    damaged[checksum] ^= 1;
    assert!(message(&damaged).contains("the gzip data are damaged"));
    let padded = read_bytes(&[packed, vec![0; 512]].concat()).unwrap();
    assert_eq!(padded.beams.len(), 100);
    assert_eq!(padded.skipped.count(SkipReason::TrailingBytes), 1);
}

#[test]
fn a_gzip_bomb_ends_without_its_weight_in_memory() {
    // 256 MiB without a line end behind one good beam: all of it is one line to be skipped.
    let mut bomb = GzEncoder::new(Vec::new(), Compression::fast());
    io::copy(&mut &many_readings(1)[..], &mut bomb).unwrap();
    io::copy(&mut io::repeat(b'7').take(256 << 20), &mut bomb).unwrap();
    let bomb = bomb.finish().unwrap();
    assert!(bomb.len() < 4 << 20);
    let recording = read_bytes(&bomb).unwrap();
    assert_eq!(recording.beams.len(), 1);
    assert_eq!(recording.skipped.count(SkipReason::TooLong), 1);
}

#[test]
fn more_beams_than_allowed_are_refused_by_line() {
    let options = LoadOptions {
        max_beams: 10,
        ..LoadOptions::default()
    };
    assert_eq!(
        read_with(&many_readings(10), &options).unwrap().beams.len(),
        10
    );
    let error = read_with(&many_readings(11), &options).unwrap_err();
    assert_eq!(
        error.to_string(),
        "f.log:12: more than 10 beams; split the recording into shorter ones"
    );
}

#[test]
fn every_error_names_the_file_and_what_to_do() {
    assert_eq!(
        message(b""),
        "f.log: is empty; a recording needs at least one beam"
    );
    assert_eq!(
        message(&gzip(b"")),
        "f.log: is empty; a recording needs at least one beam"
    );
    let png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR";
    assert!(message(png).starts_with("f.log: is not text; give"));
    assert!(message(&gzip(png)).starts_with("f.log: is not text; give"));
    assert!(message(b"Dear all,\n").starts_with("f.log: no line of its start is"));
    let damaged = format!("{HEADER}\n# note\n0,0,0,0,0,5\n0,1,0\n");
    assert_eq!(
        message(damaged.as_bytes()),
        "f.log:3: no usable beam: sensor not within 1 to 255 (2 lines skipped in all); \
         repair these lines"
    );
    assert_eq!(
        message(b"ODOM 0 0 0 0 0 0 0.1 h 0.1\n"),
        "f.log: no beam in it (no line skipped); record range readings with poses"
    );
    let load = |path: &Path| load(path, &LoadOptions::default(), &mut |_, _| ()).unwrap_err();
    let missing = load(Path::new("no/such\nfile"));
    assert!(matches!(missing, LoadError::Open { .. }));
    assert_eq!(missing.to_string().lines().count(), 1);
    let directory = load(Path::new(env!("CARGO_MANIFEST_DIR")));
    assert!(matches!(directory, LoadError::Directory { .. }));
}

#[test]
fn damaged_lines_cost_only_themselves() {
    let mut file = many_readings(3);
    file.extend_from_slice(b"\xff\xfe\0\n5,1,0,0,0,5,5\r\n\r\n# end\r\n6,1,0,0,0,17\r\n");
    let recording = read_bytes(&file).unwrap();
    assert_eq!(recording.beams.len(), 4);
    let skipped: Vec<String> = recording
        .skipped
        .first()
        .iter()
        .map(ToString::to_string)
        .collect();
    assert_eq!(
        skipped,
        ["line 5: not text", "line 6: wrong number of fields"]
    );
}

#[test]
fn steps_back_in_time_are_counted_and_kept() {
    let file =
        format!("{HEADER}\n5,1,0,0,0,1\n9,1,0,0,0,2\n3,1,0,0,0,3\n3,1,0,0,0,4\n7,1,0,0,0,5\n");
    let recording = read_bytes(file.as_bytes()).unwrap();
    assert_eq!(recording.backward_steps, 1);
    let order: Vec<u32> = recording.beams.iter().map(|beam| beam.at.get()).collect();
    assert_eq!(order, [5, 9, 3, 3, 7]);
}

#[test]
fn the_extent_holds_origins_and_echoes() {
    let file = format!("{HEADER}\n0,1,10,20,0,1000\n0,1,-5,0,270000,300\n0,1,0,0,180000,none\n");
    let recording = read_bytes(file.as_bytes()).unwrap();
    let (low, high) = recording.extent();
    assert_eq!(
        (low, high),
        (Point::from_mm(-5, -300), Point::from_mm(1010, 20))
    );
}

#[test]
fn progress_ends_at_the_whole_file() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/eight-sonar.csv");
    let mut last = (0, 0);
    load(&path, &LoadOptions::default(), &mut |done, total| {
        assert!(done >= last.0);
        last = (done, total);
    })
    .unwrap();
    let length = std::fs::metadata(&path).unwrap().len();
    assert_eq!(last, (length, length));
}

#[test]
fn the_eight_sonar_run_reads_whole() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/eight-sonar.csv");
    let recording = load(&path, &LoadOptions::default(), &mut |_, _| ()).unwrap();
    let expected = Tally {
        echo: 2236,
        no_object: 1068,
        ..Tally::default()
    };
    assert_eq!(recording.tally(), expected);
    assert_eq!((recording.sensors, recording.backward_steps), (8, 0));
    assert_eq!(recording.skipped.total(), 0);
    assert_eq!(recording.beams.last().unwrap().at, Ticks::new(92_837));
}

/// Where logs are that the project may not bring along, if this machine has them.
fn borrowed_data() -> Option<PathBuf> {
    let folder = std::env::var_os("CERTAINTY_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"),
        PathBuf::from,
    );
    folder.is_dir().then_some(folder)
}

#[test]
fn real_carmen_logs_read_without_a_line_skipped() {
    let Some(folder) = borrowed_data() else {
        eprintln!("skipped: set CERTAINTY_DATA to the folder with carmen/*.log.gz");
        return;
    };
    // Name, scans, beams a scan, the laser's no echo in millimetres and how often it occurs (counted
    // by another program), steps back in time.
    let logs = [
        ("intel", 910, 180, 80_000, 4172, 4),
        ("fhw", 488, 180, 50_000, 647, 0),
        ("acapulco", 861, 181, 50_000, 13_213, 0),
        ("orebro", 237, 181, 32_700, 968, 0),
    ];
    for (name, scans, per_scan, no_echo, no_object, backward) in logs {
        let path = folder.join(format!("carmen/{name}-corrected.log.gz"));
        let options = LoadOptions {
            max_range: Some(Millimeters::new(no_echo)),
            ..LoadOptions::default()
        };
        let recording = load(&path, &options, &mut |_, _| ()).unwrap();
        let expected = Tally {
            echo: (scans * per_scan) as u64 - no_object,
            no_object,
            ..Tally::default()
        };
        assert_eq!(recording.tally(), expected, "{name}");
        assert_eq!(recording.skipped.total(), 0, "{name}");
        assert_eq!(recording.backward_steps, backward, "{name}");
        if name == "acapulco" {
            // Its last beam is stuck at 50 m in every scan: a fault that must draw no wall.
            let mut stuck = recording.beams.iter().skip(180).step_by(181);
            assert!(stuck.all(|beam| beam.reading == Reading::NoObject));
        }
    }
}

fn any_reading() -> impl Strategy<Value = Reading> {
    prop_oneof![
        any::<u32>().prop_map(|mm| Reading::Echo(Millimeters::new(mm))),
        Just(Reading::NoObject),
        Just(Reading::TooNear),
        Just(Reading::Missing(Missing::Timeout)),
    ]
}

prop_compose! {
    fn any_beam()(
        at: u32,
        sensor in 1_u8..,
        x in -Point::LIMIT..=Point::LIMIT,
        y in -Point::LIMIT..=Point::LIMIT,
        bearing: u16,
        reading in any_reading(),
    ) -> RecordedBeam {
        RecordedBeam {
            at: Ticks::new(at),
            sensor: SensorId::try_new(sensor).unwrap(),
            origin: Point::from_mm(x, y),
            bearing: BinaryAngle::from_bits(bearing),
            reading,
        }
    }
}

/// Words that steer the parsers into their corners.
fn any_word() -> impl Strategy<Value = String> {
    prop_oneof![
        Just("FLASER".to_owned()),
        Just("ROBOTLASER1".to_owned()),
        Just(format!("\n{HEADER}\n")),
        Just("\n".to_owned()),
        Just("nan".to_owned()),
        Just("-inf".to_owned()),
        Just(",".to_owned()),
        Just("1e999".to_owned()),
        Just("18446744073709551615".to_owned()),
        (0_u32..12).prop_map(|n| n.to_string()),
        any::<i64>().prop_map(|n| n.to_string()),
        any::<f64>().prop_map(|n| n.to_string()),
    ]
}

proptest! {
    #[test]
    fn what_is_written_reads_back(beams in prop::collection::vec(any_beam(), 1..50)) {
        let mut file = Vec::new();
        write_readings(&mut file, &beams).unwrap();
        prop_assert_eq!(read_bytes(&file).unwrap().beams, beams);
    }

    #[test]
    fn no_bytes_panic(bytes: Vec<u8>, format in 0_usize..3, packed: bool) {
        let options = LoadOptions {
            format: [None, Some(Format::Carmen), Some(Format::Readings)][format],
            ..LoadOptions::default()
        };
        let _ = read_with(&bytes, &options);
        let bytes = if packed { gzip(&bytes) } else { [&[0x1F, 0x8B, 8][..], &bytes].concat() };
        let _ = read_with(&bytes, &options);
    }

    #[test]
    fn no_words_panic(words in prop::collection::vec(any_word(), 0..60), format in 0_usize..2) {
        let options = LoadOptions {
            format: [Some(Format::Carmen), Some(Format::Readings)][format],
            sensors: NonZeroU8::MAX,
            ..LoadOptions::default()
        };
        let _ = read_with(words.join(" ").as_bytes(), &options);
        let _ = read_with(words.concat().as_bytes(), &options);
    }

    #[test]
    fn no_damage_to_a_scan_panics_or_gives_half_of_it(
        place in 0_usize..200,
        byte: u8,
        readings in prop::collection::vec(0.0..9.0_f64, 1..30),
    ) {
        let numbers: Vec<String> = readings.iter().map(ToString::to_string).collect();
        let line = format!("FLASER {} {} 1 2 3 1 2 3 4.5 h 4.5", numbers.len(), numbers.join(" "));
        let mut bytes = line.into_bytes();
        let place = place % bytes.len();
        bytes[place] = byte;
        let options = LoadOptions { format: Some(Format::Carmen), ..LoadOptions::default() };
        if let Ok(recording) = read_with(&bytes, &options) {
            // A changed digit is a changed number; the count is right or the line is gone.
            let text = String::from_utf8(bytes).unwrap();
            let announced: usize = text.split_ascii_whitespace().nth(1).unwrap().parse().unwrap();
            prop_assert_eq!(recording.beams.len(), announced);
        }
    }
}
