//! `certainty simulate`: the Smart Car in a world, every method on the same readings.

use super::maps::{Mark, Panel, map_image, overview, side_by_side};
use super::options::{CommonOptions, OrNone, check_trim, given, named, world};
use super::output::Failure;
use super::output::{self, Report};
use super::table::{HealthReport, caveat, list, percent, row, table};
use certainty_core::certainty::Certainty;
use certainty_firmware::smart_car::SWEEP;
use certainty_sim::export::{OutDir, display_path, write_grey_png};
use certainty_sim::fault::FaultSpec;
use certainty_sim::fusion::{FusionRules, Method};
use certainty_sim::quantity::Excerpt;
use certainty_sim::simulation::{Length, MethodResult, Run, STEP_MS, Setup, SetupError, Truth};
use certainty_sim::transducer::SensorSet;
use certainty_sim::world::World;
use clap::Args;
use core::num::NonZeroU32;
use serde::Serialize;
use std::path::PathBuf;
use std::sync::Arc;

/// Sweeps of every head in a run without `--readings`.
const SWEEPS: u32 = 4;

/// The options of `certainty simulate`.
#[derive(Debug, Args)]
#[command(mut_arg("out", |out| out.help("Folder for the pictures")))]
pub(super) struct Arguments {
    /// TOML file of the obstacles; without it, the built-in scene
    #[arg(long, value_name = "FILE")]
    world: Option<PathBuf>,
    /// Sensors: letters A to E of [001] Table 1, or a number from 3 to 7
    #[arg(long, value_name = "ABC|3..7", default_value_t)]
    sensors: SensorSet,
    /// Fault of a sensor, such as stuck-near:1=250mm@3s..8s, or none; repeatable
    /// [default: stuck-far:2, with three sensors or more]
    #[arg(long = "fault", value_name = "SPEC|none")]
    faults: Vec<OrNone<FaultSpec>>,
    /// Number of readings of all sensors together [default: four sweeps of every head]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    readings: Option<u32>,
    /// Fusion method, or all of them
    #[arg(long, value_name = "METHOD", default_value = "all",
          value_parser = named(FusionArgument::all(), FusionArgument::name))]
    fusion: FusionArgument,
    /// Certainties that the trimmed method drops at each end [default: half of the other sensors]
    #[arg(long, value_name = "N")]
    trim: Option<u8>,
    /// Validate each sensor's readings before they are fused, as [002] Fig. 1 draws it
    #[arg(long)]
    validate: bool,
    #[command(flatten)]
    common: CommonOptions,
}

/// One method or all.
#[derive(Debug, Clone, Copy)]
enum FusionArgument {
    All,
    One(Method),
}

impl FusionArgument {
    /// Returns `all` and every method.
    fn all() -> Vec<Self> {
        let methods = Method::ALL.map(Self::One);
        [&[Self::All][..], &methods].concat()
    }

    const fn name(self) -> &'static str {
        match self {
            Self::All => "all",
            Self::One(method) => method.name(),
        }
    }
}

impl Arguments {
    fn faults(&self) -> Result<Vec<FaultSpec>, Failure> {
        if self.faults.is_empty() && self.sensors.count() >= 3 {
            let fault = "stuck-far:2".parse::<FaultSpec>();
            return Ok(vec![
                fault.map_err(|error| Failure::Internal(error.to_string()))?,
            ]);
        }
        given("--fault", &self.faults)
    }

    fn setup(&self) -> Result<Setup, Failure> {
        let world = world(self.world.as_deref(), World::built_in)?;
        let sweep = u32::from(SWEEP.directions()) * u32::from(self.sensors.count());
        let length = Length::Readings(self.readings.unwrap_or(SWEEPS * sweep));
        let sensors = self.sensors.clone();
        check_trim(self.trim, self.methods(), sensors.count())?;
        Ok(Setup {
            faults: self.faults()?,
            validated: self.validate,
            fusion: FusionRules {
                trim: self.trim,
                ..FusionRules::default()
            },
            ..Setup::smart_car(Arc::new(world), sensors, length, self.common.seed)
        })
    }

    fn methods(&self) -> Vec<Method> {
        match self.fusion {
            FusionArgument::All => Method::ALL.to_vec(),
            FusionArgument::One(method) => vec![method],
        }
    }
}

/// A run, every method's result, and the pictures.
struct Simulation<'a> {
    arguments: &'a Arguments,
    run: Run,
    methods: Vec<MethodResult>,
    files: Vec<PathBuf>,
}

/// Runs the simulation and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    arguments.common.output.check()?;
    let setup = arguments.setup()?;
    let out = arguments.common.output.create()?;
    let run = setup
        .run()
        .map_err(|SetupError::Fault(error)| Failure::Input(format!("--fault: {error}")))?;
    let methods = arguments.methods().into_iter();
    let methods: Vec<_> = methods.map(|method| run.fuse(method)).collect();
    let files = draw(&run, &methods, &out)?;
    out.finish().map_err(|error| Failure::input(&error))?;
    arguments.common.output.print(&Simulation {
        arguments,
        run,
        methods,
        files,
    })
}

/// Writes the pictures: the truth, each method's map, and all of them in one.
fn draw(run: &Run, methods: &[MethodResult], out: &OutDir) -> Result<Vec<PathBuf>, Failure> {
    const ZOOM: NonZeroU32 = NonZeroU32::new(24).unwrap();
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
struct Document {
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

impl Report for Simulation<'_> {
    fn document(&self) -> impl Serialize {
        let Self { run, methods, .. } = self;
        let geometry = run.reference.geometry();
        let reports = methods.iter().map(|result| MethodReport {
            name: result.method.name(),
            mae: result.score.mae,
            mse: result.score.mse,
            missed: result.score.missed,
            ghost: result.score.ghost,
            bytes: result.bytes,
        });
        Document {
            seed: run.setup.seed,
            readings: run.readings.len(),
            world: WorldReport {
                width: geometry.columns(),
                height: geometry.rows(),
                cell_mm: geometry.cell_size().get(),
            },
            methods: reports.collect(),
            sensors: sensors(run, methods),
            files: output::listed(&self.files),
        }
    }

    fn render(&self) -> String {
        let Self { run, methods, .. } = self;
        let setup = &run.setup;
        let faults = list(&setup.faults, ", ");
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
        text += "\nThe truth is the grid of perfect sensors in the same directions.\n\n";

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
        rows.extend(sensors(run, methods).into_iter().map(|sensor| {
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
            "\n{seconds:.0} s of simulated time; pictures in {}: overview.png shows all maps\n",
            display_path(&self.arguments.common.output.out)
        );
        text
    }
}

/// The sensors' health by the robust grid, which learns it, if it was run; else by the first method.
fn sensors(run: &Run, methods: &[MethodResult]) -> Vec<SensorReport> {
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
        let faults: Vec<_> = faults.collect();
        SensorReport {
            id: id.number(),
            model: member.letter,
            fault: (!faults.is_empty()).then(|| list(faults, ", ")),
            health: HealthReport::from(health),
        }
    });
    report.collect()
}
