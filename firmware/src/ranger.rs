//! A pulse-echo ultrasonic ranger on two pins, such as SRF04, SRF05 or HC-SR04.
//!
//! A pulse of 10 µs on Trigger sends a burst of sound. Echo is then high for the time of flight, 58 µs a
//! centimetre, or for about 40 ms if no echo returns. Echo is at 5 V: check the microcontroller's limits.
//! The echoes of one burst fade in about 20 ms; a schedule must leave this time before the next burst.
//!
//! Every wait is bounded, even if the [`Stopwatch`] stands still.

use crate::timing::{Stopwatch, longest};
use certainty_core::transducer::{Missing, Reading};
use certainty_core::units::Millimeters;
use core::fmt;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{InputPin, OutputPin};

/// The time of flight for one centimetre, there and back, in µs.
pub const US_PER_CM: u32 = 58;

/// The longest time from the trigger to Echo's rise, in µs; a working ranger needs less than 1 ms.
pub const RISE_US: u32 = 5_000;

/// The longest pulse on Echo, in µs; without an echo a working ranger's pulse has 36 to 40 ms.
pub const PULSE_US: u32 = 50_000;

/// The longest that [`Ranger::measure`] takes, in µs, with a working stopwatch and each operation
/// within [`OPERATION_US`](crate::timing::OPERATION_US).
pub const MEASURE_US: u32 = longest(TRIGGER_OPERATIONS + 2 * EDGE_OPERATIONS, TRIGGER_US)
    + RISE_US
    + PULSE_US
    + 2 * TURN_US;

/// The longest that [`Ranger::measure`] takes, in µs, with a stopwatch that stands still and each
/// operation within [`OPERATION_US`](crate::timing::OPERATION_US).
pub const MEASURE_BLIND_US: u32 = longest(TRIGGER_OPERATIONS + 2 * EDGE_OPERATIONS, TRIGGER_US)
    + (RISE_US / POLL_US + PULSE_US / POLL_US + 2) * TURN_US;

/// The time that Trigger is high, in µs: 10 plus 20 % for a fast clock.
const TRIGGER_US: u32 = 12;

/// The time between two samples of Echo, in µs.
const POLL_US: u32 = 10;

/// The longest time from one sample of Echo to the next: the wait, its call, two samples.
const TURN_US: u32 = longest(3, POLL_US);

// A pulse is measured to within one turn, which must be less than half a centimetre.
const _: () = assert!(TURN_US < US_PER_CM / 2);

/// A sample of Echo, Trigger up, a wait, Trigger down.
const TRIGGER_OPERATIONS: u32 = 4;

/// Readings of the stopwatch before the first sample of Echo and after the last.
const EDGE_OPERATIONS: u32 = 2;

/// The range of distances that a ranger measures.
///
/// A value of this type proves that nearest is below farthest and that the farthest pulse is shorter than
/// [`PULSE_US`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RangerLimits {
    nearest: Millimeters,
    farthest: Millimeters,
}

/// Which of a ranger's limits is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RangerLimitsError {
    /// The nearest distance is not below the farthest.
    EmptyRange,
    /// The farthest distance is above [`RangerLimits::FARTHEST`].
    TooFar,
}

impl fmt::Display for RangerLimitsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::EmptyRange => "bad limits: expected nearest < farthest",
            Self::TooFar => "bad farthest distance: expected at most 6000 mm",
        })
    }
}

impl core::error::Error for RangerLimitsError {}

impl RangerLimits {
    /// The largest farthest distance: its pulse of 35 ms is shorter than the one without an echo.
    pub const FARTHEST: Millimeters = Millimeters::new(6_000);

    /// A Devantech SRF04: 3 cm to 3 m.
    pub const SRF04: Self = Self {
        nearest: Millimeters::new(30),
        farthest: Millimeters::new(3_000),
    };

    /// Creates limits.
    ///
    /// # Errors
    ///
    /// [`RangerLimitsError`] names the limit that is out of range.
    pub const fn try_new(
        nearest: Millimeters,
        farthest: Millimeters,
    ) -> Result<Self, RangerLimitsError> {
        if nearest.get() >= farthest.get() {
            return Err(RangerLimitsError::EmptyRange);
        }
        if farthest.get() > Self::FARTHEST.get() {
            return Err(RangerLimitsError::TooFar);
        }
        Ok(Self { nearest, farthest })
    }

    /// Returns the shortest distance that the ranger measures.
    #[must_use]
    pub const fn nearest(&self) -> Millimeters {
        self.nearest
    }

