use super::super::{BEAMS, Mounting, RANGEFINDERS, beam_bearing};
use super::*;
use certainty_core::units::BinaryAngle;
use proptest::prelude::*;

const FAR: Point = Point::from_mm(20_000, 0);

/// Everything that a situation is made of, at one time.
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
        mirrored.pose = Pose::new(
            flip(self.pose.at),
            BinaryAngle::ZERO.wrapping_sub(self.pose.heading),
        );
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

/// The command after so long in the same scene that the wheels follow.
fn settled(scene: &Scene) -> Command {
    let mut controller = controller(Side::Left);
    let mut command = controller.step(&scene.at(0));
    for step in 1..40 {
        command = controller.step(&scene.at(step * 50));
    }
    command
}

fn signals(command: &Command) -> (f64, f64) {
    (command.wheels.right.to_num(), command.wheels.left.to_num())
}

fn assert_signals(command: &Command, (right, left): (f64, f64)) {
    let (a, b) = signals(command);
    let close = (a - right).abs() < 1e-4 && (b - left).abs() < 1e-4;
    assert!(close, "{a} {b}, and not {right} {left}");
}

#[test]
fn an_open_road_is_taken_at_full_speed() {
    let command = settled(&Scene::open());
    assert_eq!(signals(&command), (1.0, 1.0));
    assert_eq!(command.caution, SpeedLimit::None);
}

/// Eq. 1 by hand: nothing within 4 m but the goal 45° to the left, so α₀ and α₁ do not matter (nothing to
/// avoid), α₂ = 20/16 and α₃ = 1; v₂ = 0.25, v₃ = 1 − 0.25; turn 0.3125, ahead 0.75 of which 0.6875 is left.
#[test]
fn eq_1_by_hand_towards_the_goal() {
    let scene = Scene {
        goal: Point::from_mm(10_000, 10_000),
        ..Scene::open()
    };
    assert_eq!(signals(&settled(&scene)), (1.0, 0.375));
}

/// Eq. 1 by hand: FL sees something 800 mm away, nearness 7/15. v₀ = −7/30, α₀ = 12/16: −0.175; nothing
/// else turns. v₃ = 23/30; α₃ between 600 mm (6/16) and 1200 mm (12/16) is 0.5: 0.38333.
#[test]
fn eq_1_by_hand_beside_an_obstacle() {
    let mut scene = Scene::open();
    scene.rangefinders[0] = Reading::Echo(Millimeters::new(800));
    assert_signals(&settled(&scene), (0.208_33, 0.558_33));
    // With that rangefinder failed: nothing near is believed, and nothing turns.
    scene.failures.rangefinders[0] = Failure::TOTAL;
    assert_eq!(signals(&settled(&scene)), (1.0, 1.0));
}

/// Eq. 1 by hand: 21 beams on the right meet something 1550 mm away, 1000 mm beyond the safe region, which
/// takes atan(550 / 1000), 29 beams more. The valley is 50 to 100, its centre 25° to the left: v₁ = 0.25 and
/// v₃ = 0.75. α₁ at 1550 mm is (20 − 4 · 550/1500) / 16 = 1.15833, α₃ (12 + 4 · 350/800) / 16 = 0.859375.
#[test]
fn eq_1_by_hand_past_an_obstacle() {
    let mut scene = Scene::open();
    scene.scan[..=20].fill(Reading::Echo(Millimeters::new(1550)));
    let ahead = 0.75 * 0.859_375;
    for (doubt, credibility) in [("0", 1.0), ("0.25", 0.75), ("0.5", 0.5)] {
        scene.failures.scanner = Failure::new_saturating(Effort::lit(doubt));
        let turn = credibility * 0.25 * 1.158_333;
        assert_signals(&settled(&scene), (ahead + turn, ahead - turn));
    }
    // Not believed at all it neither turns nor slows, and the rangefinders see for half of full speed.
    scene.failures.scanner = Failure::TOTAL;
    let command = settled(&scene);
    assert_signals(&command, (0.5, 0.5));
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
    assert_signals(&settled(&scene), (ahead + turn, ahead - turn));
}

/// Eq. 1 by hand: as towards the goal, with every sensor failed by half. μ₂ = μ₃ = 1 − 2⁻⁷; coverage is half
/// of the scanner's 1 and half of twice a side's quarter: 0.75, more than is wanted.
#[test]
fn eq_1_by_hand_towards_the_goal_with_all_half_failed() {
    let half = Failure::new_saturating(HALF);
    let scene = Scene {
        goal: Point::from_mm(10_000, 10_000),
        ..Scene::failing(Failures {
            rangefinders: [half; RANGEFINDERS],
            scanner: half,
        })
    };
    let turn = 0.3125 * 127.0 / 128.0;
    let command = settled(&scene);
    assert_signals(&command, (1.0, 1.0 - 2.0 * turn));
    assert_eq!(command.coverage.part(), Effort::lit("0.75"));
}

