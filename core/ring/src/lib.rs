//! Which sonar of a ring is wrong, from one scan around the robot (\[003\]).
//!
//! Lasers give a polygon of the surroundings; the polygon says what each sonar should hear; the
//! sonars' echoes are held against that, and against each other. No movement is needed.
//!
//! | module | \[003\] | turns |
//! |---|---|---|
//! | [`Scan`], [`Polygon`] | §3 | the beams of laser scanners into walls, corners and edges |
//! | [`Ring`], [`Distances::simulated`] | §4 | the polygon into the distance that each echo path should give |
//! | [`Echoes`], [`Distances::fold`] | §5 | the sonars' echoes into one distance a path |
//! | [`simulation_based`] | §5 | the two into how many of its seven paths each sonar gets right |
//! | [`intersection_based`] | §6 | the echoes alone into how many of 35 independent arcs each sonar's arcs meet |
//! | [`Monitor`] | §7 | both into who is removed, who returns, and each one's [`Health`](certainty_core::health::Health) |
//!
//! Everything is in the robot's frame: the origin in the middle of the ring, +x ahead. A cheaper
//! sibling that needs no laser is the certainty grid, whose [`RobustGrid`](certainty_core::fusion::RobustGrid)
//! finds a wrong sensor too, but only once others have seen the same cells.
//!
//! # Memory
//!
//! Two scanners of 361 beams and 24 sonars: 2.9 KB for the scan, 2.1 KB for 64 elements of the
//! polygon, and below 1 KB for everything else. The scan is of no use once there is a polygon.
//!
//! # Example
//!
//! ```
//! use certainty_ring::{
//!     Distances, Echoes, Monitor, Polygon, PolygonRules, Ring, RingConfig, RingRules, Scan, Scanner,
//! };
//! use certainty_core::transducer::Reading;
//! use certainty_core::units::{BinaryAngle, Direction, Millimeters, Pose};
//!
//! // A scanner in the middle of a square room of 3 m: two walls in each direction of a beam.
//! let scanner = Scanner::try_new(Pose::default(), Millimeters::new(8000))?;
//! let mut scan = Scan::<720>::new();
//! for half_degrees in 0..720 {
//!     let bearing = BinaryAngle::from_millidegrees(half_degrees * 500);
//!     let (cos, sin) = (bearing.direction().cos().abs(), bearing.direction().sin().abs());
//!     let range = (1500_i64 << Direction::FRACTION_BITS) / i64::from(cos.max(sin));
//!     scan.add(&scanner, bearing, Reading::Echo(Millimeters::new(range as u32)))?;
//! }
//! let polygon = Polygon::<16>::of(&scan, &PolygonRules::DEFAULT)?;
//! assert_eq!(polygon.elements().len(), 4);
//!
//! // Sonars that hear nothing in a room whose walls are 1.2 m away are all wrong.
//! let ring = Ring::<24>::try_new(RingConfig::DEFAULT)?;
//! let expected = Distances::simulated(&ring, &polygon);
//! let heard = Distances::fold(&ring, &Echoes::silent(), &RingRules::DEFAULT);
//! let mut monitor = Monitor::<24>::new(RingRules::DEFAULT);
//! let assessment = monitor.assess(&ring, Some(&expected), &heard);
//! assert!(assessment.simulation_based().iter().all(|&paths| paths < 7));
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```
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
mod assessment;
mod confidence;
mod distances;
mod echoes;
mod line;
mod place;
mod polygon;
mod ring;
mod scan;
mod simulation;
mod split;

pub use assessment::{Assessment, Monitor, Verdict, overall};
pub use confidence::{
    INDEPENDENT_OVERLAPS, Overlap, PATHS_OF_A_SENSOR, RingRules, RingRulesConfig, RingRulesError,
    independent_overlaps, intersection_based, overlaps, simulation_based,
};
pub use distances::{Distances, Folded};
pub use echoes::{Echoes, NoSuchPath};
pub use line::Line;
pub use place::FinePoint;
pub use polygon::{
    Element, ElementKind, Joint, Polygon, PolygonConfig, PolygonConfigError, PolygonRules,
    TooManyElements,
};
pub use ring::{NEIGHBOURS, Path, Ring, RingConfig, RingConfigError};
pub use scan::{Scan, Scanner, ScannerError, TooManyBeams};
