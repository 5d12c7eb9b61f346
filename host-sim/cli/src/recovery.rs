//! `certainty recovery`: a sensor's confidence falls in a fault and comes back, \[001\] Fig. 7.

use super::simulate::percent;
use super::table::table;
use super::{Failure, output, progress};
use certainty_repro::recovery::{
    ConfidenceTrace, Count, Course, FAULTY, Noise, OverSeeds, READINGS, Recovery, Spread, share,
};
use certainty_sim::export::{ExportError, OutDir, shown};
use certainty_sim::fault::FaultSpec;
use certainty_sim::fusion::Rules;
use certainty_sim::plot::{Axis, Line, LineChart, Span};
use certainty_sim::transducer::SensorSet;
use certainty_sim::world::{Layout, World};
use clap::Args;
use serde::Serialize;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What the evaluation is asked.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// How many runs, each in a random layout of its own
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    seeds: u32,
    /// Names the run in the built-in scene, and the first of the random layouts
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        allow_hyphen_values = true
    )]
    seed: u64,
    /// Whose readings 50 and 200 are: each sensor's own, or those of all together
    #[arg(long, value_name = "each|all", default_value = "each")]
    count: Count,
    /// What sensor 1's noise is added to: its output, of which 'no object' is the farthest, or its
    /// echoes alone
    #[arg(long, value_name = "output|echo", default_value = "output")]
    noise: Noise,
    /// The sensors, letters A to E of [001] Table 1, at least three; sensor 1 is the first
    #[arg(long, value_name = "LETTERS|N", default_value = "ABC", value_parser = at_least_three)]
    sensors: SensorSet,
    /// The open numbers of the robust method: the defaults, or [001] to the letter
    #[arg(long, value_name = "shipped|letter|coarse", default_value = "shipped")]
    rules: Rules,
    /// Where the confidences go, as a table in CSV and as charts
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Print one JSON document instead
    #[arg(long)]
    json: bool,
}

/// Reads a crew in which a sensor can be below others.
fn at_least_three(text: &str) -> Result<SensorSet, String> {
    let crew: SensorSet = text.parse().map_err(|error| format!("{error}"))?;
    if crew.members().len() < 3 {
        return Err(format!(
            "'{text}' are too few: write three or more, such as ABC"
        ));
    }
    Ok(crew)
}

/// One run in the built-in scene, and many in random ones with their twins without the fault.
#[derive(Debug)]
struct Evaluated {
    fault: FaultSpec,
    one: ConfidenceTrace,
    traces: Vec<ConfidenceTrace>,
    twins: Vec<ConfidenceTrace>,
    over_seeds: OverSeeds,
}

/// Runs the evaluation and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    output::check_listable(arguments.json, &arguments.out)?;
    let evaluated = evaluate(arguments)?;
    let out = OutDir::create(&arguments.out).map_err(|error| Failure::input(&error))?;
    let written = out.write("recovery.csv", |file| write_csv(&evaluated.one, file));
    let mut files = vec![written.map_err(|error| Failure::input(&error))?];
    let drawn = draw(arguments, &evaluated, &out);
    files.extend(drawn.map_err(|error| Failure::input(&error))?);
    if arguments.json {
        output::print_json(&Report::new(arguments, &evaluated, &files))
    } else {
        output::print(&told(arguments, &evaluated))
    }
}

