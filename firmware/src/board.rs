//! What the Smart Car's application is wired to: a board as a list of types.

use crate::stopwatch::Stopwatch;
use crate::telemetry::Outbox;
use certainty_core::units::Ticks;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::pwm::SetDutyCycle;

/// A board that carries the Smart Car's sensors and motors: one type for each kind of connection.
///
/// The application is written against these alone; a microcontroller's pins, a simulator's and those
/// at the far end of a serial line all fit.
pub trait Board {
    /// The line that starts a GP2D02 and clocks its bits; open drain.
    type Vin: OutputPin;
    /// The line that a GP2D02 answers on; pulled down, so that an unplugged one reads low.
    type Vout: InputPin;
    /// A servo's pulses, every 20 ms.
    type Pwm: SetDutyCycle;
    /// The line that triggers a pulse-echo ranger.
    type Trigger: OutputPin;
    /// The line on which its echo's pulse comes back.
    type Echo: InputPin;
    /// A drive motor's pulses, every 20 ms; a new width counts from the next period on.
    type Motor: SetDutyCycle;
    /// Short waits within a slot.
    type Delay: DelayNs;
    /// What the width of an echo is measured with.
    type Stopwatch: Stopwatch;
    /// Where reports go.
    type Outbox: Outbox;
}

/// A pivoted infrared sensor's connections.
#[expect(
    missing_debug_implementations,
    reason = "a board's pins need not be printable"
)]
pub struct HeadWires<B: Board> {
    /// Starts it and clocks its bits.
    pub vin: B::Vin,
    /// What it answers.
    pub vout: B::Vout,
    /// Turns it.
    pub pwm: B::Pwm,
}

/// A fixed ultrasonic ranger's connections.
#[expect(
    missing_debug_implementations,
    reason = "a board's pins need not be printable"
)]
pub struct RangerWires<B: Board> {
    /// Triggers it.
    pub trigger: B::Trigger,
    /// What it answers.
    pub echo: B::Echo,
}

/// The drive motors' connections.
#[expect(
    missing_debug_implementations,
    reason = "a board's pins need not be printable"
)]
pub struct MotorWires<B: Board> {
    /// Turns the right wheel.
    pub right: B::Motor,
    /// Turns the left one.
    pub left: B::Motor,
}

/// Who started the application: whether anybody knows where the car is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Start {
    /// Somebody, by the supply or the reset pin.
    ByHand,
    /// Nobody: the watchdog, or the program itself.
    ByItself,
}

/// Everything that the application needs of a board.
#[expect(
    missing_debug_implementations,
    reason = "a board's pins need not be printable"
)]
pub struct Wiring<B: Board, const HEADS: usize, const RANGERS: usize> {
    /// The pivoted sensors, from right to left.
    pub heads: [HeadWires<B>; HEADS],
    /// The fixed ones.
    pub rangers: [RangerWires<B>; RANGERS],
    /// What the car drives with.
    pub motors: MotorWires<B>,
    /// Short waits within a slot.
    pub delay: B::Delay,
    /// What the width of an echo is measured with.
    pub stopwatch: B::Stopwatch,
    /// Where reports go.
    pub outbox: B::Outbox,
    /// Who started it.
    pub start: Start,
}

/// The schedule's clock, as the main loop sees it.
pub trait Clock {
    /// Returns the last tick that came.
    fn now(&mut self) -> Ticks;

    /// Sleeps until the next interrupt, the next tick at the latest.
    fn sleep(&mut self);
}

/// What resets the microcontroller unless it is fed in time.
pub trait Watchdog {
    /// Starts its time anew.
    fn feed(&mut self);
}
