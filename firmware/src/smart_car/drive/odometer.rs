//! Dead reckoning: where the car must be by what its motors were told.

use crate::motors::MotorPulses;
use crate::smart_car::MOTOR;
use crate::smart_car::round::FRAME_MS;
use certainty_core::units::{BinaryAngle, Direction, Point, Pose};

/// What the wheels do with what the motors are told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Chassis {
    /// How fast a wheel goes at full speed, in mm/s.
    pub full_speed_mm_s: u32,
    /// Between the wheels, in mm.
    pub track_mm: u32,
    /// Everything of the car is so near to its middle, in mm.
    pub radius_mm: u32,
}

/// The Smart Car's: at 10 cm/s a round moves it less than a cell, its wheels stand as far apart as its outer
/// heads, and it is a disc about the bar that carries them.
///
/// Open choice: the papers do not say. The middle, about which it turns, is that of its bumper.
pub const CHASSIS: Chassis = Chassis {
    full_speed_mm_s: 100,
    track_mm: 160,
    radius_mm: 80,
};

/// What a wheel goes in a frame, in µm, for each µs of its motor's thrust.
const GOES_UM: i64 = {
    let full_um_a_frame = CHASSIS.full_speed_mm_s as i64 * FRAME_MS as i64;
    let full_us = MOTOR.config().full_us as i64;
    assert!(full_um_a_frame % full_us == 0, "no whole µm");
    full_um_a_frame / full_us
};

/// Fraction bits of [`TURNS_PER_UM`] beyond those of a fine angle, which has 2^-32 of a turn.
const FINER: u32 = 16;

/// By how much of a turn, in steps of 2^-48, the car turns for each µm that one wheel goes further than the
/// other: 1 / (2 π track), 2 π being 6.283185307.
const TURNS_PER_UM: i64 = {
    const TWO_PI_BILLIONTHS: u128 = 6_283_185_307;
    let track_um = CHASSIS.track_mm as u128 * 1000;
    let turn = (1_u128 << (32 + FINER)) * 1_000_000_000;
    let steps = turn / (TWO_PI_BILLIONTHS * track_um);
    assert!(steps < 1 << 32, "so narrow a track overflows");
    (steps & 0xFFFF_FFFF) as i64
};

/// Frames that are reckoned at once: with its wheels at full speed against each other the car turns by a
/// quarter of a radian in them, 4 % of a turn.
const STRIDE: u16 = 10;

/// A pose finer than a [`Pose`]: the place in µm, the heading in 2^-32 of a turn.
///
/// Reckoned, not measured: wheels that slip, a motor that is slow or a push are not in it, and nothing
/// corrects it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Odometer {
    x_um: i64,
    y_um: i64,
    heading: u32,
}

impl Odometer {
    /// Creates it at the middle of the square millimetre of `pose`.
    #[must_use]
    pub const fn new(pose: Pose) -> Self {
        Self {
            x_um: middle_um(pose.at.x_mm()),
            y_um: middle_um(pose.at.y_mm()),
            heading: (pose.heading.to_bits() as u32) << 16,
        }
    }

    /// Returns the pose to the millimetre and to 1/65536 of a turn, rounded.
    #[must_use]
    pub fn pose(&self) -> Pose {
        let at = Point::from_mm(millimeters(self.x_um), millimeters(self.y_um));
        Pose::new(at, angle(self.heading))
    }

    /// Returns where it is after `frames` frames of `thrust`.
    ///
    /// Formula, ten frames at a time: the middle goes the mean of what both wheels go, in the direction half
    /// way through the turn; it turns by their difference over the track. Off by less than 1 % of the way, and
    /// by less than 0.1 mm in a round, against the exact arcs.
    #[must_use]
    pub fn after(self, thrust: MotorPulses, frames: u16) -> Self {
        let mut there = self;
        if thrust == MotorPulses::NONE {
            return there;
        }
        let mut left = frames;
        while left > 0 {
            let stride = left.min(STRIDE);
            there = there.step(thrust, stride);
            left = left.saturating_sub(stride);
        }
        there
    }

    fn step(self, thrust: MotorPulses, frames: u16) -> Self {
        // At most 2^15 µs, 10 frames and 2^5 µm: 24 bits.
        let goes = |us: i16| i64::from(us).wrapping_mul(GOES_UM.wrapping_mul(frames.into()));
        let (right, left) = (goes(thrust.right_us), goes(thrust.left_us));
        // 25 bits times 32.
        let turns = right.wrapping_sub(left).wrapping_mul(TURNS_PER_UM);
        let half = wrapped(turns >> (FINER + 1));
        let whole = wrapped(turns >> FINER);
        let direction = angle(self.heading.wrapping_add(half)).direction();
        // Both wheels' sum is twice the middle's way.
        let sum = right.wrapping_add(left);
        Self {
            x_um: self.x_um.saturating_add(half_part(sum, direction.cos())),
            y_um: self.y_um.saturating_add(half_part(sum, direction.sin())),
            heading: self.heading.wrapping_add(whole),
        }
    }
}

