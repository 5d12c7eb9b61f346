//! `certainty ring`: which sonar of a ring is faulty (\[003\]).

use super::options::{CommonOptions, Jobs, named, world};
use super::output::{self, Failure, Report};
use super::replay::ZeroArgument;
use super::table::{counted, list, percent, row, table};
use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose};
use certainty_repro::ring_study::{
    Extraction, ExtractionRow, FaultSweep, KindRow, PoseResult, SweepResult, differs,
};
use certainty_ring::{ElementKind, Joint, Ring, RingConfig, RingRules};
use certainty_sim::export::display_path;
use certainty_sim::quantity::{self, Excerpt};
use certainty_sim::replay::SkipCount;
use certainty_sim::ring::{
    DirectAssessment, FrozenRun, Observation, RingDefect, RingDiagnosis, RingFault, RingOptions,
    RingRecording, RingSimulation, SONARS, SensorSummary, Vectors, draw,
};
use certainty_sim::world::World;
use clap::{ArgGroup, Args};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The options of `certainty ring`.
#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("many poses").args(["sweep", "extraction"])),
    mut_arg("jobs", |jobs| jobs.requires("many poses")),
    mut_arg("seed", |seed| seed.help("Seed of poses, faulty sonars and noise")),
    mut_arg("out", |out| out.help("Folder for the pictures"))
)]
pub(super) struct Arguments {
    /// TOML file of the obstacles; without it, the built-in office
    #[arg(long, value_name = "FILE", conflicts_with = "recording")]
    world: Option<PathBuf>,
    /// The robot's position and heading, such as 2.5m,1.8m,30deg [default: the office's centre]
    #[arg(long, value_name = "X,Y,HEADING", value_parser = pose, allow_hyphen_values = true,
          conflicts_with_all = ["recording", "sweep", "extraction"])]
    pose: Option<Pose>,
    /// Fault: a sonar's number from 1, or a kind and a sonar, such as crosstalk:4 or stuck:7=350mm; repeatable.
    /// With --sweep, the kind of the first one counts
    #[arg(
        long = "fault",
        value_name = "[KIND:]SENSOR[=VALUE]",
        conflicts_with_all = ["recording", "extraction"]
    )]
    faults: Vec<RingFault>,
    /// Check at many poses, with and without every kind of fault
    #[arg(long, conflicts_with_all = ["recording", "extraction"])]
    sweep: bool,
    /// Compare the polygons at many poses with the world
    #[arg(long, conflicts_with = "recording")]
    extraction: bool,
    /// Confirmations that a sonar needs: one, as in [003] (paper), or three (wary)
    #[arg(
        long,
        value_name = "RULES",
        default_value = "paper",
        value_parser = named(Rules::ALL, Rules::name),
        conflicts_with_all = ["recording", "extraction"]
    )]
    rules: Rules,
    /// Number of poses of --sweep or --extraction
    #[arg(long, value_name = "N", default_value_t = 100, requires = "many poses",
          value_parser = clap::value_parser!(u32).range(1..=100_000))]
    poses: u32,
    /// Recording of a real ring: 24 distances a line, in metres or in the unit of their names; - is stdin
    #[arg(long, value_name = "FILE")]
    recording: Option<PathBuf>,
    /// The recorded sonars' range
    #[arg(long, value_name = "LENGTH", default_value = "5m", value_parser = quantity::length,
          requires = "recording")]
    range: Millimeters,
    /// Meaning of a recorded distance of 0
    #[arg(long, value_enum, default_value_t = ZeroArgument::None, requires = "recording")]
    zero: ZeroArgument,
    /// Read a recording of which more than a twentieth of the lines are unreadable
    #[arg(long, requires = "recording")]
    lenient: bool,
    #[command(flatten)]
    jobs: Jobs,
    #[command(flatten)]
    common: CommonOptions,
}

