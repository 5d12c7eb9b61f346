//! Converts the byte of a triangulating infrared sensor to millimetres.

use super::reading::Reading;
use crate::units::Millimeters;
use core::fmt;
use fixed::types::U8F8;

/// The inverse characteristic of one GP2D02: raw ≈ a / (d + b) + c.
///
/// The parameters are checked: `a` is positive and the range is not empty. Every unit needs its own
/// calibration: real units differ by up to 48 counts at 80 cm.
///
/// Cost: one division of 32 bits a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Calibration {
    slope: u32,
    offset: Millimeters,
    floor: u16,
    nearest: Millimeters,
    farthest: Millimeters,
}

/// Why a calibration was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CalibrationError {
    /// The slope `a` is zero or above [`Calibration::MAX_SLOPE`].
    Slope,
    /// The nearest distance is not below the farthest.
    EmptyRange,
}

impl CalibrationError {
    const fn message(self) -> &'static str {
        match self {
            Self::Slope => "the slope must be above zero and at most 8388607 count-millimetres",
            Self::EmptyRange => "the nearest distance must be below the farthest",
        }
    }
}

impl fmt::Display for CalibrationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message())
    }
}

impl core::error::Error for CalibrationError {}

impl Calibration {
    /// Largest slope, in count-millimetres: 2^23 − 1, as eight bits are kept for the fraction.
    pub const MAX_SLOPE: u32 = (1 << 23) - 1;

    /// Creates the characteristic raw ≈ `slope` / (d + `offset`) + `floor` for distances from
    /// `nearest` to `farthest`, for constants.
    ///
    /// Units: `slope` in count-millimetres (a GP2D02 has about 13 000), `floor` in counts.
    ///
    /// # Panics
    ///
    /// For parameters that [`Self::try_new`] refuses: a constant then does not build. Use that at
    /// run time.
    #[expect(clippy::panic, reason = "refuses a constant at compile time")]
    #[must_use]
    pub const fn new(
        slope: u32,
        offset: Millimeters,
        floor: U8F8,
        nearest: Millimeters,
        farthest: Millimeters,
    ) -> Self {
        match Self::try_new(slope, offset, floor, nearest, farthest) {
            Ok(calibration) => calibration,
            Err(error) => panic!("{}", error.message()),
        }
    }

    /// Creates the characteristic raw ≈ `slope` / (d + `offset`) + `floor` for distances from
    /// `nearest` to `farthest`.
    ///
    /// Units: as for [`Self::new`].
    ///
    /// # Errors
    ///
    /// [`CalibrationError`] names the parameter that is out of range.
    pub const fn try_new(
        slope: u32,
        offset: Millimeters,
        floor: U8F8,
        nearest: Millimeters,
        farthest: Millimeters,
    ) -> Result<Self, CalibrationError> {
        if slope == 0 || slope > Self::MAX_SLOPE {
            return Err(CalibrationError::Slope);
        }
        if nearest.get() >= farthest.get() {
            return Err(CalibrationError::EmptyRange);
        }
        Ok(Self {
            slope,
            offset,
            floor: floor.to_bits(),
            nearest,
            farthest,
        })
    }

    /// Returns the shortest distance that the sensor can measure.
    #[must_use]
    pub const fn nearest(&self) -> Millimeters {
        self.nearest
    }

    /// Returns the longest distance that the sensor can measure.
    #[must_use]
    pub const fn farthest(&self) -> Millimeters {
        self.farthest
    }

    /// Converts a raw byte to a reading.
    ///
    /// Formula: d = a / (raw − c) − b. Rounds to the nearest millimetre, ties up. Below the range
    /// the reading is [`Reading::TooNear`]; above it, and for raw ≤ c, [`Reading::NoObject`].
    ///
    /// ```
    /// use certainty_core::transducer::{Calibration, Reading};
    /// use certainty_core::units::Millimeters;
    /// use fixed::types::U8F8;
    ///
    /// const UNIT: Calibration = Calibration::new(
    ///     13_000,
    ///     Millimeters::ZERO,
    ///     U8F8::lit("60"),
    ///     Millimeters::new(100),
    ///     Millimeters::new(800),
    /// );
    /// assert_eq!(UNIT.reading(86), Reading::Echo(Millimeters::new(500)));
    /// assert_eq!(UNIT.reading(255), Reading::TooNear);
    /// assert_eq!(UNIT.reading(60), Reading::NoObject);
    /// ```
    #[must_use]
    pub const fn reading(&self, raw: u8) -> Reading {
        // Both in steps of 1/256 count, which is exact.
        let signal = ((raw as u32) << 8).saturating_sub(self.floor as u32);
        let scaled = self.slope << 8;
        let Some(reach) = scaled.wrapping_add(signal / 2).checked_div(signal) else {
            return Reading::NoObject;
        };
        let distance = Millimeters::new(reach).saturating_sub(self.offset);
        if distance.get() < self.nearest.get() {
            Reading::TooNear
        } else if distance.get() > self.farthest.get() {
            Reading::NoObject
        } else {
            Reading::Echo(distance)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn mm(mm: u32) -> Millimeters {
        Millimeters::new(mm)
    }

    #[test]
    fn every_byte_agrees_with_the_formula() {
        let (slope, offset, floor) = (13_211, 7, 57.625);
        let unit = Calibration::try_new(slope, mm(offset), U8F8::from_num(floor), mm(100), mm(800))
            .unwrap();
        for raw in 0..=u8::MAX {
            let exact = f64::from(slope) / (f64::from(raw) - floor) - f64::from(offset);
            let rounded = (exact + 0.5).floor();
            let expected = if f64::from(raw) <= floor || rounded > 800.0 {
                Reading::NoObject
            } else if rounded < 100.0 {
                Reading::TooNear
            } else {
                Reading::Echo(mm(rounded as u32))
            };
            assert_eq!(unit.reading(raw), expected, "raw {raw}");
        }
    }

    #[test]
    fn extreme_parameters_do_not_overflow() {
        let unit = Calibration::try_new(
            Calibration::MAX_SLOPE,
            Millimeters::ZERO,
            U8F8::ZERO,
            Millimeters::ZERO,
            mm(u32::MAX),
        )
        .unwrap();
        assert_eq!(unit.reading(1), Reading::Echo(mm(Calibration::MAX_SLOPE)));
        assert_eq!(unit.reading(0), Reading::NoObject);
    }

    #[test]
    fn bad_parameters_are_refused() {
        let floor = U8F8::ZERO;
        assert_eq!(
            Calibration::try_new(0, mm(0), floor, mm(1), mm(2)),
            Err(CalibrationError::Slope)
        );
        assert_eq!(
            Calibration::try_new(1, mm(0), floor, mm(2), mm(2)),
            Err(CalibrationError::EmptyRange)
        );
    }
}
