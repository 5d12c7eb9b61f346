//! How far each behaviour is believed: \[004\] eq. 14 and 15.

use super::motion::{bounded, scaled};
use super::{Effort, Failures};
use certainty_core::narrow::saturating_i32;

/// μ of \[004\] eq. 1, one a behaviour.
///
/// Range: 0..=1 each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Credibility {
    /// μ₀: the Braitenberg behaviour.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub braitenberg: Effort,
    /// μ₁: the histogram's.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub histogram: Effort,
    /// μ₂ and μ₃: turning to the goal and going ahead.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub goal: Effort,
}

/// `c_1` = −3 + √15, in Q32.
const C1_Q32: i64 = 3_749_434_922;
/// `c_2` = −1 / (3 + √15), in Q32.
const C2_Q32: i64 = -624_905_820;

impl Credibility {
    /// Returns what `failures` leave of each behaviour.
    ///
    /// Formula (\[004\] eq. 14, 15): `μ₀ = 1 / (Σ φ_i + c₁) + c₂`, `μ₁ = 1 − φ_s`,
    /// `μ₂ = μ₃ = 1 − φ_s Π φ_i`, over the six rangefinders. Rounds to the nearest; exactly 1 for no failure, 0 for all.
    ///
    /// Differs from \[004\] in that φ may lie between 0 and 1; at the ends it is \[004\].
    ///
    /// ```
    /// use certainty_control::{Credibility, Failures, Effort};
    ///
    /// assert_eq!(Credibility::of(&Failures::NONE).braitenberg, Effort::ONE);
    /// assert_eq!(Credibility::of(&Failures::ALL).goal, Effort::ZERO);
    /// ```
    #[must_use]
    pub fn of(failures: &Failures) -> Self {
        let parts = failures.rangefinders.map(|failure| failure.part());
        let sum = parts.into_iter().fold(Effort::ZERO, Effort::saturating_add);
        // Pair by pair, so that what is rounded is the same for left and right.
        let [a, b, c, d, e, f] = parts;
        let pairs = [scaled(a, f), scaled(b, e), scaled(c, d)];
        let product = pairs.into_iter().fold(failures.scanner.part(), scaled);
        Self {
            braitenberg: inverse_of(sum),
            histogram: failures.scanner.left(),
            goal: Effort::ONE.saturating_sub(product),
        }
    }
}

/// Eq. 14.
fn inverse_of(sum: Effort) -> Effort {
    const Q48: i64 = 1 << 48;
    // 0.87 to 6.87 in Q32, whose inverse in Q16 is 2^48 over it; 8 bits more to round them once.
    let divisor = (i64::from(sum.to_bits()) << 16).saturating_add(C1_Q32);
    let inverse = (Q48 << 8).checked_div(divisor).unwrap_or(0);
    let exact = inverse.saturating_add(C2_Q32 >> 8);
    let rounded = exact.saturating_add(1 << 7) >> 8;
    let bits = Effort::from_bits(saturating_i32(rounded));
    bounded(bits, Effort::ZERO, Effort::ONE)
}

#[cfg(test)]
mod tests {
    use super::super::Failure;
    use super::*;

    fn failed(rangefinders: usize, scanner: bool) -> Credibility {
        let mut failures = Failures::NONE;
        failures.rangefinders[..rangefinders].fill(Failure::TOTAL);
        if scanner {
            failures.scanner = Failure::TOTAL;
        }
        Credibility::of(&failures)
    }

    #[test]
    fn the_constants_are_the_papers() {
        let root = 15.0_f64.sqrt();
        let q32 = 4_294_967_296.0;
        assert!(((root - 3.0) * q32 - C1_Q32 as f64).abs() <= 0.5);
        assert!((-1.0 / (3.0 + root) * q32 - C2_Q32 as f64).abs() <= 0.5);
    }

    /// By hand, with √15 = 3.872983: 1/1.872983 − 0.145497 = 0.388410 for one failure, and so on.
    #[test]
    fn eq_14_by_hand() {
        let expected = [
            1.0, 0.388_410, 0.202_573, 0.112_702, 0.059_725, 0.024_776, 0.0,
        ];
        for (failures, expected) in expected.into_iter().enumerate() {
            let ours: f64 = failed(failures, false).braitenberg.to_num();
            assert!(
                (ours - expected).abs() < 1e-5,
                "{failures}: {ours} {expected}"
            );
        }
        assert_eq!(failed(0, false).braitenberg, Effort::ONE);
        assert_eq!(failed(6, false).braitenberg, Effort::ZERO);
    }

    #[test]
    fn eq_15_by_hand() {
        assert_eq!(failed(0, true).histogram, Effort::ZERO);
        assert_eq!(failed(6, false).histogram, Effort::ONE);
        assert_eq!(failed(5, true).goal, Effort::ONE);
        assert_eq!(failed(6, false).goal, Effort::ONE);
        assert_eq!(failed(6, true).goal, Effort::ZERO);
    }

    #[test]
    fn no_failure_leaves_all_credibility() {
        let all = Credibility {
            braitenberg: Effort::ONE,
            histogram: Effort::ONE,
            goal: Effort::ONE,
        };
        assert_eq!(Credibility::of(&Failures::NONE), all);
    }

    #[test]
    fn a_little_more_failure_never_leaves_more() {
        let of = |bits: i32| {
            let half = Failure::new_saturating(Effort::from_bits(bits));
            Credibility::of(&Failures {
                rangefinders: [half; 6],
                scanner: half,
            })
        };
        for bits in (0..65536).step_by(7) {
            let (less, more) = (of(bits), of(bits + 7));
            assert!(more.braitenberg <= less.braitenberg && more.goal <= less.goal);
            assert!((Effort::ZERO..=Effort::ONE).contains(&more.braitenberg));
        }
    }
}