    /// Returns the longest distance that the ranger measures.
    #[must_use]
    pub const fn farthest(&self) -> Millimeters {
        self.farthest
    }

    /// Returns the reading for a pulse of `width_us` on Echo.
    ///
    /// Formula: width / 58 µs, in centimetres. Rounds to the nearest, ties up.
    ///
    /// ```
    /// use certainty_core::transducer::Reading;
    /// use certainty_core::units::Millimeters;
    /// use certainty_firmware::ranger::RangerLimits;
    ///
    /// let reading = |us| RangerLimits::SRF04.reading(us);
    /// assert_eq!(reading(5_800), Reading::Echo(Millimeters::new(1_000)));
    /// assert_eq!(reading(36_000), Reading::NoObject);
    /// assert_eq!(reading(100), Reading::TooNear);
    /// ```
    #[must_use]
    pub const fn reading(&self, width_us: u32) -> Reading {
        let centimeters = width_us.saturating_add(US_PER_CM / 2) / US_PER_CM;
        let distance = Millimeters::new(centimeters.saturating_mul(10));
        if distance.get() < self.nearest.get() {
            Reading::TooNear
        } else if distance.get() > self.farthest.get() {
            Reading::NoObject
        } else {
            Reading::Echo(distance)
        }
    }
}

/// Why a ranger gave no reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Fault {
    /// Echo is high before the trigger.
    StuckHigh,
    /// Echo did not rise within [`RISE_US`].
    NoAnswer,
    /// Echo did not fall within [`PULSE_US`].
    Endless,
    /// The stopwatch counted less than the time of the waits between Echo's edges.
    Stopwatch,
    /// A pin returned an error.
    Pin,
}

impl Fault {
    /// Returns the reason of the missing reading.
    #[must_use]
    pub const fn reason(self) -> Missing {
        match self {
            Self::NoAnswer | Self::Endless => Missing::Timeout,
            Self::StuckHigh | Self::Pin => Missing::Bus,
            Self::Stopwatch => Missing::Implausible,
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::StuckHigh => "Echo is high before the trigger: expected low",
            Self::NoAnswer => "Echo did not rise within 5 ms of the trigger",
            Self::Endless => "Echo did not fall within 50 ms",
            Self::Stopwatch => "the stopwatch counted less time than was waited",
            Self::Pin => "the pin failed",
        })
    }
}

impl core::error::Error for Fault {}

/// The driver of a ranger: `Trigger` is an output, `Echo` an input with a pull-down.
#[derive(Debug)]
pub struct Ranger<Trigger, Echo> {
    trigger: Trigger,
    echo: Echo,
    limits: RangerLimits,
}

/// When Echo changed and after how many waits.
struct Edge {
    at: u32,
    waits: u32,
}

impl<Trigger: OutputPin, Echo: InputPin> Ranger<Trigger, Echo> {
    /// Creates the driver of a ranger whose Trigger is low.
    #[must_use]
    pub const fn new(trigger: Trigger, echo: Echo, limits: RangerLimits) -> Self {
        Self {
            trigger,
            echo,
            limits,
        }
    }

    /// Returns the pins.
    #[must_use]
    pub fn release(self) -> (Trigger, Echo) {
        (self.trigger, self.echo)
    }

    /// Returns the range of distances that the ranger measures.
    #[must_use]
    pub const fn limits(&self) -> &RangerLimits {
        &self.limits
    }

    /// Measures once, to the nearest centimetre.
    ///
    /// Cost: at most [`MEASURE_US`]; [`MEASURE_BLIND_US`] if the stopwatch stands still.
    ///
    /// # Errors
    ///
    /// [`Fault`]; [`Fault::reason`] gives the reason of the missing reading. Trigger is low afterwards unless
    /// its pin failed.
    pub fn measure(
        &mut self,
        delay: &mut impl DelayNs,
        stopwatch: &mut impl Stopwatch,
    ) -> Result<Reading, Fault> {
        if self.echo_is_high()? {
            return Err(Fault::StuckHigh);
        }
        self.trigger.set_high().map_err(|_| Fault::Pin)?;
        delay.delay_us(TRIGGER_US);
        self.trigger.set_low().map_err(|_| Fault::Pin)?;
        let rise = self
            .edge(true, RISE_US, delay, stopwatch)?
            .ok_or(Fault::NoAnswer)?;
        let fall = self
            .edge(false, PULSE_US, delay, stopwatch)?
            .ok_or(Fault::Endless)?;
        let width_us = fall.at.wrapping_sub(rise.at);
        // The waits took at least their time; two clocks never differ by half of it.
        if width_us < fall.waits.saturating_mul(POLL_US) / 2 {
            return Err(Fault::Stopwatch);
        }
        Ok(self.limits.reading(width_us))
    }

