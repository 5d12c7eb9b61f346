//! The check of a sonar ring gives the same bits on the host and on a Cortex-M3, in 8 KB of RAM.

use certainty_firmware_bench::ring_rehearsal::{self, Outcome};
use certainty_tests::firmware;

/// The image has 8 KB of RAM, and a stack that does not fit ends in a fault: that it answers at all is
/// the claim that one check fits.
#[test]
fn the_host_and_a_cortex_m3_under_qemu_check_a_ring_alike_and_in_8_kb() {
    let Some(image) = firmware::image("ring_bench").filter(|_| firmware::qemu_is_there()) else {
        return;
    };
    let ran = firmware::counted(&image);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let printed = format!("{}{}", ran.stdout, ran.stderr);
    let Outcome {
        digest,
        elements,
        faulty,
        ..
    } = ring_rehearsal::run(|| 0).unwrap();
    let expected = format!("digest {digest:08x} of {elements} elements, faulty {faulty:06x}");
    assert!(
        printed.lines().any(|line| line == expected),
        "{expected}, but {printed}"
    );

    // SysTick counts 24 MHz and an instruction takes 32 ns: 0.768 ticks.
    let ticks = printed.lines().find(|line| line.starts_with("ticks "));
    let numbers = ticks
        .unwrap()
        .split(' ')
        .filter_map(|word| word.parse::<f64>().ok());
    let instructions: f64 = numbers.map(|ticks| ticks / 0.768).sum();
    // Half a minute of a 24 MHz part would be no check that one runs while driving.
    assert!(
        (100_000.0..24_000_000.0).contains(&instructions),
        "{instructions} instructions"
    );
}
