//! `certainty replay`: maps of a known room.

use crate::support::{
    BEAMS, Cell, Map, NO_ECHO_M, Place, Room, all_around, certainty, command, flaser, gzip, log,
    robotlaser, shape,
};
use certainty_tests::process::{Ran, run};
use certainty_tests::workspace;
use core::time::Duration;
use serde_json::Value;
use std::fs;

/// A square room whose walls stand 1 cm deep in the cells that begin at ±2.9 m.
///
/// So a beam that grazes a wall leaves hardly a trace in the wall's own cells.
const WALL_M: f64 = 2.91;

fn square_room() -> Room {
    let w = WALL_M;
    Room::new(&[[-w, -w], [w, -w], [w, w], [-w, w]])
}

/// Looks in every direction from several places.
fn tour() -> Vec<Place> {
    let stops = [
        (0.05, 0.05),
        (-1.52, -1.03),
        (1.57, -1.48),
        (1.03, 1.52),
        (-1.48, 1.57),
    ];
    let looks = stops.map(|(x, y)| all_around(x, y));
    // Twice, so that every virtual sensor sees every wall more than once.
    let once: Vec<Place> = looks.concat();
    let turned = once.iter().map(|place| Place {
        heading: place.heading + 0.01,
        ..*place
    });
    once.iter().copied().chain(turned).collect()
}

fn room_log() -> String {
    log(&square_room(), &tour(), flaser)
}

/// Replays `recording` in a folder of its own; returns how it went and the map.
fn replay(recording: impl AsRef<[u8]>, options: &str) -> (Ran, Map) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("recording"), recording).unwrap();
    let ran = certainty(folder.path(), &format!("replay recording {options}"));
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let map = Map::read(&folder.path().join("out"));
    (ran, map)
}

fn confidences(document: &Value) -> Vec<f64> {
    let sensors = document["sensors"].as_array().unwrap().iter();
    sensors
        .map(|sensor| sensor["confidence"].as_f64().unwrap())
        .collect()
}

/// The report without the time it took.
fn untimed(mut document: Value) -> Value {
    document["insert_seconds"] = Value::Null;
    document["cpu_seconds"] = Value::Null;
    document
}

#[test]
fn json_has_the_shape_of_its_snapshot() {
    let folder = tempfile::tempdir().unwrap();
    let sonar = workspace().join("host-sim/data/eight-sonar.csv");
    let arguments = ["replay", sonar.to_str().unwrap(), "--json"];
    let ran = run(command(folder.path(), arguments), Duration::from_secs(60));
    assert_eq!(ran.stderr, "");
    let document = ran.json();
    insta::assert_json_snapshot!("replay", shape(&document));
    assert_eq!(
        document["files"],
        serde_json::json!(["out/map.png", "out/map.pgm", "out/map.yaml"])
    );
    for file in ["map.png", "map.pgm", "map.yaml"] {
        assert!(folder.path().join("out").join(file).is_file(), "{file}");
    }
}

/// Half a cell beside the axis is inside the cone, as documented.
#[test]
fn a_cone_frees_the_cells_ahead_from_anywhere_in_a_cell() {
    for x_mm in [0, 50] {
        // Looks up, more than once because one beam that passes does not make a cell free; and two short
        // echoes that make the map as large as the cone is long.
        let up = format!("0,1,{x_mm},0,90000,none\n").repeat(4);
        let beams = format!(
            "{up}1,1,{x_mm},3000,0,100\n2,1,{},0,180000,100\n",
            x_mm - 1500
        );
        let recording = format!("t_ms,sensor,x_mm,y_mm,bearing_mdeg,reading\n{beams}");
        let options = "--beam-width 20deg --max-range 3m --fusion bayes";
        let (_, map) = replay(recording, options);
        for row in 1..29 {
            let y = f64::from(row) * 0.1 + 0.05;
            let ahead = map.at_place(f64::from(x_mm) / 1000.0 + 0.0005, y);
            assert_eq!(ahead, Cell::Free, "{y} m ahead of x = {x_mm} mm\n{map}");
        }
    }
}

