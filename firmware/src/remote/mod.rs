//! Pins, pulses and time at the far end of a link.
//!
//! Where a machine has no pins to speak of, as an emulator without them or a simulator, each
//! embedded-hal call becomes a [`Request`], and whoever keeps virtual time, world and sensors answers
//! it before anything else happens: both run in lock-step. A [`Link`] carries requests, over a serial
//! line or as a plain call.

pub mod wire;

use crate::board::{Board, Clock, Watchdog};
use crate::executive::{Dispatcher, DueQueue};
use crate::stopwatch::Stopwatch;
use crate::telemetry::Outbox;
use certainty_core::units::Ticks;
use core::fmt;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{ErrorKind, ErrorType, InputPin, OutputPin};
use embedded_hal::pwm::{self, SetDutyCycle};

/// A line between the board and a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Line {
    /// To the pivoted sensor in this slot: starts it and clocks its bits.
    Vin(u8),
    /// From the pivoted sensor in this slot.
    Vout(u8),
    /// To the ranger in this slot.
    Trigger(u8),
    /// From the ranger in this slot.
    Echo(u8),
}

/// A channel of pulses, one every 20 ms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Channel {
    /// Turns the pivoted sensor in this slot.
    Servo(u8),
    /// Turns the right wheel, 0, or the left one, 1.
    Motor(u8),
}

/// What is asked of the far end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Request {
    /// Drive a line high or low.
    Drive(Line, bool),
    /// Tell whether a line is high: 1 or 0.
    Level(Line),
    /// Give a channel pulses of so many microseconds.
    Pulse(Channel, u16),
    /// Let so many nanoseconds pass; not answered.
    Pass(u32),
    /// Let time pass up to the start of this millisecond, unless it has begun; tell which it is.
    Until(u32),
    /// Tell the time in whole milliseconds.
    Tick,
    /// Tell the time in microseconds, modulo 2^32.
    Micros,
    /// The watchdog is fed.
    Feed,
    /// So many bytes of the stack were never used.
    Unused(u32),
}

/// The far end refused, or cannot be understood.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Refused;

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the far end did not do it")
    }
}

impl core::error::Error for Refused {}

/// Carries requests to the far end and brings its answers.
pub trait Link {
    /// Asks, and waits for the answer.
    ///
    /// # Errors
    ///
    /// [`Refused`] where the far end says no.
    fn ask(&self, request: Request) -> Result<u32, Refused>;

    /// Lets time pass, without waiting for an answer.
    fn pass(&self, nanoseconds: u32);

    /// Returns the far end's time in microseconds, modulo 2^32.
    ///
    /// Every answer tells it, and it holds until time is let pass again.
    fn micros(&self) -> u32;

    /// Hands over a frame of telemetry.
    fn report(&self, frame: &[u8]);
}

impl embedded_hal::digital::Error for Refused {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

impl pwm::Error for Refused {
    fn kind(&self) -> pwm::ErrorKind {
        pwm::ErrorKind::Other
    }
}

/// A line at the far end, which is driven or asked.
#[derive(Debug)]
pub struct RemotePin<'a, L> {
    link: &'a L,
    line: Line,
}

impl<'a, L> RemotePin<'a, L> {
    /// Creates the near end of `line`.
    pub const fn new(link: &'a L, line: Line) -> Self {
        Self { link, line }
    }
}

impl<L> ErrorType for RemotePin<'_, L> {
    type Error = Refused;
}

impl<L: Link> OutputPin for RemotePin<'_, L> {
    fn set_low(&mut self) -> Result<(), Refused> {
        self.link.ask(Request::Drive(self.line, false)).map(drop)
    }

    fn set_high(&mut self) -> Result<(), Refused> {
        self.link.ask(Request::Drive(self.line, true)).map(drop)
    }
}

impl<L: Link> InputPin for RemotePin<'_, L> {
    fn is_high(&mut self) -> Result<bool, Refused> {
        let level = self.link.ask(Request::Level(self.line))?;
        Ok(level != 0)
    }

    fn is_low(&mut self) -> Result<bool, Refused> {
        self.is_high().map(|high| !high)
    }
}

/// A channel's pulses at the far end; a duty step is a microsecond of 20 ms.
#[derive(Debug)]
pub struct RemotePwm<'a, L> {
    link: &'a L,
    channel: Channel,
}

impl<'a, L> RemotePwm<'a, L> {
    /// Creates the near end of the pulses of `channel`.
    pub const fn new(link: &'a L, channel: Channel) -> Self {
        Self { link, channel }
    }
}

impl<L> pwm::ErrorType for RemotePwm<'_, L> {
    type Error = Refused;
}

