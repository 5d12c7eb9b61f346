//! `certainty replay`: a recording of a real robot as a map, with its sensors' health.

use super::maps::map_image;
use super::options::{CommonOptions, check_trim, named};
use super::output::Failure;
use super::output::{self, Report, progress};
use super::table::{HealthReport, caveat, counted, row, table};
use certainty_core::fusion::{Beam, BeamConfig, BeamModel, Behind, Geometry};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Reading, ValidationConfig, ValidationRules};
use certainty_core::units::{BinaryAngle, Millimeters, Point};
use certainty_sim::export::{OutDir, display_path, write_grey_png, write_ros_map};
use certainty_sim::fault::{FaultSpec, Faulty, assign_by_number};
use certainty_sim::fusion::{FusionRules, HostMapper, Method};
use certainty_sim::quantity::{self, FieldOfView};
use certainty_sim::replay::{AngleUnit, LengthUnit, RangeUnit, SkipCount, TimeUnit};
use certainty_sim::replay::{Format, LoadOptions, RecordedBeam, Recording, ZeroMeans, load};
use certainty_sim::transducer::{Look, Sensor, Validation};
use clap::{Args, ValueEnum};
use core::num::{NonZeroU8, NonZeroU32};
use core::time::Duration;
use cpu_time::ThreadTime;
use serde::Serialize;
use std::path::PathBuf;
use std::time::Instant;

/// The options of `certainty replay`.
#[derive(Debug, Args)]
#[command(
    mut_arg("seed", |seed| seed.help("Seed of the faults' random numbers")),
    mut_arg("out", |out| out.help("Folder for the map"))
)]
pub(super) struct Arguments {
    /// Recording: a CARMEN log or a CSV, plain or packed (gzip, xz, bzip2, zip); - is stdin
    file: PathBuf,
    /// Format of the recording
    #[arg(long, value_enum, default_value_t = FormatArgument::Auto)]
    format: FormatArgument,
    /// Side of a cell
    #[arg(long, value_name = "LENGTH", default_value = "100mm", value_parser = quantity::length, allow_hyphen_values = true)]
    cell: Millimeters,
    /// Range: a reading of this length or more is no object
    #[arg(long, value_name = "LENGTH", default_value = "8m", value_parser = quantity::length, allow_hyphen_values = true)]
    max_range: Millimeters,
    /// Opening angle of a beam [default: the recording's, or a narrow beam]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::opening)]
    beam_width: Option<BinaryAngle>,
    /// Number of virtual sensors that share a laser's beams
    #[arg(long, value_name = "N", default_value = "3")]
    sensors: NonZeroU8,
    /// Meaning of a reading of 0: no object, or too near, which marks the cells at the sensor
    #[arg(long, value_enum, default_value_t = ZeroArgument::None)]
    zero: ZeroArgument,
    /// Field of view of a scan or of the ranges of a wide CSV, around straight ahead [default: the file's, or
    /// that of lasers with this number of beams; of a wide CSV a full turn]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::field_of_view)]
    fov: Option<FieldOfView>,
    /// Direction of the first beam of a scan or of a wide CSV's line, counter-clockwise from straight ahead
    /// [default: the file's, or half of the field of view to the right; of a full turn straight ahead]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true)]
    start_angle: Option<BinaryAngle>,
    /// Unit of readings in CSV columns whose names have none: distances or echo times of a sonar
    #[arg(long, value_enum, value_name = "UNIT")]
    unit: Option<UnitArgument>,
    /// Unit of positions in CSV columns whose names have none [default: m]
    #[arg(long, value_enum, value_name = "UNIT")]
    pose_unit: Option<PoseUnitArgument>,
    /// Unit of directions in a CSV column whose name has none [default: rad]
    #[arg(long, value_enum, value_name = "UNIT")]
    heading_unit: Option<HeadingUnitArgument>,
    /// Unit of times in a CSV column whose name has none [default: by the first time]
    #[arg(long, value_enum, value_name = "UNIT")]
    time_unit: Option<TimeUnitArgument>,
    /// Leave out beams behind a step of the pose longer than this
    #[arg(long, value_name = "LENGTH", value_parser = quantity::length, allow_hyphen_values = true)]
    max_step: Option<Millimeters>,
    /// Read a file of which more than a twentieth of the lines are unreadable
    #[arg(long)]
    lenient: bool,
    /// Most beams in memory, 24 bytes each
    #[arg(long, value_name = "N", default_value_t = LoadOptions::default().max_beams)]
    max_beams: usize,
    /// Fusion method
    #[arg(long, value_name = "METHOD", default_value = "robust", value_parser = named(Method::ALL, Method::name))]
    fusion: Method,
    /// Certainties that the trimmed method drops at each end [default: half of the other sensors]
    #[arg(long, value_name = "N")]
    trim: Option<u8>,
    /// Validate each sensor's readings before they are fused, as [002] Fig. 1 draws it
    #[arg(long)]
    validate: bool,
    /// Fault to add to a sensor, such as stuck-far:2; repeatable
    #[arg(long = "fault", value_name = "SPEC")]
    faults: Vec<FaultSpec>,
    /// Most cells of the map; of all layers together, if the method keeps one for each sensor
    #[arg(long, value_name = "N", default_value_t = 100_000_000)]
    max_cells: u64,
    #[command(flatten)]
    common: CommonOptions,
}

