//! `certainty ring`: \[003\]'s check of a sonar ring.

use crate::support::{certainty, folder_with, shape};
use certainty_ring::{Assessment, Distances, Echoes, Element, Monitor, Polygon, Scan};
use certainty_tests::process::Ran;
use certainty_tests::shared_data;
use serde_json::Value;
use std::fs;

/// Runs the program in a folder of its own.
fn alone(arguments: &str) -> Ran {
    let folder = tempfile::tempdir().unwrap();
    certainty(folder.path(), arguments)
}

fn numbers(value: &Value) -> Vec<u64> {
    let numbers = value.as_array().unwrap().iter();
    numbers.map(|number| number.as_u64().unwrap()).collect()
}

const VECTORS: [&str; 3] = ["intersection_based", "overall", "simulation_based"];

/// The three vectors, of which the third is the sum of the two others.
fn overall(vectors: &Value) -> Vec<u64> {
    assert_eq!(vectors.as_object().unwrap().len(), VECTORS.len());
    let [meeting, overall, simulated] = VECTORS.map(|name| numbers(&vectors[name]));
    assert_eq!(overall.len(), 24);
    for (place, &sum) in overall.iter().enumerate() {
        assert_eq!(sum, meeting[place] + simulated[place]);
        assert!(meeting[place] <= 35 && simulated[place] <= 7);
    }
    overall
}

#[test]
fn a_check_reports_vectors_and_draws_the_figures() {
    let folder = tempfile::tempdir().unwrap();
    let document = certainty(folder.path(), "ring --fault 4 --json").json();
    insta::assert_json_snapshot!("ring", shape(&document));
    let sums = overall(&document["vectors"]);
    let zero: Vec<u64> = (1..)
        .zip(&sums)
        .filter(|(_, sum)| **sum == 0)
        .map(|(n, _)| n)
        .collect();
    assert_eq!(zero, numbers(&document["faulty"]));
    assert_eq!(
        zero,
        [4],
        "sensor 4 is falsified: its value is 0 and every other above"
    );
    let files = document["files"].as_array().unwrap();
    assert_eq!(files.len(), 10, "five pictures, each as PNG and SVG");
    for file in files {
        let bytes = fs::read(folder.path().join(file.as_str().unwrap())).unwrap();
        assert!(bytes.len() > 1000);
    }
    let again = certainty(folder.path(), "ring --fault 4 --json").json();
    assert_eq!(document, again);
}

#[test]
fn a_sweep_counts_found_and_missed_faults() {
    let document = alone("ring --sweep --json --poses 12").json();
    insta::assert_json_snapshot!("ring-sweep", shape(&document));
    let poses = document["vectors"].as_array().unwrap();
    assert_eq!((poses.len(), &document["poses"]), (12, &12.into()));
    let (mut found, mut alarms) = (0, 0);
    for pose in poses {
        let sensor = pose["sensor"].as_u64().unwrap() as usize;
        let with = overall(&pose["with_fault"]);
        assert_eq!(pose["found"], with[sensor - 1] == 0);
        found += u64::from(with[sensor - 1] == 0);
        let without = overall(&pose["without_fault"]);
        alarms += without.iter().filter(|sum| **sum == 0).count();
    }
    assert_eq!(document["faulty_found"], found);
    assert_eq!(document["missed_faults"], 12 - found);
    assert_eq!(document["false_alarms"], alarms);
    let kinds = document["kinds"].as_array().unwrap();
    assert_eq!(kinds.len(), 10, "five kinds, one sonar and two");
    assert_eq!(
        alone("ring --sweep --json --poses 12 --jobs 1").json(),
        document
    );
}

#[test]
fn the_polygons_show_nearly_all_of_the_office() {
    let document = alone("ring --extraction --json --poses 20").json();
    for row in document["rows"].as_array().unwrap() {
        let number = |name: &str| row[name].as_f64().unwrap();
        let what = format!("{row}");
        assert_eq!(row["refused"], 0, "{what}");
        assert!(
            number("segments") > 200.0 && number("corners") > 50.0,
            "{what}"
        );
        if number("noise_mm") <= 5.0 {
            assert!(
                number("segments_found") > 0.9 * number("segments"),
                "{what}"
            );
            assert!(number("corners_found") > 0.9 * number("corners"), "{what}");
        }
        // A vertex is off by no more than what made it a vertex.
        assert!(number("worst_corner_error_mm") <= 200.0, "{what}");
        assert!(number("mean_corner_error_mm") < 40.0, "{what}");
    }
}

