//! What a motor does with its pulses.

use crate::pulse;
use certainty_control::Effort;
use core::fmt;

/// The numbers of a motor's speed controller, or of a continuous servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MotorConfig {
    /// The pulse at which it stands, in µs.
    pub stand_us: u16,
    /// What full speed ahead adds to the pulse and full speed back takes off it, in µs: `1..=32_767`.
    pub full_us: u16,
    /// From one pulse to the next, in µs: at most 2^15 − 1.
    pub period_us: u16,
}

impl MotorConfig {
    /// A common one: stands at 1.5 ms, full speed at 1 and 2 ms, a pulse each 20 ms.
    pub const COMMON: Self = Self {
        stand_us: 1_500,
        full_us: 500,
        period_us: 20_000,
    };
}

/// Why a motor's numbers were refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MotorConfigError {
    /// Full speed changes nothing, or more than a pulse can be changed by.
    Full,
    /// Full speed back leaves no pulse.
    Stand,
    /// The period is too long to compute with, or no longer than the longest pulse.
    Period,
}

impl fmt::Display for MotorConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Full => "full speed must change the pulse by 1 to 32767 us",
            Self::Stand => "the pulse that stands must be longer than what full speed changes",
            Self::Period => "the period must be above the longest pulse and at most 32767 us",
        })
    }
}

impl core::error::Error for MotorConfigError {}

/// A motor's numbers, checked.
///
/// Possession proves that every pulse is above zero and shorter than the period, and that nothing computed
/// from them overflows.
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
    /// [`MotorConfigError`] names what cannot be.
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

    /// Returns what `speed`, a part of full speed, adds to the pulse that stands, in whole µs.
    ///
    /// Rounds to the nearest, ties away from zero, so that opposite speeds have opposite pulses; beyond ±1
    /// it is full speed.
    ///
    /// ```
    /// use certainty_control::Effort;
    /// use certainty_firmware::motors::MotorModel;
    ///
    /// let thrust = |speed| MotorModel::COMMON.thrust_us(Effort::from_num(speed));
    /// assert_eq!((thrust(1.0), thrust(-0.5), thrust(7.0)), (500, -250, 500));
    /// ```
    #[must_use]
    pub const fn thrust_us(&self, speed: Effort) -> i16 {
        const HALF: u64 = 1 << (Effort::FRAC_NBITS - 1);
        let one = Effort::ONE.to_bits().unsigned_abs();
        let size = speed.to_bits().unsigned_abs();
        let size = if size < one { size } else { one };
        // At most 2^16 times 2^15.
        let scaled = (size as u64).wrapping_mul(self.config.full_us as u64);
        let rounded = scaled.wrapping_add(HALF) >> Effort::FRAC_NBITS;
        let [low, high, ..] = rounded.to_le_bytes();
        let thrust = i16::from_le_bytes([low, high]); // at most full_us
        if speed.is_negative() {
            thrust.wrapping_neg()
        } else {
            thrust
        }
    }

    /// Returns the duty cycle, of `full`, of the pulse that is longer by `thrust_us` than the one that
    /// stands.
    #[must_use]
    pub const fn duty(&self, thrust_us: i16, full: u16) -> u16 {
        let pulse_us = self.config.stand_us.saturating_add_signed(thrust_us);
        pulse::duty(pulse_us, self.config.period_us, full)
    }
}
