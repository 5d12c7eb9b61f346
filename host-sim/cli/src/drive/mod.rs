//! `certainty drive`: a robot drives to its goal while its sensors fail, \[004\] §4.

mod asked;
mod figures;
mod study;
mod told;

use super::jobs::Jobs;
use super::or_none::{Name, OrNone};
use super::{Failure, output};
use certainty_control::FailureSharing;
use certainty_core::units::Point;
use certainty_sim::export::OutDir;
use certainty_sim::fault::FaultSpec;
use certainty_sim::quantity;
use certainty_sim::robot::{Drive, HealthMode, MapSource, Memory, Outcome, PilotConfig};
use clap::Args;
use serde::Serialize;
use std::io::{self, Write};
use std::path::PathBuf;

/// What the robot is asked.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// A world file such as host-sim/data/course.toml, which is the course without it: the robot starts at
    /// 0,0 and looks along +x
    #[arg(long, value_name = "FILE", conflicts_with = "study")]
    world: Option<PathBuf>,
    /// Where the robot shall be
    #[arg(
        long,
        value_name = "X,Y",
        default_value = "10m,0m",
        value_parser = place,
        allow_hyphen_values = true,
        conflicts_with = "study"
    )]
    goal: Point,
    /// A sensor that is silent all the time: FL, OL, SL, SR, OR, FR or scanner; repeatable
    #[arg(long, value_name = "SENSOR|none", conflicts_with = "study")]
    fail: Vec<OrNone<Name>>,
    /// What befalls a sensor, such as stuck-far:FL@5s; see certainty simulate --help; repeatable
    #[arg(
        long,
        value_name = "KIND:SENSOR[=VALUE][@FROM[..TO]]|none",
        conflicts_with = "study"
    )]
    fault: Vec<OrNone<FaultSpec>>,
    /// Who tells the control level which sensors have failed: an oracle, the fusion level, nobody
    #[arg(
        long,
        value_name = "given|diagnosed|ignored",
        default_value = "diagnosed",
        conflicts_with = "study"
    )]
    health: HealthMode,
    /// What obstacles are seen in: the scanner's beams, or a certainty grid
    #[arg(
        long,
        value_name = "beams|robust|bayes|trimmed|median",
        default_value = "beams"
    )]
    map: MapSource,
    /// What a failed rangefinder does to the others: [004] eq. 14, or nothing
    #[arg(long, value_name = "shared|own", default_value = "shared", value_parser = blame)]
    blame: FailureSharing,
    /// Who remembers in a robust grid what sensors saw that are believed, and goes by that where they
    /// see nothing now: nobody as in [004], a robot that finds out itself what has failed, or every robot
    #[arg(
        long,
        value_name = "nobody|diagnosed|everyone",
        default_value = "diagnosed"
    )]
    memory: Memory,
    /// Allow full speed however little is seen, as the simulations of [004] do; the study has both
    #[arg(long, conflicts_with = "study")]
    bold: bool,
    /// Names the noise, the slip and the faults' whims; with --study the first of the random courses
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        allow_hyphen_values = true
    )]
    seed: u64,
    /// Drive the simulations of [004], every single failure and every pair, in random courses
    #[arg(long)]
    study: bool,
    /// How many random courses every case of the study is driven in
    #[arg(
        long,
        value_name = "N",
        default_value_t = 50,
        requires = "study",
        value_parser = clap::value_parser!(u32).range(1..=100_000)
    )]
    worlds: u32,
    #[command(flatten)]
    jobs: Jobs,
    /// Where the track, the charts and the tables go
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Print one JSON document instead
    #[arg(long)]
    json: bool,
}

/// Reads a place such as `10m,-50cm`.
fn place(text: &str) -> Result<Point, String> {
    let (x, y) = text
        .split_once(',')
        .ok_or("write two lengths with a comma between, such as 10m,0m")?;
    let length = |text| quantity::signed_length(text).map_err(|error| error.to_string());
    Ok(Point::from_mm(length(x)?.get(), length(y)?.get()))
}

