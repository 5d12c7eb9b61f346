//! A sensor's confidence falls in a fault and comes back: \[001\] §6.3, Fig. 7.
//!
//! Three sensors at full confidence; sensor 1 has a noise of 20 % of its range during its first 50
//! readings, of about 200. \[001\] does not say whose readings these are: [`Count`], nor what the noise
//! does where there is no object: [`Noise`]. Neither does it say which sensors these are, nor how finely the heads sweep: in 13 directions, as in its Table 2, whose 1560 readings are 13 for
//! each of 3 + 4 + 5 sensors in ten layouts. So the fault and what follows it both last longer than
//! a sweep, whoever counts, and both see the whole scene.

mod choice;
mod over_seeds;

pub use choice::{Count, Noise};
pub use over_seeds::{Course, OverSeeds, Spread};

use certainty_core::health::Confidence;
use certainty_sim::fault::{FaultSpec, SpecError};
use certainty_sim::fusion::{FusionRules, Method};
use certainty_sim::simulation::{
    HeadPlacement, Length, SensorLayout, Setup, SetupError, SweepOverlap,
};
use certainty_sim::transducer::SensorSet;
use certainty_sim::world::World;
use std::sync::Arc;

/// Readings of a run; \[001\] §6.3 says "about 200".
pub const READINGS: usize = 200;

/// How many of them, from the first on, the fault lasts.
pub const FAULTY: usize = 50;

/// What tells a confidence from the others': 5 % of the full one.
pub const MARGIN: Confidence = Confidence::from_bits(u16::MAX / 20);

/// The heads of the Smart Car, in 13 directions.
const RIG: SensorLayout = match SensorLayout::try_new(HeadPlacement::Bumper, SweepOverlap::Full, 13)
{
    Ok(rig) => rig,
    Err(_) => panic!("no such rig"),
};

/// The simulation of \[001\] §6.3.
#[derive(Debug, Clone, PartialEq)]
pub struct Recovery {
    /// Whose readings are counted.
    pub count: Count,
    /// What sensor 1's noise is added to.
    pub noise: Noise,
    /// The sensors; \[001\] has three.
    pub crew: SensorSet,
    /// What `AddToGrid` leaves open.
    pub fusion: FusionRules,
}

impl Recovery {
    /// Returns what is wrong with sensor 1.
    ///
    /// # Errors
    ///
    /// [`SpecError`], never in practice: a test reads all of them back.
    pub fn fault(&self) -> Result<FaultSpec, SpecError> {
        // A fault's window counts its sensor's own readings.
        let own = match self.count {
            Count::Each => FAULTY,
            Count::All => FAULTY.div_ceil(self.crew.members().len()),
        };
        format!("{}:1=20%@0..{own}", self.noise.kind()).parse()
    }

    /// Runs the simulation in `world` and records every confidence at every reading that counts.
    ///
    /// # Errors
    ///
    /// [`SetupError`], never in practice: the crew has a sensor 1.
    pub fn trace(&self, world: Arc<World>, seed: u64) -> Result<ConfidenceTrace, SetupError> {
        let faults = vec![self.fault()?];
        self.trace_with(faults, world, seed)
    }

    /// As [`Self::trace`], of the same run without the fault.
    ///
    /// # Errors
    ///
    /// As [`Self::trace`].
    pub fn twin(&self, world: Arc<World>, seed: u64) -> Result<ConfidenceTrace, SetupError> {
        self.trace_with(Vec::new(), world, seed)
    }

    fn trace_with(
        &self,
        faults: Vec<FaultSpec>,
        world: Arc<World>,
        seed: u64,
    ) -> Result<ConfidenceTrace, SetupError> {
        let sensors = self.crew.members().len();
        let length = match self.count {
            Count::Each => Length::Steps(READINGS as u32),
            Count::All => Length::Readings(READINGS as u32),
        };
        let setup = Setup {
            layout: RIG,
            faults,
            fusion: self.fusion,
            ..Setup::smart_car(world, self.crew.clone(), length, seed)
        };
        let mut confidences = vec![Vec::with_capacity(READINGS); sensors];
        setup.run()?.fuse_watching(Method::Robust, |taken, map| {
            let counts = match self.count {
                Count::Each => taken.beam.sensor.slot() + 1 == sensors,
                Count::All => true,
            };
            if counts {
                for (id, health) in map.health() {
                    confidences[id.slot()].push(health.confidence());
                }
            }
        });
        Ok(ConfidenceTrace {
            confidences,
            faulty: FAULTY,
        })
    }
}

