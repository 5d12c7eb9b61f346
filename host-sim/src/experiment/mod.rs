//! The Smart Car in a world, and how well each way to fuse its readings draws that world.

pub mod campaign;
mod crew;
mod oracle;
pub mod recovery;
mod reference;
mod rig;
mod run;
mod score;
mod statistics;
pub mod table2;

pub use crew::{Crew, CrewError, CrewMember};
pub use oracle::Oracle;
pub use reference::{Reference, Truth};
pub use rig::{Mounting, Overlap, Profile, Rig, RigError};
pub use run::{Length, MethodResult, Run, STEP_MS, Setup, SetupError, TakenReading};
pub use score::{Score, Scored};
pub use statistics::{Estimate, Waits, standard_deviation};
