//! `certainty recovery`: a sensor's confidence in and after a fault, \[001\] Fig. 7.

use super::options::{CommonOptions, named};
use super::output::Failure;
use super::output::{self, Report, progress};
use super::table::{percent, table};
use certainty_repro::Spread;
use certainty_repro::recovery::{
    ConfidenceBand, ConfidenceTrace, Count, FAULTY, Noise, OverSeeds, READINGS, Recovery,
};
use certainty_sim::export::{ExportError, OutDir, display_path};
use certainty_sim::fault::FaultSpec;
use certainty_sim::fusion::Rules;
use certainty_sim::plot::{Axis, Line, LineChart, Span};
use certainty_sim::quantity::share;
use certainty_sim::transducer::SensorSet;
use certainty_sim::world::{Layout, World};
use clap::Args;
use serde::Serialize;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The options of `certainty recovery`.
#[derive(Debug, Args)]
#[command(
    mut_arg("seed", |seed| seed
        .help("Seed of the run in the built-in scene, and of the first of the random layouts")),
    mut_arg("out", |out| out.help("Folder for the confidences, as a table in CSV and as charts"))
)]
pub(super) struct Arguments {
    /// Number of runs, each in a random layout of its own
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    seeds: u32,
    /// Readings that are counted to 50 and 200: each sensor's own, or those of all together
    #[arg(long, value_name = "COUNT", default_value = "each", value_parser = named(Count::ALL, Count::name))]
    count: Count,
    /// Signal that sensor 1's noise is added to: its output, of which 'no object' is the farthest, or its
    /// echoes alone
    #[arg(long, value_name = "NOISE", default_value = "output", value_parser = named(Noise::ALL, Noise::name))]
    noise: Noise,
    /// Sensors, letters A to E of [001] Table 1, at least three; the first is sensor 1
    #[arg(long, value_name = "LETTERS|N", default_value = "ABC", value_parser = at_least_three)]
    sensors: SensorSet,
    /// Rules of the robust method: the defaults, or [001] to the letter
    #[arg(long, value_name = "RULES", default_value = "shipped", value_parser = named(Rules::ALL, Rules::name))]
    rules: Rules,
    #[command(flatten)]
    common: CommonOptions,
}

/// Parses a set of sensors in which one can be below the others.
fn at_least_three(text: &str) -> Result<SensorSet, String> {
    let sensors: SensorSet = text.parse().map_err(|error| format!("{error}"))?;
    if sensors.members().len() < 3 {
        return Err(format!(
            "'{text}' has too few sensors: expected three or more, such as ABC"
        ));
    }
    Ok(sensors)
}

/// One run in the built-in scene, and many in random ones with their controls without the fault.
struct Evaluation<'a> {
    arguments: &'a Arguments,
    fault: FaultSpec,
    one: ConfidenceTrace,
    traces: Vec<ConfidenceTrace>,
    controls: Vec<ConfidenceTrace>,
    over_seeds: OverSeeds,
    files: Vec<PathBuf>,
}

/// Runs the evaluation and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    arguments.common.output.check()?;
    let out = arguments.common.output.create()?;
    let mut evaluation = evaluate(arguments)?;
    let written = out.write("recovery.csv", |file| write_csv(&evaluation.one, file));
    evaluation.files = vec![written.map_err(|error| Failure::input(&error))?];
    let drawn = draw(&evaluation, &out).map_err(|error| Failure::input(&error))?;
    evaluation.files.extend(drawn);
    out.finish().map_err(|error| Failure::input(&error))?;
    arguments.common.output.print(&evaluation)
}

