//! The shipped drivers on the simulated devices.

mod gp2d02;
mod pins;
mod ranger;
mod servo;
