//! One run: the robot drives until it reaches the goal or its time is over.

use super::body::Body;
use super::course::Course;
use super::pilot::{HealthMode, MapSource, PilotConfig};
use super::quality::{Quality, Sample};
use super::sensors::{NAMES, RobotSensors};
use crate::fault::{FaultSpec, SpecError};
use certainty_control::{FailureSource, Failures, SpeedLimit};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::Geometry;
use certainty_core::units::{Point, Pose, Ticks};
use core::fmt;
use std::sync::Arc;

/// Milliseconds from one control step to the next.
pub const STEP_MS: u32 = 50;

/// `T_max` of \[004\] §4, in milliseconds.
pub const LONGEST_MS: u32 = 100_000;

/// The parameters of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// The world, the start and the goal.
    pub course: Course,
    /// The sensors' faults, by the names of [`NAMES`] or their numbers.
    pub faults: Vec<FaultSpec>,
    /// Where the control level's failures come from.
    pub health: HealthMode,
    /// What the histogram is made from.
    pub map: MapSource,
    /// In what the control level differs from the default.
    pub pilot: PilotConfig,
    /// Determines the noise, the slip and random faults.
    pub seed: u64,
}

/// The robot at the end of one control step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Seconds since the start.
    pub time_s: f64,
    /// Where it is.
    pub pose: Pose,
    /// The speeds of the right and the left wheels, in m/s.
    pub wheels_m_s: (f64, f64),
    /// How fast it moves, in m/s.
    pub speed_m_s: f64,
    /// How far the goal is, in metres.
    pub distance_m: f64,
    /// How far left of straight ahead the goal is, in degrees.
    pub angle_deg: f64,
}

/// An event and its time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// Seconds since the start.
    pub time_s: f64,
    /// Its kind.
    pub what: EventKind,
}

/// A kind of event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventKind {
    /// A sensor's fault began.
    FaultBegan(&'static str),
    /// A sensor's fault ended.
    FaultEnded(&'static str),
    /// A sensor is estimated to have failed, by half at least.
    Distrusted(&'static str),
    /// It is no longer.
    TrustedAgain(&'static str),
    /// What limits the speed changed.
    SpeedLimit(SpeedLimit),
    /// The robot touched an obstacle.
    Collision,
    /// It reached the goal.
    Reached,
    /// Its time is over.
    TimeOver,
}

/// Where an event comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventSource {
    /// The simulator: it is a fact.
    Truth,
    /// The robot: its estimate, or its reaction.
    Robot,
}

impl EventKind {
    /// Returns where it comes from.
    #[must_use]
    pub const fn source(self) -> EventSource {
        match self {
            Self::FaultBegan(_)
            | Self::FaultEnded(_)
            | Self::Collision
            | Self::Reached
            | Self::TimeOver => EventSource::Truth,
            Self::Distrusted(_) | Self::TrustedAgain(_) | Self::SpeedLimit(_) => EventSource::Robot,
        }
    }
}

impl fmt::Display for EventKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FaultBegan(name) => write!(f, "{name}: fault began"),
            Self::FaultEnded(name) => write!(f, "{name}: fault ended"),
            Self::Distrusted(name) => write!(f, "{name}: no longer believed"),
            Self::TrustedAgain(name) => write!(f, "{name}: believed again"),
            Self::SpeedLimit(SpeedLimit::None) => f.write_str("goes on"),
            Self::SpeedLimit(SpeedLimit::Arrived) => f.write_str("stands: arrived"),
            Self::SpeedLimit(SpeedLimit::Slowed) => {
                f.write_str("slows: too little ahead is seen by sensors that are believed")
            }
            Self::SpeedLimit(SpeedLimit::Blind) => {
                f.write_str("stops: far too little ahead is seen by sensors that are believed")
            }
            Self::SpeedLimit(SpeedLimit::NoWay) => {
                f.write_str("turns on the spot: no direction is open")
            }
            Self::Collision => f.write_str("collision"),
            Self::Reached => f.write_str("goal reached"),
            Self::TimeOver => f.write_str("time over"),
        }
    }
}

/// The result of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Whether the goal was reached in time.
    pub reached: bool,
    /// \[004\] eq. 17 to 19.
    pub quality: Quality,
    /// How many times an obstacle was touched.
    pub collisions: u32,
    /// The least distance from the outline to an obstacle, in millimetres; infinite on an open plane.
    pub min_clearance_mm: f64,
    /// The events, in the order of their times.
    pub events: Vec<Event>,
    /// Every control step.
    pub steps: Vec<Step>,
    /// The map that the histogram was made from, as it was at the end, if it was made from one.
    pub map: Option<(Geometry, Vec<Certainty>)>,
}

impl Drive {
    /// Creates a run in `course` without any fault, as \[004\]'s simulation 1.
    #[must_use]
    pub fn new(course: Course, health: HealthMode, seed: u64) -> Self {
        Self {
            course,
            faults: Vec::new(),
            health,
            map: MapSource::Beams,
            pilot: PilotConfig::default(),
            seed,
        }
    }