fn evaluate(arguments: &Arguments) -> Result<Evaluated, Failure> {
    let internal = |error: &dyn core::error::Error| Failure::Internal(error.to_string());
    let recovery = Recovery {
        count: arguments.count,
        noise: arguments.noise,
        crew: arguments.sensors.clone(),
        fusion: arguments.rules.fusion(),
    };
    let one = recovery.trace(Arc::new(World::built_in()), arguments.seed);
    let one = one.map_err(|error| internal(&error))?;
    let bar = progress::bar("recovery", arguments.seeds.into());
    let (mut traces, mut twins) = (Vec::new(), Vec::new());
    for number in 0..u64::from(arguments.seeds) {
        let seed = arguments.seed.wrapping_add(number);
        let world = World::random(&Layout::default(), seed).map_err(|error| internal(&error))?;
        let world = Arc::new(world);
        let trace = recovery.trace(Arc::clone(&world), seed);
        traces.push(trace.map_err(|error| internal(&error))?);
        let twin = recovery.twin(world, seed);
        twins.push(twin.map_err(|error| internal(&error))?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(Evaluated {
        fault: recovery.fault().map_err(|error| internal(&error))?,
        one,
        over_seeds: OverSeeds::of(&traces, &twins),
        traces,
        twins,
    })
}

/// Draws the one run, and what the many have in common.
fn draw(
    arguments: &Arguments,
    evaluated: &Evaluated,
    out: &OutDir,
) -> Result<Vec<PathBuf>, ExportError> {
    let Arguments { sensors, noise, .. } = arguments;
    let points = |values: &[f64]| (1..).map(f64::from).zip(values.iter().copied()).collect();
    let named = |slot: usize| {
        let member = sensors.members().get(slot);
        let letter = member.map_or_else(String::new, |member| format!(" ({})", member.letter));
        format!("sensor {}{letter}", slot + 1)
    };
    let own = evaluated.one.confidences().iter().enumerate();
    let own = own.map(|(slot, own)| {
        let shares: Vec<f64> = own.iter().copied().map(share).collect();
        Line::new(&named(slot), points(&shares))
    });
    let courses = (0..sensors.members().len()).map(|slot| {
        let course = Course::of(&evaluated.traces, slot);
        Line::new(&named(slot), points(&course.mean)).with_band(course.band)
    });
    let twin = Course::of(&evaluated.twins, 0);
    let twin = Line::new("sensor 1, no fault", points(&twin.mean)).dashed();
    let whose = match noise {
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
        // Full confidence is where most of the lines are: room above them for the fault's label.
        y: Axis::counting("confidence").from(0.0).to(1.1),
        lines,
        shaded: vec![Span {
            from: 0.0,
            to: FAULTY as f64,
            label: "fault of sensor 1".into(),
        }],
    };
    let one = chart(
        format!("Confidences in and after a fault: {whose}"),
        own.collect(),
    );
    let seeds = evaluated.over_seeds.seeds;
    let many = chart(
        format!("{whose}: mean and 10–90 % of {seeds} layouts"),
        courses.chain([twin]).collect(),
    );
    let mut files = Vec::from(one.write(out, "recovery")?);
    files.extend(many.write(out, "recovery-seeds")?);
    Ok(files)
}

/// Writes a line a reading, counted from 1, and a column a sensor.
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
struct Report<'a> {
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

/// The fault; `from` and `to` count as `readings` does, `spec` the sensor's own.
#[derive(Debug, Serialize)]
struct FaultReport {
    sensor: u8,
    kind: &'static str,
    from: usize,
    to: usize,
    spec: String,
}

impl<'a> Report<'a> {
    fn new(arguments: &Arguments, evaluated: &'a Evaluated, files: &[PathBuf]) -> Self {
        let Evaluated {
            fault,
            one,
            over_seeds,
            ..
        } = evaluated;
        let shares = |own: &Vec<_>| own.iter().copied().map(share).collect();
        Self {
            seed: arguments.seed,
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
            files: output::listed(files),
        }
    }
}

/// The report for people.
fn told(arguments: &Arguments, evaluated: &Evaluated) -> String {
    /// Readings from one line of the table to the next.
    const STRIDE: usize = 10;
    /// More sensors would make the table wider than a terminal; the files have them all.
    const MOST_COLUMNS: usize = 5;
    let Evaluated {
        fault,
        one,
        over_seeds,
        ..
    } = evaluated;
    let whose = match arguments.count {
        Count::Each => "of each sensor",
        Count::All => "of all sensors together",
    };
    let Arguments { sensors, seed, .. } = arguments;
    let mut text = format!(
        "sensors: {sensors}   readings: {READINGS} {whose}   seed: {seed}\n\
         fault: {fault}   rules: {}\n\n",
        arguments.rules.name()
    );
    let shown = || one.confidences().iter().take(MOST_COLUMNS);
    let mut heading = vec!["reading".to_owned()];
    heading.extend(
        (1..)
            .zip(shown())
            .map(|(number, _)| format!("sensor {number}")),
    );
    heading.push("sensor 1 is".into());
    let mut rows = vec![heading];
    for at in (STRIDE..=READINGS).step_by(STRIDE) {
        let mut cells = vec![at.to_string()];
        cells.extend(shown().map(|own| format!("{:.2}", share(own[at - 1]))));
        cells.push(if at <= FAULTY { "faulty" } else { "sound" }.into());
        rows.push(cells);
    }
    text += &table(&rows);
    text += &format!(
        "\nback within 5 % of the others {}\n\n",
        after(one.recovered_after())
    );
    text += &summary(over_seeds);
    text += &format!(
        "\nevery reading's confidences in {}\ncharts: {}, {}\n",
        within(&arguments.out, "recovery.csv"),
        within(&arguments.out, "recovery.png"),
        within(&arguments.out, "recovery-seeds.png"),
    );
    text
}

/// What the random layouts have in common.
fn summary(over: &OverSeeds) -> String {
    let readings = |value: Option<usize>| value.map_or("never".into(), |n: usize| n.to_string());
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
            "after so many readings: 10 % / median / 90 %".into(),
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
        text += "In most runs the fault did not make sensor 1 fall clearly: being back at once\n\
                 means little.\n";
    }
    text
}

/// When a sensor recovered, in words.
fn after(readings: Option<usize>) -> String {
    match readings {
        None => "never".into(),
        Some(0) => "already when the fault ended".into(),
        Some(readings) => format!("{readings} readings after the fault ended"),
    }
}

fn within(out: &Path, file: &str) -> String {
    shown(&out.join(file))
}
