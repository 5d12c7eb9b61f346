//! What one servo does with its pulses.

use super::ServoError;
use crate::pulse::{self, low_half};
use certainty_core::units::BinaryAngle;
use core::fmt;

/// The numbers of one servo, each unit its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ServoConfig {
    /// The shortest pulse it may get, in µs.
    pub shortest_us: u16,
    /// The longest pulse it may get, in µs.
    pub longest_us: u16,
    /// The pulse that turns it straight ahead, in µs.
    pub ahead_us: u16,
    /// What a quarter turn counter-clockwise adds to the pulse, in µs; negative where the servo
    /// hangs upside down.
    pub quarter_us: i16,
    /// From one pulse to the next, in µs: `1..=`[`ServoModel::LONGEST_PERIOD_US`].
    pub period_us: u16,
    /// How long it takes for 60°, in ms, as data sheets have it: `1..=`[`ServoModel::SLOWEST_MS`].
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

/// Why a servo's numbers were refused.
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
            Self::NoRange => "the shortest pulse must be above zero and below the longest",
            Self::Ahead => "the pulse straight ahead must be within the limits",
            Self::NoTurn => "a quarter turn must change the pulse",
            Self::Period => "the period must be above the longest pulse and at most 32767 us",
            Self::Slew => "the time for 60 degrees must be 1 to 10000 ms",
        })
    }
}

impl core::error::Error for ServoConfigError {}

/// A servo's numbers, checked.
///
/// Possession proves that every [`ServoConfig`] field is within its range, that straight ahead is
/// within the limits, and that nothing computed from them overflows.
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
    /// [`ServoConfigError`] names what cannot be.
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

    /// Returns the pulse, in whole µs, that turns the servo to `angle`, counter-clockwise from
    /// straight ahead.
    ///
    /// Formula: ahead + quarter · angle / 90°, the angle within ±180°, half a turn being −180°.
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

    /// Returns the duty cycle of a pulse, of `full`.
    ///
    /// Rounds to the nearest, ties up. Where `full` is the period in µs or more, no two pulses have
    /// the same duty, so that the pulse can be told from it.
    #[must_use]
    pub const fn duty(&self, pulse_us: u16, full: u16) -> u16 {
        pulse::duty(pulse_us, self.config.period_us, full)
    }

    /// Returns the longest that the servo takes from one pulse within the limits to another, in ms.
    ///
    /// For a schedule, which must give it as long.
    #[must_use]
    pub const fn worst_settling_ms(&self) -> u32 {
        self.settling_ms(self.config.shortest_us, self.config.longest_us)
    }

    /// Returns how long the servo takes from one pulse to another, in ms; 0 for the same.
    ///
    /// Formula: the angle between them at the servo's speed, and one period, as a pulse counts only
    /// from the next period on. Rounds up.
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
