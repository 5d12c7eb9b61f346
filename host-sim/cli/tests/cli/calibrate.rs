//! `certainty calibrate`: what it reports, what it draws, and what it refuses.

use crate::support::{QUICKLY, certainty_quickly, command, folder_with, shape};
use certainty_tests::process::run;
use core::fmt::Write;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// A recording of a unit whose characteristic is known: a 13 000, b 10 mm, c 60.
fn recording() -> String {
    let mut table = "distance_mm,raw\n".to_owned();
    for mm in (80..=900_u32).step_by(20) {
        let raw = 13_000.0 / (f64::from(mm) + 10.0) + 60.0;
        for _ in 0..3 {
            writeln!(table, "{mm},{}", raw.round()).unwrap();
        }
    }
    table
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten();
    let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name();
    let mut names: Vec<_> = entries.map(|e| name(e).into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn json_has_the_shape_of_its_snapshot() {
    let folder = folder_with(recording());
    for (name, arguments, file, units) in [
        ("calibrate", "calibrate --json", Value::Null, 16),
        (
            "calibrate-file",
            "calibrate input --json",
            "input".into(),
            1,
        ),
    ] {
        let document = certainty_quickly(folder.path(), arguments).json();
        insta::assert_json_snapshot!(name, shape(&document));
        assert_eq!(document["file"], file);
        assert_eq!(
            (&document["nearest_mm"], &document["farthest_mm"]),
            (&100.into(), &800.into())
        );
        let all = document["units"].as_array().unwrap();
        assert_eq!(all.len(), units);
        for unit in all {
            for spread in ["error_mm", "error_percent"] {
                let [mean, worst] =
                    ["mean", "worst"].map(|key| unit[spread][key].as_f64().unwrap());
                assert!(mean.abs() <= worst, "{unit}");
            }
            assert!(unit["rms_counts"].as_f64() <= unit["worst_counts"].as_f64());
        }
        let files: Vec<_> = document["files"].as_array().unwrap().iter().collect();
        for file in &files {
            let content = fs::read(folder.path().join(file.as_str().unwrap())).unwrap();
            assert!(
                content.starts_with(b"\x89PNG") || content.starts_with(b"<svg "),
                "{file}"
            );
        }
        assert_eq!(files.len(), names(&folder.path().join("out")).len());
    }
}

#[test]
fn a_recordings_parameters_are_fitted() {
    let folder = folder_with(recording());
    let document = certainty_quickly(folder.path(), "calibrate input --json").json();
    let unit = &document["units"][0];
    assert_eq!(unit["name"], "raw");
    // 100 to 800 mm in steps of 20, three readings each; 80, 820 to 900 lie outside.
    assert_eq!(
        (&unit["points"], &unit["ignored"]),
        (&108.into(), &18.into())
    );
    let number = |key: &str| unit[key].as_f64().unwrap();
    // Bytes are rounded, which moves the fit by a few hundredths.
    assert!((number("a") / 13_000.0 - 1.0).abs() < 0.05, "{unit}");
    assert!((number("c") - 60.0).abs() < 1.0, "{unit}");
    assert!((0.05..0.5).contains(&number("rms_counts")), "{unit}");
    let worst = unit["error_mm"]["worst"].as_f64().unwrap();
    // Half a count at 800 mm is 25 mm.
    assert!((1.0..40.0).contains(&worst), "{unit}");

    let nearer = "calibrate input --json --nearest 8cm --farthest 0.4m";
    let document = certainty_quickly(folder.path(), nearer).json();
    assert_eq!(
        (&document["nearest_mm"], &document["farthest_mm"]),
        (&80.into(), &400.into())
    );
    assert_eq!(document["units"][0]["points"], 51);
}

/// \[001\] Fig. 6 and Table 1: units differ, and none of the real ones errs by more than 12 %.
#[test]
fn the_sixteen_real_units_err_as_the_papers_do() {
    let folder = tempfile::tempdir().unwrap();
    let document = certainty_quickly(folder.path(), "calibrate --json").json();
    let units = document["units"].as_array().unwrap().iter();
    let sd: Vec<f64> = units
        .map(|unit| unit["error_percent"]["sd"].as_f64().unwrap())
        .collect();
    let least = sd.iter().copied().fold(f64::INFINITY, f64::min);
    let most = sd.iter().copied().fold(0.0, f64::max);
    assert!((0.8..1.0).contains(&least), "{least}");
    assert!((3.0..3.5).contains(&most), "{most}");
}

#[test]
fn the_text_has_a_row_for_each_unit() {
    let folder = tempfile::tempdir().unwrap();
    let ran = certainty_quickly(folder.path(), "calibrate --out charts");
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let rows = ran.stdout.lines().filter(|line| line.starts_with('A'));
    assert_eq!(rows.count(), 16);
    let expected = [
        "calibrate-errors.png",
        "calibrate-errors.svg",
        "calibrate-over-distance.png",
        "calibrate-over-distance.svg",
    ];
    assert_eq!(names(&folder.path().join("charts")), expected);
    let svg = folder.path().join("charts/calibrate-errors.svg");
    let svg = fs::read_to_string(svg).unwrap();
    assert_eq!(
        svg.matches("σ = ").count(),
        3,
        "three units, as in the paper's figure"
    );
}

#[test]
fn bad_tables_are_refused_with_file_and_line() {
    let header = |rows: &str| format!("distance_mm,raw\n{rows}").into_bytes();
    let cases: [(&str, Vec<u8>, &[&str]); 18] = [
        ("empty", vec![], &["input: is empty", "expected a table"]),
        (
            "no header",
            b"100,190\n200,135\n".to_vec(),
            &["input:1:", "name the columns"],
        ),
        (
            "no unit named",
            b"dist_cm\n10\n".to_vec(),
            &["input:1:", "name the columns"],
        ),
        (
            "a header alone",
            header(""),
            &["input: unit 'raw', 0 points", "three distances"],
        ),
        (
            "two distances",
            header("100,190\n100,191\n200,135\n"),
            &["3 points", "three distances"],
        ),
        (
            "a cut line",
            header("100,190\n200"),
            &["input:3:", "1 columns", "2"],
        ),
        (
            "a word",
            header("100,much\n"),
            &["input:2:", "'much' is not a number"],
        ),
        (
            "NaN",
            header("100,NaN\n"),
            &["a characteristic needs points"],
        ),
        (
            "infinity",
            header("inf,5\n"),
            &["input:2:", "'inf' is no distance"],
        ),
        (
            "a negative distance",
            header("-100,5\n"),
            &["input:2:", "no distance", "above 0"],
        ),
        (
            "a huge byte",
            header("100,1e300\n"),
            &["input:2:", "1e300", "within 0 to 255"],
        ),
        (
            "not UTF-8",
            b"distance_mm,raw\n100,\xFF\n".to_vec(),
            &["input:2:", "is not a number"],
        ),
        (
            "a zero byte",
            b"distance_mm,raw\n100,\0\n".to_vec(),
            &["input:2:", "not text"],
        ),
        (
            "ten bits",
            header("100,553\n"),
            &["input:2:", "'553'", "--adc-bits 10 or 12"],
        ),
        (
            "volts",
            header("100,2.7\n200,1.6\n400,0.9\n"),
            &["input:1:", "--volts", "--vref"],
        ),
        (
            "rising",
            header("100,10\n200,20\n400,30\n"),
            &["must fall", "measure it again"],
        ),
        (
            "control characters",
            b"dist_cm,\x1b[31mred\n10,1\n20,2\n".to_vec(),
            &["unit '\\u{1b}[31mred'"],
        ),
        ("too long", vec![b'#'; 9 << 20], &["input: over 8 MiB"]),
    ];
    for (what, content, words) in cases {
        let folder = folder_with(content);
        for json in ["", " --json"] {
            let ran = certainty_quickly(folder.path(), &format!("calibrate input{json}"));
            let line = ran.refusal();
            for word in words {
                assert!(line.contains(word), "{what}: no {word} in {line:?}");
            }
            assert_eq!(
                names(folder.path()),
                ["input"],
                "{what}: a refusal leaves nothing"
            );
        }
    }
}

#[test]
fn wrong_files_and_options_are_refused() {
    let folder = folder_with(recording());
    fs::create_dir(folder.path().join("directory")).unwrap();
    let mut cases = vec![
        ("calibrate missing.csv", "missing.csv: cannot be opened"),
        ("calibrate directory", "directory: is a directory"),
        ("calibrate input/below", "input/below: cannot be opened"),
        ("calibrate input --nearest 100", "'100' has no unit"),
        ("calibrate input --nearest=-1mm", "negative"),
        ("calibrate input --farthest NaNm", "NaNm"),
        (
            "calibrate input --nearest 800mm",
            "not below --farthest 800mm",
        ),
        ("calibrate input --nearest 2m --farthest 1m", "not below"),
        (
            "calibrate input --nearest 2m --farthest 3m",
            "unit 'raw', 0 points from 2000mm",
        ),
        (
            "calibrate --nearest 2m --farthest 3m",
            "the shipped units: unit 'A0_0', 0 points",
        ),
        ("calibrate input --out input", "--out"),
        ("calibrate input input", "input"),
        ("calibrate input --adc-bits 9", "--adc-bits"),
        ("calibrate input --vref 3.3", "--volts"),
        ("calibrate input --volts --vref 0", "--vref"),
        ("calibrate --adc-bits 10", "<FILE>"),
        ("calibrate --seed x", "--seed"),
    ];
    if cfg!(target_os = "linux") {
        cases.push(("calibrate /dev/zero", "/dev/zero"));
    }
    for (arguments, word) in cases {
        let ran = certainty_quickly(folder.path(), arguments);
        assert!(ran.refusal().contains(word), "{arguments}: {}", ran.stderr);
        assert_eq!(names(folder.path()), ["directory", "input"], "{arguments}");
    }
}

/// A unit without any valid reading has null errors, not NaN.
#[test]
fn a_unit_that_reads_no_distance_has_no_error() {
    // Means of 20 000 / d + 133.8: their byte is 200, which is 302 mm and beyond the range.
    let folder = folder_with("distance_mm,raw\n300.2,200.4223\n300.5,200.3557\n300.8,200.2894\n");
    let range = "--nearest 300mm --farthest 301mm";
    let document =
        certainty_quickly(folder.path(), &format!("calibrate input --json {range}")).json();
    let unit = &document["units"][0];
    assert_eq!(
        (&unit["points"], &unit["out_of_range"]),
        (&3.into(), &3.into())
    );
    assert!(
        unit["error_mm"].is_null() && unit["error_percent"].is_null(),
        "{unit}"
    );
    let ran = certainty_quickly(folder.path(), &format!("calibrate input {range}"));
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let svg = fs::read_to_string(folder.path().join("out/calibrate-errors.svg")).unwrap();
    assert!(svg.contains("no data"));
}

#[test]
fn the_longest_table_is_calibrated_quickly() {
    let mut table = "distance_mm,raw\n".to_owned();
    for number in 0..200_000_u32 {
        let mm = 100 + number % 701;
        writeln!(table, "{mm},{}", 60 + 13_000 / mm).unwrap();
    }
    let folder = folder_with(&table);
    let ran = run(
        command(folder.path(), ["calibrate", "input", "--json"]),
        4 * QUICKLY,
    );
    assert_eq!(ran.json()["units"][0]["points"], 200_000);
    table += "100,190\n";
    let folder = folder_with(table);
    let ran = certainty_quickly(folder.path(), "calibrate input");
    let line = ran.refusal();
    assert!(
        line.contains("input:200002: more than 200000 points"),
        "{line}"
    );
}

/// The file is read through the same reader as recordings.
#[test]
fn a_table_for_another_converter_is_fitted_in_its_counts() {
    let counts = |mm: u32| 80_000.0 / (f64::from(mm) + 20.0) + 30.0;
    let row = |mm: u32| format!("{};{:.0}\n", mm / 10, counts(mm));
    let table = format!(
        "Distance [cm];A0\n15;-\n{}",
        (150..=1500).step_by(50).map(row).collect::<String>()
    );
    let folder = folder_with(table);
    let options = "--adc-bits 10 --nearest 150mm --farthest 1500mm";
    let document =
        certainty_quickly(folder.path(), &format!("calibrate input --json {options}")).json();
    let unit = &document["units"][0];
    assert_eq!(
        (&document["adc_bits"], &unit["blank"]),
        (&10.into(), &1.into())
    );
    let slope = unit["a"].as_f64().unwrap();
    assert!((slope / 80_000.0 - 1.0).abs() < 0.1, "{slope}");
    let text = certainty_quickly(folder.path(), &format!("calibrate input {options}")).stdout;
    assert!(
        text.contains("10-bit ADC") && text.contains("1 blank field"),
        "{text}"
    );
}

#[test]
fn volts_are_fitted_as_counts_of_the_converter() {
    let row = |mm: u32| format!("{mm}\t{:.3}\n", 300.0 / f64::from(mm) + 0.3).replace('.', ",");
    let table = format!(
        "mm\tleft\n{}",
        (150..=1500).step_by(50).map(row).collect::<String>()
    );
    let folder = folder_with(table);
    let options = "--volts --vref 3.3 --nearest 150mm --farthest 1500mm";
    let document =
        certainty_quickly(folder.path(), &format!("calibrate input --json {options}")).json();
    assert_eq!(document["reference_volts"], 3.3);
    let floor = document["units"][0]["c"].as_f64().unwrap();
    assert!((floor - 0.3 / 3.3 * 255.0).abs() < 0.5, "{floor}");
}
