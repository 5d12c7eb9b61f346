//! `certainty run`: the same application, bit for bit, on every backend and with every fault.

use crate::support::{certainty, shape};
use certainty_tests::firmware;
use certainty_tests::process::PATIENCE;
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Rounds of most runs: a third of a sweep, and more than the ten missing readings that make a failure.
const ROUNDS: u32 = 12;

/// Rounds of a run under QEMU too, which is the slowest.
const SHORT: u32 = 8;

/// Faults of a GP2D02's line, and the reasons of its missing readings.
const LINE_FAULTS: [(&str, &[&str]); 6] = [
    ("line-high", &["bus"]),
    ("line-low", &["bus"]),
    ("line-floating", &["bus"]),
    // Unplugged, its line is low before the conversion too.
    ("unplugged", &["timeout", "bus"]),
    ("cut-short", &["bus"]),
    ("mute", &["timeout"]),
];

/// Rounds of a run in which it drives, after 37 in which it looks around; few enough for QEMU.
const DRIVING: u32 = 42;

/// Rounds after which it has reached its goal in the built-in scene.
const ARRIVED: u32 = 90;

/// Runs the application on `backend` in a folder of its own; `None` if the backend cannot be had.
fn on(backend: &str, rounds: u32, faults: &str) -> Option<Value> {
    let folder = tempfile::tempdir().unwrap();
    let image = match backend {
        "native" => String::new(),
        "qemu" if !firmware::qemu_is_installed() => return None,
        "qemu" => format!(" --image {}", firmware::image("qemu")?.display()),
        _ => format!(" --image {}", firmware::image("smart_car")?.display()),
    };
    let arguments = format!("run --json --on {backend} --rounds {rounds}{image} {faults}");
    Some(certainty(folder.path(), &arguments).json())
}

/// Returns the fields that must be the same on every backend.
fn outcome(mut document: Value) -> Value {
    let fields = document.as_object_mut().unwrap();
    for own in [
        "backend",
        "flash_bytes",
        "static_ram_bytes",
        "stack_bytes",
        "files",
    ] {
        fields.remove(own).unwrap();
    }
    document
}

fn sensor(document: &Value, number: usize) -> &Value {
    &document["sensors"][number - 1]
}

#[test]
fn json_has_the_shape_of_its_snapshot() {
    let document = on("native", 1, "").unwrap();
    insta::assert_json_snapshot!("run", shape(&document));
    assert_eq!(document["readings"], 5, "one reading per sensor and round");
    assert_eq!(document["drive"]["conduct"], "looking around");
    assert_eq!(document["drive"]["rounds_moved"], 0);
    assert_eq!(document["sensors"].as_array().unwrap().len(), 5);
}

#[test]
fn every_backend_has_the_same_map_and_health() {
    for faults in [
        "",
        "--fault stuck-far:2 --seed 7",
        "--fault unplugged:1@3..6 --fault mute:5@4s..7s --fault noise:3=20%",
    ] {
        let native = outcome(on("native", SHORT, faults).unwrap());
        assert_eq!(native["overruns"], 0, "{faults}");
        assert_ne!(native["grid_hash"], Value::Null);
        for backend in ["qemu", "board"] {
            if let Some(document) = on(backend, SHORT, faults) {
                assert_eq!(outcome(document), native, "{backend} {faults}");
            }
        }
    }
}

fn track_hash(document: &Value) -> &Value {
    let hash = &document["drive"]["track_hash"];
    assert_eq!(hash.as_str().map(str::len), Some(8));
    hash
}

/// Asserts the same track, wheel commands and readings on `backends` as on native, bit for bit.
fn assert_the_same_way(faults: &str, backends: &[&str]) {
    let native = outcome(on("native", DRIVING, faults).unwrap());
    assert_ne!(native["drive"]["rounds_moved"], 0, "{faults}");
    assert_eq!(native["overruns"], 0, "{faults}");
    track_hash(&native);
    for backend in backends {
        if let Some(document) = on(backend, DRIVING, faults) {
            assert_eq!(outcome(document), native, "{backend} {faults}");
        }
    }
}

