//! Options that several subcommands have, and parsers of their values.

use super::output::{self, Failure, Report};
use certainty_sim::export::{OutDir, display_path};
use certainty_sim::fusion::Method;
use certainty_sim::world::World;
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use core::convert::Infallible;
use core::str::FromStr;
use std::path::{Path, PathBuf};

/// `--json`: part of every subcommand.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct JsonOption {
    /// Print one JSON document instead of text
    #[arg(long)]
    pub(super) json: bool,
}

/// `--out` and `--json`: part of every subcommand that writes files.
#[derive(Debug, Clone, Args)]
pub(super) struct OutputOptions {
    /// Folder for the files
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub(super) out: PathBuf,
    #[command(flatten)]
    json: JsonOption,
}

/// `--seed`, `--out` and `--json`: part of every subcommand that simulates.
#[derive(Debug, Clone, Args)]
pub(super) struct CommonOptions {
    /// Seed of the random numbers: the same seed gives the same result
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        allow_hyphen_values = true
    )]
    pub(super) seed: u64,
    #[command(flatten)]
    pub(super) output: OutputOptions,
}

impl JsonOption {
    /// Prints the report as `--json` asks for it.
    pub(super) fn print(self, report: &impl Report) -> Result<(), Failure> {
        if self.json {
            output::print_json(&report.document())
        } else {
            output::print(&report.render())
        }
    }
}

impl OutputOptions {
    /// Returns whether `--json` was given.
    pub(super) const fn is_json(&self) -> bool {
        self.json.json
    }

    /// Refuses a folder whose name a JSON document could not hold.
    pub(super) fn check(&self) -> Result<(), Failure> {
        output::check_listable(self.json.json, &self.out)
    }

    /// Creates and locks the folder; `finish` of it puts the files in place.
    pub(super) fn create(&self) -> Result<OutDir, Failure> {
        OutDir::begin(&self.out).map_err(|error| Failure::input(&error))
    }

    /// Prints the report as `--json` asks for it.
    pub(super) fn print(&self, report: &impl Report) -> Result<(), Failure> {
        self.json.print(report)
    }
}

/// `--jobs N`: part of every subcommand that runs in parallel.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct Jobs {
    /// Number of threads, which does not change the result [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
}

impl Jobs {
    /// Returns whether a number was given.
    pub(super) const fn are_given(self) -> bool {
        self.jobs.is_some()
    }

    /// Runs `work` with this number of `rayon` threads.
    pub(super) fn run<T: Send>(self, work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
        // Zero: rayon counts the cores.
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.jobs.unwrap_or(0).into())
            .build()
            .map_err(|error| Failure::Internal(format!("cannot start threads: {error}")))?;
        Ok(pool.install(work))
    }
}

/// Returns the parser of a value by its name; the help and the error list all names.
pub(super) fn named<T: Copy + Send + Sync + 'static>(
    all: impl IntoIterator<Item = T>,
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    let all: Vec<T> = all.into_iter().collect();
    let names: Vec<_> = all.iter().map(|&value| name(value)).collect();
    PossibleValuesParser::new(names).try_map(move |text| {
        let found = all.iter().copied().find(|&value| name(value) == text);
        found.ok_or("not a listed name") // the parser refused every other one
    })
}

/// Refuses a directory in place of a file.
pub(super) fn no_directory(file: &Path, expected: &str) -> Result<(), Failure> {
    if file.is_dir() {
        let line = format!(
            "{}: is a directory: expected {expected}",
            display_path(file)
        );
        return Err(Failure::Input(line));
    }
    Ok(())
}

/// Loads the world of `--world`; without a file, `built_in` creates it.
pub(super) fn world(file: Option<&Path>, built_in: fn() -> World) -> Result<World, Failure> {
    match file {
        Some(file) => World::load(file).map_err(|error| Failure::input(&error)),
        None => Ok(built_in()),
    }
}

/// A value of a repeatable option, or `none` for an empty list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum OrNone<T> {
    None,
    Some(T),
}

impl<T: FromStr> FromStr for OrNone<T> {
    type Err = T::Err;

