//! A differential drive: two motors behind hobby speed controllers, or two continuous servos.
//!
//! A pulse every 20 ms sets a motor's speed; there is no feedback. The driver returns the pulses that it
//! set, in whole microseconds, for dead reckoning. For a device that turns to an angle use
//! [`servo`](crate::servo).

use crate::timing::duty;
use certainty_control::{Effort, Side, Wheels};
use core::fmt;
use embedded_hal::pwm::SetDutyCycle;

/// The numbers of a motor's speed controller or of a continuous servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MotorConfig {
    /// The pulse at which it stands still, in µs.
    pub stand_us: u16,
    /// What full speed ahead adds to that pulse and full speed back subtracts, in µs: `1..=32_767`.
    pub full_us: u16,
    /// The time from one pulse to the next, in µs: at most 2^15 − 1.
    pub period_us: u16,
}

impl MotorConfig {
    /// A common controller: stands still at 1.5 ms, full speed at 1 and 2 ms, a pulse each 20 ms.
    pub const COMMON: Self = Self {
        stand_us: 1_500,
        full_us: 500,
        period_us: 20_000,
    };
}

/// Which of a motor's numbers is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MotorConfigError {
    /// The change at full speed is zero or above 32,767 µs.
    Full,
    /// The pulse at full speed back would be zero or less.
    Stand,
    /// The period is too long to compute with, or no longer than the longest pulse.
    Period,
}

impl fmt::Display for MotorConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Full => "bad change at full speed: expected 1 to 32767 us",
            Self::Stand => {
                "bad pulse for standing still: expected more than the change at full speed"
            }
            Self::Period => "bad period: expected above the longest pulse and at most 32767 us",
        })
    }
}

impl core::error::Error for MotorConfigError {}

/// A motor's numbers, checked.
///
/// A value of this type proves that every pulse is above zero and shorter than the period, and that
/// nothing computed from them overflows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MotorModel {
    config: MotorConfig,
}

impl MotorModel {
    /// [`MotorConfig::COMMON`].
    pub const COMMON: Self = Self {
        config: MotorConfig::COMMON,
    };

    /// Checks a motor's numbers.
    ///
    /// # Errors
    ///
    /// [`MotorConfigError`] names the number that is out of range.
    pub const fn try_new(config: MotorConfig) -> Result<Self, MotorConfigError> {
        let longest = (config.stand_us as u32).wrapping_add(config.full_us as u32);
        if config.full_us == 0 || config.full_us > i16::MAX.cast_unsigned() {
            Err(MotorConfigError::Full)
        } else if config.stand_us <= config.full_us {
            Err(MotorConfigError::Stand)
        } else if config.period_us > i16::MAX.cast_unsigned() || longest >= config.period_us as u32
        {
            Err(MotorConfigError::Period)
        } else {
            Ok(Self { config })
        }
    }

    /// Returns the numbers.
    #[must_use]
    pub const fn config(&self) -> MotorConfig {
        self.config
    }

    /// Returns what `speed`, a fraction of full speed, adds to the pulse for standing still, in whole µs.
    ///
    /// Rounds to the nearest, ties away from zero, so that opposite speeds have opposite pulses. Speeds
    /// beyond ±1 are full speed.
    ///
    /// ```
    /// use certainty_control::Effort;
    /// use certainty_firmware::motors::MotorModel;
    ///
    /// let pulse = |speed| MotorModel::COMMON.pulse_change_us(Effort::from_num(speed));
    /// assert_eq!((pulse(1.0), pulse(-0.5), pulse(7.0)), (500, -250, 500));
    /// ```
    #[must_use]
    pub const fn pulse_change_us(&self, speed: Effort) -> i16 {
        const HALF: u64 = 1 << (Effort::FRAC_NBITS - 1);
        let one = Effort::ONE.to_bits().unsigned_abs();
        let size = speed.to_bits().unsigned_abs();
        let size = if size < one { size } else { one };
        // At most 2^16 times 2^15.
        let scaled = (size as u64).wrapping_mul(self.config.full_us as u64);
        let rounded = scaled.wrapping_add(HALF) >> Effort::FRAC_NBITS;
        let [low, high, ..] = rounded.to_le_bytes();
        let change = i16::from_le_bytes([low, high]); // at most full_us
        if speed.is_negative() {
            change.wrapping_neg()
        } else {
            change
        }
    }

