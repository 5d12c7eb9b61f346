//! From the arguments to the run: what cannot be driven is refused before anything is.

use super::super::Failure;
use super::super::or_none::{self, Name};
use super::Arguments;
use certainty_core::units::Point;
use certainty_sim::export::shown;
use certainty_sim::fault::{Defect, FaultSpec, SensorName, SpecError};
use certainty_sim::quantity;
use certainty_sim::robot::drive::LONGEST_MS;
use certainty_sim::robot::sensors::NAMES;
use certainty_sim::robot::{Body, Course, Drive};
use certainty_sim::world::{Obstacle, World};
use std::path::Path;

/// The run that the arguments ask for.
pub(super) fn asked(arguments: &Arguments) -> Result<Drive, Failure> {
    let file = arguments.world.as_deref();
    let course = match file {
        Some(file) => {
            let world = World::load(file).map_err(|error| Failure::input(&error))?;
            Course::to(arguments.goal, world)
        }
        None => Course {
            goal: arguments.goal,
            ..Course::built_in()
        },
    };
    let drive = Drive {
        course,
        faults: faults(arguments)?,
        health: arguments.health,
        map: arguments.map,
        pilot: super::pilot(arguments),
        seed: arguments.seed,
    };
    check_start(&drive, file)?;
    check_goal(&drive, file)?;
    Ok(drive)
}

/// What befalls the sensors: those that fail whole, and the rest.
fn faults(arguments: &Arguments) -> Result<Vec<FaultSpec>, Failure> {
    let mut faults = Vec::new();
    for Name(name) in or_none::given("--fail", &arguments.fail)? {
        if SensorName::Name(name.clone()).resolve(&NAMES).is_err() {
            let shown = quantity::Excerpt::new(&name);
            let names = NAMES.join(", ");
            let line = format!("--fail: no sensor '{shown}': write one of {names}, or none");
            return Err(Failure::Input(line));
        }
        let silent = format!("dropout:{name}=100%").parse();
        faults.push(silent.map_err(|error: SpecError| Failure::input(&error))?);
    }
    for fault in or_none::given("--fault", &arguments.fault)? {
        if let Err(error) = fault.sensor.resolve(&NAMES) {
            return Err(Failure::Input(format!("--fault: {error}")));
        }
        if matches!(fault.fault.defect, Defect::Chatter(_)) {
            let line = format!(
                "--fault: {fault}: every sensor is asked once a control step, so none can chatter; \
                 write another kind"
            );
            return Err(Failure::Input(line));
        }
        faults.push(fault);
    }
    Ok(faults)
}

/// The world as a complaint calls it.
fn called(file: Option<&Path>) -> String {
    file.map_or_else(|| "the built-in course".to_owned(), shown)
}

fn check_start(drive: &Drive, file: Option<&Path>) -> Result<(), Failure> {
    let course = &drive.course;
    let body = Body::new(course.start, drive.seed);
    let touched = |obstacle: &&Obstacle| body.touches(&World::new("", vec![**obstacle]));
    let Some(obstacle) = course.world.obstacles().iter().find(touched) else {
        return Ok(());
    };
    Err(Failure::Input(format!(
        "{}: the robot, 900mm by 600mm around 0,0, starts inside an obstacle, {obstacle}; move it",
        called(file)
    )))
}

/// Refuses a goal that no drive can tell anything about.
fn check_goal(drive: &Drive, file: Option<&Path>) -> Result<(), Failure> {
    let course = &drive.course;
    let rules = drive.pilot.rules();
    let radius = rules.config().goal_radius.get();
    let full_speed = rules.config().limits.full_speed_mm_s;
    let refused = |why: &str| {
        let (x, y) = (course.goal.x_mm(), course.goal.y_mm());
        Err(Failure::Input(format!("--goal: {x}mm,{y}mm {why}")))
    };
    let covers = |obstacle: &&Obstacle| obstacle.clearance(course.goal) <= 0.0;
    if let Some(obstacle) = course.world.obstacles().iter().find(covers) {
        let world = called(file);
        return refused(&format!(
            "is inside an obstacle of {world}, {obstacle}; name a free place"
        ));
    }
    let away = distance_mm(course.start.at, course.goal);
    if away <= f64::from(radius) {
        return refused(&format!(
            "is reached at the start already, as {radius}mm away counts; name a place farther from 0,0"
        ));
    }
    // Metres: millimetres a second for milliseconds are millionths of them.
    let farthest = f64::from(full_speed) * f64::from(LONGEST_MS) / 1e6 + f64::from(radius) / 1e3;
    if away / 1e3 > farthest {
        let seconds = LONGEST_MS / 1000;
        return refused(&format!(
            "is {:.1} m away, and at full speed {seconds} s are enough for {farthest:.1} m; name a nearer \
             place",
            away / 1e3
        ));
    }
    Ok(())
}

fn distance_mm(from: Point, to: Point) -> f64 {
    let across = f64::from(to.x_mm()) - f64::from(from.x_mm());
    let upwards = f64::from(to.y_mm()) - f64::from(from.y_mm());
    across.hypot(upwards)
}
