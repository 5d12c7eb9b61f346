use super::super::nearness::distance;
use super::super::{BEAMS, Effort, Failure, RANGEFINDERS, RayFan};
use super::*;
use certainty_core::transducer::Missing;
use certainty_core::units::{BinaryAngle, Point, Pose};
use proptest::prelude::*;

const fn mm(mm: u32) -> Millimeters {
    Millimeters::new(mm)
}

fn looks(x: i32, y: i32, degrees: i32) -> Pose {
    let heading = BinaryAngle::from_millidegrees(degrees * 1000);
    Pose::new(Point::from_mm(x, y), heading)
}

/// Four rangefinders look into the scanner's field, two behind.
fn config() -> CrossCheckConfig {
    CrossCheckConfig {
        views: Views {
            rangefinders: [
                looks(400, 200, 15),
                looks(300, 250, 40),
                looks(-400, 200, 130),
                looks(-400, -200, -130),
                looks(300, -250, -40),
                looks(400, -200, -15),
            ],
            scanner: looks(450, 0, 0),
            rangefinders_see: mm(4000),
            scanner_sees: mm(4000),
        },
        tolerance: mm(150),
        contradiction: 4,
        agreement: 2,
        most: 48,
        credit: 16,
        unlikely: 12,
    }
}

fn check() -> CrossCheck {
    CrossCheck::try_new(config()).unwrap()
}

/// A wall across the way, 2 m ahead of the scanner.
fn wall() -> PerBeam<Reading> {
    let mut scan = [Reading::NoObject; BEAMS];
    for (beam, reading) in scan.iter_mut().enumerate() {
        let angle = (beam as f64 - 50.0).to_radians();
        *reading = Reading::Echo(mm((2000.0 / angle.cos()).round() as u32));
    }
    scan
}

/// The same wall by the rangefinders: x = 2450.
fn of_wall() -> PerRangefinder<Reading> {
    let away = |x: f64, degrees: f64| {
        Reading::Echo(mm(
            ((2450.0 - x) / degrees.to_radians().cos()).round() as u32
        ))
    };
    let (ahead, aside) = (away(400.0, 15.0), away(300.0, 40.0));
    let none = Reading::NoObject;
    [ahead, aside, none, none, aside, ahead]
}

fn verdicts(rangefinders: &PerRangefinder<Reading>, scan: &PerBeam<Reading>) -> Vec<Verdict> {
    config().between(rangefinders, scan).to_vec()
}

fn failures(
    readings: usize,
    rangefinders: &PerRangefinder<Reading>,
    scan: &PerBeam<Reading>,
) -> Vec<f64> {
    let mut check = check();
    for _ in 0..readings {
        check.observe(rangefinders, scan, None);
    }
    let failures = check.failures();
    let all = failures.rangefinders.into_iter().chain([failures.scanner]);
    all.map(|failure| failure.part().to_num()).collect()
}

use Verdict::{Agreement, Contradiction, Past, Phantom, Silence};

#[test]
fn sensors_that_see_the_same_wall_agree() {
    let expected = [Agreement, Agreement, Silence, Silence, Agreement, Agreement];
    assert_eq!(verdicts(&of_wall(), &wall()), expected);
    assert_eq!(failures(100, &of_wall(), &wall()), [0.0; 7]);
}

#[test]
fn a_rangefinder_that_sees_nothing_is_found_and_no_other() {
    let mut rangefinders = of_wall();
    rangefinders[0] = Reading::NoObject;
    assert_eq!(verdicts(&rangefinders, &wall())[0], Contradiction);
    // 4 a reading, λ = 12: nothing until the fourth, all at the sixth.
    assert_eq!(failures(3, &rangefinders, &wall()), [0.0; 7]);
    assert_eq!(
        failures(6, &rangefinders, &wall()),
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    );
}

