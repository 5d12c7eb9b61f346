//! What a replay reports.

use super::super::health::{HealthReport, caveat};
use super::super::output;
use super::super::table::{row, table};
use super::{Arguments, Replayed};
use certainty_sim::export::shown;
use certainty_sim::fusion::HostMapper;
use serde::Serialize;
use std::path::PathBuf;

/// The report as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    readings: u64,
    echo: u64,
    no_object: u64,
    too_near: u64,
    missing: u64,
    skipped_lines: u64,
    cells_updated: u64,
    insert_seconds: f64,
    grid: GridReport,
    sensors: Vec<SensorReport>,
    files: Vec<String>,
}

#[derive(Debug, Serialize)]
struct GridReport {
    width: u16,
    height: u16,
    cell_mm: u32,
    bytes_per_cell: f64,
}

#[derive(Debug, Serialize)]
struct SensorReport {
    id: u8,
    readings: u32,
    #[serde(flatten)]
    health: HealthReport,
}

impl Report {
    pub(super) fn new(replayed: &Replayed, files: &[PathBuf]) -> Self {
        let tally = replayed.recording.tally();
        let geometry = replayed.mapper.geometry();
        let bytes = replayed.mapper.memory_bytes() as f64;
        Self {
            readings: replayed.recording.beams.len() as u64,
            echo: tally.echo,
            no_object: tally.no_object,
            too_near: tally.too_near,
            missing: tally.missing,
            skipped_lines: replayed.recording.skipped.total(),
            cells_updated: replayed.cells_updated,
            insert_seconds: replayed.insertion.as_secs_f64(),
            grid: GridReport {
                width: geometry.columns(),
                height: geometry.rows(),
                cell_mm: geometry.cell_size().get(),
                bytes_per_cell: bytes / f64::from(geometry.cells()),
            },
            sensors: sensors(&replayed.mapper),
            files: output::listed(files),
        }
    }
}

fn sensors(mapper: &HostMapper) -> Vec<SensorReport> {
    let known = mapper.health().into_iter();
    let report = known.map(|(id, health)| SensorReport {
        id: id.number(),
        readings: health.readings(),
        health: HealthReport::from(&health),
    });
    report.collect()
}

/// The report for people.
pub(super) fn told(arguments: &Arguments, replayed: &Replayed, files: &[PathBuf]) -> String {
    let Replayed {
        mapper, recording, ..
    } = replayed;
    let tally = recording.tally();
    let geometry = mapper.geometry();
    let mut text = format!(
        "{}: {} readings: {} echoes, {} without object, {} too near, {} missing\n",
        shown(&arguments.file),
        recording.beams.len(),
        tally.echo,
        tally.no_object,
        tally.too_near,
        tally.missing
    );
    if recording.backward_steps > 0 {
        text += &format!(
            "{} times the clock went backwards\n",
            recording.backward_steps
        );
    }
    if recording.skipped.total() > 0 {
        text += &format!("{} lines skipped:", recording.skipped.total());
        for (reason, count) in recording.skipped.counts() {
            text += &format!(" {count} x {reason};");
        }
        for skipped in recording.skipped.first() {
            text += &format!("\n  line {}: {}", skipped.line, skipped.reason);
        }
        text.push('\n');
    }
    text += &format!(
        "map: {} x {} cells of {}, {} bytes, by {}; {} cells updated\n\n",
        geometry.columns(),
        geometry.rows(),
        geometry.cell_size(),
        mapper.memory_bytes(),
        arguments.fusion,
        replayed.cells_updated
    );
    let mut rows = vec![[row(["sensor", "readings"]), row(HealthReport::COLUMNS)].concat()];
    rows.extend(sensors(mapper).into_iter().map(|sensor| {
        let mut cells = vec![sensor.id.to_string(), sensor.readings.to_string()];
        cells.extend(sensor.health.cells());
        cells
    }));
    text += &table(&rows);
    text += caveat([arguments.fusion]);
    text.push('\n');
    for file in files {
        text += &format!("{}\n", shown(file));
    }
    text
}
