//! `certainty simulate`: the Smart Car in a world, every method on the same readings.

use super::health::{HealthReport, caveat};
use super::or_none::{self, OrNone};
use super::overview::overview;
use super::panels::{Mark, Panel, side_by_side};
use super::table::{row, table};
use super::{Failure, map_image, output};
use certainty_core::certainty::Certainty;
use certainty_firmware::smart_car::SWEEP;
use certainty_sim::export::{OutDir, shown, write_grey_png};
use certainty_sim::fault::FaultSpec;
use certainty_sim::fusion::Method;
use certainty_sim::quantity::Excerpt;
use certainty_sim::simulation::{Length, MethodResult, Run, STEP_MS, Setup, SetupError, Truth};
use certainty_sim::transducer::SensorSet;
use certainty_sim::world::World;
use clap::Args;
use core::num::NonZeroU32;
use core::str::FromStr;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Sweeps of every head that a run takes if it is not told how many readings.
const SWEEPS: u32 = 4;

/// What the simulation is asked.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The obstacles: a TOML file; without it, the built-in scene
    #[arg(long, value_name = "FILE")]
    world: Option<PathBuf>,
    /// The sensors: letters A to E of [001] Table 1, or a number from 3 to 7
    #[arg(long, value_name = "ABC|3..7", default_value_t)]
    sensors: SensorSet,
    /// What is wrong with a sensor, such as stuck-near:1=250mm@3s..8s, or none; repeatable
    /// [default: stuck-far:2, if there are three sensors]
    #[arg(long = "fault", value_name = "SPEC|none")]
    faults: Vec<OrNone<FaultSpec>>,
    /// How many readings, of all sensors together [default: four sweeps of every head]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    readings: Option<u32>,
    /// The method, or all of them
    #[arg(long, value_name = "all|NAME", default_value = "all")]
    fusion: FusionArgument,
    /// Names the run: the same seed gives the same result
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        allow_hyphen_values = true
    )]
    seed: u64,
    /// Where the pictures go
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Print one JSON document instead
    #[arg(long)]
    json: bool,
}

/// One method or all.
#[derive(Debug, Clone, Copy)]
enum FusionArgument {
    All,
    One(Method),
}

impl FromStr for FusionArgument {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "all" => Ok(Self::All),
            name => match name.parse() {
                Ok(method) => Ok(Self::One(method)),
                Err(error) => Err(format!("{error}, or all")),
            },
        }
    }
}

impl Arguments {
    fn faults(&self) -> Result<Vec<FaultSpec>, Failure> {
        if self.faults.is_empty() && self.sensors.count() >= 3 {
            return Ok("stuck-far:2".parse().into_iter().collect());
        }
        or_none::given("--fault", &self.faults)
    }

    fn setup(&self) -> Result<Setup, Failure> {
        let world = match &self.world {
            Some(file) => World::load(file).map_err(|error| Failure::input(&error))?,
            None => World::built_in(),
        };
        let sweep = u32::from(SWEEP.directions()) * u32::from(self.sensors.count());
        let length = Length::Readings(self.readings.unwrap_or(SWEEPS * sweep));
        let crew = self.sensors.clone();
        Ok(Setup {
            faults: self.faults()?,
            ..Setup::smart_car(Arc::new(world), crew, length, self.seed)
        })
    }

    fn methods(&self) -> Vec<Method> {
        match self.fusion {
            FusionArgument::All => Method::ALL.to_vec(),
            FusionArgument::One(method) => vec![method],
        }
    }
}

/// A run and what the methods made of it.
#[derive(Debug)]
struct Simulated {
    run: Run,
    methods: Vec<MethodResult>,
}

/// Runs the simulation and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    output::check_listable(arguments.json, &arguments.out)?;
    let setup = arguments.setup()?;
    let run = setup
        .run()
        .map_err(|SetupError::Fault(error)| Failure::Input(format!("--fault: {error}")))?;
    let methods = arguments.methods().into_iter();
    let simulated = Simulated {
        methods: methods.map(|method| run.fuse(method)).collect(),
        run,
    };
    let out = OutDir::create(&arguments.out).map_err(|error| Failure::input(&error))?;
    let files = draw(&simulated, &out)?;
    if arguments.json {
        output::print_json(&Report::new(&simulated, &files))
    } else {
        output::print(&told(&simulated, &arguments.out))
    }
}

/// Writes the pictures: the truth, each method's map, and all of them in one.
fn draw(simulated: &Simulated, out: &OutDir) -> Result<Vec<PathBuf>, Failure> {
    const ZOOM: NonZeroU32 = NonZeroU32::new(24).unwrap();
    let Simulated { run, methods } = simulated;
    let geometry = run.reference.geometry();
    let truth: Vec<_> = run
        .reference
        .cells()
        .iter()
        .map(|truth| truth.certainty())
        .collect();
    let mut maps = vec![("truth", truth.as_slice())];
    maps.extend(
        methods
            .iter()
            .map(|result| (result.method.name(), result.cells.as_slice())),
    );
    let mut files = Vec::new();
    for &(name, cells) in &maps {
        let image = map_image(&geometry, cells)?;
        let written = out.write(&format!("{name}.png"), |file| {
            write_grey_png(&image, ZOOM, file)
        });
        files.push(written.map_err(|error| Failure::input(&error))?);
    }
    let maps: Vec<&[Certainty]> = maps.into_iter().map(|(_, cells)| cells).collect();
    let written = out.write("overview.png", |file| {
        overview(&geometry, &maps, run.reference.cells(), file)
    });
    files.push(written.map_err(|error| Failure::input(&error))?);
    Ok(files)
}

