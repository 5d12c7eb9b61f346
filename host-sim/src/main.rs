//! The program `certainty`.

use std::process::ExitCode;

fn main() -> ExitCode {
    certainty_sim::cli::main()
}
