//! What goes wrong with a sensor's wires.

use super::MICROSECOND;

/// A fault of the line from a sensor to the microcontroller, or of the sensor at its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineFault {
    /// The line is high, whatever the sensor does.
    StuckHigh,
    /// The line is low, whatever the sensor does.
    StuckLow,
    /// The line is connected to nothing and picks up noise: another random level each 10 µs.
    Floating {
        /// Names the noise.
        seed: u64,
    },
    /// The sensor is pulled off during a conversion and stays off; the line's pull-down holds it
    /// low.
    UnpluggedMidConversion,
    /// The sensor's supply breaks down after each fourth bit; it starts anew a little later.
    CutShort,
    /// The sensor never gets done.
    Mute,
}

impl LineFault {
    /// How long noise holds a level.
    const NOISE_NS: u64 = 10 * MICROSECOND;

    /// Returns the level that the line has whatever the sensor does; `None` where the sensor's
    /// counts.
    pub(super) fn level(self, now_ns: u64) -> Option<bool> {
        match self {
            Self::StuckHigh => Some(true),
            Self::StuckLow => Some(false),
            Self::Floating { seed } => {
                let word = scrambled(seed ^ scrambled(now_ns / Self::NOISE_NS));
                Some(word & 1 == 1)
            }
            Self::UnpluggedMidConversion | Self::CutShort | Self::Mute => None,
        }
    }
}

/// The finalizer of `SplitMix64`: every bit of the input moves about half of the output's.
pub(super) const fn scrambled(word: u64) -> u64 {
    let word = word.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let word = (word ^ word >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let word = (word ^ word >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    word ^ word >> 31
}
