//! Sound sensors are left alone, and each fault is found.

use super::*;
use crate::fusion::{BayesGrid, Beam, BeamConfig, BeamModel, Geometry, Mapper, Strength};
use crate::health::{Health, HealthRules, Status};
use crate::sensor::SensorId;
use crate::transducer::{Calibration, Sweep};
use crate::units::Point;
use fixed::types::U8F8;
use proptest::prelude::*;

const fn mm(mm: u32) -> Millimeters {
    Millimeters::new(mm)
}

const DIRECTIONS: u16 = 37;
const ROUND_MS: u32 = 250;
const CONFIG: ValidationConfig =
    ValidationConfig::sweeping(mm(100), mm(800), 0, DIRECTIONS, 37 * ROUND_MS);
const RULES: ValidationRules = match ValidationRules::try_new(CONFIG) {
    Ok(rules) => rules,
    Err(_) => panic!("no such rules"),
};

fn degrees(degrees: i32) -> BinaryAngle {
    BinaryAngle::from_millidegrees(degrees * 1000)
}

fn sweep() -> Sweep {
    Sweep::try_new(degrees(-90), degrees(90), DIRECTIONS).unwrap()
}

fn unit() -> Calibration {
    Calibration::try_new(13_000, mm(0), U8F8::lit("60"), mm(100), mm(800)).unwrap()
}

/// A sensor on its head, round after round, with its validator.
struct Head {
    validator: Validator,
    rules: ValidationRules,
    round: u32,
}

impl Head {
    fn new() -> Self {
        Self::with(CONFIG)
    }

    fn with(config: ValidationConfig) -> Self {
        Self {
            validator: Validator::new(),
            rules: ValidationRules::try_new(config).unwrap(),
            round: 0,
        }
    }

    fn look(&mut self, reading: Reading, raw: Option<u8>) -> Validated {
        let bearing = sweep().direction(self.round, 0, 1);
        self.look_at(bearing, reading, raw)
    }

    fn look_at(&mut self, bearing: BinaryAngle, reading: Reading, raw: Option<u8>) -> Validated {
        let now = Ticks::new(self.round * ROUND_MS);
        self.round += 1;
        self.validator
            .validate(&self.rules, reading, raw, bearing, now)
    }

    fn hear(&mut self, raw: u8) -> Finding {
        self.look(unit().reading(raw), Some(raw)).finding
    }

    fn count(&self, finding: Finding) -> u16 {
        self.validator.counts().of(finding)
    }
}

#[test]
fn a_validator_takes_24_bytes() {
    assert_eq!(size_of::<Validator>(), 24);
}

#[test]
fn an_echo_outside_the_range_goes_on_as_missing() {
    for (distance, finding) in [
        (99, Finding::OutOfRange),
        (100, Finding::Plausible),
        (800, Finding::Plausible),
        (801, Finding::OutOfRange),
    ] {
        let mut head = Head::new();
        let validated = head.look(Reading::Echo(mm(distance)), None);
        assert_eq!(validated.finding, finding, "{distance} mm");
        let expected = match finding {
            Finding::OutOfRange => Reading::Missing(Missing::Implausible),
            _ => Reading::Echo(mm(distance)),
        };
        assert_eq!(validated.reading, expected);
    }
}

#[test]
fn what_is_missing_keeps_its_reason() {
    let mut head = Head::new();
    for reason in [Missing::Timeout, Missing::Bus, Missing::Implausible] {
        let validated = head.look(Reading::Missing(reason), Some(0xFF));
        assert_eq!(validated.reading, Reading::Missing(reason));
        assert_eq!(validated.finding, Finding::Missing);
    }
    assert_eq!(head.count(Finding::Missing), 3);
}

#[test]
fn a_word_that_claims_an_echo_in_every_direction_of_a_sweep_and_one_more_is_stuck() {
    let mut head = Head::new();
    for look in 1..=100 {
        let raw = 90;
        let validated = head.look(unit().reading(raw), Some(raw));
        let stuck = look > DIRECTIONS;
        assert_eq!(validated.finding == Finding::StuckAt, stuck, "look {look}");
        assert_eq!(matches!(validated.reading, Reading::Missing(_)), stuck);
    }
    // Another word and it is believed again.
    assert_eq!(head.hear(95), Finding::Plausible);
    assert_eq!(head.count(Finding::StuckAt), 100 - DIRECTIONS);
}

#[test]
fn a_stuck_line_that_fails_now_and_then_is_still_stuck() {
    let mut head = Head::new();
    for _ in 0..DIRECTIONS {
        head.hear(90);
        let _ = head.look(Reading::Missing(Missing::Timeout), None);
    }
    assert_eq!(head.hear(90), Finding::StuckAt);
}

#[test]
fn a_sound_sensor_that_sees_nothing_for_sweeps_is_not_stuck() {
    let mut head = Head::new();
    for _ in 0..10 * DIRECTIONS {
        assert_eq!(unit().reading(62), Reading::NoObject);
        assert_eq!(head.hear(62), Finding::Plausible);
    }
}

