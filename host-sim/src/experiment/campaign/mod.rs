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

pub use file::OverlapError;
pub use journal::{Journal, JournalError};
pub use row::Row;
pub use scenario::{FaultKind, FaultKindError, Scenario, Selection};
pub use trial::{HEALTH_SWEEPS, ORACLE_RUNS, TrialError};

use crate::fusion::FusionRules;
use rayon::prelude::*;
use row::Common;
use std::path::Path;
use trial::Trial;

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
        for scenario in self.scenarios.iter().skip(from) {
            finished(self.rows(scenario)?)?;
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

    fn rows(&self, scenario: &Scenario) -> Result<Vec<Row>, TrialError> {
        let Common { seed, worlds, .. } = self.common;
        let oracle = scenario.oracle(seed, &self.fusion)?;
        let trial = |world: u64| {
            let seed = seed.wrapping_add(world);
            scenario.trial(seed, &self.selection.methods, &oracle, &self.fusion)
        };
        let trials: Result<Vec<Trial>, _> = (0..worlds).into_par_iter().map(trial).collect();
        Ok(Row::of(scenario, &self.methods, &self.common, &trials?))
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