fn evaluate(arguments: &Arguments) -> Result<Evaluation<'_>, Failure> {
    let first = arguments.common.seed;
    let internal = |error: &dyn core::error::Error| Failure::Internal(error.to_string());
    let recovery = Recovery {
        count: arguments.count,
        noise: arguments.noise,
        sensors: arguments.sensors.clone(),
        fusion: arguments.rules.fusion(),
    };
    let one = recovery.trace(Arc::new(World::built_in()), first);
    let one = one.map_err(|error| internal(&error))?;
    let bar = progress("recovery", arguments.seeds.into());
    let (mut traces, mut controls) = (Vec::new(), Vec::new());
    for number in 0..u64::from(arguments.seeds) {
        let seed = first.wrapping_add(number);
        let world = World::random(&Layout::default(), seed).map_err(|error| internal(&error))?;
        let world = Arc::new(world);
        let trace = recovery.trace(Arc::clone(&world), seed);
        traces.push(trace.map_err(|error| internal(&error))?);
        let control = recovery.control(world, seed);
        controls.push(control.map_err(|error| internal(&error))?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(Evaluation {
        arguments,
        fault: recovery.fault().map_err(|error| internal(&error))?,
        one,
        over_seeds: OverSeeds::of(&traces, &controls),
        traces,
        controls,
        files: Vec::new(),
    })
}

/// Draws the one run, and the statistics of the many.
fn draw(evaluation: &Evaluation<'_>, out: &OutDir) -> Result<Vec<PathBuf>, ExportError> {
    let arguments = evaluation.arguments;
    let Arguments { sensors, noise, .. } = arguments;
    let points = |values: &[f64]| (1..).map(f64::from).zip(values.iter().copied()).collect();
    let name = |slot: usize| {
        let member = sensors.members().get(slot);
        let letter = member.map_or_else(String::new, |member| format!(" ({})", member.letter));
        format!("sensor {}{letter}", slot + 1)
    };
    let own = evaluation.one.confidences().iter().enumerate();
    let own = own.map(|(slot, own)| {
        let shares: Vec<f64> = own.iter().copied().map(share).collect();
        Line::new(&name(slot), points(&shares))
    });
    let bands = (0..sensors.members().len()).map(|slot| {
        let band = ConfidenceBand::of(&evaluation.traces, slot);
        Line::new(&name(slot), points(&band.mean)).with_band(band.band)
    });
    let control = ConfidenceBand::of(&evaluation.controls, 0);
    let control = Line::new("sensor 1, no fault", points(&control.mean)).dashed();
    let fault = match noise {
        Noise::Output => "20 % noise on the output of sensor 1",
        Noise::Echo => "20 % noise on the echoes of sensor 1",
    };
    let chart = |title: String, lines: Vec<Line>| LineChart {
        title,
        x: Axis::counting(match arguments.count {
            Count::Each => "readings of each sensor",
            Count::All => "readings of all sensors",
        })
        .from(0.0)
        .to(READINGS as f64),
        // Most lines are at full confidence: the fault's label is above them.
        y: Axis::counting("confidence").from(0.0).to(1.1),
        lines,
        shaded: vec![Span {
            from: 0.0,
            to: FAULTY as f64,
            label: "fault of sensor 1".into(),
        }],
    };
    let one = chart(
        format!("Confidences in and after a fault: {fault}"),
        own.collect(),
    );
    let seeds = evaluation.over_seeds.seeds;
    let many = chart(
        format!("{fault}: mean and 10–90 % of {seeds} layouts"),
        bands.chain([control]).collect(),
    );
    let mut files = Vec::from(one.write(out, "recovery")?);
    files.extend(many.write(out, "recovery-seeds")?);
    Ok(files)
}

/// Writes a line per reading, counted from 1, and a column per sensor.
fn write_csv(trace: &ConfidenceTrace, out: &mut dyn Write) -> io::Result<()> {
    write!(out, "reading")?;
    for number in 1..=trace.confidences().len() {
        write!(out, ",sensor_{number}")?;
    }
    writeln!(out)?;
    for at in 0..READINGS {
        write!(out, "{}", at + 1)?;
        for own in trace.confidences() {
            write!(out, ",{:.5}", share(own[at]))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// The report as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct Document<'a> {
    seed: u64,
    count: &'static str,
    sensors: String,
    rules: &'static str,
    readings: usize,
    fault: FaultReport,
    confidence: Vec<Vec<f64>>,
    recovered_after: Option<usize>,
    over_seeds: &'a OverSeeds,
    files: Vec<String>,
}

/// The fault; `from` and `to` count readings by `count`, `spec` the sensor's own.
#[derive(Debug, Serialize)]
struct FaultReport {
    sensor: u8,
    kind: &'static str,
    from: usize,
    to: usize,
    spec: String,
}

impl Report for Evaluation<'_> {
    fn document(&self) -> impl Serialize {
        let Self {
            arguments,
            fault,
            one,
            over_seeds,
            ..
        } = self;
        let shares = |own: &Vec<_>| own.iter().copied().map(share).collect();
        Document {
            seed: arguments.common.seed,
            count: arguments.count.name(),
            sensors: arguments.sensors.to_string(),
            rules: arguments.rules.name(),
            readings: READINGS,
            fault: FaultReport {
                sensor: 1,
                kind: fault.fault.defect.kind(),
                from: 0,
                to: FAULTY,
                spec: fault.to_string(),
            },
            confidence: one.confidences().iter().map(shares).collect(),
            recovered_after: one.recovered_after(),
            over_seeds,
            files: output::listed(&self.files),
        }
    }

    fn render(&self) -> String {
        /// Readings from one line of the table to the next.
        const STRIDE: usize = 10;
        /// More sensors would make the table wider than a terminal; the files have them all.
        const MOST_COLUMNS: usize = 5;
        let Self {
            arguments,
            fault,
            one,
            over_seeds,
            ..
        } = self;
        let counted = match arguments.count {
            Count::Each => "of each sensor",
            Count::All => "of all sensors together",
        };
        let CommonOptions { seed, output } = &arguments.common;
        let mut text = format!(
            "sensors: {}   readings: {READINGS} {counted}   seed: {seed}\n\
         fault: {fault}   rules: {}\n\n",
            arguments.sensors,
            arguments.rules.name()
        );
        let columns = || one.confidences().iter().take(MOST_COLUMNS);
        let mut heading = vec!["reading".to_owned()];
        heading.extend(
            (1..)
                .zip(columns())
                .map(|(number, _)| format!("sensor {number}")),
        );
        heading.push("sensor 1 is".into());
        let mut rows = vec![heading];
        for at in (STRIDE..=READINGS).step_by(STRIDE) {
            let mut cells = vec![at.to_string()];
            cells.extend(columns().map(|own| format!("{:.2}", share(own[at - 1]))));
            cells.push(if at <= FAULTY { "faulty" } else { "sound" }.into());
            rows.push(cells);
        }
        text += &table(&rows);
        text += &format!(
            "\nwithin 5 % of the others {}\n\n",
            time_of(one.recovered_after())
        );
        text += &summary(over_seeds);
        text += &format!(
            "\nevery reading's confidences in {}\ncharts: {}, {}\n",
            path(&output.out, "recovery.csv"),
            path(&output.out, "recovery.png"),
            path(&output.out, "recovery-seeds.png"),
        );
        text
    }
}

/// Renders the statistics over the random layouts.
fn summary(over: &OverSeeds) -> String {
    let readings = |value: Option<u64>| value.map_or("never".into(), |n| n.to_string());
    let spread = |Spread { mean, sd }: Spread| format!("{mean:.2} ± {sd:.2}");
    let rows = [
        vec![format!("{} random layouts", over.seeds), String::new()],
        vec![
            "lowest confidence of sensor 1 in the fault".into(),
            spread(over.lowest_confidence),
        ],
        vec![
            "below the mean of the others at its end".into(),
            spread(over.below_others),
        ],
        vec![
            "clearly below every other at its end".into(),
            percent(over.clearly_below),
        ],
        vec![
            "the same without the fault".into(),
            percent(over.clearly_below_without_fault),
        ],
        vec!["recovered".into(), over.recovered.to_string()],
        vec![
            "after readings: 10 % / median / 90 %".into(),
            [over.p10, over.median, over.p90].map(readings).join(" / "),
        ],
        vec![
            "median of those clearly below".into(),
            if over.clearly_below > 0.0 {
                readings(over.median_of_clearly_below)
            } else {
                "-".into()
            },
        ],
    ];
    let mut text = table(&rows);
    if over.clearly_below - over.clearly_below_without_fault < 0.5 {
        text += "In most runs sensor 1 did not fall clearly in the fault: an immediate recovery\n\
                 measures little.\n";
    }
    text
}

/// Renders when a sensor recovered.
fn time_of(readings: Option<usize>) -> String {
    match readings {
        None => "never".into(),
        Some(0) => "already when the fault ended".into(),
        Some(readings) => format!("{readings} readings after the fault ended"),
    }
}

fn path(out: &Path, file: &str) -> String {
    display_path(&out.join(file))
}
