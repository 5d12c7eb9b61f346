//! `certainty run`: the firmware's application on a backend.

use super::maps::{Mark, Panel, map_image, metres_of, side_by_side, track_plan};
use super::options::{CommonOptions, OrNone, given, named, no_directory, world};
use super::output::Failure;
use super::output::{self, Report};
use super::table::{percent, row, table};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::{Geometry, Shape};
use certainty_core::transducer::Reading;
use certainty_core::units::{Pose, Ticks};
use certainty_firmware::digest::Digest;
use certainty_firmware::smart_car::{
    CHASSIS, CONTROL, FARTHEST, GOAL, HEADS, LOOK_AROUND, NEAREST, POSE, SmartCarShape, look_from,
};
use certainty_firmware::telemetry::Drive;
use certainty_sim::backend::{
    self, Backend, BackendError, MissingCounts, Received, ReceivedSensor, RunDetails, Sizes,
};
use certainty_sim::bench::{Bench, BenchFault, BenchSetup, GroundTruth};
use certainty_sim::export::{ExportError, OutDir, display_path, write_grey_png};
use certainty_sim::plot::{Ink, Layer};
use certainty_sim::quantity;
use certainty_sim::simulation::{Profile, Reference, Score};
use certainty_sim::transducer::SensorSet;
use certainty_sim::transducer::{Look, PerfectSensor};
use certainty_sim::world::World;
use clap::Args;
use core::num::NonZeroU32;
use serde::Serialize;
use std::path::PathBuf;
use std::sync::Arc;

/// The options of `certainty run`.
#[derive(Debug, Args)]
#[command(mut_arg("out", |out| out.help("Folder for the pictures of map and track")))]
pub(super) struct Arguments {
    /// Where the application runs: in this process, under QEMU, or on an emulated board
    #[arg(long, value_name = "BACKEND", default_value_t = Backend::Native,
          value_parser = named(Backend::ALL, Backend::name))]
    on: Backend,
    /// Number of rounds of the schedule; the default is one sweep of the heads at the start, after which
    /// the car drives
    #[arg(long, value_name = "N", default_value_t = LOOK_AROUND,
          value_parser = clap::value_parser!(u32).range(1..=100_000))]
    rounds: u32,
    /// Fault of a sensor, its line or a motor, such as stuck-far:2, unplugged:3@3s..8s or
    /// motor-weak:left=95%, or none; repeatable
    #[arg(long = "fault", value_name = "SPEC|none")]
    faults: Vec<OrNone<BenchFault>>,
    /// TOML file of the obstacles; without it, the built-in scene
    #[arg(long, value_name = "FILE")]
    world: Option<PathBuf>,
    /// Image for qemu or board in place of the one that `cargo firmware` built
    #[arg(long, value_name = "FILE")]
    image: Option<PathBuf>,
    #[command(flatten)]
    common: CommonOptions,
}

/// The report as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct Document {
    backend: &'static str,
    seed: u64,
    rounds: u32,
    readings: u32,
    /// Eight hexadecimal digits over the map's cells; null without a complete map.
    grid_hash: Option<String>,
    sensors: Vec<SensorReport>,
    overruns: u32,
    unsent_frames: u32,
    lost_frames: u64,
    flash_bytes: Option<u32>,
    static_ram_bytes: Option<u32>,
    stack_bytes: Option<u32>,
    drive: JourneyReport,
    files: Vec<String>,
}

/// One sensor: its health by the car, and its last reading.
#[derive(Debug, Serialize)]
struct SensorReport {
    id: usize,
    kind: &'static str,
    status: String,
    confidence: f64,
    confirmations: u32,
    contradictions: u32,
    readings: u32,
    missing: u32,
    missing_because: MissingCounts,
    reading: String,
}