#[test]
fn every_backend_drives_the_same_way() {
    assert_the_same_way("", &["qemu", "board"]);
}

#[test]
#[ignore = "a minute; tests/claims runs it"]
fn every_backend_drives_the_same_way_with_faults() {
    for faults in [
        "--fault stuck-far:2 --seed 7",
        "--fault unplugged:1@39..45",
        "--fault motor-dead:left@41 --fault slip:right=20%",
        "--fault motor-weak:right=90%@30s..32s",
    ] {
        assert_the_same_way(faults, &["board"]);
    }
}

#[test]
fn the_board_drives_to_the_goal_like_the_native_run() {
    let native = outcome(on("native", ARRIVED, "").unwrap());
    assert_eq!(native["drive"]["reached"], true, "{}", native["drive"]);
    assert_eq!(native["drive"]["conduct"], "arrived");
    assert_eq!(native["drive"]["collisions"], 0);
    let truly = &native["drive"]["truly"]["to_goal_mm"];
    assert!(truly.as_u64() <= native["drive"]["goal_radius_mm"].as_u64());
    if let Some(board) = on("board", ARRIVED, "") {
        assert_eq!(outcome(board), native);
    }
}

/// Without slip, dead reckoning from the motor commands is exact but for rounding.
#[test]
fn without_slip_odometry_errs_by_at_most_a_centimetre() {
    let drive = &on("native", ARRIVED, "").unwrap()["drive"];
    for axis in ["x_mm", "y_mm"] {
        let (estimated, truly) = (&drive["believed"][axis], &drive["truly"][axis]);
        let off = estimated.as_i64().unwrap() - truly.as_i64().unwrap();
        assert!(off.abs() < 10, "{drive}");
    }
}

#[test]
fn it_stops_when_all_its_sensors_are_unplugged() {
    let all = (1..=5).map(|sensor| format!("--fault unplugged:{sensor}@40"));
    let all = all.collect::<Vec<_>>().join(" ");
    let soon = on("native", 44, &all).unwrap();
    let late = on("native", 60, &all).unwrap();
    assert_eq!(late["drive"]["conduct"], "blind");
    assert_ne!(late["drive"]["rounds_moved"], 0, "it drove before");
    assert_eq!(late["drive"]["truly"], soon["drive"]["truly"]);
    assert_eq!(late["drive"]["collisions"], 0);
    let sighted = on("native", 60, "").unwrap();
    assert_ne!(sighted["drive"]["truly"], late["drive"]["truly"]);
}

#[test]
fn it_never_touches_a_wall_across_its_path() {
    let folder = tempfile::tempdir().unwrap();
    for y in [350, 450, 600] {
        let file = folder.path().join(format!("wall-{y}.toml"));
        let wall = format!(
            "name = \"a wall across\"\n[[box]]\ncenter = [\"0mm\", \"{y}mm\"]\nsize = [\"3m\", \"100mm\"]\n"
        );
        std::fs::write(&file, wall).unwrap();
        for seed in 1..=4 {
            let arguments = format!("--seed {seed} --world {}", file.display());
            let drive = &on("native", 150, &arguments).unwrap()["drive"];
            assert_eq!(drive["collisions"], 0, "{y}: {drive}");
            assert_eq!(drive["reached"], false, "{y}: {drive}");
            assert_ne!(drive["rounds_moved"], 0, "{y}: {drive}");
        }
    }
}

/// Between a wall ahead and one behind it backs over the lower edge of its grid, beyond which its map has nothing.
///
/// It took the nothing for room and went on: with sound sensors for ever, and with both rangers mute into a wall with each
/// of these seeds.
#[test]
fn outside_its_grid_it_stops_without_collision() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("walls.toml");
    let walls = "name = \"wall ahead, wall behind\"\n\
                 [[box]]\ncenter = [\"0mm\", \"350mm\"]\nsize = [\"3m\", \"100mm\"]\n\
                 [[box]]\ncenter = [\"0mm\", \"-400mm\"]\nsize = [\"3m\", \"100mm\"]\n";
    std::fs::write(&file, walls).unwrap();
    for faults in ["", "--fault mute:4 --fault mute:5"] {
        for seed in [2, 5, 6, 7] {
            let arguments = format!("--seed {seed} --world {} {faults}", file.display());
            let drive = &on("native", 150, &arguments).unwrap()["drive"];
            assert_eq!(drive["collisions"], 0, "{arguments}: {drive}");
            assert_eq!(drive["conduct"], "blind", "{arguments}: {drive}");
            assert_ne!(drive["rounds_moved"], 0, "{arguments}: {drive}");
        }
    }
}

