//! `certainty table2`: the evaluation of \[001\] §6.2, and the factors that decide it.

use super::options::{CommonOptions, Jobs};
use super::output::Failure;
use super::output::{self, Report, progress};
use super::table::{percent, row, table};
use certainty_repro::table2::{
    Estimator, EstimatorFigures, Evaluation, EvaluationSetup, Figures, PRINTED_METHODS, Variation,
    variations, variations_steps,
};
use certainty_sim::export::OutDir;
use certainty_sim::plot::{Axis, BarChart, BarSeries};
use certainty_sim::simulation::Score;
use clap::Args;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// The options of `certainty table2`.
#[derive(Debug, Args)]
#[command(mut_arg("out", |out| out
    .help("Folder for every world's figures, table2.csv, and the chart of their means")))]
pub(super) struct Arguments {
    /// Number of repetitions of the paper's whole evaluation, each in other worlds
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    worlds: u32,
    /// Also change every factor that the text leaves open, one at a time (about half a minute)
    #[arg(long)]
    sensitivity: bool,
    #[command(flatten)]
    jobs: Jobs,
    #[command(flatten)]
    common: CommonOptions,
}

/// Most worlds of each changed set-up; fewer by `--worlds`.
const VARIED_WORLDS: u32 = 100;
/// The evaluation, its variations, and the files.
struct Outcome<'a> {
    arguments: &'a Arguments,
    evaluation: Evaluation,
    sensitivity: Option<Sensitivity>,
    files: Vec<PathBuf>,
}

/// The variations of the primary set-up.
struct Sensitivity {
    worlds: u32,
    variations: Vec<Variation>,
}

/// Runs the evaluation and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    arguments.common.output.check()?;
    // Before the evaluation, which takes a while.
    let out = arguments.common.output.create()?;
    let (evaluation, sensitivity) = arguments.jobs.run(|| {
        let evaluation = evaluate(arguments);
        let sensitivity = arguments.sensitivity.then(|| vary(arguments));
        (evaluation, sensitivity)
    })?;
    let files = write(&evaluation, &out)?;
    out.finish().map_err(|error| Failure::input(&error))?;
    arguments.common.output.print(&Outcome {
        arguments,
        evaluation,
        sensitivity,
        files,
    })
}

/// Evaluates the primary set-up in all worlds.
fn evaluate(arguments: &Arguments) -> Evaluation {
    let bar = progress("worlds", arguments.worlds.into());
    let (seed, worlds) = (arguments.common.seed, arguments.worlds);
    let evaluation = Evaluation::run(EvaluationSetup::PRIMARY, seed, worlds, || bar.inc(1));
    bar.finish_and_clear();
    evaluation
}

/// Evaluates every variation.
fn vary(arguments: &Arguments) -> Sensitivity {
    let worlds = VARIED_WORLDS.min(arguments.worlds);
    let bar = progress("factors", variations_steps(worlds));
    let variations = variations(arguments.common.seed, worlds, || bar.inc(1));
    bar.finish_and_clear();
    Sensitivity { worlds, variations }
}

/// Writes every world's figures, a line per world and estimator, and the chart.
fn write(evaluation: &Evaluation, out: &OutDir) -> Result<Vec<PathBuf>, Failure> {
    let table = out.write("table2.csv", |file| {
        writeln!(file, "world,method,mae,mse,missed,ghost,to_oracle")?;
        for (number, world) in evaluation.worlds().enumerate() {
            let oracle = world.last().map_or(0.0, |score| score.mae);
            for (estimator, score) in Estimator::ALL.iter().zip(&world) {
                writeln!(
                    file,
                    "{number},{estimator},{},{},{},{},{}",
                    score.mae,
                    score.mse,
                    score.missed,
                    score.ghost,
                    score.mae - oracle
                )?;
            }
        }
        Ok(())
    });
    let table = table.map_err(|error| Failure::input(&error))?;
    let [png, svg] = chart(evaluation)
        .write(out, "table2")
        .map_err(|error| Failure::input(&error))?;
    Ok(vec![table, png, svg])
}

