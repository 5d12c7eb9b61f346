//! `certainty monitor`: its contract, with good and damaged telemetry.

use crate::support::{certainty_quickly, command, folder_with, shape};
use certainty_control::{Effort, Wheels};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::{BayesGrid, CertaintyGrid, Environment, Measurement, Shape, Strength};
use certainty_core::health::Health;
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Finding, Missing, Reading};
use certainty_core::units::{BinaryAngle, Millimeters, Ticks};
use certainty_firmware::smart_car::{CELLS, POSE, SENSORS, SmartCarShape};
use certainty_firmware::telemetry::{
    Drive, DriveState, Encoder, FRAME, Head, Hello, Outbox, Ranger, Report, Reporter, Statistics,
};
use certainty_tests::process::{PATIENCE, Ran, run, wait};
use serde_json::Value;
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpListener;
use std::process::Stdio;
use std::thread;

/// The bytes that a board sends.
#[derive(Default)]
struct Line(Vec<u8>);

impl Outbox for Line {
    fn send(&mut self, frame: &[u8]) -> bool {
        self.0.extend_from_slice(frame);
        true
    }
}

/// Frames of a round of [`capture`] after the first: a part of the map, pose, head, ranger, the
/// health of three sensors, statistics.
const ROUND: usize = 8;

/// A capture of `rounds` rounds, each with one more occupied cell, and the map after the last.
fn capture(rounds: u32) -> (Vec<u8>, Vec<u8>) {
    let geometry = SmartCarShape.geometry();
    let mut grid = BayesGrid::try_new(SmartCarShape, Strength::UNLIMITED, [0; CELLS]).unwrap();
    let hello = Hello {
        geometry,
        sensors: SENSORS,
        rangers: 2,
        round_ms: 100,
    };
    let mut reporter = Reporter::<_, CELLS>::try_new(Line::default(), hello, 100)
        .ok()
        .unwrap();
    let sensor = SensorId::try_new(2).unwrap();
    let health = [Health::default(); SENSORS as usize];
    for (round, cell) in (0..rounds).zip(geometry.iter()) {
        let certainty = Certainty::OCCUPIED;
        grid.add(cell, Measurement { sensor, certainty }, &mut []);
        let map = Environment::new(&grid, &health);
        assert!(reporter.send_map(&map, 4));
        reporter.send(&Report::Pose(POSE));
        reporter.send(&Report::Head(Head {
            sensor,
            direction: BinaryAngle::from_millidegrees(-45_000),
            reading: Reading::Echo(Millimeters::new(512)),
            finding: Finding::Plausible,
        }));
        reporter.send(&Report::Ranger(Ranger {
            number: 1,
            reading: Reading::Missing(Missing::Timeout),
        }));
        reporter.send_health(&map);
        reporter.send(&Report::Statistics(Statistics {
            round,
            tick: Ticks::new(100 * round),
            overruns: 3,
            unsent: 0,
        }));
    }
    let cells = geometry.iter().map(|cell| grid.certainty(cell).to_bits());
    let cells = cells.collect();
    (reporter.release().0, cells)
}

/// Frames of a capture of `rounds` rounds: the first has the hello and the whole map in four parts.
fn frames(rounds: usize) -> usize {
    4 + ROUND * rounds
}

/// Monitors a file of `bytes`.
fn monitored(bytes: impl AsRef<[u8]>, options: &str) -> Ran {
    let folder = folder_with(bytes);
    certainty_quickly(folder.path(), &format!("monitor input {options}"))
}

fn cells(document: &Value) -> Vec<u8> {
    let cells = document["map"]["cells"].as_array().unwrap().iter();
    cells
        .map(|cell| u8::try_from(cell.as_u64().unwrap()).unwrap())
        .collect()
}

#[test]
fn json_has_the_shape_of_its_snapshot() {
    let (bytes, _) = capture(2);
    let document = monitored(bytes, "--json").json();
    insta::assert_json_snapshot!("monitor", shape(&document));
}