/// The report as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct Report {
    seed: u64,
    readings: usize,
    world: WorldReport,
    methods: Vec<MethodReport>,
    sensors: Vec<SensorReport>,
    files: Vec<String>,
}

/// The grid's size in cells.
#[derive(Debug, Serialize)]
struct WorldReport {
    width: u16,
    height: u16,
    cell_mm: u32,
}

#[derive(Debug, Serialize)]
struct MethodReport {
    name: &'static str,
    mae: f64,
    mse: f64,
    missed: f64,
    ghost: f64,
    bytes: usize,
}

#[derive(Debug, Serialize)]
struct SensorReport {
    id: u8,
    model: char,
    fault: Option<String>,
    #[serde(flatten)]
    health: HealthReport,
}

impl Report {
    fn new(simulated: &Simulated, files: &[PathBuf]) -> Self {
        let Simulated { run, methods } = simulated;
        let geometry = run.reference.geometry();
        let methods = methods.iter().map(|result| MethodReport {
            name: result.method.name(),
            mae: result.score.mae,
            mse: result.score.mse,
            missed: result.score.missed,
            ghost: result.score.ghost,
            bytes: result.bytes,
        });
        Self {
            seed: run.setup.seed,
            readings: run.readings.len(),
            world: WorldReport {
                width: geometry.columns(),
                height: geometry.rows(),
                cell_mm: geometry.cell_size().get(),
            },
            methods: methods.collect(),
            sensors: sensors(simulated),
            files: output::listed(files),
        }
    }
}

/// What is known of the sensors: by the robust grid, which learns it, if it was run.
fn sensors(Simulated { run, methods }: &Simulated) -> Vec<SensorReport> {
    let learned = methods
        .iter()
        .find(|result| result.method == Method::Robust);
    let Some(MethodResult { health, .. }) = learned.or(methods.first()) else {
        return Vec::new();
    };
    let known = health.iter().zip(run.setup.sensors.members());
    let names = run.setup.sensors.names();
    let report = known.map(|((id, health), member)| {
        let faults = run.setup.faults.iter();
        let faults = faults.filter(|spec| spec.sensor.resolve(&names) == Ok(*id));
        let faults: Vec<String> = faults.map(ToString::to_string).collect();
        SensorReport {
            id: id.number(),
            model: member.letter,
            fault: (!faults.is_empty()).then(|| faults.join(", ")),
            health: HealthReport::from(health),
        }
    });
    report.collect()
}

/// The report for people.
fn told(simulated: &Simulated, out: &Path) -> String {
    let Simulated { run, methods } = simulated;
    let setup = &run.setup;
    let faults: Vec<String> = setup.faults.iter().map(ToString::to_string).collect();
    let faults = if faults.is_empty() {
        "none".to_owned()
    } else {
        faults.join(", ")
    };
    let mut text = format!(
        "world: {}   sensors: {}   readings: {}   seed: {}\nfault: {faults}\n\n",
        Excerpt::new(setup.world.name()),
        setup.sensors,
        run.readings.len(),
        setup.seed
    );

    let truth = run.reference.cells();
    let ideal = |&cell: &Truth| Mark::of(cell.certainty(), cell);
    let mut panels = vec![Panel {
        title: "truth".into(),
        marks: truth.iter().map(ideal).collect(),
    }];
    panels.extend(methods.iter().map(|result| {
        Panel {
            title: result.method.name().into(),
            marks: result
                .cells
                .iter()
                .zip(truth)
                .map(|(&shown, &truth)| Mark::of(shown, truth))
                .collect(),
        }
    }));
    text += &side_by_side(&run.reference.geometry(), &panels, output::coloured());
    text += Mark::LEGEND;
    text += "\nThe truth is what perfect sensors would have drawn with the same looks.\n\n";

    let mut rows = vec![row(["method", "MAE", "MSE", "missed", "ghost", "bytes"])];
    rows.extend(methods.iter().map(|result| {
        let score = &result.score;
        vec![
            result.method.to_string(),
            format!("{:.3}", score.mae),
            format!("{:.3}", score.mse),
            percent(score.missed),
            percent(score.ghost),
            result.bytes.to_string(),
        ]
    }));
    text += &table(&rows);

    let mut rows = vec![[row(["sensor", "fault"]), row(HealthReport::COLUMNS)].concat()];
    rows.extend(sensors(simulated).into_iter().map(|sensor| {
        let mut cells = vec![
            format!("{} ({})", sensor.id, sensor.model),
            sensor.fault.unwrap_or_else(|| "-".into()),
        ];
        cells.extend(sensor.health.cells());
        cells
    }));
    text.push('\n');
    text += &table(&rows);
    text += caveat(methods.iter().map(|result| result.method));
    let seconds =
        run.readings.len() as f64 / f64::from(setup.sensors.count()) * f64::from(STEP_MS) / 1e3;
    text += &format!(
        "\n{seconds:.0} s of the car's time; pictures in {}: overview.png shows all maps\n",
        shown(out)
    );
    text
}

/// A share as a percentage.
pub(super) fn percent(share: f64) -> String {
    format!("{:.1} %", share * 100.0)
}
