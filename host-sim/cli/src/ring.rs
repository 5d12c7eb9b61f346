//! `certainty ring`: which sonar of a ring is faulty (\[003\]).

use super::table::{row, table};
use super::{Failure, output};
use crate::options::Jobs;
use crate::table::percent;
use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose};
use certainty_repro::ring_study::{
    Extraction, ExtractionRow, FaultSweep, KindRow, PoseResult, SweepResult,
};
use certainty_ring::{ElementKind, Joint, Ring, RingConfig, RingRules};
use certainty_sim::export::{OutDir, display_path};
use certainty_sim::quantity::{self, Excerpt};
use certainty_sim::ring::{
    DirectAssessment, FrozenRun, Observation, RingDefect, RingDiagnosis, RingFault, RingRecording,
    RingSimulation, SONARS, SensorSummary, Vectors, draw,
};
use certainty_sim::world::World;
use clap::{Args, ValueEnum};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The arguments.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The obstacles: a TOML file; without it, the built-in office
    #[arg(long, value_name = "FILE", conflicts_with = "recording")]
    world: Option<PathBuf>,
    /// The robot's position and heading, such as 2.5m,1.8m,30deg [default: the office's centre]
    #[arg(long, value_name = "X,Y,HEADING", value_parser = pose, allow_hyphen_values = true,
          conflicts_with_all = ["recording", "sweep", "extraction"])]
    pose: Option<Pose>,
    /// A fault: a sonar's number from 1, or a kind and a sonar, such as crosstalk:4 or stuck:7=350mm; repeatable.
    /// With --sweep, the kind of the first one counts
    #[arg(
        long = "fault",
        value_name = "[KIND:]SENSOR[=VALUE]",
        conflicts_with = "recording"
    )]
    faults: Vec<RingFault>,
    /// Check at many poses, with and without every kind of fault
    #[arg(long, conflicts_with_all = ["recording", "extraction"])]
    sweep: bool,
    /// Compare the polygons at many poses with the world
    #[arg(long, conflicts_with = "recording")]
    extraction: bool,
    /// How many confirmations a sonar needs: one, as in [003], or three
    #[arg(
        long,
        value_enum,
        default_value_t,
        conflicts_with_all = ["recording", "extraction"]
    )]
    rules: Rules,
    /// How many poses
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    poses: u32,
    /// A recording of a real ring: 24 distances in metres per line
    #[arg(long, value_name = "FILE")]
    recording: Option<PathBuf>,
    /// The recorded sonars' range
    #[arg(long, value_name = "LENGTH", default_value = "5m", value_parser = quantity::length)]
    range: Millimeters,
    /// The seed: the same seed gives the same result
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        allow_hyphen_values = true
    )]
    seed: u64,
    #[command(flatten)]
    jobs: Jobs,
    /// Folder for the pictures
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Print one JSON document instead
    #[arg(long)]
    json: bool,
}

/// The rules that can be chosen on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum Rules {
    /// One confirmation is enough
    #[default]
    Paper,
    /// Three confirmations are needed
    Wary,
}

impl Rules {
    const fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Wary => "wary",
        }
    }

    const fn rules(self) -> RingRules {
        match self {
            Self::Paper => RingRules::DEFAULT,
            Self::Wary => RingRules::WARY,
        }
    }
}

impl Arguments {
    /// The ring in a world, checked by these rules.
    fn simulation<'a>(&self, world: &'a World) -> RingSimulation<'a> {
        let mut simulation = RingSimulation::new(world);
        simulation.rules = self.rules.rules();
        simulation
    }
}

/// Parses a pose.
fn pose(text: &str) -> Result<Pose, String> {
    let mut parts = text.split(',');
    let mut part = || {
        let example = "expected x, y and heading, such as 2.5m,1.8m,30deg";
        parts
            .next()
            .ok_or_else(|| format!("a part is missing: {example}"))
    };
    let length = |text: &str| quantity::signed_length(text).map_err(|error| error.to_string());
    let (x, y) = (length(part()?)?, length(part()?)?);
    let heading = quantity::angle(part()?).map_err(|error| error.to_string())?;
    match parts.next() {
        None => Ok(Pose::new(Point::from_mm(x.get(), y.get()), heading)),
        Some(_) => {
            Err("more than three parts: expected x, y and heading, such as 2.5m,1.8m,30deg".into())
        }
    }
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    output::check_listable(arguments.json, &arguments.out)?;
    if let Some(recording) = &arguments.recording {
        return recorded(arguments, recording);
    }
    let world = match &arguments.world {
        Some(file) => World::load(file).map_err(|error| Failure::input(&error))?,
        None => World::office(),
    };
    if arguments.sweep {
        sweep(arguments, &world)
    } else if arguments.extraction {
        extraction(arguments, &world)
    } else {
        check(arguments, &world)
    }
}

