//! The program `certainty`: one file per subcommand.
//!
//! Results go to stdout, everything else to stderr. Exit code 0; 2 for bad input or usage, with one line
//! on stderr; 1 for an internal error.

mod calibrate;
mod campaign;
mod compare;
mod drive;
mod drive_study;
mod failure;
mod maps;
mod monitor;
mod options;
mod output;
mod recovery;
mod replay;
mod ring;
mod run;
mod simulate;
mod table;
mod table2;
mod usage;

use clap::{CommandFactory, Parser, Subcommand};
use failure::Failure;
use std::process::ExitCode;

/// Certainty grids that survive faulty range sensors: simulate, replay, measure.
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
    /// Two maps (PGM + YAML): agreement, missed obstacles and ghosts
    Compare(compare::Arguments),
    /// Every method against every fault, beside an oracle: maps and sensor health
    Campaign(campaign::Arguments),
    /// A sensor's confidence in and after a fault: [001] Fig. 7
    Recovery(recovery::Arguments),
    /// The evaluation of [001] Table 2: every method's distance from perfect sensors, beside the paper's
    Table2(table2::Arguments),
    /// A sonar ring checked against laser scanners and against itself, in an office or recorded: [003]
    Ring(ring::Arguments),
    /// A robot drives to its goal while its sensors fail, with and without a diagnosis: [004]
    Drive(drive::Arguments),
    /// Measured bytes of infrared sensors: their characteristics and the remaining errors
    Calibrate(calibrate::Arguments),
    /// A board's telemetry, live: its map, its sensors' directions and health, and lost frames
    Monitor(monitor::Arguments),
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
            usage::usage(&error, &Cli::command(), &arguments)
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
    fn the_options_are_consistent() {
        Cli::command().debug_assert();
    }
}