/// The rules that can be chosen on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Rules {
    /// One confirmation is enough.
    Paper,
    /// Three confirmations are needed.
    Wary,
}

impl Rules {
    const ALL: [Self; 2] = [Self::Paper, Self::Wary];

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
    /// Returns the ring in a world, checked by these rules.
    fn simulation<'a>(&self, world: &'a World) -> RingSimulation<'a> {
        let mut simulation = RingSimulation::new(world);
        simulation.rules = self.rules.rules();
        simulation
    }

    /// Returns the robot's pose in `world`: in its bounds, and where no obstacle is.
    fn robot(&self, world: &World) -> Result<Pose, Failure> {
        let robot = match self.pose {
            Some(pose) => pose,
            None if self.world.is_none() => CENTRE,
            None => {
                let line =
                    "--pose: missing with --world: expected a pose, such as --pose 2.5m,1.8m,30deg";
                return Err(Failure::Input(line.into()));
            }
        };
        let (x, y) = (robot.at.x_mm(), robot.at.y_mm());
        let radius = RingConfig::DEFAULT.radius;
        let touches = |clearance: f64| clearance < f64::from(radius.get());
        if world.clearance(robot.at).is_some_and(touches) {
            return Err(Failure::Input(format!(
                "--pose: at {x}mm,{y}mm an obstacle is within the ring's radius of {radius}: expected a \
                 free position"
            )));
        }
        let Some(bounds) = world.bounds() else {
            return Ok(robot);
        };
        let (low, high) = (bounds.lower_left, bounds.upper_right);
        let inside =
            (low.x_mm()..=high.x_mm()).contains(&x) && (low.y_mm()..=high.y_mm()).contains(&y);
        if !inside {
            return Err(Failure::Input(format!(
                "--pose: {x}mm,{y}mm is outside the room: expected a position from {}mm,{}mm to {}mm,{}mm",
                low.x_mm(),
                low.y_mm(),
                high.x_mm(),
                high.y_mm()
            )));
        }
        Ok(robot)
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

/// Checks, sweeps, compares or assesses, and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    arguments.common.output.check()?;
    if let Some(recording) = &arguments.recording {
        return recorded(arguments, recording);
    }
    let world = world(arguments.world.as_deref(), World::office)?;
    if arguments.sweep {
        sweep(arguments, &world)
    } else if arguments.extraction {
        extraction(arguments, &world)
    } else {
        check(arguments, &world)
    }
}

/// The default pose in the office.
const CENTRE: Pose = Pose::new(
    Point::from_mm(2200, 2300),
    BinaryAngle::from_millidegrees(10_000),
);

/// The report of one check as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct CheckDocument<'a> {
    seed: u64,
    world: &'a str,
    pose: PoseReport,
    faults: Vec<String>,
    /// Those that change no distance of their sonar at this pose.
    without_effect: Vec<String>,
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

/// The check at one pose, and its pictures.
struct Check<'a> {
    arguments: &'a Arguments,
    world: &'a World,
    robot: Pose,
    observation: Observation,
    diagnosis: RingDiagnosis,
    without_effect: Vec<RingFault>,
    files: Vec<PathBuf>,
}

/// Checks the ring at one pose.
fn check(arguments: &Arguments, world: &World) -> Result<(), Failure> {
    let robot = arguments.robot(world)?;
    let simulation = arguments.simulation(world);
    let observation = simulation.observe(robot, &arguments.faults, arguments.common.seed, 0);
    let observation = observation.map_err(|error| {
        let name = Excerpt::new(world.name());
        Failure::Input(format!("{name}: {error}; use fewer obstacles"))
    })?;
    let diagnosis = simulation.assess(&observation);
    let mut sound = observation.clone();
    sound.echoes = simulation.echoes(robot, &[], arguments.common.seed, 0);
    let sound = simulation.assess(&sound).measured;
    let has_effect =
        |fault: &RingFault| differs(&simulation, fault.sensor, &sound, &diagnosis.measured);
    let mut without_effect = arguments.faults.clone();
    without_effect.retain(|fault| !has_effect(fault));
    let out = arguments.common.output.create()?;
    let files = draw(&simulation, &observation, &diagnosis, &out);
    let files = files.and_then(|files| out.finish().map(|()| files));
    arguments.common.output.print(&Check {
        arguments,
        world,
        robot,
        observation,
        diagnosis,
        without_effect,
        files: files.map_err(|error| Failure::input(&error))?,
    })
}

