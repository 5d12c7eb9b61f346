use super::super::RANGEFINDERS;
use super::*;
use crate::transducer::Missing;

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
        rangefinders: [
            looks(400, 200, 15),
            looks(300, 250, 40),
            looks(-400, 200, 130),
            looks(-400, -200, -130),
            looks(300, -250, -40),
            looks(400, -200, -15),
        ],
        scanner: looks(450, 0, 0),
        tolerance: mm(150),
        rangefinders_see: mm(4000),
        scanner_sees: mm(4000),
        contradiction: 4,
        agreement: 2,
        most: 48,
        credit: 16,
        unlikely: 12,
    }
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
    let config = config();
    let points = points(scan, config.scanner);
    let all = config.rangefinders.iter().zip(rangefinders);
    all.map(|(&mounting, &reading)| config.verdict(mounting, reading, scan, &points))
        .collect()
}

fn failures(
    readings: usize,
    rangefinders: &PerRangefinder<Reading>,
    scan: &PerBeam<Reading>,
) -> Vec<f64> {
    let mut check = CrossCheck::new(config());
    for _ in 0..readings {
        check.observe(rangefinders, scan);
    }
    let failures = check.failures();
    let all = failures.rangefinders.into_iter().chain([failures.scanner]);
    all.map(|failure| failure.part().to_num()).collect()
}

use Verdict::{Agreement, Contradiction, Silence};

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
    let mut check = CrossCheck::new(config());
    let mut stuck = of_wall();
    stuck[0] = Reading::Echo(mm(1000));
    for _ in 0..20 {
        check.observe(&stuck, &wall());
    }
    let mut alone = [Reading::NoObject; RANGEFINDERS];
    alone[0] = Reading::Echo(mm(1000));
    for _ in 0..200 {
        check.observe(&alone, &[Reading::NoObject; BEAMS]);
    }
    let failures = check.failures();
    let parts = (failures.rangefinders[0].part(), failures.scanner.part());
    assert_eq!(parts, (Signal::lit("0.75"), Signal::lit("0.25")));
}

#[test]
fn a_scanner_that_breaks_after_a_rangefinder_is_found_too() {
    let mut check = CrossCheck::new(config());
    let mut stuck = of_wall();
    stuck[0] = Reading::Echo(mm(1000));
    for _ in 0..20 {
        check.observe(&stuck, &wall());
    }
    for _ in 0..30 {
        check.observe(&stuck, &[Reading::NoObject; BEAMS]);
    }
    assert_eq!(check.failures().scanner, Failure::TOTAL);
}

/// 48 by 1 a reading.
#[test]
fn what_a_sensor_said_is_forgotten_once_it_is_not_heard() {
    let mut check = CrossCheck::new(config());
    for _ in 0..20 {
        check.observe(&of_wall(), &[Reading::NoObject; BEAMS]);
    }
    let missing = [Reading::Missing(Missing::Implausible); RANGEFINDERS];
    for _ in 0..47 {
        check.observe(&missing, &wall());
    }
    assert_ne!(check.suspicion, [0; RANGEFINDERS]);
    check.observe(&missing, &wall());
    assert_eq!(check.suspicion, [0; RANGEFINDERS]);
    assert_eq!(check.failures(), Failures::NONE);
}

#[test]
fn a_sensor_that_agrees_again_is_believed_again() {
    let mut check = CrossCheck::new(config());
    let mut stuck = of_wall();
    stuck[0] = Reading::Echo(mm(1000));
    for _ in 0..100 {
        check.observe(&stuck, &wall());
    }
    assert_eq!(check.failures().rangefinders[0], Failure::TOTAL);
    // From 48 by 2 a reading: at 10 the rest, (10 − 6) / 12, is still above a quarter; at 8 it is not,
    // so it stands no more, and 8 is below λ.
    for _ in 0..19 {
        check.observe(&of_wall(), &wall());
        assert_ne!(check.failures(), Failures::NONE);
    }
    check.observe(&of_wall(), &wall());
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