    /// Returns the duty cycle, out of `full`, of a pulse that differs by `change_us` from the one for
    /// standing still.
    #[must_use]
    pub const fn duty(&self, change_us: i16, full: u16) -> u16 {
        let pulse_us = self.config.stand_us.saturating_add_signed(change_us);
        duty(pulse_us, self.config.period_us, full)
    }
}

/// Which motor's PWM channel failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MotorError {
    /// That of the right motor.
    Right,
    /// That of the left motor.
    Left,
}

impl MotorError {
    const fn of(side: Side) -> Self {
        match side {
            Side::Right => Self::Right,
            Side::Left => Self::Left,
        }
    }
}

impl fmt::Display for MotorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Right => "the right motor's PWM channel failed",
            Self::Left => "the left motor's PWM channel failed",
        })
    }
}

impl core::error::Error for MotorError {}

/// The pulses set for both motors, as differences from the pulse for standing still, in µs.
///
/// Positive values are ahead.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MotorPulses {
    /// The right motor.
    pub right_us: i16,
    /// The left one.
    pub left_us: i16,
}

impl MotorPulses {
    /// Both motors stand still.
    pub const NONE: Self = Self {
        right_us: 0,
        left_us: 0,
    };
}

/// The driver of two motors of one model on PWM channels with its period.
///
/// If a motor turns the wrong way, swap its wires.
#[derive(Debug)]
pub struct Motors<Pwm> {
    right: Pwm,
    left: Pwm,
    model: MotorModel,
}

impl<Pwm: SetDutyCycle> Motors<Pwm> {
    /// Creates the driver; no pulse is set yet.
    #[must_use]
    pub const fn new(right: Pwm, left: Pwm, model: MotorModel) -> Self {
        Self { right, left, model }
    }

    /// Returns the channels, right and left; their pulses continue.
    #[must_use]
    pub fn release(self) -> (Pwm, Pwm) {
        (self.right, self.left)
    }

    /// Sets the wheels' speeds, in parts of full speed, from the next pulse on, and returns the pulses.
    ///
    /// Range: beyond ±1 it is full speed. [`Wheels::STOPPED`] gives exactly [`MotorPulses::NONE`].
    ///
    /// # Errors
    ///
    /// [`MotorError`] names the first motor whose channel failed. Both motors are then set to stand still,
    /// because one motor that turns alone would turn the robot.
    pub fn drive(&mut self, wheels: Wheels) -> Result<MotorPulses, MotorError> {
        let pulses = MotorPulses {
            right_us: self.model.pulse_change_us(wheels.right),
            left_us: self.model.pulse_change_us(wheels.left),
        };
        let set = self
            .set(Side::Right, pulses.right_us)
            .and_then(|()| self.set(Side::Left, pulses.left_us));
        if let Err(error) = set {
            // The channel that works stands still; the first error is the one to return.
            let _ = self.set(Side::Right, 0);
            let _ = self.set(Side::Left, 0);
            return Err(error);
        }
        Ok(pulses)
    }

