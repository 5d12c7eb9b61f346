//! Bayes that is told what no robot can know: the limit for whoever learns.

use certainty_core::certainty::Certainty;
use certainty_core::fusion::{Beam, Cell};
use certainty_core::transducer::Reading;
use certainty_firmware::smart_car::FARTHEST;
use certainty_sim::simulation::{Run, SimulatedReading, Truth};

/// Eq. 1 of \[001\] with every sensor's true error rates, in real numbers.
///
/// A word about a cell counts by how much more often *this* sensor says it of occupied cells than of
/// free ones: ln(P(word | occupied) / P(word | free)). The rates are counted in other runs of the same
/// kind, against the truth, apart for every sensor, for sound and for spoilt readings and for four
/// distances. So the oracle knows at every reading whether a fault spoils it, and what such a reading
/// is worth. What it does not know is which reading errs by chance.
///
/// *Uncertain* behind an echo says nothing, as in eq. 1, and a cell of which nothing is known has even
/// odds. It is a limit for maps that fuse cell by cell and take readings as independent; nothing keeps a
/// method from beating it in a measure that it does not aim at.
#[derive(Debug, Clone, PartialEq)]
pub struct Oracle {
    /// Of each kind of reading, the weight of each word, in nat.
    weights: Vec<[f64; WORDS]>,
}

/// Words of an echo's beam: free, rather free, rather occupied, occupied; and free because of *no
/// object*.
const WORDS: usize = 5;
/// Parts of the range that are told apart.
const DISTANCES: usize = 4;
/// Kinds of word of one sensor: by a spoilt reading or not, and how far away.
const KINDS: usize = 2 * DISTANCES;

/// Which word a certainty is; none for *uncertain*.
fn word(reading: Reading, certainty: Certainty) -> Option<usize> {
    match (certainty, certainty.deviation()) {
        (_, ..0) if !matches!(reading, Reading::Echo(_)) => Some(4),
        (Certainty::FREE, _) => Some(0),
        (Certainty::OCCUPIED, _) => Some(3),
        (_, ..0) => Some(1),
        (_, 1..) => Some(2),
        (_, 0) => None,
    }
}

/// Calls `tell` with the kind and the word of everything that a reading says, and the cell.
fn words(run: &Run, taken: &SimulatedReading, tell: &mut impl FnMut(usize, usize, Cell)) {
    let beam = Beam::from(&taken.beam);
    let geometry = run.reference.geometry();
    let slot = taken.beam.sensor.slot();
    let first_kind = slot * KINDS + usize::from(taken.faulty) * DISTANCES;
    let model = &run.models[slot];
    beam.interpret(&geometry, model, &mut |cell: Cell, certainty: Certainty| {
        if let Some(word) = word(beam.reading, certainty) {
            let at = geometry.center(cell);
            let side = |a: i32, b: i32| f64::from(a) - f64::from(b);
            let (x, y) = (
                side(at.x_mm(), beam.origin.x_mm()),
                side(at.y_mm(), beam.origin.y_mm()),
            );
            let part = x.hypot(y) / f64::from(FARTHEST.get()) * DISTANCES as f64;
            let distance = (part as usize).min(DISTANCES - 1);
            tell(first_kind + distance, word, cell);
        }
    });
}

impl Oracle {
    /// Counts the rates in `runs`, which should be others than it will fuse, of the same crew.
    #[must_use]
    pub fn told(runs: &[Run]) -> Self {
        let crew = runs.iter().map(|run| run.models.len()).max().unwrap_or(0);
        // One of each before counting: what was never heard is rare, not impossible.
        let mut counts = vec![[[1.0; WORDS]; 2]; crew * KINDS];
        for run in runs {
            for taken in &run.readings {
                words(
                    run,
                    taken,
                    &mut |kind, word, cell| match run.reference.cells()[cell.index()] {
                        Truth::Free => counts[kind][0][word] += 1.0,
                        Truth::Occupied => counts[kind][1][word] += 1.0,
                        Truth::Unseen => {}
                    },
                );
            }
        }
        let weights = counts.iter().map(|[free, occupied]| {
            let of_free: f64 = free.iter().sum();
            let of_occupied: f64 = occupied.iter().sum();
            core::array::from_fn(|w| (occupied[w] / of_occupied / (free[w] / of_free)).ln())
        });
        Self {
            weights: weights.collect(),
        }
    }

    /// Returns its map of `run`, row after row from the lowest.
    #[must_use]
    pub fn fuse(&self, run: &Run) -> Vec<Certainty> {
        let mut odds = vec![0.0; run.reference.cells().len()];
        for taken in &run.readings {
            words(run, taken, &mut |kind, word, cell| {
                let weight = self.weights.get(kind).map_or(0.0, |weights| weights[word]);
                odds[cell.index()] += weight;
            });
        }
        let certainty = |odds: &f64| {
            let probability = 1.0 / (1.0 + (-odds).exp());
            Certainty::from_bits((probability * 256.0).round() as u8)
        };
        odds.iter().map(certainty).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_sim::fusion::Method;
    use certainty_sim::simulation::Score;
    use certainty_sim::simulation::{Length, Setup};
    use certainty_sim::transducer::SensorSet;
    use certainty_sim::world::{Layout, World};
    use std::sync::Arc;

    fn run(seed: u64, faults: &[&str]) -> Run {
        let world = World::random(&Layout::default(), seed).unwrap();
        let length = Length::Steps(37);
        let setup = Setup {
            faults: faults.iter().map(|spec| spec.parse().unwrap()).collect(),
            ..Setup::smart_car(Arc::new(world), SensorSet::default(), length, seed)
        };
        setup.run().unwrap()
    }

    /// The weight of a word about a cell in the third quarter of the range.
    fn weight(oracle: &Oracle, slot: usize, spoilt: bool, word: usize) -> f64 {
        oracle.weights[slot * KINDS + usize::from(spoilt) * DISTANCES + 2][word]
    }

    #[test]
    fn it_knows_what_each_sensor_is_worth() {
        let runs: Vec<_> = (100..140).map(|seed| run(seed, &["stuck-far:2"])).collect();
        let oracle = Oracle::told(&runs);
        // Sensor C of Table 1 sees nearly every object, A misses one in 25.
        let (free, occupied, silent) = (0, 3, 4);
        assert!(weight(&oracle, 2, false, silent) < weight(&oracle, 0, false, silent));
        assert!(
            weight(&oracle, 0, false, free) < -0.5 && weight(&oracle, 0, false, occupied) > 1.0
        );
        // A sensor that says "free" of everything says nothing.
        assert!(weight(&oracle, 1, true, silent).abs() < 0.1);
    }

    #[test]
    fn a_sensor_it_knows_to_be_stuck_costs_it_little() {
        let held_out: Vec<_> = (100..140).map(|seed| run(seed, &["stuck-far:3"])).collect();
        let oracle = Oracle::told(&held_out);
        let (mut ours, mut bayes) = (0.0, 0.0);
        for seed in 0..20 {
            let run = run(seed, &["stuck-far:3"]);
            ours += Score::of(&oracle.fuse(&run), run.reference.cells()).missed;
            bayes += run.fuse(Method::Bayes).score.missed;
        }
        assert!(ours < bayes / 2.0, "{ours} against {bayes}");
    }

    #[test]
    fn told_nothing_it_knows_nothing() {
        let run = run(1, &[]);
        let cells = Oracle::told(&[]).fuse(&run);
        assert!(cells.iter().all(|&cell| cell == Certainty::UNCERTAIN));
    }
}
