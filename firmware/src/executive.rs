//! The time-triggered executive: each slot of the round starts at its tick or is skipped.
//!
//! The tick interrupt runs the [`Dispatcher`], which puts due slots into a queue. The main loop runs the
//! [`Executive`], which takes them from the queue, performs them and sleeps between. A slot that the main
//! loop reaches after its tick is *skipped*: the application is notified, and the skip is counted. So an
//! overrun never delays the next slot.

use crate::board::{Clock, Watchdog};
use crate::mailbox::Mailbox;
use certainty_core::schedule::{Activity, Schedule};
use certainty_core::units::Ticks;

/// A slot that is due.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Due {
    /// Which round, from 0.
    pub round: u32,
    /// Which slot of the round, from 0.
    pub slot: u16,
    /// Its tick.
    pub at: Ticks,
}

/// The queue between [`Dispatcher`] and [`Executive`], for three slots.
pub type DueQueue = Mailbox<Due, 3>;

/// Turns ticks into due slots; runs in the tick interrupt.
///
/// Cost: one comparison a tick, one queue entry a slot.
#[derive(Debug)]
pub struct Dispatcher<const SLOTS: usize, const STATIONS: usize> {
    schedule: &'static Schedule<SLOTS, STATIONS>,
    now: Ticks,
    in_round: u16,
    round: u32,
    next: u16,
}

impl<const SLOTS: usize, const STATIONS: usize> Dispatcher<SLOTS, STATIONS> {
    /// Creates a dispatcher whose first tick is the start of round 0, at tick 0.
    #[must_use]
    pub const fn new(schedule: &'static Schedule<SLOTS, STATIONS>) -> Self {
        Self {
            schedule,
            now: Ticks::new(u32::MAX),
            in_round: 0,
            round: 0,
            next: 0,
        }
    }

    /// Counts one tick and puts the slot that begins with it, if any, into `queue`.
    ///
    /// If the queue is full the slot is dropped; the executive detects the gap and counts it as skipped.
    pub fn tick(&mut self, queue: &DueQueue) {
        self.now = Ticks::new(self.now.get().wrapping_add(1));
        let due = self.schedule.slots().get(usize::from(self.next));
        if due.is_some_and(|slot| slot.at == self.in_round) {
            let due = Due {
                round: self.round,
                slot: self.next,
                at: self.now,
            };
            // If the queue is full, the executive detects the gap.
            let _ = queue.put(due);
            self.next = self.next.wrapping_add(1);
        }
        self.in_round = self.in_round.wrapping_add(1);
        if self.in_round >= self.schedule.period() {
            self.in_round = 0;
            self.next = 0;
            self.round = self.round.wrapping_add(1);
        }
    }

    /// Returns the last tick.
    #[must_use]
    pub const fn now(&self) -> Ticks {
        self.now
    }

    /// Returns the tick at which the next slot begins.
    #[must_use]
    pub fn next_due(&self) -> Ticks {
        let starts = |slot: u16| self.schedule.slots().get(usize::from(slot)).map(|s| s.at);
        let left = match (starts(self.next), starts(0)) {
            (Some(at), _) => at.saturating_sub(self.in_round),
            (None, Some(first)) => {
                let rest = self.schedule.period().saturating_sub(self.in_round);
                rest.saturating_add(first)
            }
            (None, None) => 0, // unreachable: a schedule has slots
        };
        // `in_round` is the place of the next tick in the round.
        let ticks = u32::from(left).wrapping_add(1);
        Ticks::new(self.now.get().wrapping_add(ticks))
    }
}

/// Counts of completed rounds and skipped slots.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Timeliness {
    /// Completed rounds; saturates.
    pub rounds: u32,
    /// Skipped slots; saturates.
    pub overruns: u32,
}

/// What the slots do.
pub trait Application {
    /// Performs a slot's activity; must return before the slot ends.
    fn perform(&mut self, activity: Activity, due: Due, timeliness: Timeliness);

    /// Notes that a slot was skipped.
    fn skip(&mut self, activity: Activity, due: Due);
}

/// The main loop of a time-triggered application.
#[derive(Debug)]
pub struct Executive<C, W, const SLOTS: usize, const STATIONS: usize> {
    schedule: &'static Schedule<SLOTS, STATIONS>,
    clock: C,
    watchdog: W,
    /// Round and number of the next slot to perform.
    next: (u32, u16),
    timeliness: Timeliness,
}

