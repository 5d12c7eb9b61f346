//! The command line's contract: what scripts rely on when they run `certainty simulate`.

use crate::support::{certainty, command, shape};
use certainty_tests::process::{PATIENCE, Ran, run, wait};
use certainty_tests::skipped;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

/// Runs the program in a folder of its own.
fn alone(arguments: &str) -> Ran {
    let folder = tempfile::tempdir().unwrap();
    certainty(folder.path(), arguments)
}

fn list<'a>(document: &'a Value, key: &str) -> &'a [Value] {
    document[key].as_array().unwrap()
}

/// Bytes of each method, by name.
fn bytes(document: &Value) -> BTreeMap<&str, u64> {
    let methods = list(document, "methods").iter();
    methods
        .map(|method| {
            (
                method["name"].as_str().unwrap(),
                method["bytes"].as_u64().unwrap(),
            )
        })
        .collect()
}

/// Every file below `folder` with its content.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(Result::unwrap);
    entries
        .map(|entry| {
            (
                entry.file_name().into_string().unwrap(),
                fs::read(entry.path()).unwrap(),
            )
        })
        .collect()
}

#[test]
fn json_has_the_shape_of_its_snapshot() {
    let document = alone("simulate --json").json();
    insta::assert_json_snapshot!("simulate", shape(&document));
    for method in list(&document, "methods") {
        for share in ["ghost", "mae", "missed", "mse"] {
            let value = method[share].as_f64().unwrap();
            assert!((0.0..=1.0).contains(&value), "{share} of {method}");
        }
        // No cell is off by more than one, so the square of an error is at most the error.
        assert!(method["mse"].as_f64() <= method["mae"].as_f64(), "{method}");
    }
    for sensor in list(&document, "sensors") {
        let status = sensor["status"].as_str().unwrap();
        assert!(["healthy", "suspect", "failed", "recovering"].contains(&status));
        let confidence = sensor["confidence"].as_f64().unwrap();
        assert!((0.0..=1.0).contains(&confidence), "{confidence}");
    }
}

#[test]
fn the_default_job_is_the_papers_grid_one_sensor_stuck() {
    let document = alone("simulate --json").json();
    let world = &document["world"];
    assert_eq!(
        (&world["width"], &world["height"], &world["cell_mm"]),
        (&17.into(), &11.into(), &100.into())
    );
    let names: Vec<_> = list(&document, "methods")
        .iter()
        .map(|method| &method["name"])
        .collect();
    assert_eq!(names, ["bayes", "robust", "trimmed", "median"]);
    let expected = [
        ("bayes", 187),
        ("median", 561),
        ("robust", 234),
        ("trimmed", 561),
    ];
    assert_eq!(bytes(&document), BTreeMap::from(expected));
    let sensors = list(&document, "sensors").iter();
    let text: Vec<_> = sensors
        .map(|sensor| {
            (
                sensor["id"].as_u64(),
                sensor["model"].as_str(),
                sensor["fault"].as_str(),
            )
        })
        .collect();
    let expected = [
        (Some(1), Some("A"), None),
        (Some(2), Some("B"), Some("stuck-far:2")),
        (Some(3), Some("C"), None),
    ];
    assert_eq!(text, expected);
}

/// \[001\] §6: with a sensor that fails, the methods that keep the sensors apart err less than eq. 1.
#[test]
fn with_a_stuck_sensor_bayes_errs_most() {
    for seed in 1..=5 {
        let document = alone(&format!("simulate --json --seed {seed}")).json();
        let score = |name: &str, key: &str| {
            let mut methods = list(&document, "methods").iter();
            methods.find(|method| method["name"] == name).unwrap()[key].as_f64()
        };
        for survivor in ["trimmed", "median"] {
            let (better, worse) = (score(survivor, "mae"), score("bayes", "mae"));
            assert!(
                better < worse,
                "MAE of {survivor}, seed {seed}: {better:?}, {worse:?}"
            );
            let (fewer, more) = (score(survivor, "missed"), score("bayes", "missed"));
            assert!(
                fewer <= more,
                "{survivor}, seed {seed}: {fewer:?}, {more:?}"
            );
        }
    }
}

/// \[002\] §4: the confidence falls for a sensor that is repeatedly wrong, and not for the others.
#[test]
fn only_the_blind_sensor_fails() {
    for seed in 1..=5 {
        let run = format!("simulate --json --fault stuck-far:2 --seed {seed} --readings 3000");
        let document = alone(&run).json();
        let status: Vec<_> = list(&document, "sensors")
            .iter()
            .map(|sensor| sensor["status"].as_str().unwrap())
            .collect();
        assert_eq!(status, ["healthy", "failed", "healthy"], "{run}");
    }
}

#[test]
fn sound_sensors_stay_healthy_in_long_runs() {
    for readings in [444, 2000, 10_000] {
        let document = alone(&format!(
            "simulate --json --fault none --readings {readings}"
        ))
        .json();
        for sensor in list(&document, "sensors") {
            assert_eq!(
                sensor["status"], "healthy",
                "after {readings} readings: {sensor}"
            );
        }
    }
}

