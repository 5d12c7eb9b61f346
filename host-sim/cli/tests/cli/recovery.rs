//! `certainty recovery`: \[001\] §6.3, Fig. 7.

use crate::support::{certainty, shape};
use certainty_tests::process::Ran;
use serde_json::Value;
use std::fs;

/// Runs the program in a folder of its own.
fn alone(arguments: &str) -> Ran {
    let folder = tempfile::tempdir().unwrap();
    certainty(folder.path(), arguments)
}

/// Each sensor's confidences.
fn traces(document: &Value) -> Vec<Vec<f64>> {
    let traces = document["confidence"].as_array().unwrap().iter();
    let numbers = |trace: &Value| {
        let numbers = trace.as_array().unwrap().iter();
        numbers.map(|number| number.as_f64().unwrap()).collect()
    };
    traces.map(numbers).collect()
}

/// Readings since the fault's end until sensor 1 is at most 5 % of full confidence below the mean of
/// the others, computed from the traces alone.
fn first_return(document: &Value) -> Option<u64> {
    let traces = traces(document);
    let end = document["fault"]["to"].as_u64().unwrap();
    let margin = 3276.0 / 65535.0;
    (end..=200).find_map(|readings| {
        let at = usize::try_from(readings - 1).unwrap();
        let others = f64::midpoint(traces[1][at], traces[2][at]);
        (traces[0][at] + margin >= others - 1e-12).then_some(readings - end)
    })
}

#[test]
fn json_has_the_shape_of_its_snapshot() {
    for count in ["each", "all"] {
        let document = alone(&format!("recovery --json --seeds 3 --count {count}")).json();
        insta::assert_json_snapshot!(format!("recovery-{count}"), shape(&document));
        assert_eq!(document["over_seeds"]["seeds"], 3);
        assert_eq!(document["readings"], 200);
        assert_eq!(document["count"], count);
    }
}

#[test]
fn the_fault_is_the_papers() {
    for (arguments, kind, spec) in [
        ("", "output-noise", "output-noise:1=20%@0..50"),
        (
            "--count each --noise output",
            "output-noise",
            "output-noise:1=20%@0..50",
        ),
        // The 17 of sensor 1 among the first 50.
        ("--count all", "output-noise", "output-noise:1=20%@0..17"),
        (
            "--count all --sensors 5",
            "output-noise",
            "output-noise:1=20%@0..10",
        ),
        ("--noise echo", "noise", "noise:1=20%@0..50"),
    ] {
        let document = alone(&format!("recovery --json --seeds 1 {arguments}")).json();
        let fault = &document["fault"];
        assert_eq!(
            (&fault["sensor"], &fault["kind"]),
            (&1.into(), &kind.into())
        );
        assert_eq!((&fault["from"], &fault["to"]), (&0.into(), &50.into()));
        assert_eq!(fault["spec"], spec);
    }
}

#[test]
fn every_option_changes_the_figure_and_is_named() {
    let plain = alone("recovery --json --seeds 1").json();
    assert_eq!(
        (&plain["sensors"], &plain["rules"]),
        (&"ABC".into(), &"shipped".into())
    );
    for (arguments, key, value) in [
        ("--noise echo", "rules", "shipped"),
        ("--sensors CCC", "sensors", "CCC"),
        ("--sensors 4", "sensors", "ABCD"),
        ("--rules letter", "rules", "letter"),
    ] {
        let document = alone(&format!("recovery --json --seeds 1 {arguments}")).json();
        assert_eq!(document[key], value);
        assert_ne!(document["confidence"], plain["confidence"], "{arguments}");
        let sensors = document["sensors"].as_str().unwrap().len();
        assert_eq!(traces(&document).len(), sensors);
    }
}

/// The control run has no noise, and sensor 1 of CCC falls by the noise alone.
#[test]
fn the_control_is_the_same_whatever_the_noise() {
    let over = |noise: &str| {
        let run = format!("recovery --json --seeds 30 --sensors CCC --noise {noise}");
        alone(&run).json()["over_seeds"].clone()
    };
    let (output, echo) = (over("output"), over("echo"));
    let control = "clearly_below_without_fault";
    assert_eq!(output[control], echo[control]);
    let share = |key: &str| output[key].as_f64().unwrap();
    assert!((0.0..=1.0).contains(&share(control)));
    assert!(share("clearly_below") > share(control), "{output}");
}

#[test]
fn three_sensors_start_at_full_confidence() {
    for count in ["each", "all"] {
        let document = alone(&format!("recovery --json --seeds 1 --count {count}")).json();
        let traces = traces(&document);
        assert_eq!(traces.iter().map(Vec::len).collect::<Vec<_>>(), [200; 3]);
        for own in &traces {
            assert!(own.iter().all(|value| (0.0..=1.0).contains(value)));
            // The first readings have little to be compared with.
            assert!(own[0] > 0.9, "{}", own[0]);
            assert!(own.iter().any(|&value| value < 1.0), "it never moved");
        }
    }
}

