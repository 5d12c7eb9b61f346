//! The oracles that stand beside the methods: one a crew.

use super::Choices;
use super::repetition::{CREWS, in_one_layout};
use crate::Oracle;
use certainty_core::certainty::Certainty;
use certainty_sim::random::{Purpose, stream};
use certainty_sim::simulation::Run;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// An [`Oracle`] for each crew, told of layouts that no repetition uses.
///
/// A crew has its own because a rate belongs to a sensor at its place, and the places differ.
#[derive(Debug, Clone, PartialEq)]
pub struct Oracles(Vec<(usize, Oracle)>);

/// Layouts that the rates are counted in, with the readings of one crew each.
const LAYOUTS: u32 = 40;
/// The stream of their seeds; the repetitions' is 0.
const HELD_OUT: u8 = 1;

impl Oracles {
    /// Tells each crew's oracle its rates in the set-up of `choices`.
    #[must_use]
    pub fn told(choices: &Choices, seed: u64) -> Self {
        let layouts = (0..LAYOUTS).into_par_iter().map(|number| {
            let mut seeds = stream(seed, Purpose::Repetition, HELD_OUT, number);
            in_one_layout(choices, &mut seeds)
        });
        let layouts: Vec<_> = layouts.collect();
        let mut of_crews: [Vec<Run>; CREWS.len()] = Default::default();
        for runs in layouts {
            for (of_crew, run) in of_crews.iter_mut().zip(runs) {
                of_crew.push(run);
            }
        }
        let oracles = of_crews.iter().map(|runs| {
            let sensors = runs.first().map_or(0, |run| run.models.len());
            (sensors, Oracle::told(runs))
        });
        Self(oracles.collect())
    }

    /// Returns the map that the oracle of the run's crew makes; *uncertain* of a crew that has none.
    pub(super) fn map(&self, run: &Run) -> Vec<Certainty> {
        let of_crew = |(sensors, _): &&(usize, Oracle)| *sensors == run.models.len();
        match self.0.iter().find(of_crew) {
            Some((_, oracle)) => oracle.fuse(run),
            None => vec![Certainty::UNCERTAIN; run.reference.cells().len()],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;

    #[test]
    fn every_crew_has_an_oracle() {
        let oracles = Oracles::told(&Choices::PRIMARY, 1);
        let sensors: Vec<_> = oracles.0.iter().map(|&(sensors, _)| sensors).collect();
        assert_eq!(sensors, [3, 4, 5]);
        let mut seeds = stream(1, Purpose::Repetition, 0, 0);
        for run in in_one_layout(&Choices::PRIMARY, &mut seeds) {
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