/// A recording's format, as `--format` has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FormatArgument {
    /// By the content
    Auto,
    /// A CARMEN log: lines of lasers or sonars, with their poses or odometry
    Carmen,
    /// Readings CSV: a beam per line
    Readings,
    /// Wide CSV: a pose and several ranges per line
    Wide,
}

/// The meaning of a reading of 0, as `--zero` has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum ZeroArgument {
    /// No object
    None,
    /// An object too near to measure
    Near,
}

impl ZeroArgument {
    /// Returns the meaning.
    pub(super) const fn meaning(self) -> ZeroMeans {
        match self {
            Self::None => ZeroMeans::NoObject,
            Self::Near => ZeroMeans::TooNear,
        }
    }
}

/// The unit of readings, as `--unit` has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum UnitArgument {
    /// Millimetres
    Mm,
    /// Centimetres
    Cm,
    /// Metres
    M,
    /// Seconds until the echo
    EchoS,
    /// Milliseconds until the echo
    EchoMs,
    /// Microseconds until the echo
    EchoUs,
}

/// The unit of positions, as `--pose-unit` has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PoseUnitArgument {
    /// Millimetres
    Mm,
    /// Centimetres
    Cm,
    /// Metres
    M,
}

/// The unit of directions, as `--heading-unit` has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum HeadingUnitArgument {
    /// Degrees
    Deg,
    /// Thousandths of a degree
    Mdeg,
    /// Radians
    Rad,
}

/// The unit of times, as `--time-unit` has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum TimeUnitArgument {
    /// Seconds
    S,
    /// Milliseconds
    Ms,
    /// Microseconds
    Us,
    /// Nanoseconds
    Ns,
}

/// A replay, ready to run.
struct Replay {
    recording: Recording,
    model: BeamModel,
    sensors: Vec<Played>,
    mapper: HostMapper,
}

/// A finished replay.
struct Replayed<'a> {
    arguments: &'a Arguments,
    mapper: HostMapper,
    recording: Recording,
    cells_updated: u64,
    insertion: Duration,
    insertion_cpu: Duration,
    files: Vec<PathBuf>,
}

/// Replays the recording and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.max_range == Millimeters::ZERO {
        return Err(Failure::Input(
            "--max-range: 0mm is too short: expected at least 1mm, such as 8m".into(),
        ));
    }
    arguments.common.output.check()?;
    let recording = arguments.load()?;
    let replay = arguments.prepare(recording)?;
    // Before the long part, but after every check of the input: an error leaves no folder.
    let out = arguments.common.output.create()?;
    let mut replayed = replay.run(arguments)?;
    replayed.files = draw(&replayed.mapper, &out)?;
    out.finish().map_err(|error| Failure::input(&error))?;
    arguments.common.output.print(&replayed)
}

