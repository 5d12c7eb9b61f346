//! The same readings give the same bits on the host and on a Cortex-M3.

use certainty_firmware_bench::fusion_run::{self, Outcome};
use certainty_tests::firmware;
use object::{Object, ObjectSymbol};
use std::fs;
use std::path::Path;

/// Returns the symbols that exist only in a program that can panic.
fn panicking<'a>(symbols: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let of_panics = |name: &&str| name.contains("panicking") || name.contains("panic_fmt");
    symbols.into_iter().filter(of_panics).collect()
}

#[test]
fn fusion_is_the_same_on_the_host_and_a_cortex_m3() {
    let Some(image) = firmware::image("bench").filter(|_| firmware::qemu_is_installed()) else {
        return;
    };
    let Outcome { digest, updates } = fusion_run::run().unwrap();
    let expected = format!("fusion: digest {digest:08x} of {updates} updates");
    let printed = firmware::output(&image);
    assert!(
        printed.lines().any(|line| line == expected),
        "expected {expected}, got {printed}"
    );
}

/// Returns the panic symbols of the image at `path`.
fn panics_in(path: &Path) -> Vec<String> {
    let bytes = fs::read(path).unwrap();
    let file = object::File::parse(&*bytes).unwrap();
    let symbols: Vec<&str> = file
        .symbols()
        .filter_map(|symbol| symbol.name().ok())
        .collect();
    // A stripped image would pass without being searched.
    assert!(
        symbols.contains(&"Reset") && symbols.contains(&"main"),
        "{symbols:?}"
    );
    panicking(symbols).into_iter().map(String::from).collect()
}

#[test]
fn no_image_can_panic() {
    for name in ["smart_car", "qemu", "bench"] {
        let Some(image) = firmware::image(name) else {
            return;
        };
        assert_eq!(panics_in(&image), [""; 0], "{name}");
    }
}

#[test]
fn an_image_that_can_panic_is_detected() {
    let Some(image) = firmware::image_with("bench", "can-panic") else {
        return;
    };
    assert_ne!(panics_in(&image), [""; 0]);
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
