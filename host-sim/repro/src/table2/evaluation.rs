//! The evaluation in many worlds, its six figures, and which factors decide them.

use super::factors::{EvaluationSetup, FACTORS, Level};
use super::repetition::{Estimator, Metric, Oracles, Repetition};
use crate::statistics::Spread;
use certainty_sim::fusion::Method;
use certainty_sim::simulation::Score;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// The methods of \[001\] Table 2, in its order.
pub const PRINTED_METHODS: [Method; 3] = [Method::Bayes, Method::Robust, Method::Median];

/// MAE and MSE of Bayesian fusion, the robust and the fault-tolerant (median) certainty grid.
///
/// Units: certainties of 0 to 1, as in [`Score`]; the paper prints thousandths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures([f64; 6]);

impl Figures {
    /// The figures that Table 2 of \[001\] prints.
    pub const PRINTED: Self = Self([0.101, 0.069, 0.022, 0.012, 0.009, 0.006]);

    /// The names of the figures, in their order.
    pub const NAMES: [&'static str; 6] = [
        "bayes MAE",
        "bayes MSE",
        "robust MAE",
        "robust MSE",
        "median MAE",
        "median MSE",
    ];

    /// Largest relative difference from the printed figure that counts as reproduced.
    pub const NEAR: f64 = 0.25;

    const ZERO: Self = Self([0.0; 6]);

    /// Creates the figures from the scores of [`PRINTED_METHODS`].
    #[must_use]
    pub fn of(scores: [&Score; 3]) -> Self {
        let [bayes, robust, median] = scores;
        Self([
            bayes.mae, bayes.mse, robust.mae, robust.mse, median.mae, median.mse,
        ])
    }

    /// Returns them in the order of [`Self::NAMES`].
    #[must_use]
    pub const fn values(&self) -> [f64; 6] {
        self.0
    }

    /// Returns each divided by that of `other`.
    #[must_use]
    pub fn over(&self, other: &Self) -> [f64; 6] {
        core::array::from_fn(|n| self.0[n] / other.0[n])
    }

    /// Returns which figures are reproduced: within [`Self::NEAR`] of the printed ones.
    #[must_use]
    pub fn near(&self) -> [bool; 6] {
        self.over(&Self::PRINTED)
            .map(|ratio| (ratio - 1.0).abs() <= Self::NEAR)
    }

    /// Returns whether they are in the paper's order, by MAE and by MSE: median below robust below
    /// Bayes.
    #[must_use]
    pub fn in_the_papers_order(&self) -> bool {
        let [bayes, robust, median] = [0, 2, 4].map(|n| (self.0[n], self.0[n + 1]));
        let below = |a: (f64, f64), b: (f64, f64)| a.0 < b.0 && a.1 < b.1;
        below(median, robust) && below(robust, bayes)
    }

    fn plus(&self, other: &Self) -> Self {
        Self(core::array::from_fn(|n| self.0[n] + other.0[n]))
    }

    fn divided(&self, count: u32) -> Self {
        Self(self.0.map(|sum| sum / f64::from(count)))
    }
}

/// Returns a ratio or its inverse, whichever is 1 or more.
fn factor(ratio: f64) -> f64 {
    ratio.max(1.0 / ratio)
}

/// An estimator's figures over all worlds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EstimatorFigures {
    /// The estimator.
    pub estimator: Estimator,
    /// The mean over the worlds.
    pub mean: Score,
    /// The standard deviation of a world's figures; none for a single world.
    pub deviation: Option<Score>,
    /// The mean distance between its grid of perfect readings and the landmarks of the same readings.
    pub floor: Score,
    /// Its mean MAE less the oracle's; negative if it is nearer to the reference.
    pub to_oracle: f64,
}

/// The result of the evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// The set-up.
    pub setup: EvaluationSetup,
    /// The readings that every estimator received in a world.
    pub readings: usize,
    /// Every one of [`Estimator::ALL`], in its order.
    pub estimators: Vec<EstimatorFigures>,
    worlds: Vec<Repetition>,
}

/// Metrics of every estimator: the set-up's, and the floor.
const METRICS: usize = 2;

impl Evaluation {
    /// Repeats the evaluation in `worlds` worlds and calls `done` after each.
    ///
    /// Worlds are run in parallel on rayon's threads and summed in their order, so the figures do not
    /// depend on the number of threads.
    pub fn run(setup: EvaluationSetup, seed: u64, worlds: u32, done: impl Fn() + Sync) -> Self {
        let oracles = Oracles::count(&setup, seed);
        let metrics: [_; METRICS] = [Metric::of(&setup), Metric::FLOOR];
        let repeated = (0..worlds).into_par_iter().map(|number| {
            let all = &Estimator::ALL;
            let world = Repetition::run(&setup, &oracles, all, &metrics, seed, number);
            done();
            world
        });
        let worlds: Vec<_> = repeated.collect();
        let estimators = Estimator::ALL.into_iter().enumerate();
        let estimators = estimators.map(|(place, estimator)| {
            let place = place * METRICS;
            let scores = worlds.iter().map(|world| &world.scores[place]);
            let (mean, deviation) = mean_and_deviation(scores);
            let floors = worlds.iter().map(|world| &world.scores[place + 1]);
            let (floor, _) = mean_and_deviation(floors);
            EstimatorFigures {
                estimator,
                mean,
                deviation,
                floor,
                to_oracle: 0.0,
            }
        });
        let mut estimators: Vec<_> = estimators.collect();
        let oracle = estimators.last().map_or(0.0, |oracle| oracle.mean.mae);
        for row in &mut estimators {
            row.to_oracle = row.mean.mae - oracle;
        }
        Self {
            setup,
            readings: worlds.first().map_or(0, |world| world.readings),
            estimators,
            worlds,
        }
    }

