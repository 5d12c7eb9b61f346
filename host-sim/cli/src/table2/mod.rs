//! `certainty table2`: the evaluation of \[001\] §6.2, and which open choices decide it.

mod report;
mod told;

use super::jobs::Jobs;
use super::progress::bar;
use super::{Failure, output};
use certainty_repro::table2::{
    Choices, Effort, Evaluation, Figures, Fuser, Neighbour, PRINTED_METHODS, Search, neighbours,
    neighbours_steps,
};
use certainty_sim::export::OutDir;
use certainty_sim::plot::{Axis, BarChart, BarSeries};
use certainty_sim::simulation::Score;
use clap::Args;
use report::Report;
use std::path::PathBuf;

/// What the evaluation is asked.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// How often the paper's whole evaluation is repeated, each time in other worlds
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    worlds: u32,
    /// Names the evaluation: the same seed gives the same result
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        allow_hyphen_values = true
    )]
    seed: u64,
    /// Also vary every choice that the text leaves open, one by one and all together (minutes)
    #[arg(long)]
    sensitivity: bool,
    #[command(flatten)]
    jobs: Jobs,
    /// Where every world's figures go, as table2.csv, and the chart of their means
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Print one JSON document instead
    #[arg(long)]
    json: bool,
}

/// Worlds of each set-up that is varied; of fewer, if fewer are asked for.
const VARIED_WORLDS: u32 = 100;
/// Worlds of each set-up of the screen.
const SCREEN_WORLDS: u32 = 4;
/// Set-ups of the screen with each alternative that are run again.
const FINALISTS: usize = 12;

/// What was varied.
#[derive(Debug)]
struct Sensitivity {
    worlds: u32,
    screen_worlds: u32,
    neighbours: Vec<Neighbour>,
    search: Search,
}

/// Runs the evaluation and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    output::check_listable(arguments.json, &arguments.out)?;
    // Before the work, which takes a while.
    let out = OutDir::create(&arguments.out).map_err(|error| Failure::input(&error))?;
    let (evaluation, sensitivity) = arguments.jobs.run(|| {
        let evaluation = evaluated(arguments);
        let sensitivity = arguments.sensitivity.then(|| varied(arguments));
        (evaluation, sensitivity)
    })?;
    let files = written(&evaluation, &out)?;
    if arguments.json {
        let report = Report::new(arguments.seed, &evaluation, sensitivity.as_ref(), &files);
        output::print_json(&report)
    } else {
        let text = told::told(arguments.seed, &evaluation, sensitivity.as_ref(), &files);
        output::print(&text)
    }
}

/// The primary set-up in all worlds.
fn evaluated(arguments: &Arguments) -> Evaluation {
    let progress = bar("worlds", arguments.worlds.into());
    let (seed, worlds) = (arguments.seed, arguments.worlds);
    let evaluation = Evaluation::run(Choices::PRIMARY, seed, worlds, || progress.inc(1));
    progress.finish_and_clear();
    evaluation
}

/// The open choices, one at a time and all together.
fn varied(arguments: &Arguments) -> Sensitivity {
    let worlds = VARIED_WORLDS.min(arguments.worlds);
    let progress = bar("choices", neighbours_steps(worlds));
    let neighbours = neighbours(arguments.seed, worlds, || progress.inc(1));
    progress.finish_and_clear();

    let effort = Effort {
        screen_worlds: SCREEN_WORLDS.min(worlds),
        finalists: FINALISTS,
        final_worlds: worlds,
    };
    let progress = bar("combinations", 0);
    let announce = |steps| progress.inc_length(steps);
    let search = Search::run(arguments.seed, &effort, announce, || progress.inc(1));
    progress.finish_and_clear();
    Sensitivity {
        worlds,
        screen_worlds: effort.screen_worlds,
        neighbours,
        search,
    }
}

/// Writes the files: every world's figures, one line a world and method, and the chart.
fn written(evaluation: &Evaluation, out: &OutDir) -> Result<Vec<PathBuf>, Failure> {
    let table = out.write("table2.csv", |file| {
        writeln!(file, "world,method,mae,mse,missed,ghost,to_oracle")?;
        for (number, world) in evaluation.worlds().enumerate() {
            let oracle = world.last().map_or(0.0, |score| score.mae);
            for (method, score) in Fuser::ALL.iter().zip(&world) {
                writeln!(
                    file,
                    "{number},{method},{},{},{},{},{}",
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

/// MAE and MSE of everyone beside the paper's, in thousandths.
fn chart(evaluation: &Evaluation) -> BarChart {
    let rows = &evaluation.methods;
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
                let place = printed_place(row.method)?;
                Some(printed[2 * place + nth] * 1e3)
            })
            .collect(),
        errors: None,
    };
    BarChart {
        title: "[001] Table 2: distance from the grid of perfect sensors".into(),
        y: Axis::new("certainty", "thousandths").from(0.0),
        groups: rows.iter().map(|row| row.method.to_string()).collect(),
        bars: vec![
            ours("MAE", |score| score.mae),
            papers("MAE, paper", 0),
            ours("MSE", |score| score.mse),
            papers("MSE, paper", 1),
        ],
    }
}

/// Which row of the printed table is `fuser`'s.
fn printed_place(fuser: Fuser) -> Option<usize> {
    let mut printed = PRINTED_METHODS.into_iter().map(Fuser::Method);
    printed.position(|method| method == fuser)
}

#[cfg(test)]
mod tests;
