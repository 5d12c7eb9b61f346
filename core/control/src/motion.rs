//! What the wheels do: efforts, the partial control vectors, the limit of acceleration.

use core::fmt;
use core::iter::Sum;
use core::ops::{Add, AddAssign, Mul, Neg, Sub};
use fixed::traits::{FromFixed, ToFixed};
use fixed::types::I16F16;

/// A number near 1: a speed as a part of full speed, a weight, a failure, a coverage.
///
/// Units and range: steps of 2^-16, from −32768 to nearly 32768. All operators saturate. A product is rounded
/// to the nearest step, ties away from zero, so that the product of an opposite is the opposite product, to
/// the bit: a robot whose products are rounded down would drift to one side.
///
/// ```
/// use certainty_control::Effort;
///
/// let third = Effort::from_bits(21_845);
/// assert_eq!(third + third + third, Effort::ONE - Effort::DELTA);
/// assert_eq!(-third * Effort::HALF, -(third * Effort::HALF));
/// assert_eq!(Effort::MAX + Effort::ONE, Effort::MAX);
/// ```
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Effort(I16F16);

impl Effort {
    /// 0.
    pub const ZERO: Self = Self(I16F16::ZERO);
    /// 1: full speed, or all of something.
    pub const ONE: Self = Self(I16F16::ONE);
    /// −1: full speed backwards.
    pub const NEG_ONE: Self = Self(I16F16::NEG_ONE);
    /// One half.
    pub const HALF: Self = Self::lit("0.5");
    /// The largest value.
    pub const MAX: Self = Self(I16F16::MAX);
    /// The smallest value.
    pub const MIN: Self = Self(I16F16::MIN);
    /// The smallest step, 2^-16.
    pub const DELTA: Self = Self(I16F16::DELTA);
    /// Bits of the fraction.
    pub const FRAC_NBITS: u32 = I16F16::FRAC_NBITS;

    /// Creates the value of a decimal number such as `"-0.25"`, rounded to the nearest step.
    ///
    /// For constants: text that is not a number, or is out of range, does not compile in a constant and
    /// panics elsewhere.
    #[must_use]
    pub const fn lit(text: &str) -> Self {
        Self(I16F16::lit(text))
    }

    /// Creates a value from its steps of 2^-16.
    #[must_use]
    pub const fn from_bits(bits: i32) -> Self {
        Self(I16F16::from_bits(bits))
    }

    /// Returns the value in steps of 2^-16.
    #[must_use]
    pub const fn to_bits(self) -> i32 {
        self.0.to_bits()
    }

    /// Creates the value of a number of any kind, floats included; saturates.
    #[must_use]
    pub fn from_num<N: ToFixed>(number: N) -> Self {
        Self(number.saturating_to_fixed())
    }

    /// Returns the value as a number of any kind, floats included.
    #[must_use]
    pub fn to_num<N: FromFixed>(self) -> N {
        self.0.to_num()
    }

    /// Returns whether it is below 0.
    #[must_use]
    pub const fn is_negative(self) -> bool {
        self.0.is_negative()
    }

    /// Returns the magnitude; saturates.
    #[must_use]
    pub const fn abs(self) -> Self {
        Self(self.0.saturating_abs())
    }

    /// Returns the quotient, rounded towards zero; `None` for division by zero.
    #[must_use]
    pub const fn checked_div_int(self, by: i32) -> Option<Self> {
        match self.0.checked_div_int(by) {
            Some(quotient) => Some(Self(quotient)),
            None => None,
        }
    }

    /// Returns the fraction `value / of`, rounded down, within 0..=1; 0 if `of` is 0.
    pub(crate) fn fraction(value: i32, of: i32) -> Self {
        let one = i64::from(Self::ONE.to_bits());
        let wide = i64::from(value).saturating_mul(one);
        let part = wide.checked_div(of.into()).unwrap_or(0).clamp(0, one);
        Self::from_bits(i32::try_from(part).unwrap_or(i32::MAX))
    }

    /// Returns the nearest value within `low..=high`.
    ///
    /// Not `clamp`, which panics if `low` is above `high`.
    pub(crate) fn limited(self, low: Self, high: Self) -> Self {
        self.max(low).min(high)
    }
}

impl Add for Effort {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

impl AddAssign for Effort {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Effort {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}

impl Neg for Effort {
    type Output = Self;

    fn neg(self) -> Self {
        Self(self.0.saturating_neg())
    }
}

impl Mul for Effort {
    type Output = Self;

