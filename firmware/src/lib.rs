//! The certainty grid wired to range sensors: what a robot's application is made of.
//!
//! | module | is |
//! |---|---|
//! | [`smart_car`] | the case study's robot: its grid, where its sensors sit, how they sweep |
//! | [`gp2d02`] | driver of a Sharp GP2D02 infrared sensor on two pins |
//! | [`servo`] | driver of a hobby servo on a PWM channel |
//! | [`motors`] | driver of two drive motors on PWM channels |
//! | [`ranger`] | driver of a pulse-echo ultrasonic ranger on two pins |
//! | [`pulse`] | pulses of hobby devices |
//! | [`stopwatch`] | time as the drivers see it |
//! | [`telemetry`] | framed reports to whoever listens: map, heads, health, the schedule's statistics |
//! | [`executive`] | the time-triggered main loop: each slot at its tick, or not at all |
//! | [`mailbox`] | where an interrupt and the main loop leave things for each other |
//! | [`board`] | what the application is wired to, as a list of types |
//! | [`remote`] | a board whose pins, pulses and time are at the far end of a link |
//! | [`digest`] | a fingerprint of maps and records, to compare machines |
//!
//! Everything here runs on the microcontroller and, unchanged, in the host's simulator.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]
// Strict in what ships, not in tests: a test may unwrap, index and cast.
#![cfg_attr(
    not(test),
    warn(
        clippy::arithmetic_side_effects,
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        clippy::cast_sign_loss,
        clippy::expect_used,
        clippy::float_arithmetic,
        clippy::indexing_slicing,
        clippy::panic,
        clippy::unreachable,
        clippy::unwrap_used,
    )
)]

pub mod board;
pub mod digest;
pub mod executive;
pub mod gp2d02;
pub mod mailbox;
pub mod motors;
pub mod pulse;
pub mod ranger;
pub mod remote;
pub mod servo;
pub mod smart_car;
pub mod stopwatch;
pub mod telemetry;
