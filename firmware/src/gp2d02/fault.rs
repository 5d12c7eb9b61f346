//! Why a GP2D02 gave no byte.

use certainty_core::transducer::Missing;
use core::fmt;

/// What is wrong with a GP2D02 or its two lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Fault {
    /// Vout is low though the sensor should idle: a short circuit, no supply, or no sensor.
    StuckLow,
    /// Vout stays high though a conversion was asked for.
    StuckHigh,
    /// Vout says now this, now that where it must hold still.
    Floating,
    /// No end of the conversion within its 70 ms.
    Timeout,
    /// After the eight bits Vout did not go back to high: who sent them is gone.
    CutShort,
    /// The microcontroller's pin refused.
    Pin,
    /// A read without a conversion under way, or a start during one.
    OutOfTurn,
}

impl Fault {
    /// Returns what the fault makes of the reading.
    ///
    /// What nobody asked for did not come in time; what is wrong with a line is the line's.
    #[must_use]
    pub const fn reason(self) -> Missing {
        match self {
            Self::Timeout | Self::OutOfTurn => Missing::Timeout,
            Self::StuckLow | Self::StuckHigh | Self::Floating | Self::CutShort | Self::Pin => {
                Missing::Bus
            }
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::StuckLow => "Vout is low while the sensor idles",
            Self::StuckHigh => "Vout is high while the sensor converts",
            Self::Floating => "Vout does not hold still",
            Self::Timeout => "the conversion did not end in time",
            Self::CutShort => "Vout stays low after the bits",
            Self::Pin => "the pin failed",
            Self::OutOfTurn => "asked out of turn",
        })
    }
}

impl core::error::Error for Fault {}
