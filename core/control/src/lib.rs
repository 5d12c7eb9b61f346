#![doc = include_str!("../README.md")]
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

mod behaviours;
mod config;
mod controller;
mod cross_check;
mod diagnosis;
mod expected_scan;
mod failures;
mod histogram;
mod motion;
mod pilot;
mod sensors;
mod wgs84;

pub use behaviours::{Braitenberg, azimuth_turn, linear_speed, nearness};
pub use config::{
    ControlConfig, ControlConfigError, ControlRules, Corner, FailureSharing, Ramp, RampError,
    Weights,
};
pub use controller::{Command, ControlInput, Controller, SpeedLimit, Stamped};
pub use cross_check::{CrossCheck, CrossCheckConfig, CrossCheckConfigError, Verdict, Verdicts};
pub use diagnosis::{Assessment, Diagnosis, PlausibilityFilter};
pub use expected_scan::{
    CastRay, Completed, ExpectedScan, RayFan, RayHit, beam_in_map, scan_of_map,
};
pub use failures::{
    Coverage, CoverageConfig, Credibility, Failure, Failures, SENSORS, SensorFlags,
};
pub use histogram::{HistogramConfig, PolarHistogram, Threshold, Valley};
pub use motion::{Effort, Limits, Motion, Side, Wheels};
pub use pilot::{
    Decision, FailureSource, HistogramSource, Pilot, PilotError, PilotMaps, RobotMap, SensorModel,
};
pub use sensors::{
    BEAMS, Mountings, PerBeam, PerRangefinder, RANGEFINDERS, ScanGeometry, SensorReadings,
    beam_bearing,
};
pub use wgs84::{Wgs84, Wgs84Error};