#[test]
fn a_capture_has_what_the_board_sent() {
    let (bytes, sent) = capture(5);
    let length = bytes.len();
    let document = monitored(bytes, "--json").json();
    assert_eq!(document["bytes"], length);
    assert_eq!(document["frames"], frames(5));
    for none in [
        "lost",
        "restarts",
        "crc_errors",
        "too_long",
        "undecodable",
        "truncated",
    ] {
        assert_eq!(document[none], 0, "{none}");
    }
    let map = &document["map"];
    assert_eq!(
        (&map["complete"], &map["generation"]),
        (&true.into(), &4.into())
    );
    // Pose, head, ranger, three healths and the statistics came after it.
    assert_eq!(map["frames_ago"], ROUND - 1);
    assert_eq!((&map["width"], &map["height"]), (&17.into(), &11.into()));
    assert_eq!((&map["x_mm"], &map["y_mm"]), (&(-850).into(), &0.into()));
    assert_eq!(cells(&document), sent);
    assert!(
        sent[4] > 200 && sent[5] == 128,
        "the capture has something to show"
    );
    let second = &document["sensors"][1];
    assert_eq!(second["id"], 2);
    assert_eq!(second["direction_deg"], -45.0);
    assert_eq!(
        second["reading"],
        serde_json::json!({"kind": "echo", "mm": 512})
    );
    assert_eq!(second["health"]["status"], "healthy");
    assert_eq!(document["sensors"][0]["reading"], Value::Null);
    let missing = serde_json::json!({"kind": "missing", "why": "timeout"});
    assert_eq!(document["rangers"][0]["reading"], missing);
    assert_eq!(document["statistics"]["tick_ms"], 400);
    assert_eq!(document["statistics"]["overruns"], 3);
}

#[test]
fn garbage_is_skipped_and_counted() {
    let (bytes, sent) = capture(4);
    let noise: Vec<u8> = (0..200_u8).map(|byte| byte.wrapping_mul(37) | 1).collect();
    let middle = bytes.len() - 20;
    let dirty = [&noise[..], &[0], &bytes[..middle], &noise, &bytes[middle..]].concat();
    let document = monitored(dirty, "--json").json();
    assert_eq!(document["too_long"], 2);
    // The noise destroys one of the last frames; the last one's number shows that one is missing.
    let received = document["frames"].as_u64().unwrap();
    assert_eq!(
        received + document["lost"].as_u64().unwrap(),
        frames(4) as u64
    );
    assert_eq!(document["lost"], 1);
    assert_eq!(document["map"]["complete"], true);
    assert_eq!(cells(&document), sent);
}

#[test]
fn a_map_with_a_part_missing_is_not_called_complete() {
    let (bytes, sent) = capture(3);
    let mut whole = bytes.split_inclusive(|&byte| byte == 0);
    // The hello, and then the first part of the map.
    let hello = whole.next().unwrap().to_vec();
    whole.next();
    let rest: Vec<u8> = whole.flatten().copied().collect();
    let document = monitored([hello, rest].concat(), "--json").json();
    assert_eq!(document["lost"], 1);
    assert_eq!(document["map"]["complete"], false);
    assert_eq!(document["map"]["generation"], Value::Null);
    assert_ne!(cells(&document), sent);
    let folder = folder_with(bytes);
    let text = certainty_quickly(folder.path(), "monitor input").stdout;
    assert!(text.contains("map 2, complete"), "{text}");
}

#[test]
fn a_capture_cut_anywhere_ends_well() {
    let (bytes, _) = capture(2);
    let ends = |bytes: &[u8]| bytes.iter().filter(|&&byte| byte == 0).count();
    for cut in [bytes.len() - 1, bytes.len() / 2, 100, 40] {
        let document = monitored(&bytes[..cut], "--json").json();
        assert_eq!(document["frames"], ends(&bytes[..cut]), "cut at {cut}");
        let open = usize::from(bytes[cut - 1] != 0);
        assert_eq!(document["truncated"], open, "cut at {cut}");
    }
}

#[test]
fn without_a_terminal_each_report_is_a_line() {
    let (bytes, _) = capture(2);
    let folder = folder_with(bytes);
    for arguments in ["monitor input", "monitor input --plain"] {
        let ran = certainty_quickly(folder.path(), arguments);
        assert_eq!((ran.code, &*ran.stderr), (Some(0), ""));
        assert!(!ran.stdout.contains('\u{1b}'), "no colour, no cursor");
        let (lines, end) = ran.stdout.split_once("\n\n").unwrap();
        let lines: Vec<&str> = lines.lines().collect();
        assert_eq!(lines.len(), frames(2));
        let hello = "    0 hello: 17 x 11 cells of 100mm, 3 sensors, 2 rangers, a round of 100 ms";
        assert_eq!(lines[0], hello);
        assert_eq!(lines[1], "    1 map 0: cells 0 to 47");
        assert_eq!(lines[4], "    4 map 0: cells 144 to 186, complete");
        assert_eq!(lines[6], "    6 sensor 2 at -45.0deg: 512mm");
        assert_eq!(lines[7], "    7 ranger 1: missing, no answer in time");
        assert_eq!(lines[12], "   12 map 1: cell 1, complete");
        // The lowest row is drawn last: two cells are occupied.
        assert!(end.contains("\n##???????????????\n"), "{end}");
        assert!(end.ends_with("end of input\n"), "{end}");
        assert!(
            ran.stdout.lines().all(|line| line.chars().count() <= 80),
            "{end}"
        );
    }
}