impl<C: Clock, W: Watchdog, const SLOTS: usize, const STATIONS: usize>
    Executive<C, W, SLOTS, STATIONS>
{
    /// Creates the executive; its dispatcher must have the same schedule.
    pub const fn new(schedule: &'static Schedule<SLOTS, STATIONS>, clock: C, watchdog: W) -> Self {
        Self {
            schedule,
            clock,
            watchdog,
            next: (0, 0),
            timeliness: Timeliness {
                rounds: 0,
                overruns: 0,
            },
        }
    }

    /// Returns the counts since the start.
    pub const fn timeliness(&self) -> Timeliness {
        self.timeliness
    }

    /// Performs or skips the next due slot; sleeps if none is due.
    ///
    /// The watchdog is fed at the end of each round, after every slot of it was performed or skipped.
    pub fn step(&mut self, queue: &DueQueue, application: &mut impl Application) {
        let Some(due) = queue.take() else {
            self.clock.sleep();
            return;
        };
        self.skip_until(due, application);
        let Some(slot) = self.schedule.slots().get(usize::from(due.slot)) else {
            return; // the queue of another schedule
        };
        if self.clock.now() == due.at {
            application.perform(slot.activity, due, self.timeliness);
        } else {
            self.skip(slot.activity, due, application);
        }
        self.advance(due.round, due.slot);
    }

    /// Skips the slots that were dropped because the queue was full.
    ///
    /// All are counted. The application is notified of at most one round of them, the latest, because older
    /// readings are out of date anyway.
    fn skip_until(&mut self, due: Due, application: &mut impl Application) {
        let (round, slot) = self.next;
        let rounds = due.round.wrapping_sub(round);
        if rounds > 1 || (rounds == 1 && due.slot > slot) {
            // Start at the same slot of the previous round.
            let ended = rounds.wrapping_sub(1);
            // Add before subtracting, so that the result is not below zero; modulo 2^32.
            let missed = ended
                .wrapping_mul(u32::try_from(SLOTS).unwrap_or(u32::MAX))
                .wrapping_add(due.slot.into())
                .wrapping_sub(slot.into());
            #[cfg(feature = "defmt")]
            defmt::warn!("round {}: {} slots skipped before", due.round, missed);
            self.timeliness.overruns = self.timeliness.overruns.saturating_add(missed);
            self.timeliness.rounds = self.timeliness.rounds.saturating_add(ended);
            self.next = (due.round.wrapping_sub(1), due.slot);
        }
        for _ in 0..SLOTS {
            let (round, slot) = self.next;
            if (round, slot) == (due.round, due.slot) {
                return;
            }
            let Some(missed) = self.schedule.slots().get(usize::from(slot)) else {
                return;
            };
            let lost = Due { round, slot, ..due };
            self.skip(missed.activity, lost, application);
            self.advance(round, slot);
        }
    }

    fn skip(&mut self, activity: Activity, due: Due, application: &mut impl Application) {
        #[cfg(feature = "defmt")]
        defmt::warn!(
            "round {}: slot {} skipped: {}",
            due.round,
            due.slot,
            activity
        );
        self.timeliness.overruns = self.timeliness.overruns.saturating_add(1);
        application.skip(activity, due);
    }

    /// Moves on to the slot after this one; feeds the watchdog after the last.
    fn advance(&mut self, round: u32, slot: u16) {
        let slot = slot.wrapping_add(1);
        if usize::from(slot) < SLOTS {
            self.next = (round, slot);
        } else {
            self.next = (round.wrapping_add(1), 0);
            self.timeliness.rounds = self.timeliness.rounds.saturating_add(1);
            self.watchdog.feed();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::schedule::{ScheduleConfig, Slot};
    use certainty_core::units::BinaryAngle;
    use core::cell::RefCell;

    /// Three reports in a round of 10 ms, at 0, 3 and 7.
    static SCHEDULE: Schedule<3, 0> = Schedule::new(ScheduleConfig {
        period: 10,
        stale_after: 2000,
        apart: BinaryAngle::ZERO,
        slots: [
            Slot::new(0, 3, Activity::Report),
            Slot::new(3, 4, Activity::Report),
            Slot::new(7, 3, Activity::Report),
        ],
        stations: [],
    });

    /// A millisecond counter with its interrupt.
    struct Machine<'q> {
        dispatcher: Dispatcher<3, 0>,
        queue: &'q DueQueue,
        fed_at: Vec<u32>,
    }

    impl Machine<'_> {
        fn pass(&mut self, ms: u32) {
            (0..ms).for_each(|_| self.dispatcher.tick(self.queue));
        }
    }

    struct MachineClock<'m, 'q>(&'m RefCell<Machine<'q>>);

    impl Clock for MachineClock<'_, '_> {
        fn now(&mut self) -> Ticks {
            self.0.borrow().dispatcher.now()
        }

        fn sleep(&mut self) {
            self.0.borrow_mut().pass(1);
        }
    }

    impl Watchdog for MachineClock<'_, '_> {
        fn feed(&mut self) {
            let mut machine = self.0.borrow_mut();
            let now = machine.dispatcher.now().get();
            machine.fed_at.push(now);
        }
    }

    /// Spends the listed times in its slots, then no time.
    struct Worker<'m, 'q> {
        machine: &'m RefCell<Machine<'q>>,
        takes_ms: Vec<u32>,
        done: Vec<(u32, u16, u32)>,
        skipped: Vec<(u32, u16)>,
    }

    impl Application for Worker<'_, '_> {
        fn perform(&mut self, _: Activity, due: Due, _: Timeliness) {
            let now = self.machine.borrow().dispatcher.now();
            self.done.push((due.round, due.slot, now.get()));
            let takes = self.takes_ms.get(self.done.len() - 1).copied();
            self.machine.borrow_mut().pass(takes.unwrap_or(0));
        }

        fn skip(&mut self, _: Activity, due: Due) {
            self.skipped.push((due.round, due.slot));
        }
    }

    struct Outcome {
        done: Vec<(u32, u16, u32)>,
        skipped: Vec<(u32, u16)>,
        fed_at: Vec<u32>,
        timeliness: Timeliness,
    }

    fn run(takes_ms: &[u32], until: u32) -> Outcome {
        let queue = DueQueue::new();
        let machine = RefCell::new(Machine {
            dispatcher: Dispatcher::new(&SCHEDULE),
            queue: &queue,
            fed_at: Vec::new(),
        });
        let mut worker = Worker {
            machine: &machine,
            takes_ms: takes_ms.to_vec(),
            done: Vec::new(),
            skipped: Vec::new(),
        };
        let mut executive =
            Executive::new(&SCHEDULE, MachineClock(&machine), MachineClock(&machine));
        machine.borrow_mut().pass(1);
        while machine.borrow().dispatcher.now().get() < until {
            executive.step(&queue, &mut worker);
        }
        let timeliness = executive.timeliness();
        let (done, skipped) = (worker.done, worker.skipped);
        let fed_at = machine.into_inner().fed_at;
        Outcome {
            done,
            skipped,
            fed_at,
            timeliness,
        }
    }

    #[test]
    fn every_slot_begins_at_its_tick() {
        let outcome = run(&[2, 3, 2, 2, 3, 2], 21);
        let expected = [
            (0, 0, 0),
            (0, 1, 3),
            (0, 2, 7),
            (1, 0, 10),
            (1, 1, 13),
            (1, 2, 17),
            (2, 0, 20),
        ];
        assert_eq!(outcome.done, expected);
        assert_eq!(outcome.skipped, Vec::<(u32, u16)>::new());
        assert_eq!(outcome.fed_at, [9, 19], "after the last slot of a round");
        assert_eq!(
            outcome.timeliness,
            Timeliness {
                rounds: 2,
                overruns: 0
            }
        );
    }

    #[test]
    fn an_overrun_skips_one_slot_and_the_next_is_on_time() {
        // Slot 0 takes 5 ms: slot 1, due at 3, is skipped, not performed late.
        let outcome = run(&[5], 11);
        assert_eq!(outcome.done, [(0, 0, 0), (0, 2, 7), (1, 0, 10)]);
        assert_eq!(outcome.skipped, [(0, 1)]);
        assert_eq!(
            outcome.timeliness,
            Timeliness {
                rounds: 1,
                overruns: 1
            }
        );
    }

    #[test]
    fn slots_dropped_by_a_full_queue_are_counted() {
        // In 35 ms three slots a round become due, at 3, 7, 10, 13, … 33; the queue holds three.
        let outcome = run(&[35], 38);
        assert_eq!(outcome.done, [(0, 0, 0), (3, 2, 37)]);
        // The three in the queue, then the last round of the dropped ones; (1, 1) to (2, 1) are only
        // counted.
        let notified = [(0, 1), (0, 2), (1, 0), (2, 2), (3, 0), (3, 1)];
        assert_eq!(outcome.skipped, notified);
        assert_eq!(outcome.timeliness.overruns, 10);
        // Rounds 0 to 2 are over, and round 3 ends with its slot 2.
        assert_eq!(outcome.timeliness.rounds, 4);
    }

    #[test]
    fn a_hanging_main_loop_does_not_feed_the_watchdog() {
        let outcome = run(&[1000], 1000);
        assert_eq!(outcome.fed_at, Vec::<u32>::new());
    }

    #[test]
    fn no_slot_is_due_before_next_due() {
        let queue = DueQueue::new();
        let mut dispatcher = Dispatcher::new(&SCHEDULE);
        let mut next = dispatcher.next_due();
        assert_eq!(next, Ticks::new(0));
        for _ in 0..100 {
            dispatcher.tick(&queue);
            let due = queue.take();
            assert_eq!(due.is_some(), dispatcher.now() == next);
            if due.is_some() {
                next = dispatcher.next_due();
            }
            assert_eq!(dispatcher.next_due(), next);
        }
    }
}
