use super::*;
use crate::{Echoes, RingConfig};
use certainty_core::health::Status;
use certainty_core::transducer::Reading;
use certainty_core::units::Millimeters;

/// \[003\] §5 to §7, printed.
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
    let sound = monitor.conclude(SIMULATION, INTERSECTION);
    assert_eq!(sound.overall(), OVERALL);
    assert_eq!(faulty(&sound), [0_u8; 0]);

    let falsified = monitor.conclude(FALSIFIED_SIMULATION, FALSIFIED_INTERSECTION);
    assert_eq!(falsified.overall(), FALSIFIED_OVERALL);
    assert_eq!(faulty(&falsified), [4]);
    assert_eq!(falsified.verdicts()[3], Verdict::Removed);
    assert!(monitor.removed()[3]);

    let again = monitor.conclude(FALSIFIED_SIMULATION, FALSIFIED_INTERSECTION);
    assert_eq!(again.verdicts()[3], Verdict::StillRemoved);
    let mended = monitor.conclude(SIMULATION, INTERSECTION);
    assert_eq!(mended.verdicts()[3], Verdict::Reinstated);
    assert_eq!(monitor.removed(), &[false; 24]);
    let after = monitor.conclude(SIMULATION, INTERSECTION);
    assert_eq!(after.verdicts(), &[Verdict::Sound; 24]);
}

#[test]
fn three_confirmations_are_more_than_two_sound_sonars_of_the_paper_have() {
    let mut monitor = Monitor::<24>::new(RingRules::WARY);
    let sound = monitor.conclude(SIMULATION, INTERSECTION);
    assert_eq!(faulty(&sound), [9, 10]);
    let falsified = monitor.conclude(FALSIFIED_SIMULATION, FALSIFIED_INTERSECTION);
    assert_eq!(faulty(&falsified), [4, 9, 10]);
}

#[test]
fn a_removed_sonars_paths_stop_counting_at_the_next_assessment_and_count_again_when_it_is_back() {
    let ring = Ring::<24>::try_new(RingConfig::DEFAULT).unwrap();
    let rules = RingRules::DEFAULT;
    let expected = Distances::fold(&ring, &Echoes::silent(), &rules);
    let sound = expected;
    // Sonar 4 hears, and is heard, at 0.7 m where nothing is.
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
    assert_eq!(before.verdicts()[3], Verdict::Removed);
    // Its neighbours lost the paths to it, and keep the others.
    let lost = [6, 6, 6, 0, 6, 6, 6, 7];
    assert_eq!(before.simulation_based()[..8], lost);

    // Even sound again, in the next assessment it still counts for nobody but itself.
    let back = monitor.assess(&ring, Some(&expected), &sound);
    assert_eq!(back.simulation_based()[..8], [6, 6, 6, 7, 6, 6, 6, 7]);
    assert_eq!(back.verdicts()[3], Verdict::Reinstated);
    let after = monitor.assess(&ring, Some(&expected), &sound);
    assert_eq!(after.simulation_based(), &[7; 24]);
}

#[test]
fn the_health_of_a_removed_sonar_falls_at_once_and_comes_back_slowly() {
    let mut monitor = Monitor::<24>::new(RingRules::DEFAULT);
    let mut health = [Health::default(); 24];
    let rules = HealthRules::DEFAULT;
    let mut walked = vec![Status::Healthy];
    let faulty = (0..3).map(|_| (FALSIFIED_SIMULATION, FALSIFIED_INTERSECTION));
    let sound = (0..12).map(|_| (SIMULATION, INTERSECTION));
    for (turn, (simulation, intersection)) in faulty.chain(sound).enumerate() {
        let now = Ticks::new(turn as u32 * 100);
        for each in &mut health {
            each.record(Reading::NoObject, now);
        }
        let assessment = monitor.conclude(simulation, intersection);
        monitor.tell(&assessment, &mut health, &rules, now);
        if walked.last() != Some(&health[3].status()) {
            walked.push(health[3].status());
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
    assert_eq!(walked, expected);
    assert_eq!(health[3].contradictions(), 3);
    assert_eq!(health[3].confirmations(), 12);
}