impl Check<'_> {
    /// The sonars that are declared faulty.
    fn faulty(&self) -> Vec<u8> {
        let faulty = self.diagnosis.assessment.faulty();
        faulty.map(|id| id.number()).collect()
    }
}

impl Report for Check<'_> {
    fn document(&self) -> impl Serialize {
        let arguments = self.arguments;
        let assessment = &self.diagnosis.assessment;
        CheckDocument {
            seed: arguments.common.seed,
            world: self.world.name(),
            pose: PoseReport {
                x_mm: self.robot.at.x_mm(),
                y_mm: self.robot.at.y_mm(),
                heading_deg: quantity::degrees(self.robot.heading),
            },
            faults: arguments.faults.iter().map(ToString::to_string).collect(),
            without_effect: self
                .without_effect
                .iter()
                .map(ToString::to_string)
                .collect(),
            rules: arguments.rules.name(),
            faulty: self.faulty(),
            vectors: Vectors::of(assessment),
            verdicts: assessment
                .verdicts()
                .iter()
                .map(ToString::to_string)
                .collect(),
            polygon: PolygonReport::of(&self.observation),
            files: output::listed(&self.files),
        }
    }

    fn render(&self) -> String {
        let arguments = self.arguments;
        let polygon = PolygonReport::of(&self.observation);
        let mut text = format!(
            "world: {}   robot: {}mm, {}mm, {:.1}deg   seed: {}   rules: {}\nfault: {}\n\
             polygon of {} beams: {} walls, {} pseudo line segments, {} corners, {} edges\n\n",
            Excerpt::new(self.world.name()),
            self.robot.at.x_mm(),
            self.robot.at.y_mm(),
            quantity::degrees(self.robot.heading),
            arguments.common.seed,
            arguments.rules.name(),
            list(&arguments.faults, ", "),
            polygon.beams,
            polygon.walls,
            polygon.pseudo,
            polygon.corners,
            polygon.edges,
        );
        let vectors = Vectors::of(&self.diagnosis.assessment);
        let mut rows = vec![row([
            "sonar",
            "simulation",
            "intersection",
            "overall",
            "verdict",
        ])];
        let verdicts = self.diagnosis.assessment.verdicts();
        rows.extend((0..SONARS).map(|slot| {
            vec![
                (slot + 1).to_string(),
                vectors.simulation_based[slot].to_string(),
                vectors.intersection_based[slot].to_string(),
                vectors.overall[slot].to_string(),
                verdicts[slot].to_string(),
            ]
        }));
        text += &table(&rows);
        text.push('\n');
        for fault in &self.without_effect {
            text += &format!("{fault} changes no distance at this pose: it cannot be found here\n");
        }
        text += &format!(
            "faulty: {}\npictures: {}/ring-*.png, .svg\n",
            list(self.faulty(), ", "),
            display_path(&arguments.common.output.out)
        );
        text
    }
}

/// The report of a sweep as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct SweepDocument<'a> {
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

/// A sweep of every kind of fault.
struct Sweep<'a> {
    arguments: &'a Arguments,
    world: &'a World,
    defect: RingDefect,
    result: SweepResult,
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
        seed: arguments.common.seed,
    };
    let result = arguments.jobs.run(|| sweep.run())?;
    arguments.common.output.print(&Sweep {
        arguments,
        world,
        defect: sweep.defect,
        result: result.map_err(|error| Failure::input(&error))?,
    })
}

