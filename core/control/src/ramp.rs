//! A function of straight pieces: α of \[004\] eq. 1 and Fig. 5.

use super::Effort;
use certainty_core::narrow::saturating_i32;
use certainty_core::units::Millimeters;
use core::fmt;

/// A corner of a [`Ramp`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Corner {
    /// Where.
    pub at: Millimeters,
    /// How high.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub height: Effort,
}

/// A function of the distance to the nearest obstacle, of straight pieces between four corners, level
/// before the first and behind the last.
///
/// Possession proves that the corners ascend and that no height is below 0 or above 16.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ramp([Corner; 4]);

/// A ramp's corners do not ascend, or one is below 0 or above 16.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RampError;

impl fmt::Display for RampError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a ramp's corners must ascend, with heights from 0 to 16")
    }
}

impl core::error::Error for RampError {}

impl Ramp {
    /// Checks the corners.
    ///
    /// # Errors
    ///
    /// [`RampError`] if one is not beyond the last, or its height is not within 0..=16.
    pub const fn try_new(corners: [Corner; 4]) -> Result<Self, RampError> {
        let [a, b, c, d] = corners;
        let ascending =
            a.at.get() < b.at.get() && b.at.get() < c.at.get() && c.at.get() < d.at.get();
        if ascending && a.is_bounded() && b.is_bounded() && c.is_bounded() && d.is_bounded() {
            Ok(Self(corners))
        } else {
            Err(RampError)
        }
    }

    /// Returns the height at `distance`; rounds towards the corner before it.
    ///
    /// ```
    /// use certainty_control::{Corner, Ramp, Effort};
    /// use certainty_core::units::Millimeters;
    ///
    /// let corner = |mm, height| Corner { at: Millimeters::new(mm), height: Effort::from_num(height) };
    /// let ramp = Ramp::try_new([corner(500, 1.0), corner(1000, 0.5), corner(2000, 0.5), corner(3000, 0.0)])?;
    /// assert_eq!(ramp.at(Millimeters::new(750)), Effort::lit("0.75"));
    /// assert_eq!(ramp.at(Millimeters::new(9000)), Effort::ZERO);
    /// # Ok::<(), certainty_control::RampError>(())
    /// ```
    #[must_use]
    pub fn at(&self, distance: Millimeters) -> Effort {
        let [first, ..] = self.0;
        let mut before = first;
        for corner in self.0 {
            if distance <= corner.at {
                return before.to(corner, distance);
            }
            before = corner;
        }
        before.height
    }
}

impl Corner {
    const fn is_bounded(&self) -> bool {
        let bits = self.height.to_bits();
        0 <= bits && bits <= 16 << Effort::FRAC_NBITS
    }

    /// The height at `distance`, between this corner and `next`.
    fn to(self, next: Self, distance: Millimeters) -> Effort {
        let rise = i64::from(next.height.to_bits()).saturating_sub(self.height.to_bits().into());
        let run = i64::from(next.at.saturating_sub(self.at).get());
        let gone = i64::from(distance.saturating_sub(self.at).get());
        // 21 bits times 32; without a run, before the first corner, there is no rise.
        let risen = rise.saturating_mul(gone).checked_div(run).unwrap_or(0);
        Effort::from_bits(self.height.to_bits().saturating_add(saturating_i32(risen)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn corner(mm: u32, height: Effort) -> Corner {
        Corner {
            at: Millimeters::new(mm),
            height,
        }
    }

    fn ramp() -> Ramp {
        let heights = [2.0, 1.0, 1.0, 0.25].map(Effort::from_num);
        let [a, b, c, d] = heights;
        Ramp::try_new([
            corner(100, a),
            corner(300, b),
            corner(500, c),
            corner(1500, d),
        ])
        .unwrap()
    }

    #[test]
    fn pieces_are_straight_and_ends_are_level() {
        for (mm, expected) in [
            (0, 2.0),
            (100, 2.0),
            (150, 1.75),
            (300, 1.0),
            (400, 1.0),
            (1000, 0.625),
            (1500, 0.25),
            (u32::MAX, 0.25),
        ] {
            assert_eq!(
                ramp().at(Millimeters::new(mm)),
                Effort::from_num(expected),
                "{mm}"
            );
        }
    }

    #[test]
    fn what_is_no_ramp_is_refused() {
        let one = Effort::ONE;
        let same_place = [
            corner(0, one),
            corner(1, one),
            corner(1, one),
            corner(3, one),
        ];
        assert_eq!(Ramp::try_new(same_place), Err(RampError));
        for height in [Effort::NEG_ONE, Effort::lit("16.1")] {
            let corners = [
                corner(0, one),
                corner(1, one),
                corner(2, one),
                corner(3, height),
            ];
            assert_eq!(Ramp::try_new(corners), Err(RampError));
        }
    }
}
