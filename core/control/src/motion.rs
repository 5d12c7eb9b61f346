//! What a behaviour asks of the wheels.

use certainty_core::narrow::{low_u32, saturating_i32};
use fixed::types::I16F16;

/// A signal or a weight: 1 is full speed, or all of it.
///
/// Units and range: steps of 2^-16, ±32768.
pub type Effort = I16F16;

/// Returns `value` times `by`, rounded to the nearest, ties away from zero; saturates.
///
/// Differs from `*` in that the opposite of a signal gives the opposite product, to the bit: a robot
/// that drifts to one side by what is cut off is not symmetric.
pub(super) const fn scaled(value: Effort, by: Effort) -> Effort {
    const HALF: u64 = 1 << (Effort::FRAC_NBITS - 1);
    let (a, b) = (value.to_bits(), by.to_bits());
    // 31 bits each.
    let product = (a.unsigned_abs() as u64).wrapping_mul(b.unsigned_abs() as u64);
    let magnitude = product.wrapping_add(HALF) >> Effort::FRAC_NBITS;
    let magnitude = saturating_i32(magnitude.cast_signed());
    Effort::from_bits(if (a < 0) != (b < 0) {
        magnitude.wrapping_neg()
    } else {
        magnitude
    })
}

/// Returns what part `value` is of `of`, within 0..=1, rounded down; 0 of nothing.
pub(super) fn share(value: i32, of: i32) -> Effort {
    let one = Effort::ONE.to_bits().into();
    let wide = i64::from(value).saturating_mul(one);
    let part = wide.checked_div(of.into()).unwrap_or(0).clamp(0, one);
    Effort::from_bits(low_u32(part.cast_unsigned()).cast_signed())
}

/// One half.
pub(super) const HALF: Effort = Effort::lit("0.5");

/// Returns the value within `low..=high` that is nearest to `value`; `low` where they are the wrong way
/// round, for which `clamp` has a panic.
pub(super) fn bounded(value: Effort, low: Effort, high: Effort) -> Effort {
    if value < low {
        low
    } else if value > high {
        high
    } else {
        value
    }
}

/// A partial control vector **v**_l of \[004\] eq. 1, as what it is for.
///
/// The avoiding and the orienting behaviours only turn (`v_L = −v_R`, \[004\] §3), the speed only goes
/// ahead, so two numbers say all, and turning left is the exact opposite of turning right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Motion {
    /// What the right wheels get and the left ones lose; positive to the left.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub turn: Effort,
    /// What both get.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub ahead: Effort,
}

/// The speeds of the right and of the left wheels.
///
/// Units and range: parts of full speed; what a [`Controller`](super::Controller) says is within ±1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Wheels {
    /// `v_R`.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub right: Effort,
    /// `v_L`.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub left: Effort,
}

impl Motion {
    /// Standing still.
    pub const STILL: Self = Self {
        turn: Effort::ZERO,
        ahead: Effort::ZERO,
    };

    /// Returns the wheels' speeds: `v_R` = ahead + turn, `v_L` = ahead − turn, neither beyond ±1.
    ///
    /// Differs from \[004\] eq. 1, whose sum has no bound: turning comes first, and what it leaves of
    /// full speed is for going ahead. A sum cut off wheel by wheel would turn less the faster it went.
    #[must_use]
    pub fn wheels(self) -> Wheels {
        let turn = bounded(self.turn, Effort::NEG_ONE, Effort::ONE);
        let left_over = Effort::ONE.saturating_sub(turn.saturating_abs());
        let ahead = bounded(self.ahead, left_over.saturating_neg(), left_over);
        Wheels {
            right: ahead.saturating_add(turn),
            left: ahead.saturating_sub(turn),
        }
    }
}

impl Wheels {
    /// Standing still.
    pub const STOPPED: Self = Self {
        right: Effort::ZERO,
        left: Effort::ZERO,
    };

    /// Returns the speeds with right and left exchanged.
    #[must_use]
    pub const fn mirrored(self) -> Self {
        Self {
            right: self.left,
            left: self.right,
        }
    }
}

/// A side of the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Side {
    /// Where turning is positive.
    Left,
    /// The other.
    Right,
}

impl Side {
    /// Returns the other side.
    #[must_use]
    pub const fn other(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
        }
    }

    /// Returns `amount` with the sign of turning to this side.
    pub(super) const fn signed(self, amount: Effort) -> Effort {
        match self {
            Self::Left => amount,
            Self::Right => amount.saturating_neg(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(turn: f64, ahead: f64) -> Motion {
        Motion {
            turn: Effort::from_num(turn),
            ahead: Effort::from_num(ahead),
        }
    }

    #[test]
    fn turning_left_speeds_the_right_wheels_up() {
        let wheels = motion(0.25, 0.5).wheels();
        assert_eq!(
            (wheels.right, wheels.left),
            (Effort::lit("0.75"), Effort::lit("0.25"))
        );
    }

    #[test]
    fn beyond_full_speed_turning_comes_first() {
        let wheels = motion(0.5, 2.0).wheels();
        assert_eq!((wheels.right, wheels.left), (Effort::ONE, Effort::ZERO));
        let spin = motion(-7.0, 2.0).wheels();
        assert_eq!((spin.right, spin.left), (Effort::NEG_ONE, Effort::ONE));
    }

    #[test]
    fn products_are_rounded_alike_on_both_sides() {
        let third = Effort::from_bits(21_845);
        let weight = Effort::from_bits(65_535);
        // 21845 · 65535 / 65536 = 21844.67
        assert_eq!(scaled(third, weight).to_bits(), 21_845);
        assert_eq!(scaled(-third, weight).to_bits(), -21_845);
        assert_eq!(scaled(Effort::MIN, Effort::MIN), Effort::MAX);
        assert_eq!(scaled(Effort::MIN, Effort::MAX), -Effort::MAX);
    }
}
