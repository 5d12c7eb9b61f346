//! Defects of a sensor, and when they are active.

use crate::quantity::{Percentage, SignedMillimeters};
use certainty_core::units::{Millimeters, Ticks};
use core::fmt;

/// What a fault does to readings while it is active.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Defect {
    /// Every reading is *no object*.
    StuckFar,
    /// Every reading is this distance.
    StuckNear(Millimeters),
    /// Distances have a uniformly distributed error, at most this part of the farthest distance.
    ///
    /// Uniform, and relative to the range, not to the distance: an open choice that keeps the error
    /// bounded and different from the relative error of a sound sensor.
    Noise(Percentage),
    /// The error of [`Defect::Noise`], with *no object* as the farthest distance.
    ///
    /// The error is in the signal, which has a value without an object too: noise turns half of these
    /// readings into echoes.
    OutputNoise(Percentage),
    /// Distances have this constant error.
    Bias(SignedMillimeters),
    /// Distances are multiplied by this factor.
    Scale(Factor),
    /// Every reading is a uniformly random distance of the range.
    Random,
    /// This part of the readings is missing.
    Dropout(Percentage),
    /// The sensor reports this many times as often as its turn comes.
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

    /// Creates a factor; `None` outside 0..=1000 and for NaN.
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

/// A multiple of a frequency.
///
/// Possession proves that it is from 2 to [`Times::MOST`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Times(u32);

impl Times {
    /// The largest multiple.
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

    /// Returns the multiple.
    #[must_use]
    pub const fn get(self) -> u32 {
        self.0
    }
}

/// When a fault can be active: from its start up to, not including, its end.
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
    /// Returns whether the sensor's reading number `reading`, taken `at`, is within.
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

/// A defect, when it can be active, and whether it is intermittent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fault {
    /// The defect.
    pub defect: Defect,
    /// Whether it comes and goes, ten readings each on average.
    pub intermittent: bool,
    /// When.
    pub window: Window,
}

impl Fault {
    /// Creates a fault that is always active.
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
