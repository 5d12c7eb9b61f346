//! The program `certainty`: one file per subcommand.
//!
//! Results go to stdout, everything else to stderr. Exit code 0; 2 for bad input or usage, with one line
//! on stderr; 1 for an internal error.

mod calibrate;
mod campaign;
mod compare;
mod drive;
mod drive_study;
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

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand};
use core::error::Error;
use core::num::{IntErrorKind, ParseIntError};
use output::Failure;
use std::ffi::OsString;
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
    /// Two maps (YAML with an image): agreement, missed obstacles and ghosts
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
            usage(&error, &Cli::command(), &arguments)
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

/// Handles an error of clap: prints help and version on stdout, and returns a usage error as one line that
/// names the subcommand's help.
fn usage(
    error: &clap::Error,
    command: &clap::Command,
    arguments: &[OsString],
) -> Result<(), Failure> {
    let text = error.render().to_string();
    if let ErrorKind::DisplayHelp | ErrorKind::DisplayVersion = error.kind() {
        return output::print(&text);
    }
    let text = text.strip_prefix("error: ").unwrap_or(&text);
    let what = text.split("\n\nUsage:").next().unwrap_or(text);
    let what = what.split("\n\nFor more information").next();
    let what = what.unwrap_or(text).trim_end();
    let what = match error.kind() {
        ErrorKind::InvalidUtf8 => not_text(arguments),
        _ => with_expected(what, error),
    };
    let first = arguments.first().and_then(|first| first.to_str());
    let subcommand = first.and_then(|name| command.find_subcommand(name));
    let of = subcommand.map_or_else(String::new, |named| format!("{} ", named.get_name()));
    Err(Failure::Input(format!("{what}; see certainty {of}--help")))
}

/// Returns `what` with the expected number in place of the parser's error about one.
fn with_expected(what: &str, error: &clap::Error) -> String {
    let source = error.source();
    let Some(number) = source.and_then(|source| source.downcast_ref::<ParseIntError>()) else {
        return what.to_owned();
    };
    let expected = match number.kind() {
        IntErrorKind::Zero => "expected a whole number of at least 1",
        IntErrorKind::PosOverflow => "too large, expected a smaller whole number",
        _ => "expected a whole number in digits alone, such as 7",
    };
    let what = what.strip_suffix(&number.to_string()).unwrap_or(what);
    format!("{what}{expected}")
}

/// Returns the error of arguments that are not UTF-8, with their options.
fn not_text(arguments: &[OsString]) -> String {
    let mut places: Vec<String> = Vec::new();
    let mut before: Option<&str> = None;
    for argument in arguments {
        let lossy = argument.to_string_lossy();
        if argument.to_str().is_none() {
            let option = match (lossy.strip_prefix("--"), before) {
                (Some(_), _) => lossy.split('=').next().unwrap_or(&lossy).to_owned(),
                (None, Some(option)) => option.to_owned(),
                (None, None) => format!("'{lossy}'"),
            };
            places.push(option);
        }
        before = argument.to_str().filter(|text| text.starts_with("--"));
    }
    let places = places.join(" or ");
    format!("{places}: the value is not UTF-8: expected text in UTF-8")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_options_are_consistent() {
        Cli::command().debug_assert();
    }
}
