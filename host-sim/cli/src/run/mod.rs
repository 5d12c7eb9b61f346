//! `certainty run`: the firmware's application on a backend.

mod journey;

use super::or_none::{self, OrNone};
use super::panels::{Mark, Panel, side_by_side};
use super::table::{row, table};
use super::{Failure, map_image, output};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::Geometry;
use certainty_core::transducer::Reading;
use certainty_core::units::Ticks;
use certainty_firmware::smart_car::{
    CHASSIS, FARTHEST, HEADS, LOOK_AROUND, NEAREST, POSE, look_from,
};
use certainty_sim::backend::{
    self, Backend, BackendError, MissingCounts, Received, ReceivedSensor, RunDetails, Sizes,
};
use certainty_sim::bench::{Bench, BenchFault, BenchSetup};
use certainty_sim::export::{OutDir, shown, write_grey_png};
use certainty_sim::simulation::{Profile, Reference, Score};
use certainty_sim::transducer::SensorSet;
use certainty_sim::transducer::{Look, PerfectSensor};
use certainty_sim::world::World;
use clap::Args;
use core::num::NonZeroU32;
use journey::{Journey, JourneyReport};
use serde::Serialize;
use std::path::PathBuf;
use std::sync::Arc;

/// What the application is to do, and where.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Where the application runs: native, qemu or board
    #[arg(long, value_name = "BACKEND", default_value_t = Backend::Native)]
    on: Backend,
    /// How many rounds of the schedule; without it, those in which the car stands and looks around, a sweep of
    /// its heads: then it drives
    #[arg(long, value_name = "N", default_value_t = LOOK_AROUND,
          value_parser = clap::value_parser!(u32).range(1..=100_000))]
    rounds: u32,
    /// What is wrong with a sensor, its line or a motor, such as stuck-far:2, unplugged:3@3s..8s or
    /// motor-weak:left=95%; repeatable
    #[arg(long = "fault", value_name = "SPEC|none")]
    faults: Vec<OrNone<BenchFault>>,
    /// The obstacles: a TOML file; without it, the built-in scene
    #[arg(long, value_name = "FILE")]
    world: Option<PathBuf>,
    /// The image that qemu or board runs in place of the one that `cargo firmware` built
    #[arg(long, value_name = "FILE")]
    image: Option<PathBuf>,
    /// Names the run: the same seed gives the same result
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        allow_hyphen_values = true
    )]
    seed: u64,
    /// Where the pictures of map and track go
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Print one JSON document instead
    #[arg(long)]
    json: bool,
}

/// The report as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct Document {
    backend: &'static str,
    seed: u64,
    rounds: u32,
    readings: u32,
    /// Eight hexadecimal digits over the map's cells; null if no right map arrived.
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

/// One sensor: what the car holds of it, and what it last said.
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
    missing_because: MissingBecause,
    reading: String,
}

/// Missing readings by their reasons.
#[derive(Debug, Serialize)]
struct MissingBecause {
    timeout: u32,
    bus: u32,
    implausible: u32,
    late: u32,
}

impl From<MissingCounts> for MissingBecause {
    fn from(counts: MissingCounts) -> Self {
        let MissingCounts {
            timeout,
            bus,
            implausible,
            late,
        } = counts;
        Self {
            timeout,
            bus,
            implausible,
            late,
        }
    }
}

/// Runs the application and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    output::check_listable(arguments.json, &arguments.out)?;
    if arguments.on == Backend::Native && arguments.image.is_some() {
        let line = "--image: the native backend runs no image; leave it out, or write --on qemu or \
                    --on board";
        return Err(Failure::Input(line.into()));
    }
    let world = match &arguments.world {
        Some(file) => World::load(file).map_err(|error| Failure::input(&error))?,
        None => World::built_in(),
    };
    let radius = CHASSIS.radius_mm;
    let mut obstacles = world.obstacles().iter();
    if let Some(obstacle) = obstacles.find(|one| one.clearance(POSE.at) <= f64::from(radius)) {
        let world = arguments
            .world
            .as_deref()
            .map_or_else(|| "--world".into(), shown);
        let line = format!(
            "{world}: the car, {radius}mm around 0,0, starts inside an obstacle, {obstacle}; move it"
        );
        return Err(Failure::Input(line));
    }
    let world = Arc::new(world);
    let faults = or_none::given("--fault", &arguments.faults)?;
    let deaf = faults.iter().find_map(BenchFault::refused_channel);
    if let (Backend::Board, Some((kind, instead))) = (arguments.on, deaf) {
        let line = format!(
            "{kind}: the chip's PWM channels cannot fail; write {instead}, or --on native or qemu"
        );
        return Err(Failure::Input(line));
    }
    let bench = Bench::new(BenchSetup {
        world: Arc::clone(&world),
        sensors: SensorSet::default(),
        faults,
        seed: arguments.seed,
    });
    let bench = bench.map_err(|error| Failure::Input(format!("--fault: {error}")))?;
    let image = arguments.image.as_deref();
    let outcome = backend::run(arguments.on, image, bench, arguments.rounds);
    let (received, ran) = outcome.map_err(|error| refused(arguments, &error))?;
    let out = OutDir::create(&arguments.out).map_err(|error| Failure::input(&error))?;
    let map = received.map();
    let mut files = draw(map.as_ref(), &out)?;
    let journey = Journey::new(&received, &ran.ground_truth);
    let drawn = journey.draw(&world, map.as_ref(), &out);
    files.extend(drawn.map_err(|error| Failure::input(&error))?);
    if arguments.json {
        let document = Document::new(arguments, &received, &ran, journey.report(), &files);
        output::print_json(&document)
    } else {
        let reference = reference(&world, received.statistics().round, &journey);
        let mut text = told(arguments, &received, &ran, map.as_ref(), &reference);
        text += &journey.told();
        text += &format!("pictures: {}\n", output::told(&files));
        output::print(&text)
    }
}

