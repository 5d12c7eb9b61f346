//! `certainty drive`: a robot drives to its goal while its sensors fail, \[004\] §4.

use super::drive_study;
use super::maps::{metres_of, track_plan};
use super::options::{CommonOptions, Jobs, Name, OrNone, given, named};
use super::output::Failure;
use super::output::Report;
use super::table::{list, table};
use certainty_control::{FailureSharing, Wgs84};
use certainty_core::units::Point;
use certainty_repro::drive_study::Study;
use certainty_sim::export::{ExportError, OutDir, display_path};
use certainty_sim::fault::{Defect, FaultSpec, SensorName, SpecError};
use certainty_sim::plot::{Axis, Ink, Layer, Line, LineChart, Plan, Span};
use certainty_sim::quantity::{self, Excerpt};
use certainty_sim::robot::drive::{Event, EventKind, EventSource, LONGEST_MS, Step};
use certainty_sim::robot::sensors::NAMES;
use certainty_sim::robot::{
    Body, Course, Drive, HealthMode, MapSource, Memory, Outcome, PilotConfig,
};
use certainty_sim::world::{Obstacle, World};
use clap::Args;
use serde::Serialize;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The options of `certainty drive`.
#[derive(Debug, Args)]
#[command(
    mut_arg("seed", |seed| seed
        .help("Seed of noise, slip and faults; with --study of the first random course")),
    mut_arg("out", |out| out.help("Folder for the track, the charts and the tables"))
)]
pub(super) struct Arguments {
    /// World file such as host-sim/data/course.toml, which is also the default: the robot starts at 0,0
    /// and heads along +x
    #[arg(long, value_name = "FILE", conflicts_with = "study")]
    world: Option<PathBuf>,
    /// Seed of a random course, as --study drives them, in place of --world
    #[arg(long, value_name = "N", conflicts_with_all = ["world", "study"])]
    world_seed: Option<u64>,
    /// Goal
    #[arg(
        long,
        value_name = "X,Y",
        default_value = "10m,0m",
        value_parser = place,
        allow_hyphen_values = true,
        conflicts_with = "study"
    )]
    goal: Point,
    /// Goal in WGS-84, decimal degrees, north and east positive; the world's x axis points east
    #[arg(
        long,
        value_name = "LAT,LON",
        value_parser = coordinates,
        allow_hyphen_values = true,
        requires = "start_wgs84",
        conflicts_with_all = ["goal", "study"]
    )]
    goal_wgs84: Option<Wgs84>,
    /// Start in WGS-84, for --goal-wgs84
    #[arg(
        long,
        value_name = "LAT,LON",
        value_parser = coordinates,
        allow_hyphen_values = true,
        requires = "goal_wgs84"
    )]
    start_wgs84: Option<Wgs84>,
    /// Sensor without any reading: FL, OL, SL, SR, OR, FR or scanner, or none; repeatable
    #[arg(long, value_name = "SENSOR|none", conflicts_with = "study")]
    fail: Vec<OrNone<Name>>,
    /// Fault of a sensor, such as stuck-far:FL@5s, or none; repeatable
    #[arg(
        long,
        value_name = "KIND:SENSOR[=VALUE][@FROM[..TO]]|none",
        conflicts_with = "study"
    )]
    fault: Vec<OrNone<FaultSpec>>,
    /// Source of the control level's failure estimates: an oracle, the diagnosis, or none
    #[arg(
        long,
        value_name = "MODE",
        default_value = "diagnosed",
        value_parser = named(HealthMode::ALL, HealthMode::name),
        conflicts_with = "study"
    )]
    health: HealthMode,
    /// Source of the obstacles: the scanner's beams, or a certainty grid
    #[arg(
        long,
        value_name = "SOURCE",
        default_value = "beams",
        value_parser = named(MapSource::ALL, MapSource::name)
    )]
    map: MapSource,
    /// Effect of a failed rangefinder on the others: [004] eq. 14 (shared), or none (own)
    #[arg(
        long,
        value_name = "EFFECT",
        default_value = "shared",
        value_parser = named([FailureSharing::Shared, FailureSharing::Own], blame_name)
    )]
    blame: FailureSharing,
    /// Robots that keep a robust grid of trusted readings, for the directions without a reading: none as in
    /// [004], those with --health diagnosed, or all
    #[arg(
        long,
        value_name = "ROBOTS",
        default_value = "diagnosed",
        value_parser = named(Memory::ALL, Memory::name)
    )]
    memory: Memory,
    /// Allow full speed at any coverage, as the simulations of [004] do; the study has both
    #[arg(long, conflicts_with = "study")]
    bold: bool,
    /// Drive the simulations of [004], every single failure and every pair, in random courses
    #[arg(long)]
    study: bool,
    /// Number of random courses for every case of the study
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
    #[command(flatten)]
    common: CommonOptions,
}