    fn mul(self, by: Self) -> Self {
        const HALF_STEP: u64 = 1 << (Effort::FRAC_NBITS - 1);
        let (a, b) = (self.to_bits(), by.to_bits());
        // 31 bits each.
        let product = u64::from(a.unsigned_abs()).wrapping_mul(b.unsigned_abs().into());
        let magnitude = product.wrapping_add(HALF_STEP) >> Self::FRAC_NBITS;
        let magnitude = i32::try_from(magnitude).unwrap_or(i32::MAX);
        Self::from_bits(if (a < 0) != (b < 0) {
            magnitude.wrapping_neg()
        } else {
            magnitude
        })
    }
}

impl Sum for Effort {
    fn sum<I: Iterator<Item = Self>>(values: I) -> Self {
        values.fold(Self::ZERO, Self::add)
    }
}

impl fmt::Display for Effort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl fmt::Debug for Effort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&self.0, f)
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Effort {
    fn format(&self, fmt: defmt::Formatter<'_>) {
        defmt::Format::format(&defmt::Display2Format(&self.0), fmt);
    }
}

/// A partial control vector **v**_l of \[004\] eq. 1, split into turning and going ahead.
///
/// The avoiding and the orienting behaviours only turn (`v_L = −v_R`, \[004\] §3), the speed only goes
/// ahead. So two numbers are enough, and turning left is the exact opposite of turning right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Motion {
    /// Added to the right wheels and subtracted from the left ones; positive to the left.
    pub turn: Effort,
    /// Added to both.
    pub ahead: Effort,
}

/// The speeds of the right and of the left wheels.
///
/// Units and range: parts of full speed; within ±1 where a [`Controller`](crate::Controller) sets them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Wheels {
    /// `v_R`.
    pub right: Effort,
    /// `v_L`.
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
    /// Differs from \[004\] eq. 1, whose sum has no bound: turning has priority, and going ahead gets the rest
    /// of full speed. A sum limited wheel by wheel would turn less the faster the robot goes.
    #[must_use]
    pub fn wheels(self) -> Wheels {
        let turn = self.turn.limited(Effort::NEG_ONE, Effort::ONE);
        let rest = Effort::ONE - turn.abs();
        let ahead = self.ahead.limited(-rest, rest);
        Wheels {
            right: ahead + turn,
            left: ahead - turn,
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
    /// The side to which a positive turn goes.
    Left,
    /// The other side.
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

    /// Returns `amount` with the sign of a turn to this side.
    pub(crate) fn signed(self, amount: Effort) -> Effort {
        match self {
            Self::Left => amount,
            Self::Right => -amount,
        }
    }
}

/// The limit of acceleration, \[004\] eq. 16: how fast wheels may change their speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Limits {
    /// The speed of an effort of 1, in mm/s; above zero.
    pub full_speed_mm_s: u32,
    /// `a_th` of a wheel that speeds up, in mm/s².
    pub faster_mm_s2: u32,
    /// `a_th` of a wheel that slows down, in mm/s².
    pub slower_mm_s2: u32,
}

impl Limits {
    /// 1 m/s; 3 m/s² and 6 m/s² of \[004\] eq. 16.
    ///
    /// \[004\] does not give the full speed of its simulations.
    pub const DEFAULT: Self = Self {
        full_speed_mm_s: 1000,
        faster_mm_s2: 3000,
        slower_mm_s2: 6000,
    };

    /// Returns `f_a` of \[004\] eq. 16: the speeds nearest to `wanted` that wheels at `before` can have after
    /// `elapsed_ms`.
    ///
    /// A wheel that reverses stops first. Rounds the change down, to 2^-16 of full speed: an acceleration of
    /// less than that in one step moves nothing.
    ///
    /// Differs from \[004\] eq. 16, which as printed limits only a rise of speed: (v(t) − v(t − 1)) / Δt is
    /// below any limit while the robot brakes, though a limit for braking is given.
    #[must_use]
    pub fn apply(&self, wanted: Wheels, before: Wheels, elapsed_ms: u32) -> Wheels {
        let faster = self.change(self.faster_mm_s2, elapsed_ms);
        let slower = self.change(self.slower_mm_s2, elapsed_ms);
        Wheels {
            right: approach(wanted.right, before.right, faster, slower),
            left: approach(wanted.left, before.left, faster, slower),
        }
    }