    fn set(&mut self, side: Side, change_us: i16) -> Result<(), MotorError> {
        let pwm = match side {
            Side::Right => &mut self.right,
            Side::Left => &mut self.left,
        };
        let duty = self.model.duty(change_us, pwm.max_duty_cycle());
        pwm.set_duty_cycle(duty).map_err(|_| MotorError::of(side))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_control::Effort;
    use embedded_hal_mock::eh1::MockError;
    use embedded_hal_mock::eh1::pwm::{Mock as Channel, Transaction as Step};
    use std::io::ErrorKind;

    /// A channel that expects these duty cycles, out of 40 000: two steps a microsecond.
    fn channel(duties: &[u16]) -> Channel {
        let steps: Vec<Step> = duties
            .iter()
            .flat_map(|&duty| [Step::max_duty_cycle(40_000), Step::set_duty_cycle(duty)])
            .collect();
        Channel::new(&steps)
    }

    /// A channel that fails at the first duty cycle and takes the second.
    fn failing_once(refused: u16, then: u16) -> Channel {
        Channel::new(&[
            Step::max_duty_cycle(40_000),
            Step::set_duty_cycle(refused).with_error(MockError::Io(ErrorKind::NotConnected)),
            Step::max_duty_cycle(40_000),
            Step::set_duty_cycle(then),
        ])
    }

    fn wheels(right: f64, left: f64) -> Wheels {
        Wheels {
            right: Effort::from_num(right),
            left: Effort::from_num(left),
        }
    }

    fn motors(right: Channel, left: Channel) -> Motors<Channel> {
        Motors::new(right, left, MotorModel::COMMON)
    }

    fn done(motors: Motors<Channel>) {
        let (mut right, mut left) = motors.release();
        right.done();
        left.done();
    }

    #[test]
    fn pulses_are_1_5_ms_plus_or_minus_0_5_ms() {
        let mut motors = motors(
            channel(&[3_000, 4_000, 2_000]),
            channel(&[3_000, 3_250, 4_000]),
        );
        for (wanted, right_us, left_us) in [
            (Wheels::STOPPED, 0, 0),
            (wheels(1.0, 0.25), 500, 125),
            (wheels(-1.0, 9.0), -500, 500),
        ] {
            let pulses = motors.drive(wanted);
            assert_eq!(pulses, Ok(MotorPulses { right_us, left_us }));
        }
        done(motors);
    }

    #[test]
    fn if_one_motor_fails_both_are_stopped() {
        // The right channel is set first; if it fails, the left motor is never set to turn.
        let mut right_fails = motors(failing_once(3_500, 3_000), channel(&[3_000]));
        assert_eq!(right_fails.drive(wheels(0.5, 0.5)), Err(MotorError::Right));
        done(right_fails);
        // The right motor already turns when the left channel fails.
        let mut left_fails = motors(channel(&[3_500, 3_000]), failing_once(3_500, 3_000));
        assert_eq!(left_fails.drive(wheels(0.5, 0.5)), Err(MotorError::Left));
        done(left_fails);
    }

    #[test]
    fn pulses_follow_the_formula_and_are_odd() {
        let odd = MotorModel::try_new(MotorConfig {
            full_us: 417,
            ..MotorConfig::COMMON
        });
        for model in [MotorModel::COMMON, odd.unwrap()] {
            let full = f64::from(model.config().full_us);
            for bits in 0..=70_000 {
                let speed = Effort::from_bits(bits);
                let exact = (f64::from(bits) / 65_536.0).min(1.0) * full;
                let change = model.pulse_change_us(speed);
                assert_eq!(f64::from(change), (exact + 0.5).floor(), "{bits}");
                assert_eq!(model.pulse_change_us(-speed), -change);
            }
        }
    }

    #[test]
    fn bad_configurations_are_refused() {
        let refused = |change: fn(&mut MotorConfig)| {
            let mut config = MotorConfig::COMMON;
            change(&mut config);
            MotorModel::try_new(config).unwrap_err()
        };
        use MotorConfigError as Why;
        assert_eq!(refused(|c| c.full_us = 0), Why::Full);
        assert_eq!(refused(|c| c.full_us = 32_768), Why::Full);
        assert_eq!(refused(|c| c.stand_us = 500), Why::Stand);
        assert_eq!(refused(|c| c.period_us = 2_000), Why::Period);
        assert_eq!(refused(|c| c.period_us = 32_768), Why::Period);
        let common = MotorModel::try_new(MotorConfig::COMMON);
        assert_eq!(common, Ok(MotorModel::COMMON));
    }
}
