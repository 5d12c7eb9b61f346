//! The paper's whole evaluation, once.

use super::{Choices, Oracles, Standard};
use certainty_core::certainty::Certainty;
use certainty_sim::fusion::{FusionRules, Landmarks, Method};
use certainty_sim::random::{Purpose, stream};
use certainty_sim::simulation::{Run, Score, ScoredCells};
use certainty_sim::transducer::SensorSet;
use certainty_sim::world::World;
use rand::Rng;
use std::sync::Arc;

/// The crews of \[001\] §6.2: "systems with 3, 4, and 5 sensors".
pub(super) const CREWS: [&str; 3] = ["3", "4", "5"];

/// Who makes a map of a run's readings.
///
/// Two that compare equal make the same map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Teller<'a>(Who<'a>);

#[derive(Debug, Clone, Copy, PartialEq)]
enum Who<'a> {
    Method { method: Method, rules: FusionRules },
    Oracle(&'a Oracles),
}

impl<'a> Teller<'a> {
    /// Creates what `choices` make of a method; choices that are none of the method's play no part.
    #[must_use]
    pub fn new(method: Method, choices: &Choices) -> Self {
        let plain = FusionRules::default();
        let chosen = choices.rules();
        let rules = match method {
            Method::Bayes => FusionRules {
                own: plain.own,
                middle: plain.middle,
                ..chosen
            },
            Method::Robust => plain,
            Method::Trimmed => FusionRules {
                landmarks: Landmarks::Bounded,
                middle: plain.middle,
                ..chosen
            },
            Method::Median => FusionRules {
                own: chosen.own,
                own_strongest: chosen.own_strongest,
                middle: chosen.middle,
                ..plain
            },
        };
        Self(Who::Method { method, rules })
    }

    /// Creates the one that is told the sensors' rates.
    #[must_use]
    pub const fn oracle(oracles: &'a Oracles) -> Self {
        Self(Who::Oracle(oracles))
    }

    /// Returns the map that it makes.
    fn map(&self, run: &Run) -> Vec<Certainty> {
        match &self.0 {
            Who::Method { method, rules } => run.map_by(*method, rules),
            Who::Oracle(oracles) => oracles.map(run),
        }
    }
}

/// Whose readings make the map, what it is compared with, and in which cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Measure {
    readings: Readings,
    standard: Standard,
    scored: ScoredCells,
}

/// Whose readings make the map that is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Readings {
    Real,
    Perfect,
}

impl Measure {
    /// What a method makes of perfect readings, from the landmarks of the same readings: the distance
    /// that no sensor's error has a part in.
    pub const FLOOR: Self = Self {
        readings: Readings::Perfect,
        standard: Standard::Landmarks,
        scored: ScoredCells::All,
    };

    /// Creates the measure that `choices` take.
    #[must_use]
    pub const fn of(choices: &Choices) -> Self {
        Self {
            readings: Readings::Real,
            standard: choices.reference,
            scored: choices.scored,
        }
    }
}

/// What one repetition came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Repetition {
    /// The readings that every method was given.
    pub readings: usize,
    /// The mean over the grids: of each teller by each measure, the first teller's first.
    pub scores: Vec<Score>,
}