/// Too near in every direction was a healthy, fully believed head: with all three stuck at 50 mm the car drove on
/// an empty map and arrived; with mute rangers it touched the block.
#[test]
fn heads_that_are_always_too_near_fail_and_the_car_stands() {
    let heads = [1, 2, 3].map(|head| format!("--fault stuck-near:{head}=50mm"));
    for rangers in ["", "--fault mute:4 --fault mute:5"] {
        let faults = format!("{} {rangers}", heads.join(" "));
        let document = on("native", ARRIVED, &faults).unwrap();
        let drive = &document["drive"];
        assert_eq!(drive["conduct"], "blind", "{faults}: {drive}");
        assert_eq!(drive["rounds_moved"], 0, "{faults}: {drive}");
        for sensor in 0..3 {
            assert_eq!(
                document["sensors"][sensor]["status"], "failed",
                "{document}"
            );
        }
    }
}

#[test]
fn only_a_car_that_moved_has_a_track_picture() {
    for (rounds, count) in [(37, 1), (DRIVING, 3)] {
        let document = on("native", rounds, "").unwrap();
        let files = document["files"].as_array().unwrap();
        assert_eq!(files.len(), count, "{files:?}");
    }
}

/// What the other sensors make of the world must not depend on how one of them is broken, and every
/// backend must say why it is.
fn line_faults_are_missing_readings(backend: &str) {
    let mut maps = Vec::new();
    for (fault, reasons) in LINE_FAULTS {
        let Some(broken) = on(backend, ROUNDS, &format!("--fault {fault}:2")) else {
            return;
        };
        let bad = sensor(&broken, 2);
        assert_eq!(bad["missing"], ROUNDS, "{fault}");
        assert_eq!(bad["readings"], 0, "{fault}");
        assert_eq!(bad["status"], "failed", "{fault}");
        for (reason, count) in bad["missing_because"].as_object().unwrap() {
            let expected = reasons.contains(&reason.as_str());
            assert_eq!(count.as_u64() > Some(0), expected, "{fault}: {reason}");
        }
        for sound in [1, 3, 4, 5] {
            assert_eq!(sensor(&broken, sound)["missing"], 0, "{fault}");
            assert_eq!(sensor(&broken, sound)["status"], "healthy", "{fault}");
        }
        assert_eq!(broken["overruns"], 0, "{fault}: the schedule stays on time");
        maps.push(broken["grid_hash"].clone());
    }
    let sound = on(backend, ROUNDS, "").unwrap();
    assert!(maps.iter().all(|map| *map == maps[0]), "{maps:?}");
    assert_ne!(maps[0], sound["grid_hash"], "sensor 2 matters");
}

#[test]
fn line_faults_are_missing_readings_natively() {
    line_faults_are_missing_readings("native");
}

#[test]
fn line_faults_are_missing_readings_on_the_board() {
    line_faults_are_missing_readings("board");
}

/// Ten missing readings make a sensor fail, ten that came make it healthy again.
fn sensors_recover_after_the_fault(backend: &str) {
    for (fault, _) in LINE_FAULTS {
        let faulty = format!("--fault {fault}:2@3..14");
        let Some(ill) = on(backend, 14, &faulty) else {
            return;
        };
        assert_eq!(sensor(&ill, 2)["status"], "failed", "{fault}");
        let healed = on(backend, 30, &faulty).unwrap();
        assert_eq!(sensor(&healed, 2)["status"], "healthy", "{fault}");
        // A sensor that comes back needs a moment of its own: one more may be missing.
        let missing = sensor(&healed, 2)["missing"].as_u64().unwrap();
        assert!((11..=12).contains(&missing), "{fault}: {missing} missing");
        assert_eq!(healed["overruns"], 0);
    }
}

