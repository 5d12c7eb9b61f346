//! Which sonars are removed and which are reinstated, and how that changes their health (\[003\] §7).

use super::confidence::{intersection_based, simulation_based};
use super::distances::Distances;
use super::ring::{Ring, RingRules};
use certainty_core::health::{Claim, Health, HealthRules};
use certainty_core::sensor::SensorId;
use certainty_core::units::Ticks;
use core::fmt;

/// The conclusion of an assessment about one sonar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SonarVerdict {
    /// It has enough confirmations, as before.
    Sound,
    /// It has too few confirmations: declared faulty and removed.
    Removed,
    /// It has been removed before and still has too few confirmations.
    StillRemoved,
    /// It has been removed before and has enough confirmations again: it counts again from the next
    /// assessment on.
    Reinstated,
    /// It has too few confirmations, but was compared with the other sonars only: in the open no two echoes
    /// meet, so this is no evidence of a fault. It stays in use.
    Unverified,
}

impl SonarVerdict {
    /// Returns whether the sonar is out of use.
    #[must_use]
    pub const fn is_faulty(self) -> bool {
        matches!(self, Self::Removed | Self::StillRemoved)
    }
}

impl fmt::Display for SonarVerdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Sound => "sound",
            Self::Removed => "removed",
            Self::StillRemoved => "still removed",
            Self::Reinstated => "reinstated",
            Self::Unverified => "unverified",
        })
    }
}

/// The three confidence vectors of one scan and the verdict on each sonar.
///
/// Memory: 3 bytes per sonar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Assessment<const SENSORS: usize> {
    simulation: [u8; SENSORS],
    intersection: [u8; SENSORS],
    verdicts: [SonarVerdict; SENSORS],
}

impl<const SENSORS: usize> Assessment<SENSORS> {
    /// Returns the simulation-based confidence vector (\[003\] §5), 0 to 7 per sonar.
    #[must_use]
    pub const fn simulation_based(&self) -> &[u8; SENSORS] {
        &self.simulation
    }

    /// Returns the intersection-based confidence vector (\[003\] §6), 0 to 35 per sonar in the paper's
    /// ring.
    #[must_use]
    pub const fn intersection_based(&self) -> &[u8; SENSORS] {
        &self.intersection
    }

    /// Returns the overall confidence vector (\[003\] §7): the sum of the other two.
    #[must_use]
    pub fn overall(&self) -> [u8; SENSORS] {
        overall(&self.simulation, &self.intersection)
    }

    /// Returns the verdict on each sonar.
    #[must_use]
    pub const fn verdicts(&self) -> &[SonarVerdict; SENSORS] {
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

/// Assesses a ring scan after scan, and keeps the list of removed sonars.
///
/// Memory: one byte per sonar, and the rules.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Monitor<const SENSORS: usize> {
    removed: [bool; SENSORS],
    rules: RingRules,
}

impl<const SENSORS: usize> Monitor<SENSORS> {
    /// Creates a monitor that has removed no sonar.
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

    /// Returns, for each sonar, whether it is removed.
    #[must_use]
    pub const fn removed(&self) -> &[bool; SENSORS] {
        &self.removed
    }

    /// Assesses every sonar by one scan (\[003\] §7).
    ///
    /// A sonar with fewer confirmations than the [`RingRules`] require is declared faulty and removed; from
    /// the next assessment on, its paths no longer count for its neighbours. It is still assessed, by its
    /// paths to sonars that are in use, and reinstated when it has enough confirmations again. Without
    /// `expected`, such as without a laser, echoes are compared with each other only: a sonar with too few
    /// confirmations is then [unverified](SonarVerdict::Unverified), and none is removed.
    pub fn assess(
        &mut self,
        ring: &Ring<SENSORS>,
        expected: Option<&Distances<SENSORS>>,
        measured: &Distances<SENSORS>,
    ) -> Assessment<SENSORS> {
        let simulation = expected
            .map(|expected| simulation_based(ring, expected, measured, &self.removed, &self.rules));
        let intersection = intersection_based(ring, measured, &self.removed, &self.rules);
        self.conclude(simulation, intersection)
    }

    /// Derives the verdicts from the two confidence vectors (\[003\] §7), as [`assess`](Self::assess) does.
    pub fn conclude(
        &mut self,
        simulation: Option<[u8; SENSORS]>,
        intersection: [u8; SENSORS],
    ) -> Assessment<SENSORS> {
        let is_compared = simulation.is_some();
        let simulation = simulation.unwrap_or([0; SENSORS]);
        let mut verdicts = [SonarVerdict::Sound; SENSORS];
        let sums = overall(&simulation, &intersection);
        let least = self.rules.config().least;
        let sonars = verdicts.iter_mut().zip(&mut self.removed).zip(sums);
        for ((verdict, removed), sum) in sonars {
            *verdict = match (*removed, sum >= least) {
                (false, false) if is_compared => SonarVerdict::Removed,
                (false, false) => SonarVerdict::Unverified,
                (true, false) => SonarVerdict::StillRemoved,
                (true, true) => SonarVerdict::Reinstated,
                (false, true) => SonarVerdict::Sound,
            };
            *removed = verdict.is_faulty();
        }
        Assessment {
            simulation,
            intersection,
            verdicts,
        }
    }

