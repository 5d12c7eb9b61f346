//! The rules of a round, each a function; all of them work in constants.
//!
//! Times are sums of few numbers of 16 bits in 32 bits: nothing here can wrap.

use super::{Activity, Aim, MAX_STEPS, Measuring, ScheduleError, Slot, Station};
use crate::sensor::SensorId;
use crate::units::BinaryAngle;

/// `?`, for constants.
macro_rules! attempt {
    ($result:expr) => {
        match $result {
            Ok(value) => value,
            Err(error) => return Err(error),
        }
    };
}

/// `list.get(index)`, for constants.
const fn nth<T>(list: &[T], index: usize) -> Option<&T> {
    match list.split_at_checked(index) {
        Some((_, [item, ..])) => Some(item),
        _ => None,
    }
}

/// Whether every rule is kept.
pub(super) const fn check(
    period: u16,
    stale_after: u32,
    apart: BinaryAngle,
    slots: &[Slot],
    stations: &[Station],
) -> Result<(), ScheduleError> {
    if stations.len() > u8::MAX as usize {
        return Err(ScheduleError::TooManyStations);
    }
    if period as u32 > stale_after {
        return Err(ScheduleError::RoundTooLong {
            period,
            stale_after,
        });
    }
    attempt!(times(period, slots));
    attempt!(kinds(slots, stations));
    let mut second = 0;
    while let Some((sensor, station)) = numbered(stations, second) {
        let turn = attempt!(Turn::of(slots, sensor, station));
        if turn.end.wrapping_add(station.fades as u32) > turn.begin.wrapping_add(period as u32) {
            return Err(ScheduleError::StillFading { sensor });
        }
        second = second.wrapping_add(1);
    }
    attempt!(control(slots));
    let mut second = 0;
    while let Some(b) = numbered(stations, second) {
        let mut first = 0;
        while first < second
            && let Some(a) = numbered(stations, first)
        {
            attempt!(interference(period, apart, slots, a, b));
            first = first.wrapping_add(1);
        }
        second = second.wrapping_add(1);
    }
    Ok(())
}

/// The station at `index` with its sensor's number.
const fn numbered(stations: &[Station], index: usize) -> Option<(SensorId, &Station)> {
    match (SensorId::from_slot(index), nth(stations, index)) {
        (Some(sensor), Some(station)) => Some((sensor, station)),
        _ => None,
    }
}

/// The slots follow one another within the round.
const fn times(period: u16, slots: &[Slot]) -> Result<(), ScheduleError> {
    let [_, ..] = slots else {
        return Err(ScheduleError::NoSlots);
    };
    let mut slot = 0_usize;
    while let Some(this) = nth(slots, slot) {
        let end = this.end();
        let following = slot.wrapping_add(1);
        if this.lasts == 0 {
            return Err(ScheduleError::EmptySlot { slot });
        }
        match nth(slots, following) {
            Some(next) if next.at <= this.at => {
                return Err(ScheduleError::OutOfOrder { slot: following });
            }
            Some(next) if end > next.at as u32 => {
                let next = next.at;
                return Err(ScheduleError::Overrun { slot, end, next });
            }
            None if end > period as u32 => {
                return Err(ScheduleError::RoundOverrun { slot, end, period });
            }
            _ => {}
        }
        slot = following;
    }
    Ok(())
}

/// Every slot is for a sensor that there is and that can do it.
const fn kinds(slots: &[Slot], stations: &[Station]) -> Result<(), ScheduleError> {
    let mut slot = 0_usize;
    while let Some(&Slot { activity, .. }) = nth(slots, slot) {
        if let Some(sensor) = activity.sensor() {
            let Some(station) = nth(stations, sensor.slot()) else {
                return Err(ScheduleError::UnknownSensor { slot, sensor });
            };
            let possible = match activity {
                Activity::Move(_) => matches!(station.aim, Aim::Sweeping { .. }),
                Activity::Start(_) | Activity::Read(_) => {
                    matches!(station.measuring, Measuring::Apart { .. })
                }
                Activity::Measure(_) => matches!(station.measuring, Measuring::Whole { .. }),
                Activity::Fuse(_) | Activity::Steer | Activity::Drive | Activity::Report => true,
            };
            if !possible {
                return Err(ScheduleError::NotItsKind { slot, activity });
            }
        }
        slot = slot.wrapping_add(1);
    }
    Ok(())
}

/// A slot with its place in the list.
#[derive(Clone, Copy)]
struct Place<'a> {
    index: usize,
    slot: &'a Slot,
}

impl<'a> Place<'a> {
    /// The only slot of an activity that must have one.
    const fn of(slots: &'a [Slot], activity: Activity) -> Result<Self, ScheduleError> {
        match attempt!(Self::find(slots, activity)) {
            Some(place) => Ok(place),
            None => Err(ScheduleError::NoTurn { activity }),
        }
    }

    /// The only slot of an activity, if it has one.
    const fn find(slots: &'a [Slot], activity: Activity) -> Result<Option<Self>, ScheduleError> {
        let mut found: Option<Self> = None;
        let mut index = 0_usize;
        while let Some(slot) = nth(slots, index) {
            if slot.activity.is(activity) {
                if let Some(first) = found {
                    return Err(ScheduleError::Twice {
                        activity,
                        first: first.index,
                        again: index,
                    });
                }
                found = Some(Self { index, slot });
            }
            index = index.wrapping_add(1);
        }
        Ok(found)
    }

    /// Refuses this slot if it comes before `earlier`.
    const fn follows(&self, earlier: &Self) -> Result<(), ScheduleError> {
        if self.index < earlier.index {
            Err(ScheduleError::WrongOrder {
                slot: self.index,
                after: earlier.index,
            })
        } else {
            Ok(())
        }
    }
}