impl Arguments {
    fn load(&self) -> Result<Recording, Failure> {
        let options = LoadOptions {
            format: match self.format {
                FormatArgument::Auto => None,
                FormatArgument::Carmen => Some(Format::Carmen),
                FormatArgument::Readings => Some(Format::Readings),
                FormatArgument::Wide => Some(Format::Wide),
            },
            max_range: Some(self.max_range),
            sensors: self.sensors,
            zero: self.zero.meaning(),
            fov: self.fov,
            start_angle: self.start_angle,
            unit: self.unit.map(|unit| match unit {
                UnitArgument::Mm => RangeUnit::Millimeters,
                UnitArgument::Cm => RangeUnit::Centimeters,
                UnitArgument::M => RangeUnit::Meters,
                UnitArgument::EchoS => RangeUnit::EchoSeconds,
                UnitArgument::EchoMs => RangeUnit::EchoMilliseconds,
                UnitArgument::EchoUs => RangeUnit::EchoMicroseconds,
            }),
            pose_unit: self.pose_unit.map(|unit| match unit {
                PoseUnitArgument::Mm => LengthUnit::Millimeters,
                PoseUnitArgument::Cm => LengthUnit::Centimeters,
                PoseUnitArgument::M => LengthUnit::Meters,
            }),
            heading_unit: self.heading_unit.map(|unit| match unit {
                HeadingUnitArgument::Deg => AngleUnit::Degrees,
                HeadingUnitArgument::Mdeg => AngleUnit::Millidegrees,
                HeadingUnitArgument::Rad => AngleUnit::Radians,
            }),
            time_unit: self.time_unit.map(|unit| match unit {
                TimeUnitArgument::S => TimeUnit::Seconds,
                TimeUnitArgument::Ms => TimeUnit::Milliseconds,
                TimeUnitArgument::Us => TimeUnit::Microseconds,
                TimeUnitArgument::Ns => TimeUnit::Nanoseconds,
            }),
            max_step: self.max_step,
            lenient: self.lenient,
            max_beams: self.max_beams,
        };
        let bar = progress("reading", 0);
        let loaded = load(&self.file, &options, &mut |done, total| {
            bar.set_length(total);
            bar.set_position(done);
        });
        bar.finish_and_clear();
        loaded.map_err(|error| Failure::input(&error))
    }

    /// Checks the options against the recording and prepares the replay.
    fn prepare(&self, recording: Recording) -> Result<Replay, Failure> {
        if recording.format == Format::Readings
            && (self.fov.is_some() || self.start_angle.is_some())
        {
            return Err(Failure::Input(
                "--fov, --start-angle: each line of this recording has a direction: expected them for scans and wide \
                 CSVs only"
                    .into(),
            ));
        }
        check_trim(self.trim, [self.fusion], recording.sensors)?;
        let geometry = self.geometry(&recording)?;
        let validation = self.validation()?;
        let model = self.model(recording.beam_width)?;
        let faults = assign_by_number(&self.faults, &recording.names)
            .map_err(|error| Failure::Input(format!("--fault: {error}")))?;
        let recorded = || Recorded::new(self.max_range);
        let sensors = (0..).map_while(SensorId::from_slot).zip(faults);
        Ok(Replay {
            mapper: HostMapper::new(
                self.fusion,
                &FusionRules {
                    trim: self.trim,
                    ..FusionRules::default()
                },
                geometry,
                recording.sensors,
            ),
            sensors: sensors
                .map(|(id, faults)| Played {
                    sensor: Faulty::new(recorded(), id, faults, self.common.seed),
                    validation,
                })
                .collect(),
            model,
            recording,
        })
    }

