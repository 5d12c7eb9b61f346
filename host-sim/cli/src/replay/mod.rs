//! `certainty replay`: a recording of a real robot becomes a map and its sensors' health.

mod report;

use super::{Failure, map_image, output, progress};
use certainty_core::fusion::{Beam, BeamConfig, BeamModel, Behind, Geometry};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Millimeters, Point};
use certainty_sim::export::{OutDir, write_grey_png, write_ros_map};
use certainty_sim::fault::{FaultSpec, Faulty, assign};
use certainty_sim::fusion::{FusionRules, HostMapper, Method};
use certainty_sim::quantity;
use certainty_sim::replay::{Format, LoadOptions, RecordedBeam, Recording, load};
use certainty_sim::transducer::{Look, Sensor};
use clap::{Args, ValueEnum};
use core::num::{NonZeroU8, NonZeroU32};
use core::time::Duration;
use report::{Report, told};
use std::path::PathBuf;
use std::time::Instant;

/// What the replay is asked.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The recording: a CARMEN log or a readings CSV, plain or gzip
    file: PathBuf,
    /// How to read it
    #[arg(long, value_enum, default_value_t = FormatArgument::Auto)]
    format: FormatArgument,
    /// The side of a cell
    #[arg(long, value_name = "LENGTH", default_value = "100mm", value_parser = quantity::length, allow_hyphen_values = true)]
    cell: Millimeters,
    /// A reading this long or longer is no object
    #[arg(long, value_name = "LENGTH", default_value = "8m", value_parser = quantity::length, allow_hyphen_values = true)]
    max_range: Millimeters,
    /// The opening angle of a beam [default: what the recording says, or a narrow one]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::opening)]
    beam_width: Option<BinaryAngle>,
    /// How many virtual sensors a laser's beams are dealt to
    #[arg(long, value_name = "N", default_value = "3")]
    sensors: NonZeroU8,
    /// The fusion method
    #[arg(long, value_name = "NAME", default_value = "robust")]
    fusion: Method,
    /// What to make wrong with a sensor, such as stuck-far:2; repeatable
    #[arg(long = "fault", value_name = "SPEC")]
    faults: Vec<FaultSpec>,
    /// Names the faults' random numbers
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        allow_hyphen_values = true
    )]
    seed: u64,
    /// The largest map, in cells; where a method keeps a layer for each sensor, of all layers together
    #[arg(long, value_name = "N", default_value_t = 100_000_000)]
    max_cells: u64,
    /// Where the map goes
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Print one JSON document instead
    #[arg(long)]
    json: bool,
}

/// A recording's format on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FormatArgument {
    /// The content tells
    Auto,
    /// A CARMEN log: `FLASER` and `ROBOTLASER1` lines
    Carmen,
    /// Our readings: a beam a line
    Readings,
}

/// A replay that can begin.
struct Replay {
    recording: Recording,
    model: BeamModel,
    sensors: Vec<Faulty<Recorded>>,
    mapper: HostMapper,
}

/// A finished replay.
struct Replayed {
    mapper: HostMapper,
    recording: Recording,
    cells_updated: u64,
    insertion: Duration,
}

/// Replays the recording and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.max_range == Millimeters::ZERO {
        return Err(Failure::Input(
            "--max-range: write at least 1mm, such as 8m".into(),
        ));
    }
    output::check_listable(arguments.json, &arguments.out)?;
    let recording = arguments.load()?;
    let replay = arguments.prepare(recording)?;
    // Before the long part, but after all that can be refused: a refusal leaves no folder.
    let out = OutDir::create(&arguments.out).map_err(|error| Failure::input(&error))?;
    let replayed = replay.run(arguments)?;
    let files = draw(&replayed.mapper, &out)?;
    if arguments.json {
        output::print_json(&Report::new(&replayed, &files))
    } else {
        output::print(&told(arguments, &replayed, &files))
    }
}

impl Arguments {
    fn load(&self) -> Result<Recording, Failure> {
        let options = LoadOptions {
            format: match self.format {
                FormatArgument::Auto => None,
                FormatArgument::Carmen => Some(Format::Carmen),
                FormatArgument::Readings => Some(Format::Readings),
            },
            max_range: Some(self.max_range),
            sensors: self.sensors,
            ..LoadOptions::default()
        };
        let bar = progress::bar("reading", 0);
        let loaded = load(&self.file, &options, &mut |done, total| {
            bar.set_length(total);
            bar.set_position(done);
        });
        bar.finish_and_clear();
        loaded.map_err(|error| Failure::input(&error))
    }

    /// Everything that is needed for the replay, or why it cannot be done.
    fn prepare(&self, recording: Recording) -> Result<Replay, Failure> {
        let geometry = self.geometry(&recording)?;
        let model = self.model(recording.beam_width)?;
        let names = vec![""; recording.sensors.into()];
        let faults = assign(&self.faults, &names)
            .map_err(|error| Failure::Input(format!("--fault: {error}")))?;
        let recorded = || Recorded::new(self.max_range);
        let sensors = (0..).map_while(SensorId::from_slot).zip(faults);
        Ok(Replay {
            mapper: HostMapper::new(
                self.fusion,
                &FusionRules::default(),
                geometry,
                recording.sensors,
            ),
            sensors: sensors
                .map(|(id, faults)| Faulty::new(recorded(), id, faults, self.seed))
                .collect(),
            model,
            recording,
        })
    }

