//! The time-triggered executive: each slot of the round at its tick, or not at all.
//!
//! The tick interrupt runs the [`Dispatcher`], which only hands over what is due; the main loop runs
//! the [`Executive`], which does it and sleeps between. A slot that the main loop comes to too late is
//! *skipped*, told to the application and counted: so an overrun never delays the slot after it.

use crate::board::{Clock, Watchdog};
use crate::mailbox::Mailbox;
use certainty_core::schedule::{Activity, Schedule};
use certainty_core::units::Ticks;

/// A slot whose time has come.
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

/// Where due slots wait for the main loop: room for three of them.
pub type DueQueue = Mailbox<Due, 4>;

/// Turns ticks into due slots.
///
/// Cost: one comparison a tick, one queue entry a slot; for the tick interrupt.
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

    /// Takes one tick; puts the slot that begins with it, if any, into `queue`.
    ///
    /// Where the queue is full the slot is lost, and the main loop notices by the gap.
    pub fn tick(&mut self, queue: &DueQueue) {
        self.now = Ticks::new(self.now.get().wrapping_add(1));
        let due = self.schedule.slots().get(usize::from(self.next));
        if due.is_some_and(|slot| slot.at == self.in_round) {
            let due = Due {
                round: self.round,
                slot: self.next,
                at: self.now,
            };
            // A full queue is an overrun of several slots, which the gap tells.
            let _full = queue.put(due);
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
}

/// What the executive knows of its own working.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Timeliness {
    /// Rounds that ended.
    pub rounds: u32,
    /// Slots that were skipped because the main loop came too late.
    pub overruns: u32,
}

/// What is done in the slots.
pub trait Application {
    /// Does what a slot is for, within the slot.
    fn perform(&mut self, activity: Activity, due: Due, timeliness: Timeliness);

    /// Is told that a slot was skipped.
    fn skip(&mut self, activity: Activity, due: Due);
}

/// The main loop of a time-triggered application.
#[derive(Debug)]
pub struct Executive<C, W, const SLOTS: usize, const STATIONS: usize> {
    schedule: &'static Schedule<SLOTS, STATIONS>,
    clock: C,
    watchdog: W,
    /// The slot after the last one that was done or skipped.
    next: (u32, u16),
    timeliness: Timeliness,
}

impl<C: Clock, W: Watchdog, const SLOTS: usize, const STATIONS: usize>
    Executive<C, W, SLOTS, STATIONS>
{
    /// Creates the main loop of a dispatcher of the same schedule.
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

    /// Returns how it went so far.
    pub const fn timeliness(&self) -> Timeliness {
        self.timeliness
    }

    /// Does what is due, or sleeps until something may be.
    ///
    /// The watchdog is fed where a round ends: by then the interrupt has handed over, and the main
    /// loop has come round to, every slot.
    pub fn step(&mut self, queue: &DueQueue, application: &mut impl Application) {
        let Some(due) = queue.take() else {
            self.clock.sleep();
            return;
        };
        self.skip_until(due, application);
        let Some(slot) = self.schedule.slots().get(usize::from(due.slot)) else {
            return; // another schedule's queue: nothing here is due
        };
        if self.clock.now() == due.at {
            application.perform(slot.activity, due, self.timeliness);
        } else {
            self.skip(slot.activity, due, application);
        }
        self.advance(due.round, due.slot);
    }

    /// Skips the slots for which there was no room in the queue.
    fn skip_until(&mut self, due: Due, application: &mut impl Application) {
        // At most a round's slots: what lies further back has no reading to miss any more.
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
        self.next = (due.round, due.slot);
    }

    fn skip(&mut self, activity: Activity, due: Due, application: &mut impl Application) {
        self.timeliness.overruns = self.timeliness.overruns.saturating_add(1);
        application.skip(activity, due);
    }

    /// Goes on to the slot after this one; feeds the watchdog after the last.
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
