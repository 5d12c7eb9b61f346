//! The Smart Car in a world, and how well each way to fuse its readings draws that world.

mod crew;
mod reference;
mod run;
mod score;

pub use crew::{Crew, CrewError, CrewMember};
pub use reference::{Reference, Truth};
pub use run::{MethodResult, Run, STEP_MS, Setup, SetupError};
pub use score::Score;