#[test]
fn lost_and_damaged_frames_have_lines_in_place() {
    let (bytes, _) = capture(2);
    let mut parts: Vec<Vec<u8>> = bytes
        .split_inclusive(|&byte| byte == 0)
        .map(<[u8]>::to_vec)
        .collect();
    parts[7][3] ^= 0x10;
    parts.remove(5);
    let text = monitored(parts.concat(), "").stdout;
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[5], "      1 frame lost");
    assert_eq!(lines[7], "      a damaged frame: wrong checksum");
    assert_eq!(lines[8], "      1 frame lost");
    assert!(text.contains("2 lost, 1 damaged"), "{text}");
}

#[test]
fn it_ends_after_the_given_number_of_reports() {
    let (bytes, _) = capture(3);
    let document = monitored(&bytes, "--json --frames 6").json();
    assert_eq!(
        (&document["frames"], &document["ended"]),
        (&6.into(), &"enough frames".into())
    );
    assert_eq!(document["truncated"], 0);
}

#[test]
fn standard_input_and_tcp_are_ports_too() {
    let (bytes, sent) = capture(3);
    let folder = folder_with(&bytes);
    let mut reading = command(folder.path(), ["monitor", "-", "--json"]);
    reading.stdin(File::open(folder.path().join("input")).unwrap());
    let document = run(reading, PATIENCE).json();
    assert_eq!(
        (&document["port"], cells(&document)),
        (&"stdin".into(), sent.clone())
    );

    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = server.local_addr().unwrap();
    let sender = thread::spawn(move || server.accept().unwrap().0.write_all(&bytes).unwrap());
    let document =
        certainty_quickly(folder.path(), &format!("monitor tcp:{address} --json")).json();
    assert_eq!(cells(&document), sent);
    sender.join().unwrap();
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_with_a_report_of_what_was_received() {
    let (bytes, _) = capture(1);
    let folder = tempfile::tempdir().unwrap();
    let mut child = command(folder.path(), ["monitor", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut board = child.stdin.take().unwrap();
    board.write_all(&bytes).unwrap();
    let mut text = BufReader::new(child.stdout.take().unwrap());
    let mut line = String::new();
    while !line.contains("round 0") {
        line.clear();
        assert_ne!(text.read_line(&mut line).unwrap(), 0);
    }
    let number = child.id().to_string();
    let killed = std::process::Command::new("kill")
        .args(["-INT", &number])
        .status();
    assert!(killed.unwrap().success());
    assert_eq!(wait(&mut child, PATIENCE), Some(Some(0)));
    let mut rest = String::new();
    text.read_to_string(&mut rest).unwrap();
    assert!(rest.ends_with("interrupted\n"), "{rest}");
    drop(board);
}

#[test]
fn a_closed_pipe_ends_it() {
    let (bytes, _) = capture(1);
    let folder = tempfile::tempdir().unwrap();
    let mut child = command(folder.path(), ["monitor", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut board = child.stdin.take().unwrap();
    drop(child.stdout.take());
    // The board continues; the program must end.
    while board.write_all(&bytes).is_ok() {}
    assert_eq!(wait(&mut child, PATIENCE), Some(Some(0)));
    let mut text = String::new();
    child.stderr.unwrap().read_to_string(&mut text).unwrap();
    assert_eq!(text, "");
}

/// Asserts that the arguments are refused in one line with all of `words`.
fn assert_refused(content: &[u8], arguments: &str, words: &[&str]) {
    let folder = folder_with(content);
    std::fs::create_dir(folder.path().join("directory")).unwrap();
    for json in ["", " --json"] {
        let ran = certainty_quickly(folder.path(), &format!("monitor {arguments}{json}"));
        let line = ran.refusal();
        for word in words {
            assert!(line.contains(word), "{arguments}: no {word} in {line:?}");
        }
    }
}

#[test]
fn other_input_than_telemetry_is_refused_in_one_line() {
    let noise: Vec<u8> = (0..40_000_u32)
        .map(|number| (number.wrapping_mul(0x9E37_79B9) >> 24) as u8)
        .collect();
    assert_refused(b"", "input", &["input: no bytes received"]);
    assert_refused(b"", "-", &["stdin: no bytes received"]);
    assert_refused(
        &noise,
        "input",
        &["input: no complete frame in 40000 bytes", "--baud"],
    );
    assert_refused(&[0; 5000], "input", &["no complete frame"]);
    assert_refused(&[0x55; 5000], "input", &["no complete frame"]);
    assert_refused(b"", "missing", &["missing: cannot be opened"]);
    assert_refused(b"", "directory", &["directory: is a directory"]);
    assert_refused(b"", "tcp:127.0.0.1:1", &["tcp:127.0.0.1:1: cannot connect"]);
    assert_refused(
        b"",
        "tcp:nonsense",
        &["tcp:nonsense: cannot connect", "tcp:HOST:PORT"],
    );
    assert_refused(b"", "input --baud 0", &["--baud"]);
    assert_refused(b"", "input --frames 0", &["--frames"]);
    if cfg!(unix) {
        assert_refused(b"", "/dev/null", &["/dev/null: no bytes received"]);
    }
}

#[test]
fn the_drive_is_in_the_text_and_in_json() {
    let drive = Drive {
        pose: POSE,
        wheels: Wheels {
            right: Effort::lit("0.75"),
            left: Effort::lit("-0.25"),
        },
        state: DriveState::Slowed,
        to_goal: Millimeters::new(1234),
    };
    let mut frame = [0; FRAME];
    let mut encoder = Encoder::new();
    let report = Report::Drive(drive);
    let bytes = encoder.encode(&report, &mut frame).unwrap().to_vec();
    let words = monitored(bytes.clone(), "--plain").stdout;
    let text = "wheels 0.75 right, -0.25 left, slowed, 1234mm to the goal";
    assert!(words.contains(text), "{words}");
    let document = monitored(bytes, "--json").json();
    let text = &document["drive"];
    insta::assert_json_snapshot!("monitor-drive", shape(text));
    assert_eq!(
        (&text["right"], &text["left"]),
        (&0.75.into(), &(-0.25).into())
    );
    assert_eq!(
        (&text["conduct"], &text["to_goal_mm"]),
        (&"slowed".into(), &1234.into())
    );
    assert_eq!(document["pose"]["x_mm"], POSE.at.x_mm());
}

/// A late car goes on by itself; these states need a person.
#[test]
fn a_state_that_needs_a_start_by_hand_is_rendered() {
    for (conduct, words) in [
        (DriveState::Lost, "lost: start it by hand"),
        (DriveState::Restarted, "restarted: start it by hand"),
        (DriveState::Late, "late"),
    ] {
        let report = Report::Drive(Drive {
            pose: POSE,
            wheels: Wheels::STOPPED,
            state: conduct,
            to_goal: Millimeters::new(762),
        });
        let mut frame = [0; FRAME];
        let bytes = Encoder::new().encode(&report, &mut frame).unwrap().to_vec();
        let text = monitored(bytes.clone(), "--plain").stdout;
        let words = format!("0.00 left, {words}, 762mm to the goal");
        assert!(text.contains(&words), "{text}");
        let document = monitored(bytes, "--json").json();
        assert_eq!(document["drive"]["conduct"], conduct.to_string());
    }
}

/// By hand: version 1, sequence 0, variant 6, four zeros, and their CRC-32 by zlib, 0xB45B216A.
#[test]
fn another_version_of_the_format_is_reported() {
    let frame = [2, 1, 2, 6, 1, 1, 1, 5, 0x6A, 0x21, 0x5B, 0xB4, 0];
    let words = ["input: telemetry in version 1", "expected version 3"];
    assert_refused(&frame, "input", &words);
    let (bytes, _) = capture(1);
    let document = monitored([&frame[..], &bytes].concat(), "--json").json();
    assert_eq!(
        (&document["other_version"], &document["version_heard"]),
        (&1.into(), &1.into())
    );
    assert_eq!(document["frames"], frames(1));
}