#[test]
fn every_listed_file_is_a_complete_png() {
    let folder = tempfile::tempdir().unwrap();
    let document = certainty(folder.path(), "simulate --json --out pictures").json();
    let mut named: Vec<_> = list(&document, "files")
        .iter()
        .map(|file| file.as_str().unwrap().to_owned())
        .collect();
    for file in &named {
        let picture = fs::read(folder.path().join(file)).unwrap();
        assert!(picture.starts_with(b"\x89PNG\r\n\x1a\n"), "{file}");
        assert!(picture.ends_with(b"IEND\xAE\x42\x60\x82"), "{file}");
    }
    named.sort_unstable();
    let there = files(&folder.path().join("pictures"));
    let there: Vec<_> = there
        .keys()
        .map(|name| format!("pictures/{name}"))
        .collect();
    assert_eq!(named, there, "nothing else is left there");
    for method in ["bayes", "robust", "trimmed", "median"] {
        assert!(
            there.contains(&format!("pictures/{method}.png")),
            "{there:?}"
        );
    }
}

#[test]
fn the_seed_decides_the_bytes() {
    let run = |seed: &str| {
        let folder = tempfile::tempdir().unwrap();
        let ran = certainty(folder.path(), &format!("simulate --json --seed {seed}"));
        (ran.json(), ran.stdout, files(&folder.path().join("out")))
    };
    let (first, again, other) = (run("7"), run("7"), run("8"));
    assert_eq!(first.1, again.1);
    assert_eq!(first.2, again.2);
    assert_eq!((&first.0["seed"], &other.0["seed"]), (&7.into(), &8.into()));
    assert_ne!(first.0["methods"], other.0["methods"]);
    assert_ne!(first.2["robust.png"], other.2["robust.png"]);
    // What is true does not depend on dice.
    assert_eq!(first.2["truth.png"], other.2["truth.png"]);
}

#[test]
fn stdout_is_one_json_document_and_stderr_is_silent() {
    let ran = alone("simulate --json");
    let _document = ran.json();
    assert!(
        ran.stdout.starts_with('{') && ran.stdout.ends_with("}\n"),
        "{}",
        ran.stdout
    );
    assert_eq!(ran.stderr, "");
}

#[test]
fn one_method_can_be_asked_for() {
    for method in ["bayes", "robust", "trimmed", "median"] {
        let document = alone(&format!("simulate --json --fusion {method}")).json();
        let names: Vec<_> = bytes(&document).into_keys().collect();
        assert_eq!(names, [method]);
    }
    let all = alone("simulate --json --fusion all").json();
    assert_eq!(list(&all, "methods").len(), 4);
}

#[test]
fn a_method_alone_scores_as_among_all() {
    let all = alone("simulate --json").json();
    for (place, method) in ["bayes", "robust", "trimmed", "median"].iter().enumerate() {
        let one = alone(&format!("simulate --json --fusion {method}")).json();
        assert_eq!(
            one["methods"][0], all["methods"][place],
            "identical readings"
        );
    }
}

/// \[001\] §7: ⌈log₂(5 + 1)⌉ = 3 bits an owner, 70.125 bytes, and five bytes a cell.
#[test]
fn five_sensors_take_the_bytes_of_the_papers_formula() {
    let document = alone("simulate --json --sensors 5").json();
    let expected = [
        ("bayes", 187),
        ("median", 935),
        ("robust", 187 + 71),
        ("trimmed", 935),
    ];
    assert_eq!(bytes(&document), BTreeMap::from(expected));
    let models: Vec<_> = list(&document, "sensors")
        .iter()
        .map(|sensor| &sensor["model"])
        .collect();
    assert_eq!(models, ["A", "B", "C", "D", "E"]);
}

#[test]
fn sensors_can_be_chosen_by_the_letters_of_table_1() {
    let document = alone("simulate --json --sensors CCE").json();
    let models: Vec<_> = list(&document, "sensors")
        .iter()
        .map(|sensor| &sensor["model"])
        .collect();
    assert_eq!(models, ["C", "C", "E"]);
}

#[test]
fn faults_belong_to_the_named_sensors() {
    let faults = "--fault dropout:1=100% --fault stuck-near:3=250mm";
    let document = alone(&format!("simulate --json {faults}")).json();
    let text: Vec<_> = list(&document, "sensors")
        .iter()
        .map(|sensor| &sensor["fault"])
        .collect();
    assert_eq!(
        text,
        [
            &"dropout:1=100%".into(),
            &Value::Null,
            &"stuck-near:3=250mm".into()
        ]
    );
    let silent = &document["sensors"][0];
    assert_eq!(silent["status"], "failed");
    let readings = document["readings"].as_u64().unwrap();
    assert_eq!(silent["missing"].as_u64(), Some(readings / 3));
    let sound = alone("simulate --json --fault none").json();
    assert!(
        list(&sound, "sensors")
            .iter()
            .all(|sensor| sensor["fault"].is_null())
    );
}

