//! What the control level is told of the car's senses.

use super::rules::{GOAL, OBSTACLE, SIGHT};
use crate::smart_car::{HEADS, RANGERS};
use certainty_core::control::{
    Command, Controller, Dated, Failure, Failures, Signal, Situation, scan_of_map,
};
use certainty_core::fusion::{CertaintyGrid, Environment};
use certainty_core::health::{Health, HealthConfig};
use certainty_core::transducer::{Missing, Reading};
use certainty_core::units::{Pose, Ticks};

/// A fixed ranger, as control hears it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::smart_car) struct Eye {
    pub(in crate::smart_car) reading: Reading,
    /// When it measured.
    pub(in crate::smart_car) measured: Ticks,
    pub(in crate::smart_car) health: Health,
}

/// A round's senses, besides the map.
pub(super) struct Seen<'a> {
    pub(super) now: Ticks,
    /// Where the car is when it does what is decided.
    pub(super) pose: Pose,
    /// Which heads said nothing in this round, the first on the right.
    pub(super) silent: &'a [bool; HEADS as usize],
    /// The first on the right.
    pub(super) rangers: &'a [Eye; RANGERS as usize],
}

impl Seen<'_> {
    /// Lets `controller` decide.
    ///
    /// What 101 beams meet in the map is the scanner of \[004\]; the rangers are its rangefinders 1, on the
    /// left, and 6. Its other four do not exist: *missing*, and failed for good.
    pub(super) fn step<G: CertaintyGrid>(
        &self,
        controller: &mut Controller,
        map: &Environment<'_, G>,
    ) -> Command {
        let scan = scan_of_map(map, self.pose, SIGHT, OBSTACLE);
        let absent = Dated {
            what: Reading::Missing(Missing::Timeout),
            at: self.now,
        };
        let [right, left] = self.rangers.map(|ranger| Dated {
            what: ranger.reading,
            at: ranger.measured,
        });
        controller.step(&Situation {
            now: self.now,
            pose: self.pose,
            goal: GOAL,
            rangefinders: [left, absent, absent, absent, absent, right],
            scan: Dated {
                what: &scan,
                at: self.now,
            },
            failures: self.failures(map),
        })
    }

    /// How far each sense has failed.
    ///
    /// The map has failed as far as its heads have in the mean: each sweeps all of what lies ahead, so with
    /// one of three gone a third of the looks is missing. A head that says nothing in this round is gone for
    /// this round, before its health gives it up.
    fn failures<G: CertaintyGrid>(&self, map: &Environment<'_, G>) -> Failures {
        const LIMITS: HealthConfig = HealthConfig::DEFAULT;
        let heads = map.sensors().zip(self.silent);
        let sum = heads.fold(Signal::ZERO, |sum, ((_, health), &silent)| {
            let failure = if silent {
                Failure::TOTAL
            } else {
                Failure::of_health(health, &LIMITS)
            };
            sum.saturating_add(failure.part())
        });
        let mean = sum.checked_div_int(HEADS.into()).unwrap_or(Signal::ONE);
        let [right, left] = self
            .rangers
            .map(|ranger| Failure::of_health(&ranger.health, &LIMITS));
        let absent = Failure::TOTAL;
        Failures {
            rangefinders: [left, absent, absent, absent, absent, right],
            scanner: Failure::new_saturating(mean),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smart_car::{CELLS, POSE, SENSORS, SmartCarShape};
    use certainty_core::fusion::{BayesGrid, Strength};
    use certainty_core::health::Confidence;

    const NOW: Ticks = Ticks::new(1000);

    fn eye(reading: Reading) -> Eye {
        Eye {
            reading,
            measured: Ticks::new(900),
            health: Health::default(),
        }
    }

    /// What fails with these heads silent, this confidence of all, and these rangers.
    fn failures(silent: [bool; 3], confidence: u16, rangers: [Eye; 2]) -> Failures {
        let grid = BayesGrid::try_new(SmartCarShape, Strength::UNLIMITED, [0; CELLS]).unwrap();
        let health = [Health::new(Confidence::from_bits(confidence)); SENSORS as usize];
        let seen = Seen {
            now: NOW,
            pose: POSE,
            silent: &silent,
            rangers: &rangers,
        };
        seen.failures(&Environment::new(&grid, &health))
    }

    #[test]
    fn the_map_has_failed_as_far_as_its_heads_have_in_the_mean() {
        let sound = [eye(Reading::NoObject); 2];
        let scanner =
            |silent, confidence| failures(silent, confidence, sound).scanner.part().to_bits();
        assert_eq!(scanner([false; 3], u16::MAX), 0);
        assert_eq!(scanner([true, false, false], u16::MAX), 65_536 / 3);
        assert_eq!(scanner([true; 3], u16::MAX), 65_536);
        // No confidence is as good as silence.
        assert_eq!(scanner([false; 3], 0), 65_536);
    }

    #[test]
    fn what_the_car_does_not_have_has_failed_and_what_it_has_is_on_its_side() {
        let mut broken = eye(Reading::NoObject);
        broken.health = Health::new(Confidence::NONE);
        let told = failures([false; 3], u16::MAX, [broken, eye(Reading::NoObject)]);
        assert_eq!(told.rangefinders[0], Failure::NONE, "the left ranger");
        assert_eq!(told.rangefinders[5], Failure::TOTAL, "the right one");
        assert_eq!(told.rangefinders[1..5], [Failure::TOTAL; 4]);
    }
}
