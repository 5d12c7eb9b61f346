//! An image that can panic: what the search for panic symbols must find.
#![no_std]
#![no_main]

use cortex_m as _; // the critical section
use stm32f1xx_hal as _; // the interrupt vectors

#[cortex_m_rt::entry]
fn main() -> ! {
    let table = [1_u8, 2, 3];
    let index = core::hint::black_box(7_usize);
    loop {
        core::hint::black_box(table[index]);
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        cortex_m::asm::nop();
    }
}
