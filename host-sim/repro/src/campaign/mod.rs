//! The fault campaign: every method against every fault, many worlds each.
//!
//! \[001\] and \[000\] evaluate without permanent faults and by MAE and MSE alone. The campaign varies the
//! kind of fault, how often the faulty sensor reports, how many sensors there are and how many of them
//! are faulty, how far their views overlap and how many sweeps a map is made of, and measures what hurts
//! a robot: obstacles missed and ghosts. Beside the methods stands an [oracle](super::Oracle), and beside
//! the maps what the robust method's health made of the sensors.
//!
//! World k of seed S is the world, and the sensors' luck, of seed S + k, in every scenario.

mod file;
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

/// A campaign that can be run.
#[derive(Debug, Clone)]
pub struct Campaign {
    selection: Selection,
    scenarios: Vec<Scenario>,
    methods: Vec<&'static str>,
    common: Common,
    fusion: FusionRules,
}

/// Why a campaign ended early.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// A scenario cannot be run.
    #[error("{0}")]
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
            },
            selection,
            fusion,
        }
    }

    /// Returns the scenarios in their order.
    #[must_use]
    pub fn scenarios(&self) -> &[Scenario] {
        &self.scenarios
    }

    /// Opens the file that will hold the rows.
    ///
    /// # Errors
    ///
    /// [`JournalError`] where it cannot be written or holds something else.
    pub fn journal(&self, path: &Path) -> Result<Journal, JournalError> {
        let keys = self.scenarios.iter().map(|scenario| {
            let methods = self.methods.iter();
            let key = |method: &&str| Row::key(scenario, method, &self.common);
            methods.map(key).collect()
        });
        Journal::open(path, &keys.collect::<Vec<_>>())
    }

    /// Runs scenario after scenario and hands each one's rows to `finished`.
    ///
    /// Worlds are run in parallel on the current `rayon` pool; the rows are the same on any.
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
            let whatever = Scenario {
                sweeps: 0,
                ..*scenario
            };
            let place = match known.iter().position(|(alike, _)| *alike == whatever) {
                Some(place) => place,
                None => {
                    known.push((whatever, self.health(scenario)?));
                    known.len() - 1
                }
            };
            finished(self.rows(scenario, &known[place].1)?)?;
        }
        Ok(())
    }

    /// Runs scenario after scenario into `journal`, from where it stopped.
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

    /// What becomes of the sensors' health, which hangs on all of a scenario but its sweeps; nothing
    /// where the robust method is not asked.
    fn health(&self, scenario: &Scenario) -> Result<Vec<HealthTrial>, TrialError> {
        if !self.selection.methods.contains(&Method::Robust) {
            return Ok(Vec::new());
        }
        self.in_every_world(|seed| scenario.health_trial(seed, &self.fusion))
    }

    fn rows(&self, scenario: &Scenario, health: &[HealthTrial]) -> Result<Vec<Row>, TrialError> {
        let oracle = scenario.oracle(self.common.seed, &self.fusion)?;
        let scores = self.in_every_world(|seed| {
            scenario.scores(seed, &self.selection.methods, &oracle, &self.fusion)
        })?;
        Ok(Row::of(
            scenario,
            &self.methods,
            &self.common,
            &scores,
            health,
        ))
    }

    /// Does `work` for the seed of every world and returns the results in their order.
    fn in_every_world<T: Send>(
        &self,
        work: impl Fn(u64) -> Result<T, TrialError> + Sync,
    ) -> Result<Vec<T>, TrialError> {
        let Common { seed, worlds, .. } = self.common;
        let worlds = (0..worlds).into_par_iter();
        worlds.map(|world| work(seed.wrapping_add(world))).collect()
    }
}

/// Eight hexadecimal digits that name the program's version and the methods' rules.
fn fingerprint(fusion: &FusionRules) -> String {
    let text = format!(
        "{} {HEALTH_SWEEPS} {ORACLE_RUNS} {fusion:?}",
        env!("CARGO_PKG_VERSION")
    );
    // FNV-1a: spreads well enough to tell set-ups apart, and is the same everywhere.
    let digest = text.bytes().fold(0x811c_9dc5_u32, |digest, byte| {
        (digest ^ u32::from(byte)).wrapping_mul(0x0100_0193)
    });
    format!("{digest:08x}")
}