/// The sonars' numbers, for a table's first column.
fn numbers() -> impl Iterator<Item = String> {
    (1..=SONARS).map(|number| number.to_string())
}

/// Numbers as a list, or `none`.
fn listed(numbers: &[u8]) -> String {
    if numbers.is_empty() {
        return "none".into();
    }
    let texts: Vec<String> = numbers.iter().map(ToString::to_string).collect();
    texts.join(", ")
}

/// The default pose in the office.
const CENTRE: Pose = Pose::new(
    Point::from_mm(2200, 2300),
    BinaryAngle::from_millidegrees(10_000),
);

/// The report of one check as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct CheckReport {
    seed: u64,
    world: String,
    pose: PoseReport,
    faults: Vec<String>,
    rules: &'static str,
    faulty: Vec<u8>,
    vectors: Vectors,
    verdicts: Vec<String>,
    polygon: PolygonReport,
    files: Vec<String>,
}

#[derive(Debug, Serialize)]
struct PoseReport {
    x_mm: i32,
    y_mm: i32,
    heading_deg: f64,
}

#[derive(Debug, Serialize)]
struct PolygonReport {
    beams: usize,
    walls: usize,
    pseudo: usize,
    corners: usize,
    edges: usize,
}

impl PolygonReport {
    fn of(observation: &Observation) -> Self {
        let elements = observation.polygon.elements();
        let of = |kind| elements.iter().filter(|e| e.kind() == kind).count();
        let joints = |joint| elements.iter().filter(|e| e.joint() == joint).count();
        Self {
            beams: observation.scan.points().len(),
            walls: of(ElementKind::Wall),
            pseudo: of(ElementKind::Pseudo),
            corners: joints(Joint::Corner),
            edges: joints(Joint::Edge),
        }
    }
}

/// Checks the ring at one pose.
fn check(arguments: &Arguments, world: &World) -> Result<(), Failure> {
    let robot = match arguments.pose {
        Some(pose) => pose,
        None if arguments.world.is_none() => CENTRE,
        None => {
            let line =
                "--pose: missing with --world: expected a pose, such as --pose 2.5m,1.8m,30deg";
            return Err(Failure::Input(line.into()));
        }
    };
    if world.occupied(robot.at) {
        let (x, y) = (robot.at.x_mm(), robot.at.y_mm());
        let line = format!("--pose: an obstacle covers {x}mm,{y}mm: expected a free position");
        return Err(Failure::Input(line));
    }
    let simulation = arguments.simulation(world);
    let observation = simulation.observe(robot, &arguments.faults, arguments.seed, 0);
    let observation = observation.map_err(|error| {
        Failure::Input(format!("{}: {error}; use fewer obstacles", world.name()))
    })?;
    let diagnosis = simulation.assess(&observation);
    let out = OutDir::create(&arguments.out).map_err(|error| Failure::input(&error))?;
    let files = draw(&simulation, &observation, &diagnosis, &out);
    let files = files.map_err(|error| Failure::input(&error))?;
    if arguments.json {
        output::print_json(&check_report(
            arguments,
            world,
            robot,
            &observation,
            &diagnosis,
            &files,
        ))
    } else {
        output::print(&render_check(
            arguments,
            world,
            robot,
            &observation,
            &diagnosis,
        ))
    }
}

fn faulty(diagnosis: &RingDiagnosis) -> Vec<u8> {
    diagnosis
        .assessment
        .faulty()
        .map(|id| id.number())
        .collect()
}

fn check_report(
    arguments: &Arguments,
    world: &World,
    robot: Pose,
    observation: &Observation,
    diagnosis: &RingDiagnosis,
    files: &[PathBuf],
) -> CheckReport {
    let verdicts = diagnosis.assessment.verdicts().iter();
    CheckReport {
        seed: arguments.seed,
        world: world.name().to_owned(),
        pose: PoseReport {
            x_mm: robot.at.x_mm(),
            y_mm: robot.at.y_mm(),
            heading_deg: f64::from(robot.heading.to_bits()) * 360.0 / 65536.0,
        },
        faults: arguments.faults.iter().map(ToString::to_string).collect(),
        rules: arguments.rules.name(),
        faulty: faulty(diagnosis),
        vectors: Vectors::of(&diagnosis.assessment),
        verdicts: verdicts.map(ToString::to_string).collect(),
        polygon: PolygonReport::of(observation),
        files: output::listed(files),
    }
}

