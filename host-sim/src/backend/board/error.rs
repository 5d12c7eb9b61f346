//! Why a run on the emulated board ends early.

use thiserror::Error;

/// Why an image cannot be run, or how its run ended.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum BoardError {
    /// The bytes are no program for this microcontroller.
    #[error("not an image for the STM32F100RB: {0}")]
    NotAnImage(String),
    /// The watchdog was not fed in time: the microcontroller would start again.
    #[error("the watchdog bit at {} ms: it was not fed", at_ns / 1_000_000)]
    WatchdogBite {
        /// When, in nanoseconds since the reset.
        at_ns: u64,
    },
    /// The program asked for a reset, as its handlers of panics and faults do.
    #[error("the firmware reset itself at {} ms", at_ns / 1_000_000)]
    Reset {
        /// When, in nanoseconds since the reset before.
        at_ns: u64,
    },
    /// The program did something that the processor refuses.
    #[error("hard fault at {} ms, last refused address {address:#010x}", at_ns / 1_000_000)]
    HardFault {
        /// When, in nanoseconds since the reset.
        at_ns: u64,
        /// The address that was refused last, if any was; else 0.
        address: u32,
    },
    /// A fault within the fault handler: the processor stands still.
    #[error("the processor locked up at {} ms, at {pc:#010x}", at_ns / 1_000_000)]
    LockedUp {
        /// When, in nanoseconds since the reset.
        at_ns: u64,
        /// Where in the program.
        pc: u32,
    },
    /// A GP2D02's Vin was driven to the supply voltage; it takes at most 3 V, so it must be open drain.
    #[error("Vin of sensor {} was driven high, at {} ms: it takes 3 V at most", slot + 1, at_ns / 1_000_000)]
    VinDrivenHigh {
        /// The sensor's slot, from 0.
        slot: u8,
        /// When, in nanoseconds since the reset.
        at_ns: u64,
    },
    /// The emulator refused what the board is made of, which would be a defect of this program.
    #[error("the emulator refused the board: {0}")]
    Emulator(String),
}
