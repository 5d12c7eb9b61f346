use super::*;
use crate::remote::{Channel, Link, Refused, RemoteBoard, RemotePwm, Request};
use crate::smart_car::{CELLS, SENSORS, SmartCarShape};
use certainty_control::{BEAMS, ControlInput, Effort, Failure, Failures, Stamped};
use certainty_core::fusion::{BayesGrid, Strength};
use certainty_core::health::{Confidence, Health};
use certainty_core::transducer::{Missing, Reading};
use certainty_core::units::{Millimeters, Point, Ticks};
use core::cell::{Cell, RefCell};

/// Writes the motors' pulses down, in µs; refuses those of `deaf`.
#[derive(Default)]
struct Line {
    pulses: RefCell<Vec<(u8, u16)>>,
    deaf: Cell<Option<u8>>,
}

impl Line {
    /// What came since the last time.
    fn take(&self) -> Vec<(u8, u16)> {
        self.pulses.take()
    }
}

impl Link for Line {
    fn ask(&self, request: Request) -> Result<u32, Refused> {
        match request {
            Request::Pulse(Channel::Motor(motor), _) if self.deaf.get() == Some(motor) => {
                Err(Refused)
            }
            Request::Pulse(Channel::Motor(motor), us) => {
                self.pulses.borrow_mut().push((motor, us));
                Ok(0)
            }
            other => panic!("{other:?}"),
        }
    }

    fn pass(&self, _: u32) {}

    fn micros(&self) -> u32 {
        0
    }

    fn report(&self, _: &[u8]) {}
}

fn car(line: &Line) -> Drive<RemoteBoard<'_, Line>> {
    started(line, Start::ByHand)
}

fn started(line: &Line, start: Start) -> Drive<RemoteBoard<'_, Line>> {
    let wires = MotorWires {
        right: RemotePwm::new(line, Channel::Motor(0)),
        left: RemotePwm::new(line, Channel::Motor(1)),
    };
    Drive::new(wires, start)
}

const STANDS: [(u8, u16); 2] = [(0, 1_500), (1, 1_500)];

/// Steers in `round`, on an empty map of sensors with this confidence, all of them silent or none.
fn steer(car: &mut Drive<RemoteBoard<'_, Line>>, round: u32, silent: bool, confidence: Confidence) {
    steer_with(car, round, [silent; 3], confidence);
}

/// The same with these heads silent; the rangers are if all are.
fn steer_with(
    car: &mut Drive<RemoteBoard<'_, Line>>,
    round: u32,
    silent: [bool; 3],
    confidence: Confidence,
) {
    let grid = BayesGrid::try_new(SmartCarShape, Strength::UNLIMITED, [0; CELLS]).unwrap();
    let health = [Health::new(confidence); SENSORS as usize];
    let at = Ticks::new(round * 800 + 721);
    let reading = if silent == [true; 3] {
        Reading::Missing(Missing::Timeout)
    } else {
        Reading::NoObject
    };
    let eye = RangerInput {
        reading,
        measured: at,
        health: &health[0],
    };
    let due = Due {
        round,
        slot: 16,
        at,
    };
    let map = Environment::new(&grid, &health);
    car.steer(due, &map, &silent, &[eye, eye]);
}

/// A car that has looked around and goes; all it was told is forgotten.
fn going(line: &Line) -> Drive<RemoteBoard<'_, Line>> {
    let mut car = car(line);
    for round in 0..LOOK_AROUND + 3 {
        steer(&mut car, round, false, Confidence::FULL);
        car.drive();
    }
    assert_eq!(car.report().conduct, DriveState::Going);
    assert_ne!(car.thrust, MotorPulses::NONE);
    line.take();
    car
}

#[test]
fn it_stands_and_looks_around_for_a_sweep() {
    let line = Line::default();
    let mut car = car(&line);
    for round in 0..37 {
        steer(&mut car, round, false, Confidence::FULL);
        car.drive();
        assert_eq!(line.take(), STANDS, "round {round}");
        assert_eq!(car.report().conduct, DriveState::Looking);
    }
    assert_eq!(car.looks_from(), POSE);
}

/// What two heads missed in the first sweep is not free.
#[test]
fn a_round_in_which_two_heads_are_silent_is_no_look_around() {
    let line = Line::default();
    let mut car = car(&line);
    let one = [false, true, false];
    let two = [true, true, false];
    for (rounds, silent) in [(0..20, one), (20..50, two), (50..67, one)] {
        for round in rounds {
            steer_with(&mut car, round, silent, Confidence::FULL);
            car.drive();
            assert_eq!(car.report().conduct, DriveState::Looking, "round {round}");
        }
    }
    steer(&mut car, 67, false, Confidence::FULL);
    car.drive();
    assert_eq!(car.report().conduct, DriveState::Going);
}