/// Parses coordinates such as `52.2297,21.0122`, to 10⁻⁷ of a degree.
fn coordinates(text: &str) -> Result<Wgs84, String> {
    const EXPECTED: &str = "expected latitude and longitude in degrees, such as 52.2297,21.0122";
    let degrees = |text: &str| {
        let number = text.trim().parse::<f64>().ok();
        let number = number.filter(|number| number.abs() <= 180.0);
        number.map(|number| (number * 1e7).round() as i32)
    };
    let parts = text.split_once(',');
    let parsed = parts.and_then(|(north, east)| Some((degrees(north)?, degrees(east)?)));
    let (latitude_e7, longitude_e7) = parsed.ok_or(EXPECTED)?;
    Wgs84::try_new(latitude_e7, longitude_e7).map_err(|error| error.to_string())
}

/// Returns the goal in the world: `--goal`, or where `--goal-wgs84` is from `--start-wgs84` at 0,0.
fn goal(arguments: &Arguments) -> Result<Point, Failure> {
    let (Some(start), Some(goal)) = (arguments.start_wgs84, arguments.goal_wgs84) else {
        return Ok(arguments.goal);
    };
    start.local(goal).ok_or_else(|| {
        let km = Point::LIMIT / 1_000_000;
        Failure::Input(format!(
            "--goal-wgs84: the goal is more than {km} km away: expected a nearer place"
        ))
    })
}

/// Parses a place such as `10m,-50cm`.
fn place(text: &str) -> Result<Point, String> {
    let (x, y) = text
        .split_once(',')
        .ok_or("expected two lengths with a comma between, such as 10m,0m")?;
    let length = |text| quantity::signed_length(text).map_err(|error| error.to_string());
    Ok(Point::from_mm(length(x)?.get(), length(y)?.get()))
}

/// Drives and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    arguments.common.output.check()?;
    if arguments.study {
        let study = Study {
            seed: arguments.common.seed,
            worlds: arguments.worlds,
            map: arguments.map,
            pilot: pilot(arguments),
        };
        let blame = blame_name(arguments.blame);
        let output = &arguments.common.output;
        return arguments
            .jobs
            .run(|| drive_study::run(&study, blame, output))?;
    }
    if arguments.jobs.are_given() {
        let line = "--jobs: a single drive runs in one thread: expected --study too";
        return Err(Failure::Input(line.into()));
    }
    let drive = arguments.drive()?;
    let out = arguments.common.output.create()?;
    let outcome = drive.run().map_err(|error| Failure::input(&error))?;
    let written = out.write("drive.csv", |file| write_csv(&outcome, file));
    written.map_err(|error| Failure::input(&error))?;
    draw(&drive, &outcome, &out).map_err(|error| Failure::input(&error))?;
    out.finish().map_err(|error| Failure::input(&error))?;
    arguments.common.output.print(&Driven {
        out: &arguments.common.output.out,
        drive,
        outcome,
    })
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

