//! The Smart Car on an STM32F100RB: the image that is flashed.
//!
//! The microcontroller runs on its internal 8 MHz oscillator. `SysTick` hands over what is due, the main
//! loop does it and sleeps, USART1 sends the reports, the watchdog is fed once a completed round.
//! Pins and wiring: `docs/hardware.md`.
#![no_std]
#![no_main]

mod any_of;
mod clock;
#[cfg(feature = "defmt-rtt")]
mod log;
mod pins;
mod pulses;
mod serial;
mod watchdog;

use certainty_firmware::executive::Executive;
use certainty_firmware::smart_car::{SCHEDULE, SmartCar};
use cortex_m::Peripherals as Core;
use cortex_m::peripheral::SCB;
use stm32f1xx_hal::pac::Peripherals;

#[cortex_m_rt::entry]
fn main() -> ! {
    // There is one of each; should that ever fail, start again.
    let (Some(chip), Some(mut core)) = (Peripherals::take(), Core::take()) else {
        SCB::sys_reset()
    };
    let pins = pins::set_up(chip.RCC, (chip.GPIOA, chip.GPIOB, chip.GPIOC));
    let watchdog = watchdog::Heartbeat::start(chip.IWDG, pins.heartbeat);
    let timers = pulses::Timers::new(chip.TIM3, chip.TIM4);
    let outbox = serial::start(chip.USART1, &mut core.NVIC);
    let wiring = pins
        .lines
        .wire(timers.servos(), timers.motors(), outbox, pins.start);
    // By reference, or the stack would hold the car twice.
    let Ok(car) = &mut SmartCar::try_new(wiring) else {
        SCB::sys_reset()
    };
    #[cfg(feature = "defmt-rtt")]
    let car = &mut log::Logged(car);
    let mut executive = Executive::new(&SCHEDULE, clock::Clock, watchdog);
    clock::start(&mut core.SYST);
    loop {
        executive.step(&clock::DUE, car);
    }
}

/// Until the watchdog bites the timer would repeat the last pulses, so the microcontroller resets at once; then the
/// car stands, as it started by itself.
#[cortex_m_rt::exception]
unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
    SCB::sys_reset()
}

/// An exception that nothing here is for, as a fault.
#[cortex_m_rt::exception]
unsafe fn DefaultHandler(_: i16) -> ! {
    SCB::sys_reset()
}

/// Nothing here panics, and the linked image is searched for what would.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    SCB::sys_reset()
}
