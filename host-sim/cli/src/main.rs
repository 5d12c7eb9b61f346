//! The program `certainty`: one file a subcommand.
//!
//! Results go to stdout, everything else to stderr. Exit code 0; 2 for bad input or usage, with one
//! line that says what, where and what to do; 1 for a fault of our own.

mod calibrate;
mod campaign;
mod compare;
mod drive;
mod failure;
mod health;
mod jobs;
mod monitor;
mod or_none;
mod outlines;
mod output;
mod overview;
mod panels;
mod progress;
mod recovery;
mod replay;
mod ring;
mod run;

mod simulate;
mod table;
mod table2;

use certainty_core::certainty::Certainty;
use certainty_core::fusion::Geometry;
use certainty_sim::export::MapImage;
use clap::{CommandFactory, Parser, Subcommand};
use failure::Failure;
use std::process::ExitCode;

/// Maps a robot can trust from range sensors it cannot.
#[derive(Debug, Parser)]
#[command(name = "certainty", version, args_conflicts_with_subcommands = true)]
#[command(after_help = "Without a command: certainty simulate.")]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    simulate: simulate::Arguments,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// The Smart Car in a world, one sensor failing: every fusion method on the same readings
    Simulate(simulate::Arguments),
    /// A recording of a real robot: its map and its sensors' health
    Replay(replay::Arguments),
    /// The firmware's application: in this process, under QEMU, or on an emulated board
    Run(run::Arguments),
    /// Two maps (PGM + YAML): where they agree, what is missed, what is a ghost
    Compare(compare::Arguments),
    /// Every method against every fault, beside an oracle: maps and sensor health
    Campaign(campaign::Arguments),
    /// A sensor's confidence falls in a fault and comes back: [001] Fig. 7
    Recovery(recovery::Arguments),
    /// The evaluation of [001] Table 2: every method's distance from perfect sensors, beside the paper's
    Table2(table2::Arguments),
    /// A sonar ring checked against laser scanners and against itself, in an office or recorded: [003]
    Ring(ring::Arguments),
    /// A robot drives to its goal while its sensors fail, told of it or finding out: [004]
    Drive(drive::Arguments),
    /// Measured bytes of infrared sensors: their characteristics, and the errors that are left
    Calibrate(calibrate::Arguments),
    /// A board's telemetry, live: its map, where its sensors look, their health, and what was lost
    Monitor(monitor::Arguments),
}

/// A map's cells with the frame that its grid gives them.
fn map_image<'a>(geometry: &Geometry, cells: &'a [Certainty]) -> Result<MapImage<'a>, Failure> {
    let (width, height) = (geometry.columns().into(), geometry.rows().into());
    let cell_mm = geometry.cell_size().get();
    MapImage::try_new(width, height, cells, cell_mm, geometry.corner())
        .map_err(|error| Failure::Internal(error.to_string()))
}

/// Runs the program with the process's arguments.
fn main() -> ExitCode {
    let outcome = match Cli::try_parse() {
        Ok(cli) => match cli.command.unwrap_or(Command::Simulate(cli.simulate)) {
            Command::Simulate(arguments) => simulate::run(&arguments),
            Command::Replay(arguments) => replay::run(&arguments),
            Command::Run(arguments) => run::run(&arguments),
            Command::Compare(arguments) => compare::run(&arguments),
            Command::Campaign(arguments) => campaign::run(&arguments),
            Command::Recovery(arguments) => recovery::run(&arguments),
            Command::Table2(arguments) => table2::run(&arguments),
            Command::Ring(arguments) => ring::run(&arguments),
            Command::Drive(arguments) => drive::run(&arguments),
            Command::Calibrate(arguments) => calibrate::run(&arguments),
            Command::Monitor(arguments) => monitor::run(&arguments),
        },
        Err(error) => {
            let arguments: Vec<_> = std::env::args_os().skip(1).collect();
            failure::usage(&error, &Cli::command(), &arguments)
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_arguments_are_consistent() {
        Cli::command().debug_assert();
    }
}