/// Asserts walls at their places, free inside, unknown outside.
fn assert_square_room(map: &Map, what: &str) {
    // The cells that hold a wall begin at 2.9 m and end at 3.0 m.
    let outermost = |[x, y]: [f64; 2]| x.abs().max(y.abs());
    for place in map.places(Cell::Occupied) {
        let out = outermost(place);
        assert!(
            (2.9..3.0).contains(&out),
            "{what}: an obstacle at {place:?}\n{map}"
        );
    }
    for place in map.places(Cell::Free) {
        assert!(
            outermost(place) < 3.0,
            "{what}: free beyond the wall at {place:?}\n{map}"
        );
    }
    let steps = || (-29..29).map(|cell| f64::from(cell) * 0.1 + 0.05);
    let mut walls = [0; 4];
    for along in steps() {
        for (count, (x, y)) in
            walls
                .iter_mut()
                .zip([(-2.95, along), (2.95, along), (along, -2.95), (along, 2.95)])
        {
            *count += i32::from(map.at_place(x, y) == Cell::Occupied);
        }
        for across in steps() {
            let inside = map.at_place(along, across);
            assert_eq!(inside, Cell::Free, "{what}: at {along}, {across}\n{map}");
        }
    }
    for wall in walls {
        // A grazing beam may free a wall's cell, and the robust grid takes the latest claim.
        assert!(wall >= 46, "{what}: {wall} of 58 cells of a wall\n{map}");
    }
}

#[test]
fn every_method_maps_a_known_rooms_walls() {
    for (method, bytes_per_cell) in [
        ("bayes", 1.0),
        ("robust", 1.25),
        ("trimmed", 3.0),
        ("median", 3.0),
    ] {
        let (ran, map) = replay(room_log(), &format!("--json --fusion {method}"));
        assert_square_room(&map, method);
        let document = ran.json();
        let bytes = document["grid"]["bytes_per_cell"].as_f64().unwrap();
        // Owners end on a whole byte.
        assert!((bytes - bytes_per_cell).abs() < 0.001, "{method}: {bytes}");
        assert_eq!(document["readings"], tour().len() * BEAMS);
        assert_eq!(document["echo"], tour().len() * BEAMS);
    }
}

#[test]
fn any_number_of_virtual_sensors_draws_the_same_room() {
    for sensors in [1, 2, 4, 7] {
        let (ran, map) = replay(room_log(), &format!("--json --sensors {sensors}"));
        assert_square_room(&map, &format!("{sensors} sensors"));
        let document = ran.json();
        let dealt = document["sensors"].as_array().unwrap();
        assert_eq!(dealt.len(), sensors);
        // Beam i of a scan goes to sensor i mod N.
        for (slot, sensor) in dealt.iter().enumerate() {
            let of_a_scan = (0..BEAMS).filter(|beam| beam % sensors == slot).count();
            assert_eq!(sensor["readings"], of_a_scan * tour().len());
        }
    }
}

#[test]
fn gzip_and_plain_give_the_same_map() {
    let log = room_log();
    let (plain, plain_map) = replay(&log, "--json");
    let (packed, packed_map) = replay(gzip(log.as_bytes()), "--json");
    assert_eq!(untimed(plain.json()), untimed(packed.json()));
    assert_eq!(plain_map, packed_map);
}

#[test]
fn robotlaser1_and_flaser_give_the_same_map() {
    let newer = log(&square_room(), &tour(), robotlaser);
    assert!(newer.starts_with("ROBOTLASER1 "));
    let (older, older_map) = replay(room_log(), "--json");
    let (newer, newer_map) = replay(newer, "--json");
    assert_square_room(&newer_map, "ROBOTLASER1");
    // The older one does not have the directions of its beams.
    let (mut older, mut newer) = (untimed(older.json()), untimed(newer.json()));
    assert_eq!(older["notes"].take().as_array().unwrap().len(), 1);
    assert_eq!(newer["notes"].take(), serde_json::json!([]));
    assert_eq!(older, newer);
    assert_eq!(older_map, newer_map);
}

/// The notes of a replay, which must succeed without a skipped line.
fn notes(ran: &Ran) -> Vec<String> {
    let document = ran.json();
    assert_eq!(document["skipped_lines"], 0);
    let notes = document["notes"].as_array().unwrap().iter();
    notes
        .map(|note| note.as_str().unwrap().to_owned())
        .collect()
}

