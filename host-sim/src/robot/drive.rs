//! One run: the robot drives until it reaches the goal or its time is over; \[004\] eq. 17 to 19 rate it.

use super::body::Body;
use super::course::Course;
use super::pilot::{HealthMode, MapSource, PilotConfig};
use super::sensors::{NAMES, RobotSensors};
use crate::fault::{FaultSpec, SpecError};
use crate::quantity;
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
    /// Source of the control level's failure estimates.
    pub health: HealthMode,
    /// Source of the obstacles in the histogram.
    pub map: MapSource,
    /// Settings of the control level that differ from the default.
    pub pilot: PilotConfig,
    /// Seed of the noise, the slip and random faults.
    pub seed: u64,
}

/// The robot at the end of one control step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Seconds since the start.
    pub time_s: f64,
    /// Its pose.
    pub pose: Pose,
    /// The speeds of the right and the left wheels, in m/s.
    pub wheels_m_s: (f64, f64),
    /// Its speed over the ground, in m/s.
    pub speed_m_s: f64,
    /// Distance to the goal, in metres.
    pub distance_m: f64,
    /// Angle to the goal, in degrees, positive to the left: −180 to less than 180.
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
    /// The robot's estimate of a sensor's failure rose to a half or more.
    Distrusted(&'static str),
    /// The robot's estimate of a sensor's failure fell below a half.
    TrustedAgain(&'static str),
    /// The limit of the speed changed.
    SpeedLimit(SpeedLimit),
    /// The robot touched an obstacle.
    Collision,
    /// It reached the goal.
    Reached,
    /// The longest time of a run is over.
    TimeOver,
}

/// The source of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventSource {
    /// The simulator: true.
    Truth,
    /// The robot: its estimate or its action.
    Robot,
}

impl EventKind {
    /// Returns its source.
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

/// The quality rates of \[004\] §4; smaller is better, except for the mean speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// E of eq. 17: Σ e² Δt, in m² s.
    pub error: f64,
    /// S of eq. 18: the standard deviation of the speed, in m/s; 0 for a single step.
    pub speed_deviation: f64,
    /// s of eq. 19: Σ v Δt, in metres; `None` if the goal was not reached, for which \[004\] writes +∞.
    pub route_m: Option<f64>,
    /// T: the duration, in seconds; `None` if the goal was not reached.
    pub time_s: Option<f64>,
    /// `v_M`: the mean speed, in m/s.
    pub mean_speed: f64,
}

impl Quality {
    /// Rates a run of `steps`, one every `step_s` seconds; `reached` is whether it reached its goal.
    #[must_use]
    pub fn of(steps: &[Step], step_s: f64, reached: bool) -> Self {
        let count = steps.len().max(1) as f64;
        let sum = |value: &dyn Fn(&Step) -> f64| steps.iter().map(value).sum::<f64>();
        let mean_speed = sum(&|step| step.speed_m_s) / count;
        let squares = sum(&|step| (step.speed_m_s - mean_speed).powi(2));
        Self {
            error: sum(&|step| step.distance_m * step.distance_m) * step_s,
            speed_deviation: (squares / (count - 1.0).max(1.0)).sqrt(),
            route_m: reached.then(|| sum(&|step| step.speed_m_s) * step_s),
            time_s: reached.then_some(steps.len() as f64 * step_s),
            mean_speed,
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
    /// Number of collisions with an obstacle.
    pub collisions: u32,
    /// The least distance from the outline to an obstacle, in millimetres; infinite on an open plane.
    pub min_clearance_mm: f64,
    /// The events, in the order of their times.
    pub events: Vec<Event>,
    /// Every control step.
    pub steps: Vec<Step>,
    /// The map at the end of the run, if the histogram was made from one.
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

    /// Drives until the goal is reached or [`LONGEST_MS`] are over.
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
            // Before the readings, because a fault's window counts them.
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
        Ok(Outcome {
            reached,
            quality: Quality::of(&steps, seconds(STEP_MS), reached),
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
        quantity::signed_degrees(bearing.wrapping_sub(pose.heading))
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

/// The events, and the last noted state of everything that can change.
#[derive(Debug, Default)]
struct Log {
    events: Vec<Event>,
    faulty: [bool; NAMES.len()],
    distrusted: [bool; NAMES.len()],
    speed_limit: SpeedLimit,
    /// The limit in the latest step, and the number of steps that it has lasted.
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

    /// Notes a new limit of the speed after half a second, *blind* at once: a robot whose speed is near the
    /// allowed one alternates between *slowed* and *none* from step to step.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn step(distance_m: f64, speed_m_s: f64) -> Step {
        Step {
            time_s: 0.0,
            pose: Pose::default(),
            wheels_m_s: (speed_m_s, speed_m_s),
            speed_m_s,
            distance_m,
            angle_deg: 0.0,
        }
    }

    #[test]
    fn the_rates_are_those_of_eq_17_to_19() {
        let run = [step(3.0, 0.5), step(2.0, 1.5), step(1.0, 1.0)];
        let quality = Quality::of(&run, 0.5, true);
        assert_eq!(quality.error, 7.0); // (9 + 4 + 1) / 2
        assert_eq!(quality.speed_deviation, 0.5); // √((0.25 + 0.25 + 0) / 2)
        assert_eq!((quality.route_m, quality.time_s), (Some(1.5), Some(1.5)));
        assert_eq!(quality.mean_speed, 1.0);
    }

    #[test]
    fn a_goal_not_reached_has_no_route_and_no_time() {
        let quality = Quality::of(&[step(2.0, 0.0); 4], 0.25, false);
        assert_eq!((quality.route_m, quality.time_s), (None, None));
        assert_eq!(
            (quality.error, quality.speed_deviation, quality.mean_speed),
            (4.0, 0.0, 0.0)
        );
    }
}
