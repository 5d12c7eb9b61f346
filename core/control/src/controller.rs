//! All behaviours together: \[004\] eq. 1.

use super::braitenberg::PerRangefinder;
use super::histogram::PerBeam;
use super::motion::{HALF, scaled};
use super::nearness::{distance, in_the_way, nearness};
use super::{
    Blame, ControlConfig, ControlRules, Coverage, CoverageConfig, Credibility, Effort, Failure,
    Failures, Motion, PolarHistogram, Side, Valley, Wheels, azimuth_turn, linear_speed,
};
use certainty_core::transducer::{Missing, Reading};
use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose, Ticks};
use core::borrow::Borrow;

/// A reading and when it was taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Stamped<T> {
    /// What was read.
    pub what: T,
    /// When.
    pub at: Ticks,
}

/// What the controller is told at one step.
#[derive(Debug, Clone, Copy)]
pub struct ControlInput<'a> {
    /// The time.
    pub now: Ticks,
    /// Where the robot is, and which way it looks.
    pub pose: Pose,
    /// Where it shall be.
    pub goal: Point,
    /// The rangefinders' last readings.
    pub rangefinders: PerRangefinder<Stamped<Reading>>,
    /// The scanner's last scan, or what [`scan_of_map`](super::scan_of_map) sees in its place.
    pub scan: Stamped<&'a PerBeam<Reading>>,
    /// Which sensors are believed to have failed.
    pub failures: Failures,
}

/// Why the robot goes no faster than it does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SpeedLimit {
    /// It goes as fast as its behaviours want.
    #[default]
    None,
    /// It is where it shall be, and stands.
    Arrived,
    /// Too little of what lies ahead is seen by sensors that can be believed: it goes slower.
    Slowed,
    /// Far too little is: it stands.
    Blind,
    /// No direction is open: it turns on the spot until one is.
    NoWay,
}

/// What the controller says at one step, and why.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Command {
    /// The wheels' speeds.
    pub wheels: Wheels,
    /// What held the robot back.
    pub caution: SpeedLimit,
    /// How much of what lies ahead is seen.
    pub coverage: Coverage,
    /// μ of eq. 1.
    pub credibility: Credibility,
    /// How far the nearest obstacle is, as far as believed; none within reach is the largest distance.
    pub nearest: Millimeters,
    /// The opening that it makes for.
    pub valley: Option<Valley>,
}

/// The control level: from readings, failures and a goal to the wheels' speeds.
///
/// Braitenberg on the rangefinders, the histogram on the scanner, turning to the goal and going ahead,
/// each as credible as its sensors are (\[004\] eq. 1); then the speed that so much coverage allows, then
/// the limit of acceleration.
///
/// Mirrored situations have mirrored commands, to the bit, where the side that the robot keeps to is
/// mirrored as well.
///
/// Cost: the histogram's, and little besides. Memory: the rules, or a reference to constant ones, and 17
/// bytes; a step takes the histogram on the stack.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Controller<R = ControlRules> {
    rules: R,
    wheels: Wheels,
    last: Option<Ticks>,
    kept: Side,
}

impl<R: Borrow<ControlRules>> Controller<R> {
    /// Creates the controller of a robot that stands still, and that tries `first` where left and right
    /// are equally good.
    #[must_use]
    pub const fn new(rules: R, first: Side) -> Self {
        Self {
            rules,
            wheels: Wheels::STOPPED,
            last: None,
            kept: first,
        }
    }

    /// Returns the side that the robot keeps to.
    #[must_use]
    pub const fn kept_side(&self) -> Side {
        self.kept
    }