/// Writes a line per control step.
fn write_csv(outcome: &Outcome, out: &mut dyn Write) -> io::Result<()> {
    writeln!(
        out,
        "time_s,x_mm,y_mm,heading_deg,right_m_s,left_m_s,speed_m_s,distance_m,angle_deg"
    )?;
    for step in &outcome.steps {
        let heading = quantity::degrees(step.pose.heading);
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

/// A finished drive.
struct Driven<'a> {
    out: &'a Path,
    drive: Drive,
    outcome: Outcome,
}

/// The report as JSON; its fields are a contract.
///
/// E, S, s and `v_M` as in \[004\] eq. 17 to 19. s and the time are null if the goal was not reached, the
/// clearance without obstacles.
#[derive(Debug, Serialize)]
struct Document {
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
    /// Whether readings of failed sensors were filled in from a map.
    memory: bool,
    events: Vec<EventReport>,
}

#[derive(Debug, Serialize)]
struct EventReport {
    time_s: f64,
    what: String,
}

impl Report for Driven<'_> {
    fn document(&self) -> impl Serialize {
        let Self { drive, outcome, .. } = self;
        let quality = outcome.quality;
        let events = outcome.events.iter().map(|event| EventReport {
            time_s: event.time_s,
            what: event.what.to_string(),
        });
        let clearance = outcome.min_clearance_mm;
        Document {
            reached: outcome.reached,
            time_s: quality.time_s,
            error: quality.error,
            speed_deviation: quality.speed_deviation,
            route_m: quality.route_m,
            mean_speed: quality.mean_speed,
            collisions: outcome.collisions,
            min_clearance_mm: Some(clearance).filter(|clearance| clearance.is_finite()),
            health_mode: drive.health.name(),
            memory: drive.pilot.memory.applies_to(drive.health),
            events: events.collect(),
        }
    }

    fn render(&self) -> String {
        let mut text = header(&self.drive);
        text += &events(&self.outcome.events);
        text += &rating(&self.outcome);
        text += &format!(
            "\nevery step in {}; charts in {}: drive-track, drive-speeds, drive-goal, drive-angle\n",
            display_path(&self.out.join("drive.csv")),
            display_path(self.out)
        );
        text
    }
}

impl Arguments {
    /// Returns the drive, or an error if it cannot be driven.
    fn drive(&self) -> Result<Drive, Failure> {
        let file = self.world.as_deref();
        let goal = goal(self)?;
        let course = match (file, self.world_seed) {
            (Some(file), _) => {
                let world = World::load(file).map_err(|error| Failure::input(&error))?;
                Course::to(goal, world)
            }
            (None, Some(seed)) => {
                let course = Course::random(seed);
                let course = course.map_err(|error| Failure::Internal(error.to_string()))?;
                Course { goal, ..course }
            }
            (None, None) => Course {
                goal,
                ..Course::built_in()
            },
        };
        let drive = Drive {
            course,
            faults: faults(self)?,
            health: self.health,
            map: self.map,
            pilot: pilot(self),
            seed: self.common.seed,
        };
        let name = match (file, self.world_seed) {
            (Some(file), _) => display_path(file),
            (None, Some(seed)) => format!("the course of --world-seed {seed}"),
            (None, None) => "the built-in course".into(),
        };
        check_start(&drive, &name)?;
        check_goal(&drive, &name)?;
        Ok(drive)
    }
}

/// Returns the sensors' faults: of `--fail`, then of `--fault`.
fn faults(arguments: &Arguments) -> Result<Vec<FaultSpec>, Failure> {
    let mut faults = Vec::new();
    for Name(name) in given("--fail", &arguments.fail)? {
        if SensorName::Name(name.clone()).resolve(&NAMES).is_err() {
            let excerpt = Excerpt::new(&name);
            let names = list(NAMES, ", ");
            let line =
                format!("--fail: unknown sensor '{excerpt}': expected one of {names}, or none");
            return Err(Failure::Input(line));
        }
        let dropout = format!("dropout:{name}=100%").parse();
        faults.push(dropout.map_err(|error: SpecError| Failure::input(&error))?);
    }
    for fault in given("--fault", &arguments.fault)? {
        if let Err(error) = fault.sensor.resolve(&NAMES) {
            return Err(Failure::Input(format!("--fault: {error}")));
        }
        if matches!(fault.fault.defect, Defect::Chatter(_)) {
            let line = format!(
                "--fault: {fault}: a sensor has one reading per control step, so none can chatter: \
                 expected another kind"
            );
            return Err(Failure::Input(line));
        }
        faults.push(fault);
    }
    Ok(faults)
}

/// Refuses a start inside an obstacle; `world` is its name in errors.
fn check_start(drive: &Drive, world: &str) -> Result<(), Failure> {
    let course = &drive.course;
    let body = Body::new(course.start, drive.seed);
    let Some(obstacle) = body.touched(&course.world) else {
        return Ok(());
    };
    Err(Failure::Input(format!(
        "{world}: the robot, 900mm by 600mm around 0,0, starts inside an obstacle, {obstacle}: expected \
         free space"
    )))
}

