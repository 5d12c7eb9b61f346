//! Pins, pulses and time at the far end of a link.
//!
//! For machines without pins, such as a simulator or an emulator: each embedded-hal call becomes a
//! [`Request`]. The far end simulates time, world and sensors; it answers each request before the
//! application continues, so both run in lock-step. A [`Link`] carries the requests, over a serial line or
//! as function calls.

use crate::board::{Board, Clock, Watchdog};
use crate::executive::{Dispatcher, DueQueue};
use crate::telemetry::Outbox;
use crate::timing::Stopwatch;
use certainty_core::units::Ticks;
use core::fmt;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{ErrorKind, ErrorType, InputPin, OutputPin};
use embedded_hal::pwm::{self, SetDutyCycle};

/// A line between the board and a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Line {
    /// Input of the pivoted sensor in this slot: starts it and clocks its bits.
    Vin(u8),
    /// Output of the pivoted sensor in this slot.
    Vout(u8),
    /// Input of the ranger in this slot.
    Trigger(u8),
    /// Output of the ranger in this slot.
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

/// A request to the far end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Request {
    /// Drive a line high or low.
    Drive(Line, bool),
    /// Read a line: 1 for high, 0 for low.
    Level(Line),
    /// Set a channel's pulses to this width in µs.
    Pulse(Channel, u16),
    /// Let this many nanoseconds pass; has no answer.
    Pass(u32),
    /// Let time pass until this millisecond begins, unless it has; returns the current millisecond.
    Until(u32),
    /// Return the time in whole milliseconds.
    Tick,
    /// Return the time in microseconds, modulo 2^32.
    Micros,
    /// Feed the watchdog.
    Feed,
    /// Report how many bytes of the stack were never used.
    Unused(u32),
}

/// The far end refused a request, or its answer is invalid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RequestRefused;

impl fmt::Display for RequestRefused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the far end refused the request or its answer is invalid")
    }
}

impl core::error::Error for RequestRefused {}

/// Carries requests to the far end and brings its answers.
pub trait Link {
    /// Sends a request and waits for its answer.
    ///
    /// # Errors
    ///
    /// [`RequestRefused`] if the far end refuses.
    fn request(&self, request: Request) -> Result<u32, RequestRefused>;

    /// Lets time pass; does not wait for an answer.
    fn pass(&self, nanoseconds: u32);

    /// Returns the far end's time in microseconds, modulo 2^32.
    ///
    /// Every answer contains it; it is valid until [`Link::pass`] is called.
    fn micros(&self) -> u32;

    /// Sends a frame of telemetry.
    fn report(&self, frame: &[u8]);
}

impl embedded_hal::digital::Error for RequestRefused {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

impl pwm::Error for RequestRefused {
    fn kind(&self) -> pwm::ErrorKind {
        pwm::ErrorKind::Other
    }
}

/// A line at the far end, as output or input.
#[derive(Debug)]
pub struct RemotePin<'a, L> {
    link: &'a L,
    line: Line,
}

impl<'a, L> RemotePin<'a, L> {
    /// Creates the pin of `line`.
    pub const fn new(link: &'a L, line: Line) -> Self {
        Self { link, line }
    }
}

impl<L> ErrorType for RemotePin<'_, L> {
    type Error = RequestRefused;
}

impl<L: Link> OutputPin for RemotePin<'_, L> {
    fn set_low(&mut self) -> Result<(), RequestRefused> {
        self.link
            .request(Request::Drive(self.line, false))
            .map(drop)
    }

    fn set_high(&mut self) -> Result<(), RequestRefused> {
        self.link.request(Request::Drive(self.line, true)).map(drop)
    }
}

impl<L: Link> InputPin for RemotePin<'_, L> {
    fn is_high(&mut self) -> Result<bool, RequestRefused> {
        let level = self.link.request(Request::Level(self.line))?;
        Ok(level != 0)
    }

    fn is_low(&mut self) -> Result<bool, RequestRefused> {
        self.is_high().map(|high| !high)
    }
}

/// A pulse channel at the far end; a duty step is a microsecond of 20 ms.
#[derive(Debug)]
pub struct RemotePwm<'a, L> {
    link: &'a L,
    channel: Channel,
}

impl<'a, L> RemotePwm<'a, L> {
    /// Creates the PWM output of `channel`.
    pub const fn new(link: &'a L, channel: Channel) -> Self {
        Self { link, channel }
    }
}

impl<L> pwm::ErrorType for RemotePwm<'_, L> {
    type Error = RequestRefused;
}

