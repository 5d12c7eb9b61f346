//! `certainty drive`: the contract, the simulations of \[004\], and the effect of the diagnosis.

use crate::support::{command, shape};
use certainty_repro::drive_study::{Case, Study, Trial};
use certainty_sim::robot::drive::{Event, EventKind};
use certainty_sim::robot::{Course, Drive, HealthMode, MapSource, Memory, PilotConfig};
use certainty_tests::process::{Ran, run};
use core::time::Duration;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// The study has 342 drives; enough for a busy machine too.
const PATIENCE: Duration = Duration::from_secs(600);

/// Runs `certainty drive` with these arguments in `folder`.
fn drive(folder: &Path, arguments: &str) -> Ran {
    let all = format!("drive {arguments}");
    run(command(folder, all.split_whitespace()), PATIENCE)
}

fn document(arguments: &str) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let ran = drive(folder.path(), &format!("--json {arguments}"));
    assert_eq!(ran.code, Some(0), "{ran:?}");
    serde_json::from_str(&ran.stdout).unwrap()
}

fn whats(document: &Value) -> Vec<&str> {
    let events = document["events"].as_array().unwrap();
    events
        .iter()
        .map(|event| event["what"].as_str().unwrap())
        .collect()
}

#[test]
fn json_has_the_shape_of_its_snapshot() {
    let document = document("--health given");
    insta::assert_json_snapshot!("drive", shape(&document));
    assert_eq!(document["health_mode"], "given");
}

/// A world of the study could be neither driven nor seen.
#[test]
fn a_course_of_the_study_can_be_driven_and_seen() {
    let folder = tempfile::tempdir().unwrap();
    let ran = drive(folder.path(), "--world-seed 7003 --health given");
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert!(
        ran.stdout
            .contains("memory: diagnosed (not used by this robot)"),
        "{ran:?}"
    );
    assert!(folder.path().join("out/drive-track.png").exists());
    let other = document("--world-seed 7004");
    assert_eq!(other["memory"], true);
    let ran = drive(folder.path(), "--world-seed 1 --study");
    let refused = ran.refusal();
    assert!(refused.contains("--world-seed"), "{refused}");
}

#[test]
fn sound_sensors_reach_the_goal_of_the_built_in_course() {
    let document = document("");
    assert_eq!(document["reached"], true);
    assert_eq!(document["collisions"], 0);
    assert!(document["min_clearance_mm"].as_f64().unwrap() > 0.0);
    let time = document["time_s"].as_f64().unwrap();
    // 9.5 m at 1 m/s at the best, T_max at the worst.
    assert!((9.5..100.0).contains(&time), "{time}");
    assert!(document["s"].as_f64().unwrap() >= 9.4);
    assert_eq!(whats(&document).last(), Some(&"goal reached"));
}

#[test]
fn without_its_scanner_it_arrives_more_slowly() {
    let document = document("--fail scanner --health given");
    assert_eq!(document["reached"], true);
    let slows = "slows: too little ahead is seen by sensors that are believed";
    assert!(whats(&document).contains(&slows));
}

#[test]
fn with_every_sensor_failed_it_stops() {
    let all = "--fail FL --fail OL --fail SL --fail SR --fail OR --fail FR --fail scanner";
    let document = document(&format!("{all} --health given"));
    assert_eq!(document["reached"], false);
    assert_eq!(
        (&document["time_s"], &document["s"]),
        (&Value::Null, &Value::Null)
    );
    assert_eq!(
        (&document["v_M"], &document["collisions"]),
        (&0.0.into(), &0.into())
    );
    // 10 m away for 100 s: 10² · 100.
    assert_eq!(document["E"], 10_000.0);
}

#[test]
fn one_silent_sensor_does_not_stop_it() {
    for sensor in ["FL", "OL", "SL", "SR", "OR", "FR", "scanner"] {
        let document = document(&format!("--fail {sensor}"));
        let blind = "stops: far too little ahead is seen by sensors that are believed";
        assert!(!whats(&document).contains(&blind), "{sensor}");
        assert_eq!(document["reached"], true, "{sensor}");
    }
}