    /// Returns each world's scores, one for every one of [`Estimator::ALL`].
    #[must_use]
    pub fn worlds(&self) -> impl ExactSizeIterator<Item = Vec<Score>> {
        let of_world = |world: &Repetition| {
            let scores = world.scores.iter().step_by(METRICS);
            scores.copied().collect()
        };
        self.worlds.iter().map(of_world)
    }

    /// Returns the six figures that the paper prints.
    #[must_use]
    pub fn figures(&self) -> Figures {
        Figures::of(printed_places().map(|place| &self.estimators[place].mean))
    }

    /// Returns the share of the worlds in which the methods come in the paper's order, by MAE and by
    /// MSE.
    #[must_use]
    pub fn order_held_in(&self) -> f64 {
        let in_order = |world: &Vec<Score>| {
            let scores = printed_places().map(|place| &world[place]);
            Figures::of(scores).in_the_papers_order()
        };
        let held = self.worlds().filter(in_order).count();
        held as f64 / self.worlds.len().max(1) as f64
    }
}

/// The places of [`PRINTED_METHODS`] in [`Estimator::ALL`].
fn printed_places() -> [usize; 3] {
    let place = |wanted| Method::ALL.iter().position(|&method| method == wanted);
    PRINTED_METHODS.map(|method| place(method).unwrap_or(0)) // every method is listed
}

/// Mean and standard deviation (with n − 1) of each figure.
fn mean_and_deviation<'a>(
    scores: impl ExactSizeIterator<Item = &'a Score> + Clone,
) -> (Score, Option<Score>) {
    let count = scores.len();
    let parts: [fn(&Score) -> f64; 4] = [
        |score| score.mae,
        |score| score.mse,
        |score| score.missed,
        |score| score.ghost,
    ];
    let spreads = parts.map(|part| Spread::of(&scores.clone().map(part).collect::<Vec<_>>()));
    let score = |part: fn(&Spread) -> f64| {
        let [mae, mse, missed, ghost] = spreads.each_ref().map(part);
        Score {
            mae,
            mse,
            missed,
            ghost,
        }
    };
    (
        score(|spread| spread.mean),
        (count > 1).then(|| score(|spread| spread.sd)),
    )
}

/// The primary set-up, or one that differs from it in a single level.
#[derive(Debug, Clone, Copy)]
pub struct Variation {
    /// The factor's name and its level; none for the primary set-up.
    pub change: Option<(&'static str, &'static Level)>,
    /// The mean figures over the worlds.
    pub figures: Figures,
    /// The figure with the largest ratio to the primary set-up's, as an index of [`Figures::NAMES`], and
    /// that ratio.
    pub moved_most: Option<(usize, f64)>,
}

/// Every changed level, after none for the primary set-up.
fn changes() -> impl Iterator<Item = Option<(&'static str, &'static Level)>> {
    let of_factors = FACTORS.iter().flat_map(|factor| {
        let levels = factor.levels[1..].iter();
        levels.map(|level| Some((factor.name, level)))
    });
    core::iter::once(None).chain(of_factors)
}

/// Returns the number of steps that [`variations`] reports.
#[must_use]
pub fn variations_steps(worlds: u32) -> u64 {
    changes().count() as u64 * u64::from(worlds)
}

/// Returns the primary set-up and all that differ from it in one level, each in `worlds` worlds; calls
/// `done` after each world of each.
pub fn variations(seed: u64, worlds: u32, done: impl Fn() + Sync) -> Vec<Variation> {
    let figures = changes().map(|change| {
        let setup = match change {
            Some((_, level)) => EvaluationSetup::PRIMARY.with(level),
            None => EvaluationSetup::PRIMARY,
        };
        (change, mean_figures(&setup, seed, worlds, &done))
    });
    let mut variations: Vec<Variation> = Vec::new();
    for (change, figures) in figures {
        let moved_most = variations.first().and_then(|primary| {
            let ratios = figures.over(&primary.figures).into_iter().enumerate();
            ratios.max_by(|a, b| factor(a.1).total_cmp(&factor(b.1)))
        });
        variations.push(Variation {
            change,
            figures,
            moved_most,
        });
    }
    variations
}

