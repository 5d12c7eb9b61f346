//! Many places: how many faults are found, and how well the polygons show the world.

use super::super::simulate::percent;
use super::super::table::{row, table};
use super::super::{Failure, output};
use super::Arguments;
use certainty_repro::ring_extraction::{Extraction, ExtractionRow};
use certainty_repro::ring_sweep::{KindRow, PoseResult, Sweep, Swept};
use certainty_sim::quantity::Excerpt;
use certainty_sim::ring::RingDefect;
use certainty_sim::world::World;
use serde::Serialize;

/// The sweep as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct Report<'a> {
    seed: u64,
    world: &'a str,
    fault: &'static str,
    rules: &'static str,
    poses: u32,
    faulty_found: u32,
    missed_faults: u32,
    false_alarms: u32,
    vectors: &'a [PoseResult],
    kinds: &'a [KindRow],
}

pub(super) fn faults(arguments: &Arguments, world: &World) -> Result<(), Failure> {
    let situation = arguments.situation(world);
    let [falsified, ..] = RingDefect::ALL;
    let first = arguments.faults.first();
    let sweep = Sweep {
        situation: &situation,
        defect: first.map_or(falsified, |fault| fault.defect),
        poses: arguments.poses,
        seed: arguments.seed,
    };
    let swept = arguments.jobs.run(|| sweep.run())?;
    let swept = swept.map_err(|error| Failure::input(&error))?;
    let found = swept.poses.iter().filter(|pose| pose.found).count() as u32;
    let report = Report {
        seed: arguments.seed,
        world: world.name(),
        fault: sweep.defect.kind(),
        rules: arguments.rules.name(),
        poses: arguments.poses,
        faulty_found: found,
        missed_faults: arguments.poses - found,
        false_alarms: swept.false_alarms,
        vectors: &swept.poses,
        kinds: &swept.rows,
    };
    if arguments.json {
        output::print_json(&report)
    } else {
        output::print(&told(&report, &swept))
    }
}

fn told(report: &Report<'_>, swept: &Swept) -> String {
    let mut text = format!(
        "world: {}   places: {}   seed: {}   rules: {}\n\
         one sonar {}: {} found, {} missed; without a fault: {} false alarms\n\n",
        report.world,
        report.poses,
        report.seed,
        report.rules,
        report.fault,
        report.faulty_found,
        report.missed_faults,
        report.false_alarms
    );
    let mut rows = vec![row([
        "fault",
        "at once",
        "faults",
        "found",
        "no effect",
        "detected",
        "of those with effect",
        "false alarms",
    ])];
    for kind in &swept.rows {
        rows.push(vec![
            kind.kind.to_owned(),
            kind.faulty_sensors.to_string(),
            kind.faults.to_string(),
            kind.found.to_string(),
            kind.without_effect.to_string(),
            percent(kind.detection_rate),
            percent(kind.detection_rate_with_effect),
            kind.false_alarms.to_string(),
        ]);
    }
    text += &table(&rows);
    text
}

/// The polygons' quality as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct ExtractionReport<'a> {
    seed: u64,
    world: &'a str,
    poses: u32,
    rows: &'a [ExtractionRow],
}

pub(super) fn extraction(arguments: &Arguments, world: &World) -> Result<(), Failure> {
    let situation = arguments.situation(world);
    let extraction = Extraction {
        situation: &situation,
        poses: arguments.poses,
        seed: arguments.seed,
    };
    let rows = extraction.run().map_err(|error| Failure::input(&error))?;
    if arguments.json {
        return output::print_json(&ExtractionReport {
            seed: arguments.seed,
            world: world.name(),
            poses: arguments.poses,
            rows: &rows,
        });
    }
    let mut lines = vec![row([
        "resolution",
        "noise",
        "segments",
        "found",
        "walls",
        "corners",
        "found",
        "mean error",
        "worst",
        "refused",
    ])];
    for row in &rows {
        lines.push(vec![
            format!("{}mm", row.resolution_mm),
            format!("{}mm", row.noise_mm),
            row.segments.to_string(),
            row.segments_found.to_string(),
            row.walls.to_string(),
            row.corners.to_string(),
            row.corners_found.to_string(),
            format!("{:.1}mm", row.mean_corner_error_mm),
            format!("{:.1}mm", row.worst_corner_error_mm),
            row.refused.to_string(),
        ]);
    }
    let (name, poses, seed) = (Excerpt::new(world.name()), arguments.poses, arguments.seed);
    let heading = format!("world: {name}   places: {poses}   seed: {seed}\n\n");
    output::print(&(heading + &table(&lines)))
}
