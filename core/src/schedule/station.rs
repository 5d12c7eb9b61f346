//! What a schedule must know about a sensor.

use crate::transducer::Sweep;
use crate::units::BinaryAngle;

/// A sensor as the schedule sees it: what time it needs, and where it looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Station {
    /// What it sends out; only like signals disturb each other.
    pub signal: Signal,
    /// Where it looks, as seen from the robot.
    pub aim: Aim,
    /// How it measures.
    pub measuring: Measuring,
    /// How long its signal may still be heard by others after it has measured, in ms: the late
    /// echoes of a sound. Light has none.
    pub fades: u16,
}

/// What a sensor sends out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Signal {
    /// An infrared sensor's.
    Light,
    /// An ultrasonic ranger's.
    Sound,
}

impl Signal {
    /// `==`, for constants.
    pub(super) const fn is(self, other: Self) -> bool {
        matches!(
            (self, other),
            (Self::Light, Self::Light) | (Self::Sound, Self::Sound)
        )
    }
}

/// Where a sensor looks, in a frame that all stations of a schedule share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Aim {
    /// It sits on a pivoted head, which is moved once a round: in round n to step n of its sweep.
    Sweeping {
        /// Where the head goes.
        sweep: Sweep,
        /// Which of the sweep's heads it is, from 0.
        slot: u16,
        /// How many equally phased heads share the sweep.
        heads: u16,
        /// How long the head needs to come to rest, in ms after the end of the slot that moves it:
        /// the worst case, which is the flight back from the sweep's end to its start.
        settle: u16,
    },
    /// It cannot be moved.
    Fixed(BinaryAngle),
}

impl Aim {
    /// Returns where it looks in round `step`.
    #[must_use]
    pub const fn direction(&self, step: u32) -> BinaryAngle {
        match self {
            Self::Sweeping {
                sweep, slot, heads, ..
            } => sweep.direction(step, *slot, *heads),
            Self::Fixed(direction) => *direction,
        }
    }

    /// After how many rounds it looks the same ways again.
    pub(super) const fn repeats_after(&self) -> u32 {
        match self {
            Self::Sweeping { sweep, .. } => sweep.directions() as u32,
            Self::Fixed(_) => 1,
        }
    }
}

/// How a sensor measures, and what time that takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Measuring {
    /// It is started in one slot and read in a later one.
    Apart {
        /// Ms from the end of the first to the begin of the second: 70 for a GP2D02.
        conversion: u16,
    },
    /// The whole measurement is made in one slot.
    Whole {
        /// Ms that the slot must last at least, so that also the longest measurement fits: the way
        /// of the sound to the end of its range and back.
        longest: u16,
    },
}