impl<L: Link> SetDutyCycle for RemotePwm<'_, L> {
    fn max_duty_cycle(&self) -> u16 {
        20_000
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), RequestRefused> {
        self.link
            .request(Request::Pulse(self.channel, duty))
            .map(drop)
    }
}

/// The far end's time, for waits and as a stopwatch.
#[derive(Debug)]
pub struct RemoteTime<'a, L> {
    link: &'a L,
}

impl<'a, L> RemoteTime<'a, L> {
    /// Creates it.
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

/// Sends frames of telemetry to the far end.
#[derive(Debug)]
pub struct RemoteOutbox<'a, L> {
    link: &'a L,
}

impl<'a, L> RemoteOutbox<'a, L> {
    /// Creates it.
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
    /// Creates it.
    pub const fn new(link: &'a L) -> Self {
        Self { link }
    }
}

impl<L: Link> Watchdog for RemoteWatchdog<'_, L> {
    fn feed(&mut self) {
        // If this fails, the watchdog is not fed and resets, as it should.
        let _ = self.link.request(Request::Feed);
    }
}

/// The schedule's clock, driven by the far end's milliseconds.
///
/// It replaces the tick interrupt: before the main loop reads its queue, the dispatcher gets a tick for
/// every millisecond that has passed.
#[derive(Debug)]
pub struct RemoteClock<'a, 'q, L, const SLOTS: usize, const STATIONS: usize> {
    link: &'a L,
    dispatcher: Dispatcher<SLOTS, STATIONS>,
    queue: &'q DueQueue,
}

