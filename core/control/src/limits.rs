//! No jolt: the limit of acceleration, \[004\] eq. 16.

use super::motion::bounded;
use super::{Effort, Wheels};
use certainty_core::narrow::saturating_i32;

/// How fast wheels may change their speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Limits {
    /// What a signal of 1 is, in mm/s; above zero.
    pub full_speed_mm_s: u32,
    /// `a_th` when a wheel gets faster, in mm/s².
    pub faster_mm_s2: u32,
    /// `a_th` when a wheel gets slower, in mm/s².
    pub slower_mm_s2: u32,
}

impl Limits {
    /// 1 m/s; 3 m/s² and 6 m/s² of \[004\] eq. 16.
    ///
    /// \[004\] does not say how fast IBIS went in its simulations.
    pub const DEFAULT: Self = Self {
        full_speed_mm_s: 1000,
        faster_mm_s2: 3000,
        slower_mm_s2: 6000,
    };

    /// Returns `f_a` of \[004\] eq. 16: as near to `wanted` as `elapsed_ms` after `before` allow.
    ///
    /// A wheel that is to turn the other way round stops first. Rounds the steps down, to 2^-16 of full speed:
    /// an acceleration that is less in a step moves nothing.
    ///
    /// Differs from \[004\] eq. 16, which as printed limits a speed's rise alone: (v(t) − v(t − 1)) / Δt is
    /// below any limit while the robot brakes, though a limit for braking is given.
    #[must_use]
    pub fn limited(&self, wanted: Wheels, before: Wheels, elapsed_ms: u32) -> Wheels {
        let (faster, slower) = (
            self.step(self.faster_mm_s2, elapsed_ms),
            self.step(self.slower_mm_s2, elapsed_ms),
        );
        Wheels {
            right: approached(wanted.right, before.right, faster, slower),
            left: approached(wanted.left, before.left, faster, slower),
        }
    }

    /// The change of a signal in `elapsed_ms` at an acceleration.
    fn step(&self, mm_s2: u32, elapsed_ms: u32) -> Effort {
        // 64 bits hold the product, 16 more of a signal's fraction included, where time has 12: 4.095 s.
        let elapsed = u64::from(elapsed_ms.min((1 << 12) - 1));
        let change = u64::from(mm_s2).saturating_mul(elapsed) << Effort::FRAC_NBITS;
        let unit = u64::from(self.full_speed_mm_s).saturating_mul(1000);
        let bits = change.checked_div(unit).unwrap_or(0);
        Effort::from_bits(saturating_i32(bits.cast_signed()))
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// One wheel's speed after a step.
fn approached(wanted: Effort, before: Effort, faster: Effort, slower: Effort) -> Effort {
    // As if it went forwards; the mirror image is its exact opposite.
    if before < Effort::ZERO {
        let opposite = approached(
            wanted.saturating_neg(),
            before.saturating_neg(),
            faster,
            slower,
        );
        return opposite.saturating_neg();
    }
    let most = before.saturating_add(faster);
    let least = before.saturating_sub(slower);
    if before == Effort::ZERO {
        // From standing, either way is faster.
        bounded(wanted, most.saturating_neg(), most)
    } else {
        bounded(wanted, least.max(Effort::ZERO), most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn wheels(right: f64, left: f64) -> Wheels {
        Wheels {
            right: Effort::from_num(right),
            left: Effort::from_num(left),
        }
    }

    /// At 1.5 m/s full speed, in 125 ms.
    #[test]
    fn eq_16_by_hand() {
        let limits = Limits {
            full_speed_mm_s: 1500,
            ..Limits::DEFAULT
        };
        // 3000 · 0.125 / 1500 = 0.25 and 6000 · 0.125 / 1500 = 0.5.
        let after = |wanted, before| limits.limited(wanted, before, 125);
        assert_eq!(
            after(wheels(1.0, 1.0), wheels(0.0, 0.5)),
            wheels(0.25, 0.75)
        );
        assert_eq!(after(wheels(0.0, 0.0), wheels(1.0, 0.25)), wheels(0.5, 0.0));
        assert_eq!(after(wheels(0.6, 0.4), wheels(0.5, 0.5)), wheels(0.6, 0.4));
        assert_eq!(
            after(wheels(-1.0, -1.0), wheels(0.25, -0.5)),
            wheels(0.0, -0.75)
        );
        assert_eq!(
            after(wheels(-1.0, -1.0), wheels(0.0, 0.0)),
            wheels(-0.25, -0.25)
        );
    }

    #[test]
    fn no_time_is_no_change() {
        let before = wheels(0.5, -0.5);
        assert_eq!(Limits::DEFAULT.limited(wheels(1.0, 1.0), before, 0), before);
    }

    fn signal() -> impl Strategy<Value = Effort> {
        (-65536_i32..=65536).prop_map(Effort::from_bits)
    }

    proptest! {
        #[test]
        fn no_step_is_beyond_the_limit_and_none_leads_away(
            wanted in signal(), before in signal(), elapsed in 0_u32..500,
        ) {
            let pair = |signal| Wheels { right: signal, left: -signal };
            let after = Limits::DEFAULT.limited(pair(wanted), pair(before), elapsed);
            prop_assert_eq!(after.left, -after.right);
            let change = (after.right - before).abs();
            let slower = after.right.abs() < before.abs();
            let most = f64::from(elapsed) / 1000.0 * if slower { 6.0 } else { 3.0 };
            prop_assert!(change.to_num::<f64>() <= most + 1e-9);
            prop_assert!((wanted - after.right).abs() <= (wanted - before).abs());
        }
    }
}
