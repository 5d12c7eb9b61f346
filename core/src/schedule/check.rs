//! The rules of a round, one function each, for constants too.
//!
//! Times are sums of a few 16-bit numbers in 32 bits, so nothing here wraps.

use super::error::{MAX_STEPS, ScheduleError};
use super::round::{Activity, Aim, Measuring, Slot, Station};
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

/// Checks every rule.
pub(super) const fn check(
    period: u16,
    stale_after: u32,
    apart: BinaryAngle,
    slots: &[Slot],
    stations: &[Station],
) -> Result<(), ScheduleError> {
    if slots.is_empty() || stations.len() > u8::MAX as usize {
        return Err(ScheduleError::Size {
            slots: slots.len(),
            stations: stations.len(),
        });
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
        let interval = attempt!(Interval::of(slots, sensor, station));
        if interval.end.wrapping_add(station.fades as u32)
            > interval.begin.wrapping_add(period as u32)
        {
            return Err(ScheduleError::Interference {
                first: sensor,
                second: sensor,
                step: 0,
            });
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

/// Returns the station at `index` with its sensor's number.
const fn numbered(stations: &[Station], index: usize) -> Option<(SensorId, &Station)> {
    match (SensorId::from_slot(index), nth(stations, index)) {
        (Some(sensor), Some(station)) => Some((sensor, station)),
        _ => None,
    }
}

/// The slots follow one another within the round.
const fn times(period: u16, slots: &[Slot]) -> Result<(), ScheduleError> {
    let mut slot = 0_usize;
    while let Some(this) = nth(slots, slot) {
        let following = slot.wrapping_add(1);
        if this.lasts == 0 {
            return Err(ScheduleError::TooShort { slot, needed: 1 });
        }
        let end = this.end();
        let limit = match nth(slots, following) {
            Some(next) => next.at,
            None => period,
        };
        if end > limit as u32 {
            return Err(ScheduleError::Overrun { slot, end, limit });
        }
        slot = following;
    }
    Ok(())
}

/// Every slot's sensor has a station that can do its activity.
const fn kinds(slots: &[Slot], stations: &[Station]) -> Result<(), ScheduleError> {
    let mut slot = 0_usize;
    while let Some(&Slot { activity, .. }) = nth(slots, slot) {
        if let Some(sensor) = activity.sensor() {
            let possible = match (activity, nth(stations, sensor.slot())) {
                (_, None) => false,
                (Activity::Move(_), Some(station)) => matches!(station.aim, Aim::Sweeping { .. }),
                (Activity::Start(_) | Activity::Read(_), Some(station)) => {
                    matches!(station.measuring, Measuring::Apart { .. })
                }
                (Activity::Measure(_), Some(station)) => {
                    matches!(station.measuring, Measuring::Whole { .. })
                }
                (_, Some(_)) => true,
            };
            if !possible {
                return Err(ScheduleError::Impossible { slot, activity });
            }
        }
        slot = slot.wrapping_add(1);
    }
    Ok(())
}

/// A slot with its index in the list.
#[derive(Clone, Copy)]
struct Place<'a> {
    index: usize,
    slot: &'a Slot,
}

impl<'a> Place<'a> {
    /// Returns the only slot of an activity that must have one.
    const fn of(slots: &'a [Slot], activity: Activity) -> Result<Self, ScheduleError> {
        match attempt!(Self::find(slots, activity)) {
            Some(place) => Ok(place),
            None => Err(ScheduleError::NoSlot { activity }),
        }
    }

    /// Returns the only slot of an activity, if it has one.
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

/// A round that steers does so once, after all sensors are fused, and then drives.
const fn control(slots: &[Slot]) -> Result<(), ScheduleError> {
    let steers = attempt!(Place::find(slots, Activity::Steer));
    let drives = attempt!(Place::find(slots, Activity::Drive));
    let (steers, drives) = match (steers, drives) {
        (None, None) => return Ok(()),
        (Some(steers), Some(drives)) => (steers, drives),
        (Some(_), None) => {
            let activity = Activity::Drive;
            return Err(ScheduleError::NoSlot { activity });
        }
        (None, Some(_)) => {
            let activity = Activity::Steer;
            return Err(ScheduleError::NoSlot { activity });
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

/// The interval in which a sensor measures, in ms after the round's start.
struct Interval {
    begin: u32,
    end: u32,
}

impl Interval {
    /// Finds the measurement of `sensor` and checks its rules.
    const fn of(
        slots: &[Slot],
        sensor: SensorId,
        station: &Station,
    ) -> Result<Self, ScheduleError> {
        // All slots exist, once and in order; then the times between them.
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
                return Err(ScheduleError::TooEarly {
                    slot,
                    activity: first.slot.activity,
                    ready,
                });
            }
        }
        match station.measuring {
            Measuring::Apart { conversion } => {
                let ready = first.slot.end().wrapping_add(conversion as u32);
                if (last.slot.at as u32) < ready {
                    let slot = last.index;
                    return Err(ScheduleError::TooEarly {
                        slot,
                        activity: last.slot.activity,
                        ready,
                    });
                }
            }
            Measuring::Whole { longest } => {
                if first.slot.lasts < longest {
                    let slot = first.index;
                    return Err(ScheduleError::TooShort {
                        slot,
                        needed: longest,
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

/// Two sensors of one signal point far enough apart whenever one receives what the other sends.
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
    let interval_a = attempt!(Interval::of(slots, first, a));
    let interval_b = attempt!(Interval::of(slots, second, b));
    let round = period as u32;
    let faded_a = interval_a.end.wrapping_add(a.fades as u32);
    let faded_b = interval_b.end.wrapping_add(b.fades as u32);
    // The one that begins later receives the other's signal, and both send from their begin on. A
    // signal has faded before its own sensor measures again, so it lasts into the next round at most.
    let at_once = interval_a.begin < faded_b && interval_b.begin < faded_a;
    let a_into_next = interval_b.begin.wrapping_add(round) < faded_a;
    let b_into_next = interval_a.begin.wrapping_add(round) < faded_b;
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

/// Returns whether `a` at step `at` and `b` at step `other` point less than `apart` apart.
const fn near(a: &Station, at: u32, b: &Station, other: u32, apart: BinaryAngle) -> bool {
    let between = a.aim.direction(at).separation(b.aim.direction(other));
    between.to_bits() < apart.to_bits()
}

/// Returns the least common multiple of two numbers of 16 bits, neither of them zero.
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

#[cfg(test)]
mod tests {
    //! Random rounds against an oracle, which states every rule again, sensor by sensor.

    use super::*;
    use crate::schedule::Signal;
    use crate::transducer::Sweep;
    use core::cell::RefCell;
    use proptest::prelude::*;
    use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
    use std::collections::{BTreeMap, BTreeSet};

    const fn degrees(degrees: i32) -> BinaryAngle {
        BinaryAngle::from_millidegrees(degrees * 1000)
    }

    #[derive(Debug, Clone)]
    struct Round {
        period: u16,
        apart: BinaryAngle,
        slots: Vec<Slot>,
        stations: Vec<Station>,
    }

    const OVERRUN: &str = "a slot ends after the next begins or after the round";
    const IMPOSSIBLE: &str = "a sensor has no station that does what a slot asks for";

    /// The activities of a sensor in a round, in their order.
    fn activities_of(sensor: SensorId, station: &Station) -> Vec<Activity> {
        let mut activities = Vec::new();
        if matches!(station.aim, Aim::Sweeping { .. }) {
            activities.push(Activity::Move(sensor));
        }
        match station.measuring {
            Measuring::Apart { .. } => {
                activities.extend([Activity::Start(sensor), Activity::Read(sensor)]);
            }
            Measuring::Whole { .. } => activities.push(Activity::Measure(sensor)),
        }
        activities.push(Activity::Fuse(sensor));
        activities
    }

    /// One measurement of one round: it receives until `end` and is received until `faded`.
    struct Measurement {
        sensor: usize,
        begin: u32,
        end: u32,
        faded: u32,
        direction: BinaryAngle,
    }

    /// All rules that the round breaks.
    fn broken_rules(round: &Round) -> BTreeSet<&'static str> {
        let Round { slots, period, .. } = round;
        let mut broken = BTreeSet::new();
        if slots.is_empty() {
            broken.insert("a round needs at least one slot");
        }
        for (index, slot) in slots.iter().enumerate() {
            if slot.lasts == 0 {
                broken.insert("a slot is too short");
            }
            if slot.end() > u32::from(*period) {
                broken.insert(OVERRUN);
            }
            for later in &slots[index + 1..] {
                if slot.end() > u32::from(later.at) {
                    broken.insert(OVERRUN);
                }
            }
        }

        // Steering and driving: both or neither, each once, after all are fused.
        let of = |activity| (0..slots.len()).filter(move |&i| slots[i].activity == activity);
        let (steers, drives) = (of(Activity::Steer), of(Activity::Drive));
        let (steers, drives): (Vec<_>, Vec<_>) = (steers.collect(), drives.collect());
        if steers.is_empty() != drives.is_empty() {
            broken.insert("an activity has no slot");
        }
        if steers.len() > 1 || drives.len() > 1 {
            broken.insert("an activity has two slots");
        }
        let fused = |slot: &Slot| matches!(slot.activity, Activity::Fuse(_));
        let last_fused = slots.iter().rposition(fused);
        let steered = steers.iter().any(|&i| Some(i) < last_fused);
        if steered
            || drives
                .iter()
                .zip(&steers)
                .any(|(drive, steer)| drive < steer)
        {
            broken.insert("activities are in the wrong order");
        }

        let mut measurements = Vec::new();
        let every: BTreeSet<_> = slots.iter().filter_map(|s| s.activity.sensor()).collect();
        if every.iter().any(|s| s.slot() >= round.stations.len()) {
            broken.insert(IMPOSSIBLE);
        }
        for (index, station) in round.stations.iter().enumerate() {
            let sensor = SensorId::from_slot(index).unwrap();
            let mine: Vec<_> = (slots.iter())
                .filter(|s| s.activity.sensor() == Some(sensor))
                .collect();
            let wanted = activities_of(sensor, station);
            let done: Vec<_> = mine.iter().map(|s| s.activity).collect();
            if done.iter().any(|a| !wanted.contains(a)) {
                broken.insert(IMPOSSIBLE);
            }
            if wanted.iter().any(|a| !done.contains(a)) {
                broken.insert("an activity has no slot");
            }
            if done.iter().collect::<std::collections::HashSet<_>>().len() < done.len() {
                broken.insert("an activity has two slots");
            }
            let rank = |a: &Activity| wanted.iter().position(|w| w == a);
            if !done.iter().map(rank).is_sorted() {
                broken.insert("activities are in the wrong order");
            }
            if done != wanted {
                continue;
            }
            // Its slots, from the last: fused, read or measured, started.
            let fused = mine.len() - 1;
            let last = mine[fused - 1];
            let first = match station.measuring {
                Measuring::Apart { conversion } => {
                    let started = mine[fused - 2];
                    if u32::from(last.at) < started.end() + u32::from(conversion) {
                        broken.insert("a sensor is read before its conversion has ended");
                    }
                    started
                }
                Measuring::Whole { longest } => {
                    if last.lasts < longest {
                        broken.insert("a slot is too short");
                    }
                    last
                }
            };
            if let Aim::Sweeping { settle, .. } = station.aim
                && u32::from(first.at) < mine[0].end() + u32::from(settle)
            {
                broken.insert("a sensor measures before its head has settled");
            }
            // Enough rounds for every pair of steps: the sweeps have at most six directions each.
            for step in 0..62 {
                let start = step * u32::from(*period);
                measurements.push(Measurement {
                    sensor: index,
                    begin: start + u32::from(first.at),
                    end: start + last.end(),
                    faded: start + last.end() + u32::from(station.fades),
                    direction: station.aim.direction(step),
                });
            }
        }

        for receiver in &measurements {
            for other in &measurements {
                // The milliseconds at which the one receives the other.
                let both = receiver.begin.max(other.begin)..receiver.end.min(other.faded);
                if both.is_empty() {
                    continue;
                }
                let signal = |measurement: &Measurement| round.stations[measurement.sensor].signal;
                if receiver.sensor == other.sensor {
                    if receiver.begin != other.begin {
                        broken.insert("a sensor measures again before its signal has faded");
                    }
                } else if signal(receiver) == signal(other)
                    && receiver.direction.separation(other.direction) < round.apart
                {
                    broken.insert("two sensors measure in one direction at the same time");
                }
            }
        }
        broken
    }

    fn station() -> impl Strategy<Value = Station> {
        let aim = prop_oneof![
            (2_u16..=6, 0_u16..3, 0_u16..4).prop_map(|(directions, slot, settle)| Aim::Sweeping {
                sweep: Sweep::try_new(degrees(-90), degrees(90), directions).unwrap(),
                slot,
                heads: 3,
                settle,
            }),
            (-90..90).prop_map(|direction| Aim::Fixed(degrees(direction))),
        ];
        let measuring = prop_oneof![
            (0_u16..6).prop_map(|conversion| Measuring::Apart { conversion }),
            (1_u16..6).prop_map(|longest| Measuring::Whole { longest }),
        ];
        let fades = prop_oneof![2 => Just(0_u16), 1 => 0_u16..40];
        (any::<bool>(), aim, measuring, fades).prop_map(|(light, aim, measuring, fades)| Station {
            signal: if light { Signal::Light } else { Signal::Sound },
            aim,
            measuring,
            fades,
        })
    }

    /// Makes one small change to a round, chosen by three numbers.
    fn change(round: &mut Round, (what, which, much): (u8, usize, u16)) {
        let Some(count) = round.slots.len().checked_sub(1) else {
            return;
        };
        let (slot, other) = (which % (count + 1), usize::from(much) % (count + 1));
        let activity = round.slots[other].activity;
        match what {
            0 => round.slots[slot].at = round.slots[slot].at.saturating_sub(1 + much % 3),
            1 => round.slots[slot].lasts = much % 8,
            2 => round.slots[slot].activity = activity,
            3 => {
                round.slots[other].activity = round.slots[slot].activity;
                round.slots[slot].activity = activity;
            }
            4 => drop(round.slots.remove(slot)),
            5 => round.period = round.period.saturating_sub(1 + much),
            6 => drop(round.stations.pop()),
            7 => round.slots.truncate(usize::from(much % 2) * count),
            8 => {
                let sensor = SensorId::from_slot(other % 3).unwrap();
                let all = [
                    Activity::Move(sensor),
                    Activity::Start(sensor),
                    Activity::Read(sensor),
                    Activity::Measure(sensor),
                    Activity::Fuse(sensor),
                    Activity::Steer,
                    Activity::Drive,
                ];
                round.slots[slot].activity = all[which % all.len()];
            }
            _ => {}
        }
    }

    /// Rounds in which every sensor has all its slots in time, in a random order; half of them with a
    /// change afterwards.
    fn round() -> impl Strategy<Value = Round> {
        let order = proptest::collection::vec((0_usize..8, 0_u16..2), 16);
        let changes = proptest::option::of((0_u8..9, 0_usize..16, 0_u16..16));
        let stations = proptest::collection::vec(station(), 1..=3);
        (stations, order, 0_u16..30, 0..60, changes).prop_map(
            |(stations, order, rest, apart, changes)| {
                let mut open: Vec<_> = (stations.iter().enumerate())
                    .map(|(i, s)| activities_of(SensorId::from_slot(i).unwrap(), s))
                    .collect();
                let mut free = vec![0_u16; stations.len()];
                let mut now = 0;
                let mut slots = Vec::new();
                for (choice, wait) in order {
                    let left: Vec<_> = (0..open.len()).filter(|&i| !open[i].is_empty()).collect();
                    let activity = match left.get(choice % left.len().max(1)) {
                        Some(&i) => open[i].remove(0),
                        None => break,
                    };
                    let mine = activity.sensor().unwrap().slot();
                    let (lasts, then) = match (activity, stations[mine]) {
                        (
                            Activity::Move(_),
                            Station {
                                aim: Aim::Sweeping { settle, .. },
                                ..
                            },
                        ) => (1, settle),
                        (
                            Activity::Start(_),
                            Station {
                                measuring: Measuring::Apart { conversion },
                                ..
                            },
                        ) => (1, conversion),
                        (
                            Activity::Measure(_),
                            Station {
                                measuring: Measuring::Whole { longest },
                                ..
                            },
                        ) => (longest, 0),
                        _ => (1, 0),
                    };
                    let at = free[mine].max(now) + wait;
                    slots.push(Slot::new(at, lasts, activity));
                    now = at + lasts;
                    free[mine] = now + then;
                }
                // Every third round drives.
                if rest % 3 == 0 {
                    slots.push(Slot::new(now, 1, Activity::Steer));
                    slots.push(Slot::new(now + 1, 1, Activity::Drive));
                    now += 2;
                }
                let mut round = Round {
                    period: now + rest,
                    apart: degrees(apart),
                    slots,
                    stations,
                };
                if let Some(how) = changes {
                    change(&mut round, how);
                }
                round
            },
        )
    }

    #[test]
    fn a_round_is_accepted_exactly_if_the_oracle_does() {
        let seen = RefCell::new(BTreeMap::<&str, u32>::new());
        let config = Config {
            cases: 4000,
            failure_persistence: None,
            ..Config::default()
        };
        let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
        TestRunner::new_with_rng(config, rng)
            .run(&round(), |round| {
                let Round { period, apart, .. } = round;
                let broken = broken_rules(&round);
                let result = check(period, 2000, apart, &round.slots, &round.stations);
                match result {
                    Ok(()) => prop_assert!(broken.is_empty(), "accepted: {broken:?}"),
                    Err(error) => prop_assert!(
                        broken.contains(error.rule()),
                        "refused for {error}, not {broken:?}"
                    ),
                }
                let outcome = result.map_or_else(|error| error.rule(), |()| "accepted");
                *seen.borrow_mut().entry(outcome).or_default() += 1;
                Ok(())
            })
            .unwrap();
        // Both outcomes occur, and every rule is broken in some round.
        let seen = seen.into_inner();
        assert!(seen["accepted"] > 1000, "{seen:#?}");
        assert!(seen.values().all(|&cases| cases >= 5), "{seen:#?}");
        assert_eq!(seen.len(), 1 + 11, "{seen:#?}");
    }
}
