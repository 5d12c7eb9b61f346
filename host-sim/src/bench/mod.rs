//! Simulated devices, pin by pin: what the shipped drivers talk to.
//!
//! Each device is a function of what its pins saw and of the time it is asked at, in nanoseconds of
//! virtual time that never goes back. There are no events: whoever owns the clock may step it as it
//! likes. What a sensor sees is asked for when it looks, so a device knows nothing of worlds.

#[expect(clippy::module_inception, reason = "the bench with everything on it")]
mod bench;
mod fault;
mod gp2d02_line;
mod line_fault;
mod motor_fault;
mod moving_car;
mod ranger_line;
mod servo_shaft;
mod wires;

pub use bench::{Bench, BenchError, BenchSetup, Broken};
pub use fault::{BenchFault, WireFault};
pub use gp2d02_line::Gp2d02Line;
pub use line_fault::LineFault;
pub use motor_fault::MotorFault;
pub use moving_car::{MovingCar, Stage};
pub use ranger_line::{RangerAnswer, RangerLine};
pub use servo_shaft::{ServoShaft, pulse_of};
pub use wires::Wires;

/// Nanoseconds in a microsecond.
const MICROSECOND: u64 = 1_000;

/// Nanoseconds in a millisecond.
const MILLISECOND: u64 = 1_000_000;

#[cfg(test)]
mod tests;
