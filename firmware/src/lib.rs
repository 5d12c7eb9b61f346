#![doc = include_str!("../README.md")]
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]
// For shipped code only: tests may unwrap, index and cast.
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
pub mod ranger;
pub mod remote;
pub mod servo;
pub mod smart_car;
pub mod telemetry;
pub mod timing;