    /// Drives, and returns what came of it.
    ///
    /// # Errors
    ///
    /// [`SpecError`] for a fault of a sensor that does not exist.
    pub fn run(&self) -> Result<Outcome, SpecError> {
        let Course { world, start, goal } = &self.course;
        let mut sensors = RobotSensors::new(world, &self.faults, self.seed)?;
        let rules = self.pilot.rules();
        let mut pilot = self.pilot.pilot(&self.course, self.health, self.map);
        let mut body = Body::new(*start, self.seed);
        let limits = rules.config().limits;
        let radius_m = f64::from(rules.config().goal_radius.get()) / 1000.0;
        let mut log = Log::default();
        let mut steps = Vec::new();
        let mut reached = false;
        let world = Arc::clone(world);
        for now in (0..LONGEST_MS).step_by(STEP_MS as usize) {
            let at = Ticks::new(now);
            let pose = body.pose();
            // Of the readings that are about to be taken.
            let given = sensors.failures(at);
            let readings = sensors.read(pose, at);
            let source = match self.health {
                HealthMode::Given => FailureSource::Given(given),
                HealthMode::Diagnosed => FailureSource::Diagnosed,
                HealthMode::Ignored => FailureSource::Given(Failures::NONE),
            };
            let decision = pilot.step(&readings, pose, *goal, at, source);
            log.note_failures(now, given, decision.failures, self.health);
            log.note_speed_limit(now, decision.command.speed_limit);
            let full = f64::from(limits.full_speed_mm_s);
            body.drive(&world, decision.command.wheels, full, STEP_MS);
            let step = state(&body, *goal, now + STEP_MS);
            steps.push(step);
            log.note_collisions(now + STEP_MS, body.collisions());
            if step.distance_m <= radius_m {
                reached = true;
                break;
            }
        }
        let end = steps.len() as u32 * STEP_MS;
        log.push(
            end,
            if reached {
                EventKind::Reached
            } else {
                EventKind::TimeOver
            },
        );
        let samples: Vec<Sample> = steps
            .iter()
            .map(|step| Sample {
                distance_m: step.distance_m,
                speed_m_s: step.speed_m_s,
            })
            .collect();
        Ok(Outcome {
            reached,
            quality: Quality::of(&samples, seconds(STEP_MS), reached),
            collisions: body.collisions(),
            min_clearance_mm: body.least_clearance_mm(),
            events: log.events,
            steps,
            map: pilot
                .histogram_map()
                .map(|map| (map.geometry(), map.cells())),
        })
    }
}

fn seconds(ms: u32) -> f64 {
    f64::from(ms) / 1000.0
}

fn state(body: &Body, goal: Point, now: u32) -> Step {
    let pose = body.pose();
    let (right, left) = body.wheels_mm_s();
    let angle = pose.at.bearing(goal).map_or(0.0, |bearing| {
        let off = bearing.wrapping_sub(pose.heading).to_bits().cast_signed();
        f64::from(off) / 65536.0 * 360.0
    });
    Step {
        time_s: seconds(now),
        pose,
        wheels_m_s: (right / 1000.0, left / 1000.0),
        speed_m_s: body.speed_mm_s() / 1000.0,
        distance_m: f64::from(pose.at.distance(goal).get()) / 1000.0,
        angle_deg: angle,
    }
}

/// The events so far, and the states that the next ones are changes of.
#[derive(Debug, Default)]
struct Log {
    events: Vec<Event>,
    faulty: [bool; NAMES.len()],
    distrusted: [bool; NAMES.len()],
    speed_limit: SpeedLimit,
    /// The latest one, which may be another, and for how many steps it has lasted.
    latest: (SpeedLimit, u32),
    collisions: u32,
}

impl Log {
    fn push(&mut self, now: u32, what: EventKind) {
        self.events.push(Event {
            time_s: seconds(now),
            what,
        });
    }

    fn note_failures(&mut self, now: u32, given: Failures, estimated: Failures, mode: HealthMode) {
        for (slot, faulty) in given.failed().iter().enumerate() {
            if core::mem::replace(&mut self.faulty[slot], faulty) != faulty {
                let name = NAMES[slot];
                let what = if faulty {
                    EventKind::FaultBegan(name)
                } else {
                    EventKind::FaultEnded(name)
                };
                self.push(now, what);
            }
        }
        if mode != HealthMode::Diagnosed {
            return;
        }
        for (slot, distrusted) in estimated.failed().iter().enumerate() {
            if core::mem::replace(&mut self.distrusted[slot], distrusted) != distrusted {
                let name = NAMES[slot];
                let what = if distrusted {
                    EventKind::Distrusted(name)
                } else {
                    EventKind::TrustedAgain(name)
                };
                self.push(now, what);
            }
        }
    }

    /// Notes what limits the speed, once that has lasted half a second: a robot that just reaches the speed
    /// allowed alternates between *slowed* and *none* from step to step.
    fn note_speed_limit(&mut self, now: u32, limit: SpeedLimit) {
        const LASTING_STEPS: u32 = 10;
        let steps = if limit == self.latest.0 {
            self.latest.1
        } else {
            0
        };
        self.latest = (limit, steps + 1);
        if limit == self.speed_limit || limit == SpeedLimit::Arrived {
            return;
        }
        if self.latest.1 >= LASTING_STEPS || limit == SpeedLimit::Blind {
            self.speed_limit = limit;
            self.push(now, EventKind::SpeedLimit(limit));
        }
    }

    fn note_collisions(&mut self, now: u32, collisions: u32) {
        for _ in self.collisions..collisions {
            self.push(now, EventKind::Collision);
        }
        self.collisions = collisions;
    }
}
