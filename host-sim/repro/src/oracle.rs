//! Bayes with each sensor's true error rates: a limit for methods that learn them.

use certainty_core::certainty::Certainty;
use certainty_core::fusion::{Beam, Cell};
use certainty_core::transducer::Reading;
use certainty_firmware::smart_car::FARTHEST;
use certainty_sim::simulation::{Run, SimulatedReading, Truth};

/// Eq. 1 of \[001\] with every sensor's true error rates, in real numbers.
///
/// A claim about a cell has the weight ln(P(claim | occupied) / P(claim | free)): how much more often
/// *this* sensor makes it of occupied cells than of free ones. The rates are counted in other runs of the
/// same kind, against the truth, separately for every sensor, for readings with and without a fault, and
/// for four distances. So the oracle has, for every reading, whether a fault affects it and how reliable
/// such a reading is. It does not have which reading errs by chance.
///
/// *Uncertain* behind an echo has no weight, as in eq. 1, and a cell without claims has even odds. It is a
/// limit for maps that fuse cell by cell and treat readings as independent; by a metric that it does not
/// minimise a method can have a smaller error.
#[derive(Debug, Clone, PartialEq)]
pub struct Oracle {
    /// Of each class of readings, the weight of each claim, in nat.
    weights: Vec<[f64; CLAIMS]>,
}

/// Claims of an echo's beam: free, rather free, rather occupied, occupied; and free by *no object*.
const CLAIMS: usize = 5;
/// Parts of the range that have rates of their own.
const DISTANCES: usize = 4;
/// Classes of one sensor's readings: with and without a fault, and by distance.
const CLASSES: usize = 2 * DISTANCES;

/// Returns the index of the claim that a certainty is; none for *uncertain*.
fn claim(reading: Reading, certainty: Certainty) -> Option<usize> {
    match (certainty, certainty.deviation()) {
        (_, ..0) if !matches!(reading, Reading::Echo(_)) => Some(4),
        (Certainty::FREE, _) => Some(0),
        (Certainty::OCCUPIED, _) => Some(3),
        (_, ..0) => Some(1),
        (_, 1..) => Some(2),
        (_, 0) => None,
    }
}

/// Calls `visit` with the class, the claim and the cell of every claim of a reading.
fn claims(run: &Run, taken: &SimulatedReading, visit: &mut impl FnMut(usize, usize, Cell)) {
    let beam = Beam::from(&taken.beam);
    let geometry = run.reference.geometry();
    let slot = taken.beam.sensor.slot();
    let first_class = slot * CLASSES + usize::from(taken.faulty) * DISTANCES;
    let model = &run.models[slot];
    beam.interpret(&geometry, model, &mut |cell: Cell, certainty: Certainty| {
        if let Some(claim) = claim(beam.reading, certainty) {
            let at = geometry.center(cell);
            let side = |a: i32, b: i32| f64::from(a) - f64::from(b);
            let (x, y) = (
                side(at.x_mm(), beam.origin.x_mm()),
                side(at.y_mm(), beam.origin.y_mm()),
            );
            let part = x.hypot(y) / f64::from(FARTHEST.get()) * DISTANCES as f64;
            let distance = (part as usize).min(DISTANCES - 1);
            visit(first_class + distance, claim, cell);
        }
    });
}

impl Oracle {
    /// Counts the rates in `runs`, which should be other runs than those to fuse, of the same sensors.
    #[must_use]
    pub fn count(runs: &[Run]) -> Self {
        let sensors = runs.iter().map(|run| run.models.len()).max().unwrap_or(0);
        // Counts start at one: a claim that never occurred is rare, not impossible.
        let mut counts = vec![[[1.0; CLAIMS]; 2]; sensors * CLASSES];
        for run in runs {
            for taken in &run.readings {
                claims(
                    run,
                    taken,
                    &mut |class, claim, cell| match run.reference.cells()[cell.index()] {
                        Truth::Free => counts[class][0][claim] += 1.0,
                        Truth::Occupied => counts[class][1][claim] += 1.0,
                        Truth::Unseen => {}
                    },
                );
            }
        }
        let weights = counts.iter().map(|[free, occupied]| {
            let of_free: f64 = free.iter().sum();
            let of_occupied: f64 = occupied.iter().sum();
            core::array::from_fn(|c| (occupied[c] / of_occupied / (free[c] / of_free)).ln())
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
            claims(run, taken, &mut |class, claim, cell| {
                let weights = self.weights.get(class);
                let weight = weights.map_or(0.0, |weights| weights[claim]);
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
    use certainty_sim::simulation::{Length, Score, Setup};
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

    /// The weight of a claim about a cell in the third quarter of the range.
    fn weight(oracle: &Oracle, slot: usize, spoilt: bool, claim: usize) -> f64 {
        oracle.weights[slot * CLASSES + usize::from(spoilt) * DISTANCES + 2][claim]
    }

    #[test]
    fn weights_follow_each_sensors_error_rates() {
        let runs: Vec<_> = (100..140).map(|seed| run(seed, &["stuck-far:2"])).collect();
        let oracle = Oracle::count(&runs);
        // Sensor C of Table 1 sees nearly every object, A misses one in 25.
        let (free, occupied, no_object) = (0, 3, 4);
        assert!(weight(&oracle, 2, false, no_object) < weight(&oracle, 0, false, no_object));
        assert!(
            weight(&oracle, 0, false, free) < -0.5 && weight(&oracle, 0, false, occupied) > 1.0
        );
        // A sensor that reports every cell free has no weight.
        assert!(weight(&oracle, 1, true, no_object).abs() < 0.1);
    }

    #[test]
    fn a_stuck_sensor_costs_the_oracle_little() {
        let held_out: Vec<_> = (100..140).map(|seed| run(seed, &["stuck-far:3"])).collect();
        let oracle = Oracle::count(&held_out);
        let (mut ours, mut bayes) = (0.0, 0.0);
        for seed in 0..20 {
            let run = run(seed, &["stuck-far:3"]);
            ours += Score::of(&oracle.fuse(&run), run.reference.cells()).missed;
            bayes += run.fuse(Method::Bayes).score.missed;
        }
        assert!(ours < bayes / 2.0, "{ours} against {bayes}");
    }

    #[test]
    fn without_runs_the_map_is_uncertain() {
        let run = run(1, &[]);
        let cells = Oracle::count(&[]).fuse(&run);
        assert!(cells.iter().all(|&cell| cell == Certainty::UNCERTAIN));
    }
}
