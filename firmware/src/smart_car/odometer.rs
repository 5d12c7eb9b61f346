//! Dead reckoning: the pose that follows from the motor pulses.

use super::config::{CHASSIS, MOTOR};
use super::round::FRAME_MS;
use crate::motors::MotorPulses;
use certainty_core::units::{BinaryAngle, Point, Pose};
use micromath::F32Ext;

/// The distance of a wheel in a PWM frame, in µm, for each µs of its motor's pulse change.
const DISTANCE_UM: i32 = {
    let full_um_a_frame = CHASSIS.full_speed_mm_s * FRAME_MS as u32;
    let full_us = MOTOR.config().full_us as u32;
    assert!(
        full_um_a_frame.is_multiple_of(full_us),
        "a µs of pulse change must be a whole number of µm a frame"
    );
    (full_um_a_frame / full_us).cast_signed()
};

/// Fraction bits of [`TURNS_PER_UM`] beyond those of a fine angle, which has 2^-32 of a turn.
const FINER: u32 = 16;

/// The car's turn for each µm by which one wheel moves farther than the other, in 2^-48 of a full turn:
/// 1 / (2 π track), with 2 π = 6.283185307.
const TURNS_PER_UM: i64 = {
    const TWO_PI_BILLIONTHS: u128 = 6_283_185_307;
    let track_um = CHASSIS.track_mm as u128 * 1000;
    let turn = (1_u128 << (32 + FINER)) * 1_000_000_000;
    let steps = turn / (TWO_PI_BILLIONTHS * track_um);
    assert!(
        steps < 1 << 32,
        "the track is too narrow: the steps must fit 32 bits"
    );
    (steps & 0xFFFF_FFFF) as i64
};

/// PWM frames a reckoning step: with its wheels at full speed in opposite directions the car turns by a
/// quarter of a radian in a step, 4 % of a turn.
const STEP_FRAMES: u16 = 10;

/// A dead-reckoned pose, finer than a [`Pose`]: the position in µm, the heading in 2^-32 of a turn.
///
/// It is computed from motor pulses, not measured: slipping wheels, a slow motor or a push are not included,
/// and nothing corrects it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Odometer {
    x_um: i32,
    y_um: i32,
    heading: u32,
}

impl Odometer {
    /// Creates an odometer at the centre of the square millimetre of `pose`.
    pub(super) const fn new(pose: Pose) -> Self {
        Self {
            x_um: middle_um(pose.at.x_mm()),
            y_um: middle_um(pose.at.y_mm()),
            heading: (pose.heading.to_bits() as u32) << 16,
        }
    }

    /// Returns the pose to the millimetre and to 1/65536 of a turn, rounded.
    pub(super) fn pose(&self) -> Pose {
        let at = Point::from_mm(millimeters(self.x_um), millimeters(self.y_um));
        Pose::new(at, angle(self.heading))
    }

    /// Returns the pose after `frames` PWM frames of `pulses`.
    ///
    /// Formula, for ten frames at a time: the middle moves by the mean of both wheels' distances, in the
    /// direction half way through the turn; the car turns by their difference over the track. Against the exact
    /// arcs the error is below 0.2 % of the way and below 0.1 mm a round, most of it the approximated sine.
    pub(super) fn after(self, pulses: MotorPulses, frames: u16) -> Self {
        let mut there = self;
        if pulses == MotorPulses::NONE {
            return there;
        }
        let mut left = frames;
        while left > 0 {
            let frames = left.min(STEP_FRAMES);
            there = there.step(pulses, frames);
            left = left.saturating_sub(frames);
        }
        there
    }

    fn step(self, pulses: MotorPulses, frames: u16) -> Self {
        // At most 2^15 µs, 10 frames and 2^5 µm: 24 bits.
        let distance =
            |us: i16| i32::from(us).wrapping_mul(DISTANCE_UM.wrapping_mul(frames.into()));
        let (right, left) = (distance(pulses.right_us), distance(pulses.left_us));
        // 25 bits times 32.
        let turns = i64::from(right.wrapping_sub(left)).wrapping_mul(TURNS_PER_UM);
        let half = wrapped(turns >> (FINER + 1));
        let whole = wrapped(turns >> FINER);
        // The sum of both wheels' distances is twice the middle's.
        let middle = right.wrapping_add(left) / 2;
        let (x, y) = displacement(self.heading.wrapping_add(half), middle);
        Self {
            x_um: self.x_um.saturating_add(x),
            y_um: self.y_um.saturating_add(y),
            heading: self.heading.wrapping_add(whole),
        }
    }
}

/// Returns the centre of a square millimetre, in µm.
const fn middle_um(mm: i32) -> i32 {
    mm.saturating_mul(1000).saturating_add(500)
}

/// Returns the square millimetre that contains a position.
const fn millimeters(um: i32) -> i32 {
    um.div_euclid(1000)
}

/// Rounds a fine angle; modulo a turn.
const fn angle(fine: u32) -> BinaryAngle {
    let [_, _, low, high] = fine.wrapping_add(1 << 15).to_le_bytes();
    BinaryAngle::from_bits(u16::from_le_bytes([low, high]))
}

