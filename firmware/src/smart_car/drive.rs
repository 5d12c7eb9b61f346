//! Driving: from the control level's decisions to the motors, with dead reckoning.
//!
//! At first the car stands until every head has swept once: for [`LOOK_AROUND`] rounds, not counting those in
//! which two or more heads had no reading. Then it decides once a round, by \[004\] on its own map
//! ([`Controller`]), and sets the motors at a fixed time of the round. Nothing measures how far the wheels
//! turn; the pose is reckoned from the motor pulses ([`Odometer`]).
//!
//! | it stands | until |
//! |---|---|
//! | at the goal, or if trusted sensors cover too little of the view ahead | that changes |
//! | because a slot was skipped, or a motor's channel failed while it stood and was to stand | the round after next: it restarts from zero speed |
//! | because it moved an unknown distance: its motors were set late, or one failed while it moved or was to move | a manual reset |
//! | because it was reset automatically ([`ResetCause::Automatic`]), so its pose is unknown | a manual reset |
//!
//! While it stands it continues to sense, map and report.
//!
//! A round without a decision stops the motors. This needs a running main loop: if it hangs, the timer repeats
//! the last pulses until the watchdog resets the microcontroller; then the car stands.

use super::config::{HEADS, MOTOR, POSE, RANGERS, SWEEP, SmartCarGrid};
use super::control::{CONTROL, ControlInputs, GOAL, RangerInput};
use super::odometer::Odometer;
use super::round::{LOOK_FRAMES, ROUND_FRAMES};
use crate::board::{Board, MotorWires, ResetCause};
use crate::executive::Due;
use crate::motors::{MotorPulses, Motors};
use crate::telemetry::{self, DriveState};
use certainty_control::{ControlRules, Controller, Side, Wheels};
use certainty_core::fusion::Environment;
use certainty_core::units::Pose;

/// The rounds in which the car stands and looks around at first: one sweep. Rounds in which two or more heads
/// have no reading do not count.
pub const LOOK_AROUND: u32 = SWEEP.directions() as u32;

/// The car's pose, its last motor command and its next decision.
pub(super) struct Drive<B: Board> {
    motors: Motors<B::Motor>,
    controller: Controller<&'static ControlRules>,
    /// The pose at the start of the current motor command.
    began: Odometer,
    /// The current motor command.
    pulses: MotorPulses,
    /// The pose at the end of the current motor command, where this round has computed it: *steer* has the time
    /// for it, *drive* has two milliseconds.
    ends: Option<Odometer>,
    /// The pose from which the heads measure in this round.
    looks_from: Pose,
    /// This round's decision, until the motors are set.
    decided: Option<(Wheels, DriveState)>,
    /// Rounds of the first sweep that count, up to [`LOOK_AROUND`].
    looked: u32,
    /// A slot of this round was skipped.
    slot_skipped: bool,
    /// Why the pose is unknown; the car then stands until a manual reset.
    lost: Option<DriveState>,
    /// The report of the round.
    report: telemetry::Drive,
}

impl<B: Board> Drive<B> {
    /// Creates the drive of a car that stands at [`POSE`]; after an automatic reset its pose is unknown.
    pub(super) fn new(wires: MotorWires<B>, reset_cause: ResetCause) -> Self {
        Self {
            motors: Motors::new(wires.right, wires.left, MOTOR),
            controller: Controller::new(&CONTROL, Side::Left),
            began: Odometer::new(POSE),
            pulses: MotorPulses::NONE,
            ends: None,
            looks_from: POSE,
            decided: None,
            looked: 0,
            slot_skipped: false,
            lost: match reset_cause {
                ResetCause::Manual => None,
                ResetCause::Automatic => Some(DriveState::Restarted),
            },
            report: report(POSE, Wheels::STOPPED, DriveState::Looking),
        }
    }

    /// Returns the reckoned pose from which the heads measure in this round.
    pub(super) const fn looks_from(&self) -> Pose {
        self.looks_from
    }

    /// Notes that a slot of this round was skipped.
    pub(super) const fn note_skipped_slot(&mut self) {
        self.slot_skipped = true;
    }

