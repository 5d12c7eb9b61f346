//! Recordings become maps: of a room that is known, of real sonars, of real lasers.

use certainty_tests::map::{Cell, Map};
use certainty_tests::program::{Ran, certainty, command, run};
use certainty_tests::recording::{
    BEAMS, NO_ECHO_M, Place, Room, all_around, flaser, gzip, log, robotlaser,
};
use certainty_tests::{shared_data, workspace};
use core::time::Duration;
use serde_json::Value;
use std::fs;
use std::path::Path;

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

/// Replays the file at `path`; returns the report and the map.
fn replay_file(path: &Path, options: &str) -> (Value, Map) {
    let folder = tempfile::tempdir().unwrap();
    let mut arguments = vec!["replay", path.to_str().unwrap(), "--json"];
    arguments.extend(options.split_whitespace());
    let ran = run(command(folder.path(), arguments), Duration::from_secs(120));
    (ran.json(), Map::read(&folder.path().join("out")))
}

fn keys(object: &Value) -> Vec<&str> {
    let mut keys: Vec<&str> = object
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect();
    keys.sort_unstable();
    keys
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
    document
}

#[test]
fn json_has_exactly_the_keys_of_the_contract() {
    let folder = tempfile::tempdir().unwrap();
    let sonar = workspace().join("host-sim/data/eight-sonar.csv");
    let arguments = ["replay", sonar.to_str().unwrap(), "--json"];
    let ran = run(command(folder.path(), arguments), Duration::from_secs(60));
    assert_eq!(ran.stderr, "");
    let document = ran.json();
    let expected = [
        "cells_updated",
        "echo",
        "files",
        "grid",
        "insert_seconds",
        "missing",
        "no_object",
        "readings",
        "sensors",
        "skipped_lines",
        "too_near",
    ];
    assert_eq!(keys(&document), expected);
    assert_eq!(
        keys(&document["grid"]),
        ["bytes_per_cell", "cell_mm", "height", "width"]
    );
    let expected = [
        "confidence",
        "confirmations",
        "contradictions",
        "id",
        "missing",
        "readings",
        "status",
    ];
    for sensor in document["sensors"].as_array().unwrap() {
        assert_eq!(keys(sensor), expected);
    }
    assert_eq!(
        document["files"],
        serde_json::json!(["out/map.png", "out/map.pgm", "out/map.yaml"])
    );
    for file in ["map.png", "map.pgm", "map.yaml"] {
        assert!(folder.path().join("out").join(file).is_file(), "{file}");
    }
}

/// host-sim/data/README.md: 413 rounds of eight, 1,068 of them without an echo.
#[test]
fn the_shipped_sonars_are_counted_as_their_source_says() {
    let (document, map) = replay_file(&workspace().join("host-sim/data/eight-sonar.csv"), "");
    assert_eq!(document["readings"], 413 * 8);
    assert_eq!(document["no_object"], 1068);
    assert_eq!(document["echo"], 413 * 8 - 1068);
    assert_eq!(
        (&document["missing"], &document["skipped_lines"]),
        (&0.into(), &0.into())
    );
    let sensors = document["sensors"].as_array().unwrap();
    let readings: Vec<_> = sensors
        .iter()
        .map(|sensor| sensor["readings"].as_u64())
        .collect();
    assert_eq!(readings, [Some(413); 8]);
    assert_eq!(document["grid"]["width"], map.width);
    assert_eq!(document["grid"]["height"], map.height);
}

