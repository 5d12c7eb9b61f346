//! Maps for other programs: the written files by the rules of `map_server`, and `compare`.

use crate::support::{Cell, Map, Place, Room, all_around, certainty, flaser, log, write_drawn};
use certainty_tests::pgm::pgm;
use certainty_tests::process::Ran;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// A room that no mirror and no turn maps on itself: an L with a long and a short arm.
const CORNERS: [[f64; 2]; 6] = [
    [-1.03, -2.04],
    [4.96, -2.04],
    [4.96, 0.05],
    [1.04, 0.05],
    [1.04, 3.06],
    [-1.03, 3.06],
];

/// Replays the L-shaped room into `folder`/out.
fn map_of_the_l(folder: &Path, options: &str) -> Map {
    let stops = [(-0.02, -1.03), (2.03, -1.01), (4.02, -0.98), (0.03, 1.98)];
    let places: Vec<Place> = stops.iter().flat_map(|&(x, y)| all_around(x, y)).collect();
    let recording = log(&Room::new(&CORNERS), &places, flaser);
    fs::write(folder.join("l.log"), recording).unwrap();
    let ran = certainty(folder, &format!("replay l.log {options}"));
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    Map::read(&folder.join("out"))
}

/// `map_server`, trinary mode: darkness (255 - pixel) / 255 is occupied above `occupied_thresh`, free below
/// `free_thresh`, else unknown. Its own writer has the pixels 0, 254 and 205 for these.
#[test]
fn a_map_has_the_pixels_of_map_server() {
    for (options, resolution) in [
        ("", "0.1"),
        ("--cell 50mm --fusion median", "0.05"),
        ("--cell 25cm --fusion bayes", "0.25"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let map = map_of_the_l(folder.path(), options);
        let yaml = fs::read_to_string(folder.path().join("out/map.yaml")).unwrap();
        for line in [
            "image: map.pgm".to_owned(),
            format!("resolution: {resolution}"),
            "negate: 0".to_owned(),
            "occupied_thresh: 0.65".to_owned(),
            "free_thresh: 0.196".to_owned(),
        ] {
            assert!(
                yaml.lines().any(|found| found == line),
                "no {line} in {yaml}"
            );
        }
        let image = fs::read(folder.path().join("out/map.pgm")).unwrap();
        let (width, height, pixels) = pgm(&image);
        assert_eq!((width, height), (map.width, map.height));
        for (pixel, state) in [(0, Cell::Occupied), (205, Cell::Unknown), (254, Cell::Free)] {
            let of_state = |&&found: &&u8| found == pixel;
            let count = pixels.iter().filter(of_state).count();
            assert_eq!(count, map.places(state).len(), "{pixel} with {options}");
            assert!(count > 20, "every state occurs: {count} of {pixel}");
        }
    }
}

/// The walls of the room are at their places in the map: not mirrored, not turned.
#[test]
fn walls_and_space_are_at_their_places() {
    let folder = tempfile::tempdir().unwrap();
    let map = map_of_the_l(folder.path(), "--fusion bayes");
    let walls = [
        (-1.03, 1.55, "left"),
        (-1.03, -0.95, "left"),
        (4.96, -1.05, "right end of the long arm"),
        (1.55, -2.04, "below"),
        (3.05, 0.05, "above the long arm"),
        (1.04, 2.05, "right of the short arm"),
        (0.05, 3.06, "upper end of the short arm"),
    ];
    for (x, y, name) in walls {
        assert_eq!(map.at_place(x, y), Cell::Occupied, "{name} at {x}, {y}");
    }
    for (x, y) in [
        (0.0, 0.0),
        (0.0, 2.5),
        (-0.5, -1.5),
        (4.5, -1.0),
        (3.0, -0.5),
    ] {
        assert_eq!(map.at_place(x, y), Cell::Free, "inside at {x}, {y}");
    }
    // Outside an L, and inside its mirror images.
    for (x, y) in [(3.0, 1.5), (4.5, 2.5), (2.0, 1.0)] {
        assert_eq!(map.at_place(x, y), Cell::Unknown, "outside at {x}, {y}");
    }
}

/// Runs `certainty compare` on two drawn maps, the second of them somewhere else.
fn compare(a: &[&str], b: &[&str], b_origin: [f64; 2]) -> Ran {
    let folder = tempfile::tempdir().unwrap();
    write_drawn(folder.path(), "a", a, 0.1, [-1.0, 2.0]);
    write_drawn(folder.path(), "b", b, 0.1, b_origin);
    certainty(folder.path(), "compare a.yaml b.yaml --json")
}

const A: [&str; 4] = ["####?", "#..#?", "#..##", "####."];

#[test]
fn a_map_agrees_fully_with_itself() {
    let folder = tempfile::tempdir().unwrap();
    let map = map_of_the_l(folder.path(), "");
    let known = map.places(Cell::Free).len() + map.places(Cell::Occupied).len();
    let ran = certainty(folder.path(), "compare out/map.yaml out/map.yaml --json");
    let expected = json!({
        "overlap": map.width * map.height,
        "known_in_both": known,
        "agreeing": known,
        "agreement": 1.0,
        "missed": 0,
        "missed_fraction": 0.0,
        "ghost": 0,
        "ghost_fraction": 0.0,
        "only_a": 0,
        "only_b": 0,
        "misaligned": false,
    });
    assert_eq!(ran.json(), expected);
}

/// Worked out by hand: of 18 known cells of A two are changed and one is forgotten.
#[test]
fn an_edited_map_is_counted_cell_by_cell() {
    let b = [
        "###.#", // an obstacle became free: missed; unknown became known: only in B
        "#.##?", // free became occupied: ghost
        "#..##", //
        "?###.", // an obstacle became unknown: missed too, and only in A
    ];
    let document = compare(&A, &b, [-1.0, 2.0]).json();
    assert_eq!(document["overlap"], 20);
    assert_eq!(document["known_in_both"], 17);
    assert_eq!(document["agreeing"], 15);
    // The parser of this document may be off by the last bit.
    let fraction = |key: &str, expected: f64| {
        let found = document[key].as_f64().unwrap();
        assert!((found - expected).abs() < 1e-12, "{key}: {found}");
    };
    fraction("agreement", 15.0 / 17.0);
    assert_eq!(
        (&document["missed"], &document["ghost"]),
        (&json!(2), &json!(1))
    );
    // A has 13 obstacles and 5 free cells.
    fraction("missed_fraction", 2.0 / 13.0);
    fraction("ghost_fraction", 1.0 / 5.0);
    assert_eq!(
        (&document["only_a"], &document["only_b"]),
        (&json!(1), &json!(1))
    );
    assert_eq!(document["misaligned"], false);
}

/// B is A one cell to the right: A's column x lies on B's column x − 1, one column has no partner.
#[test]
fn a_shifted_map_is_compared_in_the_overlap() {
    let document = compare(&A, &A, [-0.9, 2.0]).json();
    // Over each other lie, the highest row first (A's columns 1 to 4 over B's 0 to 3):
    //   ###?   #..?   ..## is of the third row, and ###. of the lowest; B: ####, #..#, #..#, ####
    //   row 4: ###? / ####: three agree
    //   row 3: ..#? / #..#: a ghost, one agrees, a miss
    //   row 2: ..## / #..#: a ghost, one agrees, a miss, one agrees
    //   row 1: ###. / ####: three agree, a ghost
    let expected = json!({
        "overlap": 16,
        "known_in_both": 3 + 3 + 4 + 4,
        "agreeing": 3 + 1 + 2 + 3,
        "agreement": 9.0 / 14.0,
        "missed": 2,
        "missed_fraction": 2.0 / 9.0,
        "ghost": 3,
        "ghost_fraction": 3.0 / 5.0,
        "only_a": 4,
        "only_b": 4,
        "misaligned": false,
    });
    assert_eq!(document, expected);
}

#[test]
fn misaligned_maps_are_compared_and_marked() {
    let document = compare(&A, &A, [-0.96, 2.0]).json();
    assert_eq!(document["misaligned"], true);
    assert_eq!(document["agreement"], 1.0, "the nearest cells are the same");
}

#[test]
fn maps_without_common_known_cells_have_no_fractions() {
    let document = compare(&["?#"], &["??"], [-1.0, 2.0]).json();
    assert_eq!(document["agreement"], Value::Null);
    assert_eq!(document["ghost_fraction"], Value::Null);
    assert_eq!(document["missed_fraction"], 1.0);
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    write_drawn(folder.path(), "a", &A, 0.1, [0.0, 0.0]);
    write_drawn(folder.path(), "fine", &A, 0.05, [0.0, 0.0]);
    write_drawn(folder.path(), "far", &A, 0.1, [100.0, 0.0]);
    let line = certainty(folder.path(), "compare a.yaml fine.yaml --json");
    let line = line.refusal();
    for word in ["a.yaml", "fine.yaml", "0.1 m", "0.05 m", "resolution"] {
        assert!(line.contains(word), "no {word} in {line}");
    }
    let line = certainty(folder.path(), "compare a.yaml far.yaml");
    assert!(line.refusal().contains("no cell in common"), "{line:?}");
}

#[test]
fn the_text_has_the_figures_of_the_document() {
    let folder = tempfile::tempdir().unwrap();
    write_drawn(folder.path(), "a", &A, 0.1, [-1.0, 2.0]);
    write_drawn(folder.path(), "b", &A, 0.1, [-0.9, 2.0]);
    let ran = certainty(folder.path(), "compare a.yaml b.yaml");
    assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""));
    let row = |name: &str| {
        let found = ran.stdout.lines().find(|line| line.starts_with(name));
        let words: Vec<&str> = found.unwrap().split_whitespace().collect();
        words[words.len() - 3..].join(" ")
    };
    assert_eq!(row("agreeing"), "9 64.3 %");
    assert_eq!(row("missed"), "2 22.2 %");
    assert_eq!(row("ghost"), "3 60.0 %");
    assert!(ran.stdout.lines().all(|line| line.chars().count() <= 80));
}

#[test]
fn a_rewritten_map_compares_equal() {
    let folder = tempfile::tempdir().unwrap();
    let map = map_of_the_l(folder.path(), "");
    let drawing = map.to_string();
    let rows: Vec<&str> = drawing.lines().collect();
    write_drawn(folder.path(), "again", &rows, map.resolution, map.origin);
    let ran = certainty(folder.path(), "compare out/map.yaml again.yaml --json");
    let document = ran.json();
    assert_eq!(document["agreement"], 1.0);
    assert_eq!(
        (&document["only_a"], &document["only_b"]),
        (&json!(0), &json!(0))
    );
}
