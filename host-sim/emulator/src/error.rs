//! Why a run ends.

use thiserror::Error;

/// Why an image cannot be run, or what ended its run.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum RunError {
    /// The bytes are no program for this microcontroller.
    #[error("not an image for the STM32F100RB: {0}")]
    NotAnImage(String),
    /// The watchdog expired: the microcontroller would start again.
    #[error("the watchdog expired at {} ms: it was not fed", at_ns / 1_000_000)]
    WatchdogExpired {
        /// When, in nanoseconds since the reset.
        at_ns: u64,
    },
    /// The program requested a reset, as its handlers of panics and faults do.
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
    /// A fault within the fault handler: the processor stopped.
    #[error("the processor locked up at {} ms, at {pc:#010x}", at_ns / 1_000_000)]
    LockedUp {
        /// When, in nanoseconds since the reset.
        at_ns: u64,
        /// Where in the program.
        pc: u32,
    },
    /// A line that takes 3 V at most was driven to the supply voltage; its pin must be open drain.
    #[error("{line} was driven high, at {} ms: it takes 3 V at most", at_ns / 1_000_000)]
    DrivenHigh {
        /// The name of the line, as its [`Connection`](crate::Connection) gives it.
        line: &'static str,
        /// When, in nanoseconds since the reset.
        at_ns: u64,
    },
    /// The emulator's core refused the memory map, which would be a defect of this package.
    #[error("the emulator refused the memory map: {0}")]
    Emulator(String),
}
