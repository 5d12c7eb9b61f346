//! The evaluation in many worlds: means and standard deviations.

use super::factors::EvaluationSetup;
use super::figures::{Figures, PRINTED_METHODS};
use super::repetition::{Estimator, Metric, Oracles, Repetition};
use certainty_sim::fusion::Method;
use certainty_sim::simulation::Score;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

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
    let count = scores.len() as f64;
    let mean = scores
        .clone()
        .fold(Score::ZERO, |sum, score| sum.plus(score));
    let mean = mean.over(count.max(1.0));
    let squared = |figure: f64, mean: f64| (figure - mean) * (figure - mean);
    let squares = scores.fold(Score::ZERO, |sum, score| {
        sum.plus(&Score {
            mae: squared(score.mae, mean.mae),
            mse: squared(score.mse, mean.mse),
            missed: squared(score.missed, mean.missed),
            ghost: squared(score.ghost, mean.ghost),
        })
    });
    let variance = squares.over((count - 1.0).max(1.0));
    let deviation = Score {
        mae: variance.mae.sqrt(),
        mse: variance.mse.sqrt(),
        missed: variance.missed.sqrt(),
        ghost: variance.ghost.sqrt(),
    };
    (mean, (count > 1.0).then_some(deviation))
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