#[test]
fn readings_are_counted_over_all_sensors() {
    let document = alone("simulate --json --readings 30 --fault dropout:1=100%").json();
    assert_eq!(document["readings"], 30);
    assert_eq!(document["sensors"][0]["missing"], 10);
}

#[test]
fn without_a_terminal_the_report_is_plain_text() {
    let ran = alone("simulate");
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert_eq!(ran.stderr, "", "no bar, no note");
    assert!(!ran.stdout.contains('\u{1b}'), "no colour");
}

#[test]
fn the_report_fits_a_terminal_of_80_columns() {
    for arguments in [
        "simulate",
        "simulate --sensors 7",
        "simulate --fusion robust",
    ] {
        let ran = alone(arguments);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        for line in ran.stdout.lines() {
            let columns = line.chars().count();
            assert!(columns <= 80, "{columns} columns with {arguments}: {line}");
        }
    }
}

#[test]
fn the_report_has_methods_sensors_and_pictures() {
    let text = alone("simulate --out pictures").stdout;
    for word in [
        "truth",
        "bayes",
        "robust",
        "trimmed",
        "median",
        "MAE",
        "MSE",
        "missed",
        "ghost",
        "stuck-far:2",
        "234",
        "561",
        "pictures",
    ] {
        assert!(text.contains(word), "no {word} in\n{text}");
    }
    // Eleven rows of five maps with 17 cells each.
    let map_row = |line: &&str| {
        let panels: Vec<&str> = line.split_whitespace().collect();
        let cells = |panel: &&str| panel.len() == 17 && panel.chars().all(|c| "#.?Xo".contains(c));
        !panels.is_empty() && panels.iter().all(cells)
    };
    let panels: usize = text
        .lines()
        .filter(map_row)
        .map(|line| line.split_whitespace().count())
        .sum();
    assert_eq!(panels, 11 * 5, "{text}");
}

/// A terminal is what `script` makes; its argument for a command differs between systems.
#[cfg(target_os = "linux")]
#[test]
fn a_terminal_has_colour_unless_it_is_dumb_or_no_color_is_set() {
    let on_terminal = |terminal: &str, no_color: bool| {
        let folder = tempfile::tempdir().unwrap();
        let inner = command(folder.path(), ["simulate"]);
        let program = inner.get_program().to_str().unwrap();
        let mut script = Command::new("script");
        script
            .args(["-qec", &format!("'{program}' simulate"), "/dev/null"])
            .current_dir(folder.path())
            .env("TERM", terminal)
            .stdin(Stdio::null());
        if no_color {
            script.env("NO_COLOR", "1");
        } else {
            script.env_remove("NO_COLOR");
        }
        let ran = run(script, PATIENCE);
        assert!(ran.stdout.contains("truth"), "{ran:?}");
        ran.stdout.contains('\u{1b}')
    };
    if Command::new("script").arg("--version").output().is_err() {
        skipped("there is no `script` to make a terminal");
        return;
    }
    assert!(on_terminal("xterm", false));
    assert!(!on_terminal("xterm", true));
    assert!(!on_terminal("dumb", false));
}

#[test]
fn without_a_command_it_simulates() {
    for options in ["", "--json", "--json --seed 3 --fault none"] {
        let bare = alone(options);
        let named = alone(&format!("simulate {options}"));
        assert_eq!(bare.code, Some(0), "{}", bare.stderr);
        assert_eq!(bare.stdout, named.stdout);
    }
}

#[test]
fn help_and_version_are_results() {
    for (arguments, expected) in [
        ("--help", "simulate"),
        ("--help", "replay"),
        ("--help", "compare"),
        ("simulate --help", "--fault"),
        ("replay --help", "--max-cells"),
        ("compare --help", "--json"),
        ("--version", "certainty 0."),
    ] {
        let ran = alone(arguments);
        assert_eq!(ran.code, Some(0), "{arguments}: {}", ran.stderr);
        assert!(ran.stdout.contains(expected), "{arguments}: {}", ran.stdout);
        assert_eq!(ran.stderr, "");
    }
}

/// `certainty | head -1`: the reader has seen what it wanted.
#[test]
fn a_closed_pipe_is_no_failure() {
    for arguments in ["simulate", "simulate --json", "--help", "--version"] {
        let folder = tempfile::tempdir().unwrap();
        let mut child = command(folder.path(), arguments.split(' '))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let code = wait(&mut child, PATIENCE);
        let stderr = std::io::read_to_string(child.stderr.take().unwrap()).unwrap();
        assert_eq!(stderr, "", "{arguments}");
        assert_eq!(code, Some(Some(0)), "{arguments}");
    }
}

/// A full disk is somebody's input, not our fault, and not a success.
#[cfg(target_os = "linux")]
#[test]
fn a_full_stdout_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let output = command(folder.path(), ["simulate", "--json"])
        .stdout(full)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(stderr.starts_with("certainty: stdout: "), "{stderr}");
    assert!(stderr.contains("free space"), "what to do: {stderr}");
    assert_eq!(stderr.lines().count(), 1);
}
