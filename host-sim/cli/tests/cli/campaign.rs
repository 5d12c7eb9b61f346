//! `certainty campaign`: the same rows on any number of threads and after any interruption.

use crate::support::{certainty, command, shape};
use core::time::Duration;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::thread;
use tempfile::TempDir;

/// Ten short scenarios: without the robust method no health is followed.
const SCENARIOS: &str = r#"
    faults = ["none", "stuck-far", "dropout"]
    rates = [1, 4]
    sensors = [3]
    overlap = ["full", "partial"]
    sweeps = [1]
    methods = ["bayes"]
"#;

/// Two scenarios with every method.
const WITH_HEALTH: &str = r#"
    faults = ["none", "dropout"]
    rates = [1]
    sensors = [3]
    overlap = ["full"]
    sweeps = [1]
"#;

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("s.toml"), SCENARIOS).unwrap();
    fs::write(folder.path().join("health.toml"), WITH_HEALTH).unwrap();
    folder
}

fn file(folder: &Path) -> String {
    fs::read_to_string(folder.join("c.csv")).unwrap()
}

const RUN: &str = "campaign --scenarios s.toml --seeds 2 --csv c.csv";

/// The whole file of an undisturbed run.
fn undisturbed() -> String {
    let folder = folder();
    let ran = certainty(folder.path(), RUN);
    assert_eq!(ran.stdout, "c.csv: 10 scenarios, 10 of them new\n");
    assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""));
    file(folder.path())
}

#[test]
fn json_has_a_row_for_every_method_and_the_oracle() {
    let folder = folder();
    let ran = certainty(
        folder.path(),
        "campaign --scenarios health.toml --seeds 2 --json",
    );
    let document = ran.json();
    insta::assert_json_snapshot!("campaign", shape(&document));
    let rows = document["rows"].as_array().unwrap();
    let methods: Vec<_> = rows
        .iter()
        .take(5)
        .map(|row| row["method"].as_str().unwrap())
        .collect();
    assert_eq!(methods, ["bayes", "robust", "trimmed", "median", "oracle"]);
    assert_eq!(rows.len(), 2 * methods.len());
    let header = undisturbed();
    let columns: Vec<&str> = header.lines().next().unwrap().split(',').collect();
    for row in rows {
        let fields = row.as_object().unwrap();
        assert_eq!(fields.len(), columns.len());
        assert!(
            columns.iter().all(|column| fields.contains_key(*column)),
            "{row}"
        );
        for share in ["mae", "mse", "missed", "ghost"] {
            assert!((0.0..=1.0).contains(&row[share].as_f64().unwrap()), "{row}");
        }
        let learns = row["method"] == "robust";
        let faulty = row["fault"] != "none";
        assert_eq!(row["false_failed"].is_number(), learns, "{row}");
        assert_eq!(row["failed"].is_number(), learns && faulty, "{row}");
        if learns && faulty {
            // A sensor that drops half its readings is noticed by what is missing.
            assert_eq!(row["suspect"].as_f64(), Some(1.0), "{row}");
        }
        if row["method"] == "oracle" {
            assert_eq!(row["mae_to_oracle"].as_f64(), Some(0.0));
        }
    }
}

#[test]
fn any_number_of_jobs_writes_the_same_bytes() {
    let expected = undisturbed();
    for jobs in [1, 2, 5] {
        let folder = folder();
        let ran = certainty(folder.path(), &format!("{RUN} --jobs {jobs}"));
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        assert_eq!(file(folder.path()), expected, "{jobs} jobs");
    }
}

#[test]
fn a_cut_file_is_completed_to_the_same_bytes() {
    let expected = undisturbed();
    let folder = folder();
    for cut in (0..expected.len()).step_by(expected.len() / 12) {
        fs::write(folder.path().join("c.csv"), &expected[..cut]).unwrap();
        let ran = certainty(folder.path(), RUN);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        assert_eq!(file(folder.path()), expected, "cut at {cut}");
    }
    let ran = certainty(folder.path(), RUN);
    assert_eq!(ran.stdout, "c.csv: 10 scenarios, 0 of them new\n");
    assert_eq!(file(folder.path()), expected);
}

