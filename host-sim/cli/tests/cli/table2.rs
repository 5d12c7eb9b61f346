//! `certainty table2`: the evaluation of [001] §6.2 on the command line.

use crate::support::{certainty, shape};
use certainty_tests::process::Ran;
use serde_json::Value;
use std::fs;

/// Runs the program in a folder of its own.
fn alone(arguments: &str) -> Ran {
    let folder = tempfile::tempdir().unwrap();
    certainty(folder.path(), arguments)
}

fn list<'a>(document: &'a Value, key: &str) -> &'a [Value] {
    document[key].as_array().unwrap()
}

#[test]
fn json_has_the_shape_of_its_snapshot() {
    let document = alone("table2 --worlds 3 --json").json();
    insta::assert_json_snapshot!("table2", shape(&document));
    assert_eq!(
        (&document["worlds"], &document["seed"]),
        (&3.into(), &1.into())
    );
    let methods = list(&document, "methods");
    let names: Vec<_> = methods.iter().map(|row| &row["name"]).collect();
    assert_eq!(names, ["bayes", "robust", "trimmed", "median", "oracle"]);
    for method in methods {
        for share in ["mae", "mae_sd", "mse", "mse_sd", "missed", "ghost"] {
            let value = method[share].as_f64().unwrap();
            assert!((0.0..=1.0).contains(&value), "{share} of {method}");
        }
        // No cell is off by more than one, so the square of an error is at most the error.
        assert!(method["mse"].as_f64() <= method["mae"].as_f64(), "{method}");
    }
}

#[test]
fn sensitivity_has_the_shape_of_its_snapshot() {
    let document = alone("table2 --worlds 1 --sensitivity --json").json();
    insta::assert_json_snapshot!("table2-sensitivity", shape(&document["sensitivity"]));
}

#[test]
fn the_papers_figures_are_in_the_document() {
    let document = alone("table2 --worlds 1 --json").json();
    let paper: Vec<_> = list(&document, "paper")
        .iter()
        .map(|row| {
            let thousandths = |key: &str| (row[key].as_f64().unwrap() * 1e3).round() as u32;
            let name = row["name"].as_str().unwrap();
            (name, thousandths("mae"), thousandths("mse"))
        })
        .collect();
    let printed = [("bayes", 101, 69), ("robust", 22, 12), ("median", 9, 6)];
    assert_eq!(paper, printed);
}

#[test]
fn every_method_has_the_papers_1560_readings() {
    let document = alone("table2 --worlds 1 --json").json();
    assert_eq!(document["readings_per_method"], 1560);
}

#[test]
fn one_world_has_no_deviation() {
    let document = alone("table2 --worlds 1 --json").json();
    for method in list(&document, "methods") {
        assert_eq!(method["mae_sd"], Value::Null);
        assert_eq!(method["mse_sd"], Value::Null);
    }
}

#[test]
fn the_seed_decides_the_bytes_and_threads_do_not() {
    let run = |arguments: &str| {
        let folder = tempfile::tempdir().unwrap();
        let ran = certainty(
            folder.path(),
            &format!("table2 --worlds 9 --json {arguments}"),
        );
        let table = fs::read(folder.path().join("out/table2.csv")).unwrap();
        assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""));
        (ran.stdout, table)
    };
    let one = run("--jobs 1");
    assert_eq!(run("--jobs 2"), one);
    assert_eq!(run("--jobs 5"), one);
    assert_eq!(run(""), one);
    assert_ne!(run("--seed 2").1, one.1);
}

#[test]
fn the_mean_of_the_csv_is_the_reports() {
    let folder = tempfile::tempdir().unwrap();
    let document = certainty(folder.path(), "table2 --worlds 5 --json --out here").json();
    let files = list(&document, "files");
    assert_eq!(
        files,
        ["here/table2.csv", "here/table2.png", "here/table2.svg"]
    );
    let table = fs::read_to_string(folder.path().join("here/table2.csv")).unwrap();
    let mut lines = table.lines();
    assert_eq!(
        lines.next(),
        Some("world,method,mae,mse,missed,ghost,to_oracle")
    );
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 5 * 5);
    for method in list(&document, "methods") {
        for (column, key) in [(2, "mae"), (6, "to_oracle")] {
            let of_method = rows.iter().filter(|row| method["name"] == row[1]);
            let values = of_method.map(|row| row[column].parse::<f64>().unwrap());
            let mean = values.sum::<f64>() / 5.0;
            assert!(
                (mean - method[key].as_f64().unwrap()).abs() < 1e-12,
                "{key}"
            );
        }
    }
}

#[test]
fn the_text_has_both_tables_in_80_columns() {
    let text = alone("table2 --worlds 2").stdout;
    for word in [
        "bayes", "robust", "trimmed", "median", "oracle", "paper", "ratio", "±", "1560",
    ] {
        assert!(text.contains(word), "no {word} in {text}");
    }
    let longest = text.lines().map(|line| line.chars().count()).max();
    assert!(longest <= Some(80), "{text}");
}

#[test]
fn bad_numbers_are_refused_in_one_line() {
    for (arguments, words) in [
        ("--worlds 0", ["--worlds", "100000"]),
        ("--worlds 100001", ["--worlds", "100000"]),
        (
            "--worlds 99999999999999999999",
            ["--worlds", "99999999999999999999"],
        ),
        ("--worlds NaN", ["--worlds", "NaN"]),
        ("--worlds -1", ["-1", "--help"]),
        ("--worlds 1.5", ["--worlds", "1.5"]),
        ("--jobs 0", ["--jobs", "1024"]),
        ("--jobs 1025", ["--jobs", "1024"]),
        ("--seed -1", ["--seed", "-1"]),
        ("--seed x", ["--seed", "x"]),
        ("--sensitivity=often", ["--sensitivity", "often"]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let ran = certainty(folder.path(), &format!("table2 {arguments}"));
        let line = ran.refusal();
        for word in words {
            assert!(line.contains(word), "{arguments}: no {word} in {line:?}");
        }
        let left = fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(left, 0, "{arguments} leaves nothing behind");
    }
}

#[test]
fn an_impossible_folder_is_refused_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    let ran = certainty(folder.path(), "table2 --worlds 100000 --out file");
    assert!(ran.refusal().contains("file"));
}
