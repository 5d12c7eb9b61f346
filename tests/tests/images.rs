//! The images of the microcontroller: the same bits as on the host, the documented instructions, no panic and no
//! float.

use certainty_firmware_bench::{fusion_run, ring_run};
use certainty_tests::firmware;
use object::{Object, ObjectSymbol};
use std::fs;
use std::path::Path;
use std::sync::LazyLock;

/// The output of the bench under QEMU; `None` where its target or QEMU is not installed.
fn bench_output() -> Option<&'static str> {
    static OUTPUT: LazyLock<Option<String>> = LazyLock::new(|| {
        let image = firmware::image("bench").filter(|_| firmware::qemu_is_installed())?;
        Some(firmware::output(&image))
    });
    OUTPUT.as_deref()
}

/// Returns the symbols of the image at `path`.
fn symbols(path: &Path) -> Vec<String> {
    let bytes = fs::read(path).unwrap();
    let file = object::File::parse(&*bytes).unwrap();
    let names = file.symbols().filter_map(|symbol| symbol.name().ok());
    let symbols: Vec<String> = names.map(String::from).collect();
    // A stripped image would pass without being searched.
    for known in ["Reset", "main"] {
        assert!(symbols.iter().any(|name| name == known), "{symbols:?}");
    }
    symbols
}

/// Returns the symbols that exist only in a program that can panic.
fn panicking<S: AsRef<str>>(symbols: impl IntoIterator<Item = S>) -> Vec<S> {
    let of_panics = |name: &S| {
        let name = name.as_ref();
        name.contains("panicking") || name.contains("panic_fmt")
    };
    symbols.into_iter().filter(of_panics).collect()
}

#[test]
fn fusion_is_the_same_on_the_host_and_a_cortex_m3() {
    let Some(printed) = bench_output() else {
        return;
    };
    let fusion_run::Outcome { digest, updates } = fusion_run::run().unwrap();
    let expected = format!("fusion: digest {digest:08x} of {updates} updates");
    assert!(
        printed.lines().any(|line| line == expected),
        "expected {expected}, got {printed}"
    );
}

/// The image has 8 KB of RAM, and a stack overflow ends in a fault, so a result shows that the check fits.
#[test]
fn a_ring_check_is_the_same_on_a_cortex_m3_in_8_kb() {
    let Some(printed) = bench_output() else {
        return;
    };
    let ring_run::Outcome {
        digest,
        elements,
        faulty,
        ..
    } = ring_run::run(|| 0).unwrap();
    let expected = format!("ring: digest {digest:08x} of {elements} elements, faulty {faulty:06x}");
    assert!(
        printed.lines().any(|line| line == expected),
        "expected {expected}, got {printed}"
    );

    // SysTick counts 24 MHz and an instruction takes 32 ns: 0.768 ticks.
    let ticks = printed
        .lines()
        .find(|line| line.starts_with("ring: ticks "));
    let numbers = ticks
        .unwrap()
        .split(' ')
        .filter_map(|word| word.parse::<f64>().ok());
    let instructions: f64 = numbers.map(|ticks| ticks / 0.768).sum();
    // A second at 24 MHz: a check must be fast enough to run while driving.
    assert!(
        (100_000.0..24_000_000.0).contains(&instructions),
        "{instructions} instructions"
    );
}

/// The limits are the figures of docs/measurements/2026-11-23-control.md, 20 % more or less.
#[test]
fn control_takes_the_documented_instructions() {
    let Some(printed) = bench_output() else {
        return;
    };
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

/// Everything in the bench computes in integers: no routine for floats is linked.
#[test]
fn no_float_routine_is_linked() {
    let Some(image) = firmware::image("bench") else {
        return;
    };
    let mut names = symbols(&image);
    names.retain(|name| {
        let routine = name.strip_prefix("__aeabi_").unwrap_or_default();
        routine.starts_with(['f', 'd']) || routine.contains("2f") || routine.contains("2d")
    });
    assert_eq!(names, [""; 0]);
}

#[test]
fn no_image_can_panic() {
    for name in ["smart_car", "qemu", "bench"] {
        let Some(image) = firmware::image(name) else {
            return;
        };
        assert_eq!(panicking(symbols(&image)), [""; 0], "{name}");
    }
}

#[test]
fn an_image_that_can_panic_is_detected() {
    let Some(image) = firmware::image_with("bench", "can-panic") else {
        return;
    };
    assert_ne!(panicking(symbols(&image)), [""; 0]);
}

#[test]
fn panic_symbols_are_recognized() {
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
