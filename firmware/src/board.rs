//! The interface between the application and a board: a list of types and two traits.

use crate::telemetry::Outbox;
use crate::timing::Stopwatch;
use certainty_core::units::Ticks;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::pwm::SetDutyCycle;

/// A board with the Smart Car's sensors and motors: one type for each kind of connection.
///
/// The application uses these types only, so it runs on a microcontroller's pins, on a simulator's and on
/// pins at the far end of a serial line.
pub trait Board {
    /// The line that starts a GP2D02 and clocks its bits; open drain.
    type Vin: OutputPin;
    /// The output of a GP2D02; pulled down, so that an unplugged sensor reads low.
    type Vout: InputPin;
    /// A servo's pulses, every 20 ms.
    type Pwm: SetDutyCycle;
    /// The line that triggers a pulse-echo ranger.
    type Trigger: OutputPin;
    /// The line on which the ranger returns its echo pulse.
    type Echo: InputPin;
    /// A drive motor's pulses, every 20 ms; a new width takes effect in the next period.
    type Motor: SetDutyCycle;
    /// Short waits within a slot.
    type Delay: DelayNs;
    /// Measures the width of an echo pulse.
    type Stopwatch: Stopwatch;
    /// Takes the telemetry frames.
    type Outbox: Outbox;
}

/// A pivoted infrared sensor's connections.
#[expect(
    missing_debug_implementations,
    reason = "a board's pins need not implement Debug"
)]
pub struct HeadWires<B: Board> {
    /// Starts the sensor and clocks its bits.
    pub vin: B::Vin,
    /// The sensor's output.
    pub vout: B::Vout,
    /// Turns the servo.
    pub pwm: B::Pwm,
}

/// A fixed ultrasonic ranger's connections.
#[expect(
    missing_debug_implementations,
    reason = "a board's pins need not implement Debug"
)]
pub struct RangerWires<B: Board> {
    /// Triggers the ranger.
    pub trigger: B::Trigger,
    /// The ranger's output.
    pub echo: B::Echo,
}

/// The drive motors' connections.
#[expect(
    missing_debug_implementations,
    reason = "a board's pins need not implement Debug"
)]
pub struct MotorWires<B: Board> {
    /// Turns the right wheel.
    pub right: B::Motor,
    /// Turns the left one.
    pub left: B::Motor,
}

/// What started the application.
///
/// After a manual reset a person has put the car at its start pose. After an automatic one the pose is
/// unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ResetCause {
    /// The supply was switched on, or the reset pin was used.
    Manual,
    /// The watchdog, the program or a low-power mode reset the microcontroller.
    Automatic,
}

/// Everything that the application needs from a board.
#[expect(
    missing_debug_implementations,
    reason = "a board's pins need not implement Debug"
)]
pub struct Wiring<B: Board, const HEADS: usize, const RANGERS: usize> {
    /// The pivoted sensors, from right to left.
    pub heads: [HeadWires<B>; HEADS],
    /// The fixed rangers, from right to left.
    pub rangers: [RangerWires<B>; RANGERS],
    /// The drive motors.
    pub motors: MotorWires<B>,
    /// Short waits within a slot.
    pub delay: B::Delay,
    /// Measures the width of an echo pulse.
    pub stopwatch: B::Stopwatch,
    /// Takes the telemetry frames.
    pub outbox: B::Outbox,
    /// What started the application.
    pub reset_cause: ResetCause,
}

/// The schedule's clock.
pub trait Clock {
    /// Returns the last tick.
    fn now(&mut self) -> Ticks;

    /// Sleeps until the next interrupt, at most until the next tick.
    fn sleep(&mut self);
}

/// A timer that resets the microcontroller unless it is fed in time.
pub trait Watchdog {
    /// Restarts the timer.
    fn feed(&mut self);
}
