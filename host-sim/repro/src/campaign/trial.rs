//! One scenario in one world: the maps, and what becomes of the sensors' health.

use super::super::{Oracle, Waits};
use super::Scenario;
use certainty_core::health::Status;
use certainty_core::sensor::SensorId;
use certainty_core::units::Ticks;
use certainty_sim::fault::{Defect, Fault, FaultSpec, SensorName, Times, Window};
use certainty_sim::fusion::{FusionRules, Method};
use certainty_sim::random::{Purpose, stream};
use certainty_sim::simulation::{
    HeadPlacement, Length, Run, STEP_MS, Score, SensorLayout, Setup, SetupError,
};
use certainty_sim::transducer::SensorSet;
use certainty_sim::world::{Layout, LayoutError, World};
use rand::seq::SliceRandom;
use std::sync::Arc;

/// Directions of a sweep: the shipped car's.
const DIRECTIONS: u16 = SensorLayout::SMART_CAR.directions();

/// Sweeps during which the sensors are faulty in a health trial, and as many after they healed.
pub const HEALTH_SWEEPS: u32 = 20;

/// Runs that the oracle is told its rates from.
pub const ORACLE_RUNS: u64 = 24;

/// A scenario that cannot be run.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TrialError {
    /// A fault of a sensor that is not there.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// No world can be made.
    #[error(transparent)]
    Layout(#[from] LayoutError),
}

/// How a method's health followed the sensors' condition; waits are counted in turns of the sensor
/// itself, of which it has several while it chatters.
#[derive(Debug, Clone, Default)]
pub(super) struct HealthTrial {
    /// Of faulty sensors: until suspect (or failed).
    pub(super) suspect: Waits,
    /// Of faulty sensors: until failed.
    pub(super) failed: Waits,
    /// Of sensors that were not healthy when they healed: until healthy again.
    pub(super) recovered: Waits,
    /// Of sound sensors: until wrongly suspect (or failed).
    pub(super) false_suspect: Waits,
    /// Of sound sensors: until wrongly failed.
    pub(super) false_failed: Waits,
}

impl Scenario {
    /// The set-up in the world that `seed` names, faulty as long as `window` lasts.
    fn setup(
        &self,
        seed: u64,
        steps: u32,
        window: Window,
        fusion: &FusionRules,
    ) -> Result<Setup, TrialError> {
        let rig = SensorLayout::try_new(HeadPlacement::Bumper, self.overlap, DIRECTIONS);
        let world = World::random(&Layout::default(), seed)?;
        let crew = SensorSet::of_table_1(self.sensors.into());
        let length = Length::Steps(steps);
        Ok(Setup {
            layout: rig.unwrap_or(SensorLayout::SMART_CAR),
            faults: self.faults(seed, window),
            fusion: *fusion,
            ..Setup::smart_car(Arc::new(world), crew, length, seed)
        })
    }

    /// The sensors that are faulty in the world that `seed` names, as slots.
    fn faulty_slots(&self, seed: u64) -> Vec<usize> {
        let mut slots: Vec<usize> = (0..self.sensors.into()).collect();
        slots.shuffle(&mut stream(seed, Purpose::Choice, 0, 0));
        slots.truncate(self.faulty.into());
        slots
    }

    fn faults(&self, seed: u64, window: Window) -> Vec<FaultSpec> {
        let Some(fault) = self.fault.fault() else {
            return Vec::new();
        };
        let chatter =
            Times::try_new(self.rate).map(|times| Fault::permanent(Defect::Chatter(times)));
        let sensors = self.faulty_slots(seed).into_iter();
        let specs = sensors.filter_map(SensorId::from_slot).flat_map(|id| {
            let faults = [Some(fault), chatter].into_iter().flatten();
            faults.map(move |fault| FaultSpec {
                sensor: SensorName::Number(id),
                fault: Fault { window, ..fault },
            })
        });
        specs.collect()
    }

    /// A run that makes a map, faulty throughout.
    fn map_run(&self, seed: u64, fusion: &FusionRules) -> Result<Run, TrialError> {
        let steps = self.sweeps.saturating_mul(DIRECTIONS.into());
        Ok(self.setup(seed, steps, Window::Always, fusion)?.run()?)
    }