    /// The grid that holds every origin and echo, on whole cells, with a cell to spare around.
    fn geometry(&self, recording: &Recording) -> Result<Geometry, Failure> {
        let cell = i64::from(self.cell.get());
        if cell == 0 {
            return Err(Failure::Input(
                "--cell: write at least 1mm, such as 100mm".into(),
            ));
        }
        let (low, high) = recording.extent();
        let side = |low: i32, high: i32| {
            let first = i64::from(low).div_euclid(cell) - 1;
            let last = i64::from(high).div_euclid(cell) + 1;
            (first, last - first + 1)
        };
        let (left, columns) = side(low.x_mm(), high.x_mm());
        let (lower, rows) = side(low.y_mm(), high.y_mm());
        let layers = self.fusion.layers(recording.sensors);
        let cells = columns.unsigned_abs().saturating_mul(rows.unsigned_abs());
        let cells = cells.saturating_mul(layers);
        let too_large = || {
            Failure::Input(format!(
                "{}: the map would need {columns} x {rows} cells of {} in {layers} layers, {cells} \
                 cells, more than --max-cells {}; choose a larger --cell or --max-cells",
                self.file.display(),
                self.cell,
                self.max_cells
            ))
        };
        if cells > self.max_cells {
            return Err(too_large());
        }
        let millimetres = |cells: i64| i32::try_from(cells * cell).map_err(|_| too_large());
        let corner = Point::from_mm(millimetres(left)?, millimetres(lower)?);
        match (u16::try_from(columns), u16::try_from(rows)) {
            (Ok(columns), Ok(rows)) => Geometry::try_new(columns, rows, self.cell, corner)
                .map_err(|error| Failure::Input(format!("{}: {error}", self.file.display()))),
            _ => Err(Failure::Input(format!(
                "{}: the map would be {columns} x {rows} cells, and a side may have 65535; choose \
                 a larger --cell",
                self.file.display()
            ))),
        }
    }

    /// The beams of this recording: exact, up to the largest range, and silent about what lies
    /// behind an echo, which a robot that moves may have seen before.
    fn model(&self, recorded_width: Option<BinaryAngle>) -> Result<BeamModel, Failure> {
        let width = self.beam_width.or(recorded_width).unwrap_or_default();
        let half_width = BinaryAngle::from_bits(width.to_bits() / 2);
        let config = if half_width == BinaryAngle::ZERO {
            BeamConfig::narrow(self.max_range)
        } else {
            BeamConfig::cone(self.max_range, half_width)
        };
        BeamModel::try_new(BeamConfig {
            behind: Behind::Untouched,
            ..config
        })
        .map_err(|error| Failure::Input(format!("--beam-width or --max-range: {error}")))
    }
}

impl Replay {
    fn run(self, arguments: &Arguments) -> Result<Replayed, Failure> {
        let Self {
            recording,
            model,
            mut sensors,
            mut mapper,
        } = self;
        let bar = progress::bar("mapping", recording.beams.len() as u64);
        let mut cells_updated = 0;
        let mut insertion = Duration::ZERO;
        // Readings are made ready in batches, so that what is timed is insertion alone.
        let mut ready = Vec::new();
        for beams in recording.beams.chunks(1000) {
            ready.clear();
            for beam in beams {
                report(&mut sensors[beam.sensor.slot()], beam, &mut ready);
            }
            let start = Instant::now();
            for beam in &ready {
                let told = mapper.integrate(beam.sensor, &Beam::from(beam), &model, beam.at);
                cells_updated += u64::from(told.map_err(|error| {
                    Failure::Internal(format!("{}: {error}", arguments.file.display()))
                })?);
            }
            insertion += start.elapsed();
            bar.inc(beams.len() as u64);
        }
        bar.finish_and_clear();
        Ok(Replayed {
            mapper,
            recording,
            cells_updated,
            insertion,
        })
    }
}

/// Takes a beam's turn: what its sensor, sound or faulty, reports.
fn report(sensor: &mut Faulty<Recorded>, beam: &RecordedBeam, ready: &mut Vec<RecordedBeam>) {
    sensor.inner_mut().reading = beam.reading;
    let look = Look {
        origin: beam.origin,
        bearing: beam.bearing,
        at: beam.at,
    };
    for _ in 0..sensor.reports_per_turn(beam.at) {
        ready.push(RecordedBeam {
            reading: sensor.sense(&look),
            ..*beam
        });
    }
}

/// A sensor that says what was recorded.
#[derive(Debug)]
struct Recorded {
    reading: Reading,
    farthest: Millimeters,
}

impl Recorded {
    const fn new(farthest: Millimeters) -> Self {
        Self {
            reading: Reading::NoObject,
            farthest,
        }
    }
}

impl Sensor for Recorded {
    fn sense(&mut self, _look: &Look) -> Reading {
        self.reading
    }

    fn range(&self) -> (Millimeters, Millimeters) {
        (Millimeters::ZERO, self.farthest)
    }
}

/// Writes the map: a picture, and PGM + YAML for other programs.
fn draw(mapper: &HostMapper, out: &OutDir) -> Result<Vec<PathBuf>, Failure> {
    let cells = mapper.cells();
    let map = map_image(&mapper.geometry(), &cells)?;
    let picture = out.write("map.png", |file| {
        write_grey_png(&map, NonZeroU32::MIN, file)
    });
    let mut files = vec![picture.map_err(|error| Failure::input(&error))?];
    let map = write_ros_map(out, "map", &map).map_err(|error| Failure::input(&error))?;
    files.extend([map.pgm, map.yaml]);
    Ok(files)
}
