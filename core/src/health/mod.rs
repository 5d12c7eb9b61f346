//! How far a sensor can be trusted, and what a maintenance plan reads about it.

mod confidence;
mod learning;
mod record;
mod status;

pub use confidence::Confidence;
pub use learning::{Claim, FaultAttribution, Learning, StepRule};
pub use record::Health;
pub use status::{HealthConfig, HealthConfigError, HealthRules, Status};
