//! The rehearsal on a Cortex-M3 under QEMU: prints the digest that the host must get too.
#![no_std]
#![no_main]

use certainty_firmware_bench::rehearsal;
use cortex_m as _; // the critical section
use cortex_m_semihosting::{debug, hprintln};
use stm32f1xx_hal as _; // the interrupt vectors

#[cortex_m_rt::entry]
fn main() -> ! {
    let status = match rehearsal::run() {
        Ok(outcome) => {
            hprintln!(
                "digest {:08x} of {} cells told",
                outcome.digest,
                outcome.told
            );
            debug::EXIT_SUCCESS
        }
        Err(refused) => {
            hprintln!("refused: {}", refused);
            debug::EXIT_FAILURE
        }
    };
    loop {
        debug::exit(status);
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