/// Refuses a goal inside an obstacle, within the goal radius of the start, or out of reach.
fn check_goal(drive: &Drive, world: &str) -> Result<(), Failure> {
    let course = &drive.course;
    let rules = drive.pilot.rules();
    let radius = rules.config().goal_radius.get();
    let refused = |why: &str| {
        let (x, y) = (course.goal.x_mm(), course.goal.y_mm());
        Err(Failure::Input(format!("--goal: {x}mm,{y}mm {why}")))
    };
    let covers = |obstacle: &&Obstacle| obstacle.clearance(course.goal) <= 0.0;
    if let Some(obstacle) = course.world.obstacles().iter().find(covers) {
        return refused(&format!(
            "is inside an obstacle of {world}, {obstacle}: expected a free place"
        ));
    }
    let away = distance_mm(course.start.at, course.goal);
    if away <= f64::from(radius) {
        return refused(&format!(
            "is within the goal radius of {radius}mm at the start: expected a place farther from 0,0"
        ));
    }
    let farthest = farthest_m(&drive.pilot);
    if away / 1e3 > farthest {
        return refused(&too_far(away / 1e3, farthest));
    }
    Ok(())
}

/// Returns the farthest distance of a goal that can be reached in time, in metres.
fn farthest_m(pilot: &PilotConfig) -> f64 {
    let rules = pilot.rules();
    let radius = rules.config().goal_radius.get();
    let full_speed = rules.config().limits.full_speed_mm_s;
    // mm/s times ms are millionths of metres.
    f64::from(full_speed) * f64::from(LONGEST_MS) / 1e6 + f64::from(radius) / 1e3
}

/// Returns the second half of the error for a goal out of reach.
fn too_far(away_m: f64, farthest_m: f64) -> String {
    let seconds = LONGEST_MS / 1000;
    format!(
        "is {away_m:.1} m away, and at full speed {seconds} s are enough for {farthest_m:.1} m: expected a \
         nearer place"
    )
}

fn distance_mm(from: Point, to: Point) -> f64 {
    let across = f64::from(to.x_mm()) - f64::from(from.x_mm());
    let upwards = f64::from(to.y_mm()) - f64::from(from.y_mm());
    across.hypot(upwards)
}

/// Draws \[004\] Fig. 6 to 9 of one run: the track over the world, and over the map if there is one
/// (Fig. 6); the wheels' speeds with the robot's and its mean (Fig. 7a to 9a); distance and angle to the goal
/// (Fig. 7b to 9b).
fn draw(drive: &Drive, outcome: &Outcome, out: &OutDir) -> Result<(), ExportError> {
    track(drive, outcome).write(out, "drive-track")?;
    let points = |value: &dyn Fn(&Step) -> f64| -> Vec<(f64, f64)> {
        let steps = outcome.steps.iter();
        steps.map(|step| (step.time_s, value(step))).collect()
    };
    let chart = |what: &str, y: Axis, lines: Vec<Line>| LineChart {
        title: title(what, drive),
        x: Axis::new("time", "s").from(0.0),
        y,
        lines,
        shaded: fault_spans(outcome),
    };
    let mean = outcome.quality.mean_speed;
    let speeds = vec![
        Line::new("v_R, right wheels", points(&|step| step.wheels_m_s.0)),
        Line::new("v_L, left wheels", points(&|step| step.wheels_m_s.1)),
        Line::new("v, the robot", points(&|step| step.speed_m_s)),
        Line::new("v_M, mean of v", points(&|_| mean)).dashed(),
    ];
    chart("Speeds", Axis::new("speed", "m/s"), speeds).write(out, "drive-speeds")?;
    let goal = vec![Line::new("distance", points(&|step| step.distance_m))];
    chart("Distance to the goal", Axis::new("e", "m").from(0.0), goal).write(out, "drive-goal")?;
    let angle = split_at_the_back(points(&|step| step.angle_deg));
    let axis = Axis::new("angle, positive to the left", "°");
    chart("Angle to the goal", axis, vec![Line::new("angle", angle)]).write(out, "drive-angle")?;
    Ok(())
}

/// Returns `points` with a gap where the goal passes behind the robot, between 180° and −180°.
fn split_at_the_back(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let mut split: Vec<(f64, f64)> = Vec::with_capacity(points.len());
    for point in points {
        if split
            .last()
            .is_some_and(|last| (last.1 - point.1).abs() > 180.0)
        {
            split.push((point.0, f64::NAN));
        }
        split.push(point);
    }
    split
}

