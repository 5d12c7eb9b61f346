//! What a sensor's readings are held to.

use crate::units::Millimeters;
use core::fmt;

/// What a sensor's readings are held to, before it is checked.
///
/// No paper gives numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ValidationConfig {
    /// The shortest distance the sensor can tell.
    pub nearest: Millimeters,
    /// The longest.
    pub farthest: Millimeters,
    /// A change in one direction up to here is none: what noise alone can make of two readings.
    pub jump: Millimeters,
    /// How fast things come nearer or go away, robot included, in mm/s.
    pub speed_mm_s: u16,
    /// A reading is compared with one that is at most so many ms old. Longer than a sweep, or a
    /// swept sensor's never are.
    pub compare_within: u32,
    /// So many looks in new directions one after the other may give the same raw word.
    pub same_word: u16,
}

impl ValidationConfig {
    /// A swept infrared sensor that comes to the same direction again after `sweep_ms`.
    ///
    /// A jump is half of the range, as a unit that errs by 12 % (\[001\] Table 1, D) makes two
    /// readings of 80 cm differ by more than that once in a hundred times. A word is stuck after a
    /// whole sweep of `directions`: sound sensors see the same distance all the way round only from
    /// the middle of a circle, and a flat wall gives a GP2D02 the same byte over at most 40°.
    #[must_use]
    pub const fn sweeping(
        nearest: Millimeters,
        farthest: Millimeters,
        speed_mm_s: u16,
        directions: u16,
        sweep_ms: u32,
    ) -> Self {
        Self {
            nearest,
            farthest,
            jump: Millimeters::new(farthest.saturating_sub(nearest).get() / 2),
            speed_mm_s,
            compare_within: sweep_ms.saturating_add(sweep_ms / 2),
            same_word: directions,
        }
    }
}

/// The checked [`ValidationConfig`].
///
/// Possession proves that the range is not empty and fits 16 bits, that a jump is above zero, and
/// that at least one look may repeat a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ValidationRules(ValidationConfig);

/// Why a configuration was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ValidationError {
    /// The nearest distance is not below the farthest, or that is above 65,535 mm.
    Range,
    /// Every change would be a jump.
    Jump,
    /// Every echo would be stuck.
    SameWord,
}

impl fmt::Display for ValidationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Range => "the nearest distance must be below the farthest, that at most 65535 mm",
            Self::Jump => "a jump must be above 0 mm, or noise is one",
            Self::SameWord => "a word may be repeated at least once, or every echo is stuck",
        })
    }
}

impl core::error::Error for ValidationError {}

impl ValidationRules {
    /// Checks the configuration.
    ///
    /// # Errors
    ///
    /// [`ValidationError`] names what cannot be.
    pub const fn try_new(config: ValidationConfig) -> Result<Self, ValidationError> {
        let farthest = config.farthest.get();
        if config.nearest.get() >= farthest || farthest > u16::MAX as u32 {
            Err(ValidationError::Range)
        } else if config.jump.get() == 0 {
            Err(ValidationError::Jump)
        } else if config.same_word == 0 {
            Err(ValidationError::SameWord)
        } else {
            Ok(Self(config))
        }
    }

    /// Returns the configuration.
    #[must_use]
    pub const fn config(&self) -> &ValidationConfig {
        &self.0
    }

    /// The largest change that motion explains in so many milliseconds.
    pub(super) fn explained(&self, age: u32) -> Millimeters {
        // 32 by 16 bits, and fewer than 2^32 mm in the end.
        let moved = u64::from(age).wrapping_mul(self.0.speed_mm_s.into()) / 1000;
        let moved = Millimeters::new(u32::try_from(moved).unwrap_or(u32::MAX));
        self.0.jump.saturating_add(moved)
    }
}
