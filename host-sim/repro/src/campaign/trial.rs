//! One scenario in one world: the scores of the maps, and the course of the sensors' health.

use super::scenario::Scenario;
use crate::oracle::Oracle;
use crate::statistics::Waits;
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

/// Sweeps of a health trial with the fault, and sweeps after it.
pub const HEALTH_SWEEPS: u32 = 20;

/// Runs in which the oracle's rates are counted.
pub const ORACLE_RUNS: u64 = 24;

/// Why a scenario cannot be run.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TrialError {
    /// A fault of a sensor that does not exist.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The layout has no world.
    #[error(transparent)]
    Layout(#[from] LayoutError),
}

/// The robust method's health against the sensors' true condition.
///
/// Waits are counted in turns of the sensor itself, of which a chattering sensor has several per step.
#[derive(Debug, Clone, Default)]
pub(super) struct HealthTrial {
    /// Of faulty sensors: until suspect (or failed).
    pub(super) suspect: Waits,
    /// Of faulty sensors: until failed.
    pub(super) failed: Waits,
    /// Of sensors that were not healthy when the fault ended: until healthy again.
    pub(super) recovered: Waits,
    /// Of sound sensors: until wrongly suspect (or failed).
    pub(super) false_suspect: Waits,
    /// Of sound sensors: until wrongly failed.
    pub(super) false_failed: Waits,
}

impl Scenario {
    /// The set-up in the world of `seed`, with the fault during `window`.
    fn setup(
        &self,
        seed: u64,
        steps: u32,
        window: Window,
        fusion: &FusionRules,
    ) -> Result<Setup, TrialError> {
        let layout = SensorLayout::try_new(HeadPlacement::Bumper, self.overlap, DIRECTIONS);
        let world = World::random(&Layout::default(), seed)?;
        let sensors = SensorSet::of_table_1(self.sensors.into());
        let length = Length::Steps(steps);
        Ok(Setup {
            layout: layout.unwrap_or(SensorLayout::SMART_CAR),
            faults: self.faults(seed, window),
            fusion: *fusion,
            ..Setup::smart_car(Arc::new(world), sensors, length, seed)
        })
    }

    /// The slots of the faulty sensors in the world of `seed`.
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
                sensor: SensorName::Number(id.number().into()),
                fault: Fault { window, ..fault },
            })
        });
        specs.collect()
    }

    /// A run that makes a map, with the fault throughout.
    fn map_run(&self, seed: u64, fusion: &FusionRules) -> Result<Run, TrialError> {
        let steps = self.sweeps.saturating_mul(DIRECTIONS.into());
        Ok(self.setup(seed, steps, Window::Always, fusion)?.run()?)
    }

    /// Counts an oracle's rates of this scenario in worlds that no trial uses.
    pub(super) fn oracle(&self, seed: u64, fusion: &FusionRules) -> Result<Oracle, TrialError> {
        // Campaigns count their worlds' seeds upwards; the other half of all seeds is far away.
        let held_out = (0..ORACLE_RUNS).map(|run| seed.wrapping_add(run) ^ 1 << 63);
        let runs: Result<Vec<_>, _> = held_out.map(|seed| self.map_run(seed, fusion)).collect();
        Ok(Oracle::count(&runs?))
    }

    /// Returns the score of each method, then the oracle's, in the world of `seed`.
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

    /// Follows the health by the robust grid during the fault and after it; independent of
    /// [`Scenario::sweeps`].
    pub(super) fn health_trial(
        &self,
        seed: u64,
        fusion: &FusionRules,
    ) -> Result<HealthTrial, TrialError> {
        let steps = HEALTH_SWEEPS * u32::from(DIRECTIONS);
        let fault_end = Ticks::new(steps * STEP_MS);
        let window = Window::Times {
            from: Ticks::new(0),
            to: Some(fault_end),
        };
        let run = self.setup(seed, 2 * steps, window, fusion)?.run()?;
        let mut histories = vec![StatusHistory::default(); self.sensors.into()];
        run.fuse_watching(Method::Robust, |taken, mapper| {
            let id = taken.beam.sensor;
            let sensors = mapper.health();
            for (slot, (history, (_, health))) in histories.iter_mut().zip(&sensors).enumerate() {
                history.add(
                    health.status(),
                    slot == id.slot(),
                    taken.beam.at.get() >= fault_end.get(),
                );
            }
        });
        let faulty = self.faulty_slots(seed);
        let mut trial = HealthTrial::default();
        for (slot, history) in histories.into_iter().enumerate() {
            if faulty.contains(&slot) {
                trial.suspect.add(history.suspect);
                trial.failed.add(history.failed);
                if history.unhealthy_at_end {
                    trial.recovered.add(history.recovered);
                }
            } else {
                trial.false_suspect.add(history.suspect_ever);
                trial.false_failed.add(history.failed_ever);
            }
        }
        Ok(trial)
    }
}

/// When one sensor's status changed.
#[derive(Debug, Clone, Default)]
struct StatusHistory {
    /// Turns, and those of them before the fault ended.
    turns: u64,
    turns_faulty: u64,
    /// During the fault.
    suspect: Option<u64>,
    failed: Option<u64>,
    /// At any time.
    suspect_ever: Option<u64>,
    failed_ever: Option<u64>,
    unhealthy_at_end: bool,
    /// Turns from the fault's end until it was first healthy.
    recovered: Option<u64>,
}

impl StatusHistory {
    /// Adds the status after a reading; `own` if the reading was this sensor's, `fault_ended` if all faults
    /// are over.
    fn add(&mut self, status: Status, own: bool, fault_ended: bool) {
        self.turns += u64::from(own);
        let turns = self.turns;
        let suspect = matches!(status, Status::Suspect | Status::Failed);
        let failed = status == Status::Failed;
        if suspect {
            self.suspect_ever.get_or_insert(turns);
        }
        if failed {
            self.failed_ever.get_or_insert(turns);
        }
        if fault_ended {
            if status == Status::Healthy {
                self.recovered.get_or_insert(turns - self.turns_faulty);
            }
        } else {
            self.turns_faulty = turns;
            self.suspect = self.suspect_ever;
            self.failed = self.failed_ever;
            self.unhealthy_at_end = status != Status::Healthy;
        }
    }
}
