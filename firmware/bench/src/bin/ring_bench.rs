//! The check of a sonar ring on a Cortex-M3 under QEMU: prints the digest that the host must get too,
//! and how long each part took.
#![no_std]
#![no_main]

use certainty_firmware_bench::ring_rehearsal::{self, Outcome};
use cortex_m as _; // the critical section
use cortex_m::peripheral::{Peripherals, SYST, syst::SystClkSource};
use cortex_m_semihosting::{debug, hprintln};
use stm32f1xx_hal as _; // the interrupt vectors

/// SysTick has 24 bits and counts down; no part takes a whole turn.
const TURN: u32 = 0x00FF_FFFF;

#[cortex_m_rt::entry]
fn main() -> ! {
    if let Some(peripherals) = Peripherals::take() {
        let mut timer = peripherals.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(TURN);
        timer.clear_current();
        timer.enable_counter();
    }
    let (mut before, mut time) = (SYST::get_current(), 0_u32);
    let clock = || {
        let now = SYST::get_current();
        time = time.wrapping_add(before.wrapping_sub(now) & TURN);
        before = now;
        time
    };
    let status = match ring_rehearsal::run(clock) {
        Ok(Outcome {
            digest,
            elements,
            faulty,
            ticks,
        }) => {
            hprintln!(
                "digest {:08x} of {} elements, faulty {:06x}",
                digest,
                elements,
                faulty
            );
            hprintln!(
                "ticks polygon {} simulation {} fold {} vectors {}",
                ticks.polygon,
                ticks.simulation,
                ticks.fold,
                ticks.vectors
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
