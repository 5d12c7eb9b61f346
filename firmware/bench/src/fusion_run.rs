//! Generated readings through the Smart Car's fusion level.
//!
//! The same readings must give the same grid and the same health on every machine, bit for bit; the digest
//! compares them.

use certainty_core::fusion::{Beam, Mapper, RobustRules};
use certainty_core::health::{Health, HealthRules};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Missing, Reading};
use certainty_core::units::{Millimeters, Ticks};
use certainty_firmware::digest::Digest;
use certainty_firmware::smart_car::{self, CELLS, SENSORS, SWEEP, SmartCarGrid, SmartCarShape};
use core::fmt;
use fixed::types::U0F16;

/// Sweeps of every head in a run.
pub const SWEEPS: u32 = 6;

/// The result of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outcome {
    /// FNV-1a of all cells, confidences and counts.
    pub digest: u32,
    /// Cells that the readings updated, with repetitions.
    pub updates: u32,
}

/// A configuration of the run is invalid; a test shows that this does not happen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InitError;

impl fmt::Display for InitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a configuration of the run is invalid")
    }
}

impl core::error::Error for InitError {}

/// Runs once.
///
/// # Errors
///
/// [`InitError`], which would be a defect: there is no input.
pub fn run() -> Result<Outcome, InitError> {
    let owners = [0; certainty_core::fusion::owner_bytes(CELLS, SENSORS)];
    let rules = RobustRules::DEFAULT;
    let grid = SmartCarGrid::try_new(SmartCarShape, rules, SENSORS, [0; CELLS], owners);
    let grid = grid.map_err(|_| InitError)?;
    let mut mapper: Mapper<_, [Health; SENSORS as usize]> = Mapper::new(grid, HealthRules::DEFAULT);
    const ACCURACY: U0F16 = U0F16::lit("0.1");
    let model = smart_car::beam_model(ACCURACY);
    let mut random = Random::new(1);
    let mut updates = 0_u32;
    for step in 0..SWEEPS.saturating_mul(SWEEP.directions().into()) {
        for slot in 0..SENSORS {
            let id = SensorId::from_slot(slot.into()).ok_or(InitError)?;
            let look = smart_car::look(slot, SENSORS, step);
            let beam = Beam {
                origin: look.at,
                bearing: look.heading,
                reading: random.reading(),
            };
            let now = Ticks::new(step.saturating_mul(100));
            let cells = mapper
                .integrate(id, &beam, &model, now)
                .map_err(|_| InitError)?;
            updates = updates.saturating_add(cells);
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
        updates,
    })
}

/// A random number generator (xorshift, 32 bits).
pub(crate) struct Random(u32);

impl Random {
    /// Creates a generator from `seed`, which must not be zero.
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
    fn a_run_is_reproducible() {
        let outcome = run().unwrap();
        assert_eq!(run(), Ok(outcome));
        // Six sweeps of 37 directions by three heads; most readings update several cells.
        assert!(outcome.updates > 6 * 37 * 3);
    }
}
