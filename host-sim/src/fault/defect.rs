//! What can be wrong with a sensor, and when.

use crate::quantity::{Percentage, SignedMillimeters};
use certainty_core::units::{Millimeters, Ticks};
use core::fmt;

/// What is wrong with a sensor while a fault is active.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Defect {
    /// It says *no object*, whatever is there.
    StuckFar,
    /// It says the same distance, whatever is there.
    StuckNear(Millimeters),
    /// It errs by a uniformly distributed distance, at most this part of its farthest one.
    ///
    /// Uniform, and of the range, not of the distance: an open choice that keeps the error bounded
    /// and tells it from the relative error of a sound sensor.
    Noise(Percentage),
    /// It errs as with [`Defect::Noise`], and *no object* counts as its farthest distance.
    ///
    /// The error is in the signal, which has a value where there is no object too: half of the time
    /// noise turns that into an echo.
    OutputNoise(Percentage),
    /// It errs by the same distance every time.
    Bias(SignedMillimeters),
    /// It multiplies every distance.
    Scale(Factor),
    /// It says a distance of its range, any of them equally likely.
    Random,
    /// It does not answer, this often.
    Dropout(Percentage),
    /// It reports this many times as often as it should.
    Chatter(Times),
}

/// A factor on distances.
///
/// Possession proves that it is finite, not negative and at most [`Factor::MOST`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factor(f64);

impl Factor {
    /// The largest factor.
    pub const MOST: f64 = 1000.0;

    /// Creates a factor; `None` outside 0..=1000 and for what is no number.
    #[must_use]
    pub fn try_new(factor: f64) -> Option<Self> {
        // Adding zero turns −0 into 0.
        (0.0..=Self::MOST)
            .contains(&factor)
            .then_some(Self(factor + 0.0))
    }

    /// Returns the factor.
    #[must_use]
    pub const fn get(self) -> f64 {
        self.0
    }
}

/// How many times as often.
///
/// Possession proves that it is from 2 to [`Times::MOST`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Times(u32);

impl Times {
    /// The most often that is accepted.
    pub const MOST: u32 = 1000;

    /// Creates a multiple; `None` outside 2..=1000.
    #[must_use]
    pub const fn try_new(times: u32) -> Option<Self> {
        if times >= 2 && times <= Self::MOST {
            Some(Self(times))
        } else {
            None
        }
    }

    /// Returns how many times.
    #[must_use]
    pub const fn get(self) -> u32 {
        self.0
    }
}

/// When a fault can be active; its start included, its end not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Window {
    /// From the first reading to the last.
    Always,
    /// By the sensor's own readings, counted from 0; no end where `to` is `None`.
    Readings {
        /// The first reading.
        from: u64,
        /// The first one after it.
        to: Option<u64>,
    },
    /// By the simulation's clock; no end where `to` is `None`.
    Times {
        /// The first instant.
        from: Ticks,
        /// The first one after it.
        to: Option<Ticks>,
    },
}

impl Window {
    /// Tells whether the sensor's reading number `reading`, taken `at`, is within.
    #[must_use]
    pub fn contains(&self, reading: u64, at: Ticks) -> bool {
        match *self {
            Self::Always => true,
            Self::Readings { from, to } => reading >= from && to.is_none_or(|to| reading < to),
            Self::Times { from, to } => {
                at.get() >= from.get() && to.is_none_or(|to| at.get() < to.get())
            }
        }
    }
}

/// A defect, when it can be active, and whether it comes and goes meanwhile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fault {
    /// What is wrong.
    pub defect: Defect,
    /// Whether it comes and goes, in [`Bursts`](super::Bursts).
    pub intermittent: bool,
    /// When.
    pub window: Window,
}

impl Fault {
    /// A defect that is there all the time.
    #[must_use]
    pub const fn permanent(defect: Defect) -> Self {
        Self {
            defect,
            intermittent: false,
            window: Window::Always,
        }
    }
}

impl Defect {
    /// Returns the name it has on a command line.
    #[must_use]
    pub const fn kind(&self) -> &'static str {
        match self {
            Self::StuckFar => "stuck-far",
            Self::StuckNear(_) => "stuck-near",
            Self::Noise(_) => "noise",
            Self::OutputNoise(_) => "output-noise",
            Self::Bias(_) => "bias",
            Self::Scale(_) => "scale",
            Self::Random => "random",
            Self::Dropout(_) => "dropout",
            Self::Chatter(_) => "chatter",
        }
    }

    /// Writes `between` and the value, if the defect has one.
    pub(super) fn write_value(&self, f: &mut fmt::Formatter<'_>, between: char) -> fmt::Result {
        match self {
            Self::StuckFar | Self::Random => Ok(()),
            Self::StuckNear(distance) => write!(f, "{between}{distance}"),
            Self::Noise(share) | Self::OutputNoise(share) | Self::Dropout(share) => {
                write!(f, "{between}{share}")
            }
            Self::Bias(by) => write!(f, "{between}{by}"),
            Self::Scale(factor) => write!(f, "{between}{}", factor.get()),
            Self::Chatter(times) => write!(f, "{between}{}", times.get()),
        }
    }
}

impl fmt::Display for Window {
    /// Writes `@FROM[..TO]`, or nothing for always.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Always => Ok(()),
            Self::Readings { from, to } => {
                write!(f, "@{from}")?;
                to.map_or(Ok(()), |to| write!(f, "..{to}"))
            }
            Self::Times { from, to } => {
                write!(f, "@{}ms", from.get())?;
                to.map_or(Ok(()), |to| write!(f, "..{}ms", to.get()))
            }
        }
    }
}
