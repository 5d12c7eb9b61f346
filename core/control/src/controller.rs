//! The blend of all behaviours: \[004\] eq. 1.

use crate::behaviours::{azimuth_turn, linear_speed, nearness};
use crate::config::{ControlConfig, ControlRules, FailureSharing, Ramp};
use crate::failures::{Coverage, CoverageConfig, Credibility, Failure, Failures};
use crate::histogram::{PolarHistogram, Threshold, Valley};
use crate::motion::{Effort, Motion, Side, Wheels};
use crate::sensors::{BEAMS, RANGEFINDERS, distance};
use certainty_core::transducer::{Missing, Reading};
use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose, Ticks};
use core::borrow::Borrow;

/// A reading with the time at which it was taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Stamped<T> {
    /// The reading.
    pub what: T,
    /// Its time.
    pub at: Ticks,
}

/// The inputs of one control step.
#[derive(Debug, Clone, Copy)]
pub struct ControlInput<'a, const R: usize = RANGEFINDERS, const B: usize = BEAMS> {
    /// The time.
    pub now: Ticks,
    /// The robot's place and heading.
    pub pose: Pose,
    /// The goal.
    pub goal: Point,
    /// The rangefinders' last readings.
    pub rangefinders: [Stamped<Reading>; R],
    /// The scanner's last scan, or the map's in its place ([`scan_of_map`](crate::scan_of_map)).
    pub scan: Stamped<&'a [Reading; B]>,
    /// How far each sensor has failed.
    pub failures: Failures<R>,
}

/// What limits the robot's speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SpeedLimit {
    /// Nothing: it goes as fast as its behaviours want.
    #[default]
    None,
    /// It is at the goal, and stands.
    Arrived,
    /// Trusted sensors cover less of what lies ahead than this speed needs: it goes slower.
    Slowed,
    /// Trusted sensors cover less than the least coverage: it stands.
    Blind,
    /// Every direction is blocked: it turns on the spot until one is open.
    NoWay,
}

/// The output of one control step, and how it came about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Command {
    /// The wheels' speeds.
    pub wheels: Wheels,
    /// What limits the speed.
    pub speed_limit: SpeedLimit,
    /// How much of what lies ahead is seen.
    pub coverage: Coverage,
    /// μ of eq. 1.
    pub credibility: Credibility,
    /// The distance to the nearest obstacle that a sensor trusted by at least half reports; the largest
    /// distance if there is none.
    pub nearest: Millimeters,
    /// The opening that the robot steers to.
    pub valley: Option<Valley>,
}

/// How many beams nearer to the goal a valley on the other side must be to be chosen.
///
/// \[004\] has no such term; see [`Threshold::choose`].
const COMMITMENT: u8 = 10;

/// The control level: from readings, failures and a goal to the wheels' speeds.
///
/// Braitenberg on the rangefinders, the histogram on the scanner, turning to the goal and going ahead,
/// each weighted with its credibility (\[004\] eq. 1); then the speed that the coverage allows; then the
/// limit of acceleration.
///
/// Mirrored inputs give mirrored commands, to the bit, if the side that the robot keeps to is mirrored as
/// well.
///
/// Cost: mainly the histogram's. Memory: the rules, or a reference to constant ones, and 17 bytes; a step
/// keeps the histogram on the stack.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Controller<C = ControlRules, const R: usize = RANGEFINDERS> {
    rules: C,
    wheels: Wheels,
    last: Option<Ticks>,
    kept: Side,
}

