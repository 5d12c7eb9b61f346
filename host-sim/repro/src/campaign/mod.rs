//! The fault campaign: every method against every fault, many worlds each.
//!
//! \[001\] and \[000\] evaluate without permanent faults and by MAE and MSE alone. The campaign varies the
//! kind of fault, the report rate of the faulty sensor, the number of sensors and of faulty ones, the
//! overlap of their sweeps and the number of sweeps of a map. It measures obstacles missed and ghosts too,
//! which harm a robot most. Beside the methods stands an [oracle](super::Oracle), and beside the maps the
//! sensors' health by the robust method.
//!
//! World k of seed S has the obstacles and the sensor errors of seed S + k, in every scenario.

mod journal;
mod row;
mod scenario;
mod trial;

pub use journal::{Journal, JournalError};
pub use row::Row;
pub use scenario::{FaultKind, FaultKindError, Scenario, Selection};
pub use trial::{HEALTH_SWEEPS, ORACLE_RUNS, TrialError};

use certainty_sim::fusion::{FusionRules, Method};
use rayon::prelude::*;
use row::Common;
use std::path::Path;
use trial::HealthTrial;

/// A campaign, planned and ready to run.
#[derive(Debug, Clone)]
pub struct Campaign {
    selection: Selection,
    scenarios: Vec<Scenario>,
    methods: Vec<&'static str>,
    common: Common,
}

/// Why a campaign ended early.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// A scenario cannot be run.
    #[error(transparent)]
    Trial(#[from] TrialError),
    /// Its file cannot be written.
    #[error(transparent)]
    Journal(#[from] JournalError),
}

impl Campaign {
    /// Plans the campaign of `selection` in `worlds` worlds, the first of seed `seed`.
    #[must_use]
    pub fn new(selection: Selection, seed: u64, worlds: u64, fusion: FusionRules) -> Self {
        let methods = selection.methods.iter().map(|method| method.name());
        Self {
            scenarios: selection.scenarios(),
            methods: methods.chain(["oracle"]).collect(),
            common: Common {
                seed,
                worlds,
                setup: fingerprint(&fusion),
                fusion,
            },
            selection,
        }
    }

    /// Returns the scenarios in their order.
    #[must_use]
    pub fn scenarios(&self) -> &[Scenario] {
        &self.scenarios
    }

    /// Opens the file for the rows.
    ///
    /// # Errors
    ///
    /// [`JournalError`] if it cannot be written or is not a file of this campaign.
    pub fn journal(&self, path: &Path) -> Result<Journal, JournalError> {
        let keys = self.scenarios.iter().map(|scenario| {
            let methods = self.methods.iter();
            let key = |method: &&str| Row::key(scenario, method, &self.common);
            methods.map(key).collect()
        });
        Journal::open(path, &keys.collect::<Vec<_>>())
    }

    /// Runs scenario after scenario and calls `finished` with each one's rows.
    ///
    /// Worlds are run in parallel on the current `rayon` pool; the rows do not depend on its size.
    ///
    /// # Errors
    ///
    /// [`CampaignError`] from a scenario or from `finished`.
    pub fn run(
        &self,
        from: usize,
        mut finished: impl FnMut(Vec<Row>) -> Result<(), CampaignError>,
    ) -> Result<(), CampaignError> {
        let mut known: Vec<(Scenario, Vec<HealthTrial>)> = Vec::new();
        for scenario in self.scenarios.iter().skip(from) {
            let any_sweeps = Scenario {
                sweeps: 0,
                ..*scenario
            };
            let place = match known.iter().position(|(key, _)| *key == any_sweeps) {
                Some(place) => place,
                None => {
                    known.push((any_sweeps, self.health(scenario)?));
                    known.len() - 1
                }
            };
            finished(self.rows(scenario, &known[place].1)?)?;
        }
        Ok(())
    }

    /// Runs the scenarios that `journal` does not have and appends their rows; calls `finished` after each.
    ///
    /// # Errors
    ///
    /// [`CampaignError`] from a scenario or the file.
    pub fn run_into(
        &self,
        journal: &mut Journal,
        mut finished: impl FnMut(),
    ) -> Result<(), CampaignError> {
        self.run(journal.finished(), |rows| {
            journal.append(&rows)?;
            finished();
            Ok(())
        })
    }

    /// The course of the sensors' health, which depends on all of a scenario but its sweeps; empty without
    /// the robust method.
    fn health(&self, scenario: &Scenario) -> Result<Vec<HealthTrial>, TrialError> {
        if !self.selection.methods.contains(&Method::Robust) {
            return Ok(Vec::new());
        }
        self.in_every_world(|seed| scenario.health_trial(seed, &self.common.fusion))
    }

    fn rows(&self, scenario: &Scenario, health: &[HealthTrial]) -> Result<Vec<Row>, TrialError> {
        let oracle = scenario.oracle(self.common.seed, &self.common.fusion)?;
        let scores = self.in_every_world(|seed| {
            scenario.scores(seed, &self.selection.methods, &oracle, &self.common.fusion)
        })?;
        Ok(Row::of(
            scenario,
            &self.methods,
            &self.common,
            &scores,
            health,
        ))
    }

    /// Calls `work` with the seed of every world and returns the results in their order.
    fn in_every_world<T: Send>(
        &self,
        work: impl Fn(u64) -> Result<T, TrialError> + Sync,
    ) -> Result<Vec<T>, TrialError> {
        let Common { seed, worlds, .. } = self.common;
        let worlds = (0..worlds).into_par_iter();
        worlds.map(|world| work(seed.wrapping_add(world))).collect()
    }
}

/// Eight hexadecimal digits that identify the program's version and the methods' rules.
fn fingerprint(fusion: &FusionRules) -> String {
    let text = format!(
        "{} {HEALTH_SWEEPS} {ORACLE_RUNS} {fusion:?}",
        env!("CARGO_PKG_VERSION")
    );
    // FNV-1a: the same on every machine, and different set-ups rarely collide.
    let digest = text.bytes().fold(0x811c_9dc5_u32, |digest, byte| {
        (digest ^ u32::from(byte)).wrapping_mul(0x0100_0193)
    });
    format!("{digest:08x}")
}