/// A line of `beams` ranges from `start_deg`, by `line`, at every place of the tour.
fn wide_log(
    beams: usize,
    start_deg: f64,
    step_deg: f64,
    line: impl Fn(&str, Place) -> String,
) -> String {
    let room = square_room();
    let scan = |place: &Place| {
        let bearing =
            |beam: usize| place.heading + (beam as f64).mul_add(step_deg, start_deg).to_radians();
        let range = |beam| room.distance(place.x, place.y, bearing(beam)).to_string();
        let ranges: Vec<String> = (0..beams).map(range).collect();
        line(&format!("{beams} {}", ranges.join(" ")), *place)
    };
    tour().iter().map(scan).collect()
}

/// The fields of a pose.
fn pose(Place { x, y, heading }: Place) -> String {
    format!("{x} {y} {heading}")
}

#[test]
fn field_of_view_comes_from_count_parameters_or_options() {
    for (beams, start_deg, step_deg, head, options, noted) in [
        (541, -135.0, 0.5, "", "", true),
        (401, -50.0, 0.25, "", "", true),
        (682, -340.0 * 360.0 / 1024.0, 360.0 / 1024.0, "", "", true),
        (
            271,
            -135.0,
            1.0,
            "PARAM laser_front_laser_fov 270.0 nohost 0\n",
            "",
            true,
        ),
        (
            121,
            -30.0,
            0.5,
            "PARAM laser_front_laser_resolution 0.5 nohost 0\n",
            "",
            true,
        ),
        (360, -180.0, 1.0, "", "--fov 360deg", false),
        (181, -45.0, 0.5, "", "--fov 90deg", false),
        (181, 0.0, 0.5, "", "--fov 90deg --start-angle 0deg", false),
    ] {
        let log = wide_log(beams, start_deg, step_deg, |ranges, place| {
            let pose = pose(place);
            format!("FLASER {ranges} {pose} {pose} 5 robot 5\n")
        });
        let (ran, map) = replay(format!("{head}{log}"), &format!("--json {options}"));
        assert_eq!(notes(&ran).len(), usize::from(noted), "{beams} {options}");
        for place in map.places(Cell::Occupied) {
            let out = place[0].abs().max(place[1].abs());
            assert!(
                (2.9..3.0).contains(&out),
                "{beams} {options}: {place:?}\n{map}"
            );
        }
        assert!(
            map.places(Cell::Occupied).len() > 150,
            "{beams} {options}\n{map}"
        );
    }
}

#[test]
fn poses_come_from_the_line_or_the_odometry_before() {
    let (reference, expected) = replay(room_log(), "--json");
    let all_the_same = [
        log(&square_room(), &tour(), |ranges, place, time_s| {
            flaser(ranges, place, time_s).replacen("FLASER", "RLASER", 1)
        }),
        log(&square_room(), &tour(), |ranges, place, time_s| {
            let scan = robotlaser(ranges, place, time_s);
            let end = scan.match_indices(' ').nth(8 + BEAMS + 1).unwrap().0;
            let scan = scan[..end].replacen("ROBOTLASER1", "RAWLASER1", 1);
            format!(
                "ODOM {} 0 0 0 {time_s} robot 0\n{scan} {time_s} robot 0\n",
                pose(place)
            )
        }),
        // Fields that are not needed.
        room_log()
            .lines()
            .map(|line| {
                let (before, _) = line.rsplit_once(" robot").unwrap();
                format!("{before} my old robot\n")
            })
            .collect(),
    ];
    for log in all_the_same {
        let (ran, map) = replay(&log, "--json");
        assert_eq!(ran.json()["readings"], reference.json()["readings"]);
        let _ = notes(&ran); // checks that no line was skipped
        assert_eq!(map, expected, "{}", &log[..40]);
    }
}

#[test]
fn host_name_in_any_encoding_costs_no_line() {
    let named: Vec<u8> = room_log().replace("robot", "r\u{1}bot").into_bytes();
    let named: Vec<u8> = named
        .into_iter()
        .map(|byte| if byte == 1 { 0xF6 } else { byte })
        .collect();
    let (ran, map) = replay(named, "--json");
    assert_eq!(notes(&ran).len(), 1);
    assert_eq!(map, replay(room_log(), "--json").1);
}

