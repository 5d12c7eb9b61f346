use super::super::{BEAMS, Blame, ControlConfig, Failure, beam_bearing};
use super::*;
use crate::units::BinaryAngle;
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

    fn at(&self, now: u32) -> Situation<'_> {
        let at = Ticks::new(now);
        Situation {
            now: at,
            pose: self.pose,
            goal: self.goal,
            rangefinders: self.rangefinders.map(|what| Dated { what, at }),
            scan: Dated {
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

#[test]
fn an_open_road_is_taken_at_full_speed() {
    let command = settled(&Scene::open());
    assert_eq!(signals(&command), (1.0, 1.0));
    assert_eq!(command.caution, Caution::None);
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
    let (right, left) = signals(&settled(&scene));
    assert!(
        (right - 0.20833).abs() < 1e-4 && (left - 0.55833).abs() < 1e-4,
        "{right} {left}"
    );
    // With that rangefinder failed: nothing near is believed, and nothing turns.
    scene.failures.rangefinders[0] = Failure::TOTAL;
    assert_eq!(signals(&settled(&scene)), (1.0, 1.0));
}

#[test]
fn no_failure_leaves_all_credibility() {
    let command = settled(&Scene::open());
    let Credibility {
        braitenberg,
        histogram,
        goal,
    } = command.credibility;
    assert_eq!([braitenberg, histogram, goal], [Signal::ONE; 3]);
}

#[test]
fn all_failed_is_standing_still() {
    let command = settled(&Scene::failing(Failures::ALL));
    assert_eq!(
        (command.wheels, command.caution),
        (Wheels::STOPPED, Caution::Blind)
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
        assert!(command.credibility.braitenberg < Signal::ONE);
    }
    let scanner = Failures {
        scanner: Failure::TOTAL,
        ..Failures::NONE
    };
    let command = settled(&Scene::failing(scanner));
    assert_eq!(command.caution, Caution::Slowed);
    let (right, left) = signals(&command);
    assert!(
        (right - 0.5).abs() < 1e-3 && right == left,
        "{right} {left}"
    );
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
        Signal::ONE
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
    assert_eq!(settled(&Scene::failing(failures)).caution, Caution::Slowed);
    for corner in [0, 1, 4, 5] {
        let mut failures = failures;
        failures.rangefinders[corner] = Failure::TOTAL;
        let command = settled(&Scene::failing(failures));
        assert_eq!(
            (command.wheels, command.caution),
            (Wheels::STOPPED, Caution::Blind)
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
    assert_eq!(step(stale_after, old), Caution::None);
    // All rangefinders are, the scanner is not: their 0.5 is missing, and nothing lost.
    assert_eq!(
        step(stale_after + 1, Ticks::new(stale_after)),
        Caution::None
    );
    assert_eq!(step(stale_after + 1, old), Caution::Blind);
}

#[test]
fn where_nothing_is_open_it_turns_on_the_spot() {
    let wall = Scene {
        scan: [Reading::Echo(Millimeters::new(900)); BEAMS],
        ..Scene::open()
    };
    let command = settled(&wall);
    assert_eq!(signals(&command), (0.5, -0.5));
    assert_eq!(command.caution, Caution::NoWay);
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
        (Wheels::STOPPED, Caution::Arrived)
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
        1 => (0_i32..65536).prop_map(|bits| Failure::new_saturating(Signal::from_bits(bits))),
    ]
}

prop_compose! {
    fn scene()(
        (x, y, heading) in (-9000_i32..9000, -9000_i32..9000, any::<u16>()),
        (goal_x, goal_y) in (-9000_i32..9000, -9000_i32..9000),
        rangefinders in prop::array::uniform6(reading()),
        background in reading(),
        obstacles in prop::collection::vec((0..BEAMS, 1_usize..20, reading()), 0..6),
        failed in prop::array::uniform6(failure()),
        scanner in failure(),
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
            failures: Failures { rangefinders: failed, scanner },
        }
    }
}

proptest! {
    #[test]
    fn a_mirrored_run_has_mirrored_commands(scenes in prop::collection::vec(scene(), 1..6)) {
        let (mut ours, mut theirs) = (controller(Side::Left), controller(Side::Right));
        for (scene, now) in scenes.iter().zip((0..).step_by(70)) {
            let command = ours.step(&scene.at(now));
            let mirrored = scene.mirrored();
            let opposite = theirs.step(&mirrored.at(now));
            prop_assert_eq!(command.wheels, opposite.wheels.mirrored());
            prop_assert_eq!(command.caution, opposite.caution);
            prop_assert_eq!(command.nearest, opposite.nearest);
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
                prop_assert!(after.abs() <= Signal::ONE);
                let most = if after.abs() < before.abs() { 6.0 } else { 3.0 };
                let change: f64 = (after - before).abs().to_num();
                prop_assert!(change <= most * f64::from(elapsed) / 1000.0 + 1e-9);
            }
            before = wheels;
        }
    }

    #[test]
    fn whatever_is_seen_all_failed_is_a_stop(mut scene in scene()) {
        scene.failures = Failures::ALL;
        prop_assert_eq!(settled(&scene).wheels, Wheels::STOPPED);
    }

    #[test]
    fn no_failures_are_full_credibility_whatever_is_seen(mut scene in scene()) {
        scene.failures = Failures::NONE;
        let Credibility { braitenberg, histogram, goal } = settled(&scene).credibility;
        prop_assert_eq!([braitenberg, histogram, goal], [Signal::ONE; 3]);
    }
}
