//! The time-triggered round: what is done when, as checked constant data.
//!
//! A round is a list of slots that is worked off again and again. Everything that a wrong list
//! could do to the readings is refused when the [`Schedule`] is built, which is before the program
//! is if the schedule is a constant: a head still swings when its sensor looks, a conversion is
//! read too early, two sensors see each other's light (\[000\] §3), a sensor never has its turn.
//!
//! A round is complete in itself: a sensor moves, measures and is fused in the same one, in this
//! order. The order of the `Fuse` slots is the order of updates, on which the robust grid's values
//! depend (\[001\] §7). Where the robot moves, the round steers after them, and gives the motors what was
//! decided in a slot of its own: when wheels change their speed must not depend on how long a decision took.
//!
//! Memory: 6 bytes a slot, 22 a sensor; of a constant they are in flash.

mod check;
mod error;
mod slot;
mod station;

pub use error::ScheduleError;
pub use slot::{Activity, Slot};
pub use station::{Aim, Measuring, Signal, Station};

use crate::sensor::SensorId;
use crate::units::BinaryAngle;

/// Most rounds after which two sweeps may begin anew, if their sensors measure at the same time.
pub const MAX_STEPS: u32 = u16::MAX as u32;

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

/// A round that keeps all rules; the checked [`ScheduleConfig`].
///
/// Possession proves, of every round:
/// - the slots follow one another, none overlaps the next, all end within the round, and the round
///   is no longer than a sensor may be silent;
/// - every sensor has its turn once: it is moved if it can be, started and read or measured, and
///   fused, in this order, and gets the time to settle and to convert;
/// - a round that steers, or that drives, does both and each once: it steers when all is fused, so that
///   control sees all that the round learned, and then drives;
/// - no two sensors of like signals ever look within [`ScheduleConfig::apart`] of each other while
///   one measures what the other sends, in any step of their sweeps; late echoes and those from the
///   round before included.
///
/// # Examples
///
/// Two infrared heads that measure at once, and a ranger. A schedule that breaks a rule is refused
/// with its reason:
///
/// ```
/// use certainty_core::schedule::{
///     Activity::{Fuse, Measure, Move, Read, Report, Start},
///     Aim, Measuring, Schedule, ScheduleConfig, ScheduleError, Signal, Slot, Station,
/// };
/// use certainty_core::sensor::SensorId;
/// use certainty_core::transducer::Sweep;
/// use certainty_core::units::BinaryAngle;
///
/// let id = |number| SensorId::new(number).ok_or("zero");
/// let (right, left, ranger) = (id(1)?, id(2)?, id(3)?);
/// let degrees = |d: i32| BinaryAngle::from_millidegrees(d * 1000);
/// let sweep = Sweep::try_new(degrees(-90), degrees(90), 37)?;
/// let head = |slot| Station {
///     signal: Signal::Light,
///     aim: Aim::Sweeping { sweep, slot, heads: 2, settle: 100 },
///     measuring: Measuring::Apart { conversion: 70 },
///     fades: 0,
/// };
/// let good = ScheduleConfig {
///     period: 250,
///     stale_after: 2000,
///     apart: degrees(20),
///     slots: [
///         Slot::new(0, 1, Move(right)),
///         Slot::new(1, 1, Move(left)),
///         Slot::new(10, 30, Measure(ranger)), // while the heads settle
///         Slot::new(40, 5, Fuse(ranger)),
///         Slot::new(102, 1, Start(right)),
///         Slot::new(103, 1, Start(left)),
///         Slot::new(175, 4, Read(right)),
///         Slot::new(179, 4, Read(left)),
///         Slot::new(183, 5, Fuse(right)),
///         Slot::new(188, 5, Fuse(left)),
///         Slot::new(193, 40, Report),
///     ],
///     stations: [
///         head(0),
///         head(1),
///         Station {
///             signal: Signal::Sound,
///             aim: Aim::Fixed(BinaryAngle::ZERO),
///             measuring: Measuring::Whole { longest: 30 },
///             fades: 40,
///         },
///     ],
/// };
/// let schedule = Schedule::try_new(good)?;
/// assert_eq!(schedule.due(175), Some(6));
/// assert!(schedule.fusion_order().eq([ranger, right, left]));
///
/// let mut hasty = good;
/// hasty.slots[4].at = 100;
/// let refused = Schedule::try_new(hasty);
/// assert_eq!(refused, Err(ScheduleError::Unsettled { slot: 4, sensor: right, ready: 101 }));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
///
/// As a constant it does not build:
///
/// ```compile_fail
/// use certainty_core::schedule::{Activity::Report, Schedule, ScheduleConfig, Slot};
/// use certainty_core::units::BinaryAngle;
///
/// const ROUND: Schedule<1, 0> = match Schedule::try_new(ScheduleConfig {
///     period: 10,
///     stale_after: 2000,
///     apart: BinaryAngle::ZERO,
///     slots: [Slot::new(0, 11, Report)], // 11 ms in a round of 10 ms
///     stations: [],
/// }) {
///     Ok(schedule) => schedule,
///     Err(error) => panic!("{}", error.reason()),
/// };
/// assert_eq!(ROUND.period(), 10);
/// ```
///
/// and with one millisecond less it does:
///
/// ```
/// # use certainty_core::schedule::{Activity::Report, Schedule, ScheduleConfig, Slot};
/// # use certainty_core::units::BinaryAngle;
/// #
/// # const ROUND: Schedule<1, 0> = match Schedule::try_new(ScheduleConfig {
/// #     period: 10,
/// #     stale_after: 2000,
/// #     apart: BinaryAngle::ZERO,
/// slots: [Slot::new(0, 10, Report)],
/// #     stations: [],
/// # }) {
/// #     Ok(schedule) => schedule,
/// #     Err(error) => panic!("{}", error.reason()),
/// # };
/// # assert_eq!(ROUND.period(), 10);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Schedule<const SLOTS: usize, const STATIONS: usize>(ScheduleConfig<SLOTS, STATIONS>);

