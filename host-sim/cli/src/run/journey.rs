//! How the car drove: what it reported, what truly happened, and the picture of both.

use super::super::outlines;
use certainty_core::certainty::Certainty;
use certainty_core::fusion::Geometry;
use certainty_core::units::Pose;
use certainty_firmware::digest::Digest;
use certainty_firmware::smart_car::{CONTROL, GOAL, POSE};
use certainty_firmware::telemetry::Drive;
use certainty_sim::backend::Received;
use certainty_sim::bench::GroundTruth;
use certainty_sim::export::{ExportError, OutDir};
use certainty_sim::plot::{Line, Spot, TrackChart};
use certainty_sim::world::World;
use serde::Serialize;
use std::path::PathBuf;

/// The journey as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
pub(super) struct JourneyReport {
    /// Whether the car truly is within the goal's radius.
    reached: bool,
    /// What the car last said of its driving.
    conduct: Option<String>,
    /// Rounds in which it moved.
    rounds_moved: usize,
    collisions: u32,
    goal_x_mm: i32,
    goal_y_mm: i32,
    goal_radius_mm: u32,
    /// Where the car believes to be.
    believed: Place,
    /// Where it is.
    truly: Place,
    /// Eight hexadecimal digits over every round's pose, believed and true, and what the wheels were told.
    track_hash: String,
}

/// A pose, and how far the goal is from there.
#[derive(Debug, Serialize)]
struct Place {
    x_mm: i32,
    y_mm: i32,
    heading_deg: f64,
    to_goal_mm: u32,
}

impl From<Pose> for Place {
    fn from(pose: Pose) -> Self {
        Self {
            x_mm: pose.at.x_mm(),
            y_mm: pose.at.y_mm(),
            heading_deg: f64::from(pose.heading.to_bits()) * 360.0 / 65536.0,
            to_goal_mm: pose.at.distance(GOAL).get(),
        }
    }
}

/// What is known of a journey.
#[derive(Debug, Clone, Copy)]
pub(super) struct Journey<'a> {
    drives: &'a [Drive],
    stages: &'a [GroundTruth],
}

impl<'a> Journey<'a> {
    pub(super) fn new(received: &'a Received, stages: &'a [GroundTruth]) -> Self {
        let drives = received.drives();
        Self { drives, stages }
    }

    /// Where the car truly was in a round, from 0.
    pub(super) fn pose(&self, round: u32) -> Pose {
        let stage = self.stages.get(round as usize).or(self.stages.last());
        stage.map_or(POSE, |stage| stage.pose)
    }

    fn rounds_moved(&self) -> usize {
        let pairs = self.stages.iter().zip(self.stages.iter().skip(1));
        pairs.filter(|(a, b)| a.pose != b.pose).count()
    }

    pub(super) fn report(&self) -> JourneyReport {
        let last = self.drives.last();
        let stage = self.stages.last();
        let truly = Place::from(stage.map_or(POSE, |stage| stage.pose));
        let goal_radius = CONTROL.config().goal_radius;
        JourneyReport {
            reached: truly.to_goal_mm <= goal_radius.get(),
            conduct: last.map(|drive| drive.conduct.to_string()),
            rounds_moved: self.rounds_moved(),
            collisions: stage.map_or(0, |stage| stage.collisions),
            goal_x_mm: GOAL.x_mm(),
            goal_y_mm: GOAL.y_mm(),
            goal_radius_mm: goal_radius.get(),
            believed: last.map_or(POSE, |drive| drive.pose).into(),
            truly,
            track_hash: format!("{:08x}", self.hash()),
        }
    }

    fn hash(&self) -> u32 {
        let mut digest = Digest::NEW;
        let believed = self.drives.iter().map(|drive| drive.pose);
        for pose in believed.chain(self.stages.iter().map(|stage| stage.pose)) {
            digest.word(pose.at.x_mm().cast_unsigned());
            digest.word(pose.at.y_mm().cast_unsigned());
            digest.word(pose.heading.to_bits().into());
        }
        for wheels in self.drives.iter().map(|drive| drive.wheels) {
            digest.word(wheels.right.to_bits().cast_unsigned());
            digest.word(wheels.left.to_bits().cast_unsigned());
        }
        digest.value()
    }

    /// The journey in a line for people.
    pub(super) fn told(&self) -> String {
        let report = self.report();
        let conduct = report.conduct.unwrap_or_else(|| "not heard of".into());
        format!(
            "drive: {conduct}; moved in {} rounds; the goal is {}mm away ({}mm by the car's own reckoning), \
             {}; {} collisions; track {}\n",
            report.rounds_moved,
            report.truly.to_goal_mm,
            report.believed.to_goal_mm,
            if report.reached {
                "reached"
            } else {
                "not reached"
            },
            report.collisions,
            report.track_hash
        )
    }

    /// Draws the way over the world and the map, if the car has moved.
    pub(super) fn draw(
        &self,
        world: &World,
        map: Option<&(Geometry, Vec<Certainty>)>,
        out: &OutDir,
    ) -> Result<Vec<PathBuf>, ExportError> {
        if self.rounds_moved() == 0 {
            return Ok(Vec::new());
        }
        let cells = map.map(|(geometry, cells)| outlines::of_map(geometry, cells));
        let truly = self.stages.iter().map(|stage| stage.pose);
        let believed = self.drives.iter().map(|drive| drive.pose);
        let line = |name: &str, poses: &mut dyn Iterator<Item = Pose>| {
            Line::new(name, poses.map(|pose| outlines::at(pose.at)).collect())
        };
        let radius = CONTROL.config().goal_radius.get();
        let chart = TrackChart {
            title: "Track of the Smart Car".into(),
            unit: "m".into(),
            obstacles: outlines::of_world(world),
            cells: cells.unwrap_or_default(),
            tracks: vec![
                line("car", &mut { truly }),
                line("its own reckoning", &mut { believed }).dashed(),
            ],
            spots: vec![
                Spot::new("start", outlines::at(POSE.at)),
                Spot::new(&format!("goal (within {radius}mm)"), outlines::at(GOAL))
                    .within(f64::from(radius) / 1000.0),
            ],
        };
        chart.write(out, "run-track").map(Vec::from)
    }
}