impl<'a, 'q, L: Link, const SLOTS: usize, const STATIONS: usize>
    RemoteClock<'a, 'q, L, SLOTS, STATIONS>
{
    /// Creates the clock with the dispatcher that it drives.
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

    /// Drives the dispatcher up to and including `tick`, unless that is past.
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
        if let Ok(tick) = self.link.request(Request::Tick) {
            self.catch_up(tick);
        }
        self.dispatcher.now()
    }

    fn sleep(&mut self) {
        // No slot is due before `next_due`, so one long sleep replaces many short ones.
        let until = Request::Until(self.dispatcher.next_due().get());
        if let Ok(tick) = self.link.request(until) {
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

/// The wire form of requests and answers.
pub mod wire {
    use super::{Channel, Line, Request, RequestRefused};

    /// Bytes of a request: its kind, its place, its value with the lowest byte first.
    pub const REQUEST: usize = 6;

    /// Bytes of an answer: [`YES`] or [`NO`], its value and the time in microseconds, both with the
    /// lowest byte first.
    pub const ANSWER: usize = 9;

    /// First byte of an answer: the request was carried out.
    pub const YES: u8 = b'+';

    /// First byte of an answer: the request was refused.
    pub const NO: u8 = b'-';

    /// In place of a request's kind: the next byte is the length of a telemetry frame that follows; it has
    /// no answer.
    pub const REPORT: u8 = b'#';

    /// The kind of [`Request::Feed`], with which a round ends.
    pub const FEED: u8 = b'F';

    const fn line(line: Line) -> (u8, u8) {
        match line {
            Line::Vin(slot) => (b'i', slot),
            Line::Vout(slot) => (b'o', slot),
            Line::Trigger(slot) => (b't', slot),
            Line::Echo(slot) => (b'e', slot),
        }
    }

    /// Encodes a request.
    ///
    /// A line's letter is lower case to read it and upper case to drive it.
    #[must_use]
    pub fn encode(request: Request) -> [u8; REQUEST] {
        let (kind, place, value) = match request {
            Request::Drive(at, high) => {
                let (letter, slot) = line(at);
                (letter.to_ascii_uppercase(), slot, u32::from(high))
            }
            Request::Level(at) => {
                let (letter, slot) = line(at);
                (letter, slot, 0)
            }
            Request::Pulse(Channel::Servo(slot), micros) => (b'P', slot, u32::from(micros)),
            Request::Pulse(Channel::Motor(side), micros) => (b'M', side, u32::from(micros)),
            Request::Pass(nanoseconds) => (b'D', 0, nanoseconds),
            Request::Until(tick) => (b'N', 0, tick),
            Request::Tick => (b'n', 0, 0),
            Request::Micros => (b'u', 0, 0),
            Request::Feed => (FEED, 0, 0),
            Request::Unused(bytes) => (b'S', 0, bytes),
        };
        let [a, b, c, d] = value.to_le_bytes();
        [kind, place, a, b, c, d]
    }

    /// Decodes a request; `None` if the bytes are not one.
    #[must_use]
    pub fn decode([kind, place, a, b, c, d]: [u8; REQUEST]) -> Option<Request> {
        let value = u32::from_le_bytes([a, b, c, d]);
        let line = |letter: u8| match letter {
            b'i' => Some(Line::Vin(place)),
            b'o' => Some(Line::Vout(place)),
            b't' => Some(Line::Trigger(place)),
            b'e' => Some(Line::Echo(place)),
            _ => None,
        };
        Some(match kind {
            b'P' => Request::Pulse(Channel::Servo(place), u16::try_from(value).ok()?),
            b'M' => Request::Pulse(Channel::Motor(place), u16::try_from(value).ok()?),
            b'D' => Request::Pass(value),
            b'N' => Request::Until(value),
            b'n' => Request::Tick,
            b'u' => Request::Micros,
            FEED => Request::Feed,
            b'S' => Request::Unused(value),
            b'i' | b'o' | b't' | b'e' => Request::Level(line(kind)?),
            _ => Request::Drive(line(kind.to_ascii_lowercase())?, value != 0),
        })
    }

    /// Encodes an answer and the time in microseconds.
    #[must_use]
    pub fn encode_answer(answer: Result<u32, RequestRefused>, micros: u32) -> [u8; ANSWER] {
        let (kind, value) = match answer {
            Ok(value) => (YES, value),
            Err(RequestRefused) => (NO, 0),
        };
        let [a, b, c, d] = value.to_le_bytes();
        let [e, f, g, h] = micros.to_le_bytes();
        [kind, a, b, c, d, e, f, g, h]
    }

    /// Decodes an answer and its time; invalid bytes are a refusal.
    pub const fn decode_answer(bytes: [u8; ANSWER]) -> (Result<u32, RequestRefused>, u32) {
        let [kind, a, b, c, d, e, f, g, h] = bytes;
        let answer = if kind == YES {
            Ok(u32::from_le_bytes([a, b, c, d]))
        } else {
            Err(RequestRefused)
        };
        (answer, u32::from_le_bytes([e, f, g, h]))
    }
}

#[cfg(test)]
mod tests {
    use super::wire::{
        ANSWER, FEED, REPORT, REQUEST, decode, decode_answer, encode, encode_answer,
    };
    use super::*;
    use proptest::prelude::*;

    fn lines() -> impl Strategy<Value = Line> {
        (0..4, any::<u8>()).prop_map(|(kind, slot)| match kind {
            0 => Line::Vin(slot),
            1 => Line::Vout(slot),
            2 => Line::Trigger(slot),
            _ => Line::Echo(slot),
        })
    }

    fn channels() -> impl Strategy<Value = Channel> {
        any::<(bool, u8)>().prop_map(|(motor, place)| {
            if motor {
                Channel::Motor(place)
            } else {
                Channel::Servo(place)
            }
        })
    }

    fn requests() -> impl Strategy<Value = Request> {
        prop_oneof![
            (lines(), any::<bool>()).prop_map(|(line, high)| Request::Drive(line, high)),
            lines().prop_map(Request::Level),
            (channels(), any::<u16>())
                .prop_map(|(channel, micros)| Request::Pulse(channel, micros)),
            any::<u32>().prop_map(Request::Pass),
            any::<u32>().prop_map(Request::Until),
            Just(Request::Tick),
            Just(Request::Micros),
            Just(Request::Feed),
            any::<u32>().prop_map(Request::Unused),
        ]
    }

    proptest! {
        #[test]
        fn requests_round_trip_and_never_look_like_reports(request in requests()) {
            let bytes = encode(request);
            prop_assert_eq!(decode(bytes), Some(request));
            prop_assert_ne!(bytes[0], REPORT);
            prop_assert_eq!(bytes[0] == FEED, request == Request::Feed);
        }

        #[test]
        fn any_bytes_are_a_valid_request_or_none(bytes in any::<[u8; REQUEST]>()) {
            if let Some(request) = decode(bytes) {
                prop_assert_eq!(decode(encode(request)), Some(request));
            }
        }

        #[test]
        fn answers_round_trip_with_their_time(value in any::<u32>(), micros in any::<u32>()) {
            for answer in [Ok(value), Err(RequestRefused)] {
                let bytes = encode_answer(answer, micros);
                prop_assert_eq!(decode_answer(bytes), (answer, micros));
            }
        }
    }

    #[test]
    fn an_invalid_answer_is_a_refusal() {
        assert_eq!(decode_answer([b'?'; ANSWER]).0, Err(RequestRefused));
    }
}
