//! The program `certainty` as its users run it: one module a subcommand, and what people bring.

mod bad_input;
mod calibrate;
mod campaign;
mod command_line;
mod damaged_input;
mod drive;
mod maps;
mod monitor;
mod random_bytes;
mod real_recordings;
mod recovery;
mod replay;
mod ring;
mod run;
mod support;
mod table2;