impl<C: Borrow<ControlRules<R>>, const R: usize> Controller<C, R> {
    /// Creates the controller of a robot that stands still, and that tries `first` where left and right
    /// are equally good.
    #[must_use]
    pub const fn new(rules: C, first: Side) -> Self {
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

    /// Returns the command for now.
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
    /// assert_eq!((blind.speed_limit, blind.wheels.right), (SpeedLimit::Blind, Effort::ZERO)); // 6 m/s²
    /// ```
    // Not inlined: otherwise its histogram could be on the stack while the caller makes the scan.
    #[inline(never)]
    pub fn step<const B: usize>(&mut self, input: &ControlInput<'_, R, B>) -> Command {
        let fresh = FreshInput::of(input, self.rules.borrow().config());
        // A rangefinder that sends nothing now counts as failed here as well as for the coverage.
        let mut credibility = Credibility::of(&fresh.failures);
        if self.rules.borrow().config().sharing == FailureSharing::Own {
            credibility.braitenberg = Effort::ONE;
        }
        let nearest = fresh.nearest();
        let (wanted, valley, speed_limit, coverage) =
            self.wanted(input, &fresh, &credibility, nearest);
        if let Some(side) = valley.and_then(Valley::side) {
            self.kept = side;
        }
        let elapsed = self.last.map_or(0, |last| input.now.since(last));
        self.last = Some(input.now);
        let limits = self.rules.borrow().config().limits;
        self.wheels = limits.apply(wanted.wheels(), self.wheels, elapsed);
        Command {
            wheels: self.wheels,
            speed_limit,
            coverage,
            credibility,
            nearest,
            valley,
        }
    }

    /// Eq. 1 before `f_a`, and what limits the speed.
    fn wanted<const B: usize>(
        &self,
        input: &ControlInput<'_, R, B>,
        fresh: &FreshInput<'_, R, B>,
        mu: &Credibility,
        nearest: Millimeters,
    ) -> (Motion, Option<Valley>, SpeedLimit, Coverage) {
        let config = self.rules.borrow().config();
        let coverage = fresh.coverage(&config.coverage);
        if input.pose.at.distance(input.goal) <= config.goal_radius {
            return (Motion::STILL, None, SpeedLimit::Arrived, coverage);
        }
        let fastest = coverage.fastest(&config.coverage);
        if fastest == Effort::ZERO {
            return (Motion::STILL, None, SpeedLimit::Blind, coverage);
        }
        let bearing = input.pose.at.bearing(input.goal);
        // At the goal itself, within its radius, any bearing will do.
        let goal = bearing.map_or(BinaryAngle::ZERO, |bearing| bearing - input.pose.heading);

        let v0 = config.braitenberg.turn(&fresh.nearness(config));
        let (v1, valley, is_open) = self.avoidance(fresh, goal);
        let v2 = azimuth_turn(goal, self.kept);
        let v3 = linear_speed([v0, v1, v2]);
        if !is_open {
            let (turn, ahead) = (v1, Effort::ZERO);
            return (Motion { turn, ahead }, None, SpeedLimit::NoWay, coverage);
        }

        let alpha = |ramp: &Ramp| ramp.at(nearest);
        let weights = &config.weights;
        let turn = v0 * alpha(&weights.braitenberg) * mu.braitenberg
            + v1 * alpha(&weights.histogram) * mu.histogram
            + v2 * alpha(&weights.azimuth) * mu.goal;
        let ahead = v3 * alpha(&weights.speed) * mu.goal;
        let (ahead, speed_limit) = if ahead > fastest {
            (fastest, SpeedLimit::Slowed)
        } else {
            (ahead, SpeedLimit::None)
        };
        (Motion { turn, ahead }, valley, speed_limit, coverage)
    }

    /// `v_1R` and the valley, and whether any direction is open.
    ///
    /// \[004\] does not say what to do if all are blocked. A scanner trusted by less than half blocks none.
    fn avoidance<const B: usize>(
        &self,
        fresh: &FreshInput<'_, R, B>,
        goal: BinaryAngle,
    ) -> (Effort, Option<Valley>, bool) {
        let config = self.rules.borrow().config();
        let Some(scan) = fresh.scan else {
            return (Effort::ZERO, None, true);
        };
        let histogram = PolarHistogram::of(scan, &config.histogram);
        match Threshold::DEFAULT.choose(&histogram, goal, self.kept, COMMITMENT) {
            Some(valley) => (valley.turn(), Some(valley), true),
            None if is_trusted(fresh.scanner_trust) => {
                (self.kept.signed(Effort::HALF), None, false)
            }
            None => (Effort::ZERO, None, true),
        }
    }
}

/// Whether a sensor is trusted by at least half.
///
/// Only such a sensor's objects limit the speed, so only its view counts as coverage.
fn is_trusted(trust: Effort) -> bool {
    trust >= Effort::HALF
}

/// The input with stale readings replaced by missing ones, and the trust in each sensor.
struct FreshInput<'a, const R: usize, const B: usize> {
    readings: [Reading; R],
    /// Those of the input, and in full those of sensors without a reading.
    failures: Failures<R>,
    /// 1 − φ; 0 if the reading is missing.
    trust: [Effort; R],
    scan: Option<&'a [Reading; B]>,
    /// The scanner's.
    scanner_trust: Effort,
}