    /// The change of speed in `elapsed_ms` at an acceleration.
    fn change(&self, mm_s2: u32, elapsed_ms: u32) -> Effort {
        // 64 bits hold the product and an effort's 16 fraction bits if the time has at most 12: 4.095 s.
        let elapsed = u64::from(elapsed_ms.min((1 << 12) - 1));
        let change = u64::from(mm_s2).saturating_mul(elapsed) << Effort::FRAC_NBITS;
        let unit = u64::from(self.full_speed_mm_s).saturating_mul(1000);
        let bits = change.checked_div(unit).unwrap_or(0);
        Effort::from_bits(i32::try_from(bits).unwrap_or(i32::MAX))
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// One wheel's speed after a step.
fn approach(wanted: Effort, before: Effort, faster: Effort, slower: Effort) -> Effort {
    // Computed forwards; backwards is the exact opposite.
    if before < Effort::ZERO {
        return -approach(-wanted, -before, faster, slower);
    }
    if before == Effort::ZERO {
        // From a stop, both directions speed up.
        wanted.limited(-faster, faster)
    } else {
        wanted.limited((before - slower).max(Effort::ZERO), before + faster)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn motion(turn: f64, ahead: f64) -> Motion {
        Motion {
            turn: Effort::from_num(turn),
            ahead: Effort::from_num(ahead),
        }
    }

    fn wheels(right: f64, left: f64) -> Wheels {
        Wheels {
            right: Effort::from_num(right),
            left: Effort::from_num(left),
        }
    }

    #[test]
    fn turning_left_speeds_the_right_wheels_up() {
        assert_eq!(motion(0.25, 0.5).wheels(), wheels(0.75, 0.25));
    }

    #[test]
    fn at_full_speed_turning_has_priority() {
        assert_eq!(motion(0.5, 2.0).wheels(), wheels(1.0, 0.0));
        assert_eq!(motion(-7.0, 2.0).wheels(), wheels(-1.0, 1.0));
    }

    #[test]
    fn products_are_rounded_alike_on_both_sides() {
        let third = Effort::from_bits(21_845);
        let weight = Effort::from_bits(65_535);
        // 21845 · 65535 / 65536 = 21844.67
        assert_eq!((third * weight).to_bits(), 21_845);
        assert_eq!((-third * weight).to_bits(), -21_845);
        assert_eq!(Effort::MIN * Effort::MIN, Effort::MAX);
        assert_eq!(Effort::MIN * Effort::MAX, -Effort::MAX);
    }

    #[test]
    fn every_operator_saturates() {
        assert_eq!(Effort::MAX + Effort::DELTA, Effort::MAX);
        assert_eq!(Effort::MIN - Effort::DELTA, Effort::MIN);
        assert_eq!(-Effort::MIN, Effort::MAX);
        assert_eq!(Effort::MIN.abs(), Effort::MAX);
        assert_eq!([Effort::MAX; 3].into_iter().sum::<Effort>(), Effort::MAX);
    }

    /// At a full speed of 1.5 m/s, in 125 ms: 3000 · 0.125 / 1500 = 0.25 and 6000 · 0.125 / 1500 = 0.5.
    #[test]
    fn eq_16_by_hand() {
        let limits = Limits {
            full_speed_mm_s: 1500,
            ..Limits::DEFAULT
        };
        for (wanted, before, expected) in [
            ((1.0, 1.0), (0.0, 0.5), (0.25, 0.75)),
            ((0.0, 0.0), (1.0, 0.25), (0.5, 0.0)),
            ((0.6, 0.4), (0.5, 0.5), (0.6, 0.4)),
            ((-1.0, -1.0), (0.25, -0.5), (0.0, -0.75)),
            ((-1.0, -1.0), (0.0, 0.0), (-0.25, -0.25)),
        ] {
            let [wanted, before, expected] =
                [wanted, before, expected].map(|(right, left)| wheels(right, left));
            assert_eq!(limits.apply(wanted, before, 125), expected);
        }
    }

    #[test]
    fn no_time_is_no_change() {
        let before = wheels(0.5, -0.5);
        assert_eq!(Limits::DEFAULT.apply(wheels(1.0, 1.0), before, 0), before);
    }

    fn effort() -> impl Strategy<Value = Effort> {
        (-65536_i32..=65536).prop_map(Effort::from_bits)
    }

    proptest! {
        #[test]
        fn no_step_is_beyond_the_limit_and_none_leads_away(
            wanted in effort(), before in effort(), elapsed in 0_u32..500,
        ) {
            let pair = |effort| Wheels { right: effort, left: -effort };
            let after = Limits::DEFAULT.apply(pair(wanted), pair(before), elapsed);
            prop_assert_eq!(after.left, -after.right);
            let change = (after.right - before).abs();
            let slower = after.right.abs() < before.abs();
            let most = f64::from(elapsed) / 1000.0 * if slower { 6.0 } else { 3.0 };
            prop_assert!(change.to_num::<f64>() <= most + 1e-9);
            prop_assert!((wanted - after.right).abs() <= (wanted - before).abs());
        }
    }
}