#[test]
fn recovered_after_follows_from_the_traces() {
    for count in ["each", "all"] {
        for seed in 1..=10 {
            let run = format!("recovery --json --seeds 1 --count {count} --seed {seed}");
            let document = alone(&run).json();
            assert_eq!(
                document["recovered_after"].as_u64(),
                first_return(&document),
                "{run}"
            );
        }
    }
}

#[test]
fn a_single_seed_is_its_own_median() {
    let document = alone("recovery --json --seeds 1 --seed 4").json();
    let over_seeds = &document["over_seeds"];
    for percentile in ["p10", "p90"] {
        assert_eq!(over_seeds[percentile], over_seeds["median"]);
    }
    let came_back = u64::from(!over_seeds["median"].is_null());
    assert_eq!(over_seeds["recovered"].as_u64(), Some(came_back));
    assert_eq!(over_seeds["lowest_confidence"]["sd"], 0.0);
}

#[test]
fn the_seed_decides_the_bytes() {
    let run = |seed: u64| alone(&format!("recovery --json --seeds 5 --seed {seed}")).stdout;
    assert_eq!(run(7), run(7));
    let (seventh, eighth) = (
        alone("recovery --json --seed 7 --seeds 5").json(),
        alone("recovery --json --seed 8 --seeds 5").json(),
    );
    assert_ne!(seventh["confidence"], eighth["confidence"]);
    assert_ne!(seventh["over_seeds"], eighth["over_seeds"]);
}

#[test]
fn the_confidences_are_written_as_csv() {
    let folder = tempfile::tempdir().unwrap();
    let document = certainty(folder.path(), "recovery --json --seeds 1 --out figures").json();
    let files = [
        "figures/recovery.csv",
        "figures/recovery.png",
        "figures/recovery.svg",
        "figures/recovery-seeds.png",
        "figures/recovery-seeds.svg",
    ];
    assert_eq!(document["files"], serde_json::json!(files));
    for file in files {
        let written = fs::read(folder.path().join(file)).unwrap();
        let begins: &[u8] = match file.rsplit('.').next() {
            Some("png") => b"\x89PNG",
            Some("svg") => b"<svg",
            _ => b"reading,",
        };
        assert!(written.starts_with(begins), "{file}");
    }
    let svg = fs::read_to_string(folder.path().join("figures/recovery.svg")).unwrap();
    for word in [
        "sensor 1 (A)",
        "sensor 3 (C)",
        "fault of sensor 1",
        "20 % noise",
    ] {
        assert!(svg.contains(word), "no {word}");
    }
    let text = fs::read_to_string(folder.path().join("figures/recovery.csv")).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("reading,sensor_1,sensor_2,sensor_3"));
    let traces = traces(&document);
    for (at, line) in (0..200).zip(lines.by_ref()) {
        let fields: Vec<f64> = line
            .split(',')
            .map(|field| field.parse().unwrap())
            .collect();
        assert_eq!(fields.len(), 4, "{line}");
        assert_eq!(fields[0], f64::from(at) + 1.0);
        let at = usize::try_from(at).unwrap();
        for (written, own) in fields[1..].iter().zip(&traces) {
            assert!((written - own[at]).abs() <= 0.5e-5 + 1e-12, "{line}");
        }
    }
    assert_eq!(lines.next(), None);
}

#[test]
fn the_text_is_plain_and_fits_80_columns() {
    for choice in ["--count each", "--count all", "--sensors CDEABCDEABCDEAB"] {
        let ran = alone(&format!("recovery --seeds 5 {choice}"));
        assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""));
        for line in ran.stdout.lines() {
            assert!(line.chars().count() <= 80, "{line}");
        }
        for word in [
            "output-noise:1=20%",
            "rules: shipped",
            "sensor 3",
            "5 random layouts",
            "median",
            "without the fault",
            "recovery.csv",
            "recovery-seeds.png",
        ] {
            assert!(ran.stdout.contains(word), "no {word} in\n{}", ran.stdout);
        }
    }
}

#[test]
fn bad_input_is_refused_in_one_line() {
    for (arguments, word) in [
        ("recovery --seeds 0", "--seeds"),
        ("recovery --seeds 100001", "--seeds"),
        ("recovery --seeds many", "many"),
        ("recovery --seed -1", "-1"),
        ("recovery --count some", "possible values: each, all"),
        ("recovery --noise loud", "possible values: output, echo"),
        (
            "recovery --rules none",
            "possible values: shipped, letter, coarse",
        ),
        ("recovery --sensors AB", "three or more"),
        ("recovery --sensors XYZ", "letters A to E"),
        ("recovery extra", "extra"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let ran = certainty(folder.path(), arguments);
        let line = ran.refusal();
        assert!(line.contains(word), "{arguments}: {line}");
        assert_eq!(
            fs::read_dir(folder.path()).unwrap().count(),
            0,
            "{arguments}"
        );
    }
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("taken"), "").unwrap();
    let ran = certainty(folder.path(), "recovery --seeds 1 --out taken");
    assert!(ran.refusal().contains("taken"));
}
