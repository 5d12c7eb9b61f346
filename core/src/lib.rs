//! Certainty grids that survive faulty range sensors, for microcontrollers.
//!
//! Three levels, one way, after \[000\] §2:
//!
//! | level | module | turns |
//! |---|---|---|
//! | transducer | [`transducer`] | a sensor's answer into a [`Reading`](transducer::Reading) that says why it is what it is |
//! | fusion | [`fusion`], [`health`] | readings into a [`CertaintyGrid`](fusion::CertaintyGrid) and each sensor's [`Health`](health::Health) |
//! | control | the package `certainty-control` | readings, failures and a goal into motion; an [`Environment`](fusion::Environment) too |
//!
//! Which sensor does what when, and so the order of the readings, is a [`schedule`].
//!
//! | paper | is in |
//! |---|---|
//! | \[000\] §3 no two sensors look the same way at once | [`schedule::Schedule`], [`transducer::Sweep`] |
//! | \[000\] §3.1 trimmed fusion | [`fusion::TrimmedGrid`] |
//! | \[000\] §3.2, \[001\] §4 median selection | [`fusion::MedianGrid`] |
//! | \[001\] §3 eq. 1, Bayes | [`fusion::BayesGrid`], [`fusion::LogOdds`] |
//! | \[001\] §5 Fig. 3, `AddToGrid` | [`fusion::RobustGrid`] |
//! | \[001\] §6.1 *no object* by fluctuation | [`transducer::Fluctuation`] |
//! | \[001\] §7, memory | [`fusion::owner_bytes`] |
//! | \[002\] Fig. 1, local sensor validation | [`transducer::Validator`] |
//! | \[002\] Fig. 1, data flow | [`fusion::Mapper`] |
//! | \[003\] error detection for a sonar ring | the package `certainty-ring` |
//! | \[004\] §3, eq. 1 to 16 | the package `certainty-control` |
//!
//! No heap, no clock, no I/O, no `unsafe`, no panic. The grid's path is integers only: the same
//! readings give the same bits on a Cortex-M3 and on a workstation.
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

pub mod certainty;
pub mod fusion;
pub mod health;
pub mod narrow;
pub mod schedule;
pub mod sensor;
pub mod transducer;
pub mod units;