/// The middle of a square millimetre, in µm.
const fn middle_um(mm: i32) -> i64 {
    (mm as i64).wrapping_mul(1000).wrapping_add(500)
}

/// The square millimetre in which a place lies.
fn millimeters(um: i64) -> i32 {
    let mm = um.div_euclid(1000);
    i32::try_from(mm).unwrap_or(if mm < 0 { i32::MIN } else { i32::MAX })
}

/// A fine angle, rounded; modulo a turn.
const fn angle(fine: u32) -> BinaryAngle {
    let [_, _, low, high] = fine.wrapping_add(1 << 15).to_le_bytes();
    BinaryAngle::from_bits(u16::from_le_bytes([low, high]))
}

/// The low 32 bits: angles are modulo a turn.
const fn wrapped(steps: i64) -> u32 {
    let [a, b, c, d, ..] = steps.to_le_bytes();
    u32::from_le_bytes([a, b, c, d])
}

/// Half of `sum` times a part of a unit vector; rounds to the nearest.
const fn half_part(sum: i64, part: i32) -> i64 {
    // 25 bits times 31.
    let product = sum.wrapping_mul(part as i64);
    product.wrapping_add(1 << Direction::FRACTION_BITS) >> (Direction::FRACTION_BITS + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smart_car::POSE;
    use crate::smart_car::round::ROUND_FRAMES;
    use core::f64::consts::TAU;

    const fn thrust(right_us: i16, left_us: i16) -> MotorPulses {
        MotorPulses { right_us, left_us }
    }

    /// 100 mm/s for 40 frames of 20 ms are 80 mm.
    #[test]
    fn full_speed_ahead_is_80_mm_a_round() {
        let there = Odometer::new(POSE).after(thrust(500, 500), 40).pose();
        assert_eq!(there, Pose::new(Point::from_mm(0, 80), POSE.heading));
        let back = Odometer::new(POSE).after(thrust(-250, -250), 40).pose();
        assert_eq!(back.at, Point::from_mm(0, -40));
    }

    /// 80 mm each way on a track of 160 mm is 1 rad: 57.2958°.
    #[test]
    fn wheels_against_each_other_turn_it_on_the_spot() {
        let there = Odometer::new(POSE).after(thrust(500, -500), 40).pose();
        assert_eq!(there.at, Point::ORIGIN);
        let turned = there.heading.wrapping_sub(POSE.heading);
        assert_eq!(turned, BinaryAngle::from_millidegrees(57_296));
    }

    #[test]
    fn no_thrust_is_no_move() {
        let odometer = Odometer::new(POSE).after(thrust(123, 45), 17);
        assert_eq!(odometer.after(MotorPulses::NONE, 40), odometer);
        assert_eq!(odometer.after(thrust(500, -3), 0), odometer);
    }

    /// The exact arcs in floats, over a hundred rounds of all kinds of thrust.
    #[test]
    fn it_is_the_exact_arcs_to_a_tenth_of_a_millimetre_a_round() {
        let mut dice = 1_u32;
        let mut draw = || {
            dice ^= dice << 13;
            dice ^= dice >> 17;
            dice ^= dice << 5;
            (dice % 1001) as i16 - 500
        };
        let mut odometer = Odometer::new(POSE);
        let (mut x, mut y, mut heading) = (0.5, 0.5, TAU / 4.0);
        for round in 1..=100 {
            let (right, left) = (draw(), draw());
            odometer = odometer.after(thrust(right, left), ROUND_FRAMES);
            let way = |us: i16| f64::from(us) / 500.0 * 80.0;
            let middle = f64::midpoint(way(right), way(left));
            let turn = (way(right) - way(left)) / 160.0;
            let chord = if turn == 0.0 {
                middle
            } else {
                middle * (turn / 2.0).sin() / (turn / 2.0)
            };
            x += chord * (heading + turn / 2.0).cos();
            y += chord * (heading + turn / 2.0).sin();
            heading += turn;
            let off = (odometer.x_um as f64 / 1e3 - x).hypot(odometer.y_um as f64 / 1e3 - y);
            assert!(off < 0.1 * f64::from(round), "{off} mm after {round}");
            let turned = f64::from(odometer.heading) / 4_294_967_296.0 * TAU;
            let apart = (turned - heading).rem_euclid(TAU);
            assert!(apart.min(TAU - apart) < 1e-4, "{apart}");
        }
    }
}
