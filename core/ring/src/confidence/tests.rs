use super::*;
use crate::{Echoes, RingConfig};
use certainty_core::transducer::Reading;
use std::collections::BTreeSet;

fn ring() -> Ring<24> {
    Ring::try_new(RingConfig::DEFAULT).unwrap()
}

fn id(number: u8) -> SensorId {
    SensorId::try_new(number).unwrap()
}

/// The list of \[003\] §6, as it is printed: offsets from sensor i; equal ones are a direct echo.
const PRINTED: [(&str, &str); 5] = [
    (
        "0/0",
        "-3/-3 -2/-2 -1/-1 1/1 2/2 3/3 -3/-2 -2/-1 -1/0 0/1 1/2 2/3 -3/-1 -2/0 -1/1 0/2 1/3 \
         -3/0 -2/1 -1/2 0/3",
    ),
    (
        "-1/0",
        "-3/-2 -2/-1 0/1 1/2 -3/-1 -2/0 -1/1 0/2 -3/0 -2/1 -1/2",
    ),
    ("0/1", "-2/-1 -1/0 1/2 2/3 -2/0 -1/1 0/2 1/3 -2/1 -1/2 0/3"),
    ("-2/0", "-3/-1 -1/1 -3/0 -2/1"),
    ("0/2", "-1/1 1/3 -1/2 0/3"),
];

fn offsets(text: &str) -> (i8, i8) {
    let (from, to) = text.split_once('/').unwrap();
    (from.parse().unwrap(), to.parse().unwrap())
}

/// A path's ends as offsets from `sensor`, −12 to 11.
fn seen_from(sensor: SensorId, path: Path) -> (i8, i8) {
    let off = |slot: u8| {
        let off = i16::from(slot) - (i16::from(sensor.number()) - 1);
        ((off + 12).rem_euclid(24) - 12) as i8
    };
    let [from, to] = Ring::<24>::ends(path);
    (off(from), off(to))
}

type Pairs = BTreeSet<((i8, i8), (i8, i8))>;

fn printed() -> Pairs {
    let lines = PRINTED.iter().flat_map(|(own, others)| {
        let others = others.split_whitespace();
        others.map(move |other| (offsets(own), offsets(other)))
    });
    lines.collect()
}

fn generated(
    overlaps: impl Iterator<Item = Overlap>,
    sensor: SensorId,
) -> Vec<((i8, i8), (i8, i8))> {
    let pairs = overlaps.map(|overlap| {
        let Overlap { own, other } = overlap;
        (seen_from(sensor, own), seen_from(sensor, other))
    });
    pairs.collect()
}

#[test]
fn the_rule_gives_the_papers_51_overlaps_for_every_sensor() {
    let ring = ring();
    for sensor in ring.sensors() {
        let found = generated(overlaps(&ring, sensor), sensor);
        assert_eq!(found.len(), 51);
        assert_eq!(Pairs::from_iter(found), printed());
    }
}

#[test]
fn thirty_five_of_them_do_not_involve_the_sensor() {
    let ring = ring();
    let independent: Pairs = printed()
        .into_iter()
        .filter(|&(_, (from, to))| from != 0 && to != 0)
        .collect();
    assert_eq!(independent.len(), 35);
    let of_own = |own| independent.iter().filter(|pair| pair.0 == own).count();
    let split = [(0, 0), (-1, 0), (0, 1), (-2, 0), (0, 2)].map(of_own);
    assert_eq!(split, [15, 7, 7, 3, 3]);
    for sensor in ring.sensors() {
        let found = generated(independent_overlaps(&ring, sensor), sensor);
        assert_eq!(found.len(), 35);
        assert_eq!(Pairs::from_iter(found), independent);
    }
}

#[test]
fn there_are_24_direct_paths_and_72_across() {
    let ring = ring();
    let orders: Vec<_> = ring.paths().map(Path::order).collect();
    let of = |order| orders.iter().filter(|&&o| o == order).count();
    assert_eq!([of(0), of(1), of(2), of(3)], [24; 4]);
    // 60°, 45°, 30° and 15°.
    let degrees =
        [0, 1, 2, 3].map(|order| f64::from(ring.half_width(order)) * 2.0 / 65536.0 * 360.0);
    for (found, printed) in degrees.into_iter().zip([60.0, 45.0, 30.0, 15.0]) {
        assert!((found - printed).abs() < 0.02, "{found} for {printed}");
    }
}

#[test]
fn a_ring_with_narrow_cones_has_fewer_paths_and_overlaps() {
    let narrow = RingConfig {
        opening_millidegrees: 30_000,
        ..RingConfig::DEFAULT
    };
    let ring = Ring::<24>::try_new(narrow).unwrap();
    // 30° wide and 15° apart: the next neighbour's cone overlaps by 15°, the second's only touches.
    assert_eq!(ring.paths().count(), 48);
    let found = generated(overlaps(&ring, id(7)), id(7));
    let expected: Pairs = [
        ((0, 0), (-1, -1)),
        ((0, 0), (1, 1)),
        ((0, 0), (-1, 0)),
        ((0, 0), (0, 1)),
    ]
    .into();
    // Cross paths are 15° wide and 15° apart, and direct ones at ±1.5 spacings touch as well.
    assert_eq!(Pairs::from_iter(found), expected);
}