/// Runs the application and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    arguments.common.output.check()?;
    if arguments.on == Backend::Native && arguments.image.is_some() {
        let line = "--image: the native backend runs no image: expected --on qemu or --on board";
        return Err(Failure::Input(line.into()));
    }
    let world = world(arguments.world.as_deref(), World::built_in)?;
    let radius = CHASSIS.radius_mm;
    let mut obstacles = world.obstacles().iter();
    if let Some(obstacle) = obstacles.find(|one| one.clearance(POSE.at) <= f64::from(radius)) {
        let world = arguments
            .world
            .as_deref()
            .map_or_else(|| "--world".into(), display_path);
        let line = format!(
            "{world}: the car, {radius}mm around 0,0, starts inside an obstacle, {obstacle}: expected \
             free space"
        );
        return Err(Failure::Input(line));
    }
    let world = Arc::new(world);
    let faults = given("--fault", &arguments.faults)?;
    let unsupported = faults.iter().find_map(BenchFault::refused_channel);
    if let (Backend::Board, Some((kind, instead))) = (arguments.on, unsupported) {
        let line = format!(
            "{kind}: the emulated chip's PWM channels cannot fail: expected {instead}, or --on native \
             or qemu"
        );
        return Err(Failure::Input(line));
    }
    let bench = Bench::new(BenchSetup {
        world: Arc::clone(&world),
        sensors: SensorSet::default(),
        faults,
        seed: arguments.common.seed,
    });
    let bench = bench.map_err(|error| Failure::Input(format!("--fault: {error}")))?;
    let image = arguments.image.as_deref();
    image.map_or(Ok(()), |image| {
        no_directory(image, "an image that `cargo firmware` built")
    })?;
    let out = arguments.common.output.create()?;
    let outcome = backend::run(arguments.on, image, bench, arguments.rounds);
    let (received, ran) = outcome.map_err(|error| failure(arguments, &error))?;
    let map = received.map();
    let mut files = draw(map.as_ref(), &out)?;
    let journey = Journey::new(&received, &ran.ground_truth);
    let drawn = journey.draw(&world, map.as_ref(), &out);
    files.extend(drawn.map_err(|error| Failure::input(&error))?);
    out.finish().map_err(|error| Failure::input(&error))?;
    arguments.common.output.print(&Outcome {
        arguments,
        world: &world,
        received: &received,
        ran: &ran,
        map: map.as_ref(),
        journey,
        files,
    })
}

/// Everything that a report of a run needs.
struct Outcome<'a> {
    arguments: &'a Arguments,
    world: &'a Arc<World>,
    received: &'a Received,
    ran: &'a RunDetails,
    map: Option<&'a (Geometry, Vec<Certainty>)>,
    journey: Journey<'a>,
    files: Vec<PathBuf>,
}

/// Returns the failure of a backend; the image of `--image` may belong to another backend.
fn failure(arguments: &Arguments, error: &BackendError) -> Failure {
    let by_image = matches!(
        error,
        BackendError::Ended
            | BackendError::Timeout
            | BackendError::UnknownProtocol
            | BackendError::Board(_)
    );
    match (error, &arguments.image) {
        (BackendError::Refused, _) => Failure::Internal(error.to_string()),
        (_, Some(image)) if by_image => {
            let (on, name) = match arguments.on {
                Backend::Board => ("board", "smart_car"),
                Backend::Native | Backend::Qemu => ("qemu", "qemu"),
            };
            let image = display_path(image);
            Failure::Input(format!(
                "{image}: {error}; --on {on} expects the image named {name}"
            ))
        }
        _ => Failure::input(error),
    }
}

/// Returns the grid of perfect sensors in the directions of the car's heads.
fn reference(world: &Arc<World>, rounds: u32, journey: &Journey<'_>) -> Reference {
    let looks = (0..rounds).flat_map(|round| {
        (0..HEADS).map(move |slot| {
            let pose = look_from(journey.pose(round), slot, HEADS, round);
            Look {
                origin: pose.at,
                bearing: pose.heading,
                at: Ticks::new(0),
            }
        })
    });
    let perfect = PerfectSensor::new(Arc::clone(world), NEAREST, FARTHEST);
    let geometry = SmartCarShape.geometry();
    Reference::new(geometry, &Profile::default().model(0.0), perfect, looks)
}

fn draw(map: Option<&(Geometry, Vec<Certainty>)>, out: &OutDir) -> Result<Vec<PathBuf>, Failure> {
    const ZOOM: NonZeroU32 = NonZeroU32::new(24).unwrap();
    let Some((geometry, cells)) = map else {
        return Ok(Vec::new());
    };
    let image = map_image(geometry, cells)?;
    let written = out.write("run.png", |file| write_grey_png(&image, ZOOM, file));
    Ok(vec![written.map_err(|error| Failure::input(&error))?])
}

