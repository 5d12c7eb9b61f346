//! The Smart Car of \[001\] §6.1: a car with three pivoted infrared sensors and two ultrasonic rangers.
//!
//! | item | is |
//! |---|---|
//! | [`SmartCar`] | the application: drivers, map and records, on any board |
//! | [`SCHEDULE`] | its round: which activity runs at which millisecond |
//! | [`UNITS`] | the calibrations of its three infrared sensors |
//! | [`look`], [`mounting`], [`SWEEP`] | poses and directions of the sensors |
//! | [`GOAL`], [`CONTROL`], [`CHASSIS`] | its goal, its control rules and its wheels |
//!
//! The papers give the grid and the sensors' range. They do not say where the sensors sit, how finely they
//! sweep, or that the car moves; these choices are those of a model car.

mod application;
mod config;
mod control;
mod drive;
mod odometer;
mod round;

pub use application::{InitError, SmartCar, remote_wiring};
pub use config::{
    CELLS, CHASSIS, Chassis, FARTHEST, HEADS, MOTOR, NEAREST, POSE, RANGER, RANGERS, SENSORS,
    SERVO, SWEEP, SmartCarGrid, SmartCarShape, UNITS, Unit, VALIDATION, beam_model, look,
    look_from, mounting, ranger_mounting,
};
pub use control::{CONTROL, GOAL};
pub use drive::LOOK_AROUND;
pub use round::{SCHEDULE, SLOTS, STATIONS};