impl<L: Link> SetDutyCycle for RemotePwm<'_, L> {
    fn max_duty_cycle(&self) -> u16 {
        20_000
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Refused> {
        self.link.ask(Request::Pulse(self.channel, duty)).map(drop)
    }
}

/// The far end's time: waits, stopwatch and the schedule's clock.
#[derive(Debug)]
pub struct RemoteTime<'a, L> {
    link: &'a L,
}

impl<'a, L> RemoteTime<'a, L> {
    /// Creates the near end of time.
    pub const fn new(link: &'a L) -> Self {
        Self { link }
    }
}

impl<L: Link> DelayNs for RemoteTime<'_, L> {
    fn delay_ns(&mut self, ns: u32) {
        self.link.pass(ns);
    }
}

impl<L: Link> Stopwatch for RemoteTime<'_, L> {
    fn micros(&mut self) -> u32 {
        self.link.micros()
    }
}

/// Hands frames of telemetry to the far end.
#[derive(Debug)]
pub struct RemoteOutbox<'a, L> {
    link: &'a L,
}

impl<'a, L> RemoteOutbox<'a, L> {
    /// Creates the near end of the outbox.
    pub const fn new(link: &'a L) -> Self {
        Self { link }
    }
}

impl<L: Link> Outbox for RemoteOutbox<'_, L> {
    fn send(&mut self, frame: &[u8]) -> bool {
        self.link.report(frame);
        true
    }
}

/// A watchdog at the far end.
#[derive(Debug)]
pub struct RemoteWatchdog<'a, L> {
    link: &'a L,
}

impl<'a, L> RemoteWatchdog<'a, L> {
    /// Creates the near end of the watchdog.
    pub const fn new(link: &'a L) -> Self {
        Self { link }
    }
}

impl<L: Link> Watchdog for RemoteWatchdog<'_, L> {
    fn feed(&mut self) {
        // Refused food is what a hungry watchdog notices by itself.
        let _refused = self.link.ask(Request::Feed);
    }
}

/// The far end's milliseconds as the schedule's clock.
///
/// It is the tick interrupt too: every millisecond that passed, wherever it did, reaches the
/// dispatcher before the main loop looks at its queue again.
#[derive(Debug)]
pub struct RemoteClock<'a, 'q, L, const SLOTS: usize, const STATIONS: usize> {
    link: &'a L,
    dispatcher: Dispatcher<SLOTS, STATIONS>,
    queue: &'q DueQueue,
}

impl<'a, 'q, L: Link, const SLOTS: usize, const STATIONS: usize>
    RemoteClock<'a, 'q, L, SLOTS, STATIONS>
{
    /// Creates the clock, with the dispatcher that it drives.
    pub const fn new(
        link: &'a L,
        dispatcher: Dispatcher<SLOTS, STATIONS>,
        queue: &'q DueQueue,
    ) -> Self {
        Self {
            link,
            dispatcher,
            queue,
        }
    }

    /// Ticks up to and including `tick`, unless that has been.
    fn catch_up(&mut self, tick: u32) {
        let behind = tick.wrapping_sub(self.dispatcher.now().get());
        if behind < 1 << 31 {
            (0..behind).for_each(|_| self.dispatcher.tick(self.queue));
        }
    }
}

impl<L: Link, const SLOTS: usize, const STATIONS: usize> Clock
    for RemoteClock<'_, '_, L, SLOTS, STATIONS>
{
    fn now(&mut self) -> Ticks {
        if let Ok(tick) = self.link.ask(Request::Tick) {
            self.catch_up(tick);
        }
        self.dispatcher.now()
    }

    fn sleep(&mut self) {
        // Nothing is due before the next slot, so that nobody minds a longer sleep.
        let until = Request::Until(self.dispatcher.next_due().get());
        if let Ok(tick) = self.link.ask(until) {
            self.catch_up(tick);
        }
    }
}

/// A board whose every connection is at the far end of `L`.
#[derive(Debug)]
pub struct RemoteBoard<'a, L>(core::marker::PhantomData<&'a L>);

impl<'a, L: Link> Board for RemoteBoard<'a, L> {
    type Vin = RemotePin<'a, L>;
    type Vout = RemotePin<'a, L>;
    type Pwm = RemotePwm<'a, L>;
    type Motor = RemotePwm<'a, L>;
    type Trigger = RemotePin<'a, L>;
    type Echo = RemotePin<'a, L>;
    type Delay = RemoteTime<'a, L>;
    type Stopwatch = RemoteTime<'a, L>;
    type Outbox = RemoteOutbox<'a, L>;
}
