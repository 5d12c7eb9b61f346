//! `certainty compare`: agreement and differences of two maps.

use super::options::{JsonOption, no_directory};
use super::output::Failure;
use super::output::Report;
use super::table::{percent_or_dash, row, table};
use certainty_sim::export::{Comparison, LoadedMap, RosMap, compare, display_path};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The options of `certainty compare`.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The reference map: its YAML file, - for stdin
    a: PathBuf,
    /// The map to assess: its YAML file, - for stdin
    b: PathBuf,
    #[command(flatten)]
    json: JsonOption,
}

/// Compares the maps and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let is_stdin = |file: &Path| file == Path::new("-");
    if is_stdin(&arguments.a) && is_stdin(&arguments.b) {
        let line = "-: stdin holds one YAML: give a file for the other map";
        return Err(Failure::Input(line.into()));
    }
    let load = |file: &Path| {
        let loaded = if is_stdin(file) {
            // Its image is relative to the current directory.
            RosMap::read(std::io::stdin().lock(), Path::new("stdin"), Path::new(""))
        } else {
            no_directory(file, "a map's YAML file")?;
            RosMap::load(file)
        };
        loaded.map_err(|error| Failure::input(&error))
    };
    let (a, b) = (load(&arguments.a)?, load(&arguments.b)?);
    let mut comparison = compare(&a.map, &b.map).map_err(|error| {
        let (a, b) = (display_path(&arguments.a), display_path(&arguments.b));
        Failure::Input(format!("{a} and {b}: {error}"))
    })?;
    let LoadedMap { mut notes, .. } = a;
    for note in b.notes.into_iter().chain(comparison.notes) {
        if !notes.contains(&note) {
            notes.push(note);
        }
    }
    comparison.notes = notes;
    arguments.json.print(&comparison)
}

impl Report for Comparison {
    fn document(&self) -> impl Serialize {
        self
    }

    fn render(&self) -> String {
        let line = |name: &str, cells: u64, part: Option<f64>| {
            vec![name.to_owned(), cells.to_string(), percent_or_dash(part)]
        };
        let mut text = table(&[
            row(["", "cells", "share"]),
            line("in both maps", self.overlap, None),
            line("known in both", self.known_in_both, None),
            line("agreeing", self.agreeing, self.agreement),
            line(
                "missed: occupied in A, not in B",
                self.missed,
                self.missed_fraction,
            ),
            line(
                "ghost: free in A, occupied in B",
                self.ghost,
                self.ghost_fraction,
            ),
            line("known in A only", self.only_a, None),
            line("known in B only", self.only_b, None),
        ]);
        for note in &self.notes {
            text += &format!("note: {note}\n");
        }
        text
    }
}