impl<'a, const R: usize, const B: usize> FreshInput<'a, R, B> {
    fn of(input: &ControlInput<'a, R, B>, config: &ControlConfig<R>) -> Self {
        let stale_after = config.stale_after;
        // A time slightly ahead counts as fresh, as clocks may differ; old readings do not become fresh again
        // half a turn of the ticks later.
        let is_stale = |at: Ticks| {
            let age = input.now.get().wrapping_sub(at.get());
            age > stale_after && age < stale_after.wrapping_neg()
        };
        let readings = input.rangefinders.map(|stamped| {
            if is_stale(stamped.at) {
                Reading::Missing(Missing::Timeout)
            } else {
                stamped.what
            }
        });
        let scan = (!is_stale(input.scan.at)).then_some(input.scan.what);
        let failures = input.failures.or_missing(&readings, scan);
        let scanner_trust = failures.scanner.trust();
        Self {
            readings,
            failures,
            trust: failures.rangefinders.map(Failure::trust),
            scan: scan.filter(|_| scanner_trust > Effort::ZERO),
            scanner_trust,
        }
    }

    /// `s_RF` of eq. 2, each weighted with the trust in its rangefinder.
    fn nearness(&self, config: &ControlConfig<R>) -> [Effort; R] {
        let mut near = self
            .readings
            .map(|reading| nearness(reading, config.rangefinder_default).unwrap_or(Effort::ZERO));
        for (near, &trust) in near.iter_mut().zip(&self.trust) {
            *near = *near * trust;
        }
        near
    }

    /// How much of what lies ahead trusted sensors see.
    fn coverage(&self, config: &CoverageConfig<R>) -> Coverage {
        let counted = |trust| {
            if is_trusted(trust) {
                trust
            } else {
                Effort::ZERO
            }
        };
        Coverage::of(
            config,
            &self.trust.map(counted),
            counted(self.scanner_trust),
        )
    }

