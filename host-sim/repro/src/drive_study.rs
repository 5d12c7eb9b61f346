//! Many runs: \[004\]'s simulations 1 to 3, and the failures that its summary leaves as future work.

use crate::statistics::Spread;
use certainty_sim::fault::{FaultSpec, SpecError};
use certainty_sim::robot::course::Course;
use certainty_sim::robot::drive::{Drive, Event, EventKind};
use certainty_sim::robot::pilot::{HealthMode, MapSource, PilotConfig};
use certainty_sim::robot::sensors::NAMES;
use certainty_sim::world::LayoutError;
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};
use serde::Serialize;

/// When the faults of the study begin.
const FROM: &str = "@2s";

/// Kinds of faults that the robot receives no report of.
pub const KINDS: [&str; 4] = ["stuck-far", "stuck-near", "near-noisy", "random"];

/// Returns the faults of `kind` of `sensor`.
fn faults_of(kind: &str, sensor: &str) -> Result<Vec<FaultSpec>, SpecError> {
    let written = match kind {
        // A stuck sensor repeats one distance to the millimetre; with noise it does not.
        "near-noisy" => vec![format!("stuck-near:{sensor}"), format!("noise:{sensor}=1%")],
        _ => vec![format!("{kind}:{sensor}")],
    };
    let faults = written.into_iter();
    faults.map(|fault| (fault + FROM).parse()).collect()
}

/// The parameters of a study.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Study {
    /// The first world; the others follow it.
    pub seed: u64,
    /// Number of random courses for every case.
    pub worlds: u32,
    /// Source of the obstacles in the histogram.
    pub map: MapSource,
    /// The differences from the core's default rules.
    pub pilot: PilotConfig,
}

/// The failing sensors, their faults, and the source of the robot's failure estimates.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// The case's name: a simulation's number, or the kind of fault.
    pub name: &'static str,
    /// The sensors' names, with a `+` between two; empty if none fails.
    pub sensors: String,
    /// Number of sensors that fail.
    pub failing: usize,
    /// Source of the failure estimates.
    pub health: HealthMode,
    /// Whether full speed is allowed at any coverage.
    pub bold: bool,
    faults: Vec<FaultSpec>,
}

/// One case in one world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// The world's seed.
    pub world: u64,
    /// Whether the goal was reached.
    pub reached: bool,
    /// Number of collisions with an obstacle.
    pub collisions: u32,
    /// The least clearance, in millimetres.
    pub min_clearance_mm: f64,
    /// E, S, `v_M` of \[004\] eq. 17 and 18.
    pub error: f64,
    /// S.
    pub speed_deviation: f64,
    /// `v_M`.
    pub mean_speed: f64,
    /// s, if the goal was reached.
    pub route_m: Option<f64>,
    /// T, if the goal was reached.
    pub time_s: Option<f64>,
    /// Number of sensors that failed.
    pub failing: u32,
    /// Number of these that were diagnosed.
    pub found: u32,
    /// Seconds from a fault's start to its diagnosis, of the last of them.
    pub found_after_s: Option<f64>,
    /// Number of sound sensors that were ever diagnosed as failed.
    pub accused: u32,
}

/// Statistics over the trials of some cases; its fields are a contract.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// The simulation or the kind of fault.
    pub name: String,
    /// The failing sensors: their names, or `single` or `pair`.
    pub failing: String,
    /// Source of the failure estimates.
    pub health_mode: &'static str,
    /// Whether full speed was allowed at any coverage.
    pub bold: bool,
    /// Number of runs.
    pub runs: usize,
    /// Number of runs that reached the goal.
    pub reached: usize,
    /// Number of collisions with an obstacle.
    pub collisions: u64,
    /// E of all.
    #[serde(rename = "E")]
    pub error: Option<Spread>,
    /// T of those that reached the goal.
    #[serde(rename = "T")]
    pub time_s: Option<Spread>,
    /// S of all.
    #[serde(rename = "S")]
    pub speed_deviation: Option<Spread>,
    /// s of those that reached the goal.
    #[serde(rename = "s")]
    pub route_m: Option<Spread>,
    /// `v_M` of all.
    #[serde(rename = "v_M")]
    pub mean_speed: Option<Spread>,
    /// Number of failed sensors that were diagnosed, and number of failed sensors.
    pub found: (u64, u64),
    /// Seconds to the diagnosis, of runs in which every failed sensor was diagnosed.
    pub found_after_s: Option<Spread>,
    /// Number of sound sensors that were ever diagnosed as failed.
    pub accused: u64,
}

