//! Maps for other programs: the written files by the rules of `map_server`, and `compare`.

use crate::support::{
    Cell, Map, Place, Room, all_around, certainty, command, flaser, log, write_drawn,
};
use certainty_tests::pgm::pgm;
use certainty_tests::process::{PATIENCE, Ran, run};
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

/// `map_server`, trinary mode: darkness (255 - pixel) / 255 is free up to `free_thresh`, occupied from
/// `occupied_thresh` on, else unknown. Its own writer has the pixels 0, 254 and 205 for these.
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
        "notes": [],
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
        "notes": [],
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
    write_drawn(folder.path(), "far", &A, 0.1, [100.0, 0.0]);
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

/// Compares the drawn map [`A`] with a map of these files; returns the run.
fn compare_with(yaml: &str, image_name: &str, image: &[u8]) -> Ran {
    let folder = tempfile::tempdir().unwrap();
    write_drawn(folder.path(), "a", &A, 0.1, [-1.0, 2.0]);
    fs::write(folder.path().join("b.yaml"), yaml).unwrap();
    fs::write(folder.path().join(image_name), image).unwrap();
    certainty(folder.path(), "compare a.yaml b.yaml --json")
}

/// The pixels of [`A`] by a value for each of `#`, `.` and `?`.
fn pixels_of_a(occupied: &[u8], free: &[u8], unknown: &[u8]) -> Vec<u8> {
    let cells = A.concat();
    let pixels = cells.bytes().map(|cell| match cell {
        b'#' => occupied,
        b'.' => free,
        _ => unknown,
    });
    pixels.collect::<Vec<_>>().concat()
}

const USUAL: &str = "image: b.pgm\nresolution: 0.1\norigin: [-1.0, 2.0, 0.0]\nnegate: 0\n\
                     occupied_thresh: 0.65\nfree_thresh: 0.196\n";

/// Each YAML describes the map A, though it is written otherwise than `map_saver` does; and what its
/// notes name.
#[test]
fn yaml_of_other_writers_is_read() {
    let image = [&b"P5 5 4 255\n"[..], &pixels_of_a(&[0], &[254], &[205])].concat();
    let changed = |from: &str, to: &str| USUAL.replace(from, to);
    for (yaml, noted) in [
        (changed("negate: 0", "negate: False"), None),
        (changed("negate: 0", "negate: No"), None),
        (changed("negate: 0", "mode: Trinary\nnegate: off"), None),
        (changed("0.0]", "0.0000001]"), None),
        (changed("0.0]", "6.2831853]"), None),
        (changed("0.65", "1.0"), None),
        (
            changed("free_thresh: 0.196\n", ""),
            Some("`free_thresh: 0.196`"),
        ),
        (
            changed(
                "occupied_thresh: 0.65\nfree_thresh: 0.196\n",
                "occupied_thresh: 0.1\n",
            ),
            Some("is not below occupied_thresh 0.1"),
        ),
        (
            changed("0.65", "0.5").replace("0.196", "0.5"),
            Some("2 pixels of 205"),
        ),
        (changed("negate: 0\n", ""), Some("`negate: 0`")),
        (format!("{USUAL}trinary: false\n"), Some("`mode: scale`")),
        (format!("{USUAL}width: 5\n"), Some("not read: `width`")),
    ] {
        let document = compare_with(&yaml, "b.pgm", &image).json();
        assert_eq!(document["agreement"], 1.0, "{yaml}");
        assert_eq!(
            (&document["only_a"], &document["only_b"]),
            (&json!(0), &json!(0)),
            "{yaml}"
        );
        let notes = document["notes"].as_array().unwrap();
        match noted {
            Some(text) => {
                let found = notes.iter().filter_map(Value::as_str);
                let found =
                    found.filter(|note| note.starts_with("b.yaml: ") && note.contains(text));
                assert_eq!(found.count(), 1, "{notes:?}");
            }
            None => assert!(notes.is_empty(), "{notes:?}"),
        }
    }
}

