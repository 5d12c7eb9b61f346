//! Named cases on a Cortex-M3 under QEMU; each prints a line a result, beginning with the case's name.
//!
//! | case | prints |
//! |---|---|
//! | `fusion` | the digest of a run that the host must get too, and instructions of the fusion level |
//! | `ring` | the same for the diagnosis of a sonar ring |
//! | `control` | instructions of a control step and of the cross-check of sensors |
//!
//! Run it with `-icount shift=5`: an instruction then takes 32 ns of the emulated time, and `SysTick` counts
//! at 24 MHz whatever the firmware sets, so 125 instructions are 96 ticks.
#![no_std]
#![no_main]

mod clock;
mod control;
mod fusion;

use certainty_firmware_bench::fusion_run::InitError;
use certainty_firmware_bench::ring_run::{self, Outcome};
use clock::ticks_between;
use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m_semihosting::{debug, hprintln};
use stm32f1xx_hal as _; // the interrupt vectors

/// Checks a ring; its stack must fit into the RAM.
#[inline(never)]
fn ring() -> Result<(), InitError> {
    let (mut before, mut time) = (SYST::get_current(), 0_u32);
    let clock = || {
        let now = SYST::get_current();
        time = time.wrapping_add(ticks_between(before, now));
        before = now;
        time
    };
    let Outcome {
        digest,
        elements,
        faulty,
        ticks,
    } = ring_run::run(clock)?;
    hprintln!(
        "ring: digest {:08x} of {} elements, faulty {:06x}",
        digest,
        elements,
        faulty
    );
    hprintln!(
        "ring: ticks polygon {} simulation {} fold {} vectors {}",
        ticks.polygon,
        ticks.simulation,
        ticks.fold,
        ticks.vectors
    );
    Ok(())
}

/// Indexes beyond an array.
#[cfg(feature = "can-panic")]
fn can_panic() {
    use core::hint::black_box;
    black_box([1_u8, 2, 3][black_box(7_usize)]);
}

fn run_all() -> Result<(), InitError> {
    #[cfg(feature = "can-panic")]
    can_panic();
    fusion::run()?;
    ring()?;
    control::run()
}

#[cortex_m_rt::entry]
fn main() -> ! {
    let mut result = Err(InitError);
    if let Some(core) = Peripherals::take() {
        clock::start(core.SYST);
        result = run_all();
    }
    if let Err(error) = result {
        hprintln!("failed: {}", error);
    }
    loop {
        debug::exit(match result {
            Ok(()) => debug::EXIT_SUCCESS,
            Err(_) => debug::EXIT_FAILURE,
        });
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
