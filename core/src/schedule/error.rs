//! Why a schedule is refused.

use super::round::Activity;
use crate::sensor::SensorId;
use core::fmt;

/// Most rounds after which the sweeps of two sensors that measure at the same time may repeat.
pub const MAX_STEPS: u32 = u16::MAX as u32;

/// The first rule that a schedule breaks; slots are counted from 0, times are in ms after the round's
/// start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ScheduleError {
    /// There is no slot, or there are more than 255 stations.
    Size {
        /// The number of slots.
        slots: usize,
        /// The number of stations.
        stations: usize,
    },
    /// The round is longer than a sensor may be without a reading.
    RoundTooLong {
        /// The round's length.
        period: u16,
        /// The longest time without a reading.
        stale_after: u32,
    },
    /// A slot lasts less than 1 ms, or less than its measurement may take.
    TooShort {
        /// The slot.
        slot: usize,
        /// How long it must last.
        needed: u16,
    },
    /// A slot ends after the next begins, or after the round; also if the slots are not sorted by
    /// their begin.
    Overrun {
        /// The slot.
        slot: usize,
        /// When it ends.
        end: u32,
        /// When it must have ended.
        limit: u16,
    },
    /// A slot asks for an activity of a sensor that has no station, or whose station cannot do it: only
    /// a sweeping sensor moves, and a sensor is either started and read or measures in one slot.
    Impossible {
        /// The slot.
        slot: usize,
        /// What it asks for.
        activity: Activity,
    },
    /// A sensor has no slot for an activity that it needs, or the round has only one of
    /// [`Activity::Steer`] and [`Activity::Drive`].
    NoSlot {
        /// The missing activity.
        activity: Activity,
    },
    /// Two slots have the same activity; only [`Activity::Report`] may repeat.
    Twice {
        /// The activity.
        activity: Activity,
        /// The first slot.
        first: usize,
        /// The second slot.
        again: usize,
    },
    /// A slot comes before one that it must follow: a sensor moves, then it is started and read or
    /// measures, then it is fused; once all are fused the round steers, then it drives.
    WrongOrder {
        /// The slot that is too early.
        slot: usize,
        /// The slot that it must follow.
        after: usize,
    },
    /// A sensor is started or measures before its head has settled, or is read before its conversion
    /// has ended.
    TooEarly {
        /// The slot.
        slot: usize,
        /// What it asks for.
        activity: Activity,
        /// When it may begin.
        ready: u32,
    },
    /// Two sensors of one signal measure in nearly the same direction at the same time, or a sensor
    /// measures again before its own signal has faded.
    Interference {
        /// The sensor with the lower number.
        first: SensorId,
        /// The other; the same if it disturbs itself.
        second: SensorId,
        /// The first round in which it happens, counted from 0.
        step: u32,
    },
    /// Two sensors measure at the same time, and their sweeps repeat after more than [`MAX_STEPS`]
    /// rounds, which are too many to check.
    TooManySteps {
        /// The sensor with the lower number.
        first: SensorId,
        /// The other.
        second: SensorId,
        /// After how many rounds their sweeps repeat.
        steps: u32,
    },
}

impl ScheduleError {
    /// Returns the broken rule, as a constant can panic with it.
    pub(super) const fn rule(&self) -> &'static str {
        match self {
            Self::Size { slots: 0, .. } => "a round needs at least one slot",
            Self::Size { .. } => "a round has at most 255 stations",
            Self::RoundTooLong { .. } => "the round is longer than a sensor may be without reading",
            Self::TooShort { .. } => "a slot is too short",
            Self::Overrun { .. } => "a slot ends after the next begins or after the round",
            Self::Impossible { .. } => "a sensor has no station that does what a slot asks for",
            Self::NoSlot { .. } => "an activity has no slot",
            Self::Twice { .. } => "an activity has two slots",
            Self::WrongOrder { .. } => "activities are in the wrong order",
            Self::TooEarly {
                activity: Activity::Read(_),
                ..
            } => "a sensor is read before its conversion has ended",
            Self::TooEarly { .. } => "a sensor measures before its head has settled",
            Self::Interference { first, second, .. } if first.number() == second.number() => {
                "a sensor measures again before its signal has faded"
            }
            Self::Interference { .. } => "two sensors measure in one direction at the same time",
            Self::TooManySteps { .. } => "two sweeps repeat after too many rounds to check",
        }
    }
}

impl fmt::Display for ScheduleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.rule())?;
        match *self {
            Self::Size { slots, stations } => write!(f, ": {slots} slots, {stations} stations"),
            Self::RoundTooLong {
                period,
                stale_after,
            } => write!(f, ": {period} ms, expected at most {stale_after} ms"),
            Self::TooShort { slot, needed } => {
                write!(f, ": slot {slot}, expected {needed} ms or more")
            }
            Self::Overrun { slot, end, limit } => write!(
                f,
                ": slot {slot} ends at {end} ms, expected at most {limit} ms"
            ),
            Self::Impossible { slot, activity } => write!(f, ": slot {slot}, {activity}"),
            Self::NoSlot { activity } => write!(f, ": {activity}"),
            Self::Twice {
                activity,
                first,
                again,
            } => write!(f, ": {activity} in slots {first} and {again}"),
            Self::WrongOrder { slot, after } => {
                write!(f, ": slot {slot}, expected after slot {after}")
            }
            Self::TooEarly {
                slot,
                activity,
                ready,
            } => write!(
                f,
                ": slot {slot}, {activity}, expected at {ready} ms or later"
            ),
            Self::Interference { first, second, .. } if first == second => {
                write!(f, ": sensor {first}; lengthen the round")
            }
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
                ": sensors {first} and {second} after {steps}, expected at most {MAX_STEPS}; give \
                 both the same number of directions"
            ),
        }
    }
}

impl core::error::Error for ScheduleError {}