#[test]
fn images_of_other_writers_are_read() {
    let plain = pixels_of_a(b"0 ", b"254 ", b"205 ");
    let pam = "P7\nWIDTH 5\nHEIGHT 4\nDEPTH 2\nMAXVAL 255\nTUPLTYPE GRAYSCALE_ALPHA\nENDHDR\n";
    for image in [
        [&b"P2 5 4 255\n"[..], &plain].concat(),
        [
            &b"P5 5 4 65535\n"[..],
            &pixels_of_a(&[0, 0], &[254, 254], &[205, 205]),
        ]
        .concat(),
        [&b"P5 5 4 254\n"[..], &pixels_of_a(&[0], &[254], &[205])].concat(),
        [
            &b"P6 5 4 255\n"[..],
            &pixels_of_a(&[0; 3], &[254; 3], &[205; 3]),
        ]
        .concat(),
        // White, but transparent.
        [
            pam.as_bytes(),
            &pixels_of_a(&[0, 255], &[255, 255], &[255, 0]),
        ]
        .concat(),
        [&b"P5 5 4 255\n"[..], &pixels_of_a(&[0], &[255], &[128])].concat(),
        [
            &b"P5 5 4 255\n"[..],
            &pixels_of_a(&[0], &[254], &[205]),
            b"more",
        ]
        .concat(),
    ] {
        let document = compare_with(USUAL, "b.pgm", &image).json();
        let head = String::from_utf8_lossy(&image[..12]).into_owned();
        assert_eq!(document["agreement"], 1.0, "{head}");
        assert_eq!(
            (&document["only_a"], &document["only_b"]),
            (&json!(0), &json!(0)),
            "{head}"
        );
        // 205 of 254 would be free by the thresholds.
        let noted = image.ends_with(b"more") || image.starts_with(b"P5 5 4 254");
        assert_eq!(
            document["notes"].as_array().unwrap().len(),
            usize::from(noted),
            "{head}"
        );
    }
}

#[test]
fn a_turned_map_is_placed() {
    // A, turned by half a turn, from its upper right corner.
    let mut pixels = pixels_of_a(&[0], &[254], &[205]);
    pixels.reverse();
    let image = [&b"P5 5 4 255\n"[..], &pixels].concat();
    let yaml = USUAL.replace("[-1.0, 2.0, 0.0]", "[-0.5, 2.4, 3.14159265]");
    let document = compare_with(&yaml, "b.pgm", &image).json();
    assert_eq!(
        (&document["overlap"], &document["agreement"]),
        (&json!(20), &json!(1.0))
    );
    assert_eq!(document["misaligned"], true);
    let notes = document["notes"].as_array().unwrap();
    assert!(
        notes[0]
            .as_str()
            .unwrap()
            .contains("turned by 180.00 degrees"),
        "{notes:?}"
    );
}

#[test]
fn maps_of_unlike_cells_are_compared_on_the_coarser() {
    let folder = tempfile::tempdir().unwrap();
    write_drawn(folder.path(), "a", &A, 0.1, [-1.0, 2.0]);
    let fine: Vec<String> = A
        .iter()
        .flat_map(|row| {
            let wide: String = row.chars().flat_map(|cell| [cell; 2]).collect();
            [wide.clone(), wide]
        })
        .collect();
    let fine: Vec<&str> = fine.iter().map(String::as_str).collect();
    write_drawn(folder.path(), "fine", &fine, 0.05, [-1.0, 2.0]);
    for (maps, finer) in [("a.yaml fine.yaml", "B"), ("fine.yaml a.yaml", "A")] {
        let document = certainty(folder.path(), &format!("compare {maps} --json")).json();
        assert_eq!(
            (&document["overlap"], &document["known_in_both"]),
            (&json!(20), &json!(18))
        );
        assert_eq!(
            (&document["agreement"], &document["misaligned"]),
            (&json!(1.0), &json!(false))
        );
        let text = certainty(folder.path(), &format!("compare {maps}")).stdout;
        let expected = format!("{finer} was resampled from 0.05 to 0.1 m\n");
        assert!(text.ends_with(&expected), "{text}");
    }
}

/// An index was computed for places outside the map, too, and overflowed.
#[test]
fn maps_that_are_worlds_apart_do_not_overflow() {
    for b in [
        "resolution: 0.1\norigin: [0, -1e17, 0]",
        "resolution: 1e-300\norigin: [0, 0, 0]",
        "resolution: 1e300\norigin: [0, 0, 0]",
    ] {
        let yaml =
            format!("image: b.pgm\n{b}\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n");
        let ran = compare_with(&yaml, "b.pgm", b"P5\n2 2\n255\n\x00\xFE\xCD\x00");
        assert!(matches!(ran.code, Some(0 | 2)), "{b}: {ran:?}");
    }
}