/// The diagnosis names the faulty sensor without a report of the fault.
#[test]
fn a_blind_scanner_is_diagnosed() {
    let faults = "--fault stuck-far:scanner@2s";
    let diagnosed = document(&format!("{faults} --health diagnosed"));
    assert!(
        whats(&diagnosed).contains(&"scanner: no longer believed"),
        "{diagnosed}"
    );
    let ignored = document(&format!("{faults} --health ignored"));
    assert!(!whats(&ignored).iter().any(|what| what.contains("believed")));
    let sound = document("--health diagnosed");
    assert!(
        !whats(&sound).iter().any(|what| what.contains("no longer")),
        "{sound}"
    );
}

#[test]
fn every_kind_of_map_reaches_the_goal() {
    for map in ["robust", "bayes", "trimmed", "median"] {
        let document = document(&format!("--map {map} --health given"));
        assert_eq!(document["reached"], true, "{map}");
    }
}

#[test]
fn the_seed_decides_the_run() {
    let run = |seed| document(&format!("--seed {seed}")).to_string();
    assert_eq!(run(5), run(5));
    assert_ne!(run(5), run(6));
}

#[test]
fn a_run_leaves_its_steps_and_its_charts() {
    let folder = tempfile::tempdir().unwrap();
    let ran = drive(folder.path(), "--out there --map robust");
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let there = folder.path().join("there");
    let csv = fs::read_to_string(there.join("drive.csv")).unwrap();
    assert!(csv.lines().count() > 190);
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().all(|line| line.split(',').count() == columns));
    for chart in ["drive-track", "drive-speeds", "drive-goal", "drive-angle"] {
        for kind in ["png", "svg"] {
            let file = there.join(format!("{chart}.{kind}"));
            assert!(fs::metadata(&file).unwrap().len() > 1000, "{file:?}");
        }
    }
}

#[test]
fn bad_input_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let inside = "[[box]]\ncenter = [\"0mm\", \"0mm\"]\nsize = [\"1m\", \"1m\"]\n";
    // Within the robot's half length of its middle, and not at its middle.
    let beside = "[[disc]]\ncenter = [\"500mm\", \"0mm\"]\nradius = \"100mm\"\n";
    for (file, text) in [
        ("inside.toml", inside),
        ("beside.toml", beside),
        ("ahead.toml", &beside.replace("500mm", "5m")),
        ("empty.toml", ""),
        ("nan.toml", &inside.replace("1m", "nan")),
        ("huge.toml", &inside.replace("1m", "1e300m")),
    ] {
        fs::write(folder.path().join(file), text).unwrap();
    }
    for (arguments, part) in [
        ("--fail XX", "expected one of FL, OL"),
        ("--fault stuck-far:XX", "--fault: no sensor 'XX'"),
        (
            "--fault none --fault stuck-far:FL",
            "--fault: none and a value",
        ),
        ("--fail FL --fail none", "--fail: none and a value"),
        ("--jobs 2", "expected --study"),
        ("--goal 300mm,-400mm", "within the goal radius of 500mm"),
        ("--goal 3m,0m", "the box or wall around 3000mm,-200mm"),
        ("--goal 60m,-81m", "100.8 m away"),
        (
            "--goal 5m,0m --world ahead.toml",
            "inside an obstacle of ahead.toml",
        ),
        ("--fault stuck", "names no sensor"),
        (
            "--health known",
            "possible values: given, diagnosed, ignored",
        ),
        ("--map grid", "possible values: beams, bayes"),
        (
            "--memory me",
            "possible values: nobody, diagnosed, everyone",
        ),
        ("--goal 10,0", "has no unit"),
        ("--world inside.toml", "inside.toml: the robot"),
        (
            "--world inside.toml",
            "inside an obstacle, the box or wall around 0mm,0mm",
        ),
        ("--world missing.toml", "missing.toml"),
        (
            "--world beside.toml",
            "inside an obstacle, the disc around 500mm,0mm",
        ),
        ("--world empty.toml", "the world has no obstacle"),
        ("--world nan.toml", "not a finite number"),
        ("--world huge.toml", "too large"),
        ("--goal nanm,0m", "not a finite number"),
        ("--goal 1e300m,0m", "too large"),
        ("--fault chatter:FL=4", "none can chatter"),
        ("--fault stuck-near:FL=90deg", "unknown unit 'deg'"),
        ("--study --worlds 0", "0 is not in 1..="),
        ("--out inside.toml", "cannot be created as a directory"),
        ("--goal-wgs84 0,0.0001", "--start-wgs84"),
        ("--start-wgs84 0,0", "--goal-wgs84"),
        ("--goal-wgs84 1,0 --start-wgs84 0,0 --goal 1m,0m", "--goal"),
        ("--goal-wgs84 1,0 --start-wgs84 0,0 --study", "--study"),
        ("--goal-wgs84 0 --start-wgs84 0,0", "latitude and longitude"),
        (
            "--goal-wgs84 0,x --start-wgs84 0,0",
            "latitude and longitude",
        ),
        (
            "--goal-wgs84 0,nan --start-wgs84 0,0",
            "latitude and longitude",
        ),
        (
            "--goal-wgs84 0,0 --start-wgs84 91,0",
            "not a place on the Earth",
        ),
        (
            "--goal-wgs84 0,181 --start-wgs84 0,0",
            "latitude and longitude",
        ),
        (
            "--goal-wgs84 0,0 --start-wgs84 0,0",
            "within the goal radius",
        ),
        ("--goal-wgs84 0,0.001 --start-wgs84 0,0", "111.2 m away"),
        (
            "--goal-wgs84 0,180 --start-wgs84 0,0",
            "km away: expected a nearer",
        ),
        (
            "--goal-wgs84 0,0.00002698 --start-wgs84 0,0",
            "inside an obstacle of the built-in course",
        ),
        ("--worlds 3", "--study"),
        ("--study --fail FL", "--study"),
        ("--study --bold", "--study"),
    ] {
        let ran = drive(folder.path(), arguments);
        assert_eq!(ran.code, Some(2), "{arguments}: {ran:?}");
        assert_eq!(ran.stdout, "", "{arguments}");
        assert_eq!(ran.stderr.lines().count(), 1, "{arguments}: {}", ran.stderr);
        assert!(ran.stderr.contains(part), "{arguments}: {}", ran.stderr);
    }
    assert!(!folder.path().join("out").exists());
}