/// Returns a figure's title: its content and the run.
fn title(what: &str, drive: &Drive) -> String {
    format!("{what}, health {}: {}", drive.health, faults_text(drive))
}

/// Renders the faults; if that is long, their number and sensors.
fn faults_text(drive: &Drive) -> String {
    /// In characters; about half of a title.
    const MOST: usize = 50;
    let faults = &drive.faults;
    if faults.is_empty() {
        return "no fault".to_owned();
    }
    let all = list(faults, ", ");
    if all.chars().count() <= MOST {
        return all;
    }
    let is_faulty = |slot: usize| {
        let mut sensors = faults
            .iter()
            .filter_map(|spec| spec.sensor.resolve(&NAMES).ok());
        sensors.any(|sensor| sensor.slot() == slot)
    };
    let names = NAMES
        .iter()
        .enumerate()
        .filter(|&(slot, _)| is_faulty(slot));
    let names = list(names.map(|(_, name)| name), ", ");
    format!("{} faults of {names}", faults.len())
}

fn track(drive: &Drive, outcome: &Outcome) -> Plan {
    let course = &drive.course;
    let mut points = vec![metres_of(course.start.at)];
    points.extend(outcome.steps.iter().map(|step| metres_of(step.pose.at)));
    let rules = drive.pilot.rules();
    track_plan(
        title("Track", drive),
        &course.world,
        outcome.map.as_ref(),
        [Layer::new("robot", Ink::Solid, vec![points])],
        course.start.at,
        (course.goal, rules.config().goal_radius.get()),
    )
}

/// Returns the times of the faults; faults of the same time share a span.
fn fault_spans(outcome: &Outcome) -> Vec<Span> {
    let end = outcome.steps.last().map_or(0.0, |step| step.time_s);
    let mut times: Vec<(f64, f64, Vec<&str>)> = Vec::new();
    for (number, event) in outcome.events.iter().enumerate() {
        let EventKind::FaultBegan(name) = event.what else {
            continue;
        };
        let later = &outcome.events[number..];
        let over = later
            .iter()
            .find(|event| event.what == EventKind::FaultEnded(name));
        let (from, to) = (event.time_s, over.map_or(end, |event| event.time_s));
        match times.iter_mut().find(|time| (time.0, time.1) == (from, to)) {
            Some((_, _, names)) => names.push(name),
            None => times.push((from, to, vec![name])),
        }
    }
    let spans = times.into_iter().map(|(from, to, names)| Span {
        from,
        to,
        label: format!("fault of {}", list(names, ", ")),
    });
    spans.collect()
}

/// Renders the options of the run.
fn header(drive: &Drive) -> String {
    let faults = list(&drive.faults, " ");
    let pilot = drive.pilot;
    let idle = pilot.memory != Memory::Nobody && !pilot.memory.applies_to(drive.health);
    let memory = if idle {
        " (not used by this robot)"
    } else {
        ""
    };
    let bold = if pilot.bold {
        "   bold: full speed at any coverage"
    } else {
        ""
    };
    format!(
        "world: {}   goal: {}mm,{}mm   seed: {}\nfaults: {faults}\n\
         health: {}   memory: {}{memory}   blame: {}   obstacles from: {}{bold}\n\n",
        Excerpt::new(drive.course.world.name()),
        drive.course.goal.x_mm(),
        drive.course.goal.y_mm(),
        drive.seed,
        drive.health,
        pilot.memory.name(),
        blame_name(pilot.sharing),
        drive.map,
    )
}

/// Renders the events, each with its source.
fn events(events: &[Event]) -> String {
    /// Most lines; the JSON document has every event.
    const MOST: usize = 30;
    let mut text = String::from(
        "source of an event: truth is the simulator, robot is its estimate or action\n",
    );
    for event in events.iter().take(MOST) {
        let source = match event.what.source() {
            EventSource::Truth => "truth",
            EventSource::Robot => "robot",
        };
        text += &format!("{:7.2} s  {source}  {}\n", event.time_s, event.what);
    }
    if events.len() > MOST {
        text += &format!("           and {} more\n", events.len() - MOST);
    }
    text.push('\n');
    text
}

