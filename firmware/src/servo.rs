//! A hobby servo on a PWM channel.
//!
//! The length of the pulses sets the angle. A servo gives no feedback, so the driver keeps the last
//! pulse and computes from it how long the next turn takes.
//!
//! [`Servo`] is the driver, [`ServoModel`] the checked numbers of one servo.

use crate::timing::{duty, low_half};
use certainty_core::transducer::Missing;
use certainty_core::units::BinaryAngle;
use core::fmt;
use embedded_hal::pwm::SetDutyCycle;

/// The numbers of one servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ServoConfig {
    /// The shortest pulse it may get, in µs.
    pub shortest_us: u16,
    /// The longest pulse it may get, in µs.
    pub longest_us: u16,
    /// The pulse that turns it straight ahead, in µs.
    pub ahead_us: u16,
    /// What a quarter turn counter-clockwise adds to the pulse, in µs; negative if the servo is
    /// mounted upside down.
    pub quarter_us: i16,
    /// The time from one pulse to the next, in µs: `1..=`[`ServoModel::LONGEST_PERIOD_US`].
    pub period_us: u16,
    /// The time for 60°, in ms, as data sheets state it: `1..=`[`ServoModel::SLOWEST_MS`].
    pub sixth_ms: u16,
}

impl ServoConfig {
    /// A common servo: 600 to 2400 µs for half a turn, a pulse each 20 ms, 60° in 0.2 s.
    pub const COMMON: Self = Self {
        shortest_us: 600,
        longest_us: 2_400,
        ahead_us: 1_500,
        quarter_us: 900,
        period_us: 20_000,
        sixth_ms: 200,
    };
}

/// Which of a servo's numbers is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ServoConfigError {
    /// The shortest pulse is zero or not below the longest.
    NoRange,
    /// The pulse straight ahead is not between the limits.
    Ahead,
    /// A quarter turn changes nothing.
    NoTurn,
    /// The period is too long to compute with, or no longer than the longest pulse.
    Period,
    /// The time for 60° is zero or above [`ServoModel::SLOWEST_MS`].
    Slew,
}

impl fmt::Display for ServoConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoRange => "bad pulse limits: expected 0 < shortest < longest",
            Self::Ahead => "bad pulse for straight ahead: expected one within the limits",
            Self::NoTurn => "a quarter turn adds 0 us: expected a change of the pulse",
            Self::Period => "bad period: expected above the longest pulse and at most 32767 us",
            Self::Slew => "bad time for 60 degrees: expected 1 to 10000 ms",
        })
    }
}

impl core::error::Error for ServoConfigError {}

/// A servo's numbers, checked.
///
/// A value of this type proves that every [`ServoConfig`] field is within its range, that straight ahead
/// is within the limits, and that nothing computed from them overflows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ServoModel {
    config: ServoConfig,
}

impl ServoModel {
    /// Longest period, in µs: 2^15 − 1.
    pub const LONGEST_PERIOD_US: u16 = (1 << 15) - 1;

    /// Slowest servo: 10 s for 60°.
    pub const SLOWEST_MS: u16 = 10_000;

    /// [`ServoConfig::COMMON`].
    pub const COMMON: Self = Self {
        config: ServoConfig::COMMON,
    };

    /// Checks a servo's numbers.
    ///
    /// # Errors
    ///
    /// [`ServoConfigError`] names the number that is out of range.
    pub const fn try_new(config: ServoConfig) -> Result<Self, ServoConfigError> {
        if config.shortest_us == 0 || config.shortest_us >= config.longest_us {
            return Err(ServoConfigError::NoRange);
        }
        if config.ahead_us < config.shortest_us || config.ahead_us > config.longest_us {
            return Err(ServoConfigError::Ahead);
        }
        if config.quarter_us == 0 {
            return Err(ServoConfigError::NoTurn);
        }
        if config.period_us > Self::LONGEST_PERIOD_US || config.period_us <= config.longest_us {
            return Err(ServoConfigError::Period);
        }
        if config.sixth_ms == 0 || config.sixth_ms > Self::SLOWEST_MS {
            return Err(ServoConfigError::Slew);
        }
        Ok(Self { config })
    }

    /// Returns the numbers.
    #[must_use]
    pub const fn config(&self) -> ServoConfig {
        self.config
    }