/// The printed methods' mean figures of a set-up, summed in the order of the worlds.
fn mean_figures(
    setup: &EvaluationSetup,
    seed: u64,
    worlds: u32,
    done: &(impl Fn() + Sync),
) -> Figures {
    let estimators = PRINTED_METHODS.map(Estimator::Method);
    let metrics = [Metric::of(setup)];
    let oracles = Oracles::default(); // no estimator needs one
    let each = (0..worlds).into_par_iter().map(|number| {
        let scores = Repetition::run(setup, &oracles, &estimators, &metrics, seed, number).scores;
        done();
        Figures::of([0, 1, 2].map(|place| &scores[place]))
    });
    let each: Vec<Figures> = each.collect();
    let sum = each
        .iter()
        .fold(Figures::ZERO, |sum, world| sum.plus(world));
    sum.divided(worlds.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_printed_figures_are_near_and_in_order() {
        let printed = Figures::PRINTED;
        assert_eq!(printed.near(), [true; 6]);
        assert!(printed.in_the_papers_order());
    }

    #[test]
    fn a_factor_is_1_or_more_either_way() {
        assert_eq!([factor(0.25), factor(3.0), factor(1.0)], [4.0, 3.0, 1.0]);
        assert_eq!(factor(0.0), f64::INFINITY);
        let mut off = Figures::PRINTED;
        off.0[3] = 0.003; // a quarter
        off.0[0] = 0.303; // three times
        assert_eq!(off.near(), [false, true, true, false, true, true]);
    }

    #[test]
    fn near_is_a_quarter_more_or_less() {
        let scaled = |by: f64| Figures(Figures::PRINTED.0.map(|figure| figure * by)).near();
        assert_eq!([scaled(0.76), scaled(1.24)], [[true; 6]; 2]);
        assert_eq!([scaled(0.74), scaled(1.26)], [[false; 6]; 2]);
    }

    #[test]
    fn the_order_holds_by_mae_and_mse() {
        let mut mixed = Figures::PRINTED;
        mixed.0[5] = 0.013; // the median's MSE above the robust grid's
        assert!(!mixed.in_the_papers_order());
    }

    #[test]
    fn deviations_are_those_of_a_sample() {
        let scores = [0.1, 0.2, 0.6].map(|mae| Score { mae, ..Score::ZERO });
        let (mean, deviation) = mean_and_deviation(scores.iter());
        assert!((mean.mae - 0.3).abs() < 1e-12);
        assert!((deviation.unwrap().mae - 0.07_f64.sqrt()).abs() < 1e-12);
        assert_eq!(mean_and_deviation(scores[..1].iter()).1, None);
    }

    #[test]
    fn the_oracle_is_last_with_distance_zero() {
        let evaluation = Evaluation::run(EvaluationSetup::PRIMARY, 5, 2, || {});
        let rows = evaluation.estimators.iter();
        let estimators: Vec<_> = rows.map(|row| row.estimator).collect();
        assert_eq!(estimators, Estimator::ALL);
        let [bayes, .., oracle] = evaluation.estimators.as_slice() else {
            panic!("{estimators:?}");
        };
        let last = (oracle.estimator, oracle.to_oracle);
        assert_eq!(last, (Estimator::Oracle, 0.0));
        assert_eq!(bayes.to_oracle, bayes.mean.mae - oracle.mean.mae);
    }

    #[test]
    fn the_number_of_threads_changes_no_figure() {
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let pool = pool.build().unwrap();
            pool.install(|| Evaluation::run(EvaluationSetup::PRIMARY, 5, 7, || {}))
        };
        assert_eq!(run(1), run(3));
    }

    #[test]
    fn a_variation_has_the_figures_of_its_setup() {
        let all = variations(4, 3, || {});
        for variation in all.iter().filter(|each| {
            let name = each.change.map(|(_, level)| level.name);
            name.is_none_or(|name| name == "hard")
        }) {
            let setup = match variation.change {
                Some((_, level)) => EvaluationSetup::PRIMARY.with(level),
                None => EvaluationSetup::PRIMARY,
            };
            let alone = Evaluation::run(setup, 4, 3, || {});
            assert_eq!(variation.figures, alone.figures());
        }
    }

    #[test]
    fn hard_evidence_moves_bayes_and_nothing_else() {
        let all = variations(1, 2, || {});
        let primary = all[0].figures.values();
        let hard = all.iter().find(|each| {
            each.change
                .is_some_and(|(factor, level)| (factor, level.name) == ("evidence", "hard"))
        });
        let hard = hard.unwrap();
        assert_eq!(hard.figures.values()[2..], primary[2..]);
        let (figure, ratio) = hard.moved_most.unwrap();
        assert!(figure < 2);
        assert_eq!(ratio, hard.figures.values()[figure] / primary[figure]);
        assert_eq!(all[0].moved_most, None);
    }

    #[test]
    fn every_world_of_every_variation_is_one_step() {
        use core::sync::atomic::{AtomicU64, Ordering::Relaxed};
        let done = AtomicU64::new(0);
        let count = || {
            done.fetch_add(1, Relaxed);
        };
        let all = variations(2, 1, count);
        assert_eq!(done.load(Relaxed), variations_steps(1));
        assert_eq!(all.len() as u64, variations_steps(1));
    }
}