    /// Tells an oracle the rates of this scenario, from worlds that no trial uses.
    pub(super) fn oracle(&self, seed: u64, fusion: &FusionRules) -> Result<Oracle, TrialError> {
        // Campaigns count their worlds' seeds upwards; the other half of all seeds is far away.
        let held_out = (0..ORACLE_RUNS).map(|run| seed.wrapping_add(run) ^ 1 << 63);
        let runs: Result<Vec<_>, _> = held_out.map(|seed| self.map_run(seed, fusion)).collect();
        Ok(Oracle::told(&runs?))
    }

    /// Returns the score of each method, and last the oracle's, in the world that `seed` names.
    pub(super) fn scores(
        &self,
        seed: u64,
        methods: &[Method],
        oracle: &Oracle,
        fusion: &FusionRules,
    ) -> Result<Vec<Score>, TrialError> {
        let run = self.map_run(seed, fusion)?;
        let mut scores: Vec<_> = methods
            .iter()
            .map(|&method| run.fuse(method).score)
            .collect();
        scores.push(Score::of(&oracle.fuse(&run), run.reference.cells()));
        Ok(scores)
    }

    /// Follows the health that the robust grid reports while sensors are faulty, and after; for however
    /// many sweeps the map is made.
    pub(super) fn health_trial(
        &self,
        seed: u64,
        fusion: &FusionRules,
    ) -> Result<HealthTrial, TrialError> {
        let steps = HEALTH_SWEEPS * u32::from(DIRECTIONS);
        let healed = Ticks::new(steps * STEP_MS);
        let window = Window::Times {
            from: Ticks::new(0),
            to: Some(healed),
        };
        let run = self.setup(seed, 2 * steps, window, fusion)?.run()?;
        let mut watches = vec![Watch::default(); self.sensors.into()];
        run.fuse_watching(Method::Robust, |taken, mapper| {
            let id = taken.beam.sensor;
            let sensors = mapper.health();
            for (slot, (watch, (_, health))) in watches.iter_mut().zip(&sensors).enumerate() {
                watch.look(
                    health.status(),
                    slot == id.slot(),
                    taken.beam.at.get() >= healed.get(),
                );
            }
        });
        let faulty = self.faulty_slots(seed);
        let mut trial = HealthTrial::default();
        for (slot, watch) in watches.into_iter().enumerate() {
            if faulty.contains(&slot) {
                trial.suspect.add(watch.suspect);
                trial.failed.add(watch.failed);
                if watch.unwell_when_healed {
                    trial.recovered.add(watch.recovered);
                }
            } else {
                trial.false_suspect.add(watch.suspect_ever);
                trial.false_failed.add(watch.failed_ever);
            }
        }
        Ok(trial)
    }
}

/// What is noted of one sensor's status.
#[derive(Debug, Clone, Default)]
struct Watch {
    /// Turns so far, and those of them before the faults healed.
    turns: u64,
    turns_faulty: u64,
    /// During the faults.
    suspect: Option<u64>,
    failed: Option<u64>,
    /// At any time.
    suspect_ever: Option<u64>,
    failed_ever: Option<u64>,
    unwell_when_healed: bool,
    /// Turns since the faults healed until it was first healthy.
    recovered: Option<u64>,
}

impl Watch {
    /// Notes the status after a reading: whether it was this sensor's, and whether all faults are over.
    fn look(&mut self, status: Status, own: bool, healed: bool) {
        self.turns += u64::from(own);
        let turns = self.turns;
        let unwell = matches!(status, Status::Suspect | Status::Failed);
        let failed = status == Status::Failed;
        if unwell {
            self.suspect_ever.get_or_insert(turns);
        }
        if failed {
            self.failed_ever.get_or_insert(turns);
        }
        if healed {
            if status == Status::Healthy {
                self.recovered.get_or_insert(turns - self.turns_faulty);
            }
        } else {
            self.turns_faulty = turns;
            self.suspect = self.suspect_ever;
            self.failed = self.failed_ever;
            self.unwell_when_healed = status != Status::Healthy;
        }
    }
}