/// A round that steers does so once, with everything fused, and then drives.
const fn control(slots: &[Slot]) -> Result<(), ScheduleError> {
    let steers = attempt!(Place::find(slots, Activity::Steer));
    let drives = attempt!(Place::find(slots, Activity::Drive));
    let (steers, drives) = match (steers, drives) {
        (None, None) => return Ok(()),
        (Some(steers), Some(drives)) => (steers, drives),
        (Some(_), None) => {
            let activity = Activity::Drive;
            return Err(ScheduleError::NoTurn { activity });
        }
        (None, Some(_)) => {
            let activity = Activity::Steer;
            return Err(ScheduleError::NoTurn { activity });
        }
    };
    let mut index = 0_usize;
    while let Some(slot) = nth(slots, index) {
        if matches!(slot.activity, Activity::Fuse(_)) {
            attempt!(steers.follows(&Place { index, slot }));
        }
        index = index.wrapping_add(1);
    }
    drives.follows(&steers)
}

/// When a sensor measures, in ms after the round's start.
struct Turn {
    begin: u32,
    end: u32,
}

impl Turn {
    /// Finds the turn of `sensor` and checks its rules.
    const fn of(
        slots: &[Slot],
        sensor: SensorId,
        station: &Station,
    ) -> Result<Self, ScheduleError> {
        // What the turn needs is there, once, and in order; then the times between.
        let moved = match station.aim {
            Aim::Sweeping { settle, .. } => {
                let place = attempt!(Place::of(slots, Activity::Move(sensor)));
                Some((place, settle))
            }
            Aim::Fixed(_) => None,
        };
        let (first, last) = match station.measuring {
            Measuring::Apart { .. } => (
                attempt!(Place::of(slots, Activity::Start(sensor))),
                attempt!(Place::of(slots, Activity::Read(sensor))),
            ),
            Measuring::Whole { .. } => {
                let place = attempt!(Place::of(slots, Activity::Measure(sensor)));
                (place, place)
            }
        };
        let fused = attempt!(Place::of(slots, Activity::Fuse(sensor)));
        if let Some((moved, _)) = &moved {
            attempt!(first.follows(moved));
        }
        attempt!(last.follows(&first));
        attempt!(fused.follows(&last));

        if let Some((moved, settle)) = moved {
            let ready = moved.slot.end().wrapping_add(settle as u32);
            if (first.slot.at as u32) < ready {
                let slot = first.index;
                return Err(ScheduleError::Unsettled {
                    slot,
                    sensor,
                    ready,
                });
            }
        }
        match station.measuring {
            Measuring::Apart { conversion } => {
                let ready = first.slot.end().wrapping_add(conversion as u32);
                if (last.slot.at as u32) < ready {
                    let slot = last.index;
                    return Err(ScheduleError::Unconverted {
                        slot,
                        sensor,
                        ready,
                    });
                }
            }
            Measuring::Whole { longest } => {
                if first.slot.lasts < longest {
                    let slot = first.index;
                    return Err(ScheduleError::TooShort {
                        slot,
                        sensor,
                        longest,
                    });
                }
            }
        }
        Ok(Self {
            begin: first.slot.at as u32,
            end: last.slot.end(),
        })
    }
}

/// Two sensors of like signals look far enough apart whenever one listens to what the other sends.
const fn interference(
    period: u16,
    apart: BinaryAngle,
    slots: &[Slot],
    (first, a): (SensorId, &Station),
    (second, b): (SensorId, &Station),
) -> Result<(), ScheduleError> {
    if !a.signal.is(b.signal) {
        return Ok(());
    }
    let turn_a = attempt!(Turn::of(slots, first, a));
    let turn_b = attempt!(Turn::of(slots, second, b));
    let round = period as u32;
    let silent_a = turn_a.end.wrapping_add(a.fades as u32);
    let silent_b = turn_b.end.wrapping_add(b.fades as u32);
    // The one that begins later listens to the other, and both send from their begin on. A signal
    // is gone before its own sensor's next turn, so it reaches no further than the next round.
    let at_once = turn_a.begin < silent_b && turn_b.begin < silent_a;
    let a_into_next = turn_b.begin.wrapping_add(round) < silent_a;
    let b_into_next = turn_a.begin.wrapping_add(round) < silent_b;
    if !at_once && !a_into_next && !b_into_next {
        return Ok(());
    }
    let steps = common_multiple(a.aim.repeats_after(), b.aim.repeats_after());
    if steps > MAX_STEPS {
        return Err(ScheduleError::TooManySteps {
            first,
            second,
            steps,
        });
    }
    let mut step = 0;
    while step < steps {
        let next = step.wrapping_add(1);
        if (at_once && near(a, step, b, step, apart))
            || (a_into_next && near(a, step, b, next, apart))
            || (b_into_next && near(a, next, b, step, apart))
        {
            return Err(ScheduleError::Interference {
                first,
                second,
                step,
            });
        }
        step = next;
    }
    Ok(())
}

/// Whether `a` at one step looks less than `apart` away from where `b` looks at another.
const fn near(a: &Station, at: u32, b: &Station, other: u32, apart: BinaryAngle) -> bool {
    let between = a.aim.direction(at).separation(b.aim.direction(other));
    between.to_bits() < apart.to_bits()
}

/// The least common multiple of two numbers of 16 bits, neither of them zero.
const fn common_multiple(a: u32, b: u32) -> u32 {
    let (mut divisor, mut rest) = (a, b);
    while let Some(remainder) = divisor.checked_rem(rest) {
        divisor = rest;
        rest = remainder;
    }
    match a.checked_div(divisor) {
        Some(quotient) => quotient.wrapping_mul(b),
        None => b,
    }
}
