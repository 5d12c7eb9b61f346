//! The report as JSON; its fields are a contract.

use super::Sensitivity;
use crate::output;
use certainty_repro::table2::{
    Candidate, Evaluation, Figures, MethodFigures, Neighbour, PRINTED_METHODS, Search,
};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Names and what they stand for.
type Named = BTreeMap<&'static str, &'static str>;

#[derive(Debug, Serialize)]
pub(super) struct Report {
    seed: u64,
    worlds: usize,
    readings_per_method: usize,
    methods: Vec<MethodReport>,
    paper: Vec<PaperReport>,
    /// Whether the means come in the paper's order, by MAE and by MSE.
    order_holds: bool,
    /// The share of the worlds in which they do.
    order_held_in: f64,
    choices: Named,
    #[serde(skip_serializing_if = "Option::is_none")]
    sensitivity: Option<SensitivityReport>,
    files: Vec<String>,
}

/// Deviations are over the worlds, and null for a single one.
#[derive(Debug, Serialize)]
struct MethodReport {
    name: &'static str,
    mae: f64,
    mae_sd: Option<f64>,
    mse: f64,
    mse_sd: Option<f64>,
    missed: f64,
    ghost: f64,
    /// MAE and MSE of what the method makes of perfect readings.
    floor_mae: f64,
    floor_mse: f64,
    /// MAE less the oracle's.
    to_oracle: f64,
}

#[derive(Debug, Serialize)]
struct PaperReport {
    name: &'static str,
    mae: f64,
    mse: f64,
}

#[derive(Debug, Serialize)]
struct SensitivityReport {
    worlds: u32,
    /// The names of the figures in every list of six.
    figures: [&'static str; 6],
    /// The first is the primary set-up.
    one_at_a_time: Vec<NeighbourReport>,
    search: SearchReport,
    answer: String,
}

#[derive(Debug, Serialize)]
struct NeighbourReport {
    choice: Option<&'static str>,
    alternative: Option<&'static str>,
    reason: Option<&'static str>,
    against: Option<&'static str>,
    figures: [f64; 6],
    near: [bool; 6],
    moved_most: Option<MovedReport>,
}

#[derive(Debug, Serialize)]
struct MovedReport {
    figure: &'static str,
    ratio: f64,
}

#[derive(Debug, Serialize)]
struct SearchReport {
    screened: usize,
    /// How many of them the text allows, and how many of those come in the paper's order.
    allowed: usize,
    in_order: usize,
    finalists: usize,
    /// Whether all six figures of the best set-up are near the printed ones.
    reproduces: bool,
    best: CandidateReport,
    /// The choice that decides most comes first.
    by_choice: Vec<ChoiceReport>,
}

#[derive(Debug, Serialize)]
struct ChoiceReport {
    choice: &'static str,
    /// The worst factor given the worst alternative over that given the best one.
    decides: f64,
    alternatives: Vec<AlternativeReport>,
}

#[derive(Debug, Serialize)]
struct AlternativeReport {
    alternative: &'static str,
    against: Option<&'static str>,
    /// The share of the set-ups with it that come in the paper's order.
    in_order: f64,
    best: CandidateReport,
}

#[derive(Debug, Serialize)]
struct CandidateReport {
    choices: Named,
    figures: [f64; 6],
    near: [bool; 6],
    worst_factor: f64,
}

impl Report {
    pub(super) fn new(
        seed: u64,
        evaluation: &Evaluation,
        sensitivity: Option<&Sensitivity>,
        files: &[PathBuf],
    ) -> Self {
        Self {
            seed,
            worlds: evaluation.worlds().len(),
            readings_per_method: evaluation.readings,
            methods: evaluation.methods.iter().map(MethodReport::from).collect(),
            paper: paper(),
            order_holds: evaluation.figures().in_the_papers_order(),
            order_held_in: evaluation.order_held_in(),
            choices: evaluation.choices.names(),
            sensitivity: sensitivity.map(SensitivityReport::from),
            files: output::listed(files),
        }
    }
}

impl From<&MethodFigures> for MethodReport {
    fn from(row: &MethodFigures) -> Self {
        Self {
            name: row.method.name(),
            mae: row.mean.mae,
            mae_sd: row.deviation.map(|score| score.mae),
            mse: row.mean.mse,
            mse_sd: row.deviation.map(|score| score.mse),
            missed: row.mean.missed,
            ghost: row.mean.ghost,
            floor_mae: row.floor.mae,
            floor_mse: row.floor.mse,
            to_oracle: row.to_oracle,
        }
    }
}

/// Table 2 as it is printed.
fn paper() -> Vec<PaperReport> {
    let printed = Figures::PRINTED.values();
    let (pairs, _) = printed.as_chunks::<2>();
    let rows = PRINTED_METHODS.iter().zip(pairs);
    let report = rows.map(|(method, &[mae, mse])| PaperReport {
        name: method.name(),
        mae,
        mse,
    });
    report.collect()
}

impl From<&Sensitivity> for SensitivityReport {
    fn from(sensitivity: &Sensitivity) -> Self {
        let neighbours = sensitivity.neighbours.iter();
        Self {
            worlds: sensitivity.worlds,
            figures: Figures::NAMES,
            one_at_a_time: neighbours.map(NeighbourReport::from).collect(),
            search: SearchReport::from(&sensitivity.search),
            answer: super::told::answer(&sensitivity.search),
        }
    }
}

impl From<&Neighbour> for NeighbourReport {
    fn from(neighbour: &Neighbour) -> Self {
        let (choice, to) = neighbour.departure.unzip();
        Self {
            choice,
            alternative: to.map(|to| to.name),
            reason: to.map(|to| to.reason),
            against: to.and_then(|to| to.against),
            figures: neighbour.figures.values(),
            near: neighbour.figures.near(),
            moved_most: neighbour.moved_most.map(|(figure, ratio)| MovedReport {
                figure: Figures::NAMES[figure],
                ratio,
            }),
        }
    }
}

impl From<&Search> for SearchReport {
    fn from(search: &Search) -> Self {
        let by_choice = search.deciding().into_iter().map(|(choice, decides)| {
            let given = search.given.iter();
            let given = given.filter(|given| given.choice.name == choice.name);
            let alternatives = given.map(|given| {
                let alternative = choice.alternative(given.place);
                AlternativeReport {
                    alternative: alternative.name,
                    against: alternative.against,
                    in_order: given.in_order,
                    best: CandidateReport::from(&given.best),
                }
            });
            ChoiceReport {
                choice: choice.name,
                decides,
                alternatives: alternatives.collect(),
            }
        });
        Self {
            screened: search.screened,
            allowed: search.allowed,
            in_order: search.in_order,
            finalists: search.finalists,
            reproduces: search.reproduces(),
            best: CandidateReport::from(&search.best),
            by_choice: by_choice.collect(),
        }
    }
}

impl From<&Candidate> for CandidateReport {
    fn from(candidate: &Candidate) -> Self {
        Self {
            choices: candidate.choices.names(),
            figures: candidate.figures.values(),
            near: candidate.figures.near(),
            worst_factor: candidate.figures.worst_factor(),
        }
    }
}
