//! A recording of a real ring.

use super::super::simulate::percent;
use super::super::table::{row, table};
use super::super::{Failure, output};
use super::Arguments;
use certainty_ring::{Ring, RingConfig, RingRules};
use certainty_sim::ring::{DirectAssessment, FrozenRun, RingRecording, SensorSummary};
use serde::Serialize;
use std::path::Path;

/// What a recording without lasers and cross echoes cannot tell.
const NOT_ASSESSED: [&str; 3] = [
    "simulation-based confidence: no laser scan was recorded",
    "cross echoes: none were recorded, so no overlap with one",
    "the overall assessment: a sonar of which six overlaps are known is not declared faulty",
];

/// The report as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct Report<'a> {
    file: String,
    rows: usize,
    skipped: u64,
    range_mm: u32,
    overlaps_assessed: u32,
    overlaps_in_all: u32,
    sensors: &'a [SensorSummary],
    not_assessed: [&'static str; 3],
}

pub(super) fn run(arguments: &Arguments, file: &Path) -> Result<(), Failure> {
    let config = RingConfig {
        range: arguments.range,
        ..RingConfig::DEFAULT
    };
    let ring = Ring::try_new(config);
    let ring = ring.map_err(|error| Failure::Input(format!("--range: {error}")))?;
    let recording = RingRecording::load(file, arguments.range);
    let recording = recording.map_err(|error| Failure::input(&error))?;
    let assessed = DirectAssessment::of(&recording, &ring, &RingRules::DEFAULT);
    let (direct, all) = assessed.overlaps;
    let report = Report {
        file: file.display().to_string(),
        rows: recording.rows(),
        skipped: recording.skipped(),
        range_mm: arguments.range.get(),
        overlaps_assessed: direct,
        overlaps_in_all: all,
        sensors: &assessed.sensors,
        not_assessed: NOT_ASSESSED,
    };
    if arguments.json {
        output::print_json(&report)
    } else {
        output::print(&told(&report))
    }
}

fn told(report: &Report<'_>) -> String {
    let mut text = format!(
        "{}: {} rows, {} lines skipped; {} of {} independent overlaps of a sonar\n\n",
        report.file, report.rows, report.skipped, report.overlaps_assessed, report.overlaps_in_all
    );
    let share = |part: usize| percent(part as f64 / report.rows.max(1) as f64);
    let mut rows = vec![row([
        "sonar",
        "echo",
        "no object",
        "missing",
        "confirmed",
        "arcs met",
        "longest equal",
        "stuck",
        "blind",
    ])];
    for sensor in report.sensors {
        let longest = sensor.longest_equal.map_or(0, |run| run.rows);
        rows.push(vec![
            sensor.sensor.to_string(),
            share(sensor.echoes),
            share(sensor.no_object),
            share(sensor.missing),
            share(sensor.confirmed),
            format!("{:.1}", sensor.mean_intersections),
            longest.to_string(),
            sensor.stuck.len().to_string(),
            sensor.blind.len().to_string(),
        ]);
    }
    text += &table(&rows);
    text += &runs(report, "stuck while both neighbours moved", |sensor| {
        &sensor.stuck
    });
    text += &runs(
        report,
        "blind while both neighbours had near echoes",
        |sensor| &sensor.blind,
    );
    text += "\nnot assessed:\n";
    for line in report.not_assessed {
        text += &format!("  {line}\n");
    }
    text
}

/// The longest runs of one kind, with their lines.
fn runs(report: &Report<'_>, what: &str, of: fn(&SensorSummary) -> &Vec<FrozenRun>) -> String {
    const MOST: usize = 8;
    let sensors = report.sensors.iter();
    let runs = sensors.flat_map(|sensor| of(sensor).iter().map(|run| (sensor.sensor, *run)));
    let mut runs: Vec<_> = runs.collect();
    runs.sort_by_key(|&(sensor, run)| (core::cmp::Reverse(run.rows), sensor, run.from_line));
    let mut text = format!("\n{what}: {}\n", runs.len());
    for (sensor, run) in runs.iter().take(MOST) {
        let said = run
            .reading_mm
            .map_or("no object".into(), |mm| format!("{mm}mm"));
        let (from, to) = (run.from_line, run.to_line);
        text += &format!(
            "  sonar {sensor}: {said} in lines {from} to {to}, {} rows\n",
            run.rows
        );
    }
    if runs.len() > MOST {
        text += &format!(
            "  and {} shorter ones; --json lists all\n",
            runs.len() - MOST
        );
    }
    text
}
