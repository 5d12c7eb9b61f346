//! What goes wrong with a motor or its wheel.

use super::line_fault::scrambled;
use crate::fault::{SensorName, SpecError};
use crate::quantity::{self, Excerpt, Percentage};
use certainty_control::Side;
use core::fmt;

/// A fault between a motor's channel and the ground under its wheel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MotorFault {
    /// It does not turn.
    Dead,
    /// It turns at this part of the speed that it is told.
    Weak(Percentage),
    /// Its wheel loses up to this part of its way, another in each frame of 20 ms.
    Slip(Percentage),
    /// Its pulses cannot be set: it goes on by the last.
    Off,
}

/// A motor as it is written.
pub(super) const fn name(side: Side) -> &'static str {
    match side {
        Side::Right => "right",
        Side::Left => "left",
    }
}

/// The motor that is meant.
pub(super) fn motor(written: &SensorName) -> Result<Side, SpecError> {
    let written = written.to_string();
    let mut sides = [Side::Right, Side::Left].into_iter();
    sides
        .find(|&side| name(side) == written)
        .ok_or_else(|| SpecError::NoSuchMotor {
            motor: Excerpt::new(&written),
        })
}

impl MotorFault {
    /// Reads a kind and its value; `None` for a kind that motors do not have.
    pub(super) fn parse(kind: &str, value: Option<&str>) -> Option<Result<Self, SpecError>> {
        let valueless = |kind, fault| match value {
            Some(value) => Err(SpecError::no_value_of(kind, "left", value)),
            None => Ok(fault),
        };
        let part = |kind, default: f64, example| match value {
            None => Ok(Percentage::try_new(default).unwrap_or_default()),
            Some(value) => quantity::percentage(value).map_err(|source| SpecError::Quantity {
                kind,
                source,
                example,
            }),
        };
        Some(match kind {
            "motor-dead" => valueless("motor-dead", Self::Dead),
            "motor-off" => valueless("motor-off", Self::Off),
            "motor-weak" => part("motor-weak", 95.0, "motor-weak:left=95%").map(Self::Weak),
            "slip" => part("slip", 20.0, "slip:right=20%").map(Self::Slip),
            _ => return None,
        })
    }

    /// Writes the fault of `side` as it is read.
    pub(super) fn write(self, f: &mut fmt::Formatter<'_>, side: Side) -> fmt::Result {
        let side = name(side);
        match self {
            Self::Dead => write!(f, "motor-dead:{side}"),
            Self::Weak(part) => write!(f, "motor-weak:{side}={part}"),
            Self::Slip(part) => write!(f, "slip:{side}={part}"),
            Self::Off => write!(f, "motor-off:{side}"),
        }
    }

    /// What part of the way that it was told the wheel of `side` goes in a frame.
    ///
    /// By the frame's number, not by how often it is asked: so all backends see the same slip.
    pub(super) fn part(self, seed: u64, frame: u64, side: Side) -> f64 {
        match self {
            Self::Dead => 0.0,
            Self::Weak(part) => part.fraction(),
            Self::Slip(most) => {
                let named = scrambled(seed ^ scrambled(frame << 1 | u64::from(side == Side::Left)));
                let lost = (named >> 11) as f64 / (1_u64 << 53) as f64;
                1.0 - most.fraction() * lost
            }
            Self::Off => 1.0,
        }
    }
}
