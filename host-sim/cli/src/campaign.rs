//! `certainty campaign`: every method against every fault.

use super::options::{CommonOptions, Jobs, named};
use super::output::Failure;
use super::output::{self, Report, progress};
use super::table::{percent_or_dash, row, table};
use certainty_repro::campaign::{Campaign, CampaignError, Row, Selection};
use certainty_repro::{Waits, standard_deviation};
use certainty_sim::export::{ExportError, OutDir, display_path};
use certainty_sim::fusion::{FusionRules, Rules};
use certainty_sim::plot::{Axis, BarChart, BarSeries};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The options of `certainty campaign`.
#[derive(Debug, Args)]
#[command(
    mut_arg("seed", |seed| seed.help("Seed of the first world; the others follow it")),
    mut_arg("json", |json| json.conflicts_with("csv")),
    mut_arg("out", |out| out
        .help("Folder for the charts of the summary")
        .conflicts_with_all(["json", "csv"]))
)]
pub(super) struct Arguments {
    /// TOML file that selects a part of the scenarios; without it, all of them
    #[arg(long, value_name = "FILE")]
    scenarios: Option<PathBuf>,
    /// Number of worlds of every scenario
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    seeds: u64,
    /// Rules of the robust method
    #[arg(long, value_name = "RULES", default_value = "shipped", value_parser = named(Rules::ALL, Rules::name))]
    rules: Rules,
    /// Certainties that the trimmed method drops at each end [default: half of the other sensors]
    #[arg(long, value_name = "N")]
    trim: Option<u8>,
    #[command(flatten)]
    jobs: Jobs,
    /// Append every row to this file, after the scenarios that it has
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    common: CommonOptions,
}

/// Runs the campaign and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let selection = match &arguments.scenarios {
        Some(file) => Selection::load(file).map_err(|error| Failure::input(&error))?,
        None => Selection::default(),
    };
    let rules = FusionRules {
        trim: arguments.trim,
        ..arguments.rules.fusion()
    };
    let campaign = Campaign::new(selection, arguments.common.seed, arguments.seeds, rules);
    arguments.jobs.run(|| match &arguments.csv {
        Some(path) => append(&campaign, path),
        None => print(&campaign, arguments),
    })?
}

/// Appends the missing scenarios to the file.
fn append(campaign: &Campaign, path: &Path) -> Result<(), Failure> {
    let mut journal = campaign
        .journal(path)
        .map_err(|error| Failure::input(&error))?;
    let (all, before) = (campaign.scenarios().len(), journal.finished());
    if journal.dropped() > 0 {
        output::note(&format!(
            "{}: unfinished; continued after {before} complete scenarios",
            display_path(path)
        ));
    }
    let bar = progress("scenarios", all as u64);
    bar.set_position(before as u64);
    bar.reset_eta();
    campaign
        .run_into(&mut journal, || bar.inc(1))
        .map_err(failure)?;
    bar.finish_and_clear();
    output::print(&format!(
        "{}: {all} scenarios, {} of them new\n",
        display_path(path),
        all - before
    ))
}

/// Runs every scenario and prints the rows, or draws and prints their summary.
fn print(campaign: &Campaign, arguments: &Arguments) -> Result<(), Failure> {
    let output = &arguments.common.output;
    let out = (!output.is_json()).then(|| output.create()).transpose()?;
    let scenarios = campaign.scenarios().len();
    let bar = progress("scenarios", scenarios as u64);
    let mut rows = Vec::new();
    campaign
        .run(0, |more| {
            rows.extend(more);
            bar.inc(1);
            Ok(())
        })
        .map_err(failure)?;
    bar.finish_and_clear();
    let summary = Summary::of(arguments, scenarios, &rows);
    if let Some(out) = out {
        let drawn = summary.draw(&out).and_then(|()| out.finish());
        drawn.map_err(|error| Failure::input(&error))?;
    }
    output.print(&summary)
}

/// The report as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct Document<'a> {
    seed: u64,
    seeds: u64,
    rules: &'static str,
    scenarios: usize,
    rows: &'a [Row],
}

/// The rows, and their means over all scenarios of a fault.
struct Summary<'a> {
    arguments: &'a Arguments,
    scenarios: usize,
    faults: Vec<&'a str>,
    methods: Vec<&'a str>,
    rows: &'a [Row],
}

impl<'a> Summary<'a> {
    fn of(arguments: &'a Arguments, scenarios: usize, rows: &'a [Row]) -> Self {
        let mut faults: Vec<&str> = rows.iter().map(|row| row.fault.as_str()).collect();
        faults.dedup();
        let mut methods: Vec<&str> = Vec::new();
        for row in rows {
            if !methods.contains(&row.method) {
                methods.push(row.method);
            }
        }
        Self {
            arguments,
            scenarios,
            faults,
            methods,
            rows,
        }
    }

