//! Tables for terminals, and the sensors' health in them.

use certainty_core::health::{Confidence, Health};
use certainty_firmware::telemetry::SensorHealth;
use certainty_sim::fusion::Method;
use serde::Serialize;

/// Renders rows with aligned columns: the first to the left, the others to the right, two spaces between.
pub(super) fn table(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let mut line = String::new();
        for (column, (cell, &width)) in row.iter().zip(&widths).enumerate() {
            if column == 0 {
                line += &format!("{cell:<width$}");
            } else {
                line += &format!("  {cell:>width$}");
            }
        }
        text += line.trim_end();
        text.push('\n');
    }
    text
}

/// Returns a row of a table.
pub(super) fn row<const N: usize>(cells: [&str; N]) -> Vec<String> {
    cells.map(str::to_owned).into()
}

/// Returns a share as a percentage.
pub(super) fn percent(share: f64) -> String {
    format!("{:.1} %", share * 100.0)
}

/// A sensor's health, as JSON documents and tables have it.
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

/// Returns a confidence as a share of the full one, from 0 to 1.
fn share(confidence: Confidence) -> f64 {
    f64::from(confidence.to_bits()) / f64::from(u16::MAX)
}

impl HealthReport {
    /// The headings of [`Self::cells`].
    pub(super) const COLUMNS: [&str; 5] = [
        "confidence",
        "confirmed",
        "contradicted",
        "missing",
        "status",
    ];

    /// Returns a row's cells of a table.
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

/// Returns the note below a health table of these methods: a line, or nothing.
pub(super) fn caveat(methods: impl IntoIterator<Item = Method>) -> &'static str {
    if methods.into_iter().any(|method| method == Method::Robust) {
        ""
    } else {
        "Only the robust method compares sensors; here only missing readings count.\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned() {
        let rows = [row(["method", "mae"]), row(["bayes", "0.1"])];
        assert_eq!(table(&rows), "method  mae\nbayes   0.1\n");
    }
}
