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

mod arc;
mod confidence;
mod distances;
mod geometry;
mod monitor;
mod polygon;
mod ring;
mod scan;
mod simulation;

pub use confidence::{
    INDEPENDENT_OVERLAPS, Overlap, PATHS_OF_A_SENSOR, independent_overlaps, intersection_based,
    overlaps, simulation_based,
};
pub use distances::{Distances, Echoes, Folded, NoSuchPath};
pub use geometry::{FinePoint, FittedLine};
pub use monitor::{Assessment, Monitor, SonarVerdict, overall};
pub use polygon::{
    Element, ElementKind, Joint, Polygon, PolygonRules, PolygonRulesError, TooManyElements,
};
pub use ring::{
    NEIGHBOURS, Path, Ring, RingConfig, RingConfigError, RingRules, RingRulesConfig, RingRulesError,
};
pub use scan::{Scan, Scanner, ScannerError, TooManyBeams};
