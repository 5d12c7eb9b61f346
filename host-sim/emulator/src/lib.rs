#![doc = include_str!("../README.md")]

mod bus;
mod error;
mod flash_image;
mod it_blocks;
mod microcontroller;
mod peripherals;
mod pins;
#[cfg(test)]
mod test_elf;

pub use error::RunError;
pub use microcontroller::Stm32f100;
pub use peripherals::{ResetCause, UnmodelledRegister};
pub use pins::{Connection, Pin, Pins, Port, Timer};
