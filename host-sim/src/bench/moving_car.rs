//! The movement of the car by the pulses of its motors.

use super::fault::{MILLISECOND, MotorFault};
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

/// The motors, in the order of their numbers.
const SIDES: [Side; 2] = [Side::Right, Side::Left];

/// A motor's controller ignores pulses more than this, in µs, beyond full speed.
const SLACK_US: u32 = 500;

/// The pose of the car, from its wheels: without a fault of a motor nothing slips, and a wheel reaches its
/// commanded speed at once.
///
/// A motor takes over its pulse in the middle of each frame of 20 ms, and keeps it for a frame; without a
/// pulse, or with an impossible one, it stops. The pose changes from frame to frame only: it is the same for
/// every look within a frame, so that backends that differ by some microseconds give the same readings.
///
/// The car is a disc. One that would touch an obstacle stays where it is, and may turn; each touch counts once,
/// until the car is a centimetre away.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MovingCar {
    /// The pulses of the right and the left motor, in µs.
    pulses: [u32; 2],
    /// The way of the right and the left wheel in this frame, in mm.
    ways: [f64; 2],
    x: f64,
    y: f64,
    /// In turns, within 0..1.
    heading: f64,
    frames: u64,
    touching: bool,
    collisions: u32,
    ground_truth: Vec<GroundTruth>,
    faults: Vec<(Side, MotorFault, Window)>,
    /// The seed of the slip.
    seed: u64,
}

/// The true state of the car in one round, when its heads measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GroundTruth {
    /// Its pose.
    pub pose: Pose,
    /// The collisions so far.
    pub collisions: u32,
}

impl MovingCar {
    /// Creates a car with these faults of its motors, at the firmware's first pose; `seed` is that of the slip.
    #[must_use]
    pub(super) fn new(faults: Vec<(Side, MotorFault, Window)>, seed: u64) -> Self {
        Self {
            pulses: [0; 2],
            ways: [0.0; 2],
            x: f64::from(POSE.at.x_mm()) + 0.5,
            y: f64::from(POSE.at.y_mm()) + 0.5,
            heading: f64::from(POSE.heading.to_bits()) / 65536.0,
            frames: 0,
            touching: false,
            collisions: 0,
            ground_truth: Vec::new(),
            faults,
            seed,
        }
    }

    /// Sets the length of the pulses of the right motor, 0, or the left one, 1.
    ///
    /// Returns whether there is such a motor.
    pub(super) fn set_pulse(&mut self, motor: u8, pulse_us: u32) -> bool {
        let pulse = self.pulses.get_mut(usize::from(motor));
        pulse.map(|pulse| *pulse = pulse_us).is_some()
    }

    /// Advances to `since_ns` after the first servo pulse, with which the frames begin.
    pub(super) fn advance(&mut self, world: &World, since_ns: u64) {
        while self.frames * FRAME_NS + FRAME_NS / 2 <= since_ns {
            self.go(world);
            let [right, left] = self.pulses.map(way_mm);
            self.ways = [right * self.part(Side::Right), left * self.part(Side::Left)];
            if self.frames % ROUND_FRAMES == look_frame() {
                self.ground_truth.push(GroundTruth {
                    pose: self.pose(),
                    collisions: self.collisions,
                });
            }
            self.frames += 1;
        }
    }

    /// Whether the channel of the right motor, 0, or the left one, 1, refuses pulses at this time.
    pub(super) fn is_off(&self, motor: u8, round: u64, at: Ticks) -> bool {
        let mut faults = self.faults.iter();
        faults.any(|(side, fault, window)| {
            *fault == MotorFault::Off
                && SIDES.get(usize::from(motor)) == Some(side)
                && window.contains(round, at)
        })
    }

    /// The part of the commanded way that a wheel goes in this frame.
    fn part(&self, side: Side) -> f64 {
        let at = Ticks::new((self.frames * FRAME_NS / MILLISECOND) as u32);
        let round = self.frames / ROUND_FRAMES;
        let faults = self.faults.iter();
        faults
            .filter(|(of, _, window)| *of == side && window.contains(round, at))
            .map(|(_, fault, _)| fault.part(self.seed, self.frames, side))
            .product()
    }

    /// Returns the pose.
    #[must_use]
    pub(super) fn pose(&self) -> Pose {
        let at = Point::from_mm(self.x.floor() as i32, self.y.floor() as i32);
        Pose::new(at, angle(self.heading))
    }

    /// Returns the true state in each round, when the heads measured.
    #[must_use]
    pub(super) fn ground_truth(&self) -> &[GroundTruth] {
        &self.ground_truth
    }

    /// Moves by one frame.
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
        // It may always move away from what it touches.
        if clearance <= 0.0 && clearance <= before.2 && way != 0.0 {
            self.collisions += u32::from(!self.touching);
            self.touching = true;
            (self.x, self.y, _) = before;
        } else if clearance > 10.0 {
            self.touching = false;
        }
    }

    /// The distance from the outline to the nearest obstacle, in mm; below 0 inside it.
    fn clearance(&self, world: &World) -> f64 {
        let away = world.clearance(self.pose().at);
        away.map_or(f64::INFINITY, |away| away - f64::from(CHASSIS.radius_mm))
    }
}

/// The way of a wheel in a frame, in mm.
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

/// The angle of a number of turns, rounded; whole turns are dropped.
fn angle(turns: f64) -> BinaryAngle {
    BinaryAngle::from_bits((turns.rem_euclid(1.0) * 65536.0).round() as u32 as u16)
}

