//! A row of the campaign: one method in one scenario, over all worlds.

use super::scenario::Scenario;
use super::trial::HealthTrial;
use crate::statistics::{Estimate, Waits};
use certainty_sim::fusion::{FusionRules, Method};
use certainty_sim::simulation::Score;
use serde::Serialize;

/// One method in one scenario, over all worlds.
///
/// The CSV file has the fields in this order; an absent value is empty there and `null` in JSON. Shares are
/// 0 to 1, and `_ci` is half of a 95 % confidence interval (Student's t). The sensors' health comes from
/// runs of a fixed length, so it is the same for every number of sweeps.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// The kind of fault, such as `stuck-near=250mm`.
    pub fault: String,
    /// Reports of a faulty sensor per report of another.
    pub rate: u32,
    /// Number of sensors.
    pub sensors: u8,
    /// `full` or `partial`.
    pub overlap: String,
    /// Number of sweeps of the map.
    pub sweeps: u32,
    /// Number of faulty sensors.
    pub faulty: u8,
    /// The method, or `oracle`.
    pub method: &'static str,
    /// The certainties that the trimmed method drops at each end.
    pub trim: Option<u8>,
    /// The seed of the first world; the others follow it.
    pub seed: u64,
    /// Number of worlds.
    pub worlds: u64,
    /// Names the program's version and the methods' rules.
    pub setup: String,
    /// Mean absolute error (\[001\] §6.2).
    pub mae: f64,
    /// Of its mean.
    pub mae_ci: Option<f64>,
    /// Mean squared error.
    pub mse: f64,
    /// Of its mean.
    pub mse_ci: Option<f64>,
    /// Share of the obstacle cells that are not occupied in the map.
    pub missed: f64,
    /// Of its mean.
    pub missed_ci: Option<f64>,
    /// Share of the free cells that are occupied in the map.
    pub ghost: f64,
    /// Of its mean.
    pub ghost_ci: Option<f64>,
    /// Its MAE less the oracle's.
    pub mae_to_oracle: f64,
    /// Its share of missed cells less the oracle's.
    pub missed_to_oracle: f64,
    /// Share of the faulty sensors that became suspect (or failed) while faulty.
    pub suspect: Option<f64>,
    /// Median number of the sensor's own turns until then.
    pub suspect_after: Option<u64>,
    /// Share of the faulty sensors that failed while faulty.
    pub failed: Option<f64>,
    /// Median number of the sensor's own turns until then.
    pub failed_after: Option<u64>,
    /// Share of the sound sensors that were ever suspect (or failed).
    pub false_suspect: Option<f64>,
    /// Share of the sound sensors that ever failed.
    pub false_failed: Option<f64>,
    /// Share of the sensors that became healthy again, of those not healthy when the fault ended.
    pub recovered: Option<f64>,
    /// Median number of the sensor's own turns from the fault's end until then.
    pub recovered_after: Option<u64>,
}

/// The fields that are the same in all rows of a campaign.
#[derive(Debug, Clone)]
pub(super) struct Common {
    pub(super) seed: u64,
    pub(super) worlds: u64,
    pub(super) setup: String,
    pub(super) fusion: FusionRules,
}

impl Common {
    /// How many certainties `method` drops at each end, if it is the trimmed one.
    fn trim(&self, sensors: u8, method: &str) -> Option<u8> {
        (method == Method::Trimmed.name()).then(|| self.fusion.trimmed(sensors))
    }
}

impl Row {
    /// The CSV file's first line, without its end.
    pub const HEADER: &str = "fault,rate,sensors,overlap,sweeps,faulty,method,trim,seed,worlds,setup,\
        mae,mae_ci,mse,mse_ci,missed,missed_ci,ghost,ghost_ci,mae_to_oracle,missed_to_oracle,\
        suspect,suspect_after,failed,failed_after,false_suspect,false_failed,recovered,\
        recovered_after";

    /// Number of fields of a line.
    pub(super) const FIELDS: usize = 29;

    /// The fields that identify a line, as they stand at its beginning.
    pub(super) fn key(scenario: &Scenario, method: &str, common: &Common) -> String {
        let Scenario {
            fault,
            rate,
            sensors,
            overlap,
            sweeps,
            faulty,
        } = scenario;
        let Common {
            seed,
            worlds,
            setup,
            ..
        } = common;
        let trim = common.trim(*sensors, method);
        let trim = trim.map_or_else(String::new, |trim| trim.to_string());
        format!(
            "{fault},{rate},{sensors},{overlap},{sweeps},{faulty},{method},{trim},{seed},{worlds},{setup},"
        )
    }

