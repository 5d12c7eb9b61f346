//! Instructions of the control level on a Cortex-M3.

use certainty_tests::firmware;
use object::{Object, ObjectSymbol};
use std::fs;

/// Everything in the bench computes in integers: no routine for floats is linked.
#[test]
fn no_float_routine_is_linked() {
    let Some(image) = firmware::image("bench") else {
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

/// The limits are the figures of docs/measurements/2026-11-23-control.md, 20 % more or less.
#[test]
fn control_takes_the_documented_instructions() {
    let Some(image) = firmware::image("bench").filter(|_| firmware::qemu_is_installed()) else {
        return;
    };
    let printed = firmware::output(&image);
    for (scene, what, expected) in [
        ("open", "step", 10_321),
        ("a post ahead", "step", 32_559),
        ("walls all around", "step", 145_871),
        ("an empty map", "scan", 532_425),
        ("a wall in the map", "scan", 403_127),
        ("a wall in the map", "cross-check", 38_825),
    ] {
        let start = format!("control: {scene}: ");
        let line = printed.lines().find_map(|line| line.strip_prefix(&start));
        let line = line.unwrap_or_else(|| panic!("{printed}"));
        let mut words = line.split_whitespace();
        let number = words.by_ref().skip_while(|word| *word != what).nth(1);
        let number = number.map(|number| number.trim_end_matches(','));
        let instructions: u32 = number.unwrap_or_default().parse().unwrap();
        let (least, most) = (expected * 4 / 5, expected * 6 / 5);
        assert!(
            (least..=most).contains(&instructions),
            "{scene}, {what}: {instructions}"
        );
    }
    // The cross-check compares the scanner with the map, and the completion uses the map.
    assert!(printed.contains("scanner silent, 0 nearer"), "{printed}");
    assert!(
        printed.contains("scanner contradicts, 4 nearer"),
        "{printed}"
    );
}
