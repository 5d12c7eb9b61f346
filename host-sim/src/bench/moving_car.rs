//! The car on its wheels: where the motors' pulses take it.

use super::{MILLISECOND, MotorFault};
use crate::fault::Window;
use crate::world::World;
use certainty_control::Side;
use certainty_core::schedule::Activity;
use certainty_core::units::{BinaryAngle, Direction, Point, Pose, Ticks};
use certainty_firmware::smart_car::{CHASSIS, MOTOR, POSE, SCHEDULE};
use core::f64::consts::TAU;

/// Nanoseconds from one pulse of a motor to the next.
const FRAME_NS: u64 = MOTOR.config().period_us as u64 * 1000;

/// Frames of a round.
const ROUND_FRAMES: u64 = SCHEDULE.period() as u64 * MILLISECOND / FRAME_NS;

/// Which motor has which number.
const SIDES: [Side; 2] = [Side::Right, Side::Left];

/// A motor's controller takes no pulse that is off by more than this, in µs, beyond full speed.
const SLACK_US: u32 = 500;

/// Where the car is as its wheels take it: unless a motor is broken nothing slips, and a wheel is as fast as it is
/// told at once.
///
/// A motor takes its pulse in the middle of each frame of 20 ms, when it has come, and holds it for a frame;
/// without a pulse, or with one that cannot be, it stands. The place changes with the frame alone: a look at any
/// time within one is from the same place, so that boards that are some microseconds apart see the same.
///
/// The car is a disc. One that would touch an obstacle stays where it is, and may turn; each touch counts once,
/// until it is clear by a centimetre.
#[derive(Debug, Clone, PartialEq)]
pub struct MovingCar {
    /// What the pins give the right and the left motor, in µs.
    pulses: [u32; 2],
    /// What the motors do in this frame, in mm.
    ways: [f64; 2],
    x: f64,
    y: f64,
    /// Turns, within 0..1.
    heading: f64,
    frames: u64,
    touching: bool,
    collisions: u32,
    stages: Vec<Stage>,
    faults: Vec<(Side, MotorFault, Window)>,
    /// Names the slip.
    seed: u64,
}

/// Where the car truly was when its heads looked in a round.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stage {
    /// Where.
    pub pose: Pose,
    /// How often it had touched an obstacle by then.
    pub collisions: u32,
}

impl MovingCar {
    /// Creates the car, which stands at the firmware's first pose.
    #[must_use]
    pub fn new() -> Self {
        Self::with_faults(Vec::new(), 0)
    }

    /// Creates a car with these faults of its motors; `seed` names how a wheel slips.
    #[must_use]
    pub fn with_faults(faults: Vec<(Side, MotorFault, Window)>, seed: u64) -> Self {
        Self {
            pulses: [0; 2],
            ways: [0.0; 2],
            x: f64::from(POSE.at.x_mm()) + 0.5,
            y: f64::from(POSE.at.y_mm()) + 0.5,
            heading: f64::from(POSE.heading.to_bits()) / 65536.0,
            frames: 0,
            touching: false,
            collisions: 0,
            stages: Vec::new(),
            faults,
            seed,
        }
    }

    /// Sets the length of the pulses of the right motor, 0, or the left one, 1.
    ///
    /// Returns whether there is such a motor.
    pub fn set_pulse(&mut self, motor: u8, pulse_us: u32) -> bool {
        let pulse = self.pulses.get_mut(usize::from(motor));
        pulse.map(|pulse| *pulse = pulse_us).is_some()
    }

    /// Lets time pass until `since_ns` after the first servo pulse, with which the frames begin.
    pub fn advance(&mut self, world: &World, since_ns: u64) {
        while self.frames * FRAME_NS + FRAME_NS / 2 <= since_ns {
            self.go(world);
            let [right, left] = self.pulses.map(way_mm);
            self.ways = [right * self.part(Side::Right), left * self.part(Side::Left)];
            if self.frames % ROUND_FRAMES == look_frame() {
                self.stages.push(Stage {
                    pose: self.pose(),
                    collisions: self.collisions,
                });
            }
            self.frames += 1;
        }
    }

