//! The health of a sensor: its confidence, the counts behind it and a status for maintenance.

mod confidence;
mod learning;
mod record;
mod status;

pub use confidence::Confidence;
pub use learning::{Claim, FaultAttribution, Learning, StepRule};
pub use record::Health;
pub use status::{HealthRules, Status};