/// The first corridor leads along +x. Its walls scatter by 71 and 37 mm about a line in the
/// readings themselves (host-sim/data/README.md): 95 % within two cells of 100 mm.
#[test]
fn the_side_walls_of_the_sonars_first_corridor_are_straight() {
    let (_, map) = replay_file(&workspace().join("host-sim/data/eight-sonar.csv"), "");
    let occupied = map.places(Cell::Occupied);
    for side in [-1.0, 1.0] {
        // The nearest obstacle to this side of the corridor's middle, column by column.
        let columns: Vec<f64> = (0..85)
            .map(|column| 0.45 + f64::from(column) * 0.1)
            .collect();
        let wall: Vec<[f64; 2]> = columns
            .iter()
            .filter_map(|&x| {
                let here = occupied.iter().filter(|place| (place[0] - x).abs() < 0.051);
                let aside = here.map(|place| place[1] * side).filter(|&y| y > 0.3);
                let nearest = aside.fold(f64::INFINITY, f64::min);
                (nearest < 4.0).then_some([x, nearest])
            })
            .collect();
        let found = wall.len() as f64 / columns.len() as f64;
        assert!(
            found > 0.6,
            "the wall has gaps: {found} on side {side}\n{map}"
        );
        let [slope, offset] = line_through(&wall);
        assert!(slope.abs() < 0.02, "it leads along +x, not {slope}");
        let straight = wall
            .iter()
            .filter(|[x, y]| (y - slope * x - offset).abs() < 0.21);
        let share = straight.count() as f64 / wall.len() as f64;
        assert!(
            share > 0.9,
            "{share} of the wall on side {side} is straight\n{map}"
        );
    }
}

/// The line that half of the slopes and half of the points are above (Theil and Sen).
fn line_through(points: &[[f64; 2]]) -> [f64; 2] {
    let median = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let pairs = points.iter().enumerate().flat_map(|(index, a)| {
        let others = points[index + 1..].iter();
        others.map(move |b| (b[1] - a[1]) / (b[0] - a[0]))
    });
    let slope = median(pairs.collect());
    let offset = median(points.iter().map(|[x, y]| y - slope * x).collect());
    [slope, offset]
}

/// Where the robot drove there is nothing.
fn sonar_path() -> Vec<[f64; 2]> {
    let file = fs::read_to_string(workspace().join("host-sim/data/eight-sonar.csv")).unwrap();
    let beams = file
        .lines()
        .filter(|line| line.starts_with(|c: char| c.is_ascii_digit()));
    beams
        .map(|line| {
            let fields: Vec<&str> = line.split(',').collect();
            [2, 3].map(|field| fields[field].parse::<f64>().unwrap() / 1000.0 + 0.0005)
        })
        .collect()
}

#[test]
fn hardly_anything_stands_where_the_robot_with_the_sonars_drove() {
    let (_, map) = replay_file(&workspace().join("host-sim/data/eight-sonar.csv"), "");
    let path = sonar_path();
    let blocked = path
        .iter()
        .filter(|[x, y]| map.at_place(*x, *y) == Cell::Occupied);
    let share = blocked.count() as f64 / path.len() as f64;
    assert!(share < 0.02, "{share} of the path is blocked\n{map}");
}