    /// Decides this round's motor command.
    ///
    /// `missing` marks the heads that had no reading. Cost: the cells on 55 lines and a control step.
    // Not inlined: otherwise the scan is on the stack in every other slot.
    #[inline(never)]
    pub(super) fn steer(
        &mut self,
        due: Due,
        map: &Environment<'_, SmartCarGrid>,
        missing: &[bool; HEADS as usize],
        rangers: &[RangerInput<'_>; RANGERS as usize],
    ) {
        if self.looked < LOOK_AROUND {
            let count = missing
                .iter()
                .fold(0_u8, |count, &head| count.saturating_add(head.into()));
            if count <= 1 {
                self.looked = self.looked.saturating_add(1);
            }
            self.decided = Some((Wheels::STOPPED, DriveState::Looking));
            return;
        }
        // The new command takes effect where the current one ends.
        let ends = self.began.after(self.pulses, ROUND_FRAMES);
        self.ends = Some(ends);
        let inputs = ControlInputs {
            now: due.at,
            pose: ends.pose(),
            missing,
            rangers,
        };
        let command = inputs.step(&mut self.controller, map);
        self.decided = Some((command.wheels, command.speed_limit.into()));
    }

    /// Stops the motors, after their slot.
    ///
    /// If the car was stopped, the pose is still valid. If it was moving, the distance is unknown and the pose
    /// is lost.
    pub(super) fn drive_late(&mut self) {
        if self.pulses != MotorPulses::NONE {
            self.lost = Some(DriveState::Lost);
        }
        self.note_skipped_slot();
        self.drive();
    }

    /// Sets the motors to this round's decision, or stops them.
    ///
    /// A motor whose channel fails may keep its old speed, and the other may already have its new one. So after
    /// an error the pose is lost, unless the car stood and was to stand.
    pub(super) fn drive(&mut self) {
        let ends = self.ends.take();
        self.began = ends.unwrap_or_else(|| self.began.after(self.pulses, ROUND_FRAMES));
        let slot_skipped = core::mem::take(&mut self.slot_skipped);
        let decided = self.decided.take().filter(|_| !slot_skipped);
        let (mut wheels, mut state) = match self.lost {
            Some(why) => (Wheels::STOPPED, why),
            None => decided.unwrap_or((Wheels::STOPPED, DriveState::Late)),
        };
        self.pulses = match self.motors.drive(wheels) {
            Ok(pulses) => pulses,
            Err(_) => {
                if self.pulses != MotorPulses::NONE || wheels != Wheels::STOPPED {
                    self.lost = Some(DriveState::Lost);
                }
                (wheels, state) = (Wheels::STOPPED, DriveState::Refused);
                MotorPulses::NONE
            }
        };
        if matches!(
            state,
            DriveState::Late | DriveState::Refused | DriveState::Lost
        ) {
            // The next step starts from zero speed.
            self.controller = Controller::new(&CONTROL, self.controller.kept_side());
        }
        self.report = report(self.looks_from, wheels, state);
        self.looks_from = self.began.after(self.pulses, LOOK_FRAMES).pose();
    }

    /// Returns the report of the last motor command.
    pub(super) const fn report(&self) -> telemetry::Drive {
        self.report
    }
}

const fn report(pose: Pose, wheels: Wheels, state: DriveState) -> telemetry::Drive {
    telemetry::Drive {
        pose,
        wheels,
        state,
        to_goal: pose.at.distance(GOAL),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::remote::{Channel, Link, RemoteBoard, RemotePwm, Request, RequestRefused};
    use crate::smart_car::config::{CELLS, SENSORS, SmartCarShape};
    use certainty_control::{BEAMS, ControlInput, Effort, Failure, Failures, Stamped};
    use certainty_core::fusion::{RobustRules, owner_bytes};
    use certainty_core::health::{Confidence, Health};
    use certainty_core::transducer::{Missing, Reading};
    use certainty_core::units::{Millimeters, Point, Ticks};
    use core::cell::{Cell, RefCell};

    /// Records the motors' pulses, in µs; refuses those of the motor `failing`.
    #[derive(Default)]
    struct Line {
        pulses: RefCell<Vec<(u8, u16)>>,
        failing: Cell<Option<u8>>,
    }

    impl Line {
        /// Returns what was recorded since the last call.
        fn take(&self) -> Vec<(u8, u16)> {
            self.pulses.take()
        }
    }

    impl Link for Line {
        fn request(&self, request: Request) -> Result<u32, RequestRefused> {
            match request {
                Request::Pulse(Channel::Motor(motor), _) if self.failing.get() == Some(motor) => {
                    Err(RequestRefused)
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
        car_after(line, ResetCause::Manual)
    }

    fn car_after(line: &Line, cause: ResetCause) -> Drive<RemoteBoard<'_, Line>> {
        let wires = MotorWires {
            right: RemotePwm::new(line, Channel::Motor(0)),
            left: RemotePwm::new(line, Channel::Motor(1)),
        };
        Drive::new(wires, cause)
    }

    const STANDS: [(u8, u16); 2] = [(0, 1_500), (1, 1_500)];

    /// Steers in `round`, on an empty map of sensors with this confidence; all readings are missing or none.
    fn steer(
        car: &mut Drive<RemoteBoard<'_, Line>>,
        round: u32,
        missing: bool,
        confidence: Confidence,
    ) {
        steer_with(car, round, [missing; 3], confidence);
    }

    /// The same with these heads' readings missing; the rangers' are missing if all are.
    fn steer_with(
        car: &mut Drive<RemoteBoard<'_, Line>>,
        round: u32,
        missing: [bool; 3],
        confidence: Confidence,
    ) {
        let owners = [0; owner_bytes(CELLS, SENSORS)];
        let rules = RobustRules::DEFAULT;
        let grid = SmartCarGrid::try_new(SmartCarShape, rules, SENSORS, [0; CELLS], owners);
        let grid = grid.unwrap();
        let health = [Health::new(confidence); SENSORS as usize];
        let at = Ticks::new(round * 800 + 721);
        let reading = if missing == [true; 3] {
            Reading::Missing(Missing::Timeout)
        } else {
            Reading::NoObject
        };
        let ranger = RangerInput {
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
        car.steer(due, &map, &missing, &[ranger, ranger]);
    }

    /// Returns a car that has looked around and drives; its recorded pulses are cleared.
    fn going(line: &Line) -> Drive<RemoteBoard<'_, Line>> {
        let mut car = car(line);
        for round in 0..LOOK_AROUND + 3 {
            steer(&mut car, round, false, Confidence::FULL);
            car.drive();
        }
        assert_eq!(car.report().state, DriveState::Going);
        assert_ne!(car.pulses, MotorPulses::NONE);
        line.take();
        car
    }

    #[test]
    fn it_stands_for_the_first_sweep() {
        let line = Line::default();
        let mut car = car(&line);
        for round in 0..37 {
            steer(&mut car, round, false, Confidence::FULL);
            car.drive();
            assert_eq!(line.take(), STANDS, "round {round}");
            assert_eq!(car.report().state, DriveState::Looking);
        }
        assert_eq!(car.looks_from(), POSE);
    }

    /// Directions that two heads missed in the first sweep are not known to be free.
    #[test]
    fn a_round_with_two_missing_heads_does_not_count() {
        let line = Line::default();
        let mut car = car(&line);
        let one = [false, true, false];
        let two = [true, true, false];
        for (rounds, missing) in [(0..20, one), (20..50, two), (50..67, one)] {
            for round in rounds {
                steer_with(&mut car, round, missing, Confidence::FULL);
                car.drive();
                assert_eq!(car.report().state, DriveState::Looking, "round {round}");
            }
        }
        steer(&mut car, 67, false, Confidence::FULL);
        car.drive();
        assert_eq!(car.report().state, DriveState::Going);
    }

    #[test]
    fn after_the_sweep_it_drives_towards_its_goal() {
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
        let set = line.take();
        assert_eq!(set.len(), 2);
        assert!(set.iter().all(|(_, us)| (1_000..=2_000).contains(us)));
    }

    #[test]
    fn a_round_without_a_decision_stops_the_motors() {
        let line = Line::default();
        let mut car = going(&line);
        car.drive();
        assert_eq!(line.take(), STANDS);
        assert_eq!(car.report().state, DriveState::Late);
        // The previous command moved it for one more round; from now on it stands.
        let there = car.looks_from();
        car.drive();
        assert_eq!(car.looks_from(), there);
    }

    #[test]
    fn a_skipped_slot_makes_it_stand_for_two_rounds() {
        let line = Line::default();
        let mut car = going(&line);
        steer(&mut car, LOOK_AROUND + 3, false, Confidence::FULL);
        car.note_skipped_slot();
        car.drive();
        assert_eq!(line.take(), STANDS);
        assert_eq!(car.report().state, DriveState::Late);
        // It restarts: no time has passed for the first decision, so it cannot accelerate.
        steer(&mut car, LOOK_AROUND + 4, false, Confidence::FULL);
        car.drive();
        assert_eq!(car.report().state, DriveState::Going);
        assert_eq!(line.take(), STANDS);
        steer(&mut car, LOOK_AROUND + 5, false, Confidence::FULL);
        car.drive();
        assert_eq!(car.report().state, DriveState::Going);
        assert_ne!(car.pulses, MotorPulses::NONE);
    }

    #[test]
    fn a_failing_motor_stops_the_other() {
        for (failing, other) in [(0, 1), (1, 0)] {
            let line = Line::default();
            let mut car = going(&line);
            line.failing.set(Some(failing));
            steer(&mut car, LOOK_AROUND + 3, false, Confidence::FULL);
            car.drive();
            assert_eq!(line.take().last(), Some(&(other, 1_500)));
            assert_eq!(car.report().state, DriveState::Refused);
            let there = car.looks_from();
            car.drive();
            assert_eq!(car.looks_from(), there, "it is reckoned to stand");
            // The distance of the failing motor is unknown, so the car stays when the channel works again.
            line.failing.set(None);
            assert_stands_for_good(&mut car, &line, DriveState::Lost);
        }
    }

    /// The other motor may already turn and may not receive the stop.
    #[test]
    fn a_motor_failing_at_the_start_of_a_move_loses_the_pose() {
        for failing in [0, 1] {
            let line = Line::default();
            let mut car = going(&line);
            car.drive();
            steer(&mut car, LOOK_AROUND + 4, false, Confidence::FULL);
            car.drive();
            assert_eq!(car.pulses, MotorPulses::NONE);
            line.failing.set(Some(failing));
            steer(&mut car, LOOK_AROUND + 5, false, Confidence::FULL);
            car.drive();
            assert_eq!(car.report().state, DriveState::Refused);
            line.failing.set(None);
            assert_stands_for_good(&mut car, &line, DriveState::Lost);
        }
    }

    #[test]
    fn a_motor_failing_while_the_car_stands_costs_only_time() {
        let line = Line::default();
        let mut car = car(&line);
        line.failing.set(Some(1));
        for round in 0..20 {
            steer(&mut car, round, false, Confidence::FULL);
            car.drive();
            assert_eq!(car.report().state, DriveState::Refused);
        }
        line.failing.set(None);
        for round in 20..LOOK_AROUND + 3 {
            steer(&mut car, round, false, Confidence::FULL);
            car.drive();
        }
        assert_eq!(car.report().state, DriveState::Going);
        assert_ne!(car.pulses, MotorPulses::NONE);
    }

    /// Steers a few more rounds and asserts that the car stands in this state.
    fn assert_stands_for_good(
        car: &mut Drive<RemoteBoard<'_, Line>>,
        line: &Line,
        why: DriveState,
    ) {
        for round in LOOK_AROUND + 5..LOOK_AROUND + 9 {
            line.take();
            steer(car, round, false, Confidence::FULL);
            car.drive();
            assert_eq!(line.take(), STANDS);
            assert_eq!(car.report().state, why);
        }
    }

    #[test]
    fn a_moving_car_set_late_is_lost() {
        let line = Line::default();
        let mut car = going(&line);
        steer(&mut car, LOOK_AROUND + 3, false, Confidence::FULL);
        car.drive_late();
        assert_eq!(line.take(), STANDS);
        assert_eq!(car.report().state, DriveState::Lost);
        assert_stands_for_good(&mut car, &line, DriveState::Lost);
    }

    #[test]
    fn after_an_automatic_reset_it_stands() {
        let line = Line::default();
        let mut car = car_after(&line, ResetCause::Automatic);
        for round in 0..LOOK_AROUND + 9 {
            steer(&mut car, round, false, Confidence::FULL);
            car.drive();
            assert_eq!(line.take(), STANDS, "round {round}");
            assert_eq!(car.report().state, DriveState::Restarted);
        }
        assert_eq!(car.looks_from(), POSE);
    }

    #[test]
    fn a_standing_car_set_late_drives_on() {
        let line = Line::default();
        let mut car = car(&line);
        steer(&mut car, 3, false, Confidence::FULL);
        car.drive_late();
        assert_eq!(car.report().state, DriveState::Late);
        for round in 4..LOOK_AROUND + 6 {
            steer(&mut car, round, false, Confidence::FULL);
            car.drive();
        }
        assert_eq!(car.report().state, DriveState::Going);
    }

    #[test]
    fn without_trusted_readings_it_stands() {
        let inputs = [(true, Confidence::FULL), (false, Confidence::NONE)];
        for (missing, confidence) in inputs {
            let line = Line::default();
            let mut car = going(&line);
            steer(&mut car, LOOK_AROUND + 3, missing, confidence);
            car.drive();
            assert_eq!(line.take(), STANDS);
            assert_eq!(car.report().state, DriveState::Blind);
        }
    }

    #[test]
    fn at_its_goal_it_stands() {
        let line = Line::default();
        let mut car = going(&line);
        car.began = Odometer::new(Pose::new(GOAL, POSE.heading));
        car.pulses = MotorPulses::NONE;
        for round in LOOK_AROUND + 3..LOOK_AROUND + 6 {
            steer(&mut car, round, false, Confidence::FULL);
            car.drive();
        }
        assert_eq!(line.take()[2..], [STANDS, STANDS].concat());
        let report = car.report();
        assert_eq!(report.state, DriveState::Arrived);
        assert_eq!((report.to_goal.get(), report.pose.at), (0, GOAL));
        assert_eq!(GOAL, Point::from_mm(-300, 700));
    }

    /// The map shows obstacles right before the car while the rangers measure none: whatever the trust in the
    /// heads, the car does not drive ahead.
    #[test]
    fn it_never_drives_into_a_half_trusted_map() {
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
                (failures.rangefinders[0], failures.rangefinders[5]) =
                    (Failure::NONE, Failure::NONE);
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
}