/// The frame of a round in which the heads measure.
fn look_frame() -> u64 {
    let mut slots = SCHEDULE.slots().iter();
    let look = slots.find(|slot| matches!(slot.activity, Activity::Start(_)));
    let at_ns = look.map_or(0, |slot| u64::from(slot.at)) * MILLISECOND;
    at_ns.saturating_sub(FRAME_NS / 2) / FRAME_NS
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Percentage;
    use crate::world::Obstacle;
    use certainty_core::units::Millimeters;

    fn open() -> World {
        World::new("open", Vec::new())
    }

    /// A car with these pulses from the start.
    fn car_with(right: u32, left: u32) -> MovingCar {
        let mut car = MovingCar::new(Vec::new(), 0);
        assert!(car.set_pulse(0, right) && car.set_pulse(1, left));
        car
    }

    fn at(x: i32, y: i32) -> Pose {
        Pose::new(Point::from_mm(x, y), POSE.heading)
    }

    #[test]
    fn a_pulse_acts_from_the_middle_of_its_frame() {
        let mut car = car_with(2_000, 2_000);
        // Taken at 10 ms; 2 mm further in each frame, all of it at its end.
        for (ms, y) in [(9, 0), (10, 0), (29, 0), (30, 2), (49, 2), (50, 4)] {
            car.advance(&open(), ms * MILLISECOND);
            assert_eq!(car.pose(), at(0, y), "{ms} ms");
        }
        // Set in the second half of a frame, a stop acts from the next middle.
        car.set_pulse(0, 1_500);
        car.set_pulse(1, 1_500);
        car.advance(&open(), 69 * MILLISECOND);
        assert_eq!(car.pose(), at(0, 4));
        car.advance(&open(), 1_000 * MILLISECOND);
        assert_eq!(car.pose(), at(0, 6));
    }

    #[test]
    fn the_size_of_the_steps_changes_nothing() {
        let mut often = car_with(1_900, 1_750);
        let mut once = often.clone();
        for us in 0..200_000 {
            often.advance(&open(), us * 7_000);
        }
        once.advance(&open(), 199_999 * 7_000);
        assert_eq!(often, once);
    }

    /// 80 mm each way on a track of 160 mm is 1 rad, to the hundredth of a degree.
    #[test]
    fn opposite_wheels_turn_on_the_spot() {
        let mut car = car_with(2_000, 1_000);
        car.advance(&open(), 810 * MILLISECOND);
        let turned = car.pose().heading.wrapping_sub(POSE.heading);
        let off = turned.separation(BinaryAngle::from_millidegrees(57_296));
        assert!(off <= BinaryAngle::from_bits(2), "{turned:?}");
        assert_eq!(car.pose().at, POSE.at);
    }

    #[test]
    fn without_a_possible_pulse_it_stops() {
        for us in [0, 400, 2_600, 20_000] {
            let mut car = car_with(us, us);
            car.advance(&open(), 2_000 * MILLISECOND);
            assert_eq!(car.pose(), POSE, "{us} us");
        }
        assert!(!MovingCar::new(Vec::new(), 0).set_pulse(2, 1_500));
    }

    #[test]
    fn each_touch_of_a_wall_counts_once() {
        let (from, to) = (Point::from_mm(-900, 500), Point::from_mm(900, 500));
        let wall = Obstacle::wall(from, to, Millimeters::new(20)).unwrap();
        let world = World::new("a wall across", vec![wall]);
        let mut car = car_with(2_000, 2_000);
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
        let touched: Vec<u32> = car
            .ground_truth()
            .iter()
            .map(|stage| stage.collisions)
            .collect();
        assert_eq!(touched.first(), Some(&0));
        assert_eq!(touched.last(), Some(&2), "{touched:?}");
        assert!(touched.is_sorted());
    }

    /// One pose a round: 31 frames after the command of the round before.
    #[test]
    fn the_true_pose_is_stored_once_a_round() {
        let mut car = car_with(2_000, 2_000);
        car.advance(&open(), 2_400 * MILLISECOND);
        let noted: Vec<i32> = car
            .ground_truth()
            .iter()
            .map(|stage| stage.pose.at.y_mm())
            .collect();
        // From 10 ms to 610 ms: 30 frames of 2 mm, then 40 more a round.
        assert_eq!(noted, [60, 140, 220]);
    }

    /// The pose after this many ms at full speed with a fault of the right motor in round 1.
    fn pose_with(fault: MotorFault, seed: u64, ms: u64) -> Pose {
        let window = Window::Readings {
            from: 1,
            to: Some(2),
        };
        let mut car = MovingCar::new(vec![(Side::Right, fault, window)], seed);
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
    fn a_motor_fault_turns_the_car() {
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
            let before = turned(pose_with(fault, 1, 810));
            let there = turned(pose_with(fault, 1, 1_610));
            let later = turned(pose_with(fault, 1, 2_410));
            assert!(before.abs() < 0.02, "{fault:?} {before}");
            let off = there - f64::to_degrees(radians);
            assert!(off.abs() < 0.2, "{fault:?} {there}");
            assert!((later - there).abs() < 0.02, "{fault:?} {later}");
        }
    }

    /// Different seeds give different ways, the same seed the same.
    #[test]
    fn a_slipping_wheel_loses_half_the_limit_on_average() {
        let slip = MotorFault::Slip(Percentage::try_new(20.0).unwrap());
        let lost: Vec<f64> = (0..20)
            .map(|seed| turned(pose_with(slip, seed, 2_410)))
            .collect();
        let mean = lost.iter().sum::<f64>() / 20.0;
        let expected = f64::to_degrees(0.05);
        assert!((mean - expected).abs() < expected / 10.0, "{lost:?}");
        assert!(lost.iter().any(|&one| one < lost[0]) || lost.iter().any(|&one| one > lost[0]));
        assert_eq!(turned(pose_with(slip, 7, 2_410)), lost[7]);
    }
}