#[test]
fn a_yaml_from_stdin_names_images_here() {
    let folder = tempfile::tempdir().unwrap();
    write_drawn(folder.path(), "a", &A, 0.1, [-1.0, 2.0]);
    let mut program = command(folder.path(), ["compare", "-", "a.yaml", "--json"]);
    program.stdin(fs::File::open(folder.path().join("a.yaml")).unwrap());
    assert_eq!(run(program, PATIENCE).json()["agreement"], 1.0);
    let ran = certainty(folder.path(), "compare - -");
    assert!(ran.refusal().contains("stdin holds one YAML"), "{ran:?}");
    let ran = certainty(folder.path(), "compare - a.yaml");
    assert!(ran.refusal().starts_with("certainty: stdin:1: "), "{ran:?}");
}

#[test]
fn what_is_no_map_is_named_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    write_drawn(folder.path(), "a", &A, 0.1, [-1.0, 2.0]);
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
    let named = |image: &str| format!("image: {image}\nresolution: 0.1\norigin: [0, 0, 0]\n");
    write("nav2.yaml", b"amcl:\n  ros__parameters:\n    alpha1: 0.2\n");
    write("none.yaml", named("b.pgm").as_bytes());
    write("huge.yaml", named("huge.pgm").as_bytes());
    write("huge.pgm", b"P5 99999 99999 255\n");
    write("zero.yaml", named("zero.pgm").as_bytes());
    write("zero.pgm", b"P5 0 0 255\n");
    write("self.yaml", named("self.yaml").as_bytes());
    write("cut.yaml", named("cut.pgm").as_bytes());
    write("cut.pgm", b"P5 5 4 255\n123");
    for (file, expected) in [
        (
            "a.pgm",
            "a.pgm: is an image; give the .yaml that names it and has its resolution and origin, a.yaml",
        ),
        ("nav2.yaml", "nav2.yaml:1: is YAML of something else"),
        ("none.yaml", "b.pgm: cannot be read"),
        (
            "huge.yaml",
            "huge.pgm: is of 99999 x 99999 pixels, more than a map may have",
        ),
        ("zero.yaml", "zero.pgm: has no pixels"),
        (
            "self.yaml",
            "self.yaml: is not PGM, PPM, PBM, PNG, BMP, JPEG or GIF",
        ),
        (
            "cut.yaml",
            "cut.pgm: announces 5 x 4 pixels but does not hold them",
        ),
    ] {
        let ran = certainty(folder.path(), &format!("compare {file} a.yaml --json"));
        let line = ran.refusal();
        assert!(line.contains(expected), "{file}: {line}");
    }
}

/// Locks `folder` as a run with `--out` does.
fn hold(folder: &Path) -> fs::File {
    let file = fs::File::create(folder.join(".certainty.lock")).unwrap();
    file.try_lock().unwrap();
    file
}

#[test]
fn a_second_run_into_a_folder_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let place = all_around(0.0, 0.0)[0];
    let recording = log(&Room::new(&CORNERS), &[place], flaser);
    fs::write(folder.path().join("l.log"), recording).unwrap();
    let out = folder.path().join("out");
    fs::create_dir(&out).unwrap();
    let held = hold(&out);
    for arguments in [
        "replay l.log",
        "simulate",
        "calibrate",
        "drive",
        "ring",
        "recovery",
    ] {
        let ran = certainty(folder.path(), arguments);
        let line = ran.refusal();
        assert!(
            line.contains("out: another run writes its files there"),
            "{line}"
        );
    }
    drop(held);
    assert_eq!(certainty(folder.path(), "replay l.log").code, Some(0));
    assert!(!out.join(".certainty.lock").exists());
}

#[test]
fn a_set_of_files_is_written_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let place = all_around(0.0, 0.0)[0];
    let recording = log(&Room::new(&CORNERS), &[place], flaser);
    fs::write(folder.path().join("l.log"), recording).unwrap();
    let out = folder.path().join("out");
    fs::create_dir_all(out.join("map.yaml")).unwrap();
    fs::write(out.join("map.pgm"), "old").unwrap();
    let ran = certainty(folder.path(), "replay l.log");
    let line = ran.refusal();
    assert!(
        line.contains("out/map.yaml: is a directory where a file is to be written"),
        "{line}"
    );
    assert_eq!(fs::read(out.join("map.pgm")).unwrap(), b"old");
    assert_eq!(fs::read_dir(&out).unwrap().count(), 2);
}