/// Why there is no outcome: an image that was named may be no image of this backend.
fn refused(arguments: &Arguments, error: &BackendError) -> Failure {
    let odd = matches!(
        error,
        BackendError::Ended
            | BackendError::Timeout
            | BackendError::UnknownProtocol
            | BackendError::Board(_)
    );
    match (error, &arguments.image) {
        (BackendError::Refused, _) => Failure::Internal(error.to_string()),
        (_, Some(image)) if odd => {
            let (on, its) = match arguments.on {
                Backend::Board => ("board", "smart_car"),
                Backend::Native | Backend::Qemu => ("qemu", "qemu"),
            };
            let image = shown(image);
            Failure::Input(format!(
                "{image}: {error}; --on {on} runs the one called {its}"
            ))
        }
        _ => Failure::input(error),
    }
}

/// The grid of perfect sensors that look where the car's heads did.
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
    let geometry =
        certainty_core::fusion::Shape::geometry(&certainty_firmware::smart_car::SmartCarShape);
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

impl Document {
    fn new(
        arguments: &Arguments,
        received: &Received,
        ran: &RunDetails,
        drive: JourneyReport,
        files: &[PathBuf],
    ) -> Self {
        let statistics = received.statistics();
        let sensors = sensors(received);
        let whole = |sizes: fn(Sizes) -> u32| ran.sizes.map(sizes);
        Self {
            backend: arguments.on.name(),
            seed: arguments.seed,
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
            drive,
            files: output::listed(files),
        }
    }
}

/// What was heard of every sensor that was heard of at all.
fn sensors(received: &Received) -> Vec<SensorReport> {
    let numbered = (1..).zip(received.sensors());
    let reports = numbered.filter_map(|(id, heard)| {
        let ReceivedSensor {
            health,
            reading,
            missing,
        } = *heard;
        let health = health?;
        Some(SensorReport {
            id,
            kind: if id <= usize::from(HEADS) {
                "infrared"
            } else {
                "ultrasonic"
            },
            status: health.status.to_string(),
            confidence: f64::from(health.confidence.to_bits()) / f64::from(u16::MAX),
            confirmations: health.confirmations,
            contradictions: health.contradictions,
            readings: health.readings,
            missing: health.missing,
            missing_because: missing.into(),
            reading: reading.map_or_else(|| "none".into(), said),
        })
    });
    reports.collect()
}

/// A reading in words.
fn said(reading: Reading) -> String {
    match reading {
        Reading::Echo(distance) => format!("{distance}"),
        Reading::NoObject => "no object".into(),
        Reading::TooNear => "too near".into(),
        Reading::Missing(why) => format!("missing: {why}"),
    }
}

/// The report for people.
fn told(
    arguments: &Arguments,
    received: &Received,
    ran: &RunDetails,
    map: Option<&(Geometry, Vec<Certainty>)>,
    reference: &Reference,
) -> String {
    let statistics = received.statistics();
    let mut text = format!(
        "backend: {}   rounds: {}   car's time: {:.1} s   seed: {}\n\n",
        arguments.on,
        statistics.round,
        f64::from(statistics.tick.get()) / 1e3,
        arguments.seed
    );
    match map {
        Some((geometry, cells)) => {
            let truth = reference.cells();
            let marks = cells.iter().zip(truth);
            let marks = marks.map(|(&shown, &truth)| Mark::of(shown, truth));
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
                super::simulate::percent(score.missed),
                super::simulate::percent(score.ghost),
                received
                    .grid_hash()
                    .map_or_else(String::new, |hash| format!("{hash:08x}")),
            );
        }
        None => text += "No right map arrived.\n\n",
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
    text
}
