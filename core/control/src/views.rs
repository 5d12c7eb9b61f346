//! Where the sensors sit, where they look and how far.

use super::PerRangefinder;
use certainty_core::units::{Millimeters, Pose};

/// What each sensor looks at, in the robot's frame: x ahead, y to the left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Views {
    /// Where the rangefinders sit and look.
    pub rangefinders: PerRangefinder<Pose>,
    /// Where the scanner does.
    pub scanner: Pose,
    /// How far the rangefinders see.
    pub rangefinders_see: Millimeters,
    /// How far the scanner sees.
    pub scanner_sees: Millimeters,
}
