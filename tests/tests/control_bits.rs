//! What the control level costs on a Cortex-M3, and what it must not need.

use certainty_tests::firmware;
use object::{Object, ObjectSymbol};
use std::fs;

/// The control level computes in integers: no routine for floats is linked.
#[test]
fn nothing_in_the_control_level_is_a_float() {
    let Some(image) = firmware::image("control_bench") else {
        return;
    };
    let bytes = fs::read(image).unwrap();
    let file = object::File::parse(&*bytes).unwrap();
    let names = file.symbols().filter_map(|symbol| symbol.name().ok());
    let of_floats = |name: &&str| {
        let routine = name.strip_prefix("__aeabi_").unwrap_or_default();
        routine.starts_with(['f', 'd']) || routine.contains("2f") || routine.contains("2d")
    };
    assert_eq!(names.filter(of_floats).collect::<Vec<_>>(), [""; 0]);
}

/// The limits are the figures of docs/measurements/2026-11-23-control.md and a fifth more or less.
#[test]
fn a_control_step_takes_the_instructions_that_are_written_down() {
    let Some(image) = firmware::image("control_bench").filter(|_| firmware::qemu_is_there()) else {
        return;
    };
    let ran = firmware::counted(&image);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let printed = format!("{}{}", ran.stdout, ran.stderr);
    for (scene, what, expected) in [
        ("open", "step", 10_321),
        ("a post ahead", "step", 32_559),
        ("walls all around", "step", 145_871),
        ("nothing remembered", "recollection", 532_425),
        ("a wall remembered", "recollection", 403_127),
        ("a wall remembered", "cross-check", 38_825),
    ] {
        let told = printed
            .lines()
            .find(|line| line.starts_with(&format!("{scene}: ")));
        let told = told.unwrap_or_else(|| panic!("{printed}"));
        let mut words = told[scene.len() + 1..].split_whitespace();
        let number = words.by_ref().skip_while(|word| *word != what).nth(1);
        let number = number.map(|number| number.trim_end_matches(','));
        let instructions: u32 = number.unwrap_or_default().parse().unwrap();
        let (least, most) = (expected * 4 / 5, expected * 6 / 5);
        assert!(
            (least..=most).contains(&instructions),
            "{scene}, {what}: {instructions}"
        );
    }
    // The map is held against the sensors, and makes up for them.
    assert!(printed.contains("scanner silent, 0 nearer"), "{printed}");
    assert!(
        printed.contains("scanner contradicts, 4 nearer"),
        "{printed}"
    );
}