impl Report for Outcome<'_> {
    fn document(&self) -> impl Serialize {
        let Self {
            arguments,
            received,
            ran,
            ..
        } = self;
        let statistics = received.statistics();
        let sensors = sensors(received);
        let whole = |sizes: fn(Sizes) -> u32| ran.sizes.map(sizes);
        Document {
            backend: arguments.on.name(),
            seed: arguments.common.seed,
            rounds: statistics.round,
            readings: sensors.iter().map(|sensor| sensor.readings).sum(),
            grid_hash: received.grid_hash().map(|hash| format!("{hash:08x}")),
            sensors,
            overruns: statistics.overruns,
            unsent_frames: statistics.unsent,
            lost_frames: received.tally().lost,
            flash_bytes: whole(|sizes| sizes.flash_bytes),
            static_ram_bytes: whole(|sizes| sizes.static_ram_bytes),
            stack_bytes: ran.stack_bytes,
            drive: self.journey.report(),
            files: output::listed(&self.files),
        }
    }

    fn render(&self) -> String {
        let Self {
            arguments,
            received,
            ran,
            ..
        } = self;
        let statistics = received.statistics();
        let mut text = format!(
            "backend: {}   rounds: {}   simulated time: {:.1} s   seed: {}\n\n",
            arguments.on,
            statistics.round,
            f64::from(statistics.tick.get()) / 1e3,
            arguments.common.seed
        );
        match self.map {
            Some((geometry, cells)) => {
                let reference = reference(self.world, statistics.round, &self.journey);
                let truth = reference.cells();
                let marks = cells.iter().zip(truth);
                let marks = marks.map(|(&cell, &truth)| Mark::of(cell, truth));
                let panel = Panel {
                    title: "robust".into(),
                    marks: marks.collect(),
                };
                text += &side_by_side(geometry, &[panel], output::coloured());
                text += Mark::LEGEND;
                let score = Score::of(cells, truth);
                text += &format!(
                    "\nMAE {:.3}, missed {}, ghost {}; map {}\n\n",
                    score.mae,
                    percent(score.missed),
                    percent(score.ghost),
                    received
                        .grid_hash()
                        .map_or_else(String::new, |hash| format!("{hash:08x}")),
                );
            }
            None => text += "No complete map was received.\n\n",
        }
        let mut rows = vec![row([
            "sensor",
            "status",
            "confidence",
            "confirmed",
            "contradicted",
            "readings",
            "missing",
            "last reading",
        ])];
        rows.extend(sensors(received).into_iter().map(|sensor| {
            vec![
                format!("{} ({})", sensor.id, sensor.kind),
                sensor.status,
                format!("{:.2}", sensor.confidence),
                sensor.confirmations.to_string(),
                sensor.contradictions.to_string(),
                sensor.readings.to_string(),
                sensor.missing.to_string(),
                sensor.reading,
            ]
        }));
        text += &table(&rows);
        text += &format!(
            "\n{} slots skipped, {} frames not sent, {} lost\n",
            statistics.overruns,
            statistics.unsent,
            received.tally().lost
        );
        if let Some(sizes) = ran.sizes {
            text += &format!(
                "{} bytes of flash, {} of RAM for variables",
                sizes.flash_bytes, sizes.static_ram_bytes
            );
            if let Some(stack) = ran.stack_bytes {
                text += &format!(", {stack} of stack");
            }
            text.push('\n');
        }
        text += &self.journey.render();
        text += &format!("pictures: {}\n", output::joined(&self.files, " "));
        text
    }
}

/// Returns every sensor of which the car reported health.
fn sensors(received: &Received) -> Vec<SensorReport> {
    let numbered = (1..).zip(received.sensors());
    let reports = numbered.filter_map(|(id, last)| {
        let ReceivedSensor {
            health,
            reading,
            missing,
        } = *last;
        let health = health?;
        Some(SensorReport {
            id,
            kind: if id <= usize::from(HEADS) {
                "infrared"
            } else {
                "ultrasonic"
            },
            status: health.status.to_string(),
            confidence: quantity::share(health.confidence),
            confirmations: health.confirmations,
            contradictions: health.contradictions,
            readings: health.readings,
            missing: health.missing,
            missing_because: missing,
            reading: reading.map_or_else(|| "none".into(), reading_text),
        })
    });
    reports.collect()
}

/// Renders a reading.
fn reading_text(reading: Reading) -> String {
    match reading {
        Reading::Echo(distance) => format!("{distance}"),
        Reading::NoObject => "no object".into(),
        Reading::TooNear => "too near".into(),
        Reading::Missing(why) => format!("missing: {why}"),
    }
}

/// The drive as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct JourneyReport {
    /// Whether the car's true place is within the goal's radius.
    reached: bool,
    /// The car's last drive state.
    conduct: Option<String>,
    /// Rounds in which it moved.
    rounds_moved: usize,
    collisions: u32,
    goal_x_mm: i32,
    goal_y_mm: i32,
    goal_radius_mm: u32,
    /// The car's last estimate of its pose.
    believed: Place,
    /// Its true pose.
    truly: Place,
    /// Eight hexadecimal digits over every round's pose, estimated and true, and the wheels' commands.
    track_hash: String,
}

