//! The Smart Car in a world, and how well each way to fuse its readings draws that world.

mod crew;
mod reference;
mod rig;
mod run;
mod score;

pub use crew::{Crew, CrewError, CrewMember};
pub use reference::{Reference, Truth};
pub use rig::{Mounting, Overlap, OverlapError, Profile, Rig, RigError};
pub use run::{Length, MethodResult, Run, STEP_MS, Setup, SetupError, TakenReading};
pub use score::{Score, Scored};
