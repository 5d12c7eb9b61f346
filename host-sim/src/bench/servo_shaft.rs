//! A servo, by its pulses.

use super::fault::MILLISECOND;
use certainty_core::units::BinaryAngle;
use certainty_firmware::servo::ServoConfig;

/// The shaft of a simulated servo: turns at its speed to the angle of its pulses.
///
/// It follows each pulse at once and stops at the ends of its range, which are those of its shortest
/// and longest pulse.
#[derive(Debug, Clone, PartialEq, Eq)]
#[expect(
    missing_copy_implementations,
    reason = "a copy would be another device"
)]
pub struct ServoShaft {
    config: ServoConfig,
    /// Its place at `since_ns`, in 2^-32 of a turn.
    from: i64,
    /// Its target, in 2^-32 of a turn.
    to: i64,
    since_ns: u64,
    jammed: bool,
}

/// Fraction bits of a place below a step of [`BinaryAngle`].
const FINER: u32 = 16;

impl ServoShaft {
    /// Creates a servo at the angle of `pulse_us`, with the numbers of `config`, which must be those of a
    /// [`ServoModel`](certainty_firmware::servo::ServoModel).
    #[must_use]
    pub fn new(config: ServoConfig, pulse_us: u32) -> Self {
        let at = place(&config, pulse_us);
        Self {
            config,
            from: at,
            to: at,
            since_ns: 0,
            jammed: false,
        }
    }

    /// Sets the length of the pulses; 0 is none, and the shaft stays where it is.
    pub fn set_pulse(&mut self, pulse_us: u32, now_ns: u64) {
        self.from = self.place_at(now_ns);
        self.since_ns = now_ns;
        self.to = match pulse_us {
            0 => self.from,
            pulse_us => place(&self.config, pulse_us),
        };
    }

    /// Jams the shaft, which stays where it is, or frees it, which continues to its target.
    pub fn set_jammed(&mut self, jammed: bool, now_ns: u64) {
        self.from = self.place_at(now_ns);
        self.since_ns = now_ns;
        self.jammed = jammed;
    }

    /// Returns whether the shaft is jammed.
    #[must_use]
    pub const fn is_jammed(&self) -> bool {
        self.jammed
    }

    /// Returns the angle of the shaft, counter-clockwise from straight ahead.
    ///
    /// Rounds to the nearest step of the angle, ties up.
    #[must_use]
    pub fn angle(&self, now_ns: u64) -> BinaryAngle {
        let steps = (self.place_at(now_ns) + (1 << (FINER - 1))) >> FINER;
        BinaryAngle::from_bits(steps as u16)
    }

    /// Returns whether the shaft is at its target.
    #[must_use]
    pub fn is_settled(&self, now_ns: u64) -> bool {
        self.place_at(now_ns) == self.to
    }

    fn place_at(&self, now_ns: u64) -> i64 {
        if self.jammed {
            return self.from;
        }
        let sixth_ns = u128::from(self.config.sixth_ms) * u128::from(MILLISECOND);
        let elapsed_ns = u128::from(now_ns.saturating_sub(self.since_ns));
        let travelled = (elapsed_ns << 32) / (6 * sixth_ns);
        let way = self.to - self.from;
        if travelled >= u128::from(way.unsigned_abs()) {
            self.to
        } else {
            self.from + way.signum() * travelled as i64
        }
    }
}

/// The angle of a pulse, in 2^-32 of a turn.
fn place(config: &ServoConfig, pulse_us: u32) -> i64 {
    let (shortest, longest) = (config.shortest_us.into(), config.longest_us.into());
    let aside = i64::from(pulse_us.clamp(shortest, longest)) - i64::from(config.ahead_us);
    (aside << 30) / i64::from(config.quarter_us)
}

#[cfg(test)]
mod tests {
    use super::super::test_pins::{Clock, servo};
    use super::*;
    use certainty_firmware::servo::ServoModel;
    use certainty_firmware::smart_car::SWEEP;

