//! The Smart Car in a world, and how well each way to fuse its readings draws that world.

mod reference;
mod run;
mod score;
mod sensor_layout;
mod sensor_set;

pub use reference::{Reference, Truth};
pub use run::{Length, MethodResult, Run, STEP_MS, Setup, SetupError, TakenReading};
pub use score::{Score, Scored};
pub use sensor_layout::{
    HeadPlacement, Profile, SensorLayout, SensorLayoutError, SweepOverlap, SweepOverlapError,
};
pub use sensor_set::{CarSensor, SensorSet, SensorSetError};