#[test]
fn a_goal_exactly_behind_is_turned_to_on_the_side_that_is_kept() {
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

/// Who is not heeded when it says that something is there must not count when it says that nothing is.
#[test]
fn a_scanner_that_stops_nobody_clears_no_way_either() {
    let mut scene = Scene {
        scan: [Reading::Echo(Millimeters::new(700)); BEAMS],
        ..Scene::open()
    };
    let fail = |scene: &mut Scene, bits| {
        scene.failures.scanner = Failure::new_saturating(Effort::from_bits(bits));
    };
    fail(&mut scene, HALF.to_bits());
    assert_eq!(settled(&scene).caution, SpeedLimit::NoWay);
    fail(&mut scene, HALF.to_bits() + 1);
    let command = settled(&scene);
    assert_eq!(command.caution, SpeedLimit::Slowed);
    assert_signals(&command, (0.5, 0.5));
    assert_eq!(command.nearest, Millimeters::new(u32::MAX));
}

/// Half of the beams, and all of them ahead.
#[test]
fn who_sees_to_both_sides_does_not_see_ahead() {
    let mut scene = Scene::open();
    scene.scan[25..75].fill(Reading::Missing(Missing::Timeout));
    let command = settled(&scene);
    assert_eq!(command.caution, SpeedLimit::Slowed);
    assert_signals(&command, (0.5, 0.5));
    scene.rangefinders = [Reading::Missing(Missing::Timeout); RANGEFINDERS];
    assert_eq!(settled(&scene).caution, SpeedLimit::Blind);
}

#[test]
fn looking_down_flat_ground_is_open_and_a_hole_stops_it() {
    let config = ControlConfig {
        outlook: Mounting::Tilted,
        ..ControlConfig::DEFAULT
    };
    let rules = ControlRules::try_new(config).unwrap();
    let ground = Reading::Echo(config.rangefinder_default);
    let after_a_second = |rangefinders| {
        let scene = Scene {
            rangefinders,
            ..Scene::open()
        };
        let mut controller = Controller::new(rules, Side::Left);
        controller.step(&scene.at(0));
        controller.step(&scene.at(1000))
    };
    let flat = after_a_second([ground; RANGEFINDERS]);
    assert_eq!(
        (signals(&flat), flat.nearest),
        ((1.0, 1.0), Millimeters::new(u32::MAX))
    );
    let mut hole_ahead = [ground; RANGEFINDERS];
    (hole_ahead[0], hole_ahead[5]) = (Reading::NoObject, Reading::NoObject);
    for hole in [hole_ahead, [Reading::NoObject; RANGEFINDERS]] {
        let command = after_a_second(hole);
        assert_eq!(command.nearest, Millimeters::ZERO);
        // α₃ is 3/16 where something touches the robot.
        assert_signals(&command, (0.1875, 0.1875));
    }
    // On the left alone: it turns to the right.
    let mut hole_aside = [ground; RANGEFINDERS];
    hole_aside[1] = Reading::Echo(Millimeters::new(2900));
    let Wheels { right, left } = after_a_second(hole_aside).wheels;
    assert!(right < left);
}

#[test]
fn no_failure_leaves_all_credibility() {
    let command = settled(&Scene::open());
    let Credibility {
        braitenberg,
        histogram,
        goal,
    } = command.credibility;
    assert_eq!([braitenberg, histogram, goal], [Effort::ONE; 3]);
}

#[test]
fn all_failed_is_standing_still() {
    let command = settled(&Scene::failing(Failures::ALL));
    assert_eq!(
        (command.wheels, command.caution),
        (Wheels::STOPPED, SpeedLimit::Blind)
    );
}

/// PEERS: a dead sensor must neither stop everything nor go unnoticed.
#[test]
fn one_dead_sensor_of_any_kind_does_not_stop_the_robot() {
    for dead in 0..RANGEFINDERS {
        let mut failures = Failures::NONE;
        failures.rangefinders[dead] = Failure::TOTAL;
        let command = settled(&Scene::failing(failures));
        assert_eq!(signals(&command), (1.0, 1.0), "rangefinder {}", dead + 1);
        assert!(command.credibility.braitenberg < Effort::ONE);
    }
    let scanner = Failures {
        scanner: Failure::TOTAL,
        ..Failures::NONE
    };
    let command = settled(&Scene::failing(scanner));
    assert_eq!(command.caution, SpeedLimit::Slowed);
    assert_signals(&command, (0.5, 0.5));
}

#[test]
fn where_each_has_its_own_blame_the_others_are_believed_as_before() {
    let config = ControlConfig {
        blame: Blame::Own,
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
fn too_little_coverage_stops_and_says_so() {
    let mut failures = Failures {
        scanner: Failure::TOTAL,
        ..Failures::NONE
    };
    // Without the scanner the sides are missed by nobody, and a corner is seen by one sensor alone.
    failures.rangefinders[2] = Failure::TOTAL;
    assert_eq!(
        settled(&Scene::failing(failures)).caution,
        SpeedLimit::Slowed
    );
    for corner in [0, 1, 4, 5] {
        let mut failures = failures;
        failures.rangefinders[corner] = Failure::TOTAL;
        let command = settled(&Scene::failing(failures));
        assert_eq!(
            (command.wheels, command.caution),
            (Wheels::STOPPED, SpeedLimit::Blind)
        );
    }
}

#[test]
fn what_is_stale_counts_as_missing() {
    let scene = Scene::open();
    let mut controller = controller(Side::Left);
    let stale_after = ControlConfig::DEFAULT.stale_after;
    let old = Ticks::new(0);
    let mut step = |now, scan_at| {
        let mut situation = scene.at(now);
        for dated in &mut situation.rangefinders {
            dated.at = old;
        }
        situation.scan.at = scan_at;
        controller.step(&situation).caution
    };
    assert_eq!(step(stale_after, old), SpeedLimit::None);
    // All rangefinders are, the scanner is not: their 0.5 is missing, and nothing lost.
    assert_eq!(
        step(stale_after + 1, Ticks::new(stale_after)),
        SpeedLimit::None
    );
    assert_eq!(step(stale_after + 1, old), SpeedLimit::Blind);
    // However long ago that was, and half of all ticks ago it would be in the future.
    for now in [1 << 31, u32::MAX - stale_after - 1] {
        assert_eq!(step(now, old), SpeedLimit::Blind, "{now}");
    }
    // A clock that is a little ahead is none that stands.
    assert_eq!(step(1000, Ticks::new(1000 + stale_after)), SpeedLimit::None);
}

#[test]
fn where_nothing_is_open_it_turns_on_the_spot() {
    let wall = Scene {
        scan: [Reading::Echo(Millimeters::new(900)); BEAMS],
        ..Scene::open()
    };
    let command = settled(&wall);
    assert_eq!(signals(&command), (0.5, -0.5));
    assert_eq!(command.caution, SpeedLimit::NoWay);
}

#[test]
fn at_the_goal_it_stands() {
    let scene = Scene {
        goal: Point::from_mm(300, 400),
        ..Scene::open()
    };
    let command = settled(&scene);
    assert_eq!(
        (command.wheels, command.caution),
        (Wheels::STOPPED, SpeedLimit::Arrived)
    );
}

#[test]
fn before_a_post_it_keeps_to_the_side_it_began_with() {
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

/// All at once as well, so that the product of eq. 15 is not nothing.
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
    let outlook = prop_oneof![Just(Mounting::Level), Just(Mounting::Tilted)];
    let blame = prop_oneof![Just(Blame::Shared), Just(Blame::Own)];
    (outlook, blame).prop_map(|(outlook, blame)| {
        let config = ControlConfig {
            outlook,
            blame,
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
                let mut situation: ControlInput<'_> = Scene::at(scene, now);
                let mut ages = *ages;
                if reversed {
                    ages.reverse();
                }
                for (dated, age) in situation.rangefinders.iter_mut().zip(ages) {
                    dated.at = Ticks::new(now.wrapping_sub(age));
                }
                situation.scan.at = Ticks::new(now.wrapping_sub(*age));
                situation
            };
            let command = ours.step(&aged(scene, false));
            let opposite = theirs.step(&aged(&mirrored, true));
            prop_assert_eq!(command.wheels, opposite.wheels.mirrored());
            prop_assert_eq!(command.caution, opposite.caution);
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
    fn no_command_is_beyond_full_speed_or_the_limit_of_acceleration(
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

    /// However it goes by then: full speed is gone in 167 ms.
    #[test]
    fn whatever_is_seen_all_failed_is_a_stop(
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
    fn no_failures_are_full_credibility_whatever_is_seen(mut scene in scene()) {
        scene.failures = Failures::NONE;
        let Credibility { braitenberg, histogram, goal } = settled(&scene).credibility;
        prop_assert_eq!([braitenberg, histogram, goal], [Effort::ONE; 3]);
    }
}