    /// The distance to the nearest object that a trusted sensor reports.
    fn nearest(&self) -> Millimeters {
        let rangefinders = self.readings.iter().zip(&self.trust);
        let rangefinders = rangefinders
            .filter(|&(_, &trust)| is_trusted(trust))
            .map(|(reading, _)| reading);
        let scan = self.scan.filter(|_| is_trusted(self.scanner_trust));
        let beams = scan.into_iter().flatten();
        let objects = rangefinders
            .chain(beams)
            .filter_map(|&reading| distance(reading));
        objects.fold(Millimeters::new(u32::MAX), Millimeters::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::{BEAMS, PerBeam, PerRangefinder, RANGEFINDERS, beam_bearing};
    use certainty_core::units::BinaryAngle;
    use proptest::prelude::*;

    const FAR: Point = Point::from_mm(20_000, 0);

    /// The inputs of one control step, without their times.
    #[derive(Debug, Clone)]
    struct Scene {
        pose: Pose,
        goal: Point,
        rangefinders: PerRangefinder<Reading>,
        scan: PerBeam<Reading>,
        failures: Failures,
    }

    impl Scene {
        fn open() -> Self {
            Self {
                pose: Pose::default(),
                goal: FAR,
                rangefinders: [Reading::NoObject; RANGEFINDERS],
                scan: [Reading::NoObject; BEAMS],
                failures: Failures::NONE,
            }
        }

        fn failing(failures: Failures) -> Self {
            Self {
                failures,
                ..Self::open()
            }
        }

        fn mirrored(&self) -> Self {
            let flip = |point: Point| Point::from_mm(point.x_mm(), -point.y_mm());
            let mut mirrored = self.clone();
            mirrored.pose = Pose::new(flip(self.pose.at), -self.pose.heading);
            mirrored.goal = flip(self.goal);
            mirrored.rangefinders.reverse();
            mirrored.scan.reverse();
            mirrored.failures.rangefinders.reverse();
            mirrored
        }

        fn at(&self, now: u32) -> ControlInput<'_> {
            let at = Ticks::new(now);
            ControlInput {
                now: at,
                pose: self.pose,
                goal: self.goal,
                rangefinders: self.rangefinders.map(|what| Stamped { what, at }),
                scan: Stamped {
                    what: &self.scan,
                    at,
                },
                failures: self.failures,
            }
        }
    }

    fn controller(first: Side) -> Controller {
        Controller::new(ControlRules::DEFAULT, first)
    }

    /// The command after two seconds in the same scene, when the wheels have their final speed.
    fn settled(scene: &Scene) -> Command {
        let mut controller = controller(Side::Left);
        let mut command = controller.step(&scene.at(0));
        for step in 1..40 {
            command = controller.step(&scene.at(step * 50));
        }
        command
    }

    fn efforts(command: &Command) -> (f64, f64) {
        (command.wheels.right.to_num(), command.wheels.left.to_num())
    }

    fn assert_efforts(command: &Command, (right, left): (f64, f64)) {
        let (a, b) = efforts(command);
        let close = (a - right).abs() < 1e-4 && (b - left).abs() < 1e-4;
        assert!(close, "{a} {b}, and not {right} {left}");
    }

    #[test]
    fn an_open_road_is_taken_at_full_speed() {
        let command = settled(&Scene::open());
        assert_eq!(efforts(&command), (1.0, 1.0));
        assert_eq!(command.speed_limit, SpeedLimit::None);
    }

    /// Eq. 1 by hand: nothing within 4 m but the goal 45° to the left, so α₀ and α₁ do not matter (nothing to
    /// avoid), α₂ = 20/16 and α₃ = 1; v₂ = 0.25, v₃ = 1 − 0.25; turn 0.3125, ahead 0.75 of which 0.6875 is left.
    #[test]
    fn eq_1_by_hand_towards_the_goal() {
        let scene = Scene {
            goal: Point::from_mm(10_000, 10_000),
            ..Scene::open()
        };
        assert_eq!(efforts(&settled(&scene)), (1.0, 0.375));
    }

    /// Eq. 1 by hand: FL sees an object 800 mm away, nearness 7/15. v₀ = −7/30, α₀ = 12/16: −0.175; nothing
    /// else turns. v₃ = 23/30; α₃ between 600 mm (6/16) and 1200 mm (12/16) is 0.5: 0.38333.
    #[test]
    fn eq_1_by_hand_beside_an_obstacle() {
        let mut scene = Scene::open();
        scene.rangefinders[0] = Reading::Echo(Millimeters::new(800));
        assert_efforts(&settled(&scene), (0.208_33, 0.558_33));
        // With that rangefinder failed its reading counts for nothing, and nothing turns.
        scene.failures.rangefinders[0] = Failure::TOTAL;
        assert_eq!(efforts(&settled(&scene)), (1.0, 1.0));
    }

    /// Eq. 1 by hand: 21 beams on the right hit an object 1550 mm away, 1000 mm beyond the safe region, which
    /// widens by atan(550 / 1000), 29 beams. The valley is 50 to 100, its centre 25° to the left: v₁ = 0.25 and
    /// v₃ = 0.75. α₁ at 1550 mm is (20 − 4 · 550/1500) / 16 = 1.15833, α₃ (12 + 4 · 350/800) / 16 = 0.859375.
    #[test]
    fn eq_1_by_hand_past_an_obstacle() {
        let mut scene = Scene::open();
        scene.scan[..=20].fill(Reading::Echo(Millimeters::new(1550)));
        let ahead = 0.75 * 0.859_375;
        for (failure, credibility) in [("0", 1.0), ("0.25", 0.75), ("0.5", 0.5)] {
            scene.failures.scanner = Failure::new_saturating(Effort::lit(failure));
            let turn = credibility * 0.25 * 1.158_333;
            assert_efforts(&settled(&scene), (ahead + turn, ahead - turn));
        }
        // Without trust it neither turns nor slows; the rangefinders cover half of full speed.
        scene.failures.scanner = Failure::TOTAL;
        let command = settled(&scene);
        assert_efforts(&command, (0.5, 0.5));
        assert_eq!(
            (command.valley, command.nearest),
            (None, Millimeters::new(u32::MAX))
        );
    }

    /// Eq. 1 by hand: as beside an obstacle, with FR failed. μ₀ = 1 / (1 + c₁) + c₂ = 0.533908 − 0.145497.
    #[test]
    fn eq_1_by_hand_beside_an_obstacle_with_another_failed() {
        let mut scene = Scene::open();
        scene.rangefinders[0] = Reading::Echo(Millimeters::new(800));
        scene.failures.rangefinders[5] = Failure::TOTAL;
        let (turn, ahead) = (-0.175 * 0.388_411, 0.383_333);
        assert_efforts(&settled(&scene), (ahead + turn, ahead - turn));
    }

    /// Eq. 1 by hand: as towards the goal, with every sensor failed by half. μ₂ = μ₃ = 1 − 2⁻⁷; coverage is half
    /// of the scanner's 1 and half of twice a side's quarter: 0.75, more than the wanted speed.
    #[test]
    fn eq_1_by_hand_towards_the_goal_with_all_half_failed() {
        let half = Failure::new_saturating(Effort::HALF);
        let scene = Scene {
            goal: Point::from_mm(10_000, 10_000),
            ..Scene::failing(Failures {
                rangefinders: [half; RANGEFINDERS],
                scanner: half,
            })
        };
        let turn = 0.3125 * 127.0 / 128.0;
        let command = settled(&scene);
        assert_efforts(&command, (1.0, 1.0 - 2.0 * turn));
        assert_eq!(command.coverage.part(), Effort::lit("0.75"));
    }

    #[test]
    fn a_goal_exactly_behind_is_turned_to_on_the_kept_side() {
        let mut scene = Scene {
            pose: Pose::new(Point::ORIGIN, BinaryAngle::HALF),
            ..Scene::open()
        };
        // With and without a post that leaves a valley on either side.
        for post in [false, true] {
            if post {
                scene.scan[45..=55].fill(Reading::Echo(Millimeters::new(1700)));
            }
            for side in [Side::Left, Side::Right] {
                let mut controller = controller(side);
                controller.step(&scene.at(0));
                let Wheels { right, left } = controller.step(&scene.at(50)).wheels;
                assert_eq!(right > left, side == Side::Left, "{side:?} {post}");
                assert_ne!(right, left);
                assert_eq!(controller.kept_side(), side);
            }
        }
    }

    /// A scanner whose objects do not limit the speed must not count as coverage either.
    #[test]
    fn a_scanner_that_blocks_nothing_covers_nothing() {
        let mut scene = Scene {
            scan: [Reading::Echo(Millimeters::new(700)); BEAMS],
            ..Scene::open()
        };
        let fail = |scene: &mut Scene, bits| {
            scene.failures.scanner = Failure::new_saturating(Effort::from_bits(bits));
        };
        fail(&mut scene, Effort::HALF.to_bits());
        assert_eq!(settled(&scene).speed_limit, SpeedLimit::NoWay);
        fail(&mut scene, Effort::HALF.to_bits() + 1);
        let command = settled(&scene);
        assert_eq!(command.speed_limit, SpeedLimit::Slowed);
        assert_efforts(&command, (0.5, 0.5));
        assert_eq!(command.nearest, Millimeters::new(u32::MAX));
    }

    /// Half of the beams, and all of them ahead.
    #[test]
    fn beams_to_both_sides_do_not_cover_what_lies_ahead() {
        let mut scene = Scene::open();
        scene.scan[25..75].fill(Reading::Missing(Missing::Timeout));
        let command = settled(&scene);
        assert_eq!(command.speed_limit, SpeedLimit::Slowed);
        assert_efforts(&command, (0.5, 0.5));
        scene.rangefinders = [Reading::Missing(Missing::Timeout); RANGEFINDERS];
        assert_eq!(settled(&scene).speed_limit, SpeedLimit::Blind);
    }

    #[test]
    fn no_failure_leaves_full_credibility() {
        let command = settled(&Scene::open());
        let Credibility {
            braitenberg,
            histogram,
            goal,
        } = command.credibility;
        assert_eq!([braitenberg, histogram, goal], [Effort::ONE; 3]);
    }

    #[test]
    fn with_all_sensors_failed_it_stands_still() {
        let command = settled(&Scene::failing(Failures::ALL));
        assert_eq!(
            (command.wheels, command.speed_limit),
            (Wheels::STOPPED, SpeedLimit::Blind)
        );
    }

    #[test]
    fn one_dead_sensor_of_any_kind_does_not_stop_the_robot() {
        for dead in 0..RANGEFINDERS {
            let mut failures = Failures::NONE;
            failures.rangefinders[dead] = Failure::TOTAL;
            let command = settled(&Scene::failing(failures));
            assert_eq!(efforts(&command), (1.0, 1.0), "rangefinder {}", dead + 1);
            assert!(command.credibility.braitenberg < Effort::ONE);
        }
        let scanner = Failures {
            scanner: Failure::TOTAL,
            ..Failures::NONE
        };
        let command = settled(&Scene::failing(scanner));
        assert_eq!(command.speed_limit, SpeedLimit::Slowed);
        assert_efforts(&command, (0.5, 0.5));
    }

    #[test]
    fn with_own_failures_the_other_rangefinders_keep_trust() {
        let config = ControlConfig {
            sharing: FailureSharing::Own,
            ..ControlConfig::DEFAULT
        };
        let mut controller = Controller::new(ControlRules::try_new(config).unwrap(), Side::Left);
        let mut failures = Failures::NONE;
        failures.rangefinders[0] = Failure::TOTAL;
        let scene = Scene::failing(failures);
        assert_eq!(
            controller.step(&scene.at(0)).credibility.braitenberg,
            Effort::ONE
        );
    }

    #[test]
    fn too_little_coverage_stops_the_robot() {
        let mut failures = Failures {
            scanner: Failure::TOTAL,
            ..Failures::NONE
        };
        // The two at the sides cover nothing; each corner has one sensor.
        failures.rangefinders[2] = Failure::TOTAL;
        assert_eq!(
            settled(&Scene::failing(failures)).speed_limit,
            SpeedLimit::Slowed
        );
        for corner in [0, 1, 4, 5] {
            let mut failures = failures;
            failures.rangefinders[corner] = Failure::TOTAL;
            let command = settled(&Scene::failing(failures));
            assert_eq!(
                (command.wheels, command.speed_limit),
                (Wheels::STOPPED, SpeedLimit::Blind)
            );
        }
    }

    #[test]
    fn stale_readings_count_as_missing() {
        let scene = Scene::open();
        let mut controller = controller(Side::Left);
        let stale_after = ControlConfig::DEFAULT.stale_after;
        let old = Ticks::new(0);
        let mut step = |now, scan_at| {
            let mut input = scene.at(now);
            for stamped in &mut input.rangefinders {
                stamped.at = old;
            }
            input.scan.at = scan_at;
            controller.step(&input).speed_limit
        };
        assert_eq!(step(stale_after, old), SpeedLimit::None);
        // All rangefinders are stale, the scanner is not: its coverage alone is enough.
        assert_eq!(
            step(stale_after + 1, Ticks::new(stale_after)),
            SpeedLimit::None
        );
        assert_eq!(step(stale_after + 1, old), SpeedLimit::Blind);
        // At any age; half of all ticks ago would be in the future.
        for now in [1 << 31, u32::MAX - stale_after - 1] {
            assert_eq!(step(now, old), SpeedLimit::Blind, "{now}");
        }
        // A time slightly ahead is fresh.
        assert_eq!(step(1000, Ticks::new(1000 + stale_after)), SpeedLimit::None);
    }

    /// A silent rangefinder counted as failed for the coverage only.
    #[test]
    fn a_silent_rangefinder_counts_in_eq_14_as_a_failed_one() {
        let mut silent = Scene::open();
        silent.rangefinders[2] = Reading::Missing(Missing::Timeout);
        let mut failed = silent.clone();
        failed.failures.rangefinders[2] = Failure::TOTAL;
        let (silent, failed) = (settled(&silent), settled(&failed));
        assert_eq!(silent.credibility, failed.credibility);
        assert!(silent.credibility.braitenberg < Effort::ONE);
    }

    #[test]
    fn where_every_direction_is_blocked_it_turns() {
        let wall = Scene {
            scan: [Reading::Echo(Millimeters::new(900)); BEAMS],
            ..Scene::open()
        };
        let command = settled(&wall);
        assert_eq!(efforts(&command), (0.5, -0.5));
        assert_eq!(command.speed_limit, SpeedLimit::NoWay);
    }

    #[test]
    fn at_the_goal_it_stands() {
        let scene = Scene {
            goal: Point::from_mm(300, 400),
            ..Scene::open()
        };
        let command = settled(&scene);
        assert_eq!(
            (command.wheels, command.speed_limit),
            (Wheels::STOPPED, SpeedLimit::Arrived)
        );
    }

    #[test]
    fn before_a_post_it_keeps_to_its_first_side() {
        let mut scene = Scene::open();
        for beam in 47..=53 {
            scene.scan[beam] = Reading::Echo(Millimeters::new(1500));
        }
        for side in [Side::Left, Side::Right] {
            let mut controller = controller(side);
            controller.step(&scene.at(0));
            let command = controller.step(&scene.at(50));
            assert_eq!(command.valley.and_then(Valley::side), Some(side));
            assert_eq!(controller.kept_side(), side);
        }
        assert_eq!(beam_bearing(50), BinaryAngle::ZERO);
    }

    fn reading() -> impl Strategy<Value = Reading> {
        prop_oneof![
            4 => (0_u32..5000).prop_map(|mm| Reading::Echo(Millimeters::new(mm))),
            3 => Just(Reading::NoObject),
            1 => Just(Reading::TooNear),
            1 => Just(Reading::Missing(Missing::Timeout)),
        ]
    }

    fn failure() -> impl Strategy<Value = Failure> {
        prop_oneof![
            3 => Just(Failure::NONE),
            1 => Just(Failure::TOTAL),
            1 => (0_i32..65536).prop_map(|bits| Failure::new_saturating(Effort::from_bits(bits))),
        ]
    }

    /// Sometimes all of them partly, so that the product of eq. 15 is not 0.
    fn failures() -> impl Strategy<Value = Failures> {
        let partly =
            || (1_i32..65536).prop_map(|bits| Failure::new_saturating(Effort::from_bits(bits)));
        prop_oneof![
            3 => (prop::array::uniform6(failure()), failure()),
            1 => (prop::array::uniform6(partly()), partly()),
        ]
        .prop_map(|(rangefinders, scanner)| Failures {
            rangefinders,
            scanner,
        })
    }

    prop_compose! {
        fn scene()(
            (x, y, heading) in (-9000_i32..9000, -9000_i32..9000, any::<u16>()),
            (goal_x, goal_y) in (-9000_i32..9000, -9000_i32..9000),
            rangefinders in prop::array::uniform6(reading()),
            background in reading(),
            obstacles in prop::collection::vec((0..BEAMS, 1_usize..20, reading()), 0..6),
            failures in failures(),
        ) -> Scene {
            let mut scan = [background; BEAMS];
            for (first, width, reading) in obstacles {
                let end = BEAMS.min(first + width);
                scan[first..end].fill(reading);
            }
            Scene {
                pose: Pose::new(Point::from_mm(x, y), BinaryAngle::from_bits(heading)),
                goal: Point::from_mm(goal_x, goal_y),
                rangefinders,
                scan,
                failures,
            }
        }
    }

    fn rules() -> impl Strategy<Value = ControlRules> {
        let sharing = prop_oneof![Just(FailureSharing::Shared), Just(FailureSharing::Own)];
        sharing.prop_map(|sharing| {
            let config = ControlConfig {
                sharing,
                ..ControlConfig::DEFAULT
            };
            ControlRules::try_new(config).unwrap()
        })
    }

    proptest! {
        #[test]
        fn a_mirrored_run_has_mirrored_commands(
            rules in rules(),
            scenes in prop::collection::vec((scene(), prop::array::uniform6(0_u32..400), 0_u32..400), 1..6),
        ) {
            let (mut ours, mut theirs) =
                (Controller::new(rules, Side::Left), Controller::new(rules, Side::Right));
            for ((scene, ages, age), now) in scenes.iter().zip((0..).step_by(70)) {
                let mirrored = scene.mirrored();
                let aged = |scene, reversed: bool| {
                    let mut input: ControlInput<'_> = Scene::at(scene, now);
                    let mut ages = *ages;
                    if reversed {
                        ages.reverse();
                    }
                    for (stamped, age) in input.rangefinders.iter_mut().zip(ages) {
                        stamped.at = Ticks::new(now.wrapping_sub(age));
                    }
                    input.scan.at = Ticks::new(now.wrapping_sub(*age));
                    input
                };
                let command = ours.step(&aged(scene, false));
                let opposite = theirs.step(&aged(&mirrored, true));
                prop_assert_eq!(command.wheels, opposite.wheels.mirrored());
                prop_assert_eq!(command.speed_limit, opposite.speed_limit);
                prop_assert_eq!(command.nearest, opposite.nearest);
                prop_assert_eq!(command.coverage, opposite.coverage);
                prop_assert_eq!(command.credibility, opposite.credibility);
                let ends = |valley: Valley| (valley.first(), valley.last());
                let flipped = |valley: Valley| (100 - valley.last(), 100 - valley.first());
                prop_assert_eq!(command.valley.map(ends), opposite.valley.map(flipped));
                prop_assert_eq!(ours.kept_side(), theirs.kept_side().other());
            }
        }

        #[test]
        fn no_command_exceeds_full_speed_or_acceleration(
            scenes in prop::collection::vec((scene(), 0_u32..300), 1..8),
        ) {
            let mut controller = controller(Side::Left);
            let (mut now, mut before) = (0, Wheels::STOPPED);
            for (number, (scene, pause)) in scenes.iter().enumerate() {
                now += pause;
                let wheels = controller.step(&scene.at(now)).wheels;
                let elapsed = if number == 0 { 0 } else { *pause };
                for (after, before) in [(wheels.right, before.right), (wheels.left, before.left)] {
                    prop_assert!(after.abs() <= Effort::ONE);
                    let most = if after.abs() < before.abs() { 6.0 } else { 3.0 };
                    let change: f64 = (after - before).abs().to_num();
                    prop_assert!(change <= most * f64::from(elapsed) / 1000.0 + 1e-9);
                }
                before = wheels;
            }
        }

        /// From full speed it takes 167 ms.
        #[test]
        fn with_all_sensors_failed_it_stops_in_any_scene(
            scenes in prop::collection::vec(scene(), 1..12), mut last in scene(),
        ) {
            let mut controller = controller(Side::Left);
            let mut now = 0;
            for scene in &scenes {
                controller.step(&scene.at(now));
                now += 150;
            }
            last.failures = Failures::ALL;
            for _ in 0..4 {
                controller.step(&last.at(now));
                now += 50;
            }
            prop_assert_eq!(controller.step(&last.at(now)).wheels, Wheels::STOPPED);
        }

        #[test]
        fn no_failure_is_full_credibility_in_any_scene(mut scene in scene()) {
            scene.failures = Failures::NONE;
            let present = |reading: &mut Reading| {
                if matches!(reading, Reading::Missing(_)) {
                    *reading = Reading::NoObject;
                }
            };
            scene.rangefinders.iter_mut().chain(&mut scene.scan).for_each(present);
            let Credibility { braitenberg, histogram, goal } = settled(&scene).credibility;
            prop_assert_eq!([braitenberg, histogram, goal], [Effort::ONE; 3]);
        }
    }
}