    /// Records an assessment in the sonars' health, and settles it.
    ///
    /// `health` lists the sonars in the order of their numbers: the same [`Health`] that a certainty grid
    /// keeps of its sensors, such as [`Mapper::health_mut`](certainty_core::fusion::Mapper::health_mut)
    /// returns. One assessment is one confirmation or one contradiction, and nothing for an unverified sonar. The readings themselves are not
    /// recorded here: a mapper does that, or [`Health::record`].
    pub fn record(
        &self,
        assessment: &Assessment<SENSORS>,
        health: &mut [Health],
        health_rules: &HealthRules,
        now: Ticks,
    ) {
        let learning = self.rules.learning();
        for (verdict, health) in assessment.verdicts.iter().zip(health) {
            // The other party is the rest of the ring, of which no record is kept.
            let ring = &mut Health::default();
            match verdict {
                SonarVerdict::Removed | SonarVerdict::StillRemoved => {
                    Health::contradict([health, ring], [Claim::Occupied, Claim::Free], &learning);
                }
                SonarVerdict::Sound | SonarVerdict::Reinstated => {
                    Health::confirm([health, ring], Claim::Occupied, &learning);
                }
                SonarVerdict::Unverified => {}
            }
            health.settle(health_rules, now);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Echoes, RingConfig};
    use certainty_core::health::Status;
    use certainty_core::transducer::Reading;
    use certainty_core::units::Millimeters;

    /// \[003\] §5 to §7, as printed.
    const SIMULATION: [u8; 24] = [
        7, 4, 2, 2, 4, 4, 4, 6, 0, 1, 4, 3, 3, 5, 5, 3, 6, 3, 5, 7, 4, 4, 5, 7,
    ];
    const INTERSECTION: [u8; 24] = [
        15, 7, 2, 1, 0, 1, 1, 0, 1, 1, 2, 3, 4, 8, 8, 8, 6, 4, 7, 9, 6, 2, 14, 13,
    ];
    const OVERALL: [u8; 24] = [
        22, 11, 4, 3, 4, 5, 5, 6, 1, 2, 6, 6, 7, 13, 13, 11, 12, 7, 12, 16, 10, 6, 19, 20,
    ];
    /// \[003\] §7, with sensor 4 falsified.
    const FALSIFIED_SIMULATION: [u8; 24] = [
        6, 3, 2, 0, 4, 4, 4, 6, 0, 1, 4, 3, 3, 5, 5, 3, 6, 3, 5, 7, 4, 4, 5, 7,
    ];
    const FALSIFIED_INTERSECTION: [u8; 24] = [
        12, 6, 1, 0, 0, 1, 1, 0, 1, 1, 2, 3, 4, 8, 8, 8, 6, 4, 7, 9, 6, 2, 14, 13,
    ];
    const FALSIFIED_OVERALL: [u8; 24] = [
        18, 9, 3, 0, 4, 5, 5, 6, 1, 2, 6, 6, 7, 13, 13, 11, 12, 7, 12, 16, 10, 6, 19, 20,
    ];

    fn faulty(assessment: &Assessment<24>) -> Vec<u8> {
        assessment.faulty().map(SensorId::number).collect()
    }

    #[test]
    fn the_papers_vectors_add_up_and_name_sensor_4() {
        let mut monitor = Monitor::<24>::new(RingRules::DEFAULT);
        let sound = monitor.conclude(Some(SIMULATION), INTERSECTION);
        assert_eq!(sound.overall(), OVERALL);
        assert_eq!(faulty(&sound), [0_u8; 0]);

        let falsified = monitor.conclude(Some(FALSIFIED_SIMULATION), FALSIFIED_INTERSECTION);
        assert_eq!(falsified.overall(), FALSIFIED_OVERALL);
        assert_eq!(faulty(&falsified), [4]);
        assert_eq!(falsified.verdicts()[3], SonarVerdict::Removed);
        assert!(monitor.removed()[3]);

        let again = monitor.conclude(Some(FALSIFIED_SIMULATION), FALSIFIED_INTERSECTION);
        assert_eq!(again.verdicts()[3], SonarVerdict::StillRemoved);
        let fixed = monitor.conclude(Some(SIMULATION), INTERSECTION);
        assert_eq!(fixed.verdicts()[3], SonarVerdict::Reinstated);
        assert_eq!(monitor.removed(), &[false; 24]);
        let after = monitor.conclude(Some(SIMULATION), INTERSECTION);
        assert_eq!(after.verdicts(), &[SonarVerdict::Sound; 24]);
    }

    #[test]
    fn two_sound_sonars_have_under_three_confirmations() {
        let mut monitor = Monitor::<24>::new(RingRules::WARY);
        let sound = monitor.conclude(Some(SIMULATION), INTERSECTION);
        assert_eq!(faulty(&sound), [9, 10]);
        let falsified = monitor.conclude(Some(FALSIFIED_SIMULATION), FALSIFIED_INTERSECTION);
        assert_eq!(faulty(&falsified), [4, 9, 10]);
    }

    #[test]
    fn removal_and_reinstatement_take_effect_next_time() {
        let ring = Ring::<24>::try_new(RingConfig::DEFAULT).unwrap();
        let rules = RingRules::DEFAULT;
        let expected = Distances::fold(&ring, &Echoes::silent(), &rules);
        let sound = expected;
        // All paths of sonar 4 give 0.7 m where nothing is.
        let mut echoes = Echoes::<24>::silent();
        let id = |number| SensorId::try_new(number).unwrap();
        for other in [1, 2, 3, 4, 5, 6, 7] {
            let wrong = Reading::Echo(Millimeters::new(1400));
            echoes.set(id(4), id(other), wrong).unwrap();
            echoes.set(id(other), id(4), wrong).unwrap();
        }
        let wrong = Distances::fold(&ring, &echoes, &rules);

        let mut monitor = Monitor::new(rules);
        let before = monitor.assess(&ring, Some(&expected), &wrong);
        assert_eq!(before.overall()[3], 0);
        assert_eq!(before.verdicts()[3], SonarVerdict::Removed);
        // Its neighbours lose the paths to it and keep the others.
        let lost = [6, 6, 6, 0, 6, 6, 6, 7];
        assert_eq!(before.simulation_based()[..8], lost);

        // Sound again, in the next assessment it still counts for itself only.
        let back = monitor.assess(&ring, Some(&expected), &sound);
        assert_eq!(back.simulation_based()[..8], [6, 6, 6, 7, 6, 6, 6, 7]);
        assert_eq!(back.verdicts()[3], SonarVerdict::Reinstated);
        let after = monitor.assess(&ring, Some(&expected), &sound);
        assert_eq!(after.simulation_based(), &[7; 24]);
    }

    /// Without a laser, 17 of 24 sound sonars were declared faulty.
    #[test]
    fn without_expected_echoes_no_sonar_is_removed() {
        let mut monitor = Monitor::<24>::new(RingRules::DEFAULT);
        let alone = monitor.conclude(None, INTERSECTION);
        assert_eq!(faulty(&alone), [0_u8; 0]);
        let least = RingRules::DEFAULT.config().least;
        for (verdict, &count) in alone.verdicts().iter().zip(&INTERSECTION) {
            let expected = if count >= least {
                SonarVerdict::Sound
            } else {
                SonarVerdict::Unverified
            };
            assert_eq!(*verdict, expected);
        }
        // It neither confirms nor contradicts.
        let mut health = [Health::default(); 24];
        monitor.record(&alone, &mut health, &HealthRules::DEFAULT, Ticks::new(0));
        assert_eq!(
            (health[4].confirmations(), health[4].contradictions()),
            (0, 0)
        );
        // One that is removed stays so.
        let _ = monitor.conclude(Some(FALSIFIED_SIMULATION), FALSIFIED_INTERSECTION);
        let after = monitor.conclude(None, FALSIFIED_INTERSECTION);
        assert_eq!(after.verdicts()[3], SonarVerdict::StillRemoved);
    }

    #[test]
    fn health_of_a_removed_sonar_falls_fast_recovers_slow() {
        let mut monitor = Monitor::<24>::new(RingRules::DEFAULT);
        let mut health = [Health::default(); 24];
        let rules = HealthRules::DEFAULT;
        let mut statuses = vec![Status::Healthy];
        let faulty = (0..3).map(|_| (FALSIFIED_SIMULATION, FALSIFIED_INTERSECTION));
        let sound = (0..12).map(|_| (SIMULATION, INTERSECTION));
        for (turn, (simulation, intersection)) in faulty.chain(sound).enumerate() {
            let now = Ticks::new(turn as u32 * 100);
            for each in &mut health {
                each.record(Reading::NoObject, now);
            }
            let assessment = monitor.conclude(Some(simulation), intersection);
            monitor.record(&assessment, &mut health, &rules, now);
            if statuses.last() != Some(&health[3].status()) {
                statuses.push(health[3].status());
            }
            assert_eq!(health[4].status(), Status::Healthy);
        }
        let expected = [
            Status::Healthy,
            Status::Suspect,
            Status::Failed,
            Status::Recovering,
            Status::Healthy,
        ];
        assert_eq!(statuses, expected);
        assert_eq!(health[3].contradictions(), 3);
        assert_eq!(health[3].confirmations(), 12);
    }
}
