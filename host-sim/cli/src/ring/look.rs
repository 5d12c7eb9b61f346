//! One look around.

use super::super::table::{row, table};
use super::super::{Failure, output};
use super::{Arguments, listed, numbers};
use certainty_core::units::{BinaryAngle, Point, Pose};
use certainty_ring::{ElementKind, Joint};
use certainty_sim::export::{OutDir, shown};
use certainty_sim::quantity::Excerpt;
use certainty_sim::ring::{Judged, Observation, Vectors, draw};
use certainty_sim::world::World;
use serde::Serialize;
use std::path::PathBuf;

/// Where the robot stands in the office unless it is told.
const MIDDLE: Pose = Pose::new(
    Point::from_mm(2200, 2300),
    BinaryAngle::from_millidegrees(10_000),
);

/// The report as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct Report {
    seed: u64,
    world: String,
    pose: PoseReport,
    faults: Vec<String>,
    rules: &'static str,
    faulty: Vec<u8>,
    vectors: Vectors,
    verdicts: Vec<String>,
    polygon: PolygonReport,
    files: Vec<String>,
}

#[derive(Debug, Serialize)]
struct PoseReport {
    x_mm: i32,
    y_mm: i32,
    heading_deg: f64,
}

#[derive(Debug, Serialize)]
struct PolygonReport {
    beams: usize,
    walls: usize,
    pseudo: usize,
    corners: usize,
    edges: usize,
}

impl PolygonReport {
    fn of(observation: &Observation) -> Self {
        let elements = observation.polygon.elements();
        let of = |kind| elements.iter().filter(|e| e.kind() == kind).count();
        let joints = |joint| elements.iter().filter(|e| e.joint() == joint).count();
        Self {
            beams: observation.scan.points().len(),
            walls: of(ElementKind::Wall),
            pseudo: of(ElementKind::Pseudo),
            corners: joints(Joint::Corner),
            edges: joints(Joint::Edge),
        }
    }
}

pub(super) fn run(arguments: &Arguments, world: &World) -> Result<(), Failure> {
    let robot = match arguments.pose {
        Some(pose) => pose,
        None if arguments.world.is_none() => MIDDLE,
        None => {
            let line = "--pose: a world of your own needs one, such as --pose 2.5m,1.8m,30deg";
            return Err(Failure::Input(line.into()));
        }
    };
    if world.occupied(robot.at) {
        let (x, y) = (robot.at.x_mm(), robot.at.y_mm());
        let line = format!("--pose: an obstacle covers {x}mm,{y}mm; name a free place");
        return Err(Failure::Input(line));
    }
    let situation = arguments.situation(world);
    let observation = situation.observe(robot, &arguments.faults, arguments.seed, 0);
    let observation = observation.map_err(|error| {
        Failure::Input(format!("{}: {error}; use fewer obstacles", world.name()))
    })?;
    let judged = situation.judge(&observation);
    let out = OutDir::create(&arguments.out).map_err(|error| Failure::input(&error))?;
    let files = draw(&situation, &observation, &judged, &out);
    let files = files.map_err(|error| Failure::input(&error))?;
    if arguments.json {
        output::print_json(&report(
            arguments,
            world,
            robot,
            &observation,
            &judged,
            &files,
        ))
    } else {
        output::print(&told(arguments, world, robot, &observation, &judged))
    }
}

fn faulty(judged: &Judged) -> Vec<u8> {
    judged.assessment.faulty().map(|id| id.number()).collect()
}

fn report(
    arguments: &Arguments,
    world: &World,
    robot: Pose,
    observation: &Observation,
    judged: &Judged,
    files: &[PathBuf],
) -> Report {
    let verdicts = judged.assessment.verdicts().iter();
    Report {
        seed: arguments.seed,
        world: world.name().to_owned(),
        pose: PoseReport {
            x_mm: robot.at.x_mm(),
            y_mm: robot.at.y_mm(),
            heading_deg: f64::from(robot.heading.to_bits()) * 360.0 / 65536.0,
        },
        faults: arguments.faults.iter().map(ToString::to_string).collect(),
        rules: arguments.rules.name(),
        faulty: faulty(judged),
        vectors: Vectors::of(judged),
        verdicts: verdicts.map(ToString::to_string).collect(),
        polygon: PolygonReport::of(observation),
        files: output::listed(files),
    }
}

fn told(
    arguments: &Arguments,
    world: &World,
    robot: Pose,
    observation: &Observation,
    judged: &Judged,
) -> String {
    let faults: Vec<String> = arguments.faults.iter().map(ToString::to_string).collect();
    let faults = if faults.is_empty() {
        "none".to_owned()
    } else {
        faults.join(", ")
    };
    let polygon = PolygonReport::of(observation);
    let mut text = format!(
        "world: {}   robot: {}mm, {}mm, {:.1}deg   seed: {}   rules: {}\nfault: {faults}\n\
         polygon of {} beams: {} walls, {} pseudo line segments, {} corners, {} edges\n\n",
        Excerpt::new(world.name()),
        robot.at.x_mm(),
        robot.at.y_mm(),
        f64::from(robot.heading.to_bits()) * 360.0 / 65536.0,
        arguments.seed,
        arguments.rules.name(),
        polygon.beams,
        polygon.walls,
        polygon.pseudo,
        polygon.corners,
        polygon.edges,
    );
    let vectors = Vectors::of(judged);
    let mut rows = vec![row([
        "sonar",
        "simulation",
        "intersection",
        "overall",
        "verdict",
    ])];
    let verdicts = judged.assessment.verdicts();
    for (slot, number) in numbers().enumerate() {
        rows.push(vec![
            number,
            vectors.simulation_based[slot].to_string(),
            vectors.intersection_based[slot].to_string(),
            vectors.overall[slot].to_string(),
            verdicts[slot].to_string(),
        ]);
    }
    text += &table(&rows);
    text += &format!(
        "\nfaulty: {}\npictures: {}/ring-*.png, .svg\n",
        listed(&faulty(judged)),
        shown(&arguments.out)
    );
    text
}
