//! The car on its wheels.

use crate::bench::{MILLISECOND, MovingCar};
use crate::world::{Obstacle, World};
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