#[test]
fn sonars_map_the_room_as_sensors_of_their_own() {
    for with_pose in [true, false] {
        let log = wide_log(16, 0.0, 22.5, |ranges, place| {
            let pose = pose(place);
            let own = if with_pose {
                format!(" {pose}")
            } else {
                String::new()
            };
            format!("ODOM {pose} 0 0 0 5 robot 0\nSONAR {ranges}{own} 5 robot 0\n")
        });
        let (ran, map) = replay(log, "--json");
        assert_eq!(ran.json()["sensors"].as_array().unwrap().len(), 16);
        assert_eq!(notes(&ran).len(), 1 + usize::from(!with_pose));
        assert!(map.places(Cell::Occupied).len() > 50, "{map}");
        for place in map.places(Cell::Occupied) {
            let out = place[0].abs().max(place[1].abs());
            assert!((2.9..3.0).contains(&out), "{place:?}\n{map}");
        }
    }
}

#[test]
fn infinity_and_zero_are_no_object() {
    let room = square_room();
    let far = |word: &str| {
        log(&room, &tour(), |ranges, place, time_s| {
            let ranges: Vec<f64> = ranges
                .iter()
                .map(|&m| if m > 3.5 { NO_ECHO_M } else { m })
                .collect();
            flaser(&ranges, place, time_s)
        })
        .replace(&NO_ECHO_M.to_string(), word)
    };
    let (reference, expected) = replay(far("81.83"), "--json");
    for (word, noted) in [("inf", 1), ("Infinity", 1), ("0", 2), ("0.000", 2)] {
        let (ran, map) = replay(far(word), "--json");
        assert_eq!(map, expected, "{word}");
        assert_eq!(ran.json()["sensors"], reference.json()["sensors"], "{word}");
        assert_eq!(notes(&ran).len(), noted, "{word}");
    }
    let count = reference.json()["no_object"].clone();
    assert_eq!(
        replay(far("0"), "--json --zero near").0.json()["too_near"],
        count
    );
    assert_eq!(replay(far("-inf"), "--json").0.json()["too_near"], count);
    for word in ["nan", "-1"] {
        assert_eq!(
            replay(far(word), "--json").0.json()["missing"],
            count,
            "{word}"
        );
    }
}

#[test]
fn text_report_prints_the_notes() {
    let (ran, _) = replay(room_log(), "");
    let note = "FLASER of 180 readings: from -90deg in steps of 1deg, assumed";
    assert!(
        ran.stdout.lines().any(|line| line.starts_with(note)),
        "{}",
        ran.stdout
    );
}

#[test]
fn the_format_can_be_named() {
    let (named, map) = replay(room_log(), "--json --format carmen");
    let (found, same) = replay(room_log(), "--json --format auto");
    assert_eq!(untimed(named.json()), untimed(found.json()));
    assert_eq!(map, same);
}

#[test]
fn readings_beyond_the_range_are_no_obstacles() {
    let place = all_around(0.0, 0.0)[0];
    for metres in [8.0, 8.001, 50.0, NO_ECHO_M, 1e9] {
        let line = flaser(&[metres; BEAMS], place, 0.0);
        for method in ["bayes", "robust", "trimmed", "median"] {
            let (ran, map) = replay(&line, &format!("--json --fusion {method}"));
            assert_eq!(ran.json()["no_object"], BEAMS, "{metres} m");
            assert_eq!(
                map.places(Cell::Occupied),
                [[0.0; 2]; 0],
                "{metres} m by {method}"
            );
        }
    }
    // Below the range they are obstacles.
    let (ran, map) = replay(flaser(&[7.999; BEAMS], place, 0.0), "--json");
    assert_eq!(ran.json()["echo"], BEAMS);
    assert!(!map.places(Cell::Occupied).is_empty());
}

#[test]
fn a_room_beyond_the_largest_range_is_open_space() {
    let (ran, map) = replay(
        log(&square_room(), &all_around(0.0, 0.0), flaser),
        "--json --max-range 2m",
    );
    assert_eq!(ran.json()["no_object"], 4 * BEAMS);
    assert_eq!(map.places(Cell::Occupied), [[0.0; 2]; 0]);
}

#[test]
fn cells_have_the_size_of_the_option() {
    for (cell, resolution) in [("50mm", 0.05), ("20cm", 0.2), ("1m", 1.0)] {
        let (ran, map) = replay(room_log(), &format!("--json --cell {cell}"));
        assert!((map.resolution - resolution).abs() < 1e-9);
        let cell_mm = ran.json()["grid"]["cell_mm"].as_f64().unwrap();
        assert!((cell_mm - resolution * 1000.0).abs() < 1e-6);
        let extent = map.width as f64 * resolution;
        assert!(
            extent >= 2.0 * WALL_M,
            "the grid holds the room: {extent} m"
        );
    }
}