/// Repeats the evaluation: all crews in all layouts, every grid by every teller.
///
/// The seed and the number name the worlds and the sensors' errors. Choices that leave the looks as
/// they are see the same ones, so that set-ups differ by what was chosen and not by chance.
///
/// # Panics
///
/// Never: every set-up of [`Choices`] can be run.
#[must_use]
pub fn repetition(
    choices: &Choices,
    tellers: &[Teller<'_>],
    measures: &[Measure],
    seed: u64,
    number: u32,
) -> Repetition {
    let mut seeds = stream(seed, Purpose::Repetition, 0, number);
    let mut total = Repetition {
        readings: 0,
        scores: vec![Score::ZERO; tellers.len() * measures.len()],
    };
    let mut grids = 0;
    for _ in 0..choices.sweeps.layouts() {
        for run in in_one_layout(choices, &mut seeds) {
            total.readings += run.readings.len();
            total.add(&run, tellers, measures);
            grids += 1;
        }
    }
    for score in &mut total.scores {
        *score = score.over(f64::from(grids));
    }
    total
}

/// Runs every crew in the layout that comes next.
pub(super) fn in_one_layout(choices: &Choices, seeds: &mut impl Rng) -> [Run; CREWS.len()] {
    let world = World::random(&choices.obstacles.layout(), seeds.next_u64());
    let world = Arc::new(world.expect("there is room for so few obstacles"));
    CREWS.map(|crew| {
        let crew: SensorSet = crew.parse().expect("a crew of Table 1");
        let setup = choices.setup(Arc::clone(&world), crew, seeds.next_u64());
        setup.run().expect("every crew has a sensor 2")
    })
}

impl Repetition {
    /// Adds one run's grids.
    fn add(&mut self, run: &Run, tellers: &[Teller<'_>], measures: &[Measure]) {
        let truth = run.reference.cells();
        let landmarks: Vec<_> = truth.iter().map(|cell| cell.certainty()).collect();
        let needs_perfect = |measure: &Measure| {
            measure.readings == Readings::Perfect || measure.standard == Standard::SameMethod
        };
        let perfect = measures.iter().any(needs_perfect);
        let perfect = perfect.then(|| run.of_perfect_sensors());
        let mut sums = self.scores.iter_mut();
        for teller in tellers {
            let real = teller.map(run);
            let of_perfect = perfect.as_ref().map(|perfect| teller.map(perfect));
            let of_perfect = of_perfect.as_ref().unwrap_or(&landmarks);
            for (measure, sum) in measures.iter().zip(&mut sums) {
                let map = match measure.readings {
                    Readings::Real => &real,
                    Readings::Perfect => of_perfect,
                };
                let ideal = match measure.standard {
                    Standard::Landmarks => &landmarks,
                    Standard::SameMethod => of_perfect,
                };
                *sum = sum.plus(&Score::against(map, ideal, truth, measure.scored));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Evidence, Open, Sweeps};
    use super::*;
    use certainty_sim::fusion::Own;

    fn primary(seed: u64, number: u32) -> Repetition {
        let tellers = Method::ALL.map(|method| Teller::new(method, &Choices::PRIMARY));
        let measures = [Measure::of(&Choices::PRIMARY)];
        repetition(&Choices::PRIMARY, &tellers, &measures, seed, number)
    }

    #[test]
    fn every_division_really_takes_1560_readings() {
        for &sweeps in Sweeps::ALL {
            let choices = Choices {
                sweeps,
                ..Choices::PRIMARY
            };
            assert_eq!(repetition(&choices, &[], &[], 1, 0).readings, 1560);
        }
    }

    #[test]
    fn seed_and_number_name_the_repetition() {
        assert_eq!(primary(1, 0), primary(1, 0));
        assert_ne!(primary(1, 0), primary(1, 1));
        assert_ne!(primary(1, 0), primary(2, 0));
    }

    #[test]
    fn who_else_tells_and_measures_changes_no_score() {
        let choices = Choices::PRIMARY;
        let median = Teller::new(Method::Median, &choices);
        let all = primary(3, 0).scores;
        let measures = [
            Measure {
                readings: Readings::Real,
                standard: Standard::SameMethod,
                scored: ScoredCells::Known,
            },
            Measure::of(&choices),
        ];
        let alone = repetition(&choices, &[median], &measures, 3, 0).scores;
        assert_eq!(alone[1], all[3]);
    }

    #[test]
    fn perfect_readings_fused_alike_are_no_distance_from_themselves() {
        let world = Arc::new(World::built_in());
        let run = Choices::PRIMARY
            .setup(world, SensorSet::default(), 1)
            .run()
            .unwrap();
        let perfect = run.of_perfect_sensors();
        let tellers = Method::ALL.map(|method| Teller::new(method, &Choices::PRIMARY));
        let measure = Measure {
            standard: Standard::SameMethod,
            ..Measure::of(&Choices::PRIMARY)
        };
        let mut total = Repetition {
            readings: 0,
            scores: vec![Score::ZERO; 4],
        };
        total.add(&perfect, &tellers, &[measure]);
        assert!(total.scores.iter().all(|score| score.mae == 0.0));
        total.add(&run, &tellers, &[measure]);
        assert!(total.scores.iter().all(|score| score.mae > 0.0));
    }

    #[test]
    fn the_floor_is_what_perfect_readings_come_to() {
        let world = Arc::new(World::built_in());
        let run = Choices::PRIMARY.setup(world, SensorSet::default(), 1).run();
        let perfect = run.unwrap().of_perfect_sensors();
        let teller = Teller::new(Method::Robust, &Choices::PRIMARY);
        let mut total = Repetition {
            readings: 0,
            scores: vec![Score::ZERO; 2],
        };
        let measures = [Measure::FLOOR, Measure::of(&Choices::PRIMARY)];
        total.add(&perfect, &[teller], &measures);
        assert_eq!(total.scores[0], total.scores[1]);
        assert!(total.scores[0].mae > 0.0);
    }

    #[test]
    fn choices_that_are_none_of_a_methods_make_the_same_teller() {
        let changed = Choices {
            evidence: Evidence::Hard,
            own: Own::Latest,
            ..Choices::PRIMARY
        };
        let same = |method, choices| {
            Teller::new(method, &Choices::PRIMARY) == Teller::new(method, choices)
        };
        assert!(same(Method::Robust, &changed));
        assert!(!same(Method::Bayes, &changed) && !same(Method::Median, &changed));
        let own = Choices {
            own: Own::Latest,
            ..Choices::PRIMARY
        };
        assert!(same(Method::Bayes, &own));
    }
}
