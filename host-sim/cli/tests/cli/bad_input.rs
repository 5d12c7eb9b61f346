//! Bad input ends in one line and exit code 2.

use crate::support::{
    BEAMS, PLACE, Place, QUICKLY, all_around, certainty_quickly, command, flaser, folder_with,
    gzip, scan,
};
use certainty_sim::replay::HEADER;
use certainty_tests::process::run;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

fn good_log() -> String {
    let scans = all_around(0.5, 0.5).into_iter().zip(0_u8..);
    scans
        .map(|(place, number)| flaser(&[2.0; BEAMS], place, number.into()))
        .collect()
}

/// Bytes without a pattern, which gzip cannot compress.
fn noise(count: u32) -> Vec<u8> {
    let dice = |number: u32| number.wrapping_mul(0x9E37_79B9).rotate_left(11) ^ number;
    (0..count).map(|n| dice(dice(n)).to_le_bytes()[1]).collect()
}

/// Asserts that no file was written, not even a temporary one.
fn assert_no_results(folder: &Path, what: &str) {
    let left = |path: &Path| -> Vec<_> {
        let entries = fs::read_dir(path).into_iter().flatten();
        entries.map(|entry| entry.unwrap().path()).collect()
    };
    assert_eq!(left(&folder.join("out")), [""; 0].map(Path::new), "{what}");
}

/// Asserts that `arguments` are refused in one line with every one of `words`.
fn assert_refused(folder: &TempDir, arguments: &str, words: &[&str]) {
    let ran = certainty_quickly(folder.path(), arguments);
    let line = ran.refusal();
    for word in words {
        assert!(line.contains(word), "{arguments}: no {word} in {line:?}");
    }
    assert_no_results(folder.path(), arguments);
}

/// Options that change nothing were taken without a word.
#[test]
fn an_option_without_effect_is_refused() {
    let folder = folder_with("t_ms,sensor,x_mm,y_mm,bearing_mdeg,reading\n0,1,0,0,0,500\n");
    for (arguments, named) in [
        ("replay input --trim 1", "--fusion trimmed"),
        ("replay input --fusion trimmed --trim 1", "at most 0"),
        ("replay input --fov 180deg", "--fov"),
        ("replay input --start-angle 0deg", "--start-angle"),
        ("simulate --fusion bayes --trim 1", "--fusion trimmed"),
        ("simulate --trim 2", "at most 1"),
    ] {
        let ran = certainty_quickly(folder.path(), arguments);
        assert!(ran.refusal().contains(named), "{arguments}: {ran:?}");
    }
}

#[test]
fn an_unusable_recording_is_refused_with_its_name() {
    let truncated = {
        let mut whole = gzip(scan(2.0).as_bytes());
        whole.truncate(30);
        whole
    };
    let corrupt = {
        let mut whole = gzip(good_log().as_bytes());
        let middle = whole.len() / 2;
        whole[middle..middle + 8].fill(0xFF);
        whole
    };
    let header = |lines: &str| format!("{HEADER}\n{lines}").into_bytes();
    let cut = good_log().lines().next().unwrap()[..300].to_owned();
    let cases: [(&str, Vec<u8>, &[&str]); 16] = [
        ("an empty file", vec![], &["is empty"]),
        ("an empty gzip", gzip(b""), &["is empty"]),
        ("binary junk", noise(5000), &["is not text"]),
        ("zeros", vec![0; 5000], &["is not text"]),
        ("packed junk", gzip(&noise(5000)), &["is not text"]),
        (
            "a letter",
            b"Dear all,\nhello\n".to_vec(),
            &["no line of its start"],
        ),
        ("a cut gzip", truncated, &["gzip data are damaged"]),
        ("a corrupt gzip", corrupt, &["gzip data are damaged"]),
        (
            "a gzip header alone",
            vec![0x1F, 0x8B],
            &["gzip data are damaged"],
        ),
        ("only the header", header(""), &["no beam in it"]),
        (
            "odometry only",
            b"ODOM 0 0 0 0 0 0 0.1 h 0.1\n".to_vec(),
            &["no beam in it"],
        ),
        (
            "a scan cut",
            cut.into_bytes(),
            &["input:1:", "wrong number of fields"],
        ),
        (
            "10^9 beams announced",
            scan(1.0)
                .replacen("FLASER 180", "FLASER 1000000000", 1)
                .into_bytes(),
            &["input:1:", "wrong number of fields"],
        ),
        (
            "2^64 beams announced",
            scan(1.0)
                .replacen("FLASER 180", "FLASER 18446744073709551616", 1)
                .into_bytes(),
            &["input:1:", "not a number"],
        ),
        (
            "10^9 beams announced by ROBOTLASER1",
            b"ROBOTLASER1 0 -1.5 3 0.1 8 0.01 0 1000000000 1 2 3 0 0 0 0 0 0 0 0 0 0 0 0 1 h 1\n"
                .to_vec(),
            &["input:1:", "wrong number of fields"],
        ),
        (
            "a line without end",
            [b"FLASER 180".to_vec(), vec![b' '; 3 << 20]].concat(),
            &["input:1:", "line too long"],
        ),
    ];
    for (what, content, words) in cases {
        let folder = folder_with(content);
        let words: Vec<&str> = ["input"].iter().chain(words).copied().collect();
        for json in ["", " --json"] {
            eprintln!("{what}"); // names the case where one fails
            assert_refused(&folder, &format!("replay input{json}"), &words);
        }
    }
}

