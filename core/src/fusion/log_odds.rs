//! Eq. 1 as an addition of bytes.

use crate::certainty::Certainty;

/// The logarithm of the odds of being occupied, in steps of 1/16 nat.
///
/// Formula: 16 · ln(p / (1 − p)). In this form eq. 1 of \[001\], which multiplies odds, is an addition.
///
/// Units and range: −127 to 127, which is p = 0.00036 to 0.99964; the sum saturates there. Eq. 1 itself
/// divides by zero at p = 0 and never leaves 0 or 1 again: the bound is what lets a cell recover.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LogOdds(i8);

impl LogOdds {
    /// Steps in one nat.
    pub const STEPS_PER_NAT: u8 = 16;
    /// Even odds.
    pub const EVEN: Self = Self(0);
    /// The surest that something is occupied.
    pub const MAX: Self = Self(127);

    /// The least odds that can be expressed, against.
    pub const MIN: Self = Self(-127);

    /// Creates log-odds of `steps`; −128 becomes −127.
    #[must_use]
    pub const fn from_steps(steps: i8) -> Self {
        Self(if steps == i8::MIN { -127 } else { steps })
    }

    /// Returns the number of steps, `-127..=127`.
    #[must_use]
    pub const fn steps(self) -> i8 {
        self.0
    }

    /// Returns the log-odds of `certainty`.
    ///
    /// Rounds to the nearest step. *Free* and *occupied*, whose odds are infinite, are ∓127.
    ///
    /// ```
    /// use certainty_core::certainty::Certainty;
    /// use certainty_core::fusion::LogOdds;
    ///
    /// assert_eq!(LogOdds::from(Certainty::UNCERTAIN), LogOdds::EVEN);
    /// assert_eq!(LogOdds::from(Certainty::OCCUPIED), LogOdds::MAX);
    /// assert_eq!(LogOdds::from(Certainty::from_bits(192)).steps(), 18); // 16 · ln 3
    /// ```
    #[must_use]
    #[expect(
        clippy::indexing_slicing,
        reason = "a byte is always inside a table of 256"
    )]
    pub const fn of(certainty: Certainty) -> Self {
        Self(OF_CERTAINTY[certainty.to_bits() as usize])
    }

    /// Returns the certainty with these odds.
    ///
    /// Rounds to the nearest step of 1/256.
    #[must_use]
    #[expect(
        clippy::indexing_slicing,
        reason = "a byte is always inside a table of 256"
    )]
    pub const fn certainty(self) -> Certainty {
        Certainty::from_bits(OF_LOG_ODDS[self.0.cast_unsigned() as usize])
    }

    /// Returns the odds after another, independent opinion: eq. 1 of \[001\] for n = 2.
    #[must_use]
    pub const fn saturating_add(self, other: Self) -> Self {
        Self::from_steps(self.0.saturating_add(other.0))
    }
}

impl From<Certainty> for LogOdds {
    fn from(certainty: Certainty) -> Self {
        Self::of(certainty)
    }
}

/// Made by the compiler; nothing here runs on the target.
static OF_CERTAINTY: [i8; 256] = of_certainty();
static OF_LOG_ODDS: [u8; 256] = of_log_odds();

#[expect(
    clippy::indexing_slicing,
    clippy::arithmetic_side_effects,
    clippy::cast_possible_truncation,
    clippy::float_arithmetic,
    reason = "evaluated at compile time, where a mistake is a compile error"
)]
const fn of_certainty() -> [i8; 256] {
    let mut table = [0; 256];
    table[0] = -127;
    table[255] = 127;
    let mut bits = 1;
    while bits < 255 {
        let odds = bits as f64 / (256 - bits) as f64;
        let steps = LogOdds::STEPS_PER_NAT as f64 * ln(odds);
        table[bits] = rounded(steps) as i8;
        bits += 1;
    }
    table
}

#[expect(
    clippy::indexing_slicing,
    clippy::arithmetic_side_effects,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::float_arithmetic,
    reason = "evaluated at compile time, where a mistake is a compile error"
)]
const fn of_log_odds() -> [u8; 256] {
    let mut table = [0; 256];
    let mut steps = -127_i32;
    while steps <= 127 {
        let odds = exp(steps as f64 / LogOdds::STEPS_PER_NAT as f64);
        let bits = rounded(256.0 * odds / (1.0 + odds));
        table[(steps & 0xFF) as usize] = if bits > 255 { 255 } else { bits as u8 };
        steps += 1;
    }
    table
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::float_arithmetic,
    reason = "compile time"
)]
const fn rounded(value: f64) -> i32 {
    (if value < 0.0 {
        value - 0.5
    } else {
        value + 0.5
    }) as i32
}

/// ln of a positive number: 2 · artanh((x − 1) / (x + 1)) after taking out powers of e.
#[expect(
    clippy::arithmetic_side_effects,
    clippy::float_arithmetic,
    reason = "compile time"
)]
const fn ln(value: f64) -> f64 {
    let mut x = value;
    let mut whole = 0.0;
    while x > core::f64::consts::E {
        x /= core::f64::consts::E;
        whole += 1.0;
    }
    while x < 1.0 {
        x *= core::f64::consts::E;
        whole -= 1.0;
    }
    let z = (x - 1.0) / (x + 1.0);
    let mut power = z;
    let mut sum = 0.0;
    let mut k = 1;
    while k < 60 {
        sum += power / k as f64;
        power *= z * z;
        k += 2;
    }
    whole + 2.0 * sum
}

/// e to the power of `value`: the series of value / 32, squared five times.
#[expect(
    clippy::arithmetic_side_effects,
    clippy::float_arithmetic,
    reason = "compile time"
)]
const fn exp(value: f64) -> f64 {
    let x = value / 32.0;
    let mut sum = 1.0;
    let mut term = 1.0;
    let mut k = 1;
    while k < 20 {
        term *= x / k as f64;
        sum += term;
        k += 1;
    }
    let mut squarings = 5;
    while squarings > 0 {
        sum *= sum;
        squarings -= 1;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_tables_are_the_formula_rounded() {
        for bits in 1..=254_u8 {
            let p = f64::from(bits) / 256.0;
            let exact = 16.0 * (p / (1.0 - p)).ln();
            let steps = LogOdds::of(Certainty::from_bits(bits)).steps();
            assert_eq!(f64::from(steps), exact.round(), "certainty {bits}");
        }
        for steps in -127..=127_i8 {
            let p = 1.0 / (1.0 + (-f64::from(steps) / 16.0).exp());
            let bits = LogOdds::from_steps(steps).certainty().to_bits();
            assert_eq!(
                f64::from(bits),
                (256.0 * p).round().min(255.0),
                "{steps} steps"
            );
        }
    }

    #[test]
    fn the_landmarks_survive_the_way_there_and_back() {
        for landmark in [Certainty::FREE, Certainty::UNCERTAIN, Certainty::OCCUPIED] {
            assert_eq!(LogOdds::of(landmark).certainty(), landmark);
        }
    }

    #[test]
    fn there_and_back_loses_no_more_than_half_a_step() {
        // A step of 1/16 nat is 4 certainties wide in the middle.
        for bits in 0..=u8::MAX {
            let back = LogOdds::of(Certainty::from_bits(bits))
                .certainty()
                .to_bits();
            assert!(back.abs_diff(bits) <= 2, "{bits} came back as {back}");
        }
    }
}
