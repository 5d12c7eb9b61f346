//! The Smart Car on an STM32F100RB: the image to flash.
//!
//! The microcontroller runs on its internal 8 MHz oscillator. `SysTick` queues due slots, the main loop
//! performs them and sleeps, USART1 sends the reports, the watchdog is fed once a completed round.
//! Pins and wiring: `docs/hardware.md`.
#![no_std]
#![no_main]

mod clock;
mod pins;
mod serial;

use certainty_firmware::executive::Executive;
use certainty_firmware::smart_car::{SCHEDULE, SmartCar};
use cortex_m::Peripherals as Core;
use cortex_m::peripheral::SCB;
use stm32f1xx_hal::pac::Peripherals;

#[cortex_m_rt::entry]
fn main() -> ! {
    // The first call always succeeds; otherwise reset.
    let (Some(chip), Some(mut core)) = (Peripherals::take(), Core::take()) else {
        SCB::sys_reset()
    };
    let pins = pins::set_up(chip.RCC, (chip.GPIOA, chip.GPIOB, chip.GPIOC));
    let watchdog = clock::Heartbeat::start(chip.IWDG, pins.heartbeat);
    let timers = pins::Timers::new(chip.TIM3, chip.TIM4);
    let outbox = serial::start(chip.USART1, &mut core.NVIC);
    let wiring = pins
        .lines
        .wire(timers.servos(), timers.motors(), outbox, pins.reset_cause);
    // By reference: by value the stack would hold the car twice.
    let Ok(car) = &mut SmartCar::try_new(wiring) else {
        SCB::sys_reset()
    };
    let mut executive = Executive::new(&SCHEDULE, clock::Clock, watchdog);
    clock::start(&mut core.SYST);
    loop {
        executive.step(&clock::DUE, car);
    }
}

/// Resets at once: until the watchdog resets, the timer would repeat the last pulses. After this automatic
/// reset the car stands.
#[cortex_m_rt::exception]
unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
    SCB::sys_reset()
}

/// Handles any other exception like a fault.
#[cortex_m_rt::exception]
unsafe fn DefaultHandler(_: i16) -> ! {
    SCB::sys_reset()
}

/// Never called: a test checks that the linked image contains no panic.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    SCB::sys_reset()
}
