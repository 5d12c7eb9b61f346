//! One run: the robot drives until it is there or its time is over.

use super::body::Body;
use super::course::Course;
use super::diagnosis::broken;
use super::modes::{HealthMode, MapSource};
use super::pilot::{Pilot, PilotConfig};
use super::quality::{Quality, Sample};
use super::sensors::{NAMES, RobotSensors};
use crate::fault::{FaultSpec, SpecError};
use certainty_control::{Failures, SpeedLimit};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::Geometry;
use certainty_core::units::{Point, Pose, Ticks};
use core::fmt;
use std::sync::Arc;

/// Milliseconds from one control step to the next.
pub const STEP_MS: u32 = 50;

/// `T_max` of \[004\] §4, in milliseconds.
pub const LONGEST_MS: u32 = 100_000;

/// A run, before it is made.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// Where.
    pub course: Course,
    /// What befalls the sensors, by the names of [`NAMES`] or their numbers.
    pub faults: Vec<FaultSpec>,
    /// Who tells the control level of it.
    pub health: HealthMode,
    /// What the histogram is made from.
    pub map: MapSource,
    /// What of the core's rules is otherwise.
    pub manner: PilotConfig,
    /// Names the noise, the slip and the faults' whims.
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

/// What happened, and when.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// Seconds since the start.
    pub time_s: f64,
    /// What.
    pub what: Happening,
}

/// What can happen on the way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Happening {
    /// A sensor's fault began.
    FaultBegan(&'static str),
    /// A sensor's fault ended.
    FaultEnded(&'static str),
    /// A sensor is believed to have failed, by half at least.
    Distrusted(&'static str),
    /// It is not any more.
    TrustedAgain(&'static str),
    /// What held the robot back changed.
    SpeedLimit(SpeedLimit),
    /// It touched an obstacle.
    Collision,
    /// It is there.
    Reached,
    /// Its time is over.
    TimeOver,
}

/// Whose word an event is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventSource {
    /// The simulator's, which knows.
    Truth,
    /// The robot's: what it believes, and what it does for that.
    Robot,
}

impl Happening {
    /// Returns whose word it is.
    #[must_use]
    pub const fn voice(self) -> EventSource {
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

impl fmt::Display for Happening {
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

/// What a run came to.
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
    /// What happened.
    pub events: Vec<Event>,
    /// Every control step.
    pub steps: Vec<Step>,
    /// The map that the histogram was made from at the end, if it was.
    pub map: Option<(Geometry, Vec<Certainty>)>,
}

impl Drive {
    /// The run in `course` without any fault, as \[004\]'s simulation 1.
    #[must_use]
    pub fn new(course: Course, health: HealthMode, seed: u64) -> Self {
        Self {
            course,
            faults: Vec::new(),
            health,
            map: MapSource::Beams,
            manner: PilotConfig::default(),
            seed,
        }
    }

    /// Drives.
    ///
    /// # Errors
    ///
    /// [`SpecError`] for a fault of a sensor that is not there.
    pub fn run(&self) -> Result<Outcome, SpecError> {
        let Course { world, start, goal } = &self.course;
        let mut sensors = RobotSensors::new(world, &self.faults, self.seed)?;
        let rules = self.manner.rules();
        let mut pilot = Pilot::new(&self.course, self.manner, self.health, self.map);
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
            let glance = sensors.look(pose, at);
            let decision = pilot.decide(&glance, pose, *goal, at, given);
            log.note_failures(now, given, decision.failures, self.health);
            log.note_caution(now, decision.command.caution);
            let full = f64::from(limits.full_speed_mm_s);
            body.drive(&world, decision.command.wheels, full, STEP_MS);
            let step = seen(&body, *goal, now + STEP_MS);
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
                Happening::Reached
            } else {
                Happening::TimeOver
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
            map: pilot.map().map(|map| (map.geometry(), map.cells())),
        })
    }
}

fn seconds(ms: u32) -> f64 {
    f64::from(ms) / 1000.0
}

fn seen(body: &Body, goal: Point, now: u32) -> Step {
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

/// What happened so far, and what it is compared with.
#[derive(Debug, Default)]
struct Log {
    events: Vec<Event>,
    faulty: [bool; NAMES.len()],
    distrusted: [bool; NAMES.len()],
    caution: SpeedLimit,
    /// Another one, and for how many steps it has been that.
    other: (SpeedLimit, u32),
    collisions: u32,
}

impl Log {
    fn push(&mut self, now: u32, what: Happening) {
        self.events.push(Event {
            time_s: seconds(now),
            what,
        });
    }

    fn note_failures(&mut self, now: u32, given: Failures, believed: Failures, mode: HealthMode) {
        let all = |failures: Failures| broken(&failures).into_iter().enumerate();
        for (slot, faulty) in all(given) {
            if core::mem::replace(&mut self.faulty[slot], faulty) != faulty {
                let name = NAMES[slot];
                let what = if faulty {
                    Happening::FaultBegan(name)
                } else {
                    Happening::FaultEnded(name)
                };
                self.push(now, what);
            }
        }
        if mode != HealthMode::Diagnosed {
            return;
        }
        for (slot, distrusted) in all(believed) {
            if core::mem::replace(&mut self.distrusted[slot], distrusted) != distrusted {
                let name = NAMES[slot];
                let what = if distrusted {
                    Happening::Distrusted(name)
                } else {
                    Happening::TrustedAgain(name)
                };
                self.push(now, what);
            }
        }
    }

    /// Notes what holds the robot back, once that has lasted half a second: a robot that could go just as
    /// fast as it may changes from *slowed* to not at every step.
    fn note_caution(&mut self, now: u32, caution: SpeedLimit) {
        const LASTING_STEPS: u32 = 10;
        let steps = if caution == self.other.0 {
            self.other.1
        } else {
            0
        };
        self.other = (caution, steps + 1);
        if caution == self.caution || caution == SpeedLimit::Arrived {
            return;
        }
        if self.other.1 >= LASTING_STEPS || caution == SpeedLimit::Blind {
            self.caution = caution;
            self.push(now, Happening::SpeedLimit(caution));
        }
    }

    fn note_collisions(&mut self, now: u32, collisions: u32) {
        for _ in self.collisions..collisions {
            self.push(now, Happening::Collision);
        }
        self.collisions = collisions;
    }
}