#[test]
fn a_scanner_that_sees_nothing_is_found_and_no_rangefinder() {
    let blind = [Reading::NoObject; BEAMS];
    let all = failures(6, &of_wall(), &blind);
    assert_eq!(all, [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn two_rangefinders_that_lie_are_outvoted_by_two_that_agree() {
    let mut rangefinders = of_wall();
    rangefinders[0] = Reading::Echo(mm(1200));
    rangefinders[1] = Reading::Echo(mm(2300));
    let all = failures(10, &rangefinders, &wall());
    assert_eq!(all, [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
}

#[test]
fn one_pair_alone_leaves_both_in_doubt() {
    let mut rangefinders = [Reading::NoObject; RANGEFINDERS];
    rangefinders[5] = Reading::Echo(mm(1500));
    let all = failures(10, &rangefinders, &[Reading::NoObject; BEAMS]);
    assert_eq!(all, [0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.5]);
}

/// By hand: when the others are silent `x` is 48 and the rest 0, so S = 48 − 12 and R = 48 − 6 for who
/// stands: the lead is 36 − 42 + 12 = 6 of 24, a quarter of the blame.
#[test]
fn who_was_found_broken_stays_so_when_the_others_fall_silent() {
    let mut check = check();
    let mut stuck = of_wall();
    stuck[0] = Reading::Echo(mm(1000));
    for _ in 0..20 {
        check.observe(&stuck, &wall(), None);
    }
    let mut alone = [Reading::NoObject; RANGEFINDERS];
    alone[0] = Reading::Echo(mm(1000));
    for _ in 0..200 {
        check.observe(&alone, &[Reading::NoObject; BEAMS], None);
    }
    let failures = check.failures();
    let parts = (failures.rangefinders[0].part(), failures.scanner.part());
    assert_eq!(parts, (Effort::lit("0.75"), Effort::lit("0.25")));
}

#[test]
fn a_scanner_that_breaks_after_a_rangefinder_is_found_too() {
    let mut check = check();
    let mut stuck = of_wall();
    stuck[0] = Reading::Echo(mm(1000));
    for _ in 0..20 {
        check.observe(&stuck, &wall(), None);
    }
    for _ in 0..30 {
        check.observe(&stuck, &[Reading::NoObject; BEAMS], None);
    }
    assert_eq!(check.failures().scanner, Failure::TOTAL);
}

/// 48 by 1 a reading.
#[test]
fn what_a_sensor_said_is_forgotten_once_it_is_not_heard() {
    let mut check = check();
    for _ in 0..20 {
        check.observe(&of_wall(), &[Reading::NoObject; BEAMS], None);
    }
    let missing = [Reading::Missing(Missing::Implausible); RANGEFINDERS];
    for _ in 0..47 {
        check.observe(&missing, &wall(), None);
    }
    assert_ne!(check.suspicions.of_pairs, [0; RANGEFINDERS]);
    check.observe(&missing, &wall(), None);
    assert_eq!(check.suspicions.of_pairs, [0; RANGEFINDERS]);
    assert_eq!(check.failures(), Failures::NONE);
}

#[test]
fn a_sensor_that_agrees_again_is_believed_again() {
    let mut check = check();
    let mut stuck = of_wall();
    stuck[0] = Reading::Echo(mm(1000));
    for _ in 0..100 {
        check.observe(&stuck, &wall(), None);
    }
    assert_eq!(check.failures().rangefinders[0], Failure::TOTAL);
    // From 48 by 2 a reading: at 10 the rest, (10 − 6) / 12, is still above a quarter; at 8 it is not,
    // so it stands no more, and 8 is below λ.
    for _ in 0..19 {
        check.observe(&of_wall(), &wall(), None);
        assert_ne!(check.failures(), Failures::NONE);
    }
    check.observe(&of_wall(), &wall(), None);
    assert_eq!(check.failures(), Failures::NONE);
}

#[test]
fn what_nobody_can_know_is_silence() {
    let nothing = [Reading::NoObject; BEAMS];
    let missing = [Reading::Missing(Missing::Timeout); RANGEFINDERS];
    assert_eq!(verdicts(&missing, &wall()), [Silence; 6]);
    // Nothing seen by anyone, and echoes where the scanner does not look.
    let mut behind = [Reading::NoObject; RANGEFINDERS];
    behind[2] = Reading::Echo(mm(500));
    behind[3] = Reading::TooNear;
    assert_eq!(verdicts(&behind, &nothing), [Silence; 6]);
    // A corner: the scanner's wall ends before the rangefinder's beam.
    let mut corner = wall();
    corner[..65].fill(Reading::NoObject);
    let open = [Reading::NoObject; RANGEFINDERS];
    assert_eq!(verdicts(&open, &corner)[5], Silence);
}

#[test]
fn what_is_behind_an_obstacle_of_the_scanners_is_no_contradiction() {
    // The scanner is blocked at 300 mm on all beams around the rangefinder's echo, which passes the
    // obstacle from its own place.
    let mut scan = [Reading::NoObject; BEAMS];
    scan[60..80].fill(Reading::Echo(mm(300)));
    let mut rangefinders = [Reading::NoObject; RANGEFINDERS];
    rangefinders[0] = Reading::Echo(mm(3000));
    assert_eq!(verdicts(&rangefinders, &scan)[0], Silence);
}

/// Surely free is all before the wall, and a metre where there is none.
fn clear(reading: Reading) -> Millimeters {
    distance(reading).unwrap_or(mm(1000))
}

/// What a map shows that remembers the wall: by 1° a sector's rays would be a little longer or shorter.
fn memory_of_wall() -> ExpectedScan {
    ExpectedScan {
        sectors: of_wall().map(|reading| RayFan::of_rays([reading; 11], clear(reading))),
        scan: wall(),
        clear: wall().map(clear),
    }
}

const BLIND: PerRangefinder<Reading> = [Reading::NoObject; RANGEFINDERS];

/// After so many times of `recall` and `observe`.
fn with_memory(
    times: usize,
    rangefinders: &PerRangefinder<Reading>,
    scan: &PerBeam<Reading>,
    memory: &ExpectedScan,
) -> Vec<f64> {
    let mut check = check();
    for _ in 0..times {
        check.observe(rangefinders, scan, Some(memory));
    }
    let failures = check.failures();
    let all = failures.rangefinders.into_iter().chain([failures.scanner]);
    all.map(|failure| failure.part().to_num()).collect()
}

#[test]
fn who_says_what_the_map_says_is_not_suspected() {
    let mut check = check();
    let verdicts = check.observe(&of_wall(), &wall(), Some(&memory_of_wall()));
    let expected = [Agreement, Agreement, Silence, Silence, Agreement, Agreement];
    assert_eq!(verdicts.rangefinders, expected);
    assert_eq!(verdicts.scanner, Agreement);
    assert_eq!(
        with_memory(100, &of_wall(), &wall(), &memory_of_wall()),
        [0.0; 7]
    );
    // Nor who sees what nobody saw before.
    let verdicts = check.observe(&of_wall(), &wall(), Some(&ExpectedScan::NOTHING));
    assert_eq!(verdicts.rangefinders, [Silence; RANGEFINDERS]);
    assert_eq!(verdicts.scanner, Silence);
}

/// By hand: a rangefinder's `x` and `y` are 48, so it explains 96 − 12; the scanner 2 · 48 − 48 − 12 and
/// leaves 2 · 36, in all less than the two rangefinders' 168 by far more than λ.
#[test]
fn two_that_lie_are_told_from_the_scanner_by_what_the_map_remembers() {
    let mut rangefinders = of_wall();
    (rangefinders[1], rangefinders[4]) = (Reading::NoObject, Reading::NoObject);
    // Only these two see the wall, and the scanner.
    (rangefinders[0], rangefinders[5]) = (
        Reading::Missing(Missing::Timeout),
        Reading::Missing(Missing::Timeout),
    );
    let found = [0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0];
    assert_eq!(
        with_memory(20, &rangefinders, &wall(), &memory_of_wall()),
        found
    );
    // Without a memory the one failure that explains both is blamed.
    let blamed = failures(20, &rangefinders, &wall());
    assert!(blamed[6] > blamed[1], "{blamed:?}");
}

#[test]
fn a_scanner_and_a_rangefinder_that_go_blind_together_are_both_found() {
    let blind = [Reading::NoObject; BEAMS];
    let mut rangefinders = of_wall();
    rangefinders[0] = Reading::NoObject;
    let found = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    assert_eq!(
        with_memory(20, &rangefinders, &blind, &memory_of_wall()),
        found
    );
    // Nobody else could say so of the rangefinder.
    assert_eq!(failures(20, &rangefinders, &blind)[0], 0.0);
}

#[test]
fn a_scan_is_judged_by_most_of_its_beams() {
    let verdict = |scan: &PerBeam<Reading>| {
        let mut check = check();
        check.observe(&BLIND, scan, Some(&memory_of_wall())).scanner
    };
    // All 101 beams see the wall, which is within reach of them all: 2000 / cos 50° + 150 + 194.
    let mut scan = wall();
    assert_eq!(verdict(&scan), Agreement);
    scan[..33].fill(Reading::NoObject);
    assert_eq!(verdict(&scan), Agreement);
    scan[..34].fill(Reading::Echo(mm(3900)));
    assert_eq!(verdict(&scan), Silence);
    scan[..50].fill(Reading::Echo(mm(100)));
    assert_eq!(verdict(&scan), Silence);
    scan[..51].fill(Reading::TooNear);
    assert_eq!(verdict(&scan), Contradiction);
    // Four beams say nothing about the others, whatever they say; nor do beams that are not heard.
    let silent = Reading::Missing(Missing::Timeout);
    scan = [silent; BEAMS];
    scan[..4].fill(Reading::NoObject);
    assert_eq!(verdict(&scan), Silence);
    scan[4] = Reading::NoObject;
    assert_eq!(verdict(&scan), Contradiction);
}

#[test]
fn an_edge_in_the_map_judges_no_rangefinder() {
    let judged = |rays: [Reading; 11], reading: Reading| {
        let mut memory = ExpectedScan::NOTHING;
        memory.sectors[0] = RayFan::of_rays(rays, Millimeters::ZERO);
        let mut rangefinders = BLIND;
        rangefinders[0] = reading;
        let mut check = check();
        check
            .observe(&rangefinders, &[Reading::NoObject; BEAMS], Some(&memory))
            .rangefinders[0]
    };
    let echo = |distance| Reading::Echo(mm(distance));
    let mut rays = [echo(1000); 11];
    assert_eq!(judged(rays, Reading::NoObject), Contradiction);
    // 150 and a sixteenth of 1000 either way.
    assert_eq!(judged(rays, echo(1212)), Agreement);
    assert_eq!(judged(rays, echo(1213)), Contradiction);
    assert_eq!(judged(rays, echo(788)), Agreement);
    assert_eq!(judged(rays, echo(787)), Contradiction);
    assert_eq!(judged(rays, Reading::TooNear), Contradiction);
    // 150 and a sixteenth of 160 is all there is before it.
    assert_eq!(judged([echo(160); 11], Reading::TooNear), Agreement);
    assert_eq!(judged([echo(161); 11], Reading::TooNear), Contradiction);
    assert_eq!(judged(rays, Reading::Missing(Missing::Timeout)), Silence);
    for beside in [Reading::NoObject, echo(1501)] {
        rays[6] = beside;
        assert_eq!(judged(rays, Reading::NoObject), Past);
        assert_eq!(judged(rays, echo(1213)), Past);
        assert_eq!(judged(rays, echo(1212)), Silence);
        assert_eq!(judged(rays, Reading::Missing(Missing::Timeout)), Silence);
    }
    // Nearly out of reach: 3623 + 150 + 226 is within 4000, one more is not.
    assert_eq!(judged([echo(3623); 11], Reading::NoObject), Contradiction);
    assert_eq!(judged([echo(3624); 11], Reading::NoObject), Silence);
}

/// A map that is surely free for 2 m wherever anybody looks.
fn memory_of_free() -> ExpectedScan {
    ExpectedScan {
        sectors: [RayFan::of_rays([Reading::NoObject; 11], mm(2000)); RANGEFINDERS],
        clear: [mm(2000); BEAMS],
        ..ExpectedScan::NOTHING
    }
}

/// A wall at 1.5 m where there was none, and who sees it: a phantom of a sensor that is alone.
#[test]
fn what_one_sensor_sees_where_all_was_free_is_a_phantom_and_what_two_see_is_new() {
    let open = [Reading::NoObject; BEAMS];
    let judged = |rangefinders: &PerRangefinder<Reading>, scan: &PerBeam<Reading>| {
        check().observe(rangefinders, scan, Some(&memory_of_free()))
    };
    let echo = |distance| Reading::Echo(mm(distance));
    let mut alone = BLIND;
    // 150 and a sixteenth of 1741 before the end of what is free.
    (alone[2], alone[3]) = (echo(1741), echo(1742));
    alone[5] = Reading::TooNear;
    let verdicts = judged(&alone, &open);
    let expected = [Silence, Silence, Phantom, Silence, Silence, Phantom];
    assert_eq!(verdicts.rangefinders, expected);
    assert_eq!(verdicts.scanner, Silence);
    let near_wall = wall().map(|reading| match reading {
        Reading::Echo(distance) => echo(distance.get() / 2),
        other => other,
    });
    assert_eq!(judged(&BLIND, &near_wall).scanner, Contradiction);
    // The same wall by rangefinder 1: 450 + 1000 − 400 ahead, at 15°.
    let mut both = BLIND;
    both[0] = echo((1050.0 / 15_f64.to_radians().cos()) as u32);
    let verdicts = judged(&both, &near_wall);
    assert_eq!(verdicts.pairs[0], Agreement);
    assert_eq!(verdicts.rangefinders[0], Silence);
    assert_eq!(verdicts.scanner, Silence);
}

/// A rangefinder beside the scanner's field that says something near, with noise: nobody but the map knows.
#[test]
fn a_phantom_beside_the_scanners_field_is_found_by_what_was_free() {
    let open = [Reading::NoObject; BEAMS];
    let mut stuck = BLIND;
    stuck[2] = Reading::Echo(mm(250));
    let found = with_memory(20, &stuck, &open, &memory_of_free());
    // One failure alone leaves both in doubt, as the scanner drew the map.
    assert_eq!(found, [0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.5]);
    // Where the scanner agrees with the map it is the rangefinder.
    let memory = ExpectedScan {
        scan: wall(),
        ..memory_of_free()
    };
    let mut stuck = of_wall();
    stuck[2] = Reading::Echo(mm(250));
    let found = with_memory(20, &stuck, &wall(), &memory);
    assert_eq!(found, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(failures(20, &stuck, &wall()), [0.0; 7]);
}

/// 48 by 1 a time.
#[test]
fn what_contradicted_the_map_is_forgotten_where_it_remembers_nothing() {
    let mut check = check();
    for _ in 0..20 {
        check.observe(&BLIND, &[Reading::NoObject; BEAMS], Some(&memory_of_wall()));
    }
    assert_eq!(check.failures().scanner, Failure::TOTAL);
    for _ in 0..47 {
        check.observe(
            &BLIND,
            &[Reading::NoObject; BEAMS],
            Some(&ExpectedScan::NOTHING),
        );
    }
    assert_ne!(check.suspicions, Suspicions::NONE);
    check.observe(
        &BLIND,
        &[Reading::NoObject; BEAMS],
        Some(&ExpectedScan::NOTHING),
    );
    assert_eq!(check.suspicions, Suspicions::NONE);
    assert_eq!(check.failures(), Failures::NONE);
}

#[test]
fn what_could_find_nobody_is_refused() {
    let base = config();
    let refused = |config| CrossCheck::try_new(config).unwrap_err();
    for weightless in [
        CrossCheckConfig {
            contradiction: 0,
            ..base
        },
        CrossCheckConfig {
            agreement: 0,
            ..base
        },
        CrossCheckConfig {
            unlikely: 0,
            ..base
        },
    ] {
        assert_eq!(refused(weightless), CrossCheckConfigError::Weightless);
    }
    let most = |most| CrossCheckConfig { most, ..base };
    assert_eq!(refused(most(23)), CrossCheckConfigError::NeverFound);
    assert!(CrossCheck::try_new(most(24)).is_ok());
}

#[test]
fn it_takes_the_memory_that_is_written_down() {
    assert_eq!(size_of::<CrossCheck>() - size_of::<CrossCheckConfig>(), 36);
}

/// Whether an echo of rangefinder 1 is met that five beams around it see so: `a`like, `p`ast it, `n`earer.
#[test]
fn an_echo_is_met_by_two_of_five_beams_and_missed_by_all_or_nearly() {
    let mut rangefinders = BLIND;
    rangefinders[0] = Reading::Echo(mm(1500));
    // 400 + 1500 cos 15° = 1849 and 200 + 1500 sin 15° = 588: from the scanner 1517 away at 22.8°.
    let verdict = |five: &str| {
        let mut scan = [Reading::TooNear; BEAMS];
        for (reading, seen) in scan[71..=75].iter_mut().zip(five.chars()) {
            *reading = match seen {
                'a' => Reading::Echo(mm(1517)),
                'p' => Reading::NoObject,
                _ => Reading::Missing(Missing::Timeout),
            };
        }
        verdicts(&rangefinders, &scan)[0]
    };
    for (five, expected) in [
        ("aapppp", Agreement),
        ("nannan", Agreement),
        ("ppppp", Contradiction),
        ("ppapp", Contradiction),
        ("npapp", Contradiction),
        ("pppnp", Silence),
        ("nnapp", Silence),
        ("nnnnn", Silence),
    ] {
        assert_eq!(verdict(five), expected, "{five}");
    }
}

/// At the field's rim there are but three of the five.
#[test]
fn where_the_scanner_ends_left_is_judged_as_right() {
    for distance in (1000..3900).step_by(50) {
        let mut rangefinders = BLIND;
        rangefinders[1] = Reading::Echo(mm(distance));
        let open = [Reading::NoObject; BEAMS];
        let left = verdicts(&rangefinders, &open)[1];
        rangefinders.reverse();
        assert_eq!(verdicts(&rangefinders, &open)[4], left, "{distance}");
    }
}

fn reading() -> impl Strategy<Value = Reading> {
    prop_oneof![
        6 => (30_u32..4000).prop_map(|far| Reading::Echo(mm(far))),
        3 => Just(Reading::NoObject),
        1 => Just(Reading::TooNear),
        1 => Just(Reading::Missing(Missing::Timeout)),
    ]
}

prop_compose! {
    /// Walls that lean, before a background.
    fn scan()(
        background in reading(),
        walls in prop::collection::vec((0..BEAMS, 1_usize..40, 300_i32..4000, -20_i32..20), 0..5),
    ) -> PerBeam<Reading> {
        let mut scan = [background; BEAMS];
        for (first, width, far, lean) in walls {
            for (reading, step) in scan[first..BEAMS.min(first + width)].iter_mut().zip(0..) {
                *reading = Reading::Echo(mm((far + lean * step).max(30).unsigned_abs()));
            }
        }
        scan
    }
}

prop_compose! {
    fn memory()(
        rays in prop::array::uniform6(prop::array::uniform11(reading())),
        walls in prop::array::uniform6(prop::option::of(reading())),
        scan in scan(),
        clear in prop::array::uniform7((0_u32..5000).prop_map(mm)),
    ) -> [ExpectedScan; 2] {
        let mut sectors = rays;
        for (rays, wall) in sectors.iter_mut().zip(walls) {
            if let Some(wall) = wall {
                rays.fill(wall);
            }
        }
        let [ahead @ .., beams] = clear;
        let mut numbered = sectors.into_iter().zip(ahead);
        let sectors = [(); RANGEFINDERS].map(|()| numbered.next().unwrap());
        let ours = ExpectedScan {
            sectors: sectors.map(|(rays, clear)| RayFan::of_rays(rays, clear)),
            scan,
            clear: [beams; BEAMS],
        };
        let mirrored = ExpectedScan {
            sectors: reversed(sectors).map(|(rays, clear)| RayFan::of_rays(reversed(rays), clear)),
            scan: reversed(scan),
            ..ours
        };
        [ours, mirrored]
    }
}

fn reversed<T: Copy, const N: usize>(mut of: [T; N]) -> [T; N] {
    of.reverse();
    of
}

proptest! {
    #[test]
    fn a_mirrored_glance_is_judged_alike(
        glances in prop::collection::vec(
            (prop::array::uniform6(reading()), scan(), 1_usize..6), 1..4,
        ),
        [memory, mirrored] in memory(),
    ) {
        let (mut ours, mut theirs) = (check(), check());
        for (rangefinders, scan, times) in glances {
            let (opposite, from_left) = (reversed(rangefinders), reversed(scan));
            for _ in 0..times {
                let verdicts = ours.observe(&rangefinders, &scan, Some(&memory));
                let mirror = theirs.observe(&opposite, &from_left, Some(&mirrored));
                prop_assert_eq!(verdicts.pairs, reversed(mirror.pairs));
                prop_assert_eq!(verdicts.rangefinders, reversed(mirror.rangefinders));
                prop_assert_eq!(verdicts.scanner, mirror.scanner);
            }
            let (failures, mirror) = (ours.failures(), theirs.failures());
            prop_assert_eq!(failures.rangefinders, reversed(mirror.rangefinders));
            prop_assert_eq!(failures.scanner, mirror.scanner);
            let completed = memory.complete(&rangefinders, &scan, &failures);
            let mirror = mirrored.complete(&opposite, &from_left, &mirror);
            // Of two things equally near it tells of either: an echo at 0 or too near.
            let away = completed.rangefinders.map(distance);
            prop_assert_eq!(away, reversed(mirror.rangefinders.map(distance)));
            prop_assert_eq!(completed.failures.rangefinders, reversed(mirror.failures.rangefinders));
            prop_assert_eq!(completed.failures.scanner, mirror.failures.scanner);
        }
    }
}