#[test]
fn a_goal_just_within_the_limits_is_driven_to() {
    // One millimetre beyond the goal's radius, and at the farthest place.
    let near = document("--goal 501mm,0m");
    assert_eq!(near["reached"], true);
    let far = document("--goal=-100500mm,0m --fail scanner --fail FL --fail FR --health given");
    assert_eq!(far["reached"], false);
}

/// By hand: 899 · 10⁻⁷ degrees of the equator are 9.996 m, those of a meridian too; eq. 10 of \[004\] has the
/// directions.
#[test]
fn a_goal_in_wgs84_is_the_goal_in_the_world() {
    let same = |coordinates: &str, goal: &str| {
        let wgs84 = document(&format!("{coordinates} --seed 3"));
        assert_eq!(wgs84, document(&format!("--goal={goal} --seed 3")));
    };
    same("--goal-wgs84 0,0.0000899 --start-wgs84 0,0", "9996mm,0mm");
    same(
        "--goal-wgs84=-33.0000899,151 --start-wgs84=-33,151",
        "0mm,-9996mm",
    );
}

#[test]
fn none_is_the_same_as_no_option() {
    let plain = document("");
    assert_eq!(document("--fault none"), plain);
    assert_eq!(document("--fail none --fault none"), plain);
}

#[test]
fn the_report_has_options_and_sources_of_events() {
    let folder = tempfile::tempdir().unwrap();
    let ran = drive(
        folder.path(),
        "--fault stuck-far:scanner@2s --bold --blame own",
    );
    assert_eq!(ran.code, Some(0), "{ran:?}");
    for part in [
        "goal: 10000mm,0mm",
        "faults: stuck-far:scanner@2000ms",
        "memory: diagnosed   blame: own   obstacles from: beams   bold",
        "   2.00 s  truth  scanner: fault began",
        " s  robot  scanner: no longer believed",
        "T, time to the goal",
        "v_M, mean speed",
        " m/s",
    ] {
        assert!(ran.stdout.contains(part), "no {part} in {}", ran.stdout);
    }
    let clearance = ran
        .stdout
        .lines()
        .find(|line| line.starts_with("least clearance"));
    let clearance = clearance.unwrap().split_whitespace().nth(2).unwrap();
    assert!(
        clearance.parse::<u32>().is_ok(),
        "whole millimetres: {clearance}"
    );
}