/// Returns the chart of MAE and MSE beside the paper's, in thousandths.
fn chart(evaluation: &Evaluation) -> BarChart {
    let rows = &evaluation.estimators;
    let ours = |name: &str, part: fn(&Score) -> f64| BarSeries {
        name: name.to_owned(),
        values: rows.iter().map(|row| Some(part(&row.mean) * 1e3)).collect(),
        errors: Some(
            rows.iter()
                .map(|row| row.deviation.map_or(f64::NAN, |score| part(&score) * 1e3))
                .collect(),
        ),
    };
    let printed = Figures::PRINTED.values();
    let papers = |name: &str, nth: usize| BarSeries {
        name: name.to_owned(),
        values: rows
            .iter()
            .map(|row| {
                let place = printed_place(row.estimator)?;
                Some(printed[2 * place + nth] * 1e3)
            })
            .collect(),
        errors: None,
    };
    BarChart {
        title: "[001] Table 2: distance from the grid of perfect sensors".into(),
        y: Axis::new("certainty", "thousandths").from(0.0),
        groups: rows.iter().map(|row| row.estimator.to_string()).collect(),
        bars: vec![
            ours("MAE", |score| score.mae),
            papers("MAE, paper", 0),
            ours("MSE", |score| score.mse),
            papers("MSE, paper", 1),
        ],
    }
}

/// Returns the estimator's row in the printed table.
fn printed_place(estimator: Estimator) -> Option<usize> {
    let mut printed = PRINTED_METHODS.into_iter().map(Estimator::Method);
    printed.position(|method| method == estimator)
}

/// Names of factors with names of levels.
type Named = BTreeMap<&'static str, &'static str>;

/// The report as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct Document {
    seed: u64,
    worlds: usize,
    readings_per_method: usize,
    methods: Vec<MethodReport>,
    paper: Vec<PaperReport>,
    /// Whether the means are in the paper's order, by MAE and by MSE.
    order_holds: bool,
    /// The share of the worlds in the paper's order.
    order_held_in: f64,
    choices: Named,
    #[serde(skip_serializing_if = "Option::is_none")]
    sensitivity: Option<SensitivityReport>,
    files: Vec<String>,
}

/// Deviations are over the worlds; null for a single one.
#[derive(Debug, Serialize)]
struct MethodReport {
    name: &'static str,
    mae: f64,
    mae_sd: Option<f64>,
    mse: f64,
    mse_sd: Option<f64>,
    missed: f64,
    ghost: f64,
    /// MAE and MSE of the grid of perfect readings.
    floor_mae: f64,
    floor_mse: f64,
    /// MAE less the oracle's.
    to_oracle: f64,
}

#[derive(Debug, Serialize)]
struct PaperReport {
    name: &'static str,
    mae: f64,
    mse: f64,
}

#[derive(Debug, Serialize)]
struct SensitivityReport {
    worlds: u32,
    /// The names of the figures in every list of six.
    figures: [&'static str; 6],
    /// The first is the primary set-up.
    one_at_a_time: Vec<VariationReport>,
}

#[derive(Debug, Serialize)]
struct VariationReport {
    choice: Option<&'static str>,
    alternative: Option<&'static str>,
    reason: Option<&'static str>,
    against: Option<&'static str>,
    figures: [f64; 6],
    near: [bool; 6],
    moved_most: Option<MovedReport>,
}

#[derive(Debug, Serialize)]
struct MovedReport {
    figure: &'static str,
    ratio: f64,
}

impl Report for Outcome<'_> {
    fn document(&self) -> impl Serialize {
        let evaluation = &self.evaluation;
        Document {
            seed: self.arguments.common.seed,
            worlds: evaluation.worlds().len(),
            readings_per_method: evaluation.readings,
            methods: evaluation
                .estimators
                .iter()
                .map(MethodReport::from)
                .collect(),
            paper: paper(),
            order_holds: evaluation.figures().in_the_papers_order(),
            order_held_in: evaluation.order_held_in(),
            choices: evaluation.setup.names(),
            sensitivity: self.sensitivity.as_ref().map(SensitivityReport::from),
            files: output::listed(&self.files),
        }
    }