    /// Whether the channel of the right motor, 0, or the left one, 1, refuses in this round at this time.
    pub(super) fn is_off(&self, motor: u8, round: u64, at: Ticks) -> bool {
        let mut faults = self.faults.iter();
        faults.any(|(side, fault, window)| {
            *fault == MotorFault::Off
                && SIDES.get(usize::from(motor)) == Some(side)
                && window.contains(round, at)
        })
    }

    /// What part of the way that it was told a wheel goes in this frame.
    fn part(&self, side: Side) -> f64 {
        let at = Ticks::new((self.frames * FRAME_NS / MILLISECOND) as u32);
        let round = self.frames / ROUND_FRAMES;
        let faults = self.faults.iter();
        faults
            .filter(|(of, _, window)| *of == side && window.contains(round, at))
            .map(|(_, fault, _)| fault.part(self.seed, self.frames, side))
            .product()
    }

    /// Returns where it is.
    #[must_use]
    pub fn pose(&self) -> Pose {
        let at = Point::from_mm(self.x.floor() as i32, self.y.floor() as i32);
        Pose::new(at, angle(self.heading))
    }

    /// Returns where it was when its heads looked, a round after the other.
    #[must_use]
    pub fn stages(&self) -> &[Stage] {
        &self.stages
    }

    /// Moves by what the wheels do in a frame.
    fn go(&mut self, world: &World) {
        let [right, left] = self.ways;
        if right == 0.0 && left == 0.0 {
            return;
        }
        let turn = (right - left) / (f64::from(CHASSIS.track_mm) * TAU);
        let direction = angle(self.heading + turn / 2.0).direction();
        let way = f64::midpoint(right, left) / f64::from(1_u32 << Direction::FRACTION_BITS);
        let before = (self.x, self.y, self.clearance(world));
        self.heading = (self.heading + turn).rem_euclid(1.0);
        self.x += way * f64::from(direction.cos());
        self.y += way * f64::from(direction.sin());
        let clearance = self.clearance(world);
        // Away from what it touches it may always go.
        if clearance <= 0.0 && clearance <= before.2 && way != 0.0 {
            self.collisions += u32::from(!self.touching);
            self.touching = true;
            (self.x, self.y, _) = before;
        } else if clearance > 10.0 {
            self.touching = false;
        }
    }

    /// How far the nearest obstacle is from the outline, in mm; below 0 within it.
    fn clearance(&self, world: &World) -> f64 {
        let away = world.clearance(self.pose().at);
        away.map_or(f64::INFINITY, |away| away - f64::from(CHASSIS.radius_mm))
    }
}

impl Default for MovingCar {
    fn default() -> Self {
        Self::new()
    }
}

/// How far a wheel goes in a frame, in mm.
fn way_mm(pulse_us: u32) -> f64 {
    let motor = MOTOR.config();
    let (stand, full) = (u32::from(motor.stand_us), u32::from(motor.full_us));
    if pulse_us.abs_diff(stand) > full + SLACK_US {
        return 0.0;
    }
    let part = (f64::from(pulse_us) - f64::from(stand)) / f64::from(full);
    let seconds = FRAME_NS as f64 / 1e9;
    part.clamp(-1.0, 1.0) * f64::from(CHASSIS.full_speed_mm_s) * seconds
}

/// Turns as an angle, rounded; a whole turn wraps to none.
fn angle(turns: f64) -> BinaryAngle {
    BinaryAngle::from_bits((turns.rem_euclid(1.0) * 65536.0).round() as u32 as u16)
}

/// The frame of a round in which the heads look.
fn look_frame() -> u64 {
    let mut slots = SCHEDULE.slots().iter();
    let look = slots.find(|slot| matches!(slot.activity, Activity::Start(_)));
    let at_ns = look.map_or(0, |slot| u64::from(slot.at)) * MILLISECOND;
    at_ns.saturating_sub(FRAME_NS / 2) / FRAME_NS
}