#[test]
fn a_damaged_recording_is_assessed_in_part() {
    let row = |metres: &str| [metres; 24].join(",") + ",Move-Forward\n";
    let folder = folder_with(row("1.000") + &row("nan") + "not a row\n" + &row("5.0"));
    let document = certainty(folder.path(), "ring --recording input --lenient --json").json();
    assert_eq!(
        (&document["rows"], &document["skipped"]),
        (&3.into(), &1.into())
    );
    let overlaps = (&document["overlaps_assessed"], &document["overlaps_in_all"]);
    assert_eq!(overlaps, (&6.into(), &35.into()));
    for sensor in document["sensors"].as_array().unwrap() {
        for kind in ["echoes", "no_object", "missing"] {
            assert_eq!(sensor[kind], 1, "{sensor}");
        }
        // Round about, each meets all six neighbours: in one row of three, for no echo is no arc.
        assert_eq!(sensor["confirmed"], 1);
        assert_eq!(sensor["mean_intersections"], 2.0);
    }
    assert_eq!(document["not_assessed"].as_array().unwrap().len(), 3);
}

#[test]
fn a_recordings_header_names_its_columns() {
    let names: Vec<String> = (1..=24)
        .rev()
        .map(|sonar| format!("US{sonar}_cm"))
        .collect();
    let row = "-inf,".to_owned() + &["150"; 23].join(",");
    let folder = folder_with(format!("time,{}\n1,{row}\n", names.join(",")));
    let document = certainty(folder.path(), "ring --recording input --json").json();
    let last = &document["sensors"][23];
    assert_eq!((&last["too_near"], &last["echoes"]), (&1.into(), &0.into()));
    assert_eq!(document["sensors"][0]["echoes"], 1);
    let note = "columns that are not used: time";
    assert_eq!(document["notes"], serde_json::json!([note]));
    let text = certainty(folder.path(), "ring --recording input").stdout;
    assert!(text.contains(note) && text.contains("too near"), "{text}");
}

#[test]
fn a_recording_counts_one_line_in_the_singular() {
    let row = "1.000,".repeat(23) + "1.000\n";
    for (content, counted) in [
        (row.clone() + "no row\n", "input: 1 row, 1 line skipped; "),
        (row.repeat(2), "input: 2 rows, 0 lines skipped; "),
    ] {
        let folder = folder_with(content);
        let text = certainty(folder.path(), "ring --recording input --lenient").stdout;
        assert!(text.starts_with(counted), "{text}");
    }
}

#[test]
fn a_worlds_name_is_escaped() {
    let wall = |from: &str, to: &str| format!("[[wall]]\nfrom = [{from}]\nto = [{to}]\n");
    let corners = [
        "\"0m\", \"0m\"",
        "\"4m\", \"0m\"",
        "\"4m\", \"3m\"",
        "\"0m\", \"3m\"",
    ];
    let walls = (0..4).map(|n| wall(corners[n], corners[(n + 1) % 4]));
    let folder =
        folder_with("name = \"a\\u001b[31mroom\"\n".to_owned() + &walls.collect::<String>());
    for command in [
        "--pose 2m,1.5m,0deg",
        "--sweep --poses 1",
        "--extraction --poses 1",
    ] {
        let ran = certainty(folder.path(), &format!("ring --world input {command}"));
        assert!(
            ran.stdout.starts_with("world: a\\u{1b}[31mroom "),
            "{ran:?}"
        );
    }
}

/// The fault of an example had no effect, and nothing said so.
#[test]
fn a_fault_without_effect_is_named() {
    let document = alone("ring --json --fault blind:4 --fault 9").json();
    assert_eq!(document["without_effect"], serde_json::json!(["blind:4"]));
    let text = alone("ring --fault blind:4").stdout;
    let line = "blind:4 changes no distance at this pose: it cannot be found here\n";
    assert!(text.contains(line), "{text}");
}

/// A sweep had the default value of every kind, whatever --fault had.
#[test]
fn a_sweep_has_the_value_of_its_fault() {
    let rows = |fault: &str| {
        let arguments = format!("ring --sweep --poses 8 --json --fault {fault}");
        alone(&arguments).json()["kinds"].clone()
    };
    // 20 mm is below the threshold of 100 mm, so no path differs.
    let slight = rows("falsified:4=20mm");
    assert_eq!(slight[0]["without_effect"], slight[0]["faults"]);
    assert_eq!(rows("falsified:4=500mm")[0]["without_effect"], 0);
}