#[test]
fn names_of_worlds_and_folders_are_escaped() {
    let folder = tempfile::tempdir().unwrap();
    let world = "name = \"\\u001b[2Jred\"\n[[disc]]\ncenter = [\"5m\", \"9m\"]\nradius = \"1m\"\n";
    fs::write(folder.path().join("world.toml"), world).unwrap();
    let ran = drive(
        folder.path(),
        "--world world.toml --goal 1m,0m --out a\u{1b}[2J",
    );
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let control = |c: char| c.is_control() && c != '\n';
    assert!(!ran.stdout.contains(control), "{:?}", ran.stdout);
    assert!(
        ran.stdout.contains("world: \\u{1b}[2Jred"),
        "{}",
        ran.stdout
    );
    assert!(
        ran.stdout.contains("charts in a\\u{1b}[2J"),
        "{}",
        ran.stdout
    );
    // The same in an error.
    let ran = drive(folder.path(), "--world b\u{1b}[2J");
    assert!(!ran.refusal().contains(control), "{:?}", ran.stderr);
}

#[test]
fn the_study_has_every_case() {
    let folder = tempfile::tempdir().unwrap();
    let ran = drive(folder.path(), "--study --worlds 1 --seed 2 --json");
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let csv = fs::read_to_string(folder.path().join("out/study.csv")).unwrap();
    let report: Value = serde_json::from_str(&ran.stdout).unwrap();
    insta::assert_json_snapshot!("drive-study", shape(&report));
    assert_eq!(report["memory"], "diagnosed");
    assert_eq!(report["simulations"].as_array().unwrap().len(), 6);
    // Singles and pairs of four kinds and of all, by three modes.
    assert_eq!(report["failures"].as_array().unwrap().len(), 2 * 5 * 3);
    // 6 simulations, 28 sets of sensors by four kinds and three modes, and the header.
    assert_eq!(csv.lines().count(), 6 + 28 * 4 * 3 + 1);
}

/// The trials of a case, in worlds that no parameter was chosen on.
fn trials(case: &Case, memory: Memory, worlds: u32) -> Vec<Trial> {
    let study = Study {
        seed: 7001,
        worlds,
        map: MapSource::Beams,
        pilot: PilotConfig {
            memory,
            ..PilotConfig::default()
        },
    };
    study.drive(case).unwrap()
}

fn mean(trials: &[Trial], value: impl Fn(&Trial) -> f64) -> f64 {
    trials.iter().map(value).sum::<f64>() / trials.len() as f64
}

/// \[004\] §4: the goal is reached; without FL E is worse and the robot slower; without the scanner it
/// still gets there in most worlds.
#[test]
fn the_simulations_come_out_as_the_paper_says() {
    let driven = Study::simulations().unwrap();
    let driven: Vec<Vec<Trial>> = driven[..3]
        .iter()
        .map(|case| trials(case, Memory::Nobody, 16))
        .collect();
    let [sound, without_fl, without_scanner] = &driven[..] else {
        panic!("three simulations");
    };
    let reached = |trials: &[Trial]| mean(trials, |trial| f64::from(u8::from(trial.reached)));
    assert!(reached(sound) >= 0.85, "{}", reached(sound));
    assert!(
        reached(without_scanner) > 0.5,
        "{}",
        reached(without_scanner)
    );
    let error = |trials: &[Trial]| mean(trials, |trial| trial.error);
    assert!(error(without_fl) > error(sound));
    let speed = |trials: &[Trial]| mean(trials, |trial| trial.mean_speed);
    assert!(speed(without_fl) < speed(sound));
    assert!(speed(without_scanner) < speed(sound));
}

/// Collisions and reached goals over all trials of some cases.
#[derive(Debug)]
struct Totals {
    touched: u32,
    reached: u32,
    runs: u32,
}

fn totals(memory: Memory, worlds: u32, of: impl Fn(&Case) -> bool) -> Totals {
    let cases = Study::failures().unwrap();
    let all = cases.iter().filter(|case| of(case));
    let all = all.flat_map(|case| trials(case, memory, worlds));
    let none = Totals {
        touched: 0,
        reached: 0,
        runs: 0,
    };
    all.fold(none, |totals, trial| Totals {
        touched: totals.touched + trial.collisions,
        reached: totals.reached + u32::from(trial.reached),
        runs: totals.runs + 1,
    })
}

