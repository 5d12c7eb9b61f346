//! The same readings give the same bits on the host and on a Cortex-M3.

use certainty_firmware_bench::rehearsal;
use certainty_tests::firmware;
use object::{Object, ObjectSymbol};
use std::fs;
use std::path::Path;

/// Symbols that only a program with a way to panic has.
fn panicking<'a>(symbols: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let of_panics = |name: &&str| name.contains("panicking") || name.contains("panic_fmt");
    symbols.into_iter().filter(of_panics).collect()
}

#[test]
fn the_host_and_a_cortex_m3_under_qemu_get_the_same_digest() {
    if !firmware::qemu_is_there() {
        return;
    }
    let Some(image) = firmware::image("smoke") else {
        return;
    };
    let ran = firmware::counted(&image);
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

/// The panic symbols of the image at `path`.
fn panics_in(path: &Path) -> Vec<String> {
    let bytes = fs::read(path).unwrap();
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
    panicking(symbols).into_iter().map(String::from).collect()
}

#[test]
fn nothing_in_the_firmware_can_panic() {
    for name in ["smart_car", "qemu", "smoke", "control_bench"] {
        let Some(image) = firmware::image(name) else {
            return;
        };
        assert_eq!(panics_in(&image), [""; 0], "{name}");
    }
}

#[test]
fn an_image_that_can_panic_is_found_out() {
    let Some(image) = firmware::image_with("can_panic", "can-panic") else {
        return;
    };
    assert_ne!(panics_in(&image), [""; 0]);
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