    /// Returns the pulse for `angle`, counter-clockwise from straight ahead, in whole µs.
    ///
    /// Formula: ahead + quarter · angle / 90°, with the angle in −180°..180°.
    /// Rounds to the nearest microsecond, ties up.
    ///
    /// ```
    /// use certainty_core::units::BinaryAngle;
    /// use certainty_firmware::servo::{ServoError, ServoModel};
    ///
    /// let to = |degrees: i32| ServoModel::COMMON.pulse_us(BinaryAngle::from_millidegrees(degrees * 1000));
    /// assert_eq!(to(90), Ok(2_400));
    /// assert_eq!(to(-5), Ok(1_450));
    /// assert_eq!(to(95), Err(ServoError::OutOfReach));
    /// ```
    ///
    /// # Errors
    ///
    /// [`ServoError::OutOfReach`] for a pulse beyond the limits; it is not clipped.
    pub const fn pulse_us(&self, angle: BinaryAngle) -> Result<u16, ServoError> {
        const HALF_QUARTER: i32 = 1 << 13;
        let steps = angle.to_bits().cast_signed() as i32;
        // At most 2^15 · 2^15 plus 2^13.
        let turned = (self.config.quarter_us as i32)
            .wrapping_mul(steps)
            .wrapping_add(HALF_QUARTER)
            >> 14;
        let pulse = (self.config.ahead_us as i32).wrapping_add(turned);
        let (shortest, longest) = (self.config.shortest_us, self.config.longest_us);
        if pulse < shortest as i32 || pulse > longest as i32 {
            return Err(ServoError::OutOfReach);
        }
        Ok(low_half(pulse.cast_unsigned())) // within the limits, which have 16 bits
    }

    /// Returns the duty cycle of a pulse out of `full`, as [`timing::duty`](crate::timing::duty) does.
    #[must_use]
    pub const fn duty(&self, pulse_us: u16, full: u16) -> u16 {
        duty(pulse_us, self.config.period_us, full)
    }

    /// Returns the longest time that the servo takes between two pulses within the limits, in ms.
    ///
    /// A schedule must leave at least this time between a turn and the measurement.
    #[must_use]
    pub const fn worst_settling_ms(&self) -> u32 {
        self.settling_ms(self.config.shortest_us, self.config.longest_us)
    }

    /// Returns how long the servo takes from one pulse to another, in ms; 0 for the same.
    ///
    /// Formula: the angle between them at the servo's speed, plus one period, because a new pulse takes
    /// effect in the next period. Rounds up.
    #[must_use]
    pub const fn settling_ms(&self, from_us: u16, to_us: u16) -> u32 {
        let distance = from_us.abs_diff(to_us) as u32;
        if distance == 0 {
            return 0;
        }
        // A quarter turn is 3/2 of 60°: 2^16 · 10 000 · 3 is below 2^31, and so are the rest.
        let travel = distance
            .wrapping_mul(self.config.sixth_ms as u32)
            .wrapping_mul(3);
        let half_turn = (self.config.quarter_us.unsigned_abs() as u32).wrapping_mul(2);
        let rounding_up = travel.wrapping_add(half_turn.wrapping_sub(1));
        let travel = match rounding_up.checked_div(half_turn) {
            Some(travel) => travel,
            None => 0, // a quarter turn changes the pulse
        };
        travel.wrapping_add((self.config.period_us as u32).div_ceil(1_000))
    }
}

/// Why a servo was not turned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ServoError {
    /// The angle needs a pulse beyond the servo's limits.
    OutOfReach,
    /// The PWM channel returned an error.
    Pwm,
}

impl ServoError {
    /// Returns the reason for the missing reading of the sensor on this servo.
    #[must_use]
    pub const fn reason(self) -> Missing {
        match self {
            Self::OutOfReach | Self::Pwm => Missing::Bus,
        }
    }
}

impl fmt::Display for ServoError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OutOfReach => "angle out of reach: expected a pulse within the servo's limits",
            Self::Pwm => "the PWM channel failed",
        })
    }
}

impl core::error::Error for ServoError {}

/// The result of [`Servo::aim`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Aimed {
    /// The time until the servo has turned, in ms; 0 if the pulse did not change.
    pub settle_ms: u32,
    /// The length of its pulses, in µs.
    pub pulse_us: u16,
}

/// The driver of a servo on a PWM channel with the model's period.
#[derive(Debug)]
pub struct Servo<Pwm> {
    pwm: Pwm,
    model: ServoModel,
    /// The last pulse that was set; unknown at the start and after an error.
    last_pulse_us: Option<u16>,
}

