//! A range reading that says why it is what it is.

use crate::units::Millimeters;
use core::fmt;

/// What one measurement of a range sensor says.
///
/// The four cases never share a number: *nothing there* is no large distance, *too near* no small
/// one, and a sensor that did not answer says nothing about the world.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Reading {
    /// The nearest object in the beam is this far away.
    Echo(Millimeters),
    /// No object within the sensor's range.
    NoObject,
    /// An object, but nearer than the sensor can tell how near.
    TooNear,
    /// No measurement.
    Missing(Missing),
}

/// Why a measurement is missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Missing {
    /// The sensor did not answer in time.
    Timeout,
    /// The line to the sensor failed.
    Bus,
    /// The sensor answered with something that cannot be.
    Implausible,
    /// The sensor was not asked: its turn came too late.
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