    /// Returns what to do now.
    ///
    /// At the first step no time has passed, so the wheels stand. A step that comes late changes no
    /// wheel's speed by more than four seconds' worth.
    ///
    /// ```
    /// use certainty_control::{
    ///     BEAMS, SpeedLimit, ControlRules, Controller, Stamped, Failures, Side, Effort, ControlInput,
    /// };
    /// use certainty_core::transducer::Reading;
    /// use certainty_core::units::{Point, Pose, Ticks};
    ///
    /// let mut controller = Controller::new(ControlRules::DEFAULT, Side::Left);
    /// let scan = [Reading::NoObject; BEAMS];
    /// let mut step = |ms, failures| {
    ///     let now = Ticks::new(ms);
    ///     controller.step(&ControlInput {
    ///         now,
    ///         pose: Pose::default(),
    ///         goal: Point::from_mm(10_000, 0),
    ///         rangefinders: [Stamped { what: Reading::NoObject, at: now }; 6],
    ///         scan: Stamped { what: &scan, at: now },
    ///         failures,
    ///     })
    /// };
    /// step(0, Failures::NONE);
    /// assert_eq!(step(250, Failures::NONE).wheels.right, Effort::lit("0.75")); // 3 m/s²
    /// let blind = step(400, Failures::ALL);
    /// assert_eq!((blind.caution, blind.wheels.right), (SpeedLimit::Blind, Effort::ZERO)); // 6 m/s²
    /// ```
    // Not inlined: its histogram must not be on the stack while the caller makes the scan.
    #[inline(never)]
    pub fn step(&mut self, situation: &ControlInput<'_>) -> Command {
        let fresh = Fresh::of(situation, self.rules.borrow().config());
        let mut credibility = Credibility::of(&situation.failures);
        if self.rules.borrow().config().blame == Blame::Own {
            credibility.braitenberg = Effort::ONE;
        }
        let nearest = fresh.nearest(self.rules.borrow().config());
        let (wanted, valley, caution, coverage) =
            self.wanted(situation, &fresh, &credibility, nearest);
        if let Some(side) = valley.and_then(Valley::side) {
            self.kept = side;
        }
        let elapsed = self.last.map_or(0, |last| situation.now.since(last));
        self.last = Some(situation.now);
        let limits = self.rules.borrow().config().limits;
        self.wheels = limits.limited(wanted.wheels(), self.wheels, elapsed);
        Command {
            wheels: self.wheels,
            caution,
            coverage,
            credibility,
            nearest,
            valley,
        }
    }

    /// Eq. 1 before `f_a`, and what became of it.
    fn wanted(
        &self,
        situation: &ControlInput<'_>,
        fresh: &Fresh<'_>,
        credibility: &Credibility,
        nearest: Millimeters,
    ) -> (Motion, Option<Valley>, SpeedLimit, Coverage) {
        let config = self.rules.borrow().config();
        let coverage = fresh.coverage(&config.coverage);
        if situation.pose.at.distance(situation.goal) <= config.goal_radius {
            return (Motion::STILL, None, SpeedLimit::Arrived, coverage);
        }
        let fastest = coverage.fastest(&config.coverage);
        if fastest == Effort::ZERO {
            return (Motion::STILL, None, SpeedLimit::Blind, coverage);
        }
        let bearing = situation.pose.at.bearing(situation.goal);
        // At the goal's very place, which is within its radius, any bearing will do.
        let goal = bearing.map_or(BinaryAngle::ZERO, |bearing| {
            bearing.wrapping_sub(situation.pose.heading)
        });

        let near = fresh.readings.map(|reading| {
            nearness(reading, config.rangefinder_default, config.outlook).unwrap_or(Effort::ZERO)
        });
        let mut believed = near;
        for (near, &left) in believed.iter_mut().zip(&fresh.left) {
            *near = scaled(*near, left);
        }
        let v0 = config.braitenberg.turn(&believed);
        let (v1, valley, open) = self.avoidance(fresh, goal);
        let v2 = azimuth_turn(goal, self.kept);
        let v3 = linear_speed([v0, v1, v2]);

        let alpha = &config.weights;
        let weighted = |value, credibility, alpha: &super::Ramp| {
            scaled(scaled(value, alpha.at(nearest)), credibility)
        };
        let turn = weighted(v0, credibility.braitenberg, &alpha.braitenberg)
            .saturating_add(weighted(v1, credibility.histogram, &alpha.histogram))
            .saturating_add(weighted(v2, credibility.goal, &alpha.azimuth));
        let ahead = weighted(v3, credibility.goal, &alpha.speed);
        if !open {
            let ahead = Effort::ZERO;
            return (
                Motion { turn: v1, ahead },
                None,
                SpeedLimit::NoWay,
                coverage,
            );
        }
        let (ahead, caution) = if ahead > fastest {
            (fastest, SpeedLimit::Slowed)
        } else {
            (ahead, SpeedLimit::None)
        };
        (Motion { turn, ahead }, valley, caution, coverage)
    }