#[test]
fn paths_that_are_no_files_are_refused() {
    let folder = folder_with(good_log());
    assert_refused(
        &folder,
        "replay missing.log",
        &["missing.log", "cannot be opened"],
    );
    assert_refused(
        &folder,
        "replay input/below",
        &["input/below", "cannot be opened"],
    );
    assert_refused(
        &folder,
        "compare missing.yaml missing.yaml",
        &["missing.yaml", "cannot be read"],
    );
    assert_refused(&folder, "compare input input", &["input:1"]);
    assert_refused(
        &folder,
        "simulate --world missing.toml",
        &["missing.toml", "cannot read"],
    );
}

#[test]
fn a_directory_in_place_of_a_file_has_one_wording() {
    let folder = folder_with(good_log());
    fs::create_dir(folder.path().join("directory")).unwrap();
    for (arguments, expected) in [
        ("replay directory", "a recording"),
        ("simulate --world directory", "a world file"),
        ("run --world directory", "a world file"),
        ("drive --world directory", "a world file"),
        ("ring --world directory", "a world file"),
        ("ring --recording directory", "a recording"),
        ("compare directory input", "a map's YAML file"),
        ("calibrate directory", "a table of measured points"),
        ("monitor directory", "a serial port, a file or a pipe"),
        (
            "run --on qemu --image directory",
            "an image that `cargo firmware` built",
        ),
        ("campaign --csv directory", "a file for --csv"),
    ] {
        let line = format!("directory: is a directory: expected {expected}");
        assert_refused(&folder, arguments, &[&line]);
    }
}

/// Root may write everywhere that permissions forbid; below a file and in /proc not even root.
#[test]
fn an_out_that_cannot_be_written_is_refused() {
    let folder = folder_with(good_log());
    for command in ["replay input", "simulate", "simulate --json"] {
        let below = format!("{command} --out input/below");
        assert_refused(&folder, &below, &["input/below", "--out"]);
        assert_refused(
            &folder,
            &format!("{command} --out input"),
            &["input", "--out"],
        );
        if cfg!(target_os = "linux") {
            let proc = format!("{command} --out /proc/self");
            assert_refused(&folder, &proc, &["/proc/self", "--out"]);
        }
    }
    assert_eq!(
        fs::read(folder.path().join("input")).unwrap(),
        good_log().as_bytes()
    );
}

