//! Independent streams of random numbers.
//!
//! Every sensor, and every fault of a sensor, has a stream of its own: adding a sensor or a fault changes no
//! other's numbers, so a faulty run differs from its healthy twin in the fault only.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// The use of a stream's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// A simulated sensor's errors.
    Transducer,
    /// A fault of a sensor.
    Fault,
    /// The places of obstacles.
    Layout,
    /// The random choices of an evaluation.
    Choice,
    /// The seeds of an evaluation's runs.
    Repetition,
    /// Noise of laser scanners.
    Laser,
    /// The slip of a robot's wheels.
    Slip,
}

/// Returns the stream of `sensor`'s `part` for `purpose`, in the run with this `seed`.
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
    fn all_streams_of_a_run_differ() {
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
    fn a_stream_depends_on_the_seed() {
        let draw = |seed| stream(seed, Purpose::Transducer, 1, 0).next_u64();
        assert_eq!(draw(1), draw(1));
        assert_ne!(draw(1), draw(2));
    }
}