    /// The rows of a fault and a method.
    fn rows_of(&self, fault: &str, method: &str) -> Vec<&'a Row> {
        let of_both = |row: &&Row| row.fault == fault && row.method == method;
        self.rows.iter().filter(of_both).collect()
    }

    /// Draws the missed obstacles and the ghosts of every method by fault.
    fn draw(&self, out: &OutDir) -> Result<(), ExportError> {
        let chart = |title: &str, what: &str, part: fn(&Row) -> Option<f64>| BarChart {
            title: title.to_owned(),
            y: Axis::new(what, "%").from(0.0),
            groups: self.faults.iter().map(|&fault| fault.to_owned()).collect(),
            bars: self
                .methods
                .iter()
                .map(|&method| self.bars(method, part))
                .collect(),
        };
        chart(
            "Obstacles missed, by fault",
            "obstacle cells missed",
            |row| Some(row.missed),
        )
        .write(out, "campaign-missed")?;
        chart("Ghosts, by fault", "free cells shown occupied", |row| {
            Some(row.ghost)
        })
        .write(out, "campaign-ghosts")?;
        Ok(())
    }

    /// One method's bars, in percent, with the spread over the scenarios of each fault.
    fn bars(&self, method: &str, part: fn(&Row) -> Option<f64>) -> BarSeries {
        let samples = self.faults.iter().map(|fault| {
            let rows = self.rows_of(fault, method);
            rows.into_iter()
                .filter_map(part)
                .map(|share| share * 100.0)
                .collect::<Vec<_>>()
        });
        let samples: Vec<Vec<f64>> = samples.collect();
        let means = samples.iter().map(|samples| certainty_repro::mean(samples));
        BarSeries {
            name: method.to_owned(),
            values: means.collect(),
            errors: Some(
                samples
                    .iter()
                    .map(|samples| standard_deviation(samples).unwrap_or(f64::NAN))
                    .collect(),
            ),
        }
    }

    /// Renders both tables.
    fn tables(&self) -> String {
        let mut maps = vec![row([
            "fault",
            "method",
            "MAE",
            "MSE",
            "missed",
            "ghost",
            "MAE - oracle's",
        ])];
        let mut health = vec![row([
            "fault",
            "rate",
            "suspect",
            "after",
            "failed",
            "after",
            "false suspect",
            "false failed",
            "recovered",
            "after",
        ])];
        for &fault in &self.faults {
            for &method in &self.methods {
                let rows = self.rows_of(fault, method);
                let mean = |part: fn(&Row) -> Option<f64>| mean(&rows, part);
                let error = |part: fn(&Row) -> Option<f64>| decimals(mean(part));
                let share = |part: fn(&Row) -> Option<f64>| percent_or_dash(mean(part));
                maps.push(vec![
                    fault.to_owned(),
                    method.to_owned(),
                    error(|row| Some(row.mae)),
                    error(|row| Some(row.mse)),
                    share(|row| Some(row.missed)),
                    share(|row| Some(row.ghost)),
                    error(|row| Some(row.mae_to_oracle)),
                ]);
            }
            health.extend(self.health_of(fault));
        }
        let mut text = format!(
            "{} scenarios, {} worlds each from seed {}, {} rules; means over the scenarios\n\n",
            self.scenarios,
            self.arguments.seeds,
            self.arguments.common.seed,
            self.arguments.rules.name()
        );
        text += &table(&maps);
        if health.len() > 1 {
            text += "\nHealth by the robust method: shares of the faulty, the sound and the recovering sensors;\n\
                     after: turns of the sensor (median of the scenarios' medians)\n\n";
            text += &table(&health);
        }
        text += &format!(
            "\ncharts in {}: campaign-missed.png and campaign-ghosts.png, also as SVG; whiskers: the spread \
             over scenarios\n",
            display_path(&self.arguments.common.output.out)
        );
        text
    }
}

impl Report for Summary<'_> {
    fn document(&self) -> impl Serialize {
        Document {
            seed: self.arguments.common.seed,
            seeds: self.arguments.seeds,
            rules: self.arguments.rules.name(),
            scenarios: self.scenarios,
            rows: self.rows,
        }
    }

    fn render(&self) -> String {
        self.tables()
    }
}

impl Summary<'_> {
    /// Returns the rows of a fault in the table of health: one for each rate, which sets the length of a turn.
    fn health_of(&self, fault: &str) -> Vec<Vec<String>> {
        let all = self.rows_of(fault, "robust");
        let mut rates: Vec<u32> = all.iter().map(|row| row.rate).collect();
        rates.dedup();
        let of_rate = rates.into_iter().map(|rate| {
            let rows: Vec<&Row> = all.iter().filter(|row| row.rate == rate).copied().collect();
            let share = |part: fn(&Row) -> Option<f64>| percent_or_dash(mean(&rows, part));
            let turns = |part: fn(&Row) -> Option<u64>| median(&rows, part);
            vec![
                fault.to_owned(),
                rate.to_string(),
                share(|row| row.suspect),
                turns(|row| row.suspect_after),
                share(|row| row.failed),
                turns(|row| row.failed_after),
                share(|row| row.false_suspect),
                share(|row| row.false_failed),
                share(|row| row.recovered),
                turns(|row| row.recovered_after),
            ]
        });
        of_rate.collect()
    }
}

/// Returns the mean of the rows that have the value.
fn mean(rows: &[&Row], part: fn(&Row) -> Option<f64>) -> Option<f64> {
    let known: Vec<f64> = rows.iter().filter_map(|row| part(row)).collect();
    certainty_repro::mean(&known)
}

/// Returns the median over the rows; those without the value count as longest.
fn median(rows: &[&Row], part: fn(&Row) -> Option<u64>) -> String {
    let waits: Waits = rows.iter().map(|row| part(row)).collect();
    waits.median().map_or("-".into(), |turns| turns.to_string())
}

fn decimals(number: Option<f64>) -> String {
    number.map_or("-".into(), |number| format!("{number:.3}"))
}

fn failure(error: CampaignError) -> Failure {
    match error {
        CampaignError::Trial(error) => Failure::Internal(error.to_string()),
        CampaignError::Journal(error) => Failure::input(&error),
    }
}
