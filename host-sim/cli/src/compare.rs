//! `certainty compare`: agreement and differences of two maps.

use super::options::{JsonOption, no_directory};
use super::output::Failure;
use super::output::Report;
use super::table::{percent_or_dash, row, table};
use certainty_sim::export::{Comparison, RosMap, compare};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The options of `certainty compare`.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The reference map: its YAML file
    a: PathBuf,
    /// The map to assess: its YAML file
    b: PathBuf,
    #[command(flatten)]
    json: JsonOption,
}

/// Compares the maps and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let load = |file: &Path| {
        no_directory(file, "a map's YAML file")?;
        RosMap::load(file).map_err(|error| Failure::input(&error))
    };
    let (a, b) = (load(&arguments.a)?, load(&arguments.b)?);
    let comparison = compare(&a, &b).map_err(|error| {
        let (a, b) = (arguments.a.display(), arguments.b.display());
        Failure::Input(format!("{a} and {b}: {error}"))
    })?;
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
        if self.misaligned {
            text += "The maps' cells are not aligned; the nearest ones were compared.\n";
        }
        text
    }
}