impl Sweep<'_> {
    /// The number of poses at which the faulty sonar was found.
    fn found(&self) -> u32 {
        self.result.poses.iter().filter(|pose| pose.found).count() as u32
    }
}

impl Report for Sweep<'_> {
    fn document(&self) -> impl Serialize {
        SweepDocument {
            seed: self.arguments.common.seed,
            world: self.world.name(),
            fault: self.defect.kind(),
            rules: self.arguments.rules.name(),
            poses: self.arguments.poses,
            faulty_found: self.found(),
            missed_faults: self.arguments.poses - self.found(),
            false_alarms: self.result.false_alarms,
            vectors: &self.result.poses,
            kinds: &self.result.rows,
        }
    }

    fn render(&self) -> String {
        let mut text = format!(
            "world: {}   places: {}   seed: {}   rules: {}\n\
             one sonar {}: {} found, {} missed; without a fault: {} false alarms\n\n",
            Excerpt::new(self.world.name()),
            self.arguments.poses,
            self.arguments.common.seed,
            self.arguments.rules.name(),
            self.defect.kind(),
            self.found(),
            self.arguments.poses - self.found(),
            self.result.false_alarms
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
        for kind in &self.result.rows {
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
}

/// The report of the polygons' quality as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct ExtractionDocument<'a> {
    seed: u64,
    world: &'a str,
    poses: u32,
    rows: &'a [ExtractionRow],
}

/// The quality of the polygons at every noise and resolution.
struct Extracted<'a> {
    arguments: &'a Arguments,
    world: &'a World,
    rows: Vec<ExtractionRow>,
}

/// Compares polygons at many poses with the world.
fn extraction(arguments: &Arguments, world: &World) -> Result<(), Failure> {
    let simulation = arguments.simulation(world);
    let extraction = Extraction {
        simulation: &simulation,
        poses: arguments.poses,
        seed: arguments.common.seed,
    };
    let rows = arguments.jobs.run(|| extraction.run())?;
    arguments.common.output.print(&Extracted {
        arguments,
        world,
        rows: rows.map_err(|error| Failure::input(&error))?,
    })
}

impl Report for Extracted<'_> {
    fn document(&self) -> impl Serialize {
        ExtractionDocument {
            seed: self.arguments.common.seed,
            world: self.world.name(),
            poses: self.arguments.poses,
            rows: &self.rows,
        }
    }

    fn render(&self) -> String {
        let mut lines = vec![row([
            "resolution",
            "noise",
            "segments",
            "found",
            "walls",
            "phantom",
            "corners",
            "found",
            "mean error",
            "worst",
            "refused",
        ])];
        for row in &self.rows {
            lines.push(vec![
                format!("{}mm", row.resolution_mm),
                format!("{}mm", row.noise_mm),
                row.segments.to_string(),
                row.segments_found.to_string(),
                row.walls.to_string(),
                row.phantom_walls.to_string(),
                row.corners.to_string(),
                row.corners_found.to_string(),
                format!("{:.1}mm", row.mean_corner_error_mm),
                format!("{:.1}mm", row.worst_corner_error_mm),
                row.refused.to_string(),
            ]);
        }
        let (poses, seed) = (self.arguments.poses, self.arguments.common.seed);
        let name = Excerpt::new(self.world.name());
        format!("world: {name}   places: {poses}   seed: {seed}\n\n") + &table(&lines)
    }
}

/// The parts of the assessment that need lasers or cross echoes, which a recording does not have.
const NOT_ASSESSED: [&str; 3] = [
    "simulation-based confidence: no laser scan was recorded",
    "cross echoes: none were recorded, so no overlap with one",
    "the overall assessment: a sonar of which six overlaps are known is not declared faulty",
];