#[test]
fn sensors_recover_after_the_fault_natively() {
    sensors_recover_after_the_fault("native");
}

#[test]
fn sensors_recover_after_the_fault_on_the_board() {
    sensors_recover_after_the_fault("board");
}

#[test]
fn readings_are_missing_while_a_servo_fails() {
    for backend in ["native", "qemu"] {
        let Some(off) = on(backend, SHORT, "--fault servo-off:3@2..6") else {
            continue;
        };
        let bad = sensor(&off, 3);
        assert_eq!(bad["missing"], 4, "{backend}");
        assert_eq!(bad["missing_because"]["bus"], 4, "{backend}");
        assert_eq!(bad["readings"], 4, "{backend}");
        assert_eq!(off["overruns"], 0);
    }
}

#[test]
fn a_ranger_without_answer_fails_alone_and_recovers() {
    for backend in ["native", "board"] {
        let Some(sound) = on(backend, 30, "") else {
            continue;
        };
        let mute = on(backend, 14, "--fault mute:4@3..14").unwrap();
        assert_eq!(sensor(&mute, 4)["status"], "failed", "{backend}");
        assert_eq!(sensor(&mute, 4)["missing_because"]["timeout"], 11);
        let healed = on(backend, 30, "--fault mute:4@3..14").unwrap();
        assert_eq!(sensor(&healed, 4)["status"], "healthy", "{backend}");
        assert_eq!(sensor(&healed, 4)["missing"], 11, "{backend}");
        assert_eq!(healed["grid_hash"], sound["grid_hash"], "{backend}");
        assert_eq!(healed["overruns"], 0);
    }
}

/// The same for both motors, and if the motor recovers: the distance since the last pulse is unknown.
#[test]
fn a_motor_error_of_a_moving_car_stops_it_for_good() {
    for motor in ["right", "left"] {
        for (window, conduct) in [("40", "motor refused"), ("40..42", "lost")] {
            let faults = format!("--fault motor-off:{motor}@{window}");
            let drive = &on("native", ARRIVED, &faults).unwrap()["drive"];
            assert_eq!(drive["conduct"], conduct, "{faults}");
            assert_ne!(drive["rounds_moved"], 0, "{faults}");
            // Its estimate stays where it stopped.
            let earlier = &on("native", 44, &faults).unwrap()["drive"];
            assert_eq!(drive["believed"], earlier["believed"], "{faults}");
            if conduct == "lost" {
                assert_eq!(drive["truly"], earlier["truly"], "{faults}");
            }
        }
    }
}

#[test]
fn a_motor_error_is_reported_by_the_microcontroller() {
    let fault = "--fault motor-off:left@3";
    let native = outcome(on("native", SHORT, fault).unwrap());
    assert_eq!(native["drive"]["conduct"], "motor refused");
    if let Some(qemu) = on("qemu", SHORT, fault) {
        assert_eq!(outcome(qemu), native);
    }
}

/// With a failed motor from the start no wheel turns; after it recovers the car drives.
#[test]
fn a_motor_error_of_a_stopped_car_costs_only_time() {
    let off = on("native", ARRIVED, "--fault motor-off:left").unwrap();
    assert_eq!(off["drive"]["conduct"], "motor refused");
    assert_eq!(off["drive"]["rounds_moved"], 0);
    let back = on("native", ARRIVED, "--fault motor-off:left@0..20").unwrap();
    assert_eq!(back["drive"]["reached"], true, "{}", back["drive"]);
}

/// What docs/measurements promise: 4 KB of RAM with the stack, 31 KB of flash.
#[test]
fn the_shipped_image_keeps_its_budgets() {
    // Its stack is deepest in the slot *steer*.
    let Some(board) = on("board", ARRIVED, "") else {
        return;
    };
    let bytes = |field: &str| board[field].as_u64().unwrap();
    let (flash, ram, stack) = (
        bytes("flash_bytes"),
        bytes("static_ram_bytes"),
        bytes("stack_bytes"),
    );
    assert!(flash <= 31_404, "{flash} bytes of flash");
    assert!(ram + stack <= 4096, "{ram} + {stack} bytes of RAM");
    assert!(stack > 200, "a stack of {stack} bytes was not measured");
    assert!(flash > 4096, "an image of {flash} bytes is not complete");
}