fn blame(text: &str) -> Result<FailureSharing, String> {
    match text {
        "shared" => Ok(FailureSharing::Shared),
        "own" => Ok(FailureSharing::Own),
        _ => Err("write shared or own".into()),
    }
}

/// Drives and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    output::check_listable(arguments.json, &arguments.out)?;
    if arguments.study {
        return arguments.jobs.run(|| study::run(arguments))?;
    }
    if arguments.jobs.are_given() {
        let line = "--jobs: one drive has no use for threads; leave it out, or add --study";
        return Err(Failure::Input(line.into()));
    }
    let drive = asked::asked(arguments)?;
    let outcome = drive.run().map_err(|error| Failure::input(&error))?;
    let out = OutDir::create(&arguments.out).map_err(|error| Failure::input(&error))?;
    let written = out.write("drive.csv", |file| write_csv(&outcome, file));
    written.map_err(|error| Failure::input(&error))?;
    figures::draw(&drive, &outcome, &out).map_err(|error| Failure::input(&error))?;
    if arguments.json {
        output::print_json(&Report::new(&drive, &outcome))
    } else {
        output::print(&told::told(arguments, &drive, &outcome))
    }
}

const fn blame_name(blame: FailureSharing) -> &'static str {
    match blame {
        FailureSharing::Shared => "shared",
        FailureSharing::Own => "own",
    }
}

const fn pilot(arguments: &Arguments) -> PilotConfig {
    PilotConfig {
        bold: arguments.bold,
        sharing: arguments.blame,
        memory: arguments.memory,
    }
}

/// Writes a line a control step.
fn write_csv(outcome: &Outcome, out: &mut dyn Write) -> io::Result<()> {
    writeln!(
        out,
        "time_s,x_mm,y_mm,heading_deg,right_m_s,left_m_s,speed_m_s,distance_m,angle_deg"
    )?;
    for step in &outcome.steps {
        let heading = f64::from(step.pose.heading.to_bits()) / 65536.0 * 360.0;
        let (right, left) = step.wheels_m_s;
        writeln!(
            out,
            "{:.2},{},{},{heading:.2},{right:.3},{left:.3},{:.3},{:.3},{:.2}",
            step.time_s,
            step.pose.at.x_mm(),
            step.pose.at.y_mm(),
            step.speed_m_s,
            step.distance_m,
            step.angle_deg
        )?;
    }
    Ok(())
}

/// The report as JSON; its fields are a contract.
///
/// E, S, s and `v_M` as \[004\] eq. 17 to 19 have them; s and the time are null where the goal was not
/// reached, the clearance is on an open plane.
#[derive(Debug, Serialize)]
struct Report {
    reached: bool,
    time_s: Option<f64>,
    #[serde(rename = "E")]
    error: f64,
    #[serde(rename = "S")]
    speed_deviation: f64,
    #[serde(rename = "s")]
    route_m: Option<f64>,
    #[serde(rename = "v_M")]
    mean_speed: f64,
    collisions: u32,
    min_clearance_mm: Option<f64>,
    health_mode: &'static str,
    events: Vec<EventReport>,
}

#[derive(Debug, Serialize)]
struct EventReport {
    time_s: f64,
    what: String,
}

impl Report {
    fn new(drive: &Drive, outcome: &Outcome) -> Self {
        let quality = outcome.quality;
        let events = outcome.events.iter().map(|event| EventReport {
            time_s: event.time_s,
            what: event.what.to_string(),
        });
        let clearance = outcome.min_clearance_mm;
        Self {
            reached: outcome.reached,
            time_s: quality.time_s,
            error: quality.error,
            speed_deviation: quality.speed_deviation,
            route_m: quality.route_m,
            mean_speed: quality.mean_speed,
            collisions: outcome.collisions,
            min_clearance_mm: Some(clearance).filter(|clearance| clearance.is_finite()),
            health_mode: drive.health.name(),
            events: events.collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_two_lengths() {
        assert_eq!(place("10m,-50cm"), Ok(Point::from_mm(10_000, -500)));
        for wrong in ["", "10m", "10,0", "10m;0m", "1m,2m,3m"] {
            assert!(place(wrong).is_err(), "{wrong}");
        }
    }
}
