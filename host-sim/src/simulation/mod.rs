//! The Smart Car in a simulated world, and the scores of each fusion method's map of it.
//!
//! [`Setup::run`] takes the readings; [`Run::fuse`] fuses them by a method and scores the map against that of
//! perfect sensors.

mod run;
mod score;
mod sensor_layout;

pub use run::{Length, MethodResult, Run, STEP_MS, Setup, SetupError, SimulatedReading};
pub use score::{Reference, Score, ScoredCells, Truth};
pub use sensor_layout::{
    HeadPlacement, Profile, SensorLayout, SensorLayoutError, SweepOverlap, SweepOverlapError,
};