    fn render(&self) -> String {
        let evaluation = &self.evaluation;
        let mut text = format!(
            "[001] Table 2   worlds: {}   readings a method and world: {}   seed: {}\n\
             MAE and MSE in thousandths: mean ± standard deviation over the worlds\n\n",
            evaluation.worlds().len(),
            evaluation.readings,
            self.arguments.common.seed
        );
        text += &methods(evaluation);
        let holds = if evaluation.figures().in_the_papers_order() {
            "holds"
        } else {
            "does not hold"
        };
        text += &format!(
            "The paper's order, median < robust < bayes in MAE and MSE, {holds} for the\n\
             means; in {} of the worlds.\n",
            percent(evaluation.order_held_in())
        );
        text += &self
            .sensitivity
            .as_ref()
            .map_or_else(String::new, sensitivity);
        text += &format!("\nwritten: {}\n", output::joined(&self.files, ", "));
        text
    }
}

impl From<&EstimatorFigures> for MethodReport {
    fn from(row: &EstimatorFigures) -> Self {
        Self {
            name: row.estimator.name(),
            mae: row.mean.mae,
            mae_sd: row.deviation.map(|score| score.mae),
            mse: row.mean.mse,
            mse_sd: row.deviation.map(|score| score.mse),
            missed: row.mean.missed,
            ghost: row.mean.ghost,
            floor_mae: row.floor.mae,
            floor_mse: row.floor.mse,
            to_oracle: row.to_oracle,
        }
    }
}

/// Returns Table 2 as printed.
fn paper() -> Vec<PaperReport> {
    let printed = Figures::PRINTED.values();
    let (pairs, _) = printed.as_chunks::<2>();
    let rows = PRINTED_METHODS.iter().zip(pairs);
    let report = rows.map(|(method, &[mae, mse])| PaperReport {
        name: method.name(),
        mae,
        mse,
    });
    report.collect()
}

impl From<&Sensitivity> for SensitivityReport {
    fn from(sensitivity: &Sensitivity) -> Self {
        let variations = sensitivity.variations.iter();
        Self {
            worlds: sensitivity.worlds,
            figures: Figures::NAMES,
            one_at_a_time: variations.map(VariationReport::from).collect(),
        }
    }
}

impl From<&Variation> for VariationReport {
    fn from(variation: &Variation) -> Self {
        let (choice, level) = variation.change.unzip();
        Self {
            choice,
            alternative: level.map(|level| level.name),
            reason: level.map(|level| level.reason),
            against: level.and_then(|level| level.against),
            figures: variation.figures.values(),
            near: variation.figures.near(),
            moved_most: variation.moved_most.map(|(figure, ratio)| MovedReport {
                figure: Figures::NAMES[figure],
                ratio,
            }),
        }
    }
}

/// Renders the table of the methods beside the paper's.
fn methods(evaluation: &Evaluation) -> String {
    let head = [
        "method", "MAE", "paper", "ratio", "MSE", "paper", "ratio", "missed", "ghost",
    ];
    let mut rows = vec![row(head)];
    rows.extend(evaluation.estimators.iter().map(|row| {
        let EstimatorFigures {
            estimator,
            mean,
            deviation,
            ..
        } = row;
        let printed = Figures::PRINTED.values();
        let place = printed_place(*estimator);
        let mut cells = vec![estimator.to_string()];
        for (nth, mean, deviation) in [
            (0, mean.mae, deviation.map(|score| score.mae)),
            (1, mean.mse, deviation.map(|score| score.mse)),
        ] {
            cells.push(match deviation {
                Some(deviation) => format!("{} ± {}", thousandths(mean), thousandths(deviation)),
                None => thousandths(mean),
            });
            let printed = place.map(|place| printed[2 * place + nth]);
            cells.push(printed.map_or("-".into(), |printed| format!("{:.0}", printed * 1e3)));
            cells.push(printed.map_or("-".into(), |printed| format!("{:.2}", mean / printed)));
        }
        cells.extend([percent(mean.missed), percent(mean.ghost)]);
        cells
    }));
    let head = [
        "method",
        "MAE - oracle's",
        "MAE of perfect readings",
        "MSE of perfect readings",
    ];
    let mut limits = vec![row(head)];
    limits.extend(evaluation.estimators.iter().map(|row| {
        vec![
            row.estimator.to_string(),
            format!("{:+.1}", row.to_oracle * 1e3),
            thousandths(row.floor.mae),
            thousandths(row.floor.mse),
        ]
    }));
    format!("{}\n{}\n", table(&rows), table(&limits))
}

