//! The result of one range measurement.

use crate::units::Millimeters;
use core::fmt;

/// The result of one measurement of a range sensor.
///
/// No case is encoded as a special distance: *no object* is not a large distance, *too near* not a
/// small one, and a missing reading says nothing about the surroundings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Reading {
    /// The nearest object in the beam is this far away.
    Echo(Millimeters),
    /// There is no object within the sensor's range.
    NoObject,
    /// There is an object nearer than the shortest distance that the sensor can measure.
    TooNear,
    /// There is no measurement.
    Missing(Missing),
}

/// Why a measurement is missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Missing {
    /// The sensor did not answer in time.
    Timeout,
    /// The connection to the sensor failed.
    Bus,
    /// The sensor gave a value that validation rejects.
    Implausible,
    /// The sensor was not triggered: its slot in the round came too late.
    Late,
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Timeout => "no answer in time",
            Self::Bus => "line failed",
            Self::Implausible => "implausible answer",
            Self::Late => "not asked in time",
        })
    }
}