    fn from_str(text: &str) -> Result<Self, T::Err> {
        match text {
            "none" => Ok(Self::None),
            some => some.parse().map(Self::Some),
        }
    }
}

/// A name that is resolved after parsing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Name(pub String);

impl FromStr for Name {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(Self(text.to_owned()))
    }
}

/// Returns the values of the repeatable `option`; an error for `none` together with a value.
pub(super) fn given<T: Clone>(option: &str, all: &[OrNone<T>]) -> Result<Vec<T>, Failure> {
    let some: Vec<T> = all
        .iter()
        .filter_map(|one| match one {
            OrNone::None => None,
            OrNone::Some(one) => Some(one.clone()),
        })
        .collect();
    if !some.is_empty() && some.len() < all.len() {
        let line = format!("{option}: none and a value together: expected none alone, or values");
        return Err(Failure::Input(line));
    }
    Ok(some)
}

/// Refuses a `--trim` that none of `methods` uses, or that is more than `sensors` sensors allow.
pub(super) fn check_trim(
    trim: Option<u8>,
    methods: impl IntoIterator<Item = Method>,
    sensors: u8,
) -> Result<(), Failure> {
    let Some(trim) = trim else {
        return Ok(());
    };
    if !methods.into_iter().any(|method| method == Method::Trimmed) {
        let line = "--trim: no map is fused by the trimmed method: expected --fusion trimmed too";
        return Err(Failure::Input(line.into()));
    }
    let most = sensors.saturating_sub(1) / 2;
    if trim > most {
        return Err(Failure::Input(format!(
            "--trim: {trim} at each end leave nothing of {sensors} sensors: expected at most {most}"
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_sim::backend::Backend;
    use certainty_sim::fusion::{Method, Rules};
    use certainty_sim::robot::{HealthMode, MapSource, Memory};
    use clap::Command;
    use std::ffi::OsStr;

    /// Asserts that every name is parsed as its value, and that others are refused.
    fn assert_named<T>(all: &[T], name: fn(T) -> &'static str, names: &[&str])
    where
        T: Copy + Send + Sync + PartialEq + core::fmt::Debug + 'static,
    {
        let (parser, command) = (named(all.to_vec(), name), Command::new("certainty"));
        let parse = |text: &str| parser.parse_ref(&command, None, OsStr::new(text));
        assert_eq!(
            all.iter().map(|&value| name(value)).collect::<Vec<_>>(),
            names
        );
        for &value in all {
            assert_eq!(parse(name(value)).unwrap(), value);
            assert!(parse(&name(value).to_uppercase()).is_err());
        }
        assert!(parse("").is_err());
    }

    #[test]
    fn names_are_read_back_and_others_refused() {
        assert_named(
            &HealthMode::ALL,
            HealthMode::name,
            &["given", "diagnosed", "ignored"],
        );
        assert_named(
            &Memory::ALL,
            Memory::name,
            &["nobody", "diagnosed", "everyone"],
        );
        let sources = ["beams", "bayes", "robust", "trimmed", "median"];
        assert_named(&MapSource::ALL, MapSource::name, &sources);
        assert_named(&Method::ALL, Method::name, &sources[1..]);
        assert_named(&Rules::ALL, Rules::name, &["shipped", "letter", "coarse"]);
        assert_named(&Backend::ALL, Backend::name, &["native", "qemu", "board"]);
    }

    #[test]
    fn none_and_a_value_are_refused_together() {
        let given = |texts: &[&str]| {
            let all: Vec<OrNone<u8>> = texts.iter().map(|text| text.parse().unwrap()).collect();
            given("--option", &all)
        };
        assert_eq!(given(&[]).unwrap(), [0_u8; 0]);
        assert_eq!(given(&["none", "none"]).unwrap(), [0_u8; 0]);
        assert_eq!(given(&["3", "4"]).unwrap(), [3, 4]);
        assert!(given(&["3", "none"]).is_err() && given(&["none", "3"]).is_err());
        assert!("nones".parse::<OrNone<u8>>().is_err());
    }
}
