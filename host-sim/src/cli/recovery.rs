//! `certainty recovery`: a sensor's confidence falls in a fault and comes back, \[001\] Fig. 7.

use super::simulate::percent;
use super::table::{row, table};
use super::{Failure, output, progress};
use crate::experiment::recovery::{
    ConfidenceTrace, Count, FAULTY, OverSeeds, READINGS, Recovery, Spread, share,
};
use crate::export::OutDir;
use crate::fault::FaultSpec;
use crate::fusion::FusionRules;
use crate::world::{Layout, World};
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
    /// Where the confidences go, as a table in CSV
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Print one JSON document instead
    #[arg(long)]
    json: bool,
}

/// One run in the built-in scene, and many in random ones.
#[derive(Debug)]
struct Evaluated {
    fault: FaultSpec,
    one: ConfidenceTrace,
    over_seeds: OverSeeds,
}

/// Runs the evaluation and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    output::check_listable(arguments.json, &arguments.out)?;
    let evaluated = evaluate(arguments)?;
    let out = OutDir::create(&arguments.out).map_err(|error| Failure::input(&error))?;
    let written = out.write("recovery.csv", |file| write_csv(&evaluated.one, file));
    let files = [written.map_err(|error| Failure::input(&error))?];
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
        fusion: FusionRules::default(),
    };
    let trace = |world: World, seed: u64| {
        let trace = recovery.trace(Arc::new(world), seed);
        trace.map_err(|error| internal(&error))
    };
    let one = trace(World::built_in(), arguments.seed)?;
    let bar = progress::bar("recovery", arguments.seeds.into());
    let mut traces = Vec::new();
    for number in 0..u64::from(arguments.seeds) {
        let seed = arguments.seed.wrapping_add(number);
        let world = World::random(&Layout::default(), seed).map_err(|error| internal(&error))?;
        traces.push(trace(world, seed)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(Evaluated {
        fault: recovery.fault().map_err(|error| internal(&error))?,
        one,
        over_seeds: OverSeeds::of(&traces),
    })
}

/// Writes a line a reading, counted from 1, and a column a sensor.
fn write_csv(trace: &ConfidenceTrace, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "reading,sensor_1,sensor_2,sensor_3")?;
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
        } = evaluated;
        let shares = |own: &Vec<_>| own.iter().copied().map(share).collect();
        Self {
            seed: arguments.seed,
            count: arguments.count.name(),
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
    let Evaluated {
        fault,
        one,
        over_seeds,
    } = evaluated;
    let whose = match arguments.count {
        Count::Each => "of each sensor",
        Count::All => "of all sensors together",
    };
    let mut text = format!(
        "sensors: ABC   readings: {READINGS} {whose}   seed: {}\nfault: {fault}\n\n",
        arguments.seed
    );
    let mut rows = vec![row([
        "reading",
        "sensor 1",
        "sensor 2",
        "sensor 3",
        "sensor 1 is",
    ])];
    for at in (STRIDE..=READINGS).step_by(STRIDE) {
        let mut cells = vec![at.to_string()];
        let confidences = one.confidences().iter();
        cells.extend(confidences.map(|own| format!("{:.2}", share(own[at - 1]))));
        cells.push(if at <= FAULTY { "faulty" } else { "sound" }.into());
        rows.push(cells);
    }
    text += &table(&rows);
    text += &format!(
        "\nback within 5 % of the others {}\n\n",
        after(one.recovered_after())
    );
    text += &summary(over_seeds);
    text += &format!("\nevery reading's confidences in {}\n", csv(&arguments.out));
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
            "clearly below both others at its end".into(),
            percent(over.clearly_below),
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
    if over.clearly_below < 0.5 {
        text += "In most runs sensor 1 did not fall clearly: being back at once means little.\n";
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

fn csv(out: &Path) -> String {
    out.join("recovery.csv").display().to_string()
}