#[test]
fn wrong_options_are_refused_with_their_values() {
    let folder = folder_with(good_log());
    for (arguments, words) in [
        (
            "replay input --cell 100",
            &["'100' has no unit", "100mm"][..],
        ),
        ("replay input --cell 1e300mm", &["1e300mm", "too large"]),
        ("replay input --cell 0mm", &["--cell", "at least 1mm"]),
        ("replay input --cell 10parsecs", &["parsecs", "unit"]),
        ("replay input --cell NaNm", &["NaNm"]),
        ("replay input --cell infm", &["infm"]),
        ("replay input --cell=", &["--cell"]),
        ("replay input --max-range=-1m", &["-1m", "negative"]),
        (
            "replay input --max-range 0m",
            &["--max-range", "at least 1mm"],
        ),
        ("replay input --max-range 8", &["'8' has no unit"]),
        ("replay input --beam-width 200deg", &["--beam-width"]),
        ("replay input --sensors 0", &["--sensors"]),
        ("replay input --sensors 256", &["--sensors"]),
        (
            "replay input --fusion best",
            &["invalid value 'best'", "median"],
        ),
        ("replay input --fusion Robust", &["invalid value 'Robust'"]),
        ("replay input --format xml", &["xml", "carmen", "readings"]),
        (
            "replay input --fault explode:1",
            &["unknown fault 'explode'", "stuck-far"],
        ),
        (
            "replay input --fault stuck-far:9",
            &["--fault: no sensor '9'"],
        ),
        (
            "replay input --fault stuck-far:0",
            &["no sensor '0'", "has 1, 2, 3"],
        ),
        ("replay input --fault stuck-far:FL", &["no sensor 'FL'"]),
        ("replay input --fault stuck-far", &["names no sensor"]),
        ("replay input --fault stuck-near:1=250", &["no unit"]),
        ("replay input --fault dropout:1=101%", &["dropout"]),
        ("replay input --fault stuck-far:1@9..3", &["empty"]),
        ("replay input --max-cells 10", &["--max-cells 10", "cells"]),
        ("replay input --max-cells=-1", &["--max-cells"]),
        (
            "replay input --seed x",
            &[
                "'x' for '--seed <N>': expected a whole number in digits alone",
                "see certainty replay --help",
            ],
        ),
        (
            "drive --study --worlds many",
            &[
                "--worlds",
                "expected a whole number",
                "see certainty drive --help",
            ],
        ),
        (
            "run --rounds 1.5",
            &[
                "--rounds",
                "expected a whole number",
                "see certainty run --help",
            ],
        ),
        (
            "monitor input --baud 0",
            &["--baud", "expected a whole number of at least 1"],
        ),
        (
            "simulate --seed 18446744073709551616",
            &["--seed", "expected a smaller whole number"],
        ),
        ("replay input --colour", &["--colour"]),
        ("replay input input", &["input"]),
        ("replay", &["<FILE>"]),
        ("compare input", &["<B>"]),
        ("simulate --fusion best", &["invalid value 'best'", "all"]),
        ("simulate --fault explode:1", &["unknown fault 'explode'"]),
        ("simulate --fault stuck-far:4", &["--fault: no sensor '4'"]),
        (
            "simulate --fault none --fault stuck-far:1",
            &["--fault: none and a value"],
        ),
        ("simulate --fault none:1", &["unknown fault 'none'"]),
        ("simulate --sensors 2", &["unknown sensors '2'"]),
        ("simulate --sensors 8", &["unknown sensors '8'"]),
        ("simulate --sensors ABF", &["unknown sensors 'ABF'"]),
        ("simulate --sensors AAAAAAAAAAAAAAAA", &["unknown sensors"]),
        ("simulate --readings 0", &["--readings"]),
        ("simulate --readings 10000001", &["--readings"]),
        ("simulate --seed -1", &["-1"]),
        ("dance", &["dance", "; see certainty --help"]),
        ("--fusion best", &["invalid value 'best'"]),
    ] {
        assert_refused(&folder, arguments, words);
    }
}

#[test]
fn a_map_that_is_too_large_is_refused_with_its_size() {
    // Two scans 20 km apart: 200 021 columns of 100 mm or so.
    let far = Place {
        x: 20_000.0,
        ..PLACE
    };
    let log = scan(2.0) + &flaser(&[2.0; BEAMS], far, 2.0);
    let folder = folder_with(log);
    assert_refused(
        &folder,
        "replay input --cell 1mm",
        &["--max-cells 100000000", " x "],
    );
    assert_refused(&folder, "replay input", &["65535", "--cell"]);
    // With all layers of a method that keeps the sensors apart: 44 x 44 cells of three layers.
    let folder = folder_with(scan(2.0));
    let enough = |cells: u32| format!("replay input --fusion median --max-cells {cells}");
    assert_refused(&folder, &enough(1000), &["--max-cells 1000", "3 layers"]);
    // The figure is what it takes: with as many it works.
    let line = certainty_quickly(folder.path(), &enough(1000))
        .refusal()
        .to_owned();
    let figure = line
        .split_once("layers, ")
        .unwrap()
        .1
        .split(' ')
        .next()
        .unwrap();
    let figure: u32 = figure.parse().unwrap();
    assert_refused(&folder, &enough(figure - 1), &[&figure.to_string()]);
    assert_eq!(
        certainty_quickly(folder.path(), &enough(figure)).code,
        Some(0)
    );
}

#[test]
fn a_wild_pose_is_refused_without_a_huge_allocation() {
    let wild = Place {
        x: 268_000.0,
        y: -268_000.0,
        heading: 1e6,
    };
    let folder = folder_with(scan(2.0) + &flaser(&[2.0; BEAMS], wild, 2.0));
    assert_refused(
        &folder,
        "replay input --max-cells 18446744073709551615",
        &["65535"],
    );
    assert_refused(&folder, "replay input", &["--max-cells"]);
}

