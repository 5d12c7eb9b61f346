//! The car's control level: first it looks around, then it drives to its goal.
//!
//! First it stands until every head has swept once: for [`LOOK_AROUND`] rounds in which at most one head was
//! silent, so that what two of them did not see is looked at for as long again. From then on each round
//! decides once, by \[004\] on the car's own map ([`Controller`]), and gives the motors what was decided at a
//! fixed time of the round. Nothing measures how far the wheels turn: the pose is reckoned from what the
//! motors were told ([`Odometer`]).
//!
//! It stands where it has arrived; where too little of what lies ahead is seen by sensors that can be believed;
//! for a round in which a slot was skipped; and while a motor refuses. After either it starts anew from a
//! stand, which takes it a second round. Where it was moving and cannot know how far, as its motors were told
//! late or one of them refused, it is lost; and where nobody started it but itself ([`Start::ByItself`]) it
//! knows no place. Then it looks, maps and reports, but stands until it is started by hand.
//!
//! Dead man's rule: a round in which nothing was decided tells the motors to stand. It takes a main loop that
//! runs: one that hangs leaves the last pulses to the timer until the watchdog bites, after which the car stands.

mod odometer;
mod rules;
mod senses;

pub use odometer::{CHASSIS, Chassis, Odometer};
pub use rules::{CONTROL, GOAL};
use senses::ControlInputs;
pub(super) use senses::RangerInput;

use super::round::{LOOK_FRAMES, ROUND_FRAMES};
use super::{HEADS, MOTOR, POSE, RANGERS, SWEEP};
use crate::board::{Board, MotorWires, Start};
use crate::executive::Due;
use crate::motors::{MotorPulses, Motors};
use crate::telemetry::{self, DriveState};
use certainty_control::{ControlRules, Controller, Side, Wheels};
use certainty_core::fusion::{CertaintyGrid, Environment};
use certainty_core::units::Pose;

/// In so many rounds the car stands and looks around: those of one sweep; rounds in which two heads are silent do not
/// count.
pub const LOOK_AROUND: u32 = SWEEP.directions() as u32;

/// Where the car is, what its motors were told, and what it decided to tell them next.
pub(super) struct Drive<B: Board> {
    motors: Motors<B::Motor>,
    controller: Controller<&'static ControlRules>,
    /// Where the car was when it began to move by `thrust`.
    began: Odometer,
    /// What the motors were told last.
    thrust: MotorPulses,
    /// Where the car is when its heads look, until the motors are told anew.
    looks_from: Pose,
    /// What was decided in this round, until the motors are told.
    decided: Option<(Wheels, DriveState)>,
    /// Rounds in which at most one head was silent, until there are enough.
    looked: u32,
    /// A slot of this round was skipped.
    faltered: bool,
    /// Why the car does not know where it is: it stands until it is started by hand.
    lost: Option<DriveState>,
    /// How the round ended.
    told: telemetry::Drive,
}

impl<B: Board> Drive<B> {
    /// Creates the control level of a car that stands at [`POSE`], as far as whoever started it knows.
    pub(super) fn new(wires: MotorWires<B>, start: Start) -> Self {
        Self {
            motors: Motors::new(wires.right, wires.left, MOTOR),
            controller: Controller::new(&CONTROL, Side::Left),
            began: Odometer::new(POSE),
            thrust: MotorPulses::NONE,
            looks_from: POSE,
            decided: None,
            looked: 0,
            faltered: false,
            lost: match start {
                Start::ByHand => None,
                Start::ByItself => Some(DriveState::Restarted),
            },
            told: told(POSE, Wheels::STOPPED, DriveState::Looking),
        }
    }

    /// Returns where the car believes to be when its heads look, until the motors are told anew.
    pub(super) const fn looks_from(&self) -> Pose {
        self.looks_from
    }

    /// Notes that a slot was skipped.
    pub(super) const fn falter(&mut self) {
        self.faltered = true;
    }

    /// Decides what the motors shall be told in this round.
    ///
    /// Cost: the cells on 55 lines and a control step.
    // Not inlined: the scan would stay on the stack of every other slot.
    #[inline(never)]
    pub(super) fn steer<G: CertaintyGrid>(
        &mut self,
        due: Due,
        map: &Environment<'_, G>,
        silent: &[bool; HEADS as usize],
        rangers: &[RangerInput<'_>; RANGERS as usize],
    ) {
        if self.looked < LOOK_AROUND {
            let gone = silent
                .iter()
                .fold(0_u8, |gone, &head| gone.saturating_add(head.into()));
            if gone <= 1 {
                self.looked = self.looked.saturating_add(1);
            }
            self.decided = Some((Wheels::STOPPED, DriveState::Looking));
            return;
        }
        // Where it will be when it begins to do what is decided now.
        let pose = self.began.after(self.thrust, ROUND_FRAMES).pose();
        let seen = ControlInputs {
            now: due.at,
            pose,
            silent,
            rangers,
        };
        let command = seen.step(&mut self.controller, map);
        self.decided = Some((command.wheels, command.speed_limit.into()));
    }

    /// Tells the motors to stand, later than it should.
    ///
    /// Who stood, stood. Who was moving moved on for nobody knows how long, and stands from now on.
    pub(super) fn drive_late(&mut self) {
        if self.thrust != MotorPulses::NONE {
            self.lost = Some(DriveState::Lost);
        }
        self.falter();
        self.drive();
    }

    /// Tells the motors what was decided, or to stand.
    ///
    /// A motor that refuses to be told otherwise goes on as it did, and one that was told to turn before the other
    /// refused may not hear that it shall stand: unless both stood and were to stand, the car is lost.
    pub(super) fn drive(&mut self) {
        self.began = self.began.after(self.thrust, ROUND_FRAMES);
        let faltered = core::mem::take(&mut self.faltered);
        let decided = self.decided.take().filter(|_| !faltered);
        let (mut wheels, mut conduct) = match self.lost {
            Some(why) => (Wheels::STOPPED, why),
            None => decided.unwrap_or((Wheels::STOPPED, DriveState::Late)),
        };
        self.thrust = match self.motors.drive(wheels) {
            Ok(thrust) => thrust,
            Err(_) => {
                if self.thrust != MotorPulses::NONE || wheels != Wheels::STOPPED {
                    self.lost = Some(DriveState::Lost);
                }
                (wheels, conduct) = (Wheels::STOPPED, DriveState::Refused);
                MotorPulses::NONE
            }
        };
        if matches!(
            conduct,
            DriveState::Late | DriveState::Refused | DriveState::Lost
        ) {
            // The next step begins with a car that stands.
            self.controller = Controller::new(&CONTROL, self.controller.kept_side());
        }
        self.told = told(self.looks_from, wheels, conduct);
        self.looks_from = self.began.after(self.thrust, LOOK_FRAMES).pose();
    }

    /// Returns the report of a round whose motors were told.
    pub(super) const fn report(&self) -> telemetry::Drive {
        self.told
    }
}

const fn told(pose: Pose, wheels: Wheels, conduct: DriveState) -> telemetry::Drive {
    telemetry::Drive {
        pose,
        wheels,
        conduct,
        to_goal: pose.at.distance(GOAL),
    }
}

#[cfg(test)]
mod tests;