    /// Waits until Echo is `high`, at most `limit_us` by the stopwatch and by the number of waits, so that
    /// a stopwatch that stands still ends the loop too.
    fn edge(
        &mut self,
        high: bool,
        limit_us: u32,
        delay: &mut impl DelayNs,
        stopwatch: &mut impl Stopwatch,
    ) -> Result<Option<Edge>, Fault> {
        let from = stopwatch.micros();
        for waits in 0..=limit_us / POLL_US {
            let changed = self.echo_is_high()? == high;
            let at = stopwatch.micros();
            if changed {
                return Ok(Some(Edge { at, waits }));
            }
            if at.wrapping_sub(from) > limit_us {
                break;
            }
            delay.delay_us(POLL_US);
        }
        Ok(None)
    }

    fn echo_is_high(&mut self) -> Result<bool, Fault> {
        self.echo.is_high().map_err(|_| Fault::Pin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_hal_mock::eh1::MockError;
    use embedded_hal_mock::eh1::delay::{CheckedDelay, NoopDelay, Transaction as Wait};
    use embedded_hal_mock::eh1::digital::{Mock as Pin, State as Level, Transaction as PinStep};
    use std::io::ErrorKind;

    /// A stopwatch that returns these values in their order.
    struct Scripted(Vec<u32>);

    impl Stopwatch for Scripted {
        fn micros(&mut self) -> u32 {
            self.0.remove(0)
        }
    }

    struct Frozen;

    impl Stopwatch for Frozen {
        fn micros(&mut self) -> u32 {
            7
        }
    }

    fn pulse() -> [PinStep; 2] {
        [PinStep::set(Level::High), PinStep::set(Level::Low)]
    }

    fn samples(levels: &[(u32, Level)]) -> Pin {
        let mut steps = Vec::new();
        for &(times, level) in levels {
            steps.extend((0..times).map(|_| PinStep::get(level)));
        }
        Pin::new(&steps)
    }

    fn measured(
        ranger: Ranger<Pin, Pin>,
        waits: u32,
        stopwatch: &mut impl Stopwatch,
    ) -> Result<Reading, Fault> {
        let mut ranger = ranger;
        let mut steps = vec![Wait::delay_us(12)];
        steps.extend((0..waits).map(|_| Wait::delay_us(10)));
        let mut delay = CheckedDelay::new(&steps);
        let result = ranger.measure(&mut delay, stopwatch);
        delay.done();
        let (mut trigger, mut echo) = ranger.release();
        trigger.done();
        echo.done();
        result
    }

    fn ranger(echo: Pin) -> Ranger<Pin, Pin> {
        Ranger::new(Pin::new(&pulse()), echo, RangerLimits::SRF04)
    }

    #[test]
    fn the_pulse_gives_the_distance_across_a_wrap() {
        let echo = samples(&[(1 + 2, Level::Low), (1 + 3, Level::High), (1, Level::Low)]);
        let start = u32::MAX - 30;
        let mut stopwatch = Scripted(
            [0, 10, 20, 40, 40, 51, 62, 73, 40 + 290]
                .map(|us| start.wrapping_add(us))
                .to_vec(),
        );
        // Low at 10 and 20, high at 40; then high at 51, 62 and 73, low at 330: 290 µs are 5 cm.
        let reading = measured(ranger(echo), 2 + 3, &mut stopwatch);
        assert_eq!(reading, Ok(Reading::Echo(Millimeters::new(50))));
        assert!(stopwatch.0.is_empty());
    }

    #[test]
    fn echo_high_before_the_trigger_is_stuck_high() {
        let mut ranger = Ranger::new(
            Pin::new(&[]),
            samples(&[(1, Level::High)]),
            RangerLimits::SRF04,
        );
        let result = ranger.measure(&mut NoopDelay::new(), &mut Frozen);
        assert_eq!(result, Err(Fault::StuckHigh));
        let (mut trigger, mut echo) = ranger.release();
        trigger.done();
        echo.done();
    }

    #[test]
    fn no_rise_ends_by_the_stopwatch() {
        let echo = samples(&[(1 + 2, Level::Low)]);
        let mut stopwatch = Scripted(vec![100, 5_100, 5_101]);
        let reading = measured(ranger(echo), 1, &mut stopwatch);
        assert_eq!(reading, Err(Fault::NoAnswer));
    }

    #[test]
    fn no_fall_ends_by_the_stopwatch() {
        let echo = samples(&[(1, Level::Low), (1 + 2, Level::High)]);
        let mut stopwatch = Scripted(vec![0, 10, 20, 50_020, 50_021]);
        let reading = measured(ranger(echo), 1, &mut stopwatch);
        assert_eq!(reading, Err(Fault::Endless));
    }

    #[test]
    fn a_frozen_stopwatch_bounds_the_wait_too() {
        // 5 and 50 ms in waits of 10 µs, and a last sample after each.
        let echo = samples(&[(1 + 501, Level::Low)]);
        assert_eq!(
            measured(ranger(echo), 501, &mut Frozen),
            Err(Fault::NoAnswer)
        );
        let echo = samples(&[(1, Level::Low), (1 + 5_001, Level::High)]);
        assert_eq!(
            measured(ranger(echo), 5_001, &mut Frozen),
            Err(Fault::Endless)
        );
        // 501 and 5001 turns of 25 µs and what is around them: under a seventh of a second.
        assert!((137_550..138_000).contains(&MEASURE_BLIND_US));
    }

    #[test]
    fn a_frozen_stopwatch_gives_no_distance() {
        let echo = samples(&[(1, Level::Low), (1 + 100, Level::High), (1, Level::Low)]);
        assert_eq!(
            measured(ranger(echo), 100, &mut Frozen),
            Err(Fault::Stopwatch)
        );
    }

    #[test]
    fn a_pin_error_is_a_fault() {
        let pin_error = || MockError::Io(ErrorKind::NotConnected);
        let echo = Pin::new(&[PinStep::get(Level::Low).with_error(pin_error())]);
        let mut echo_fails = Ranger::new(Pin::new(&[]), echo, RangerLimits::SRF04);
        let result = echo_fails.measure(&mut NoopDelay::new(), &mut Frozen);
        assert_eq!(result, Err(Fault::Pin));
        let (mut trigger, mut echo) = echo_fails.release();
        trigger.done();
        echo.done();

        let trigger = Pin::new(&[PinStep::set(Level::High).with_error(pin_error())]);
        let mut trigger_fails =
            Ranger::new(trigger, samples(&[(1, Level::Low)]), RangerLimits::SRF04);
        let result = trigger_fails.measure(&mut NoopDelay::new(), &mut Frozen);
        assert_eq!(result, Err(Fault::Pin));
        let (mut trigger, mut echo) = trigger_fails.release();
        trigger.done();
        echo.done();
    }

    #[test]
    fn pulses_round_to_the_nearest_centimetre() {
        let limits = RangerLimits::SRF04;
        for centimeter in 3..=300_u32 {
            let exact = centimeter * 58;
            let expected = Reading::Echo(Millimeters::new(centimeter * 10));
            for width in exact - 29..exact + 29 {
                assert_eq!(limits.reading(width), expected);
            }
        }
        assert_eq!(limits.reading(3 * 58 - 30), Reading::TooNear);
        assert_eq!(limits.reading(300 * 58 + 29), Reading::NoObject);
        assert_eq!(limits.reading(u32::MAX), Reading::NoObject);
        assert_eq!(limits.reading(0), Reading::TooNear);
    }

    #[test]
    fn bad_limits_are_refused() {
        let limits =
            |near, far| RangerLimits::try_new(Millimeters::new(near), Millimeters::new(far));
        assert_eq!(limits(30, 30), Err(RangerLimitsError::EmptyRange));
        assert_eq!(limits(30, 6_001), Err(RangerLimitsError::TooFar));
        assert_eq!(limits(30, 3_000), Ok(RangerLimits::SRF04));
        assert!(RangerLimits::FARTHEST.get() / 10 * US_PER_CM < 36_000);
    }

    #[test]
    fn each_fault_has_the_reason_of_its_kind() {
        assert_eq!(Fault::NoAnswer.reason(), Missing::Timeout);
        assert_eq!(Fault::Endless.reason(), Missing::Timeout);
        assert_eq!(Fault::StuckHigh.reason(), Missing::Bus);
        assert_eq!(Fault::Pin.reason(), Missing::Bus);
        assert_eq!(Fault::Stopwatch.reason(), Missing::Implausible);
    }
}