/// A pose, and its distance to the goal.
#[derive(Debug, Serialize)]
struct Place {
    x_mm: i32,
    y_mm: i32,
    heading_deg: f64,
    to_goal_mm: u32,
}

impl From<Pose> for Place {
    fn from(pose: Pose) -> Self {
        Self {
            x_mm: pose.at.x_mm(),
            y_mm: pose.at.y_mm(),
            heading_deg: quantity::degrees(pose.heading),
            to_goal_mm: pose.at.distance(GOAL).get(),
        }
    }
}

/// The car's reports and its true poses.
#[derive(Debug, Clone, Copy)]
struct Journey<'a> {
    drives: &'a [Drive],
    ground_truth: &'a [GroundTruth],
}

impl<'a> Journey<'a> {
    fn new(received: &'a Received, ground_truth: &'a [GroundTruth]) -> Self {
        let drives = received.drives();
        Self {
            drives,
            ground_truth,
        }
    }

    /// Returns the car's true pose in a round, from 0.
    fn pose(&self, round: u32) -> Pose {
        let stage = self
            .ground_truth
            .get(round as usize)
            .or(self.ground_truth.last());
        stage.map_or(POSE, |stage| stage.pose)
    }

    fn rounds_moved(&self) -> usize {
        let pairs = self
            .ground_truth
            .iter()
            .zip(self.ground_truth.iter().skip(1));
        pairs.filter(|(a, b)| a.pose != b.pose).count()
    }

    fn report(&self) -> JourneyReport {
        let last = self.drives.last();
        let stage = self.ground_truth.last();
        let truly = Place::from(stage.map_or(POSE, |stage| stage.pose));
        let goal_radius = CONTROL.config().goal_radius;
        JourneyReport {
            reached: truly.to_goal_mm <= goal_radius.get(),
            conduct: last.map(|drive| drive.state.to_string()),
            rounds_moved: self.rounds_moved(),
            collisions: stage.map_or(0, |stage| stage.collisions),
            goal_x_mm: GOAL.x_mm(),
            goal_y_mm: GOAL.y_mm(),
            goal_radius_mm: goal_radius.get(),
            believed: last.map_or(POSE, |drive| drive.pose).into(),
            truly,
            track_hash: format!("{:08x}", self.hash()),
        }
    }

    fn hash(&self) -> u32 {
        let mut digest = Digest::NEW;
        let estimated = self.drives.iter().map(|drive| drive.pose);
        for pose in estimated.chain(self.ground_truth.iter().map(|stage| stage.pose)) {
            digest.word(pose.at.x_mm().cast_unsigned());
            digest.word(pose.at.y_mm().cast_unsigned());
            digest.word(pose.heading.to_bits().into());
        }
        for wheels in self.drives.iter().map(|drive| drive.wheels) {
            digest.word(wheels.right.to_bits().cast_unsigned());
            digest.word(wheels.left.to_bits().cast_unsigned());
        }
        digest.value()
    }

    /// Renders the drive in a line.
    fn render(&self) -> String {
        let report = self.report();
        let conduct = report.conduct.unwrap_or_else(|| "no report".into());
        format!(
            "drive: {conduct}; moved in {} rounds; the goal is {}mm away ({}mm by the car's odometry), {}; \
             {} collisions; track {}\n",
            report.rounds_moved,
            report.truly.to_goal_mm,
            report.believed.to_goal_mm,
            if report.reached {
                "reached"
            } else {
                "not reached"
            },
            report.collisions,
            report.track_hash
        )
    }

    /// Draws the track over the world and the map, if the car has moved.
    fn draw(
        &self,
        world: &World,
        map: Option<&(Geometry, Vec<Certainty>)>,
        out: &OutDir,
    ) -> Result<Vec<PathBuf>, ExportError> {
        if self.rounds_moved() == 0 {
            return Ok(Vec::new());
        }
        let truly = self
            .ground_truth
            .iter()
            .map(|stage| metres_of(stage.pose.at));
        let estimated = self.drives.iter().map(|drive| metres_of(drive.pose.at));
        let tracks = [
            Layer::new("car", Ink::Solid, vec![truly.collect()]),
            Layer::new("by its odometry", Ink::Dashed, vec![estimated.collect()]),
        ];
        let title = "Track of the Smart Car".into();
        let goal = (GOAL, CONTROL.config().goal_radius.get());
        let plan = track_plan(title, world, map, tracks, POSE.at, goal);
        plan.write(out, "run-track").map(Vec::from)
    }
}
