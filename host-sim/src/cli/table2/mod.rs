//! `certainty table2`: the evaluation of \[001\] §6.2, and which open choices decide it.

mod report;
mod told;

use super::progress::bar;
use super::{Failure, output};
use crate::experiment::table2::{
    Choices, Effort, Evaluation, Neighbour, Search, neighbours, neighbours_steps,
};
use crate::export::OutDir;
use crate::fusion::Method;
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
    /// How many threads compute; the result does not depend on it [default: one a core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    jobs: Option<u16>,
    /// Where every world's figures go, as table2.csv
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
    let threads = arguments.jobs.map_or(0, usize::from); // 0: as many as there are cores
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| Failure::Internal(format!("cannot start threads: {error}")))?;

    let (evaluation, sensitivity) = pool.install(|| {
        let evaluation = evaluated(arguments);
        let sensitivity = arguments.sensitivity.then(|| varied(arguments));
        (evaluation, sensitivity)
    });
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

/// Writes the files: every world's figures, one line a world and method.
fn written(evaluation: &Evaluation, out: &OutDir) -> Result<Vec<PathBuf>, Failure> {
    let table = out.write("table2.csv", |file| {
        writeln!(file, "world,method,mae,mse,missed,ghost")?;
        for (number, world) in evaluation.worlds().enumerate() {
            for (method, score) in Method::ALL.iter().zip(world) {
                writeln!(
                    file,
                    "{number},{method},{},{},{},{}",
                    score.mae, score.mse, score.missed, score.ghost
                )?;
            }
        }
        Ok(())
    });
    Ok(vec![table.map_err(|error| Failure::input(&error))?])
}

#[cfg(test)]
mod tests;
