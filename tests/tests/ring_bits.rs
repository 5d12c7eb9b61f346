//! The diagnosis of a sonar ring gives the same bits on the host and on a Cortex-M3 with 8 KB of RAM.

use certainty_firmware_bench::ring_run::{self, Outcome};
use certainty_tests::firmware;

/// The image has 8 KB of RAM, and a stack overflow ends in a fault, so a result shows that the check fits.
#[test]
fn a_ring_check_is_the_same_on_a_cortex_m3_in_8_kb() {
    let Some(image) = firmware::image("bench").filter(|_| firmware::qemu_is_installed()) else {
        return;
    };
    let printed = firmware::output(&image);
    let Outcome {
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