impl<const SLOTS: usize, const STATIONS: usize> Schedule<SLOTS, STATIONS> {
    /// Checks a round.
    ///
    /// Cost: slots times stations, and for two sensors that measure at the same time the rounds
    /// after which their sweeps begin anew, at most [`MAX_STEPS`].
    ///
    /// # Errors
    ///
    /// [`ScheduleError`] names the first rule that is broken and by what: first the times of the
    /// slots, then what they are for, then each sensor's turn, then steering and driving, then what disturbs
    /// what.
    pub const fn try_new(config: ScheduleConfig<SLOTS, STATIONS>) -> Result<Self, ScheduleError> {
        match check::check(
            config.period,
            config.stale_after,
            config.apart,
            &config.slots,
            &config.stations,
        ) {
            Ok(()) => Ok(Self(config)),
            Err(error) => Err(error),
        }
    }

    /// Returns the milliseconds from the start of one round to the start of the next.
    #[must_use]
    pub const fn period(&self) -> u16 {
        self.0.period
    }

    /// Returns what is done, in the order of time.
    #[must_use]
    pub const fn slots(&self) -> &[Slot; SLOTS] {
        &self.0.slots
    }

    /// Returns the sensors, in the order of their numbers.
    #[must_use]
    pub const fn stations(&self) -> &[Station; STATIONS] {
        &self.0.stations
    }

    /// Returns what the schedule knows about `sensor`; `None` if it is not in it.
    #[must_use]
    pub fn station(&self, sensor: SensorId) -> Option<&Station> {
        self.0.stations.get(sensor.slot())
    }

    /// Returns the slot that begins at `tick_in_round`, in ms after the round's start, counted
    /// from 0; `None` if none does.
    ///
    /// Cost: a binary search, which an interrupt can afford every tick.
    #[must_use]
    pub fn due(&self, tick_in_round: u16) -> Option<usize> {
        self.0
            .slots
            .binary_search_by_key(&tick_in_round, |slot| slot.at)
            .ok()
    }

    /// Returns the sensors in the order in which their readings are fused in every round.
    pub fn fusion_order(&self) -> impl Iterator<Item = SensorId> + '_ {
        self.0.slots.iter().filter_map(|slot| match slot.activity {
            Activity::Fuse(sensor) => Some(sensor),
            _ => None,
        })
    }
}

#[cfg(test)]
mod tests;