/// Why a case cannot be driven; a test drives every one.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StudyError {
    /// The layout has no world.
    #[error(transparent)]
    Layout(#[from] LayoutError),
    /// A fault names no sensor.
    #[error(transparent)]
    Fault(#[from] SpecError),
}

impl Study {
    /// Returns \[004\]'s simulations: no failure, FL, the scanner; each with this robot's speed limit and
    /// with full speed at any coverage as in \[004\].
    ///
    /// # Errors
    ///
    /// [`SpecError`] if a fault cannot be parsed, which a test excludes.
    pub fn simulations() -> Result<Vec<Case>, SpecError> {
        let silent = |sensor: &str| Ok(vec![format!("dropout:{sensor}=100%").parse()?]);
        let mut cases = Vec::new();
        for bold in [false, true] {
            for (name, sensor) in [
                ("simulation 1", ""),
                ("simulation 2", "FL"),
                ("simulation 3", "scanner"),
            ] {
                cases.push(Case {
                    name,
                    sensors: sensor.to_owned(),
                    failing: usize::from(!sensor.is_empty()),
                    health: HealthMode::Given,
                    bold,
                    faults: if sensor.is_empty() {
                        Vec::new()
                    } else {
                        silent(sensor)?
                    },
                });
            }
        }
        Ok(cases)
    }

    /// Returns every single failure and every pair of each kind, by every [`HealthMode`].
    ///
    /// # Errors
    ///
    /// [`SpecError`] if a fault cannot be parsed, which a test excludes.
    pub fn failures() -> Result<Vec<Case>, SpecError> {
        let mut sets: Vec<Vec<&str>> = NAMES.iter().map(|&name| vec![name]).collect();
        for (slot, first) in NAMES.iter().enumerate() {
            sets.extend(NAMES[slot + 1..].iter().map(|second| vec![*first, second]));
        }
        let mut cases = Vec::new();
        for name in KINDS {
            for sensors in &sets {
                let mut faults = Vec::new();
                for sensor in sensors {
                    faults.extend(faults_of(name, sensor)?);
                }
                cases.extend(HealthMode::ALL.map(|health| Case {
                    name,
                    sensors: sensors.join("+"),
                    failing: sensors.len(),
                    health,
                    bold: false,
                    faults: faults.clone(),
                }));
            }
        }
        Ok(cases)
    }

    /// Drives `case` in every world, in parallel on rayon's threads.
    ///
    /// # Errors
    ///
    /// [`StudyError`] if a course or a fault of the case is invalid.
    pub fn drive(&self, case: &Case) -> Result<Vec<Trial>, StudyError> {
        let worlds = 0..u64::from(self.worlds);
        let seeds: Vec<u64> = worlds
            .map(|number| self.seed.wrapping_add(number))
            .collect();
        seeds
            .par_iter()
            .map(|&seed| self.trial(case, seed))
            .collect()
    }

    fn trial(&self, case: &Case, seed: u64) -> Result<Trial, StudyError> {
        let drive = Drive {
            course: Course::random(seed)?,
            faults: case.faults.clone(),
            health: case.health,
            map: self.map,
            pilot: PilotConfig {
                bold: case.bold || self.pilot.bold,
                ..self.pilot
            },
            seed,
        };
        let outcome = drive.run()?;
        let quality = outcome.quality;
        let (found, found_after_s, accused) = diagnosed(case, &outcome.events);
        Ok(Trial {
            world: seed,
            reached: outcome.reached,
            collisions: outcome.collisions,
            min_clearance_mm: outcome.min_clearance_mm,
            error: quality.error,
            speed_deviation: quality.speed_deviation,
            mean_speed: quality.mean_speed,
            route_m: quality.route_m,
            time_s: quality.time_s,
            failing: case.failing as u32,
            found,
            found_after_s,
            accused,
        })
    }
}

/// Returns the number of failed sensors that were diagnosed, the seconds until all of them were, and the
/// number of sound sensors that were diagnosed as failed.
fn diagnosed(case: &Case, events: &[Event]) -> (u32, Option<f64>, u32) {
    let failed: Vec<&str> = case
        .sensors
        .split('+')
        .filter(|name| !name.is_empty())
        .collect();
    let since = |name: &str, wanted: fn(&'static str) -> EventKind| {
        let named = NAMES.into_iter().find(|own| *own == name).map(wanted);
        let mut events = events.iter().filter(|event| Some(event.what) == named);
        events.next().map(|event| event.time_s)
    };
    let (mut found, mut after, mut accused) = (0, Some(0.0_f64), 0);
    for name in NAMES {
        let named = since(name, EventKind::Distrusted);
        if !failed.contains(&name) {
            accused += u32::from(named.is_some());
            continue;
        }
        found += u32::from(named.is_some());
        let took = named.zip(since(name, EventKind::FaultBegan));
        let took = took.map(|(named, began)| (named - began).max(0.0));
        after = after.zip(took).map(|(after, took)| after.max(took));
    }
    (found, after.filter(|_| !failed.is_empty()), accused)
}

impl Summary {
    /// Computes the statistics of `trials` of the cases that `name`, `failing`, `health` and `bold` describe.
    #[must_use]
    pub fn of(name: &str, failing: &str, health: HealthMode, bold: bool, trials: &[Trial]) -> Self {
        let spread = |value: &dyn Fn(&Trial) -> Option<f64>| {
            let values: Vec<f64> = trials.iter().filter_map(value).collect();
            (!values.is_empty()).then(|| Spread::of(&values))
        };
        Self {
            name: name.to_owned(),
            failing: failing.to_owned(),
            health_mode: health.name(),
            bold,
            runs: trials.len(),
            reached: trials.iter().filter(|trial| trial.reached).count(),
            collisions: trials.iter().map(|trial| u64::from(trial.collisions)).sum(),
            error: spread(&|trial| Some(trial.error)),
            time_s: spread(&|trial| trial.time_s),
            speed_deviation: spread(&|trial| Some(trial.speed_deviation)),
            route_m: spread(&|trial| trial.route_m),
            mean_speed: spread(&|trial| Some(trial.mean_speed)),
            found: (
                trials.iter().map(|trial| u64::from(trial.found)).sum(),
                trials.iter().map(|trial| u64::from(trial.failing)).sum(),
            ),
            found_after_s: spread(&|trial| trial.found_after_s),
            accused: trials.iter().map(|trial| u64::from(trial.accused)).sum(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failures_are_all_singles_and_pairs_by_kind_and_mode() {
        let cases = Study::failures().unwrap();
        assert_eq!(cases.len(), (7 + 21) * KINDS.len() * 3);
        let pairs = cases.iter().filter(|case| case.failing == 2).count();
        assert_eq!(pairs, 21 * KINDS.len() * 3);
        for case in &cases {
            let faults = if case.name == "near-noisy" { 2 } else { 1 };
            assert_eq!(case.faults.len(), faults * case.failing);
        }
    }

    #[test]
    fn the_number_of_threads_changes_nothing() {
        let study = Study {
            seed: 3,
            worlds: 3,
            map: MapSource::Beams,
            pilot: PilotConfig::default(),
        };
        let case = &Study::simulations().unwrap()[0];
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap().install(|| study.drive(case).unwrap())
        };
        assert_eq!(on(1), on(2));
    }
}