    /// Returns the grid of every origin and echo, on whole cells, with a margin of one cell.
    fn geometry(&self, recording: &Recording) -> Result<Geometry, Failure> {
        let cell = i64::from(self.cell.get());
        if cell == 0 {
            return Err(Failure::Input(
                "--cell: 0mm is too short: expected at least 1mm, such as 100mm".into(),
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
        let stray = || {
            let stray = recording.stray_pose();
            stray.map_or_else(String::new, |stray| format!("; {stray}"))
        };
        let too_large = || {
            Failure::Input(format!(
                "{}: the map would need {columns} x {rows} cells of {} in {layers} layers, {cells} \
                 cells, more than --max-cells {}: expected a larger --cell or --max-cells{}",
                self.file.display(),
                self.cell,
                self.max_cells,
                stray()
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
                "{}: the map would be {columns} x {rows} cells, and a side has at most 65535: expected a \
                 larger --cell{}",
                self.file.display(),
                stray()
            ))),
        }
    }

    /// Returns the beam model: exact, up to the largest range, and without a claim behind an echo, where
    /// a moving robot may have measured before.
    fn model(&self, recorded_width: Option<BinaryAngle>) -> Result<BeamModel, Failure> {
        let width = self.beam_width.or(recorded_width).unwrap_or_default();
        let half_width = BinaryAngle::from_bits(width.to_bits() / 2);
        let config = if half_width == BinaryAngle::ZERO {
            BeamConfig::narrow(self.max_range)
        } else {
            BeamConfig::cone(self.max_range, half_width)
        };
        BeamModel::try_new(BeamConfig {
            // Too near is known to the cell at the sensor and the next.
            nearest: self.cell.min(self.max_range - Millimeters::new(1)),
            behind: Behind::Untouched,
            ..config
        })
        .map_err(|error| Failure::Input(format!("--beam-width or --max-range: {error}")))
    }

    /// Returns the checks of every sensor's readings, if `--validate` asks for them.
    fn validation(&self) -> Result<Option<Validation>, Failure> {
        /// No surroundings give the same millimetre in as many successive directions.
        const MOST_REPEATS: u16 = 100;
        if !self.validate {
            return Ok(None);
        }
        let rules = ValidationRules::try_new(ValidationConfig::sweeping(
            Millimeters::ZERO,
            self.max_range,
            0,
            MOST_REPEATS,
            0,
        ));
        let rules = rules
            .map_err(|error| Failure::Input(format!("--max-range with --validate: {error}")))?;
        Ok(Some(Validation::new(rules)))
    }
}

impl Replay {
    fn run(self, arguments: &Arguments) -> Result<Replayed<'_>, Failure> {
        let Self {
            recording,
            model,
            mut sensors,
            mut mapper,
        } = self;
        let bar = progress("mapping", recording.beams.len() as u64);
        let mut cells_updated = 0;
        let mut insertion = Duration::ZERO;
        let mut insertion_cpu = Duration::ZERO;
        // Readings are prepared in batches, so that the measured time is insertion alone.
        let mut ready = Vec::new();
        for beams in recording.beams.chunks(1000) {
            ready.clear();
            for beam in beams {
                sense(&mut sensors[beam.sensor.slot()], beam, &mut ready);
            }
            let (start, start_cpu) = (Instant::now(), ThreadTime::try_now());
            for beam in &ready {
                let updated = mapper.integrate(beam.sensor, &Beam::from(beam), &model, beam.at);
                cells_updated += u64::from(updated.map_err(|error| {
                    Failure::Internal(format!("{}: {error}", arguments.file.display()))
                })?);
            }
            insertion += start.elapsed();
            // A system without such a clock has 0.
            let cpu = start_cpu.and_then(|start| start.try_elapsed());
            insertion_cpu += cpu.unwrap_or_default();
            bar.inc(beams.len() as u64);
        }
        bar.finish_and_clear();
        Ok(Replayed {
            arguments,
            mapper,
            recording,
            cells_updated,
            insertion,
            insertion_cpu,
            files: Vec::new(),
        })
    }
}

/// Adds the reports of a beam's sensor, sound or faulty, in its turn.
fn sense(played: &mut Played, beam: &RecordedBeam, ready: &mut Vec<RecordedBeam>) {
    let Played { sensor, validation } = played;
    sensor.inner_mut().reading = beam.reading;
    let look = Look {
        origin: beam.origin,
        bearing: beam.bearing,
        at: beam.at,
    };
    for _ in 0..sensor.reports_per_turn(beam.at) {
        let measured = sensor.sense(&look);
        let reading = match validation {
            Some(validation) => validation.check(measured, &look),
            None => measured,
        };
        ready.push(RecordedBeam { reading, ..*beam });
    }
}

/// A sensor of the recording, with its faults and the checks of its readings.
struct Played {
    sensor: Faulty<Recorded>,
    validation: Option<Validation>,
}

/// A sensor that returns the recorded reading.
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

/// The report as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct Document {
    readings: u64,
    echo: u64,
    no_object: u64,
    too_near: u64,
    missing: u64,
    skipped_lines: u64,
    skipped: Vec<SkipCount>,
    notes: Vec<String>,
    cells_updated: u64,
    insert_seconds: f64,
    /// The thread's CPU time of insertion alone.
    cpu_seconds: f64,
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
    /// The sensor's number in the file.
    id: u16,
    readings: u32,
    #[serde(flatten)]
    health: HealthReport,
}

