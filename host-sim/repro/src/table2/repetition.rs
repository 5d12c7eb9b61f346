//! The paper's whole evaluation, once: every estimator's grids by every metric.

use super::factors::{EvaluationSetup, ReferenceGrid};
use crate::Oracle;
use certainty_core::certainty::Certainty;
use certainty_sim::fusion::Method;
use certainty_sim::random::{Purpose, stream};
use certainty_sim::simulation::{Run, Score, ScoredCells};
use certainty_sim::transducer::SensorSet;
use certainty_sim::world::World;
use core::fmt;
use rand::Rng;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use std::sync::Arc;

/// The sets of sensors of \[001\] §6.2: "systems with 3, 4, and 5 sensors".
const SENSOR_SETS: [&str; 3] = ["3", "4", "5"];

/// A method that makes a grid from a run's readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Estimator {
    /// A fusion method.
    Method(Method),
    /// An [oracle](crate::Oracle) for each set of sensors.
    Oracle,
}

impl Estimator {
    /// The methods in the order of [`Method::ALL`], then the oracle.
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

    /// Returns its grid of the run.
    fn map(self, run: &Run, setup: &EvaluationSetup, oracles: &Oracles) -> Vec<Certainty> {
        match self {
            Self::Method(method) => run.map_by(method, &setup.rules(method)),
            Self::Oracle => oracles.map(run),
        }
    }
}

impl fmt::Display for Estimator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Which readings make the grid, what it is compared with, and in which cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Metric {
    readings: Readings,
    reference: ReferenceGrid,
    scored: ScoredCells,
}

/// Whose readings make the grid that is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Readings {
    Real,
    Perfect,
}

impl Metric {
    /// The distance between an estimator's grid of perfect readings and the landmarks of the same
    /// readings: the part of the error that no sensor causes.
    pub(super) const FLOOR: Self = Self {
        readings: Readings::Perfect,
        reference: ReferenceGrid::Landmarks,
        scored: ScoredCells::All,
    };

    /// Creates the metric of `setup`.
    pub(super) const fn of(setup: &EvaluationSetup) -> Self {
        Self {
            readings: Readings::Real,
            reference: setup.reference,
            scored: setup.scored,
        }
    }
}

/// The result of one repetition.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Repetition {
    /// The readings that every estimator received.
    pub(super) readings: usize,
    /// The mean over the grids: of each estimator by each metric, the first estimator's first.
    pub(super) scores: Vec<Score>,
}

impl Repetition {
    /// Runs the evaluation: all sets of sensors in all layouts, every grid by every estimator.
    ///
    /// The seed and the number name the worlds and the sensors' errors. Set-ups with the same looks have
    /// the same worlds and errors, so that they differ by their levels and not by chance.
    pub(super) fn run(
        setup: &EvaluationSetup,
        oracles: &Oracles,
        estimators: &[Estimator],
        metrics: &[Metric],
        seed: u64,
        number: u32,
    ) -> Self {
        let mut seeds = stream(seed, Purpose::Repetition, 0, number);
        let mut total = Self {
            readings: 0,
            scores: vec![Score::ZERO; estimators.len() * metrics.len()],
        };
        let mut grids = 0;
        for _ in 0..setup.division.layouts {
            for run in in_one_layout(setup, &mut seeds) {
                total.readings += run.readings.len();
                total.add(&run, setup, oracles, estimators, metrics);
                grids += 1;
            }
        }
        for score in &mut total.scores {
            *score = score.over(f64::from(grids));
        }
        total
    }

