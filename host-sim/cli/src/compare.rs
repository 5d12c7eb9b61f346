//! `certainty compare`: two maps held against each other.

use super::simulate::percent;
use super::table::{row, table};
use super::{Failure, output};
use certainty_sim::export::{Comparison, RosMap, compare};
use clap::Args;
use std::path::{Path, PathBuf};

/// What the comparison is asked.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The map that is taken for true: its YAML file
    a: PathBuf,
    /// The map that is judged: its YAML file
    b: PathBuf,
    /// Print one JSON document instead
    #[arg(long)]
    json: bool,
}

/// Compares the maps and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let load = |file: &Path| RosMap::load(file).map_err(|error| Failure::input(&error));
    let (a, b) = (load(&arguments.a)?, load(&arguments.b)?);
    let comparison = compare(&a, &b).map_err(|error| {
        let (a, b) = (arguments.a.display(), arguments.b.display());
        Failure::Input(format!("{a} and {b}: {error}"))
    })?;
    if arguments.json {
        output::print_json(&comparison)
    } else {
        output::print(&told(&comparison))
    }
}

/// The report for people.
fn told(found: &Comparison) -> String {
    let share = |share: Option<f64>| share.map_or_else(|| "-".to_owned(), percent);
    let line = |name: &str, cells: u64, part: Option<f64>| {
        vec![name.to_owned(), cells.to_string(), share(part)]
    };
    let mut text = table(&[
        row(["", "cells", "share"]),
        line("in both maps", found.overlap, None),
        line("known in both", found.known_in_both, None),
        line("agreeing", found.agreeing, found.agreement),
        line(
            "missed: occupied in A, not in B",
            found.missed,
            found.missed_fraction,
        ),
        line(
            "ghost: free in A, occupied in B",
            found.ghost,
            found.ghost_fraction,
        ),
        line("known in A only", found.only_a, None),
        line("known in B only", found.only_b, None),
    ]);
    if found.misaligned {
        text += "The maps' cells do not lie on each other; the nearest ones were compared.\n";
    }
    text
}