/// The report of a recording as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct RecordingDocument<'a> {
    file: String,
    rows: usize,
    skipped: u64,
    skip_reasons: Vec<SkipCount>,
    notes: &'a [String],
    range_mm: u32,
    overlaps_assessed: u32,
    overlaps_in_all: u32,
    sensors: &'a [SensorSummary],
    not_assessed: [&'static str; 3],
}

/// An assessed recording.
struct Recorded<'a> {
    file: &'a Path,
    range: Millimeters,
    recording: RingRecording,
    assessed: DirectAssessment,
}

/// Assesses a recording of a real ring.
fn recorded(arguments: &Arguments, file: &Path) -> Result<(), Failure> {
    let range = arguments.range;
    let config = RingConfig {
        range,
        ..RingConfig::DEFAULT
    };
    let ring = Ring::try_new(config);
    let ring = ring.map_err(|error| Failure::Input(format!("--range: {error}")))?;
    let options = RingOptions {
        range,
        zero: arguments.zero.meaning(),
        lenient: arguments.lenient,
    };
    let recording = RingRecording::load(file, &options);
    let recording = recording.map_err(|error| Failure::input(&error))?;
    arguments.common.output.print(&Recorded {
        assessed: DirectAssessment::of(&recording, &ring, &RingRules::DEFAULT),
        file,
        range,
        recording,
    })
}

impl Report for Recorded<'_> {
    fn document(&self) -> impl Serialize {
        let (direct, all) = self.assessed.overlaps;
        RecordingDocument {
            file: self.file.display().to_string(),
            rows: self.recording.rows(),
            skipped: self.recording.skipped().total(),
            skip_reasons: self.recording.skipped().counts().collect(),
            notes: self.recording.notes(),
            range_mm: self.range.get(),
            overlaps_assessed: direct,
            overlaps_in_all: all,
            sensors: &self.assessed.sensors,
            not_assessed: NOT_ASSESSED,
        }
    }

    fn render(&self) -> String {
        let (direct, all) = self.assessed.overlaps;
        let mut text = format!(
            "{}: {}, {} skipped; {direct} of {all} independent overlaps of a sonar\n",
            display_path(self.file),
            counted(self.recording.rows() as u64, "row"),
            counted(self.recording.skipped().total(), "line"),
        );
        for note in self.recording.notes() {
            text += &format!("{note}\n");
        }
        text.push('\n');
        let share = |part: usize| percent(part as f64 / self.recording.rows().max(1) as f64);
        let mut rows = vec![row([
            "sonar",
            "echo",
            "no object",
            "too near",
            "missing",
            "confirmed",
            "arcs met",
            "longest equal",
            "stuck",
            "blind",
        ])];
        for sensor in &self.assessed.sensors {
            let longest = sensor.longest_equal.map_or(0, |run| run.rows);
            rows.push(vec![
                sensor.sensor.to_string(),
                share(sensor.echoes),
                share(sensor.no_object),
                share(sensor.too_near),
                share(sensor.missing),
                share(sensor.confirmed),
                format!("{:.1}", sensor.mean_intersections),
                longest.to_string(),
                sensor.stuck.len().to_string(),
                sensor.blind.len().to_string(),
            ]);
        }
        text += &table(&rows);
        let sensors = &self.assessed.sensors;
        text += &runs(sensors, "stuck while both neighbours moved", |sensor| {
            &sensor.stuck
        });
        text += &runs(
            sensors,
            "blind while both neighbours had near echoes",
            |sensor| &sensor.blind,
        );
        text += "\nnot assessed:\n";
        for line in NOT_ASSESSED {
            text += &format!("  {line}\n");
        }
        text
    }
}

/// The longest runs of one kind, with their lines in the file.
fn runs(
    sensors: &[SensorSummary],
    what: &str,
    of: fn(&SensorSummary) -> &Vec<FrozenRun>,
) -> String {
    const MOST: usize = 8;
    let runs = sensors
        .iter()
        .flat_map(|sensor| of(sensor).iter().map(|run| (sensor.sensor, *run)));
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
