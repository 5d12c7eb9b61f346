//! The car on its wheels.

use crate::bench::{MILLISECOND, MotorFault, MovingCar};
use crate::fault::Window;
use crate::quantity::Percentage;
use crate::world::{Obstacle, World};
use certainty_control::Side;
use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose};
use certainty_firmware::smart_car::POSE;

fn open() -> World {
    World::new("open", Vec::new())
}

/// A car whose motors get these pulses from the start on.
fn told(right: u32, left: u32) -> MovingCar {
    let mut car = MovingCar::new();
    assert!(car.set_pulse(0, right) && car.set_pulse(1, left));
    car
}

fn at(x: i32, y: i32) -> Pose {
    Pose::new(Point::from_mm(x, y), POSE.heading)
}

#[test]
fn a_pulse_counts_from_the_middle_of_its_frame_on() {
    let mut car = told(2_000, 2_000);
    // Taken at 10 ms; 2 mm further in each frame, all of it at its end.
    for (ms, y) in [(9, 0), (10, 0), (29, 0), (30, 2), (49, 2), (50, 4)] {
        car.advance(&open(), ms * MILLISECOND);
        assert_eq!(car.pose(), at(0, y), "{ms} ms");
    }
    // Told in the second half of a frame, it stands only from the next middle on.
    car.set_pulse(0, 1_500);
    car.set_pulse(1, 1_500);
    car.advance(&open(), 69 * MILLISECOND);
    assert_eq!(car.pose(), at(0, 4));
    car.advance(&open(), 1_000 * MILLISECOND);
    assert_eq!(car.pose(), at(0, 6));
}

#[test]
fn how_often_it_is_asked_changes_nothing() {
    let mut often = told(1_900, 1_750);
    let mut once = often.clone();
    for us in 0..200_000 {
        often.advance(&open(), us * 7_000);
    }
    once.advance(&open(), 199_999 * 7_000);
    assert_eq!(often, once);
}

/// 80 mm each way on a track of 160 mm is 1 rad, to the hundredth of a degree.
#[test]
fn wheels_against_each_other_turn_it_on_the_spot() {
    let mut car = told(2_000, 1_000);
    car.advance(&open(), 810 * MILLISECOND);
    let turned = car.pose().heading.wrapping_sub(POSE.heading);
    let off = turned.separation(BinaryAngle::from_millidegrees(57_296));
    assert!(off <= BinaryAngle::from_bits(2), "{turned:?}");
    assert_eq!(car.pose().at, POSE.at);
}

#[test]
fn without_a_pulse_that_can_be_it_stands() {
    for us in [0, 400, 2_600, 20_000] {
        let mut car = told(us, us);
        car.advance(&open(), 2_000 * MILLISECOND);
        assert_eq!(car.pose(), POSE, "{us} us");
    }
    assert!(!MovingCar::new().set_pulse(2, 1_500));
}

#[test]
fn it_stops_at_a_wall_and_each_touch_counts_once() {
    let (from, to) = (Point::from_mm(-900, 500), Point::from_mm(900, 500));
    let wall = Obstacle::wall(from, to, Millimeters::new(20)).unwrap();
    let world = World::new("a wall across", vec![wall]);
    let mut car = told(2_000, 2_000);
    let mut now = 0;
    let mut drive = |car: &mut MovingCar, us, ms| {
        car.set_pulse(0, us);
        car.set_pulse(1, us);
        now += ms * MILLISECOND;
        car.advance(&world, now);
    };
    drive(&mut car, 2_000, 8_000);
    // The wall's face at 490, the outline 80 ahead of the middle, and steps of 2.
    assert!((408..=410).contains(&car.pose().at.y_mm()), "{car:?}");
    drive(&mut car, 1_000, 400);
    assert!((365..=375).contains(&car.pose().at.y_mm()), "{car:?}");
    drive(&mut car, 2_000, 2_400);
    let touched: Vec<u32> = car.stages().iter().map(|stage| stage.collisions).collect();
    assert_eq!(touched.first(), Some(&0));
    assert_eq!(touched.last(), Some(&2), "{touched:?}");
    assert!(touched.is_sorted());
}

/// A stage a round, where it is when its heads look: 31 frames after what it was told in the round before.
#[test]
fn where_it_is_when_its_heads_look_is_noted_once_a_round() {
    let mut car = told(2_000, 2_000);
    car.advance(&open(), 2_400 * MILLISECOND);
    let noted: Vec<i32> = car
        .stages()
        .iter()
        .map(|stage| stage.pose.at.y_mm())
        .collect();
    // Taken at 10 ms, seen at 610 ms: 30 frames of 2 mm, then 40 more a round.
    assert_eq!(noted, [60, 140, 220]);
}

/// A car at full speed whose right motor is broken so in round 1, after this many ms.
fn broken(fault: MotorFault, seed: u64, ms: u64) -> Pose {
    let window = Window::Readings {
        from: 1,
        to: Some(2),
    };
    let mut car = MovingCar::with_faults(vec![(Side::Right, fault, window)], seed);
    assert!(car.set_pulse(0, 2_000) && car.set_pulse(1, 2_000));
    car.advance(&open(), ms * MILLISECOND);
    car.pose()
}

/// How far it has turned to the right, in degrees.
fn turned(pose: Pose) -> f64 {
    let back = POSE.heading.wrapping_sub(pose.heading);
    f64::from(back.to_bits()) * 360.0 / 65_536.0
}

#[test]
fn a_broken_motor_turns_the_car_by_what_its_wheel_does_not_go() {
    let part = |percent| Percentage::try_new(percent).unwrap();
    // Of the 80 mm of a round on a track of 160 mm: the whole is half a radian.
    for (fault, radians) in [
        (MotorFault::Dead, 0.5),
        (MotorFault::Weak(part(95.0)), 0.025),
        (MotorFault::Weak(part(0.0)), 0.5),
        (MotorFault::Weak(part(100.0)), 0.0),
        (MotorFault::Slip(part(0.0)), 0.0),
        (MotorFault::Off, 0.0),
    ] {
        let before = turned(broken(fault, 1, 810));
        let there = turned(broken(fault, 1, 1_610));
        let later = turned(broken(fault, 1, 2_410));
        assert!(before.abs() < 0.02, "{fault:?} {before}");
        let off = there - f64::to_degrees(radians);
        assert!(off.abs() < 0.2, "{fault:?} {there}");
        assert!((later - there).abs() < 0.02, "{fault:?} {later}");
    }
}

/// Half of the most in the mean, another for another seed, the same for the same.
#[test]
fn a_slipping_wheel_loses_half_of_the_most_in_the_mean() {
    let slip = MotorFault::Slip(Percentage::try_new(20.0).unwrap());
    let lost: Vec<f64> = (0..20)
        .map(|seed| turned(broken(slip, seed, 2_410)))
        .collect();
    let mean = lost.iter().sum::<f64>() / 20.0;
    let expected = f64::to_degrees(0.05);
    assert!((mean - expected).abs() < expected / 10.0, "{lost:?}");
    assert!(lost.iter().any(|&one| one < lost[0]) || lost.iter().any(|&one| one > lost[0]));
    assert_eq!(turned(broken(slip, 7, 2_410)), lost[7]);
}
