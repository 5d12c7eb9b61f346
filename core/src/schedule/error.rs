//! Why a schedule was refused.

use super::round::Activity;
use crate::sensor::SensorId;
use core::fmt;

/// Most rounds after which two sweeps may begin anew, if their sensors measure at the same time.
pub const MAX_STEPS: u32 = u16::MAX as u32;

/// Why a schedule was refused; slots are counted from 0, times are in ms after the round's start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ScheduleError {
    /// There is no slot.
    NoSlots,
    /// There are more stations than sensors have numbers.
    TooManyStations,
    /// A sensor would have its turn less often than its health expects.
    RoundTooLong {
        /// The round's length.
        period: u16,
        /// For how long a sensor may be silent.
        stale_after: u32,
    },
    /// A slot has no time.
    EmptySlot {
        /// Which.
        slot: usize,
    },
    /// A slot does not begin after the one before it.
    OutOfOrder {
        /// The later in the list.
        slot: usize,
    },
    /// A slot ends after the next has begun.
    Overrun {
        /// The earlier of the two.
        slot: usize,
        /// When it ends.
        end: u32,
        /// When the next begins.
        next: u16,
    },
    /// The last slot ends after the round.
    RoundOverrun {
        /// The last slot.
        slot: usize,
        /// When it ends.
        end: u32,
        /// The round's length.
        period: u16,
    },
    /// A slot is for a sensor that has no station.
    UnknownSensor {
        /// Which slot.
        slot: usize,
        /// Its sensor.
        sensor: SensorId,
    },
    /// A sensor is told to do what it cannot: a fixed one to move, one that is started and read to
    /// measure in one slot, or the other way round.
    NotItsKind {
        /// Which slot.
        slot: usize,
        /// What it asks for.
        activity: Activity,
    },
    /// A sensor has no slot for something that its turn needs, or the round steers without driving or drives
    /// without steering.
    NoTurn {
        /// What is missing.
        activity: Activity,
    },
    /// Something is done twice in a round that is done once; only reports may be more.
    Twice {
        /// What.
        activity: Activity,
        /// The first slot of it.
        first: usize,
        /// The second.
        again: usize,
    },
    /// Something is done before what must come first: a sensor moves, then it is started and read or
    /// measures, then it is fused; once all are fused the round steers, then it drives.
    WrongOrder {
        /// The slot that is too early.
        slot: usize,
        /// The slot that it must follow.
        after: usize,
    },
    /// A sensor measures before its head has come to rest.
    Unsettled {
        /// The slot that starts the measurement.
        slot: usize,
        /// Whose.
        sensor: SensorId,
        /// When it may begin.
        ready: u32,
    },
    /// A sensor is read before its conversion is over.
    Unconverted {
        /// The slot that reads.
        slot: usize,
        /// Whose.
        sensor: SensorId,
        /// When it may begin.
        ready: u32,
    },
    /// A measurement may take longer than its slot.
    TooShort {
        /// Which slot.
        slot: usize,
        /// Whose.
        sensor: SensorId,
        /// How long it must last, in ms.
        longest: u16,
    },
    /// A sensor's turn comes again before its own signal has faded.
    StillFading {
        /// Which.
        sensor: SensorId,
    },
    /// Two sensors of like signals look too nearly the same way at the same time.
    Interference {
        /// The one.
        first: SensorId,
        /// The other.
        second: SensorId,
        /// The first round in which they do, counted from 0.
        step: u32,
    },
    /// Two sensors measure at the same time, and their sweeps meet in more ways than are checked.
    TooManySteps {
        /// The one.
        first: SensorId,
        /// The other.
        second: SensorId,
        /// After how many rounds both sweeps begin anew.
        steps: u32,
    },
}

impl ScheduleError {
    /// Returns what is wrong, in words that a constant can panic with.
    #[must_use]
    pub const fn reason(&self) -> &'static str {
        match self {
            Self::NoSlots => "a round needs at least one slot",
            Self::TooManyStations => "there can be at most 255 stations",
            Self::RoundTooLong { .. } => "the round is longer than a sensor may be silent",
            Self::EmptySlot { .. } => "a slot has no time",
            Self::OutOfOrder { .. } => "a slot does not begin after the one before it",
            Self::Overrun { .. } => "a slot overruns the next",
            Self::RoundOverrun { .. } => "the last slot overruns the round",
            Self::UnknownSensor { .. } => "a slot is for a sensor without a station",
            Self::NotItsKind { .. } => "a sensor cannot do what a slot asks for",
            Self::NoTurn { .. } => "an activity is without its slot",
            Self::Twice { .. } => "the same is done twice in a round",
            Self::WrongOrder { .. } => "activities are in the wrong order",
            Self::Unsettled { .. } => "a sensor measures before its head has settled",
            Self::Unconverted { .. } => "a sensor is read before its conversion is over",
            Self::TooShort { .. } => "a measurement may overrun its slot",
            Self::StillFading { .. } => "a sensor's own signal fades into its next turn",
            Self::Interference { .. } => "two sensors look the same way at the same time",
            Self::TooManySteps { .. } => "two sweeps meet in more ways than can be checked",
        }
    }
}

impl fmt::Display for ScheduleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.reason())?;
        match *self {
            Self::NoSlots | Self::TooManyStations => Ok(()),
            Self::RoundTooLong {
                period,
                stale_after,
            } => write!(f, ": {period} ms; shorten it to {stale_after} ms"),
            Self::EmptySlot { slot } => write!(f, ": slot {slot}; give it 1 ms or more"),
            Self::OutOfOrder { slot } => write!(f, ": slot {slot}; sort the slots by their begin"),
            Self::Overrun { slot, end, next } => write!(
                f,
                ": slot {slot} ends at {end} ms; begin the next then, not at {next} ms"
            ),
            Self::RoundOverrun { slot, end, period } => write!(
                f,
                ": slot {slot} ends at {end} ms; lengthen the round from {period} ms"
            ),
            Self::UnknownSensor { slot, sensor } => {
                write!(f, ": slot {slot}, sensor {sensor}; add its station")
            }
            Self::NotItsKind { slot, activity } => write!(
                f,
                ": slot {slot}, {activity}; drop it or change the sensor's station"
            ),
            Self::NoTurn { activity } => write!(f, ": add a slot to {activity}"),
            Self::Twice {
                activity,
                first,
                again,
            } => write!(f, ": {activity} in slots {first} and {again}; drop one"),
            Self::WrongOrder { slot, after } => write!(f, ": put slot {slot} after slot {after}"),
            Self::Unsettled {
                slot,
                sensor,
                ready,
            }
            | Self::Unconverted {
                slot,
                sensor,
                ready,
            } => write!(
                f,
                ": slot {slot}, sensor {sensor}; begin it at {ready} ms or later"
            ),
            Self::TooShort {
                slot,
                sensor,
                longest,
            } => write!(f, ": slot {slot}, sensor {sensor}; give it {longest} ms"),
            Self::StillFading { sensor } => write!(f, ": sensor {sensor}; lengthen the round"),
            Self::Interference {
                first,
                second,
                step,
            } => write!(
                f,
                ": sensors {first} and {second} in round {step}; measure one after the other or \
                 shift a sweep"
            ),
            Self::TooManySteps {
                first,
                second,
                steps,
            } => write!(
                f,
                ": sensors {first} and {second} in {steps}, of at most {MAX_STEPS}; give both \
                 sweeps the same number of directions"
            ),
        }
    }
}

impl core::error::Error for ScheduleError {}