#[test]
fn then_it_goes_towards_its_goal_and_its_looks_go_with_it() {
    let line = Line::default();
    let mut car = going(&line);
    let before = car.looks_from();
    steer(&mut car, LOOK_AROUND + 3, false, Confidence::FULL);
    car.drive();
    assert_eq!(car.report().pose, before, "of the round that ended");
    let after = car.looks_from();
    assert!(after.at.distance(GOAL) < before.at.distance(GOAL));
    // 80 mm a round at the most.
    assert!(after.at.distance(before.at).get() <= 80);
    let told = line.take();
    assert_eq!(told.len(), 2);
    assert!(told.iter().all(|(_, us)| (1_000..=2_000).contains(us)));
}

#[test]
fn a_round_without_a_decision_tells_the_motors_to_stand() {
    let line = Line::default();
    let mut car = going(&line);
    car.drive();
    assert_eq!(line.take(), STANDS);
    assert_eq!(car.report().conduct, DriveState::Late);
    // What was told before took it a round further, and from now on it stands.
    let there = car.looks_from();
    car.drive();
    assert_eq!(car.looks_from(), there);
}

#[test]
fn a_slot_that_is_skipped_makes_it_stand_for_two_rounds() {
    let line = Line::default();
    let mut car = going(&line);
    steer(&mut car, LOOK_AROUND + 3, false, Confidence::FULL);
    car.falter();
    car.drive();
    assert_eq!(line.take(), STANDS);
    assert_eq!(car.report().conduct, DriveState::Late);
    // It starts anew: the first decision knows of no time that has passed, in which it could get faster.
    steer(&mut car, LOOK_AROUND + 4, false, Confidence::FULL);
    car.drive();
    assert_eq!(car.report().conduct, DriveState::Going);
    assert_eq!(line.take(), STANDS);
    steer(&mut car, LOOK_AROUND + 5, false, Confidence::FULL);
    car.drive();
    assert_eq!(car.report().conduct, DriveState::Going);
    assert_ne!(car.thrust, MotorPulses::NONE);
}

#[test]
fn a_motor_that_refuses_makes_the_other_stand() {
    for (deaf, other) in [(0, 1), (1, 0)] {
        let line = Line::default();
        let mut car = going(&line);
        line.deaf.set(Some(deaf));
        steer(&mut car, LOOK_AROUND + 3, false, Confidence::FULL);
        car.drive();
        assert_eq!(line.take().last(), Some(&(other, 1_500)));
        assert_eq!(car.report().conduct, DriveState::Refused);
        let there = car.looks_from();
        car.drive();
        assert_eq!(car.looks_from(), there, "it is not reckoned to move");
        // Where its pulses took it meanwhile nobody knows, so it does not go on when it hears again.
        line.deaf.set(None);
        stands_for_good(&mut car, &line, DriveState::Lost);
    }
}

/// The other motor was told to turn before, and may not have heard that it shall not.
#[test]
fn a_motor_that_refuses_when_the_car_begins_to_move_makes_it_lost() {
    for deaf in [0, 1] {
        let line = Line::default();
        let mut car = going(&line);
        car.drive();
        steer(&mut car, LOOK_AROUND + 4, false, Confidence::FULL);
        car.drive();
        assert_eq!(car.thrust, MotorPulses::NONE);
        line.deaf.set(Some(deaf));
        steer(&mut car, LOOK_AROUND + 5, false, Confidence::FULL);
        car.drive();
        assert_eq!(car.report().conduct, DriveState::Refused);
        line.deaf.set(None);
        stands_for_good(&mut car, &line, DriveState::Lost);
    }
}

#[test]
fn a_motor_that_refuses_to_stand_while_it_stands_costs_nothing_but_time() {
    let line = Line::default();
    let mut car = car(&line);
    line.deaf.set(Some(1));
    for round in 0..20 {
        steer(&mut car, round, false, Confidence::FULL);
        car.drive();
        assert_eq!(car.report().conduct, DriveState::Refused);
    }
    line.deaf.set(None);
    for round in 20..LOOK_AROUND + 3 {
        steer(&mut car, round, false, Confidence::FULL);
        car.drive();
    }
    assert_eq!(car.report().conduct, DriveState::Going);
    assert_ne!(car.thrust, MotorPulses::NONE);
}