#[test]
fn bad_input_is_one_line_and_exit_code_2() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("empty"), "").unwrap();
    std::fs::write(at.join("text"), "no image\n").unwrap();
    let on_the_car = "[[disc]]\ncenter = [\"0mm\", \"100mm\"]\nradius = \"50mm\"\n";
    std::fs::write(at.join("on.toml"), on_the_car).unwrap();
    for (arguments, part) in [
        ("run --on mars", "native, qemu, board"),
        ("run --rounds 0", "--rounds"),
        ("run --rounds 99999999", "--rounds"),
        ("run --fault line-high", "names no sensor"),
        ("run --fault line-hig:1", "line-floating"),
        ("run --fault line-high:9", "--fault: no sensor '9'"),
        (
            "run --fault none --fault line-high:1",
            "--fault: none and a value",
        ),
        ("run --image text", "the native backend runs no image"),
        ("run --fault chatter:2=4", "one turn a round"),
        ("run --fault stuck-far:4", "line faults only"),
        ("run --fault servo-jammed:5", "no servo"),
        ("run --on qemu --image missing", "cargo firmware"),
        ("run --on qemu --image empty", "cargo firmware"),
        ("run --on board --image text", "cargo firmware"),
        ("run --on board --image .", "cargo firmware"),
        ("run --on board --fault servo-off:1", "servo-off"),
        ("run --on board --fault motor-off:left", "motor-off"),
        ("run --fault motor-dead:middle", "right or left"),
        ("run --fault motor-dead", "names no sensor"),
        ("run --fault motor-off:left=3", "takes no value"),
        ("run --fault motor-weak:left=fast", "motor-weak:left=95%"),
        ("run --fault slip:right=120%", "slip:right=20%"),
        ("run --fault slip:right@9..3", "is empty"),
        ("run --world missing.toml", "missing.toml"),
        ("run --world on.toml", "on.toml: the car"),
        (
            "run --world on.toml",
            "the disc around 0mm,100mm: expected free space",
        ),
        ("run --rounds 1 --out text", "text"),
    ] {
        let ran = certainty(at, arguments);
        assert_eq!(ran.code, Some(2), "{arguments}: {ran:?}");
        assert_eq!(
            ran.stderr.trim_end().lines().count(),
            1,
            "{arguments}: {ran:?}"
        );
        assert!(ran.stderr.contains(part), "{arguments}: {}", ran.stderr);
        assert_eq!(ran.stdout, "", "{arguments}");
    }
}

/// Such an image was read until the memory was full.
#[cfg(target_os = "linux")]
#[test]
fn an_image_without_end_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let ran = certainty(folder.path(), "run --on board --image /dev/zero");
    let line = ran.refusal();
    assert!(
        line.contains("/dev/zero") && line.contains("over 64 MiB"),
        "{line}"
    );
}

#[test]
fn another_backends_image_is_refused_with_its_name() {
    let Some(image) = firmware::image("qemu") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let arguments = format!("run --on board --image {}", image.display());
    let ran = certainty(folder.path(), &arguments);
    let line = ran.refusal();
    assert!(line.contains(image.to_str().unwrap()), "{line}");
    assert!(
        line.contains("--on board expects the image named smart_car"),
        "{line}"
    );
}

#[test]
fn without_qemu_the_error_says_how_to_install_it() {
    let Some(image) = firmware::image("qemu") else {
        return;
    };
    let ran = Command::new(env!("CARGO_BIN_EXE_certainty"))
        .args(["run", "--on", "qemu", "--image"])
        .arg(image)
        .current_dir(tempfile::tempdir().unwrap().path())
        .env("PATH", Path::new("/nowhere"))
        .output()
        .unwrap();
    let line = String::from_utf8(ran.stderr).unwrap();
    assert_eq!(ran.status.code(), Some(2), "{line}");
    assert_eq!(line.lines().count(), 1, "{line}");
    assert!(line.contains("apt-get install qemu-system-arm"), "{line}");
    const { assert!(PATIENCE.as_secs() > 30) }
}