    /// Adds one run's grids.
    fn add(
        &mut self,
        run: &Run,
        setup: &EvaluationSetup,
        oracles: &Oracles,
        estimators: &[Estimator],
        metrics: &[Metric],
    ) {
        let truth = run.reference.cells();
        let landmarks: Vec<_> = truth.iter().map(|cell| cell.certainty()).collect();
        let needs_perfect = |metric: &Metric| {
            metric.readings == Readings::Perfect || metric.reference == ReferenceGrid::SameMethod
        };
        let perfect = metrics.iter().any(needs_perfect);
        let perfect = perfect.then(|| run.of_perfect_sensors());
        let mut sums = self.scores.iter_mut();
        for estimator in estimators {
            let real = estimator.map(run, setup, oracles);
            let of_perfect = perfect
                .as_ref()
                .map(|perfect| estimator.map(perfect, setup, oracles));
            let of_perfect = of_perfect.as_ref().unwrap_or(&landmarks);
            for (metric, sum) in metrics.iter().zip(&mut sums) {
                let map = match metric.readings {
                    Readings::Real => &real,
                    Readings::Perfect => of_perfect,
                };
                let ideal = match metric.reference {
                    ReferenceGrid::Landmarks => &landmarks,
                    ReferenceGrid::SameMethod => of_perfect,
                };
                *sum = sum.plus(&Score::against(map, ideal, truth, metric.scored));
            }
        }
    }
}

/// Runs every set of sensors in the layout that comes next.
fn in_one_layout(setup: &EvaluationSetup, seeds: &mut impl Rng) -> [Run; SENSOR_SETS.len()] {
    let world = World::random(&setup.obstacles.layout(), seeds.next_u64());
    let world = Arc::new(world.expect("the area has room for seven obstacles"));
    SENSOR_SETS.map(|sensors| {
        let sensors: SensorSet = sensors.parse().expect("a set of sensors of Table 1");
        let run = setup.run_setup(Arc::clone(&world), sensors, seeds.next_u64());
        run.run().expect("every set has a sensor 2")
    })
}

/// An [`Oracle`] for each set of sensors, with error rates of layouts that no repetition uses.
///
/// Each set has its own because a rate belongs to a sensor at its place, and the places differ.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Oracles(Vec<(usize, Oracle)>);

/// Layouts in which the rates are counted, with the readings of one set of sensors each.
const LAYOUTS: u32 = 40;
/// The stream of their seeds; the repetitions' is 0.
const HELD_OUT: u8 = 1;

impl Oracles {
    /// Counts the rates of each set of sensors in `setup`.
    pub(super) fn count(setup: &EvaluationSetup, seed: u64) -> Self {
        let layouts = (0..LAYOUTS).into_par_iter().map(|number| {
            let mut seeds = stream(seed, Purpose::Repetition, HELD_OUT, number);
            in_one_layout(setup, &mut seeds)
        });
        let layouts: Vec<_> = layouts.collect();
        let mut by_set: [Vec<Run>; SENSOR_SETS.len()] = Default::default();
        for runs in layouts {
            for (of_set, run) in by_set.iter_mut().zip(runs) {
                of_set.push(run);
            }
        }
        let oracles = by_set.iter().map(|runs| {
            let sensors = runs.first().map_or(0, |run| run.models.len());
            (sensors, Oracle::count(runs))
        });
        Self(oracles.collect())
    }