impl Report for Replayed<'_> {
    fn document(&self) -> impl Serialize {
        let tally = self.recording.tally();
        let geometry = self.mapper.geometry();
        let bytes = self.mapper.memory_bytes() as f64;
        Document {
            readings: self.recording.beams.len() as u64,
            echo: tally.echo,
            no_object: tally.no_object,
            too_near: tally.too_near,
            missing: tally.missing,
            skipped_lines: self.recording.skipped.total(),
            skipped: self.recording.skipped.counts().collect(),
            notes: self.recording.notes.clone(),
            cells_updated: self.cells_updated,
            insert_seconds: self.insertion.as_secs_f64(),
            cpu_seconds: self.insertion_cpu.as_secs_f64(),
            grid: GridReport {
                width: geometry.columns(),
                height: geometry.rows(),
                cell_mm: geometry.cell_size().get(),
                bytes_per_cell: bytes / f64::from(geometry.cells()),
            },
            sensors: sensors(&self.mapper, &self.recording),
            files: output::listed(&self.files),
        }
    }

    fn render(&self) -> String {
        let Self {
            arguments,
            mapper,
            recording,
            ..
        } = self;
        let tally = recording.tally();
        let geometry = mapper.geometry();
        let mut text = format!(
            "{}: {}: {}, {} without object, {} too near, {} missing\n",
            display_path(&arguments.file),
            counted(recording.beams.len() as u64, "reading"),
            if tally.echo == 1 {
                "1 echo".to_owned()
            } else {
                format!("{} echoes", tally.echo)
            },
            tally.no_object,
            tally.too_near,
            tally.missing
        );
        for note in &recording.notes {
            text += &format!("{note}\n");
        }
        if recording.backward_steps > 0 {
            let steps = counted(recording.backward_steps, "backward step");
            text += &format!("{steps} of the clock\n");
        }
        if recording.skipped.total() > 0 {
            let reason = |count: SkipCount| {
                let SkipCount {
                    reason,
                    lines,
                    first_line,
                } = count;
                format!("{lines} x {reason}, first in line {first_line}")
            };
            let reasons: Vec<String> = recording.skipped.counts().map(reason).collect();
            let lines = counted(recording.skipped.total(), "line");
            text += &format!("{lines} skipped: {}", reasons.join("; "));
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
            self.cells_updated
        );
        let mut rows = vec![[row(["sensor", "readings"]), row(HealthReport::COLUMNS)].concat()];
        rows.extend(sensors(mapper, recording).into_iter().map(|sensor| {
            let mut cells = vec![sensor.id.to_string(), sensor.readings.to_string()];
            cells.extend(sensor.health.cells());
            cells
        }));
        text += &table(&rows);
        text += caveat([arguments.fusion]);
        text.push('\n');
        for file in &self.files {
            text += &format!("{}\n", display_path(file));
        }
        text
    }
}

fn sensors(mapper: &HostMapper, recording: &Recording) -> Vec<SensorReport> {
    let known = mapper.health().into_iter();
    let report = known.map(|(id, health)| SensorReport {
        // As many names as the mapper has sensors.
        id: recording.names.get(id.slot()).copied().unwrap_or_default(),
        readings: health.readings(),
        health: HealthReport::from(&health),
    });
    report.collect()
}