/// Every failure and every pair of a kind, this system against \[004\]'s: with a diagnosis the robot has a
/// memory, with given or ignored health it has the current readings alone.
///
/// Stuck far is the most dangerous kind, because *no object* stops no robot.
#[test]
fn diagnosis_collides_like_given_health_or_less() {
    for kind in ["stuck-far", "stuck-near"] {
        let driven = |health| {
            let of = |case: &Case| case.name == kind && case.health == health;
            totals(Memory::Diagnosed, 2, of)
        };
        let diagnosed = driven(HealthMode::Diagnosed);
        let given = driven(HealthMode::Given);
        let ignored = driven(HealthMode::Ignored);
        let all = format!("{kind}: {diagnosed:?} {given:?} {ignored:?}");
        assert!(10 * diagnosed.touched <= 11 * given.touched, "{all}");
        assert!(2 * diagnosed.touched <= ignored.touched, "{all}");
        assert!(diagnosed.reached > given.reached, "{all}");
        assert!(diagnosed.reached > ignored.reached, "{all}");
    }
}

/// Every single failure, with the same memory in both modes, so that only the diagnosis differs.
#[test]
fn with_equal_memory_a_diagnosing_robot_arrives_more() {
    let driven = |health| {
        let of = |case: &Case| case.failing == 1 && case.health == health && case.name != "random";
        totals(Memory::Everyone, 2, of)
    };
    let (diagnosed, ignored) = (driven(HealthMode::Diagnosed), driven(HealthMode::Ignored));
    assert_eq!(diagnosed.runs, 7 * 3 * 2);
    assert!(
        10 * diagnosed.reached >= 9 * diagnosed.runs,
        "{diagnosed:?}"
    );
    assert!(2 * ignored.reached <= ignored.runs, "{ignored:?}");
    assert!(
        2 * diagnosed.touched <= ignored.touched,
        "{diagnosed:?} {ignored:?}"
    );
}

#[test]
fn a_sensor_that_recovers_is_trusted_again() {
    for fault in ["stuck-near:SL=250mm@2s..4s", "random:FR@2s..4s"] {
        let document = document(&format!("--fault {fault}"));
        let events = whats(&document);
        let last = |end| events.iter().rposition(|what| what.ends_with(end));
        let (lost, back) = (last("no longer believed"), last("believed again"));
        assert!(lost.is_some() && lost < back, "{fault}: {events:?}");
        assert_eq!(document["reached"], true, "{fault}");
    }
}

/// A stuck distance below the sensor's range, or with the noise of a sound sensor.
#[test]
fn a_sensor_stuck_near_fails_at_any_distance() {
    for faults in [
        "--fault stuck-near:FL=0mm@2s",
        "--fault stuck-near:scanner=0mm@2s",
        "--fault stuck-near:OL=250mm@2s --fault noise:OL=1%@2s",
        "--fault stuck-near:scanner=250mm@2s --fault noise:scanner=1%@2s",
    ] {
        let document = document(faults);
        assert_eq!(document["reached"], true, "{faults}: {document}");
        assert_eq!(document["collisions"], 0, "{faults}");
        let sensor = faults["--fault stuck-near:".len()..]
            .split('=')
            .next()
            .unwrap();
        let named = format!("{sensor}: no longer believed");
        assert!(whats(&document).contains(&named.as_str()), "{faults}");
    }
}

/// False diagnoses are allowed in some of the random courses, where obstacles are close.
#[test]
fn sound_sensors_are_rarely_diagnosed_as_failed() {
    let mut false_alarms = 0;
    for seed in 7001..=7020 {
        let drive = Drive {
            course: Course::random(seed).unwrap(),
            faults: Vec::new(),
            health: HealthMode::Diagnosed,
            map: MapSource::Beams,
            pilot: PilotConfig::default(),
            seed,
        };
        let outcome = drive.run().unwrap();
        let is_diagnosis = |event: &Event| matches!(event.what, EventKind::Distrusted(_));
        false_alarms += u32::from(outcome.events.iter().any(is_diagnosis));
    }
    assert!(false_alarms <= 6, "{false_alarms} of 20");
}