/// Renders the table of the variations.
fn sensitivity(sensitivity: &Sensitivity) -> String {
    let mut text = format!(
        "\nOne factor at a time, {} worlds each; * is within {:.0} % of the paper\n\n",
        sensitivity.worlds,
        Figures::NEAR * 100.0
    );
    let head = [&["factor", "level"][..], &COLUMNS, &["moves most"]].concat();
    let mut rows = vec![head.into_iter().map(str::to_owned).collect::<Vec<_>>()];
    rows.push([vec!["paper".into(), String::new()], six(&Figures::PRINTED)].concat());
    rows.extend(sensitivity.variations.iter().map(|variation| {
        let (factor, level) = match variation.change {
            Some((factor, level)) => (factor, level.name),
            None => ("primary", ""),
        };
        let moved = variation
            .moved_most
            .map(|(figure, ratio)| format!("{} ×{ratio:.2}", Figures::NAMES[figure]));
        let mut cells = vec![factor.to_owned(), level.to_owned()];
        cells.extend(six(&variation.figures));
        cells.push(moved.unwrap_or_default());
        cells
    }));
    text += &table(&rows);
    text
}

const COLUMNS: [&str; 6] = ["bayes", "MSE", "robust", "MSE", "median", "MSE"];

/// Renders the six figures in thousandths, with an asterisk if near the printed one.
fn six(figures: &Figures) -> Vec<String> {
    let marked = figures.values().into_iter().zip(figures.near());
    marked
        .map(|(value, near)| format!("{}{}", thousandths(value), if near { "*" } else { " " }))
        .collect()
}

fn thousandths(value: f64) -> String {
    format!("{:.1}", value * 1e3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_repro::table2::FACTORS;
    use clap::Parser;
    use serde_json::Value;

    #[derive(Debug, Parser)]
    struct Table2 {
        #[command(flatten)]
        arguments: Arguments,
    }

    /// The outcome of one world, as JSON and as text.
    fn outcome(varied: bool) -> (Value, String) {
        let Table2 { arguments } = Table2::parse_from(["table2", "--worlds", "1"]);
        let outcome = Outcome {
            evaluation: evaluate(&arguments),
            sensitivity: varied.then(|| vary(&arguments)),
            arguments: &arguments,
            files: Vec::new(),
        };
        let document = serde_json::to_value(outcome.document()).unwrap();
        (document, outcome.render())
    }

    #[test]
    fn the_sensitivity_lists_every_level() {
        let (document, text) = outcome(true);
        let rows = document["sensitivity"]["one_at_a_time"].as_array().unwrap();
        let others: usize = FACTORS.iter().map(|factor| factor.levels.len() - 1).sum();
        assert_eq!(rows.len(), 1 + others);
        assert_eq!(rows[0]["choice"], Value::Null);
        for row in &rows[1..] {
            let level = row["alternative"].as_str().unwrap();
            assert!(text.contains(level), "{level}");
            for key in ["figures", "near"] {
                assert_eq!(row[key].as_array().unwrap().len(), 6);
            }
            let figure = row["moved_most"]["figure"].as_str().unwrap();
            assert!(Figures::NAMES.contains(&figure));
        }
    }

    #[test]
    fn the_choices_are_those_of_the_primary_setup() {
        let (document, _) = outcome(false);
        let choices = document["choices"].as_object().unwrap();
        assert_eq!(choices.len(), FACTORS.len());
        for factor in FACTORS {
            assert_eq!(choices[factor.name], factor.levels[0].name);
        }
        assert_eq!(document.get("sensitivity"), None);
    }
}
