//! The certainty grid wired to range sensors: what a robot's application is made of.
//!
//! | module | is |
//! |---|---|
//! | [`smart_car`] | the case study's robot: its grid, where its sensors sit, how they sweep |
//! | [`rehearsal`] | made-up readings through the real fusion level, to compare machines |
//! | [`ring_rehearsal`] | a made-up room through the real diagnosis of a sonar ring, likewise |
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

pub mod rehearsal;
pub mod ring_rehearsal;
pub mod smart_car;