/// Walls of a polygon that are on no surface were not counted.
#[test]
fn extraction_counts_the_walls_that_do_not_exist() {
    let document = alone("ring --extraction --poses 4 --json").json();
    let row = &document["rows"][0];
    let (walls, phantoms) = (row["walls"].as_u64(), row["phantom_walls"].as_u64());
    assert!(phantoms.unwrap() > 0 && phantoms < walls, "{row}");
}

#[test]
fn the_number_of_threads_changes_no_polygon() {
    let extraction = |jobs: u8| {
        let arguments = format!("ring --extraction --json --poses 3 --jobs {jobs}");
        alone(&arguments).json()
    };
    assert_eq!(extraction(1), extraction(3));
}

#[test]
fn the_real_ring_is_assessed() {
    let Some(file) = shared_data("ring24/sensor_readings_24.csv") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let arguments = format!("ring --json --recording {}", file.display());
    let document = certainty(folder.path(), &arguments).json();
    assert_eq!(
        (&document["rows"], &document["skipped"]),
        (&5456.into(), &0.into())
    );
    // Counted with awk in the file: sonar 1 has 5 m or more 67 times, sonar 10 1065 times.
    assert_eq!(document["sensors"][0]["no_object"], 67);
    assert_eq!(document["sensors"][9]["no_object"], 1065);
    // The longest run of equal echoes is sonar 19's, lines 3149 to 3169 (counted likewise).
    let longest = &document["sensors"][18]["longest_equal"];
    assert_eq!(
        (&longest["rows"], &longest["from_line"]),
        (&21.into(), &3149.into())
    );
    assert_eq!(longest["reading_mm"], 350);
}

#[test]
fn bad_input_is_refused_in_one_line() {
    let folder = folder_with("metres\n");
    for (arguments, part) in [
        ("ring --fault 25", "unknown sonar '25'"),
        ("ring --fault deaf:4", "unknown fault 'deaf'"),
        ("ring --pose 1,2,3", "has no unit"),
        ("ring --pose 1m,2m", "a part is missing"),
        ("ring --pose 350mm,3m,0deg", "within the ring"),
        ("ring --world input", "input:1"),
        ("ring --recording input", "input:1: 'metres' in column 1"),
        ("ring --recording nowhere", "nowhere: cannot be opened"),
        ("ring --recording input --sweep", "cannot be used with"),
        ("ring --recording input --range 9m", "range must be from"),
        ("ring --sweep --poses 0", "0"),
        ("ring --poses 5", "<--sweep|--extraction>"),
        ("ring --jobs 2", "<--sweep|--extraction>"),
        ("ring --recording input --poses 5", "<--sweep|--extraction>"),
        ("ring --range 4m", "--recording <FILE>"),
        ("ring --lenient", "--recording <FILE>"),
        ("ring --extraction --fault 4", "cannot be used with"),
        (
            "ring --pose 9m,9m,0deg",
            "--pose: 9000mm,9000mm is outside the room: expected a position from -100mm,-100mm to",
        ),
    ] {
        let ran = certainty(folder.path(), arguments);
        let line = ran.refusal();
        assert!(line.contains(part), "{arguments}: {line}");
    }
}

/// The sizes in the documentation of `certainty_ring`.
#[test]
fn a_ring_fits_a_small_microcontroller() {
    assert_eq!(size_of::<Element>(), 32, "Memory: 32 bytes");
    assert!(
        size_of::<Scan<722>>() <= 4 * 722 + 16,
        "4 bytes a beam and 12"
    );
    assert!(size_of::<Polygon<64>>() <= 32 * 64 + 8);
    assert_eq!(size_of::<Echoes<24>>(), 14 * 24);
    assert_eq!(size_of::<Distances<24>>(), 8 * 24);
    assert_eq!(size_of::<Assessment<24>>(), 3 * 24);
    let all = size_of::<Scan<722>>()
        + size_of::<Polygon<64>>()
        + size_of::<Echoes<24>>()
        + 2 * size_of::<Distances<24>>()
        + size_of::<Monitor<24>>()
        + size_of::<Assessment<24>>();
    // A part of 20 KB keeps two thirds for everything else.
    assert!(all <= 5900, "{all} bytes");
}