/// Steers a few rounds more and sees it stand, for this reason.
fn stands_for_good(car: &mut Drive<RemoteBoard<'_, Line>>, line: &Line, why: DriveState) {
    for round in LOOK_AROUND + 5..LOOK_AROUND + 9 {
        line.take();
        steer(car, round, false, Confidence::FULL);
        car.drive();
        assert_eq!(line.take(), STANDS);
        assert_eq!(car.report().conduct, why);
    }
}

#[test]
fn a_car_that_moved_and_was_told_late_is_lost_and_stands_for_good() {
    let line = Line::default();
    let mut car = going(&line);
    steer(&mut car, LOOK_AROUND + 3, false, Confidence::FULL);
    car.drive_late();
    assert_eq!(line.take(), STANDS);
    assert_eq!(car.report().conduct, DriveState::Lost);
    stands_for_good(&mut car, &line, DriveState::Lost);
}

#[test]
fn a_car_that_started_by_itself_stands_until_it_is_started_by_hand() {
    let line = Line::default();
    let mut car = started(&line, Start::ByItself);
    for round in 0..LOOK_AROUND + 9 {
        steer(&mut car, round, false, Confidence::FULL);
        car.drive();
        assert_eq!(line.take(), STANDS, "round {round}");
        assert_eq!(car.report().conduct, DriveState::Restarted);
    }
    assert_eq!(car.looks_from(), POSE);
}

#[test]
fn a_car_that_stood_and_was_told_late_goes_on() {
    let line = Line::default();
    let mut car = car(&line);
    steer(&mut car, 3, false, Confidence::FULL);
    car.drive_late();
    assert_eq!(car.report().conduct, DriveState::Late);
    for round in 4..LOOK_AROUND + 6 {
        steer(&mut car, round, false, Confidence::FULL);
        car.drive();
    }
    assert_eq!(car.report().conduct, DriveState::Going);
}

#[test]
fn without_senses_it_stands() {
    let senses = [(true, Confidence::FULL), (false, Confidence::NONE)];
    for (silent, confidence) in senses {
        let line = Line::default();
        let mut car = going(&line);
        steer(&mut car, LOOK_AROUND + 3, silent, confidence);
        car.drive();
        assert_eq!(line.take(), STANDS);
        assert_eq!(car.report().conduct, DriveState::Blind);
    }
}

#[test]
fn at_its_goal_it_stands() {
    let line = Line::default();
    let mut car = going(&line);
    car.began = Odometer::new(Pose::new(GOAL, POSE.heading));
    car.thrust = MotorPulses::NONE;
    for round in LOOK_AROUND + 3..LOOK_AROUND + 6 {
        steer(&mut car, round, false, Confidence::FULL);
        car.drive();
    }
    assert_eq!(line.take()[2..], [STANDS, STANDS].concat());
    let report = car.report();
    assert_eq!(report.conduct, DriveState::Arrived);
    assert_eq!((report.to_goal.get(), report.pose.at), (0, GOAL));
    assert_eq!(GOAL, Point::from_mm(-300, 700));
}

/// Everything that the map shows is right before the car, and the rangers see nothing: however far the heads
/// are believed, it does not go ahead.
#[test]
fn it_never_drives_into_a_map_that_it_half_believes() {
    for part in 0..=64 {
        let failed = Failure::new_saturating(Effort::from_num(f64::from(part) / 64.0));
        let mut controller = Controller::new(&CONTROL, Side::Left);
        let near = Reading::Echo(Millimeters::new(120));
        let scan = [near; BEAMS];
        for round in 0..4 {
            let now = Ticks::new(round * 800);
            let dated = |what| Stamped { what, at: now };
            let sides = [Reading::NoObject, near, near, near, near, Reading::NoObject];
            let mut failures = Failures {
                rangefinders: [failed; 6],
                scanner: failed,
            };
            (failures.rangefinders[0], failures.rangefinders[5]) = (Failure::NONE, Failure::NONE);
            let command = controller.step(&ControlInput {
                now,
                pose: POSE,
                goal: GOAL,
                rangefinders: sides.map(dated),
                scan: Stamped {
                    what: &scan,
                    at: now,
                },
                failures,
            });
            let Wheels { right, left } = command.wheels;
            assert!(right + left <= Effort::ZERO, "{part}/64: {command:?}");
        }
    }
}
