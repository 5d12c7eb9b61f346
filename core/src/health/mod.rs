//! How far a sensor can be trusted, and what a maintenance plan reads about it.

mod confidence;
mod learning;
mod record;
mod status;

pub use confidence::Confidence;
pub use learning::{Blame, Learning, Stride, Word};
pub use record::Health;
pub use status::{HealthConfig, HealthConfigError, HealthRules, Status};