#[test]
fn a_fixed_sensor_before_a_wall_is_not_stuck() {
    let mut head = Head::new();
    for _ in 0..1000 {
        let ahead = BinaryAngle::QUARTER;
        let validated = head.look_at(ahead, unit().reading(90), Some(90));
        assert_eq!(validated.finding, Finding::Plausible);
    }
}

#[test]
fn a_ranger_without_raw_words_is_not_stuck() {
    let mut head = Head::new();
    for _ in 0..100 {
        let validated = head.look(Reading::Echo(mm(300)), None);
        assert_eq!(validated.finding, Finding::Plausible);
    }
}

/// The reason for a whole sweep. Without noise, which would only help.
#[test]
fn a_flat_wall_gives_the_same_byte_over_40_degrees_at_most() {
    let mut widest = 0;
    for wall in (100..800).map(f64::from) {
        let (mut same, mut last) = (0, 0);
        for millidegrees in (-89_000..89_000).step_by(250) {
            let distance = wall / (f64::from(millidegrees) / 1000.0).to_radians().cos();
            let raw = (13_000.0 / distance + 60.0).round() as u8;
            let steady = raw == last && distance <= 800.0;
            same = if steady { same + 250 } else { 0 };
            last = raw;
            widest = widest.max(same);
        }
    }
    assert!((35_000..=40_000).contains(&widest), "{widest}");
}

#[test]
fn a_change_in_the_same_direction_beyond_what_motion_explains_is_a_jump() {
    // Two looks 250 ms apart at 400 mm/s: half of 700 mm and 100 mm.
    let judged = |distance: u32| {
        let mut head = Head::with(ValidationConfig {
            speed_mm_s: 400,
            ..CONFIG
        });
        let ahead = BinaryAngle::QUARTER;
        let _ = head.look_at(ahead, Reading::Echo(mm(200)), None);
        head.look_at(ahead, Reading::Echo(mm(distance)), None)
    };
    assert_eq!(judged(650).finding, Finding::Plausible);
    let jump = judged(651);
    assert_eq!(jump.finding, Finding::Jump);
    assert_eq!(jump.reading, Reading::Echo(mm(651)), "a label only");
}

#[test]
fn no_object_and_too_near_jump_by_what_they_prove() {
    let judged = |before, after| {
        let mut head = Head::new();
        let ahead = BinaryAngle::QUARTER;
        let _ = head.look_at(ahead, before, None);
        head.look_at(ahead, after, None).finding == Finding::Jump
    };
    let echo = |distance| Reading::Echo(mm(distance));
    // The limit is 350 mm; 800 mm and beyond is no object, 100 mm and less is too near.
    for (before, after, jump) in [
        (echo(450), Reading::NoObject, false),
        (echo(449), Reading::NoObject, true),
        (echo(450), Reading::TooNear, false),
        (echo(451), Reading::TooNear, true),
        (Reading::NoObject, Reading::TooNear, true),
        (Reading::NoObject, Reading::NoObject, false),
        (Reading::TooNear, Reading::TooNear, false),
    ] {
        assert_eq!(judged(before, after), jump, "{before:?} to {after:?}");
        assert_eq!(judged(after, before), jump, "{after:?} to {before:?}");
    }
}

#[test]
fn the_edges_of_objects_that_rest_are_no_jumps() {
    let mut head = Head::new();
    for _ in 0..5 * DIRECTIONS {
        let near = head.round % u32::from(DIRECTIONS) % 4 < 2;
        let distance = if near { 150 } else { 790 };
        let validated = head.look(Reading::Echo(mm(distance)), None);
        assert_eq!(validated.finding, Finding::Plausible);
    }
}

/// One direction is compared a sweep, and the next one the sweep after.
#[test]
fn a_jump_in_any_direction_of_a_sweep_is_found_in_time() {
    let directions = u32::from(DIRECTIONS);
    for restless in 0..directions {
        let mut head = Head::new();
        for _ in 0..(directions + 2) * directions {
            // In this direction every sweep sees something else.
            let (sweep, step) = (head.round / directions, head.round % directions);
            let near = step == restless && sweep % 2 == 0;
            let distance = if near { 150 } else { 700 };
            let finding = head.look(Reading::Echo(mm(distance)), None).finding;
            assert!(finding == Finding::Plausible || step == restless);
        }
        assert_eq!(head.count(Finding::Jump), 1, "direction {restless}");
    }
}

#[test]
fn what_was_seen_too_long_ago_is_not_compared() {
    let judged = |later: u32| {
        let mut validator = Validator::new();
        let mut validate = |distance, now| {
            let reading = Reading::Echo(mm(distance));
            validator.validate(&RULES, reading, None, BinaryAngle::ZERO, Ticks::new(now))
        };
        let _ = validate(150, 0);
        validate(700, later).finding
    };
    assert_eq!(judged(CONFIG.compare_within), Finding::Jump);
    assert_eq!(judged(CONFIG.compare_within + 1), Finding::Plausible);
}