#[test]
fn a_killed_campaign_ends_with_the_same_file() {
    let expected = undisturbed();
    let folder = folder();
    let mut kills = 0;
    for patience in (1..).map(|n| Duration::from_millis(n * 15)) {
        let mut child = command(folder.path(), RUN.split(' '))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        thread::sleep(patience);
        let Some(status) = child.try_wait().unwrap() else {
            child.kill().unwrap(); // SIGKILL
            child.wait().unwrap();
            kills += 1;
            continue;
        };
        assert!(status.success());
        break;
    }
    assert!(kills > 0, "every run ended before it could be killed");
    assert_eq!(file(folder.path()), expected);
}

#[test]
fn a_foreign_file_is_refused_and_not_changed() {
    let whole = undisturbed();
    let folder = folder();
    let other_seed = whole.replace(",2,", ",3,");
    let damaged = whole.replacen("0.0", "0,0", 1);
    let longer = whole.clone() + "more\n";
    let lines = whole.lines().count();
    let after = format!("c.csv:{}:", lines + 1);
    for (content, word) in [
        ("my notes\n", "c.csv:1:"),
        (&other_seed, "c.csv:2:"),
        (&damaged, "damaged"),
        (&longer, &after),
    ] {
        fs::write(folder.path().join("c.csv"), content).unwrap();
        let ran = certainty(folder.path(), RUN);
        assert!(ran.refusal().contains(word), "{}", ran.stderr);
        assert_eq!(file(folder.path()), content);
    }
}

#[test]
fn bad_arguments_and_scenario_files_end_in_one_line() {
    let folder = folder();
    for (name, content) in [
        ("empty-list.toml", &b"rates = []"[..]),
        ("unknown.toml", b"fault = ['none']"),
        ("cut.toml", b"faults = ['none"),
        ("bytes.toml", b"\xFF\xFE\x00"),
        ("huge.toml", b"sweeps = [99999999999999999999]"),
        ("kind.toml", b"\nfaults = ['none', 'stuck-far:2']"),
    ] {
        fs::write(folder.path().join(name), content).unwrap();
        let ran = certainty(
            folder.path(),
            &format!("campaign --seeds 1 --scenarios {name}"),
        );
        assert!(
            ran.refusal().contains(&format!("{name}:")),
            "{}",
            ran.stderr
        );
    }
    for (arguments, word) in [
        ("--scenarios nowhere.toml", "nowhere.toml: cannot read"),
        (
            "--scenarios .",
            ".: is a directory: expected a scenario file",
        ),
        ("--seeds 0", "--seeds"),
        ("--seeds 1e9", "--seeds"),
        ("--seeds NaN", "--seeds"),
        ("--jobs 0", "--jobs"),
        ("--rules lax", "invalid value 'lax'"),
        ("--json --csv c.csv", "--csv"),
        ("--csv nowhere/c.csv", "nowhere/c.csv: "),
        ("--csv .", ".: is a directory: expected a file for --csv"),
        ("--csv /dev/full --scenarios s.toml", "/dev/full"),
    ] {
        let ran = certainty(folder.path(), &format!("campaign {arguments}"));
        assert!(ran.refusal().contains(word), "{}", ran.stderr);
    }
}

#[test]
fn the_shipped_sample_selects_one_sensor_of_three() {
    let sample = concat!(env!("CARGO_MANIFEST_DIR"), "/../data/one-of-three.toml");
    let selection = certainty_repro::campaign::Selection::load(Path::new(sample));
    let scenarios = selection.unwrap().scenarios();
    assert_eq!(scenarios.len(), 6);
    assert!(scenarios.iter().all(|scenario| scenario.sensors == 3));
}