    /// `v_1R` and the valley, and whether any direction is open.
    ///
    /// \[004\] does not say what to do where all are blocked. A scanner that is not believed blocks nothing.
    fn avoidance(&self, fresh: &Fresh<'_>, goal: BinaryAngle) -> (Effort, Option<Valley>, bool) {
        let config = self.rules.borrow().config();
        let Some(scan) = fresh.scan else {
            return (Effort::ZERO, None, true);
        };
        let histogram = PolarHistogram::of(scan, &config.histogram);
        let chosen = (config.threshold).choose(&histogram, goal, self.kept, config.commitment);
        match chosen {
            Some(valley) => (valley.turn(), chosen, true),
            None if is_heeded(fresh.scanner_left) => (self.kept.signed(HALF), None, false),
            None => (Effort::ZERO, None, true),
        }
    }
}

/// Whether a sensor is believed by half at least, of which `left` is left.
///
/// One that is not stops nobody; so it must not count as seeing either.
fn is_heeded(left: Effort) -> bool {
    left >= HALF
}

/// A situation in which what is stale is missing, and what is missing is not believed.
struct Fresh<'a> {
    readings: PerRangefinder<Reading>,
    /// 1 − φ of those that were heard.
    left: PerRangefinder<Effort>,
    scan: Option<&'a PerBeam<Reading>>,
    /// The same of the scanner.
    scanner_left: Effort,
}

impl<'a> Fresh<'a> {
    fn of(situation: &ControlInput<'a>, config: &ControlConfig) -> Self {
        let stale_after = config.stale_after;
        // What is dated a little ahead is fresh, as clocks may differ; no half turn of the ticks makes old
        // things new.
        let stale = |at: Ticks| {
            let age = situation.now.get().wrapping_sub(at.get());
            age > stale_after && age < stale_after.wrapping_neg()
        };
        let readings = situation.rangefinders.map(|dated| {
            if stale(dated.at) {
                Reading::Missing(Missing::Timeout)
            } else {
                dated.what
            }
        });
        let scan = (!stale(situation.scan.at)).then_some(situation.scan.what);
        let failures = situation.failures.or_silent(&readings, scan);
        let scanner_left = failures.scanner.left();
        Self {
            readings,
            left: failures.rangefinders.map(Failure::left),
            scan: scan.filter(|_| scanner_left > Effort::ZERO),
            scanner_left,
        }
    }

    /// How much of what lies ahead is seen by who is heeded.
    fn coverage(&self, config: &CoverageConfig) -> Coverage {
        let heeded = |left| if is_heeded(left) { left } else { Effort::ZERO };
        Coverage::of(config, &self.left.map(heeded), heeded(self.scanner_left))
    }

    /// How far the nearest obstacle is that a sensor tells of which is heeded.
    fn nearest(&self, config: &ControlConfig) -> Millimeters {
        let rangefinders = self.readings.iter().zip(&self.left);
        let rangefinders = rangefinders
            .filter(|&(_, &left)| is_heeded(left))
            .filter_map(|(&reading, _)| {
                in_the_way(reading, config.rangefinder_default, config.outlook)
            });
        let scan = self.scan.filter(|_| is_heeded(self.scanner_left));
        let beams = scan
            .into_iter()
            .flatten()
            .filter_map(|&reading| distance(reading));
        let farthest = Millimeters::new(u32::MAX);
        rangefinders.chain(beams).fold(farthest, Millimeters::min)
    }
}

#[cfg(test)]
mod tests;