/// Half a cell beside the axis is inside the cone, as its documentation says.
#[test]
fn a_cone_frees_what_lies_before_the_sensor_wherever_the_sensor_stands_in_its_cell() {
    for x_mm in [0, 50] {
        // Looks up, and two short echoes that make the map as large as the cone is long.
        let beams = format!(
            "0,1,{x_mm},0,90000,none\n1,1,{x_mm},3000,0,100\n2,1,{},0,180000,100\n",
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

#[test]
fn most_of_where_the_robot_with_the_sonars_drove_is_free() {
    let (_, map) = replay_file(&workspace().join("host-sim/data/eight-sonar.csv"), "");
    let path = sonar_path();
    let free = path
        .iter()
        .filter(|[x, y]| map.at_place(*x, *y) == Cell::Free);
    let share = free.count() as f64 / path.len() as f64;
    assert!(share > 0.9, "{share} of the path is free\n{map}");
}

/// Walls where they are, nothing else anywhere, free inside, unknown outside.
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
        // A beam that grazes a wall may free a cell of it, and the robust grid believes the latest.
        assert!(wall >= 46, "{what}: {wall} of 58 cells of a wall\n{map}");
    }
}

#[test]
fn a_known_room_has_its_walls_where_they_are_by_every_method() {
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
fn robotlaser1_gives_the_map_of_the_same_beams_as_flaser() {
    let newer = log(&square_room(), &tour(), robotlaser);
    assert!(newer.starts_with("ROBOTLASER1 "));
    let (older, older_map) = replay(room_log(), "--json");
    let (newer, newer_map) = replay(newer, "--json");
    assert_square_room(&newer_map, "ROBOTLASER1");
    assert_eq!(untimed(older.json()), untimed(newer.json()));
    assert_eq!(older_map, newer_map);
}

#[test]
fn the_format_can_be_named() {
    let (named, map) = replay(room_log(), "--json --format carmen");
    let (told, same) = replay(room_log(), "--json --format auto");
    assert_eq!(untimed(named.json()), untimed(told.json()));
    assert_eq!(map, same);
}

#[test]
fn readings_at_or_beyond_the_largest_range_are_never_obstacles() {
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
    // Below it they are: the border is where the option says.
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
fn the_cells_are_as_large_as_asked_for() {
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
fn a_stuck_sensor_loses_confidence_and_the_others_keep_the_room() {
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
fn a_silent_sensor_is_missing_and_failed_while_the_others_draw_the_room() {
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

/// A real log: beams by its scans and beams a scan, `no_object` counted in the file at 8 m.
fn real_log(name: &str, readings: u64, no_object: u64) {
    let Some(file) = shared_data(&format!("carmen/{name}-corrected.log.gz")) else {
        return;
    };
    let (document, map) = replay_file(&file, "");
    assert_eq!(document["readings"], readings);
    assert_eq!(document["no_object"], no_object);
    assert_eq!(document["echo"], readings - no_object);
    assert_eq!(document["skipped_lines"], 0);
    assert_eq!(
        (&document["too_near"], &document["missing"]),
        (&0.into(), &0.into())
    );
    assert!(document["cells_updated"].as_u64().unwrap() > readings);
    // A floor plan is mostly lines: far more free cells than walls, and walls there are.
    let (walls, free) = (
        map.places(Cell::Occupied).len(),
        map.places(Cell::Free).len(),
    );
    assert!(
        walls > 500 && free > 5 * walls,
        "{walls} walls, {free} free"
    );
    // A wall's cell has a neighbour that is wall: specks do not.
    let specks = map.places(Cell::Occupied).into_iter().filter(|[x, y]| {
        let around = [-0.1, 0.0, 0.1].map(|dy| [-0.1, 0.0, 0.1].map(|dx| (dx, dy)));
        let near = around
            .as_flattened()
            .iter()
            .filter(|&&aside| aside != (0.0, 0.0));
        let alike = |&(dx, dy): &(f64, f64)| map.at_place(x + dx, y + dy) == Cell::Occupied;
        !near.into_iter().any(alike)
    });
    let share = specks.count() as f64 / walls as f64;
    assert!(share < 0.15, "{share} of the walls are specks");
}

#[test]
fn the_log_of_the_intel_lab_becomes_a_floor_plan() {
    real_log("intel", 163_800, 11_455);
}

#[test]
fn the_log_of_the_fhw_museum_becomes_a_floor_plan() {
    real_log("fhw", 87_840, 17_711);
}

#[test]
fn the_log_of_the_acapulco_convention_center_becomes_a_floor_plan() {
    real_log("acapulco", 155_841, 78_163);
}

#[test]
fn the_log_of_orebro_becomes_a_floor_plan() {
    real_log("orebro", 42_897, 4664);
}

#[test]
fn every_sensor_of_a_real_lab_is_healthy_and_a_silent_one_is_not() {
    let Some(file) = shared_data("carmen/intel-corrected.log.gz") else {
        return;
    };
    let statuses = |options: &str| -> Vec<String> {
        let (document, _) = replay_file(&file, options);
        let sensors = document["sensors"].as_array().unwrap().iter();
        sensors
            .map(|sensor| sensor["status"].as_str().unwrap().to_owned())
            .collect()
    };
    assert_eq!(statuses(""), ["healthy"; 3]);
    let silent = statuses("--fault dropout:2=100%");
    assert_eq!(silent, ["healthy", "failed", "healthy"]);
}
