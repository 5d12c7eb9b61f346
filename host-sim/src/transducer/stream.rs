//! Random numbers that do not depend on who else draws some.
//!
//! Every sensor, and every fault of a sensor, draws from a stream of its own: adding a sensor or a
//! fault changes no other's draws, so that a faulty run differs from its healthy twin in the fault
//! alone.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// What the numbers of a stream are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// A simulated sensor's errors.
    Transducer,
    /// A fault's whims.
    Fault,
    /// Where obstacles stand.
    Layout,
    /// What an evaluation draws lots for.
    Choice,
    /// The seeds of an evaluation's runs.
    Repetition,
    /// Noise of laser scanners.
    Laser,
    /// How a robot's wheels slip.
    Slip,
}

/// Returns the stream of `sensor`'s `part` for `purpose`, in the run that `seed` names.
///
/// Streams of `ChaCha8` with the same key are disjoint: 2^64 of them, each of 2^68 bytes.
#[must_use]
pub fn stream(seed: u64, purpose: Purpose, sensor: u8, part: u32) -> ChaCha8Rng {
    let purpose = match purpose {
        Purpose::Transducer => 0_u64,
        Purpose::Fault => 1,
        Purpose::Layout => 2,
        Purpose::Choice => 4,
        Purpose::Repetition => 3,
        Purpose::Laser => 5,
        Purpose::Slip => 6,
    };
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(purpose << 40 | u64::from(part) << 8 | u64::from(sensor));
    rng
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;

    #[test]
    fn no_two_streams_of_a_run_agree() {
        let mut first: Vec<u64> = Vec::new();
        let purposes = [
            Purpose::Transducer,
            Purpose::Fault,
            Purpose::Layout,
            Purpose::Choice,
            Purpose::Repetition,
            Purpose::Laser,
            Purpose::Slip,
        ];
        for purpose in purposes {
            for sensor in [0, 1, 255] {
                for part in [0, 1, u32::MAX] {
                    first.push(stream(7, purpose, sensor, part).next_u64());
                }
            }
        }
        let streams = first.len();
        first.sort_unstable();
        first.dedup();
        assert_eq!(first.len(), streams);
    }

    #[test]
    fn the_seed_names_the_run() {
        let draw = |seed| stream(seed, Purpose::Transducer, 1, 0).next_u64();
        assert_eq!(draw(1), draw(1));
        assert_ne!(draw(1), draw(2));
    }
}