    #[test]
    fn a_settled_head_points_where_its_sweep_does() {
        let clock = Clock::new(0);
        let (mut servo, shaft) = servo(&clock, 2_400);
        for step in 0..3 * u32::from(SWEEP.directions()) {
            for head in 0..3 {
                let direction = SWEEP.direction(step, head, 3);
                let aimed = servo.aim(direction).unwrap();
                clock.advance(u64::from(aimed.settle_ms) * MILLISECOND);
                let shaft = shaft.borrow();
                assert!(shaft.is_settled(clock.now()));
                assert_eq!(shaft.angle(clock.now()), direction);
            }
        }
    }

    #[test]
    fn the_worst_settling_time_is_enough() {
        for pulse_us in [600, 1_500, 2_400] {
            let clock = Clock::new(0);
            let (mut servo, shaft) = servo(&clock, pulse_us);
            let aimed = servo.aim(BinaryAngle::from_millidegrees(-90_000)).unwrap();
            assert_eq!(aimed.settle_ms, ServoModel::COMMON.worst_settling_ms());
            clock.advance(u64::from(aimed.settle_ms / 2) * MILLISECOND);
            assert_eq!(shaft.borrow().is_settled(clock.now()), pulse_us < 2_400);
            clock.advance(u64::from(aimed.settle_ms / 2) * MILLISECOND);
            assert!(shaft.borrow().is_settled(clock.now()));
        }
    }

    #[test]
    fn the_shaft_turns_at_its_speed_to_a_new_target() {
        let degrees = |degrees: i32| BinaryAngle::from_millidegrees(degrees * 1_000);
        let mut shaft = ServoShaft::new(ServoConfig::COMMON, 1_500);
        shaft.set_pulse(2_100, 0); // 60°, 200 ms away
        assert_eq!(shaft.angle(0), degrees(0));
        assert_eq!(shaft.angle(100 * MILLISECOND), degrees(30));
        assert!(!shaft.is_settled(200 * MILLISECOND - 1));
        assert!(shaft.is_settled(200 * MILLISECOND));
        shaft.set_pulse(1_500, 100 * MILLISECOND);
        assert_eq!(shaft.angle(150 * MILLISECOND), degrees(15));
        shaft.set_pulse(0, 150 * MILLISECOND);
        assert_eq!(shaft.angle(u64::MAX), degrees(15));
        // No pulse turns it past its stops.
        shaft.set_pulse(9_999, 150 * MILLISECOND);
        assert_eq!(shaft.angle(u64::MAX), degrees(90));
    }

    #[test]
    fn a_jammed_shaft_stays_until_it_is_freed() {
        let clock = Clock::new(0);
        let (mut servo, shaft) = servo(&clock, 1_500);
        let target = BinaryAngle::from_millidegrees(45_000);
        shaft.borrow_mut().set_jammed(true, clock.now());
        let aimed = servo.aim(target).unwrap();
        clock.advance(u64::from(aimed.settle_ms) * MILLISECOND);
        assert_eq!(shaft.borrow().angle(clock.now()), BinaryAngle::ZERO);
        shaft.borrow_mut().set_jammed(false, clock.now());
        clock.advance(150 * MILLISECOND);
        assert_eq!(shaft.borrow().angle(clock.now()), target);
    }

    #[test]
    fn an_inverted_servo_turns_the_other_way() {
        let config = ServoConfig {
            quarter_us: -900,
            ..ServoConfig::COMMON
        };
        let model = ServoModel::try_new(config).unwrap();
        for millidegrees in [-90_000, -33_300, 0, 5_000, 90_000] {
            let angle = BinaryAngle::from_millidegrees(millidegrees);
            let pulse = model.pulse_us(angle).unwrap();
            let at = ServoShaft::new(config, pulse.into()).angle(0);
            assert!(at.separation(angle).to_bits() <= 9); // half a microsecond of 900 in 16384 steps
        }
    }
}
