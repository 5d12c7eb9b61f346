//! A run without sensors: made-up readings through the Smart Car's real fusion level.
//!
//! The same readings on every machine must give the same grid and the same health, bit for bit. The
//! digest says whether they did.

use certainty_core::fusion::{Beam, Mapper, RobustRules};
use certainty_core::health::{Health, HealthRules};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Missing, Reading};
use certainty_core::units::{Millimeters, Ticks};
use certainty_firmware::digest::Digest;
use certainty_firmware::smart_car::{self, CELLS, SENSORS, SWEEP, SmartCarGrid, SmartCarShape};
use core::fmt;
use fixed::types::U0F16;

/// Sweeps of every head in the rehearsal.
pub const SWEEPS: u32 = 6;

/// What a rehearsal came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outcome {
    /// FNV-1a of all cells, confidences and counts.
    pub digest: u32,
    /// Cells that the readings said something about.
    pub told: u32,
}

/// The rehearsal's parts do not fit each other; they always do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InitError;

impl fmt::Display for InitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the grid or a sensor was refused")
    }
}

impl core::error::Error for InitError {}

/// Runs the rehearsal.
///
/// # Errors
///
/// [`InitError`], which would be a defect here: nothing depends on the outside.
pub fn run() -> Result<Outcome, InitError> {
    let owners = [0; certainty_core::fusion::owner_bytes(CELLS, SENSORS)];
    let rules = RobustRules::DEFAULT;
    let grid = SmartCarGrid::try_new(SmartCarShape, rules, SENSORS, [0; CELLS], owners);
    let grid = grid.map_err(|_| InitError)?;
    let mut mapper: Mapper<_, [Health; SENSORS as usize]> = Mapper::new(grid, HealthRules::DEFAULT);
    const ACCURACY: U0F16 = U0F16::lit("0.1");
    let model = smart_car::beam_model(ACCURACY);
    let mut dice = Dice::new(1);
    let mut told = 0_u32;
    for step in 0..SWEEPS.saturating_mul(SWEEP.directions().into()) {
        for slot in 0..SENSORS {
            let id = SensorId::from_slot(slot.into()).ok_or(InitError)?;
            let look = smart_car::look(slot, SENSORS, step);
            let beam = Beam {
                origin: look.at,
                bearing: look.heading,
                reading: dice.reading(),
            };
            let now = Ticks::new(step.saturating_mul(100));
            let cells = mapper
                .integrate(id, &beam, &model, now)
                .map_err(|_| InitError)?;
            told = told.saturating_add(cells);
        }
    }
    let map = mapper.environment();
    let mut digest = Digest::NEW;
    for cell in map.geometry().iter() {
        digest.word(map.certainty(cell).to_bits().into());
    }
    for (_, health) in map.sensors() {
        digest.word(health.confidence().to_bits().into());
        digest.word(health.confirmations());
        digest.word(health.contradictions());
        digest.word(health.missing());
    }
    Ok(Outcome {
        digest: digest.value(),
        told,
    })
}

/// A small generator of made-up readings (xorshift, 32 bits).
pub(crate) struct Dice(u32);

impl Dice {
    /// Throws that `seed`, not zero, decides.
    pub(crate) const fn new(seed: u32) -> Self {
        Self(seed)
    }

    pub(crate) fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }

    fn reading(&mut self) -> Reading {
        let distance = self.next() % 1024;
        match self.next() % 16 {
            0 => Reading::Missing(Missing::Timeout),
            1 => Reading::TooNear,
            2..=5 => Reading::NoObject,
            _ => Reading::Echo(Millimeters::new(distance)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rehearsal_uses_every_kind_of_reading_and_repeats_itself() {
        let outcome = run().unwrap();
        assert_eq!(run(), Ok(outcome));
        // Six sweeps of 37 directions by three heads, most of them with several cells.
        assert!(outcome.told > 6 * 37 * 3);
    }
}
