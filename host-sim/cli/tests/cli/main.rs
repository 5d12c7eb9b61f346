//! The program `certainty` from the command line: a module per subcommand, and for bad input.

mod bad_input;
mod calibrate;
mod campaign;
mod command_line;
mod damaged_input;
mod drive;
mod maps;
mod monitor;
mod real_recordings;
mod recovery;
mod replay;
mod ring;
mod run;
mod support;
mod table2;
