//! What is done in a round, and when.

use crate::sensor::SensorId;
use core::fmt;

/// One thing that is done in a round.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Activity {
    /// Turn a pivoted sensor to where it looks in this round.
    Move(SensorId),
    /// Start a conversion that goes on by itself.
    Start(SensorId),
    /// Fetch what was converted.
    Read(SensorId),
    /// Make a whole measurement.
    Measure(SensorId),
    /// Take what was read or measured into the map.
    Fuse(SensorId),
    /// Decide, from what was fused, how the wheels shall turn.
    Steer,
    /// Give the motors what was decided, at an instant that does not depend on how long deciding took.
    Drive,
    /// Tell the host how things are.
    Report,
}

impl Activity {
    /// Returns whose activity this is; `None` for what is no sensor's: [`Activity::Steer`],
    /// [`Activity::Drive`] and [`Activity::Report`].
    #[must_use]
    pub const fn sensor(self) -> Option<SensorId> {
        match self {
            Self::Move(sensor)
            | Self::Start(sensor)
            | Self::Read(sensor)
            | Self::Measure(sensor)
            | Self::Fuse(sensor) => Some(sensor),
            Self::Steer | Self::Drive | Self::Report => None,
        }
    }

    /// `==`, for constants.
    pub(super) const fn is(self, other: Self) -> bool {
        match (self, other) {
            (Self::Move(a), Self::Move(b))
            | (Self::Start(a), Self::Start(b))
            | (Self::Read(a), Self::Read(b))
            | (Self::Measure(a), Self::Measure(b))
            | (Self::Fuse(a), Self::Fuse(b)) => a.number() == b.number(),
            (Self::Steer, Self::Steer)
            | (Self::Drive, Self::Drive)
            | (Self::Report, Self::Report) => true,
            _ => false,
        }
    }
}

impl fmt::Display for Activity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Move(sensor) => write!(f, "move sensor {sensor}"),
            Self::Start(sensor) => write!(f, "start sensor {sensor}"),
            Self::Read(sensor) => write!(f, "read sensor {sensor}"),
            Self::Measure(sensor) => write!(f, "measure with sensor {sensor}"),
            Self::Fuse(sensor) => write!(f, "fuse sensor {sensor}"),
            Self::Steer => f.write_str("steer"),
            Self::Drive => f.write_str("drive"),
            Self::Report => f.write_str("report"),
        }
    }
}

/// When an activity begins, and how long it may take.
///
/// Units: milliseconds, which are the ticks of the round's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Slot {
    /// When it begins, in ms after the round's start.
    pub at: u16,
    /// How long it may take, in ms; at least one.
    pub lasts: u16,
    /// What is done.
    pub activity: Activity,
}

impl Slot {
    /// Creates the slot from `at` to `at + lasts`.
    #[must_use]
    pub const fn new(at: u16, lasts: u16, activity: Activity) -> Self {
        Self {
            at,
            lasts,
            activity,
        }
    }

    /// Returns when it has ended, in ms after the round's start.
    #[must_use]
    pub const fn end(&self) -> u32 {
        (self.at as u32).wrapping_add(self.lasts as u32) // two of 16 bits: no wrap
    }
}