/// What every path hears if the surroundings are a circle about the robot.
fn round(distance: u32) -> Distances<24> {
    let ring = ring();
    let mut echoes = Echoes::silent();
    for path in ring.paths() {
        let (_, half_apart) = ring.chord(path.order());
        let half_apart = half_apart as f64 / 16.0;
        let length = 2.0 * f64::from(distance).hypot(half_apart);
        let [from, to] = Ring::<24>::ends(path).map(|slot| id(slot + 1));
        let reading = Reading::Echo(Millimeters::new(length.round() as u32));
        echoes.set(from, to, reading).unwrap();
        echoes.set(to, from, reading).unwrap();
    }
    Distances::fold(&ring, &echoes, &RingRules::DEFAULT)
}

#[test]
fn echoes_as_expected_confirm_all_seven_paths() {
    let (ring, none) = (ring(), [false; 24]);
    let heard = round(1000);
    let rules = RingRules::DEFAULT;
    for (off, paths) in [(0, 7), (99, 7), (101, 0)] {
        let vector = simulation_based(&ring, &round(1000 + off), &heard, &none, &rules);
        assert_eq!(vector, [paths; 24], "{off} mm off");
    }
    // A difference of just the threshold is not below it.
    let vector = simulation_based(&ring, &round(1100), &heard, &none, &rules);
    assert!(vector.iter().all(|&paths| paths < 7));
}

#[test]
fn a_removed_sensor_counts_for_itself_only() {
    let (ring, heard) = (ring(), round(1000));
    let mut removed = [false; 24];
    removed[3] = true;
    let rules = RingRules::DEFAULT;
    let vector = simulation_based(&ring, &heard, &heard, &removed, &rules);
    let mut expected = [7; 24];
    for neighbour in [0, 1, 2, 4, 5, 6] {
        expected[neighbour] = 6;
    }
    assert_eq!(vector, expected);

    let all = intersection_based(&ring, &heard, &[false; 24], &rules);
    let fewer = intersection_based(&ring, &heard, &removed, &rules);
    assert_eq!(fewer[3], all[3], "nobody else of its overlaps is removed");
    for neighbour in [0, 1, 2, 4, 5, 6] {
        assert!(fewer[neighbour] < all[neighbour]);
    }
    assert_eq!(fewer[12], all[12]);
}

#[test]
fn unknown_echoes_confirm_nothing() {
    let (ring, none, rules) = (ring(), [false; 24], RingRules::DEFAULT);
    let unknown = Distances::fold(&ring, &Echoes::unknown(), &rules);
    assert_eq!(
        simulation_based(&ring, &round(1000), &unknown, &none, &rules),
        [0; 24]
    );
    assert_eq!(intersection_based(&ring, &unknown, &none, &rules), [0; 24]);
}

/// Silent arcs side by side at the range would all meet; in the paper's example sonar 8 hears what is
/// expected on six of seven paths and meets nothing.
#[test]
fn silence_is_confirmed_by_the_simulation_and_by_no_arc() {
    let (ring, none, rules) = (ring(), [false; 24], RingRules::DEFAULT);
    let silent = Distances::fold(&ring, &Echoes::silent(), &rules);
    assert_eq!(
        simulation_based(&ring, &silent, &silent, &none, &rules),
        [7; 24]
    );
    assert_eq!(intersection_based(&ring, &silent, &none, &rules), [0; 24]);
    // One millimetre nearer there is something to meet.
    let meeting = intersection_based(&ring, &round(1999), &none, &rules);
    assert!(meeting.iter().all(|&arcs| arcs > 0));
}

#[test]
fn no_vector_is_above_its_bound() {
    let (ring, none, rules) = (ring(), [false; 24], RingRules::DEFAULT);
    for distance in [0, 50, 300, 1999, 2500] {
        let heard = round(distance);
        let simulated = simulation_based(&ring, &heard, &heard, &none, &rules);
        assert!(simulated.iter().all(|&paths| paths <= PATHS_OF_A_SENSOR));
        let meeting = intersection_based(&ring, &heard, &none, &rules);
        assert!(meeting.iter().all(|&arcs| arcs <= INDEPENDENT_OVERLAPS));
    }
}

#[test]
fn rules_that_cannot_be_are_refused() {
    let base = RingRulesConfig::DEFAULT;
    let zero = Millimeters::ZERO;
    let never = [
        RingRulesConfig {
            consistent: zero,
            ..base
        },
        RingRulesConfig {
            uncertainty: zero,
            ..base
        },
    ];
    for config in never {
        assert_eq!(RingRules::try_new(config), Err(RingRulesError::Never));
    }
    let touch = RingRulesConfig {
        touch: Millimeters::new(1000),
        ..base
    };
    assert_eq!(RingRules::try_new(touch), Err(RingRulesError::Touch));
    let step = RingRulesConfig {
        lower: U0F16::ZERO,
        ..base
    };
    assert_eq!(RingRules::try_new(step), Err(RingRulesError::Step));
    let nobody = RingRulesConfig { least: 0, ..base };
    assert_eq!(RingRules::try_new(nobody), Err(RingRulesError::Least));
    assert_eq!(RingRules::try_new(base), Ok(RingRules::DEFAULT));
}