#[test]
fn a_stuck_sensor_loses_confidence_but_not_the_room() {
    let (ran, map) = replay(room_log(), "--json --fault stuck-far:2 --fusion median");
    // Sensors 1 and 3 are the majority wherever both saw a cell.
    for place in map.places(Cell::Occupied) {
        let out = place[0].abs().max(place[1].abs());
        assert!((2.9..3.0).contains(&out), "{place:?}\n{map}");
    }
    assert!(map.places(Cell::Occupied).len() > 4 * 58 / 2, "{map}");
    assert_eq!(ran.json()["skipped_lines"], 0);

    // What stands in front of everything is contradicted everywhere.
    let (ran, _) = replay(room_log(), "--json --fault stuck-near:2=300mm");
    let confidences = confidences(&ran.json());
    assert!(
        confidences[1] < confidences[0] && confidences[1] < confidences[2],
        "{confidences:?}"
    );
}

#[test]
fn a_silent_sensor_fails_and_the_others_map_the_room() {
    let (ran, map) = replay(room_log(), "--json --fault dropout:2=100% --fusion robust");
    let document = ran.json();
    let sensors = document["sensors"].as_array().unwrap();
    let of_each = tour().len() * BEAMS / 3;
    assert_eq!(sensors[1]["missing"], of_each);
    assert_eq!(sensors[1]["status"], "failed");
    assert_eq!(
        (&sensors[0]["missing"], &sensors[2]["missing"]),
        (&0.into(), &0.into())
    );
    assert!(map.places(Cell::Occupied).len() > 4 * 58 * 9 / 10, "{map}");
}

#[test]
fn a_random_fault_follows_the_seed() {
    let options = |seed: u8| format!("--json --fault random:1 --seed {seed}");
    let run = |seed: u8| {
        let (ran, map) = replay(room_log(), &options(seed));
        (untimed(ran.json()), map)
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
}

/// Five sensors of a robot in a room; a function writes the reading of a line.
fn readings(write: impl Fn(u32, u32) -> String) -> String {
    let lines = (0..40).flat_map(|at| (1..=4).map(move |sensor| (at, sensor)));
    let line = |(at, sensor)| {
        let bearing = (sensor - 1) * 90_000 + at * 1000;
        let reading = write(at, sensor);
        format!("{},{sensor},{},0,{bearing},{reading}\n", at * 100, at * 20)
    };
    format!(
        "t_ms,sensor,x_mm,y_mm,bearing_mdeg,reading\n{}",
        lines.map(line).collect::<String>()
    )
}

#[test]
fn the_same_readings_in_another_form_give_the_same_map() {
    let value = |at: u32, sensor: u32| {
        if sensor == 3 {
            "none".to_owned()
        } else {
            (1500 + at).to_string()
        }
    };
    let plain = readings(value);
    let (expected, map) = replay(&plain, "--json");
    let (header, lines) = plain.split_once('\n').unwrap();
    let fractions: String = lines
        .lines()
        .map(|line| line.replace("none", "inf") + ".25\n")
        .collect();
    let fractions = fractions.replace("inf.25", "inf");
    for other in [
        readings(|at, sensor| value(at, sensor).replace("none", "inf")),
        readings(|at, sensor| value(at, sensor).replace("none", "0")),
        format!("{header}\n{fractions}"),
        plain.replace(',', ";"),
        plain.replace(',', "\t"),
        plain.replace(',', ", "),
        format!("{}\n{lines}", header.to_uppercase()),
    ] {
        let (ran, same) = replay(&other, "--json");
        let (mut ran, mut expected) = (untimed(ran.json()), untimed(expected.json()));
        (ran["notes"], expected["notes"]) = (Value::Null, Value::Null);
        assert_eq!(ran, expected, "{other}");
        assert_eq!(same, map);
    }
}

#[test]
fn a_recording_is_read_from_stdin() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("recording"), room_log()).unwrap();
    let mut from_stdin = command(folder.path(), ["replay", "-", "--json"]);
    from_stdin.stdin(fs::File::open(folder.path().join("recording")).unwrap());
    let read = run(from_stdin, Duration::from_secs(60));
    let (expected, _) = replay(room_log(), "--json");
    assert_eq!(untimed(read.json()), untimed(expected.json()));
}