/// Confidences over time; sensor 1 was faulty at first, but not in a twin.
///
/// Point *n* is taken after *n* + 1 readings.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ConfidenceTrace {
    confidences: Vec<Vec<Confidence>>,
    faulty: usize,
}

impl ConfidenceTrace {
    /// Returns each sensor's confidences, sensor 1 first.
    #[must_use]
    pub fn confidences(&self) -> &[Vec<Confidence>] {
        &self.confidences
    }

    /// Returns after how many readings since the fault ended sensor 1 was back: its confidence first
    /// at least the mean of the others' less [`MARGIN`].
    ///
    /// Units: readings as [`Count`] counts them. 0 where it was so close already when the fault
    /// ended, as one is that never fell; a later fall does not take it back. `None` where it did not
    /// come back before the trace ended, or the trace ended before the fault.
    #[must_use]
    pub fn recovered_after(&self) -> Option<usize> {
        let mut points = self.faulty.checked_sub(1)?..self.length();
        points.position(|at| {
            let (sum, others) = self
                .others(at)
                .fold((0, 0), |(s, n), bits| (s + bits, n + 1));
            sum <= others * (self.of_sensor_1(at) + u32::from(MARGIN.to_bits()))
        })
    }

    /// Returns how far sensor 1 was below the mean of the others when the fault ended; negative where
    /// it was above.
    ///
    /// Units: of full confidence, −1 to 1. `None` if the trace ended before the fault.
    #[must_use]
    pub fn below_others(&self) -> Option<f64> {
        let at = self.end_of_fault()?;
        let others: Vec<f64> = self.others(at).map(of_full).collect();
        Some(Spread::of(&others).mean - of_full(self.of_sensor_1(at)))
    }

    /// Tells whether sensor 1 was more than [`MARGIN`] below *every* other when the fault ended.
    #[must_use]
    pub fn clearly_below(&self) -> bool {
        let below = |at: usize| {
            let limit = self.of_sensor_1(at) + u32::from(MARGIN.to_bits());
            self.others(at).all(|other| other > limit)
        };
        self.end_of_fault().is_some_and(below)
    }

    /// Returns the lowest confidence of sensor 1 while the fault lasted; of full confidence, 0 to 1.
    #[must_use]
    pub fn lowest_in_fault(&self) -> f64 {
        let during = 0..self.faulty.min(self.length());
        let lowest = during.map(|at| self.of_sensor_1(at)).min();
        lowest.map_or(1.0, of_full)
    }

    /// Points of the trace.
    fn length(&self) -> usize {
        self.confidences.iter().map(Vec::len).min().unwrap_or(0)
    }

    /// The last point of the fault.
    fn end_of_fault(&self) -> Option<usize> {
        let last = self.faulty.checked_sub(1)?;
        (last < self.length()).then_some(last)
    }

    fn of_sensor_1(&self, at: usize) -> u32 {
        self.confidences[0][at].to_bits().into()
    }

    fn others(&self, at: usize) -> impl Iterator<Item = u32> {
        let others = self.confidences[1..].iter();
        others.map(move |own| own[at].to_bits().into())
    }
}

/// Steps of a confidence as a share of the full one.
fn of_full(bits: u32) -> f64 {
    f64::from(bits) / f64::from(Confidence::FULL.to_bits())
}

/// Returns a confidence as a share of the full one.
#[must_use]
pub fn share(confidence: Confidence) -> f64 {
    of_full(confidence.to_bits().into())
}

#[cfg(test)]
mod tests;