    /// Returns the grid by the oracle of the run's set of sensors; *uncertain* if there is none.
    fn map(&self, run: &Run) -> Vec<Certainty> {
        let of_set = |(sensors, _): &&(usize, Oracle)| *sensors == run.models.len();
        match self.0.iter().find(of_set) {
            Some((_, oracle)) => oracle.fuse(run),
            None => vec![Certainty::UNCERTAIN; run.reference.cells().len()],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::factors::FACTORS;
    use super::*;

    const PRIMARY: EvaluationSetup = EvaluationSetup::PRIMARY;

    fn repeat(setup: &EvaluationSetup, seed: u64, number: u32) -> Repetition {
        let metrics = [Metric::of(setup)];
        Repetition::run(
            setup,
            &Oracles::default(),
            &methods(),
            &metrics,
            seed,
            number,
        )
    }

    fn methods() -> [Estimator; 4] {
        Method::ALL.map(Estimator::Method)
    }

    /// A run of three sensors in the built-in scene.
    fn run() -> Run {
        let world = Arc::new(World::built_in());
        PRIMARY
            .run_setup(world, SensorSet::default(), 1)
            .run()
            .unwrap()
    }

    /// The scores of one run.
    fn scores(run: &Run, estimators: &[Estimator], metrics: &[Metric]) -> Vec<Score> {
        let mut total = Repetition {
            readings: 0,
            scores: vec![Score::ZERO; estimators.len() * metrics.len()],
        };
        total.add(run, &PRIMARY, &Oracles::default(), estimators, metrics);
        total.scores
    }

    #[test]
    fn every_division_takes_1560_readings() {
        let sweeps = FACTORS.into_iter().find(|factor| factor.name == "sweeps");
        for level in sweeps.unwrap().levels {
            let setup = PRIMARY.with(level);
            let repetition = Repetition::run(&setup, &Oracles::default(), &[], &[], 1, 0);
            assert_eq!(repetition.readings, 1560);
        }
    }

    #[test]
    fn every_level_changes_some_score() {
        let primary = repeat(&PRIMARY, 1, 0).scores;
        for factor in FACTORS {
            for level in &factor.levels[1..] {
                let changed = repeat(&PRIMARY.with(level), 1, 0).scores;
                assert_ne!(changed, primary, "{} {}", factor.name, level.name);
            }
        }
    }

    #[test]
    fn seed_and_number_name_the_repetition() {
        let primary = |seed, number| repeat(&PRIMARY, seed, number);
        assert_eq!(primary(1, 0), primary(1, 0));
        assert_ne!(primary(1, 0), primary(1, 1));
        assert_ne!(primary(1, 0), primary(2, 0));
    }

    #[test]
    fn other_estimators_and_metrics_change_no_score() {
        let all = repeat(&PRIMARY, 3, 0).scores;
        let metrics = [
            Metric {
                readings: Readings::Real,
                reference: ReferenceGrid::SameMethod,
                scored: ScoredCells::Known,
            },
            Metric::of(&PRIMARY),
        ];
        let median = [Estimator::Method(Method::Median)];
        let alone = Repetition::run(&PRIMARY, &Oracles::default(), &median, &metrics, 3, 0);
        assert_eq!(alone.scores[1], all[3]);
    }

    #[test]
    fn perfect_readings_have_no_distance_from_themselves() {
        let run = run();
        let metrics = [Metric {
            reference: ReferenceGrid::SameMethod,
            ..Metric::of(&PRIMARY)
        }];
        let of_perfect = scores(&run.of_perfect_sensors(), &methods(), &metrics);
        assert!(of_perfect.iter().all(|score| score.mae == 0.0));
        let real = scores(&run, &methods(), &metrics);
        assert!(real.iter().all(|score| score.mae > 0.0));
    }

    #[test]
    fn the_floor_is_the_score_of_perfect_readings() {
        let robust = [Estimator::Method(Method::Robust)];
        let metrics = [Metric::FLOOR, Metric::of(&PRIMARY)];
        let scores = scores(&run().of_perfect_sensors(), &robust, &metrics);
        assert_eq!(scores[0], scores[1]);
        assert!(scores[0].mae > 0.0);
    }

    #[test]
    fn every_set_of_sensors_has_an_oracle() {
        let oracles = Oracles::count(&PRIMARY, 1);
        let sensors: Vec<_> = oracles.0.iter().map(|&(sensors, _)| sensors).collect();
        assert_eq!(sensors, [3, 4, 5]);
        let mut seeds = stream(1, Purpose::Repetition, 0, 0);
        for run in in_one_layout(&PRIMARY, &mut seeds) {
            let cells = oracles.map(&run);
            assert!(cells.iter().any(|&cell| cell != Certainty::UNCERTAIN));
        }
    }

    #[test]
    fn no_world_is_held_out() {
        let first = |sensor: u8, number| stream(1, Purpose::Repetition, sensor, number).next_u64();
        let held_out: Vec<_> = (0..LAYOUTS).map(|n| first(HELD_OUT, n)).collect();
        assert!((0..100).all(|number| !held_out.contains(&first(0, number))));
    }
}
