//! The shipped drivers on the simulated devices.

mod gp2d02;
mod moving_car;
mod pins;
mod ranger;
mod servo;
