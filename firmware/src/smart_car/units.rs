//! The car's three infrared sensors: units with names, each with its own calibration.

use super::{FARTHEST, HEADS, NEAREST};
use certainty_core::transducer::Calibration;
use certainty_core::units::Millimeters;
use fixed::types::{U0F16, U8F8};

/// One GP2D02 as it is known before it is mounted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Unit {
    /// How its bytes become millimetres.
    pub calibration: Calibration,
    /// The standard deviation of its distances, as a fraction of them (\[001\] Table 1).
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub accuracy: U0F16,
}

const fn unit(slope: u32, offset_mm: u32, floor: U8F8, accuracy: U0F16) -> Unit {
    let offset = Millimeters::new(offset_mm);
    Unit {
        calibration: Calibration::new(slope, offset, floor, NEAREST, FARTHEST),
        accuracy,
    }
}

/// The sensors from right to left: units `A0_0` to `A0_2` of the simulator's table with the accuracies
/// of A, B and C of \[001\] Table 1.
///
/// Replace them by what `certainty calibrate` finds for yours.
pub static UNITS: [Unit; HEADS as usize] = [
    unit(16_866, 14, U8F8::from_bits(17_422), U0F16::lit("0.06")),
    unit(16_572, 16, U8F8::from_bits(18_456), U0F16::lit("0.10")),
    unit(16_573, 12, U8F8::from_bits(19_161), U0F16::lit("0.07")),
];
