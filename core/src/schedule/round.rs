//! The parts of a round: its slots, and the stations of its sensors.

use crate::sensor::SensorId;
use crate::transducer::Sweep;
use crate::units::BinaryAngle;
use core::fmt;

/// A round; [`Schedule`](super::Schedule) checks it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ScheduleConfig<const SLOTS: usize, const STATIONS: usize> {
    /// The time from the start of one round to the start of the next, in ms.
    pub period: u16,
    /// The longest time without a reading of a sensor, in ms:
    /// [`HealthRules::stale_after`](crate::health::HealthRules::stale_after).
    pub stale_after: u32,
    /// The smallest angle between two sensors of one signal that measure at the same time; above half
    /// a turn they may not.
    pub apart: BinaryAngle,
    /// The slots, sorted by their begin.
    pub slots: [Slot; SLOTS],
    /// The sensors, in the order of their numbers from 1.
    pub stations: [Station; STATIONS],
}

/// What is done in a slot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Activity {
    /// Turn a pivoted sensor to its direction in this round.
    Move(SensorId),
    /// Start a conversion, which goes on by itself.
    Start(SensorId),
    /// Read the result of a conversion.
    Read(SensorId),
    /// Make a whole measurement.
    Measure(SensorId),
    /// Fuse the reading into the map.
    Fuse(SensorId),
    /// Compute the speeds of the wheels from the map and the readings.
    Steer,
    /// Set the motors to these speeds, at a time that does not depend on how long computing took.
    Drive,
    /// Send a report to the host.
    Report,
}

impl Activity {
    /// Returns the sensor of this activity; `None` for [`Activity::Steer`], [`Activity::Drive`] and
    /// [`Activity::Report`].
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

/// An activity, when it begins and how long it may take.
///
/// Units: milliseconds, which are the ticks of the round's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Slot {
    /// The begin, in ms after the round's start.
    pub at: u16,
    /// The longest duration, in ms; at least 1.
    pub lasts: u16,
    /// The activity.
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

    /// Returns the end, in ms after the round's start.
    #[must_use]
    pub const fn end(&self) -> u32 {
        (self.at as u32).wrapping_add(self.lasts as u32) // two 16-bit numbers: no wrap
    }
}

/// A sensor for the schedule: its times and its direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Station {
    /// What it sends out; only sensors of one signal disturb each other.
    pub signal: Signal,
    /// Its direction in the robot's frame.
    pub aim: Aim,
    /// How it measures.
    pub measuring: Measuring,
    /// How long other sensors may receive its signal after it has measured, in ms: the late echoes of
    /// sound. 0 for light.
    pub fades: u16,
}

/// What a sensor sends out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Signal {
    /// An infrared sensor's.
    Light,
    /// An ultrasonic ranger's.
    Sound,
}

impl Signal {
    /// `==`, for constants.
    pub(super) const fn is(self, other: Self) -> bool {
        matches!(
            (self, other),
            (Self::Light, Self::Light) | (Self::Sound, Self::Sound)
        )
    }
}

/// The direction of a sensor, in a frame that all stations of a schedule share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Aim {
    /// On a pivoted head, which moves once a round: in round n to step n of its sweep.
    Sweeping {
        /// The directions of the head.
        sweep: Sweep,
        /// The index of the head, from 0.
        slot: u16,
        /// The number of equally phased heads that share the sweep.
        heads: u16,
        /// How long the head takes to settle, in ms after the end of the slot that moves it: the worst
        /// case, which is the move from the sweep's end back to its start.
        settle: u16,
    },
    /// Fixed.
    Fixed(BinaryAngle),
}

impl Aim {
    /// Returns the direction in round `step`.
    #[must_use]
    pub const fn direction(&self, step: u32) -> BinaryAngle {
        match self {
            Self::Sweeping {
                sweep, slot, heads, ..
            } => sweep.direction(step, *slot, *heads),
            Self::Fixed(direction) => *direction,
        }
    }

    /// Returns the number of rounds after which the directions repeat.
    pub(super) const fn repeats_after(&self) -> u32 {
        match self {
            Self::Sweeping { sweep, .. } => sweep.directions() as u32,
            Self::Fixed(_) => 1,
        }
    }
}

/// How a sensor measures, and how long that takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Measuring {
    /// It is started in one slot and read in a later one.
    Apart {
        /// The time from the end of the first to the begin of the second, in ms: 70 for a GP2D02.
        conversion: u16,
    },
    /// The whole measurement is made in one slot.
    Whole {
        /// The longest measurement, in ms, which the slot must last: sound takes it to the end of the
        /// range and back.
        longest: u16,
    },
}
