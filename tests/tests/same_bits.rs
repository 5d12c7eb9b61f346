//! The same readings give the same bits on the host and on a Cortex-M3.

use certainty_firmware::rehearsal;
use certainty_tests::program::{executable, run};
use certainty_tests::{skipped, workspace};
use core::time::Duration;
use object::{Object, ObjectSymbol};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

const TARGET: &str = "thumbv7m-none-eabi";

/// The rehearsal's image as `cargo firmware` builds it; `None` where that target is not installed.
fn image() -> Option<&'static Path> {
    static IMAGE: OnceLock<Option<PathBuf>> = OnceLock::new();
    built(&IMAGE, "smoke")
}

/// The image of the control level's benchmark.
fn control_image() -> Option<&'static Path> {
    static IMAGE: OnceLock<Option<PathBuf>> = OnceLock::new();
    built(&IMAGE, "control_bench")
}

fn built(image: &'static OnceLock<Option<PathBuf>>, name: &str) -> Option<&'static Path> {
    let image = image.get_or_init(|| {
        let libraries = Command::new("rustc")
            .args(["--print", "target-libdir", "--target", TARGET])
            .current_dir(workspace())
            .output();
        let folder = String::from_utf8(libraries.ok()?.stdout).ok()?;
        let installed = Path::new(folder.trim()).is_dir();
        installed.then(|| executable(["firmware"], name).expect("the firmware can be built"))
    });
    if image.is_none() {
        skipped(&format!("rustup target add {TARGET}"));
    }
    image.as_deref()
}

/// Symbols that only a program with a way to panic has.
fn panicking<'a>(symbols: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let of_panics = |name: &&str| name.contains("panicking") || name.contains("panic_fmt");
    symbols.into_iter().filter(of_panics).collect()
}

#[test]
fn the_host_and_a_cortex_m3_under_qemu_get_the_same_digest() {
    if Command::new("qemu-system-arm")
        .arg("--version")
        .output()
        .is_err()
    {
        skipped("there is no qemu-system-arm");
        return;
    }
    let Some(image) = image() else { return };
    let mut qemu = Command::new("qemu-system-arm");
    qemu.args([
        "-M",
        "stm32vldiscovery",
        "-nographic",
        "-monitor",
        "none",
        "-serial",
        "null",
    ])
    .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
    .arg(image)
    .stdin(Stdio::null());
    let ran = run(qemu, Duration::from_secs(60));
    let rehearsal::Outcome { digest, told } = rehearsal::run().unwrap();
    let expected = format!("digest {digest:08x} of {told} cells told");
    assert_eq!(ran.code, Some(0), "{ran:?}");
    // QEMU's semihosting writes to stderr or stdout, depending on its version.
    let printed = format!("{}{}", ran.stdout, ran.stderr);
    assert!(
        printed.lines().any(|line| line == expected),
        "{expected}, but {printed}"
    );
}

#[test]
fn nothing_in_the_firmware_can_panic() {
    for image in [image(), control_image()].into_iter().flatten() {
        cannot_panic(image);
    }
}

/// The control level computes in integers: no routine for floats is linked.
#[test]
fn nothing_in_the_control_level_is_a_float() {
    let Some(image) = control_image() else { return };
    let bytes = fs::read(image).unwrap();
    let file = object::File::parse(&*bytes).unwrap();
    let names = file.symbols().filter_map(|symbol| symbol.name().ok());
    let of_floats = |name: &&str| {
        let routine = name.strip_prefix("__aeabi_").unwrap_or_default();
        routine.starts_with(['f', 'd']) || routine.contains("2f") || routine.contains("2d")
    };
    assert_eq!(names.filter(of_floats).collect::<Vec<_>>(), [""; 0]);
}

/// Under QEMU every instruction takes 32 ns of the machine's time, so the count repeats; the limits are
/// the figures of docs/measurements/2026-11-23-control.md and a fifth more or less.
#[test]
fn a_control_step_takes_the_instructions_that_are_written_down() {
    if Command::new("qemu-system-arm")
        .arg("--version")
        .output()
        .is_err()
    {
        skipped("there is no qemu-system-arm");
        return;
    }
    let Some(image) = control_image() else { return };
    let mut qemu = Command::new("qemu-system-arm");
    qemu.args(["-M", "stm32vldiscovery", "-nographic", "-monitor", "none"])
        .args(["-serial", "null", "-icount", "shift=5"])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(image)
        .stdin(Stdio::null());
    let ran = run(qemu, Duration::from_secs(60));
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let printed = format!("{}{}", ran.stdout, ran.stderr);
    for (scene, expected) in [
        ("open", 9339),
        ("a post ahead", 32_962),
        ("walls all around", 155_988),
    ] {
        let line = printed
            .lines()
            .find(|line| line.starts_with(&format!("{scene}: step ")));
        let words: Vec<&str> = line
            .unwrap_or_else(|| panic!("{printed}"))
            .split(' ')
            .collect();
        let number = words.iter().position(|word| *word == "step").unwrap() + 1;
        let instructions: u32 = words[number].parse().unwrap();
        let (least, most) = (expected * 4 / 5, expected * 6 / 5);
        assert!(
            (least..=most).contains(&instructions),
            "{scene}: {instructions}"
        );
    }
}

fn cannot_panic(image: &Path) {
    let bytes = fs::read(image).unwrap();
    let file = object::File::parse(&*bytes).unwrap();
    let symbols: Vec<&str> = file
        .symbols()
        .filter_map(|symbol| symbol.name().ok())
        .collect();
    // A stripped image would have nothing to find.
    assert!(
        symbols.contains(&"Reset") && symbols.contains(&"main"),
        "{symbols:?}"
    );
    assert_eq!(panicking(symbols), [""; 0]);
}

#[test]
fn a_panic_among_the_symbols_would_be_found() {
    let names = [
        "main",
        "_ZN4core9panicking5panic17h0123456789abcdefE",
        "_RNvNtCs1_4core9panicking18panic_bounds_check",
        "_ZN4core3fmt5write17h0123456789abcdefE",
        "_RNvNtCs1_3std9panic_fmt",
    ];
    assert_eq!(panicking(names), [names[1], names[2], names[4]]);
    assert_eq!(panicking(["main", "Reset", "DefaultHandler_"]), [""; 0]);
}