/// Renders \[004\] eq. 17 to 19 and the collisions.
fn rating(outcome: &Outcome) -> String {
    let quality = outcome.quality;
    let reached = if outcome.reached { "yes" } else { "no" };
    let to_goal = |value: Option<f64>, unit: &str| {
        value.map_or("-".to_owned(), |value| format!("{value:.2} {unit}"))
    };
    let clearance = Some(outcome.min_clearance_mm).filter(|clearance| clearance.is_finite());
    let rows = [
        ("goal reached", reached.to_owned()),
        ("T, time to the goal", to_goal(quality.time_s, "s")),
        (
            "E, squared distance to the goal over time",
            format!("{:.1} m² s", quality.error),
        ),
        (
            "S, standard deviation of the speed",
            format!("{:.3} m/s", quality.speed_deviation),
        ),
        ("s, path to the goal", to_goal(quality.route_m, "m")),
        ("v_M, mean speed", format!("{:.3} m/s", quality.mean_speed)),
        ("collisions", outcome.collisions.to_string()),
        (
            "least clearance",
            clearance.map_or("-".to_owned(), |clearance| format!("{clearance:.0} mm")),
        ),
    ];
    table(&rows.map(|(what, value)| vec![what.to_owned(), value]))
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

    #[test]
    fn an_angle_has_a_gap_behind_the_robot() {
        let split = split_at_the_back(vec![(0.0, 170.0), (1.0, -175.0), (2.0, 5.0), (3.0, 179.0)]);
        assert!(split[1].1.is_nan());
        let kept: Vec<f64> = split.iter().map(|point| point.1).collect();
        assert_eq!((kept[0], &kept[2..]), (170.0, &[-175.0, 5.0, 179.0][..]));
    }

    #[test]
    fn a_title_has_few_faults_or_their_sensors() {
        let mut drive = Drive::new(Course::built_in(), HealthMode::Given, 1);
        assert_eq!(title("Track", &drive), "Track, health given: no fault");
        drive.faults = vec!["stuck-far:FL@5s".parse().unwrap()];
        assert_eq!(
            title("Track", &drive),
            "Track, health given: stuck-far:FL@5000ms"
        );
        let many = ["scanner", "2", "FL", "FR"].map(|name| format!("dropout:{name}=100%"));
        drive.faults = many.iter().map(|text| text.parse().unwrap()).collect();
        let expected = "Track, health given: 4 faults of FL, OL, FR, scanner";
        assert_eq!(title("Track", &drive), expected);
    }

    #[test]
    fn faults_of_the_same_time_share_a_span() {
        let mut drive = Drive::new(Course::built_in(), HealthMode::Given, 1);
        let specs = ["dropout:FL=100%", "dropout:SR=100%", "stuck-far:OL@1s"];
        drive.faults = specs.map(|text| text.parse().unwrap()).into();
        let spans = fault_spans(&drive.run().unwrap());
        let labels: Vec<&str> = spans.iter().map(|span| span.label.as_str()).collect();
        assert_eq!(labels, ["fault of FL, SR", "fault of OL"]);
    }

    #[test]
    fn the_header_has_every_option() {
        let mut drive = Drive::new(Course::built_in(), HealthMode::Given, 4);
        drive.pilot.bold = true;
        let text = header(&drive);
        for part in [
            "goal: 10000mm,0mm   seed: 4",
            "faults: none",
            "health: given   memory: diagnosed (not used by this robot)   blame: shared",
            "obstacles from: beams   bold",
        ] {
            assert!(text.contains(part), "no {part} in {text}");
        }
        drive.health = HealthMode::Diagnosed;
        assert!(!header(&drive).contains("not used"));
    }

    #[test]
    fn a_worlds_name_is_escaped() {
        let world = World::new("red \u{1b}[31m\nworld", Vec::new());
        let course = Course::to(Course::built_in().goal, world);
        let text = header(&Drive::new(course, HealthMode::Given, 1));
        assert!(
            text.starts_with("world: red \\u{1b}[31m\\nworld   goal"),
            "{text}"
        );
    }

    #[test]
    fn an_event_has_its_source() {
        let event = |what| Event { time_s: 5.0, what };
        let text = events(&[
            event(EventKind::FaultBegan("FL")),
            event(EventKind::Distrusted("FL")),
        ]);
        let lines: Vec<&str> = text.lines().skip(1).collect();
        let expected = [
            "   5.00 s  truth  FL: fault began",
            "   5.00 s  robot  FL: no longer believed",
            "",
        ];
        assert_eq!(lines, expected);
        let many = events(&[event(EventKind::Collision); 31]);
        assert!(many.contains("and 1 more"));
    }
}