fn render_check(
    arguments: &Arguments,
    world: &World,
    robot: Pose,
    observation: &Observation,
    diagnosis: &RingDiagnosis,
) -> String {
    let faults: Vec<String> = arguments.faults.iter().map(ToString::to_string).collect();
    let faults = if faults.is_empty() {
        "none".to_owned()
    } else {
        faults.join(", ")
    };
    let polygon = PolygonReport::of(observation);
    let mut text = format!(
        "world: {}   robot: {}mm, {}mm, {:.1}deg   seed: {}   rules: {}\nfault: {faults}\n\
         polygon of {} beams: {} walls, {} pseudo line segments, {} corners, {} edges\n\n",
        Excerpt::new(world.name()),
        robot.at.x_mm(),
        robot.at.y_mm(),
        f64::from(robot.heading.to_bits()) * 360.0 / 65536.0,
        arguments.seed,
        arguments.rules.name(),
        polygon.beams,
        polygon.walls,
        polygon.pseudo,
        polygon.corners,
        polygon.edges,
    );
    let vectors = Vectors::of(&diagnosis.assessment);
    let mut rows = vec![row([
        "sonar",
        "simulation",
        "intersection",
        "overall",
        "verdict",
    ])];
    let verdicts = diagnosis.assessment.verdicts();
    for (slot, number) in numbers().enumerate() {
        rows.push(vec![
            number,
            vectors.simulation_based[slot].to_string(),
            vectors.intersection_based[slot].to_string(),
            vectors.overall[slot].to_string(),
            verdicts[slot].to_string(),
        ]);
    }
    text += &table(&rows);
    text += &format!(
        "\nfaulty: {}\npictures: {}/ring-*.png, .svg\n",
        listed(&faulty(diagnosis)),
        display_path(&arguments.out)
    );
    text
}

/// The report of a sweep as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct SweepReport<'a> {
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

/// Checks the ring at many poses with every kind of fault.
fn sweep(arguments: &Arguments, world: &World) -> Result<(), Failure> {
    let simulation = arguments.simulation(world);
    let [falsified, ..] = RingDefect::ALL;
    let first = arguments.faults.first();
    let sweep = FaultSweep {
        simulation: &simulation,
        defect: first.map_or(falsified, |fault| fault.defect),
        poses: arguments.poses,
        seed: arguments.seed,
    };
    let result = arguments.jobs.run(|| sweep.run())?;
    let result = result.map_err(|error| Failure::input(&error))?;
    let found = result.poses.iter().filter(|pose| pose.found).count() as u32;
    let report = SweepReport {
        seed: arguments.seed,
        world: world.name(),
        fault: sweep.defect.kind(),
        rules: arguments.rules.name(),
        poses: arguments.poses,
        faulty_found: found,
        missed_faults: arguments.poses - found,
        false_alarms: result.false_alarms,
        vectors: &result.poses,
        kinds: &result.rows,
    };
    if arguments.json {
        output::print_json(&report)
    } else {
        output::print(&render_sweep(&report, &result))
    }
}

fn render_sweep(report: &SweepReport<'_>, result: &SweepResult) -> String {
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
    for kind in &result.rows {
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

/// The report of the polygons' quality as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct ExtractionReport<'a> {
    seed: u64,
    world: &'a str,
    poses: u32,
    rows: &'a [ExtractionRow],
}

/// Compares polygons at many poses with the world.
fn extraction(arguments: &Arguments, world: &World) -> Result<(), Failure> {
    let simulation = arguments.simulation(world);
    let extraction = Extraction {
        simulation: &simulation,
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

/// The parts of the assessment that need lasers or cross echoes, which a recording does not have.
const NOT_ASSESSED: [&str; 3] = [
    "simulation-based confidence: no laser scan was recorded",
    "cross echoes: none were recorded, so no overlap with one",
    "the overall assessment: a sonar of which six overlaps are known is not declared faulty",
];

/// The report of a recording as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct RecordingReport<'a> {
    file: String,
    rows: usize,
    skipped: u64,
    range_mm: u32,
    overlaps_assessed: u32,
    overlaps_in_all: u32,
    sensors: &'a [SensorSummary],
    not_assessed: [&'static str; 3],
}

/// Assesses a recording of a real ring.
fn recorded(arguments: &Arguments, file: &Path) -> Result<(), Failure> {
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
    let report = RecordingReport {
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
        output::print(&render_recording(&report))
    }
}

fn render_recording(report: &RecordingReport<'_>) -> String {
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

/// The longest runs of one kind, with their lines in the file.
fn runs(
    report: &RecordingReport<'_>,
    what: &str,
    of: fn(&SensorSummary) -> &Vec<FrozenRun>,
) -> String {
    const MOST: usize = 8;
    let sensors = report.sensors.iter();
    let runs = sensors.flat_map(|sensor| of(sensor).iter().map(|run| (sensor.sensor, *run)));
    let mut runs: Vec<_> = runs.collect();
    runs.sort_by_key(|&(sensor, run)| (core::cmp::Reverse(run.rows), sensor, run.from_line));
    let mut text = format!("\n{what}: {}\n", runs.len());
    for (sensor, run) in runs.iter().take(MOST) {
        let reading = run
            .reading_mm
            .map_or("no object".into(), |mm| format!("{mm}mm"));
        let (from, to) = (run.from_line, run.to_line);
        text += &format!(
            "  sonar {sensor}: {reading} in lines {from} to {to}, {} rows\n",
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