/// Returns the low 32 bits: angles are modulo a turn.
const fn wrapped(steps: i64) -> u32 {
    let [a, b, c, d, ..] = steps.to_le_bytes();
    u32::from_le_bytes([a, b, c, d])
}

/// Returns how far along x and y a `distance` leads in the direction `heading`, in 2^-32 of a turn.
///
/// Units and range: µm, the distance within ±2^24. By `micromath`, whose cosine is off by at most 0.0011 and
/// exact at quarter turns: 0.09 mm in a round of 80 mm. Rounds towards zero. 32-bit floats without fused
/// operations are the same on every machine, so a run still has the same bits everywhere.
#[expect(
    clippy::float_arithmetic,
    clippy::cast_possible_truncation,
    reason = "an approximation of 0.11 % is enough here; the casts saturate"
)]
fn displacement(heading: u32, distance: i32) -> (i32, i32) {
    const RADIANS: f32 = core::f32::consts::TAU / 4_294_967_296.0;
    let heading = heading.cast_signed() as f32 * RADIANS;
    let distance = distance as f32;
    let along = |part: f32| (distance * part) as i32;
    (along(F32Ext::cos(heading)), along(F32Ext::sin(heading)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smart_car::config::POSE;
    use crate::smart_car::round::ROUND_FRAMES;
    use core::f64::consts::TAU;

    const fn pulses(right_us: i16, left_us: i16) -> MotorPulses {
        MotorPulses { right_us, left_us }
    }

    /// 100 mm/s for 40 frames of 20 ms are 80 mm.
    #[test]
    fn full_speed_ahead_is_80_mm_a_round() {
        let there = Odometer::new(POSE).after(pulses(500, 500), 40).pose();
        assert_eq!(there, Pose::new(Point::from_mm(0, 80), POSE.heading));
        let back = Odometer::new(POSE).after(pulses(-250, -250), 40).pose();
        assert_eq!(back.at, Point::from_mm(0, -40));
    }

    /// 80 mm each way on a track of 160 mm is 1 rad: 57.2958°.
    #[test]
    fn opposite_wheels_turn_it_on_the_spot() {
        let there = Odometer::new(POSE).after(pulses(500, -500), 40).pose();
        assert_eq!(there.at, Point::ORIGIN);
        let turned = there.heading.wrapping_sub(POSE.heading);
        assert_eq!(turned, BinaryAngle::from_millidegrees(57_296));
    }

    #[test]
    fn without_pulses_it_does_not_move() {
        let odometer = Odometer::new(POSE).after(pulses(123, 45), 17);
        assert_eq!(odometer.after(MotorPulses::NONE, 40), odometer);
        assert_eq!(odometer.after(pulses(500, -3), 0), odometer);
    }

    /// Micromath's approximation at every bearing that a pose can have.
    #[test]
    fn a_displacement_is_off_by_0_11_percent_at_most() {
        const DISTANCE: i32 = 1 << 24;
        for bits in 0..=u16::MAX {
            let (x, y) = displacement(u32::from(bits) << 16, DISTANCE);
            let (sin, cos) = (f64::from(bits) / 65_536.0 * TAU).sin_cos();
            for (approximate, exact) in [(x, cos), (y, sin)] {
                let off = (f64::from(approximate) / f64::from(DISTANCE) - exact).abs();
                assert!(off < 0.0011, "{off} at {bits}");
            }
        }
        for (quarter, expected) in [(0, (1, 0)), (1, (0, 1)), (2, (-1, 0)), (3, (0, -1))] {
            let (x, y) = displacement(quarter << 30, 20_000);
            assert_eq!(
                (x, y),
                (expected.0 * 20_000, expected.1 * 20_000),
                "{quarter}"
            );
        }
    }

    /// Another version of micromath, or a compiler that fuses operations, would change the digest.
    #[test]
    fn displacements_have_the_same_bits_everywhere() {
        let mut digest = crate::digest::Digest::NEW;
        for step in 0..10_000_u32 {
            let (x, y) = displacement(step.wrapping_mul(2_654_435_769), step as i32 - 5000);
            digest.bytes(&x.to_le_bytes());
            digest.bytes(&y.to_le_bytes());
        }
        assert_eq!(digest.value(), 0xE97D_C9F9);
    }

    /// Compares with the exact arcs in floats, over a hundred rounds of random pulses.
    #[test]
    fn it_follows_the_exact_arcs_to_0_1_mm_a_round() {
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
            odometer = odometer.after(pulses(right, left), ROUND_FRAMES);
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
            let off =
                (f64::from(odometer.x_um) / 1e3 - x).hypot(f64::from(odometer.y_um) / 1e3 - y);
            assert!(off < 0.1 * f64::from(round), "{off} mm after {round}");
            let turned = f64::from(odometer.heading) / 4_294_967_296.0 * TAU;
            let apart = (turned - heading).rem_euclid(TAU);
            assert!(apart.min(TAU - apart) < 1e-4, "{apart}");
        }
    }
}
