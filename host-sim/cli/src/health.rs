//! A sensor's health as reports show it.

use certainty_core::health::{Confidence, Health};
use certainty_firmware::telemetry::SensorHealth;
use certainty_sim::fusion::Method;
use serde::Serialize;

/// A sensor's health in JSON; part of every sensor's entry.
#[derive(Debug, Serialize)]
pub(super) struct HealthReport {
    /// From 0 to 1.
    confidence: f64,
    confirmations: u32,
    contradictions: u32,
    missing: u32,
    status: String,
}

impl From<&Health> for HealthReport {
    fn from(health: &Health) -> Self {
        Self {
            confidence: share(health.confidence()),
            confirmations: health.confirmations(),
            contradictions: health.contradictions(),
            missing: health.missing(),
            status: health.status().to_string(),
        }
    }
}

impl From<&SensorHealth> for HealthReport {
    fn from(health: &SensorHealth) -> Self {
        Self {
            confidence: share(health.confidence),
            confirmations: health.confirmations,
            contradictions: health.contradictions,
            missing: health.missing,
            status: health.status.to_string(),
        }
    }
}

/// A confidence from 0 to 1.
fn share(confidence: Confidence) -> f64 {
    f64::from(confidence.to_bits()) / f64::from(u16::MAX)
}

impl HealthReport {
    /// The heads of the columns that [`Self::cells`] fills.
    pub(super) const COLUMNS: [&str; 5] = [
        "confidence",
        "confirmed",
        "contradicted",
        "missing",
        "status",
    ];

    /// The columns of a table.
    pub(super) fn cells(&self) -> [String; 5] {
        [
            format!("{:.2}", self.confidence),
            self.confirmations.to_string(),
            self.contradictions.to_string(),
            self.missing.to_string(),
            self.status.clone(),
        ]
    }
}

/// What must be said beside the health that these methods report: a line, or nothing.
pub(super) fn caveat(methods: impl IntoIterator<Item = Method>) -> &'static str {
    if methods.into_iter().any(|method| method == Method::Robust) {
        ""
    } else {
        "Only the robust method compares sensors; here only missing readings count.\n"
    }
}
