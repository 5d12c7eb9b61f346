//! What a round is made of: slots in time, and the stations of its sensors.

use crate::sensor::SensorId;
use crate::transducer::Sweep;
use crate::units::BinaryAngle;
use core::fmt;

/// A round before it is checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ScheduleConfig<const SLOTS: usize, const STATIONS: usize> {
    /// From the start of one round to the start of the next, in ms.
    pub period: u16,
    /// For how long a sensor may be silent before its health calls it stale, in ms:
    /// [`HealthConfig::stale_after`](crate::health::HealthConfig::stale_after).
    pub stale_after: u32,
    /// How far apart two sensors of like signals must look at least if they measure at the same
    /// time; above half a turn they may never.
    pub apart: BinaryAngle,
    /// What is done, in the order of time.
    pub slots: [Slot; SLOTS],
    /// The sensors, in the order of their numbers from 1.
    pub stations: [Station; STATIONS],
}

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

/// A sensor as the schedule sees it: what time it needs, and where it looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Station {
    /// What it sends out; only like signals disturb each other.
    pub signal: Signal,
    /// Where it looks, as seen from the robot.
    pub aim: Aim,
    /// How it measures.
    pub measuring: Measuring,
    /// How long its signal may still be heard by others after it has measured, in ms: the late
    /// echoes of a sound. Light has none.
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

/// Where a sensor looks, in a frame that all stations of a schedule share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Aim {
    /// It sits on a pivoted head, which is moved once a round: in round n to step n of its sweep.
    Sweeping {
        /// Where the head goes.
        sweep: Sweep,
        /// Which of the sweep's heads it is, from 0.
        slot: u16,
        /// How many equally phased heads share the sweep.
        heads: u16,
        /// How long the head needs to come to rest, in ms after the end of the slot that moves it:
        /// the worst case, which is the flight back from the sweep's end to its start.
        settle: u16,
    },
    /// It cannot be moved.
    Fixed(BinaryAngle),
}

impl Aim {
    /// Returns where it looks in round `step`.
    #[must_use]
    pub const fn direction(&self, step: u32) -> BinaryAngle {
        match self {
            Self::Sweeping {
                sweep, slot, heads, ..
            } => sweep.direction(step, *slot, *heads),
            Self::Fixed(direction) => *direction,
        }
    }

    /// After how many rounds it looks the same ways again.
    pub(super) const fn repeats_after(&self) -> u32 {
        match self {
            Self::Sweeping { sweep, .. } => sweep.directions() as u32,
            Self::Fixed(_) => 1,
        }
    }
}

/// How a sensor measures, and what time that takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Measuring {
    /// It is started in one slot and read in a later one.
    Apart {
        /// Ms from the end of the first to the begin of the second: 70 for a GP2D02.
        conversion: u16,
    },
    /// The whole measurement is made in one slot.
    Whole {
        /// Ms that the slot must last at least, so that also the longest measurement fits: the way
        /// of the sound to the end of its range and back.
        longest: u16,
    },
}