#[test]
fn a_sensor_without_a_reading_is_in_the_table_as_failed() {
    for silence in ["", "-1", "nan", "missing"] {
        let recording = readings(|_, sensor| {
            if sensor == 2 {
                silence.to_owned()
            } else {
                "1500".to_owned()
            }
        });
        let (ran, _) = replay(recording, "--json");
        let sensors = ran.json()["sensors"].as_array().unwrap().clone();
        assert_eq!(
            (sensors.len(), &sensors[1]["id"]),
            (4, &2.into()),
            "{silence}"
        );
        assert_eq!(
            (&sensors[1]["status"], &sensors[1]["missing"]),
            (&"failed".into(), &40.into())
        );
    }
}

#[test]
fn a_sensor_keeps_the_number_of_its_file() {
    let recording = readings(|_, _| "1500".to_owned())
        .replace(",3,", ",0,")
        .replace(",4,", ",65535,");
    let (ran, _) = replay(recording, "--json --fault stuck-near:65535=300mm");
    let document = ran.json();
    let sensors = document["sensors"].as_array().unwrap();
    let ids: Vec<_> = sensors.iter().map(|sensor| sensor["id"].clone()).collect();
    assert_eq!(ids, [0, 1, 2, 65535]);
}

#[test]
fn a_wide_csv_draws_the_room_of_its_readings() {
    // Four sensors at the corners of a robot in a square room, in metres and in seconds of the echo.
    let room = square_room();
    let poses: Vec<(f64, f64, f64)> = (0..40)
        .map(|at| (f64::from(at) * 0.02 - 0.4, 0.1, f64::from(at) * 0.07))
        .collect();
    let wide = |unit: f64| {
        let line = |(at, &(x, y, heading)): (usize, &(f64, f64, f64))| {
            let ranges = [1.0, 3.0, 5.0, 7.0].map(|eighth: f64| {
                let bearing = heading + eighth * core::f64::consts::FRAC_PI_4;
                (room.distance(x, y, bearing) / unit).to_string()
            });
            format!("{at}, {x}, {y}, {heading}, {}\n", ranges.join(", "))
        };
        let lines: String = poses.iter().enumerate().map(line).collect();
        format!(
            "# timestamp, pos_x, pos_y, heading, ultrasound0, ultrasound1, ultrasound2, ultrasound3\n{lines}"
        )
    };
    let (metres, map) = replay(wide(1.0), "--unit m --start-angle 45deg");
    assert!(metres.stdout.contains("--start-angle"), "{}", metres.stdout);
    let (_, echoes) = replay(wide(171.5), "--unit echo-s --start-angle 45deg");
    assert_eq!(map, echoes);
    for [x, y] in map.places(Cell::Occupied) {
        assert!(
            (2.8..3.1).contains(&x.abs().max(y.abs())),
            "an obstacle at {x}, {y}\n{map}"
        );
    }
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("recording"), wide(1.0)).unwrap();
    for (options, named) in [
        ("--start-angle 45deg", "--unit"),
        ("--unit m", "--start-angle"),
    ] {
        let ran = certainty(folder.path(), &format!("replay recording {options}"));
        assert!(ran.refusal().contains(named), "{ran:?}");
    }
}

#[test]
fn a_wild_pose_is_named_and_can_be_left_out() {
    let places = all_around(0.0, 0.0);
    let mut track: Vec<Place> = (0..8)
        .map(|step| Place {
            x: f64::from(step) * 0.1,
            ..places[0]
        })
        .collect();
    track[4].x = 20_000.0;
    let wild: String = (0..8)
        .map(|at| flaser(&[2.0; BEAMS], track[at], 0.0))
        .collect();
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("recording"), &wild).unwrap();
    let ran = certainty(folder.path(), "replay recording");
    let line = ran.refusal();
    assert!(
        line.contains("line 5 has a pose") && line.contains("--max-step"),
        "{line}"
    );
    let (ran, _) = replay(&wild, "--max-step 5m --json");
    let expected = serde_json::json!([{"reason": "far_step", "lines": 1, "first_line": 5}]);
    assert_eq!(ran.json()["skipped"], expected);
    fs::write(folder.path().join("recording"), &wild).unwrap();
    let ran = certainty(folder.path(), "replay recording --max-beams 7");
    let line = ran.refusal();
    assert!(
        line.contains("recording:1: more than 7 beams: give --max-beams"),
        "{line}"
    );
}