#[test]
fn counts_saturate() {
    let mut head = Head::new();
    for _ in 0..70_000_u32 {
        let _ = head.look(Reading::Missing(Missing::Bus), None);
    }
    assert_eq!(head.count(Finding::Missing), u16::MAX);
    assert_eq!(head.count(Finding::Plausible), 0);
}

#[test]
fn what_cannot_be_is_refused() {
    let refused = |config| ValidationRules::try_new(config).unwrap_err();
    let (nearest, jump) = (mm(800), mm(0));
    assert_eq!(
        refused(ValidationConfig { nearest, ..CONFIG }),
        ValidationError::Range
    );
    let farthest = mm(65_536);
    assert_eq!(
        refused(ValidationConfig { farthest, ..CONFIG }),
        ValidationError::Range
    );
    assert_eq!(
        refused(ValidationConfig { jump, ..CONFIG }),
        ValidationError::Jump
    );
    let same_word = 0;
    assert_eq!(
        refused(ValidationConfig {
            same_word,
            ..CONFIG
        }),
        ValidationError::SameWord
    );
}

/// The way of a reading to the health is the same as that of any other.
#[test]
fn the_health_of_a_stuck_sensor_falls_and_the_map_is_left_alone() {
    let geometry = Geometry::try_new(17, 11, mm(100), Point::from_mm(-850, 0)).unwrap();
    let grid = BayesGrid::try_new(geometry, Strength::MEASUREMENT, [0_u8; 187]).unwrap();
    let mut mapper = Mapper::new(grid, [Health::default(); 1], HealthRules::DEFAULT);
    let model = BeamModel::try_new(BeamConfig::narrow(mm(800))).unwrap();
    let sensor = SensorId::new(1).unwrap();
    let mut head = Head::new();
    let patience = u32::from(HealthRules::DEFAULT.config().suspect_missing);
    for look in 1..=u32::from(DIRECTIONS) + patience {
        let now = Ticks::new(look);
        let beam = Beam {
            origin: Point::ORIGIN,
            bearing: BinaryAngle::QUARTER,
            reading: head.look(unit().reading(90), Some(90)).reading,
        };
        let cells = mapper.integrate(sensor, &beam, &model, now).unwrap();
        assert_eq!(cells == 0, look > u32::from(DIRECTIONS), "look {look}");
    }
    let suspects = mapper.environment().count(Status::Suspect);
    assert_eq!(suspects, 1);
}

fn any_reading() -> impl Strategy<Value = Reading> {
    prop_oneof![
        6 => (0_u32..1000).prop_map(|d| Reading::Echo(mm(d))),
        1 => Just(Reading::NoObject),
        1 => Just(Reading::TooNear),
        1 => Just(Reading::Missing(Missing::Timeout)),
    ]
}

proptest! {
    /// Labels and counts, whatever comes: a reading changes exactly if its finding says so.
    #[test]
    fn nothing_is_dropped_silently(
        looks in proptest::collection::vec(
            (any_reading(), 88_u8..90, 0_i32..3, 0_u32..9000),
            0..300,
        ),
        same_word in 1_u16..6,
    ) {
        let rules = ValidationRules::try_new(ValidationConfig { same_word, ..CONFIG }).unwrap();
        let mut validator = Validator::new();
        let mut made = [0_u16; Finding::ALL.len()];
        let mut now = 0_u32;
        let mut run = Vec::new(); // of words that claim an echo, each with its direction
        for (reading, raw, bearing, later) in looks {
            now = now.wrapping_add(later);
            let Validated { reading: passed, finding } =
                validator.validate(&rules, reading, Some(raw), degrees(bearing), Ticks::new(now));
            made[finding as usize] += 1;

            match reading {
                Reading::Echo(_) => {
                    if run.last().is_some_and(|&(word, _)| word != raw) {
                        run.clear();
                    }
                    run.push((raw, bearing));
                    run.dedup();
                }
                Reading::NoObject | Reading::TooNear => run.clear(),
                Reading::Missing(_) => {}
            }
            let in_range =
                !matches!(reading, Reading::Echo(d) if !(100..=800).contains(&d.get()));
            let stuck = run.len() > usize::from(same_word)
                && !matches!(reading, Reading::Missing(_));
            let changed = !in_range || stuck;
            let expected = if changed { Reading::Missing(Missing::Implausible) } else { reading };
            prop_assert_eq!(passed, expected);
            prop_assert_eq!(finding == Finding::OutOfRange, !in_range);
            prop_assert_eq!(finding == Finding::StuckAt, in_range && stuck);
            let missing = matches!(reading, Reading::Missing(_));
            prop_assert_eq!(finding == Finding::Missing, missing);
        }
        for finding in Finding::ALL {
            prop_assert_eq!(validator.counts().of(finding), made[finding as usize]);
        }
    }
}