#[test]
fn wrong_worlds_are_refused_with_file_and_line() {
    for (world, words) in [
        ("", &["input:1", "no obstacle"][..]),
        (
            "[[disc]]\ncenter = [\"0mm\", \"1m\"]\nradius = \"8\"\n",
            &["input:3", "no unit"],
        ),
        (
            "[[disc]]\ncenter = [\"0mm\", \"1m\"]\n",
            &["input:1", "radius"],
        ),
        (
            "[[disc]]\ncenter = [\"0mm\"]\nradius = \"8mm\"\n",
            &["input:2", "write for example: [[disc]]"],
        ),
        (
            "[[disc]]\ncenter = [\"0mm\", \"1m\"]\nradius = 8\n",
            &["input:3", "in quotes, such as \"100mm\""],
        ),
        ("[[ball]]\nradius = \"8mm\"\n", &["input:1", "ball"]),
        ("[[disc]\n", &["input:1"]),
        ("\u{0}\u{1}", &["input:1"]),
    ] {
        let folder = folder_with(world);
        assert_refused(&folder, "simulate --world input", words);
    }
    let folder = folder_with(noise(5000));
    assert_refused(&folder, "simulate --world input", &["input:1"]);
    // A file without end is not read to its end.
    if cfg!(target_os = "linux") {
        assert_refused(
            &folder,
            "simulate --world /dev/zero",
            &["/dev/zero", "4 MiB"],
        );
        assert_refused(
            &folder,
            "compare /dev/zero /dev/zero",
            &["/dev/zero", "larger than"],
        );
    }
}

/// The error of an argument that is not UTF-8 names its option.
#[cfg(target_os = "linux")]
#[test]
fn a_value_that_is_not_utf8_is_refused_with_its_option() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    for arguments in [&[&b"--seed"[..], b"\xFF"][..], &[b"--seed=\xFF"]] {
        let mut command = command(folder.path(), ["drive"]);
        command.args(arguments.iter().map(|argument| OsStr::from_bytes(argument)));
        let ran = run(command, QUICKLY);
        let line = ran.refusal();
        assert!(line.contains("--seed: the value is not UTF-8"), "{line}");
        assert!(line.ends_with("see certainty drive --help"), "{line}");
    }
}

/// A JSON document cannot list files in such a folder, so it must be refused before anything is written.
#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_is_not_utf8_is_refused_with_json() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let name = OsStr::from_bytes(b"out\xFF");
    for arguments in [
        ["simulate", "--json"].as_slice(),
        &["replay", "input", "--json"],
    ] {
        let folder = folder_with(good_log());
        let mut command = command(folder.path(), arguments);
        command.arg("--out").arg(name);
        let ran = run(command, QUICKLY);
        let _line = ran.refusal();
        let written = fs::read_dir(folder.path().join(name)).into_iter().flatten();
        assert_eq!(written.count(), 0);
    }
}

#[test]
fn a_single_sensor_needs_no_fault_option() {
    let folder = tempfile::tempdir().unwrap();
    let ran = certainty_quickly(folder.path(), "simulate --json --sensors A");
    assert_eq!(ran.json()["sensors"].as_array().unwrap().len(), 1);
}

/// A line without end is no line; where all the file is one, nothing can come of it.
#[cfg(target_os = "linux")]
#[test]
fn an_endless_file_is_refused_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    for format in ["auto", "carmen", "readings"] {
        let arguments = format!("replay --format {format} /dev/zero");
        assert_refused(&folder, &arguments, &["/dev/zero"]);
    }
}

/// A refusal leaves what an earlier run wrote.
#[test]
fn an_error_keeps_the_files_of_an_earlier_run() {
    let folder = folder_with(good_log());
    assert_eq!(
        certainty_quickly(folder.path(), "replay input").code,
        Some(0)
    );
    let results =
        ["map.png", "map.pgm", "map.yaml"].map(|name| folder.path().join("out").join(name));
    let before = results.each_ref().map(|path| fs::read(path).unwrap());
    let _line = certainty_quickly(folder.path(), "replay input --max-cells 10")
        .refusal()
        .to_owned();
    assert_eq!(
        results.each_ref().map(|path| fs::read(path).unwrap()),
        before
    );
    assert_eq!(fs::read_dir(folder.path().join("out")).unwrap().count(), 3);
}
