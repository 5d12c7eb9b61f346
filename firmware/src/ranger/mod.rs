//! A pulse-echo ultrasonic ranger on two pins, as SRF04, SRF05 and HC-SR04 are.
//!
//! A pulse of 10 µs on Trigger sends a burst of sound; then Echo is high for as long as the sound is
//! under way, 58 µs a centimetre, or for some 40 ms where nothing came back. Echo is at 5 V: mind
//! the microcontroller's limits. The echoes of one burst fade in about 20 ms, which a schedule gives
//! them before the next.
//!
//! Everything is bounded, with a [`Stopwatch`] that stands still, too.

use crate::stopwatch::{Stopwatch, longest};
use certainty_core::transducer::{Missing, Reading};
use certainty_core::units::Millimeters;
use core::fmt;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{InputPin, OutputPin};

/// What sound takes for one centimetre there and back, in µs.
pub const US_PER_CM: u32 = 58;

/// The longest from the trigger to Echo's rise, in µs; a sound ranger needs under one ms.
pub const RISE_US: u32 = 5_000;

/// The longest pulse on Echo, in µs; that of a sound ranger that hears nothing has 36 to 40 ms.
pub const PULSE_US: u32 = 50_000;

/// The longest that [`Ranger::measure`] takes, in µs, with a sound stopwatch and each operation
/// within [`OPERATION_US`](crate::stopwatch::OPERATION_US).
pub const MEASURE_US: u32 =
    longest(ASK_OPERATIONS + 2 * EDGE_OPERATIONS, TRIGGER_US) + RISE_US + PULSE_US + 2 * TURN_US;

/// The longest that [`Ranger::measure`] takes, in µs, with a stopwatch that stands still, each
/// operation within [`OPERATION_US`](crate::stopwatch::OPERATION_US).
pub const MEASURE_BLIND_US: u32 = longest(ASK_OPERATIONS + 2 * EDGE_OPERATIONS, TRIGGER_US)
    + (RISE_US / POLL_US + PULSE_US / POLL_US + 2) * TURN_US;

/// Trigger high, in µs: 10 and a fifth for a clock that is fast.
const TRIGGER_US: u32 = 12;

/// Between two looks at Echo, in µs.
const POLL_US: u32 = 10;

/// The longest from one look at Echo to the next: the wait, its call, two looks.
const TURN_US: u32 = longest(3, POLL_US);

// A pulse is told to within one turn, which must be less than half a centimetre.
const _: () = assert!(TURN_US < US_PER_CM / 2);

/// A look at Echo, Trigger up, a wait, Trigger down.
const ASK_OPERATIONS: u32 = 4;

/// Looks at the stopwatch before the first look at Echo and after the last.
const EDGE_OPERATIONS: u32 = 2;

/// The distances between which one ranger can tell.
///
/// Possession proves that nearest is below farthest and that the farthest pulse is shorter than
/// [`PULSE_US`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RangerLimits {
    nearest: Millimeters,
    farthest: Millimeters,
}

/// Why a ranger's limits were refused.
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
            Self::EmptyRange => "the nearest distance must be below the farthest",
            Self::TooFar => "the farthest distance must be at most 6000 mm",
        })
    }
}

impl core::error::Error for RangerLimitsError {}

impl RangerLimits {
    /// The farthest that any ranger may be said to tell: its pulse of 35 ms is shorter than that of
    /// one that hears nothing.
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
    /// [`RangerLimitsError`] names what cannot be.
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

    /// Returns the shortest distance the ranger can tell.
    #[must_use]
    pub const fn nearest(&self) -> Millimeters {
        self.nearest
    }

    /// Returns the longest distance the ranger can tell.
    #[must_use]
    pub const fn farthest(&self) -> Millimeters {
        self.farthest
    }

    /// Returns what a pulse of `width_us` on Echo says.
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

/// What is wrong with a ranger or its two lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Fault {
    /// Echo is high before the trigger.
    StuckHigh,
    /// Echo did not rise within [`RISE_US`]: the ranger does not answer.
    NoAnswer,
    /// Echo did not fall within [`PULSE_US`].
    Endless,
    /// The stopwatch counted less than the waits between Echo's edges took.
    Stopwatch,
    /// The microcontroller's pin refused.
    Pin,
}

impl Fault {
    /// Returns what the fault makes of the reading.
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
            Self::StuckHigh => "Echo is high before the trigger",
            Self::NoAnswer => "Echo did not rise in time",
            Self::Endless => "Echo did not fall in time",
            Self::Stopwatch => "the stopwatch lost time",
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

/// When Echo changed, and after how many waits.
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

    /// Returns the distances between which the ranger can tell.
    #[must_use]
    pub const fn limits(&self) -> &RangerLimits {
        &self.limits
    }

    /// Measures once, to the nearest centimetre.
    ///
    /// Cost: at most [`MEASURE_US`]; [`MEASURE_BLIND_US`] where the stopwatch stands still.
    ///
    /// # Errors
    ///
    /// [`Fault`] says what is wrong; its reason is that of a missing reading. Trigger is low then,
    /// if its pin still obeys.
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
        // Each wait took its time. Half of it is far from what two clocks can differ by.
        if width_us < fall.waits.saturating_mul(POLL_US) / 2 {
            return Err(Fault::Stopwatch);
        }
        Ok(self.limits.reading(width_us))
    }

    /// Waits until Echo is `high`, for `limit_us` and no longer; by the count of waits, too, as no
    /// wait is shorter than it should be.
    fn edge(
        &mut self,
        high: bool,
        limit_us: u32,
        delay: &mut impl DelayNs,
        stopwatch: &mut impl Stopwatch,
    ) -> Result<Option<Edge>, Fault> {
        let from = stopwatch.micros();
        for waits in 0..=limit_us / POLL_US {
            let seen = self.echo_is_high()? == high;
            let at = stopwatch.micros();
            if seen {
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
mod tests;
