//! Maps of real recordings: of eight sonars, which are part of the project, and of lasers.

use crate::support::{Cell, replay_file};
use certainty_tests::{shared_data, workspace};
use std::fs;

/// host-sim/data/README.md: 413 rounds of eight, 1,068 of them without an echo.
#[test]
fn the_shipped_sonars_have_their_sources_counts() {
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
fn the_sonar_robots_first_corridor_is_straight() {
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
fn few_cells_on_the_sonar_robots_path_are_occupied() {
    let (_, map) = replay_file(&workspace().join("host-sim/data/eight-sonar.csv"), "");
    let path = sonar_path();
    let blocked = path
        .iter()
        .filter(|[x, y]| map.at_place(*x, *y) == Cell::Occupied);
    let share = blocked.count() as f64 / path.len() as f64;
    assert!(share < 0.02, "{share} of the path is blocked\n{map}");
}

#[test]
fn most_cells_on_the_sonar_robots_path_are_free() {
    let (_, map) = replay_file(&workspace().join("host-sim/data/eight-sonar.csv"), "");
    let path = sonar_path();
    let free = path
        .iter()
        .filter(|[x, y]| map.at_place(*x, *y) == Cell::Free);
    let share = free.count() as f64 / path.len() as f64;
    assert!(share > 0.9, "{share} of the path is free\n{map}");
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
fn the_intel_lab_log_becomes_a_floor_plan() {
    real_log("intel", 163_800, 11_455);
}

#[test]
fn the_fhw_museum_log_becomes_a_floor_plan() {
    real_log("fhw", 87_840, 17_711);
}

#[test]
fn the_acapulco_log_becomes_a_floor_plan() {
    real_log("acapulco", 155_841, 78_163);
}

#[test]
fn the_orebro_log_becomes_a_floor_plan() {
    real_log("orebro", 42_897, 4664);
}

#[test]
fn a_real_labs_sensors_are_healthy_but_a_silent_one() {
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
