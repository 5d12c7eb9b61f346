//! The rules of a round, each a function; all of them work in constants.
//!
//! Times are sums of few numbers of 16 bits in 32 bits: nothing here can wrap.

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

#[cfg(test)]
mod tests {
    //! Random rounds, and every rule once more: plainly, from the sensors' point of view.

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

    /// What a sensor's turn is made of, in its order.
    fn turn_of(sensor: SensorId, station: &Station) -> Vec<Activity> {
        let mut turn = Vec::new();
        if matches!(station.aim, Aim::Sweeping { .. }) {
            turn.push(Activity::Move(sensor));
        }
        match station.measuring {
            Measuring::Apart { .. } => {
                turn.extend([Activity::Start(sensor), Activity::Read(sensor)])
            }
            Measuring::Whole { .. } => turn.push(Activity::Measure(sensor)),
        }
        turn.push(Activity::Fuse(sensor));
        turn
    }

    /// A sensor at work in one round of many: it listens until `heard` and is heard until `silent`.
    struct Work {
        sensor: usize,
        begin: u32,
        heard: u32,
        silent: u32,
        direction: BinaryAngle,
    }

    /// The reasons of all rules that the round breaks.
    fn broken(round: &Round) -> BTreeSet<&'static str> {
        let Round { slots, period, .. } = round;
        let mut broken = BTreeSet::new();
        if slots.is_empty() {
            broken.insert("a round needs at least one slot");
        }
        for (index, slot) in slots.iter().enumerate() {
            if slot.lasts == 0 {
                broken.insert("a slot has no time");
            }
            if slot.end() > u32::from(*period) {
                broken.insert("the last slot overruns the round");
            }
            for later in &slots[index + 1..] {
                if later.at <= slot.at {
                    broken.insert("a slot does not begin after the one before it");
                } else if slot.end() > u32::from(later.at) {
                    broken.insert("a slot overruns the next");
                }
            }
        }

        // Who steers drives, each once, and when all is fused.
        let of = |activity| (0..slots.len()).filter(move |&i| slots[i].activity == activity);
        let (steers, drives) = (of(Activity::Steer), of(Activity::Drive));
        let (steers, drives): (Vec<_>, Vec<_>) = (steers.collect(), drives.collect());
        if steers.is_empty() != drives.is_empty() {
            broken.insert("an activity is without its slot");
        }
        if steers.len() > 1 || drives.len() > 1 {
            broken.insert("the same is done twice in a round");
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

        let mut works = Vec::new();
        let every: BTreeSet<_> = slots.iter().filter_map(|s| s.activity.sensor()).collect();
        if every.iter().any(|s| s.slot() >= round.stations.len()) {
            broken.insert("a slot is for a sensor without a station");
        }
        for (index, station) in round.stations.iter().enumerate() {
            let sensor = SensorId::from_slot(index).unwrap();
            let mine: Vec<_> = (slots.iter())
                .filter(|s| s.activity.sensor() == Some(sensor))
                .collect();
            let wanted = turn_of(sensor, station);
            let done: Vec<_> = mine.iter().map(|s| s.activity).collect();
            if done.iter().any(|a| !wanted.contains(a)) {
                broken.insert("a sensor cannot do what a slot asks for");
            }
            if wanted.iter().any(|a| !done.contains(a)) {
                broken.insert("an activity is without its slot");
            }
            if done.iter().collect::<std::collections::HashSet<_>>().len() < done.len() {
                broken.insert("the same is done twice in a round");
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
                        broken.insert("a sensor is read before its conversion is over");
                    }
                    started
                }
                Measuring::Whole { longest } => {
                    if last.lasts < longest {
                        broken.insert("a measurement may overrun its slot");
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
                works.push(Work {
                    sensor: index,
                    begin: start + u32::from(first.at),
                    heard: start + last.end(),
                    silent: start + last.end() + u32::from(station.fades),
                    direction: station.aim.direction(step),
                });
            }
        }

        for listener in &works {
            for other in &works {
                // Some millisecond at which the one listens and the other is heard.
                let both = listener.begin.max(other.begin)..listener.heard.min(other.silent);
                if both.is_empty() {
                    continue;
                }
                let signal = |work: &Work| round.stations[work.sensor].signal;
                if listener.sensor == other.sensor {
                    if listener.begin != other.begin {
                        broken.insert("a sensor's own signal fades into its next turn");
                    }
                } else if signal(listener) == signal(other)
                    && listener.direction.separation(other.direction) < round.apart
                {
                    broken.insert("two sensors look the same way at the same time");
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

    /// One small change to a round, by three numbers.
    fn meddle(round: &mut Round, (what, which, much): (u8, usize, u16)) {
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

    /// Rounds in which every sensor does what it must in time, in a random order; half of them meddled
    /// with afterwards.
    fn round() -> impl Strategy<Value = Round> {
        let order = proptest::collection::vec((0_usize..8, 0_u16..2), 16);
        let meddling = proptest::option::of((0_u8..9, 0_usize..16, 0_u16..16));
        let stations = proptest::collection::vec(station(), 1..=3);
        (stations, order, 0_u16..30, 0..60, meddling).prop_map(
            |(stations, order, rest, apart, meddling)| {
                let mut to_do: Vec<_> = (stations.iter().enumerate())
                    .map(|(i, s)| turn_of(SensorId::from_slot(i).unwrap(), s))
                    .collect();
                let mut free = vec![0_u16; stations.len()];
                let mut now = 0;
                let mut slots = Vec::new();
                for (choice, wait) in order {
                    let left: Vec<_> = (0..to_do.len()).filter(|&i| !to_do[i].is_empty()).collect();
                    let activity = match left.get(choice % left.len().max(1)) {
                        Some(&i) => to_do[i].remove(0),
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
                if let Some(change) = meddling {
                    meddle(&mut round, change);
                }
                round
            },
        )
    }

    #[test]
    fn a_round_is_accepted_exactly_if_the_oracle_finds_no_rule_broken() {
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
                let broken = broken(&round);
                let verdict = check(period, 2000, apart, &round.slots, &round.stations);
                match verdict {
                    Ok(()) => prop_assert!(broken.is_empty(), "accepted: {broken:?}"),
                    Err(error) => prop_assert!(
                        broken.contains(error.reason()),
                        "refused for {error}, not {broken:?}"
                    ),
                }
                let reason = verdict.map_or_else(|error| error.reason(), |()| "accepted");
                *seen.borrow_mut().entry(reason).or_default() += 1;
                Ok(())
            })
            .unwrap();
        // Neither side of the claim is empty, and no rule went untried.
        let seen = seen.into_inner();
        assert!(seen["accepted"] > 1000, "{seen:#?}");
        assert!(seen.values().all(|&cases| cases >= 5), "{seen:#?}");
        assert_eq!(seen.len(), 1 + 15, "{seen:#?}");
    }
}
