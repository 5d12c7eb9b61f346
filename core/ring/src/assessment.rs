//! Which sonars are removed, which return, and what that does to their health (\[003\] §7).

use super::confidence::{RingRules, intersection_based, simulation_based};
use super::distances::Distances;
use super::ring::Ring;
use certainty_core::health::{Claim, Health, HealthRules};
use certainty_core::sensor::SensorId;
use certainty_core::units::Ticks;
use core::fmt;

/// What an assessment concludes about a sonar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Verdict {
    /// Something confirms it, as before.
    Sound,
    /// Nothing confirms it any more, or too little: declared faulty and removed.
    Removed,
    /// Still nothing confirms it.
    StillRemoved,
    /// Something confirms it again: it counts again from the next assessment on.
    Reinstated,
}

impl Verdict {
    /// Tells whether the sonar is out of use.
    #[must_use]
    pub const fn is_faulty(self) -> bool {
        matches!(self, Self::Removed | Self::StillRemoved)
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Sound => "sound",
            Self::Removed => "removed",
            Self::StillRemoved => "still removed",
            Self::Reinstated => "reinstated",
        })
    }
}

/// The three confidence vectors of one scan, and what follows from them.
///
/// Memory: 3 bytes a sonar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Assessment<const SENSORS: usize> {
    simulation: [u8; SENSORS],
    intersection: [u8; SENSORS],
    verdicts: [Verdict; SENSORS],
}

impl<const SENSORS: usize> Assessment<SENSORS> {
    /// Returns the simulation-based confidence vector (\[003\] §5), 0 to 7 a sonar.
    #[must_use]
    pub const fn simulation_based(&self) -> &[u8; SENSORS] {
        &self.simulation
    }

    /// Returns the intersection-based confidence vector (\[003\] §6), 0 to 35 a sonar in the paper's ring.
    #[must_use]
    pub const fn intersection_based(&self) -> &[u8; SENSORS] {
        &self.intersection
    }

    /// Returns the overall confidence vector (\[003\] §7): the sum of the two others.
    #[must_use]
    pub fn overall(&self) -> [u8; SENSORS] {
        overall(&self.simulation, &self.intersection)
    }

    /// Returns what is concluded about each sonar.
    #[must_use]
    pub const fn verdicts(&self) -> &[Verdict; SENSORS] {
        &self.verdicts
    }

    /// Returns the numbers of the sonars that are out of use.
    pub fn faulty(&self) -> impl Iterator<Item = SensorId> + '_ {
        let numbered = self.verdicts.iter().zip(1..=u8::MAX);
        numbered.filter_map(|(verdict, number)| {
            let sensor = SensorId::try_new(number);
            sensor.filter(|_| verdict.is_faulty())
        })
    }
}

/// Adds the two confidence vectors (\[003\] §7).
#[must_use]
pub fn overall<const SENSORS: usize>(
    simulation: &[u8; SENSORS],
    intersection: &[u8; SENSORS],
) -> [u8; SENSORS] {
    let mut sums = *simulation;
    for (sum, &more) in sums.iter_mut().zip(intersection) {
        *sum = sum.saturating_add(more);
    }
    sums
}

/// Watches a ring over scans: remembers which sonars are removed.
///
/// Memory: one byte a sonar, and the rules.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Monitor<const SENSORS: usize> {
    removed: [bool; SENSORS],
    rules: RingRules,
}

impl<const SENSORS: usize> Monitor<SENSORS> {
    /// Creates a monitor that has removed none.
    #[must_use]
    pub const fn new(rules: RingRules) -> Self {
        Self {
            removed: [false; SENSORS],
            rules,
        }
    }

    /// Returns the rules.
    #[must_use]
    pub const fn rules(&self) -> &RingRules {
        &self.rules
    }

    /// Returns which sonars are removed.
    #[must_use]
    pub const fn removed(&self) -> &[bool; SENSORS] {
        &self.removed
    }

    /// Assesses every sonar by one scan (\[003\] §7).
    ///
    /// A sonar that nothing confirms is declared faulty and removed; from the next assessment on its
    /// paths no longer count for its neighbours. It itself is assessed on, by the paths to sonars that
    /// are in use, and reinstated when something confirms it again. Without `expected`, the echoes are
    /// held against each other only.
    pub fn assess(
        &mut self,
        ring: &Ring<SENSORS>,
        expected: Option<&Distances<SENSORS>>,
        heard: &Distances<SENSORS>,
    ) -> Assessment<SENSORS> {
        let simulation = expected.map_or([0; SENSORS], |expected| {
            simulation_based(ring, expected, heard, &self.removed, &self.rules)
        });
        let intersection = intersection_based(ring, heard, &self.removed, &self.rules);
        self.conclude(simulation, intersection)
    }

    /// Concludes from the two confidence vectors (\[003\] §7), wherever they come from.
    pub fn conclude(
        &mut self,
        simulation: [u8; SENSORS],
        intersection: [u8; SENSORS],
    ) -> Assessment<SENSORS> {
        let mut verdicts = [Verdict::Sound; SENSORS];
        let sums = overall(&simulation, &intersection);
        let least = self.rules.config().least;
        let sonars = verdicts.iter_mut().zip(&mut self.removed).zip(sums);
        for ((verdict, removed), sum) in sonars {
            *verdict = match (*removed, sum >= least) {
                (false, false) => Verdict::Removed,
                (true, false) => Verdict::StillRemoved,
                (true, true) => Verdict::Reinstated,
                (false, true) => Verdict::Sound,
            };
            *removed = verdict.is_faulty();
        }
        Assessment {
            simulation,
            intersection,
            verdicts,
        }
    }

    /// Tells the sonars' health what an assessment found, and settles it.
    ///
    /// `health` lists the sonars in the order of their numbers: the same [`Health`] that a certainty
    /// grid keeps of its sensors, such as [`Mapper::health_mut`](certainty_core::fusion::Mapper::health_mut) gives.
    /// One assessment is one confirmation or one contradiction. That readings came is recorded by who
    /// took them, a mapper or [`Health::record`].
    pub fn tell(
        &self,
        assessment: &Assessment<SENSORS>,
        health: &mut [Health],
        health_rules: &HealthRules,
        now: Ticks,
    ) {
        let learning = self.rules.learning();
        for (verdict, health) in assessment.verdicts.iter().zip(health) {
            // The other side is the rest of the ring, of which no record is kept.
            let ring = &mut Health::default();
            if verdict.is_faulty() {
                Health::contradict([health, ring], [Claim::Occupied, Claim::Free], &learning);
            } else {
                Health::confirm([health, ring], Claim::Occupied, &learning);
            }
            health.settle(health_rules, now);
        }
    }
}

#[cfg(test)]
mod tests;