    /// The rows of a scenario: each method's, and last the oracle's.
    pub(super) fn of(
        scenario: &Scenario,
        methods: &[&'static str],
        common: &Common,
        scores: &[Vec<Score>],
        health: &[HealthTrial],
    ) -> Vec<Self> {
        let parts: [fn(&Score) -> f64; 4] = [
            |score| score.mae,
            |score| score.mse,
            |score| score.missed,
            |score| score.ghost,
        ];
        let measures = |method: usize| {
            parts.map(|part| {
                let samples = scores.iter().map(|scores| part(&scores[method]));
                let estimate = Estimate::of(&samples.collect::<Vec<_>>());
                estimate.unwrap_or(Estimate {
                    mean: f64::NAN,
                    half_width: None,
                })
            })
        };
        let [oracle_mae, _, oracle_missed, _] = measures(methods.len() - 1);
        let rows = methods.iter().enumerate().map(|(place, &method)| {
            let [mae, mse, missed, ghost] = measures(place);
            let mut row = Self {
                fault: scenario.fault.to_string(),
                rate: scenario.rate,
                sensors: scenario.sensors,
                overlap: scenario.overlap.to_string(),
                sweeps: scenario.sweeps,
                faulty: scenario.faulty,
                method,
                trim: common.trim(scenario.sensors, method),
                seed: common.seed,
                worlds: common.worlds,
                setup: common.setup.clone(),
                mae: mae.mean,
                mae_ci: mae.half_width,
                mse: mse.mean,
                mse_ci: mse.half_width,
                missed: missed.mean,
                missed_ci: missed.half_width,
                ghost: ghost.mean,
                ghost_ci: ghost.half_width,
                mae_to_oracle: mae.mean - oracle_mae.mean,
                missed_to_oracle: missed.mean - oracle_missed.mean,
                suspect: None,
                suspect_after: None,
                failed: None,
                failed_after: None,
                false_suspect: None,
                false_failed: None,
                recovered: None,
                recovered_after: None,
            };
            if method == "robust" {
                row.add_health(health);
            }
            row
        });
        rows.collect()
    }

    fn add_health(&mut self, trials: &[HealthTrial]) {
        let all = |part: fn(&HealthTrial) -> &Waits| -> Waits {
            trials
                .iter()
                .flat_map(|health| part(health).iter())
                .collect()
        };
        let suspect = all(|health| &health.suspect);
        let failed = all(|health| &health.failed);
        let recovered = all(|health| &health.recovered);
        (self.suspect, self.suspect_after) = (suspect.share(), suspect.median());
        (self.failed, self.failed_after) = (failed.share(), failed.median());
        (self.recovered, self.recovered_after) = (recovered.share(), recovered.median());
        self.false_suspect = all(|health| &health.false_suspect).share();
        self.false_failed = all(|health| &health.false_failed).share();
    }

    /// The row as a line of the CSV file, without its end.
    ///
    /// No field needs quotes: kinds of fault and methods contain neither commas nor quotes.
    #[must_use]
    pub fn line(&self) -> String {
        let share = |share: Option<f64>| share.map_or(String::new(), |share| format!("{share:.6}"));
        let count = |count: Option<u64>| count.map_or(String::new(), |count| count.to_string());
        [
            self.fault.clone(),
            self.rate.to_string(),
            self.sensors.to_string(),
            self.overlap.clone(),
            self.sweeps.to_string(),
            self.faulty.to_string(),
            self.method.to_owned(),
            count(self.trim.map(u64::from)),
            self.seed.to_string(),
            self.worlds.to_string(),
            self.setup.clone(),
            share(Some(self.mae)),
            share(self.mae_ci),
            share(Some(self.mse)),
            share(self.mse_ci),
            share(Some(self.missed)),
            share(self.missed_ci),
            share(Some(self.ghost)),
            share(self.ghost_ci),
            share(Some(self.mae_to_oracle)),
            share(Some(self.missed_to_oracle)),
            share(self.suspect),
            count(self.suspect_after),
            share(self.failed),
            count(self.failed_after),
            share(self.false_suspect),
            share(self.false_failed),
            share(self.recovered),
            count(self.recovered_after),
        ]
        .join(",")
    }
}
