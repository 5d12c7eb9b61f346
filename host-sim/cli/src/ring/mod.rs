//! `certainty ring`: which sonar of a ring is wrong, \[003\].

mod look;
mod recorded;
mod sweep;

use super::jobs::Jobs;
use super::{Failure, output};
use certainty_core::units::{Millimeters, Point, Pose};
use certainty_ring::RingRules;
use certainty_sim::quantity;
use certainty_sim::ring::{RingFault, Situation};
use certainty_sim::world::World;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// What the check is asked.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The obstacles: a TOML file; without it, the built-in office
    #[arg(long, value_name = "FILE", conflicts_with = "recording")]
    world: Option<PathBuf>,
    /// Where the robot is and looks, such as 2.5m,1.8m,30deg [default: in the office's middle]
    #[arg(long, value_name = "X,Y,HEADING", value_parser = pose, allow_hyphen_values = true,
          conflicts_with_all = ["recording", "sweep", "extraction"])]
    pose: Option<Pose>,
    /// What is wrong with a sonar: its number from 1, or such as blind:4 or stuck:7=350mm; repeatable.
    /// With --sweep, the kind of the first
    #[arg(
        long = "fault",
        value_name = "[KIND:]SENSOR[=VALUE]",
        conflicts_with = "recording"
    )]
    faults: Vec<RingFault>,
    /// Check at many places, with and without every kind of fault
    #[arg(long, conflicts_with_all = ["recording", "extraction"])]
    sweep: bool,
    /// Compare the polygons at many places with the world
    #[arg(long, conflicts_with = "recording")]
    extraction: bool,
    /// How many confirmations a sonar needs: one, as [003] has it, or three
    #[arg(
        long,
        value_enum,
        default_value_t,
        conflicts_with_all = ["recording", "extraction"]
    )]
    rules: Rules,
    /// How many places
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    poses: u32,
    /// A recording of a real ring of 24: distances in metres, a row a line
    #[arg(long, value_name = "FILE")]
    recording: Option<PathBuf>,
    /// The recorded sonars' range
    #[arg(long, value_name = "LENGTH", default_value = "5m", value_parser = quantity::length)]
    range: Millimeters,
    /// Names the run: the same seed gives the same result
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        allow_hyphen_values = true
    )]
    seed: u64,
    #[command(flatten)]
    jobs: Jobs,
    /// Where the pictures go
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Print one JSON document instead
    #[arg(long)]
    json: bool,
}

/// Sets of numbers of the check, by their names on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum Rules {
    /// One confirmation is enough
    #[default]
    Paper,
    /// It takes three
    Wary,
}

impl Rules {
    const fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Wary => "wary",
        }
    }

    const fn rules(self) -> RingRules {
        match self {
            Self::Paper => RingRules::DEFAULT,
            Self::Wary => RingRules::WARY,
        }
    }
}

impl Arguments {
    /// The ring in a world, checked by these rules.
    fn situation<'a>(&self, world: &'a World) -> Situation<'a> {
        let mut situation = Situation::new(world);
        situation.rules = self.rules.rules();
        situation
    }
}

/// Reads a pose.
fn pose(text: &str) -> Result<Pose, String> {
    let mut parts = text.split(',');
    let mut part = || {
        let example = "write x, y and heading, such as 2.5m,1.8m,30deg";
        parts
            .next()
            .ok_or_else(|| format!("a part is missing: {example}"))
    };
    let length = |text: &str| quantity::signed_length(text).map_err(|error| error.to_string());
    let (x, y) = (length(part()?)?, length(part()?)?);
    let heading = quantity::angle(part()?).map_err(|error| error.to_string())?;
    match parts.next() {
        None => Ok(Pose::new(Point::from_mm(x.get(), y.get()), heading)),
        Some(_) => {
            Err("a pose has three parts: write x, y and heading, such as 2.5m,1.8m,30deg".into())
        }
    }
}

/// Runs the check and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    output::check_listable(arguments.json, &arguments.out)?;
    if let Some(recording) = &arguments.recording {
        return recorded::run(arguments, recording);
    }
    let world = match &arguments.world {
        Some(file) => World::load(file).map_err(|error| Failure::input(&error))?,
        None => World::office(),
    };
    if arguments.sweep {
        sweep::faults(arguments, &world)
    } else if arguments.extraction {
        sweep::extraction(arguments, &world)
    } else {
        look::run(arguments, &world)
    }
}

/// The sonars' numbers, for a table's first column.
fn numbers() -> impl Iterator<Item = String> {
    (1..=certainty_sim::ring::SONARS).map(|number| number.to_string())
}

/// Numbers as a list in a sentence.
fn listed(numbers: &[u8]) -> String {
    if numbers.is_empty() {
        return "none".into();
    }
    let texts: Vec<String> = numbers.iter().map(ToString::to_string).collect();
    texts.join(", ")
}
