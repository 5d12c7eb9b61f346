//! A sonar ring and two laser scanners in a world (\[003\]): what they measure, and which sonar is wrong.
//!
//! The lasers and the acoustics here know the world itself, in floating point; what is made of their
//! readings is the core's [`diagnosis`](certainty_ring), which knows the readings alone.

mod acoustics;
mod fault;
mod lasers;
mod observation;
mod picture;
mod recording;
pub mod surfaces;

pub use acoustics::{Acoustics, Turned};
pub use fault::{RingDefect, RingFault, RingFaultError};
pub use lasers::{LaserPair, ScannerModel};
pub use observation::{Judged, Observation, Situation, Vectors};
pub use picture::draw;
pub use recording::{
    DirectAssessment, FrozenRun, RecordingError, RingRecording, SensorSummary, WideRing,
};

use certainty_ring::{Ring, RingConfig};

/// How many sonars the ring has.
pub const SONARS: usize = 24;

/// How many elements a polygon may have.
pub const ELEMENTS: usize = 128;

/// How many beams the two scanners have together.
pub const BEAMS: usize = 722;

/// Returns the paper's ring.
///
/// # Panics
///
/// Never: the paper's ring is one.
#[must_use]
pub fn paper_ring() -> Ring<SONARS> {
    Ring::try_new(RingConfig::DEFAULT).expect("the paper's ring is a ring")
}
