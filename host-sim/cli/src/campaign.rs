//! `certainty campaign`: every method against every fault.

use super::jobs::Jobs;
use super::simulate::percent;
use super::table::{row, table};
use super::{Failure, output, progress};
use certainty_repro::campaign::{Campaign, CampaignError, Row, Selection};
use certainty_repro::{Estimate, Waits, standard_deviation};
use certainty_sim::export::{ExportError, OutDir, shown};
use certainty_sim::fusion::Rules;
use certainty_sim::plot::{Axis, BarChart, BarSeries};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// What the campaign is asked.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Which scenarios: a TOML file that selects a part; without it, all of them
    #[arg(long, value_name = "FILE")]
    scenarios: Option<PathBuf>,
    /// How many worlds a scenario is run in
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    seeds: u64,
    /// The seed of the first world; the others follow it
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        allow_hyphen_values = true
    )]
    seed: u64,
    /// The numbers of the robust method
    #[arg(long, value_name = "shipped|letter|coarse", default_value = "shipped")]
    rules: Rules,
    #[command(flatten)]
    jobs: Jobs,
    /// Print one JSON document instead of a summary
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// Write every row to this file, going on where it stopped
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Where the charts of the summary go
    #[arg(
        long,
        value_name = "DIR",
        default_value = "out",
        conflicts_with_all = ["json", "csv"]
    )]
    out: PathBuf,
}

/// Runs the campaign and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let selection = match &arguments.scenarios {
        Some(file) => Selection::load(file).map_err(|error| Failure::input(&error))?,
        None => Selection::default(),
    };
    let Arguments {
        seed, seeds, rules, ..
    } = *arguments;
    let campaign = Campaign::new(selection, seed, seeds, rules.fusion());
    arguments.jobs.run(|| match &arguments.csv {
        Some(path) => into_file(&campaign, path),
        None => to_stdout(&campaign, arguments),
    })?
}

/// Writes what is missing of the file.
fn into_file(campaign: &Campaign, path: &Path) -> Result<(), Failure> {
    let mut journal = campaign
        .journal(path)
        .map_err(|error| Failure::input(&error))?;
    let (all, before) = (campaign.scenarios().len(), journal.finished());
    if journal.dropped() > 0 {
        output::note(&format!(
            "{}: left in the middle of a scenario; going on after the {before} that are whole",
            shown(path)
        ));
    }
    let bar = progress::bar("scenarios", all as u64);
    bar.set_position(before as u64);
    bar.reset_eta();
    campaign
        .run_into(&mut journal, || bar.inc(1))
        .map_err(failure)?;
    bar.finish_and_clear();
    output::print(&format!(
        "{}: {all} scenarios, {} of them new\n",
        shown(path),
        all - before
    ))
}

/// The report as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct Report {
    seed: u64,
    seeds: u64,
    rules: &'static str,
    scenarios: usize,
    rows: Vec<Row>,
}

fn to_stdout(campaign: &Campaign, arguments: &Arguments) -> Result<(), Failure> {
    let scenarios = campaign.scenarios().len();
    let bar = progress::bar("scenarios", scenarios as u64);
    let mut rows = Vec::new();
    campaign
        .run(0, |more| {
            rows.extend(more);
            bar.inc(1);
            Ok(())
        })
        .map_err(failure)?;
    bar.finish_and_clear();
    if arguments.json {
        return output::print_json(&Report {
            seed: arguments.seed,
            seeds: arguments.seeds,
            rules: arguments.rules.name(),
            scenarios,
            rows,
        });
    }
    let summary = Summary::of(&rows);
    let out = OutDir::create(&arguments.out).map_err(|error| Failure::input(&error))?;
    summary.draw(&out).map_err(|error| Failure::input(&error))?;
    output::print(&summary.told(scenarios, arguments))
}

/// The rows in short: means over all scenarios of a fault.
struct Summary<'a> {
    faults: Vec<&'a str>,
    methods: Vec<&'a str>,
    rows: &'a [Row],
}

impl<'a> Summary<'a> {
    fn of(rows: &'a [Row]) -> Self {
        let mut faults: Vec<&str> = rows.iter().map(|row| row.fault.as_str()).collect();
        faults.dedup();
        let mut methods: Vec<&str> = Vec::new();
        for row in rows {
            if !methods.contains(&row.method) {
                methods.push(row.method);
            }
        }
        Self {
            faults,
            methods,
            rows,
        }
    }

    /// The rows of a fault and a method.
    fn alike(&self, fault: &str, method: &str) -> Vec<&'a Row> {
        let of_both = |row: &&Row| row.fault == fault && row.method == method;
        self.rows.iter().filter(of_both).collect()
    }

    /// Draws what the methods miss and what they invent, fault by fault.
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
            let rows = self.alike(fault, method);
            rows.into_iter()
                .filter_map(part)
                .map(|share| share * 100.0)
                .collect::<Vec<_>>()
        });
        let samples: Vec<Vec<f64>> = samples.collect();
        let estimates = samples.iter().map(|samples| Estimate::of(samples));
        BarSeries {
            name: method.to_owned(),
            values: estimates.map(|estimate| estimate.map(|e| e.mean)).collect(),
            errors: Some(
                samples
                    .iter()
                    .map(|samples| standard_deviation(samples).unwrap_or(f64::NAN))
                    .collect(),
            ),
        }
    }

    fn told(&self, scenarios: usize, arguments: &Arguments) -> String {
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
                let alike = self.alike(fault, method);
                let mean = |part: fn(&Row) -> Option<f64>| mean(&alike, part);
                let error = |part: fn(&Row) -> Option<f64>| decimals(mean(part));
                let share = |part: fn(&Row) -> Option<f64>| mean(part).map_or("-".into(), percent);
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
            "{scenarios} scenarios, {} worlds each from seed {}, {} rules; means over the scenarios\n\n",
            arguments.seeds,
            arguments.seed,
            arguments.rules.name()
        );
        text += &table(&maps);
        if health.len() > 1 {
            text += "\nHealth by the robust method: shares of the faulty, of the sound and of the healed \
                 sensors;\nafter so many turns of the sensor (median of the scenarios' medians)\n\n";
            text += &table(&health);
        }
        text += &format!(
            "\ncharts in {}: campaign-missed.png and campaign-ghosts.png, also as SVG; whiskers: the spread \
         over scenarios\n",
            shown(&arguments.out)
        );
        text
    }
}

impl Summary<'_> {
    /// The lines of the table of health for a fault: one for each rate, since turns pass faster at a
    /// higher one.
    fn health_of(&self, fault: &str) -> Vec<Vec<String>> {
        let all = self.alike(fault, "robust");
        let mut rates: Vec<u32> = all.iter().map(|row| row.rate).collect();
        rates.dedup();
        let of_rate = rates.into_iter().map(|rate| {
            let alike: Vec<&Row> = all.iter().filter(|row| row.rate == rate).copied().collect();
            let share =
                |part: fn(&Row) -> Option<f64>| mean(&alike, part).map_or("-".into(), percent);
            let turns = |part: fn(&Row) -> Option<u64>| middle(&alike, part);
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

/// The mean of what is known.
fn mean(rows: &[&Row], part: fn(&Row) -> Option<f64>) -> Option<f64> {
    let known: Vec<f64> = rows.iter().filter_map(|row| part(row)).collect();
    (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64)
}

/// The median over rows, those where it is not known being the longest.
fn middle(rows: &[&Row], part: fn(&Row) -> Option<u64>) -> String {
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
