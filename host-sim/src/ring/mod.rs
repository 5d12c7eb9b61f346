//! A simulated or recorded ring of sonars (\[003\]): what it measures, and which sonar is faulty.
//!
//! The acoustics and the lasers here compute their measurements from the world itself, in floating
//! point. The assessment is that of [`certainty_ring`], which has the measurements alone.

mod acoustics;
mod fault;
mod picture;
mod recording;
mod simulation;

pub use acoustics::{Acoustics, Face, Misalignment, PAPER_RING, PointMm, SONARS, Surfaces};
pub use fault::{RingDefect, RingFault, RingFaultError};
pub use picture::draw;
pub use recording::{
    DirectAssessment, FrozenRun, RecordingError, RingOptions, RingRecording, SensorSummary,
};
pub use simulation::{
    BEAMS, ELEMENTS, LaserPair, Observation, RingDiagnosis, RingSimulation, ScannerModel, Vectors,
};
