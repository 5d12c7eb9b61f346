//! The control level: from readings and the sensors' health to motion, after \[004\].
//!
//! ```text
//! rangefinders ── nearness (3, 5) ── Braitenberg (2, 4) ───────┐
//! scanner, or ─── histogram (6–8) ── valley (9, 11) ───────────┤ weights α, credibility μ (1, 14, 15)
//! the map                                                      ├─► motion ─► coverage ─► limits (16) ─► wheels
//! pose, goal ──── bearing (10) ───── azimuth (12), speed (13) ─┘
//! Health, cross-check ─► Failures ───── φ ─────────────────────┘
//! ```
//!
//! [`Controller`] composes it; each part stands alone too. What the paper has as a given vector of zeros
//! and ones, [`Failures`], is here as continuous as what it is made of: the operator's word, the fusion
//! level's [`Health`](certainty_core::health::Health), or a [`CrossCheck`].
//!
//! Angles count counter-clockwise, turning left is positive. All is integers and sign-symmetric: mirrored
//! readings have mirrored commands and mirrored diagnoses, to the bit. (What is looked up in a map is mirrored to
//! a millimetre, which is what the centre of a cell is rounded by.)
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

mod azimuth;
mod braitenberg;
mod controller;
mod coverage;
mod credibility;
mod cross_check;
mod expected_scan;
mod failures;
mod histogram;
mod limits;
mod map_scan;
mod motion;
mod nearness;
mod ramp;
mod ray_fan;
mod rules;
mod speed;
mod valley;
mod views;
mod wgs84;

pub use azimuth::azimuth_turn;
pub use braitenberg::{Braitenberg, PerRangefinder, RANGEFINDERS};
pub use controller::{Command, ControlInput, Controller, SpeedLimit, Stamped};
pub use coverage::{Coverage, CoverageConfig};
pub use credibility::Credibility;
pub use cross_check::{CrossCheck, CrossCheckConfig, CrossCheckConfigError, Verdict, Verdicts};
pub use expected_scan::{Completed, ExpectedScan};
pub use failures::{Failure, Failures, SENSORS};
pub use histogram::{BEAMS, HistogramConfig, MIDDLE_BEAM, PerBeam, PolarHistogram, beam_bearing};
pub use limits::Limits;
pub use map_scan::{RayHit, beam_in_map, scan_of_map};
pub use motion::{Effort, Motion, Side, Wheels};
pub use nearness::{Mounting, nearness};
pub use ramp::{Corner, Ramp, RampError};
pub use ray_fan::RayFan;
pub use rules::{Blame, ControlConfig, ControlConfigError, ControlRules, Weights};
pub use speed::linear_speed;
pub use valley::{Threshold, Valley};
pub use views::Views;
pub use wgs84::Wgs84;