impl<Pwm: SetDutyCycle> Servo<Pwm> {
    /// Creates the driver of a servo whose angle is unknown.
    #[must_use]
    pub const fn new(pwm: Pwm, model: ServoModel) -> Self {
        Self {
            pwm,
            model,
            last_pulse_us: None,
        }
    }

    /// Returns the PWM channel; its pulses continue.
    #[must_use]
    pub fn release(self) -> Pwm {
        self.pwm
    }

    /// Returns the servo's numbers.
    #[must_use]
    pub const fn model(&self) -> &ServoModel {
        &self.model
    }

    /// Turns to `angle`, counter-clockwise from straight ahead, and returns how long that takes.
    ///
    /// The time is computed from the previous pulse, so the previous turn must be over. For the first turn
    /// and after an error it is [`ServoModel::worst_settling_ms`].
    ///
    /// # Errors
    ///
    /// - [`ServoError::OutOfReach`] if the pulse is beyond the limits; the servo keeps its angle.
    /// - [`ServoError::Pwm`] if the channel fails; the angle is then unknown.
    pub fn aim(&mut self, angle: BinaryAngle) -> Result<Aimed, ServoError> {
        let pulse_us = self.model.pulse_us(angle)?;
        let settle_ms = match self.last_pulse_us.take() {
            Some(from_us) => self.model.settling_ms(from_us, pulse_us),
            None => self.model.worst_settling_ms(),
        };
        let duty = self.model.duty(pulse_us, self.pwm.max_duty_cycle());
        self.pwm.set_duty_cycle(duty).map_err(|_| ServoError::Pwm)?;
        self.last_pulse_us = Some(pulse_us);
        Ok(Aimed {
            settle_ms,
            pulse_us,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_hal_mock::eh1::MockError;
    use embedded_hal_mock::eh1::pwm::{Mock as Channel, Transaction as Step};
    use std::io::ErrorKind;

    fn degrees(degrees: i32) -> BinaryAngle {
        BinaryAngle::from_millidegrees(degrees * 1_000)
    }

    /// A channel that expects these duty cycles, out of 40 000.
    fn channel(duties: &[u16]) -> Channel {
        let steps: Vec<Step> = duties
            .iter()
            .flat_map(|&duty| [Step::max_duty_cycle(40_000), Step::set_duty_cycle(duty)])
            .collect();
        Channel::new(&steps)
    }

    #[test]
    fn pulses_are_whole_microseconds() {
        // 600, 1500, 1450 and 2400 µs of 20 000, at two steps a microsecond.
        let mut servo = Servo::new(channel(&[1_200, 3_000, 2_900, 4_800]), ServoModel::COMMON);
        for (angle, pulse_us) in [(-90, 600), (0, 1_500), (-5, 1_450), (90, 2_400)] {
            assert_eq!(servo.aim(degrees(angle)).unwrap().pulse_us, pulse_us);
        }
        servo.release().done();
    }

    #[test]
    fn first_turn_takes_the_worst_time_later_ones_less() {
        let mut servo = Servo::new(channel(&[3_000, 4_200, 4_200]), ServoModel::COMMON);
        assert_eq!(ServoModel::COMMON.worst_settling_ms(), 600 + 20); // 180° and a period
        let mut settle = |millidegrees| {
            let angle = BinaryAngle::from_millidegrees(millidegrees);
            servo.aim(angle).unwrap().settle_ms
        };
        assert_eq!(settle(0), 620);
        assert_eq!(settle(60_000), 200 + 20);
        assert_eq!(settle(60_000), 0);
        servo.release().done();
    }

    #[test]
    fn an_angle_out_of_reach_is_refused() {
        let mut servo = Servo::new(channel(&[3_000, 3_600]), ServoModel::COMMON);
        servo.aim(degrees(0)).unwrap();
        for angle in [91, -91, 180, 135] {
            assert_eq!(servo.aim(degrees(angle)), Err(ServoError::OutOfReach));
        }
        // The last pulse is still the one for straight ahead: 300 µs are 30°.
        assert_eq!(servo.aim(degrees(30)).unwrap().settle_ms, 100 + 20);
        servo.release().done();
    }

    #[test]
    fn a_pwm_error_makes_the_angle_unknown() {
        let steps = [
            Step::max_duty_cycle(40_000),
            Step::set_duty_cycle(3_000),
            Step::max_duty_cycle(40_000),
            Step::set_duty_cycle(3_100).with_error(MockError::Io(ErrorKind::NotConnected)),
            Step::max_duty_cycle(40_000),
            Step::set_duty_cycle(3_100),
        ];
        let mut servo = Servo::new(Channel::new(&steps), ServoModel::COMMON);
        servo.aim(degrees(0)).unwrap();
        assert_eq!(servo.aim(degrees(5)), Err(ServoError::Pwm));
        assert_eq!(servo.aim(degrees(5)).unwrap().settle_ms, 620);
        servo.release().done();
    }

    #[test]
    fn every_angle_has_the_formulas_pulse_or_none() {
        let mirrored = ServoModel::try_new(ServoConfig {
            quarter_us: -917,
            ahead_us: 1_478,
            ..ServoConfig::COMMON
        })
        .unwrap();
        for model in [ServoModel::COMMON, mirrored] {
            let config = model.config();
            let mut reached = 0;
            for bits in 0..=u16::MAX {
                let turns = f64::from(bits as i16) / 65_536.0;
                let exact = f64::from(config.ahead_us) + 4.0 * turns * f64::from(config.quarter_us);
                let pulse = (exact + 0.5).floor();
                let inside = (600.0..=2_400.0).contains(&pulse);
                reached += u32::from(inside);
                assert_eq!(
                    model.pulse_us(BinaryAngle::from_bits(bits)).ok(),
                    inside.then_some(pulse as u16)
                );
            }
            assert!((32_000..33_000).contains(&reached)); // about half a turn
        }
    }

    #[test]
    fn a_pulse_can_be_computed_back_from_its_duty() {
        for full in [20_000, 20_001, 40_000, u16::MAX] {
            for pulse in 600..=2_400_u16 {
                let duty = ServoModel::COMMON.duty(pulse, full);
                let back = (f64::from(duty) * 20_000.0 / f64::from(full)).round();
                assert_eq!(back, f64::from(pulse), "of {full}");
            }
        }
    }

    #[test]
    fn a_duty_is_rounded_and_at_most_full() {
        // 1500 of 20 000 of 1000 is 75; 1503 would be 75.15, 1510 75.5.
        let duty = |pulse, full| ServoModel::COMMON.duty(pulse, full);
        assert_eq!(duty(1_503, 1_000), 75);
        assert_eq!(duty(1_510, 1_000), 76);
        assert_eq!(duty(u16::MAX, u16::MAX), u16::MAX);
        assert_eq!(duty(1_500, 0), 0);
    }

    #[test]
    fn settling_rounds_up() {
        // 1 µs of 900 a quarter turn: 0.1°, a third of a millisecond; and the period.
        assert_eq!(ServoModel::COMMON.settling_ms(1_500, 1_501), 1 + 20);
        assert_eq!(ServoModel::COMMON.settling_ms(1_503, 1_500), 1 + 20);
        assert_eq!(ServoModel::COMMON.settling_ms(1_504, 1_500), 2 + 20);
        let slowest = ServoModel::try_new(ServoConfig {
            shortest_us: 1,
            longest_us: 32_766,
            quarter_us: 1,
            period_us: 32_767,
            sixth_ms: 10_000,
            ..ServoConfig::COMMON
        });
        // 32 765 quarter turns of 15 s.
        assert_eq!(slowest.unwrap().worst_settling_ms(), 491_475_000 + 33);
    }

    #[test]
    fn bad_configurations_are_refused() {
        let refused = |change: fn(&mut ServoConfig)| {
            let mut config = ServoConfig::COMMON;
            change(&mut config);
            ServoModel::try_new(config).unwrap_err()
        };
        use ServoConfigError as Why;
        assert_eq!(refused(|c| c.shortest_us = 0), Why::NoRange);
        assert_eq!(refused(|c| c.shortest_us = 2_400), Why::NoRange);
        assert_eq!(refused(|c| c.ahead_us = 599), Why::Ahead);
        assert_eq!(refused(|c| c.ahead_us = 2_401), Why::Ahead);
        assert_eq!(refused(|c| c.quarter_us = 0), Why::NoTurn);
        assert_eq!(refused(|c| c.period_us = 2_400), Why::Period);
        assert_eq!(refused(|c| c.period_us = 32_768), Why::Period);
        assert_eq!(refused(|c| c.sixth_ms = 0), Why::Slew);
        assert_eq!(refused(|c| c.sixth_ms = 10_001), Why::Slew);
        assert_eq!(
            ServoModel::try_new(ServoConfig::COMMON),
            Ok(ServoModel::COMMON)
        );
    }
}
