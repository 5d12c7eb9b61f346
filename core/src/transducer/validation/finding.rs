//! What validation finds.

use crate::transducer::Reading;
use core::fmt;

/// What a [`Validator`](super::Validator) thinks of a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Finding {
    /// Nothing speaks against it.
    Plausible,
    /// In the same direction something else was seen shortly before, and no motion explains the
    /// change. A label: the reading stays.
    Jump,
    /// An echo from where the sensor cannot see. The reading becomes *missing*, implausible.
    OutOfRange,
    /// The same raw word has claimed an echo in too many directions one after the other. The
    /// reading becomes *missing*, implausible.
    StuckAt,
    /// There was no reading; its reason stays.
    Missing,
}

impl Finding {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Plausible,
        Self::Jump,
        Self::OutOfRange,
        Self::StuckAt,
        Self::Missing,
    ];
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Plausible => "plausible",
            Self::Jump => "jump",
            Self::OutOfRange => "out of range",
            Self::StuckAt => "stuck",
            Self::Missing => "missing",
        })
    }
}

/// A reading with what was found; what the fusion level is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[must_use]
pub struct Validated {
    /// The reading as it goes on.
    pub reading: Reading,
    /// Why it does so.
    pub finding: Finding,
}

/// How often each finding was made; saturates at 65,535.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FindingCounts([u16; Finding::ALL.len()]);

impl FindingCounts {
    /// None was made yet.
    pub(super) const NONE: Self = Self([0; Finding::ALL.len()]);

    /// Returns how often `finding` was made.
    #[must_use]
    pub fn of(&self, finding: Finding) -> u16 {
        self.0.get(finding as usize).copied().unwrap_or_default()
    }

    /// Counts one more.
    pub(super) fn record(&mut self, finding: Finding) {
        if let Some(count) = self.0.get_mut(finding as usize) {
            *count = count.saturating_add(1);
        }
    }
}
