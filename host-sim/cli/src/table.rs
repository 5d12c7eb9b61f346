//! Tables for terminals, and the sensors' health in them.

use certainty_core::health::Health;
use certainty_firmware::telemetry::SensorHealth;
use certainty_sim::fusion::Method;
use certainty_sim::quantity::share;
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

/// Returns a share as a percentage, or a dash without one.
pub(super) fn percent_or_dash(share: Option<f64>) -> String {
    share.map_or_else(|| "-".to_owned(), percent)
}

/// Returns the items with `separator` between two, or `none` without any.
pub(super) fn list<T: ToString>(items: impl IntoIterator<Item = T>, separator: &str) -> String {
    let items: Vec<String> = items.into_iter().map(|item| item.to_string()).collect();
    if items.is_empty() {
        "none".to_owned()
    } else {
        items.join(separator)
    }
}

/// Returns a count with its noun in the singular or, with an `s`, in the plural.
pub(super) fn counted(count: u64, noun: &str) -> String {
    match count {
        1 => format!("1 {noun}"),
        count => format!("{count} {noun}s"),
    }
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
    fn one_is_singular_and_an_empty_list_is_none() {
        assert_eq!(counted(1, "line"), "1 line");
        assert_eq!([0, 2].map(|n| counted(n, "line")), ["0 lines", "2 lines"]);
        assert_eq!(list([4, 7], ", "), "4, 7");
        assert_eq!(list([""; 0], ", "), "none");
    }

    #[test]
    fn columns_are_aligned() {
        let rows = [row(["method", "mae"]), row(["bayes", "0.1"])];
        assert_eq!(table(&rows), "method  mae\nbayes   0.1\n");
    }
}
