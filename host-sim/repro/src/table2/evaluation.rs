//! The evaluation in many worlds: means, and how much they scatter.

use super::{Choices, Figures, Measure, Oracles, PRINTED_METHODS, Repetition, Teller, repetition};
use certainty_sim::fusion::Method;
use certainty_sim::simulation::Score;
use core::fmt;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// Who fuses: a method, or the oracle beside them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fuser {
    /// A method.
    Method(Method),
    /// An [oracle](crate::Oracle) for each crew.
    Oracle,
}

impl Fuser {
    /// The methods in the order of [`Method::ALL`], and last the oracle.
    pub const ALL: [Self; Method::ALL.len() + 1] = {
        let mut all = [Self::Oracle; Method::ALL.len() + 1];
        let mut place = 0;
        while place < Method::ALL.len() {
            all[place] = Self::Method(Method::ALL[place]);
            place += 1;
        }
        all
    };

    /// Returns its name in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Method(method) => method.name(),
            Self::Oracle => "oracle",
        }
    }
}

impl fmt::Display for Fuser {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A method's (or the oracle's) figures over all worlds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MethodFigures {
    /// Whose figures.
    pub method: Fuser,
    /// The mean over the worlds.
    pub mean: Score,
    /// The standard deviation of a world's figures; none of a single world.
    pub deviation: Option<Score>,
    /// The mean of what it makes of perfect readings: see [`Measure::FLOOR`].
    pub floor: Score,
    /// Its mean MAE less the oracle's; negative where it is nearer.
    pub to_oracle: f64,
}

/// What the evaluation came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// The set-up.
    pub choices: Choices,
    /// The readings that every method was given in a world.
    pub readings: usize,
    /// Everyone of [`Fuser::ALL`], in its order.
    pub methods: Vec<MethodFigures>,
    worlds: Vec<Repetition>,
}

/// The score by the set-up's measure and the floor, of everyone.
const MEASURES: usize = 2;

impl Evaluation {
    /// Repeats the evaluation in `worlds` worlds; `done` hears of each.
    ///
    /// Worlds are shared out among rayon's threads and summed in their order: the figures do not
    /// depend on how many threads there are.
    pub fn run(choices: Choices, seed: u64, worlds: u32, done: impl Fn() + Sync) -> Self {
        let oracles = Oracles::told(&choices, seed);
        let tellers = Fuser::ALL.map(|fuser| match fuser {
            Fuser::Method(method) => Teller::new(method, &choices),
            Fuser::Oracle => Teller::oracle(&oracles),
        });
        let measures: [_; MEASURES] = [Measure::of(&choices), Measure::FLOOR];
        let repeated = (0..worlds).into_par_iter().map(|number| {
            let world = repetition(&choices, &tellers, &measures, seed, number);
            done();
            world
        });
        let worlds: Vec<_> = repeated.collect();
        let methods = Fuser::ALL.into_iter().enumerate();
        let methods = methods.map(|(place, method)| {
            let place = place * MEASURES;
            let scores = worlds.iter().map(|world| &world.scores[place]);
            let (mean, deviation) = mean_and_deviation(scores);
            let floors = worlds.iter().map(|world| &world.scores[place + 1]);
            let (floor, _) = mean_and_deviation(floors);
            MethodFigures {
                method,
                mean,
                deviation,
                floor,
                to_oracle: 0.0,
            }
        });
        let mut methods: Vec<_> = methods.collect();
        let oracle = methods.last().map_or(0.0, |oracle| oracle.mean.mae);
        for row in &mut methods {
            row.to_oracle = row.mean.mae - oracle;
        }
        Self {
            choices,
            readings: worlds.first().map_or(0, |world| world.readings),
            methods,
            worlds,
        }
    }

    /// Returns each world's scores, one for everyone of [`Fuser::ALL`].
    #[must_use]
    pub fn worlds(&self) -> impl ExactSizeIterator<Item = Vec<Score>> {
        let of_methods = |world: &Repetition| {
            let scores = world.scores.iter().step_by(MEASURES);
            scores.copied().collect()
        };
        self.worlds.iter().map(of_methods)
    }

    /// Returns the six figures that the paper prints.
    ///
    /// # Panics
    ///
    /// Never: every method is evaluated.
    #[must_use]
    pub fn figures(&self) -> Figures {
        let found = PRINTED_METHODS.map(|wanted| {
            let wanted = Fuser::Method(wanted);
            let figures = self.methods.iter().find(|row| row.method == wanted);
            &figures.expect("every method is evaluated").mean
        });
        Figures::of(found)
    }

    /// Returns the share of the worlds in which the methods come in the paper's order, by MAE and by
    /// MSE.
    #[must_use]
    pub fn order_held_in(&self) -> f64 {
        let place = |wanted| Method::ALL.iter().position(|&method| method == wanted);
        let places = PRINTED_METHODS.map(|method| place(method).unwrap_or(0));
        let in_order = |world: &Vec<Score>| {
            let scores = places.map(|place| &world[place]);
            Figures::of(scores).in_the_papers_order()
        };
        let held = self.worlds().filter(in_order).count();
        held as f64 / self.worlds.len().max(1) as f64
    }
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
    fn the_oracle_is_last_and_no_distance_from_itself() {
        let evaluation = Evaluation::run(Choices::PRIMARY, 5, 2, || {});
        let fusers: Vec<_> = evaluation.methods.iter().map(|row| row.method).collect();
        assert_eq!(fusers, Fuser::ALL);
        let [bayes, .., oracle] = evaluation.methods.as_slice() else {
            panic!("{fusers:?}");
        };
        assert_eq!((oracle.method, oracle.to_oracle), (Fuser::Oracle, 0.0));
        assert_eq!(bayes.to_oracle, bayes.mean.mae - oracle.mean.mae);
    }

    #[test]
    fn threads_change_no_figure() {
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let pool = pool.build().unwrap();
            pool.install(|| Evaluation::run(Choices::PRIMARY, 5, 7, || {}))
        };
        assert_eq!(run(1), run(3));
    }
}
