use super::*;
use crate::{Folded, Path, PolygonRules, RingConfig, Scan, Scanner};
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Direction, Millimeters, Pose};
use proptest::prelude::*;

const fn mm(mm: u32) -> Millimeters {
    Millimeters::new(mm)
}

/// An upright room with the robot at its origin, seen by a scanner in the middle, exact to 1 mm.
fn room(right: i64, top: i64, left: i64, bottom: i64) -> Polygon<64> {
    let scanner = Scanner::try_new(Pose::default(), mm(30_000)).unwrap();
    let mut scan = Scan::<720>::new();
    for beam in 0..720 {
        let bearing = BinaryAngle::from_millidegrees(beam * 500);
        let direction = bearing.direction();
        let until = |wall: i64, part: i32| {
            let far = (wall << Direction::FRACTION_BITS).checked_div(part.into());
            far.filter(|&far| far > 0)
        };
        let walls = [
            until(right, direction.cos()),
            until(top, direction.sin()),
            until(-left, direction.cos()),
            until(-bottom, direction.sin()),
        ];
        let range = walls.into_iter().flatten().min().unwrap();
        let range = Reading::Echo(mm(range as u32));
        scan.add(&scanner, bearing, range).unwrap();
    }
    Polygon::of(&scan, &PolygonRules::DEFAULT).unwrap()
}

fn ring() -> Ring<24> {
    Ring::try_new(RingConfig::DEFAULT).unwrap()
}

fn distance(distances: &Distances<24>, from: u8, order: u8) -> u32 {
    match distances.get(Path::new(from, order)) {
        Folded::Distance(distance) => distance.get(),
        other => panic!("{other:?}"),
    }
}

/// The room's echoes in floating point, from first principles: mirror images of the second sonar in
/// each wall and corner, which lie in cones of so many degrees to either side.
fn naive(walls: [f64; 4], from: u8, order: u8, [to_walls, to_corners]: [f64; 2]) -> f64 {
    let axes = [from, from + order].map(|slot| f64::from(slot) * core::f64::consts::TAU / 24.0);
    let [s, t] = axes.map(|axis| (300.0 * axis.cos(), 300.0 * axis.sin()));
    let [right, top, left, bottom] = walls;
    let sees = |x: f64, y: f64, half_cone_degrees: f64| {
        [s, t].iter().zip(axes).all(|(&(sx, sy), axis)| {
            let (dx, dy) = (x - sx, y - sy);
            let ahead = dx * axis.cos() + dy * axis.sin();
            ahead >= dx.hypot(dy) * half_cone_degrees.to_radians().cos()
        })
    };
    let mut best = f64::INFINITY;
    // Walls across x, then across y.
    for wall in [right, -left] {
        let (a, b) = ((wall - s.0).abs(), (wall - t.0).abs());
        let y = (s.1 * b + t.1 * a) / (a + b);
        if (-bottom..=top).contains(&y) && sees(wall, y, to_walls) {
            best = best.min((a + b).hypot(s.1 - t.1));
        }
    }
    for wall in [top, -bottom] {
        let (a, b) = ((wall - s.1).abs(), (wall - t.1).abs());
        let x = (s.0 * b + t.0 * a) / (a + b);
        if (-left..=right).contains(&x) && sees(x, wall, to_walls) {
            best = best.min((a + b).hypot(s.0 - t.0));
        }
    }
    for (x, y) in [
        (right, top),
        (-left, top),
        (-left, -bottom),
        (right, -bottom),
    ] {
        if sees(x, y, to_corners) {
            best = best.min((x - s.0).hypot(y - s.1) + (x - t.0).hypot(y - t.1));
        }
    }
    let half_apart = (s.0 - t.0).hypot(s.1 - t.1) / 2.0;
    let distance = ((best / 2.0).powi(2) - half_apart.powi(2)).sqrt();
    distance.min(2000.0)
}

#[test]
fn a_wall_ahead_is_heard_at_its_distance_directly_and_across() {
    let distances = Distances::simulated(&ring(), &room(1300, 5000, 5000, 5000));
    assert_eq!(distance(&distances, 0, 0), 1000);
    // Sonars 24 and 2, and the middle between them 0.3 m · cos 15° ahead: 1300 − 289.8.
    assert_eq!(distance(&distances, 23, 2), 1010);
    // Sonar 13 looks the other way, where nothing is within 2 m.
    assert_eq!(distance(&distances, 12, 0), 2000);
}

#[test]
fn a_corner_is_heard_by_the_sonar_that_looks_into_it() {
    let distances = Distances::simulated(&ring(), &room(1000, 1000, 5000, 5000));
    // Sonar 4 looks at 45°: (1000, 1000) is √2 m from the middle, 0.3 m less from the sonar. Both
    // walls' feet are 45° off its axis, outside its cone.
    let found = distance(&distances, 3, 0);
    assert!((1113..=1115).contains(&found), "{found}");
}

#[test]
fn what_is_hidden_is_not_heard() {
    // A pillar 0.6 m ahead, seen in front of a wall at 1.2 m: sonar 1 hears the pillar only.
    let points = [
        (1200, -900),
        (1200, -301),
        (600, -150),
        (600, 150),
        (1200, 301),
        (1200, 900),
        (-2900, 900),
        (-2900, -900),
    ];
    let mut scan = Scan::<1024>::new();
    for (place, &(x, y)) in points.iter().enumerate() {
        let (to_x, to_y) = points[(place + 1) % points.len()];
        let steps = 60;
        for step in 0..steps {
            let at = |from: i32, to: i32| (from + (to - from) * step / steps) as i16;
            scan.place([at(x, to_x), at(y, to_y)]);
        }
    }
    let polygon = Polygon::<64>::of(&scan, &PolygonRules::DEFAULT).unwrap();
    let distances = Distances::simulated(&ring(), &polygon);
    assert_eq!(distance(&distances, 0, 0), 300);
    // Sonar 2 at 15°: its foot on the wall, (1200, 78), is behind the pillar; so is all of the wall
    // that would send an echo back. It hears the pillar: 600 − 300·cos 15°.
    assert_eq!(distance(&distances, 1, 0), 310);
    // Sonar 4 at 45°: the wall's foot at y = 212 is behind the pillar's shadow; the wall above at
    // 900 − 212 = 688 is 45° off; the corner at (1200, 900) is 34.9° from the middle.
    let corner = (1200.0_f64 - 212.13).hypot(900.0 - 212.13).round() as u32;
    assert_eq!(distance(&distances, 3, 0), corner);
}

#[test]
fn edges_are_not_heard() {
    // An L-shaped room whose inner corner, at (500, 500), points at the robot: sonar 4 looks at it, its
    // walls are outside the cone, and so nothing is heard within 2 m but what the rule excludes.
    let points = [
        (2500, -1000),
        (2500, 500),
        (500, 500),
        (500, 2500),
        (-1000, 2500),
        (-1000, -1000),
    ];
    let mut scan = Scan::<1024>::new();
    for (place, &(x, y)) in points.iter().enumerate() {
        let (to_x, to_y) = points[(place + 1) % points.len()];
        for step in 0..80 {
            let at = |from: i32, to: i32| (from + (to - from) * step / 80) as i16;
            scan.place([at(x, to_x), at(y, to_y)]);
        }
    }
    let polygon = Polygon::<64>::of(&scan, &PolygonRules::DEFAULT).unwrap();
    assert_eq!(
        distance(&Distances::simulated(&ring(), &polygon), 3, 0),
        2000
    );
}

#[test]
fn an_empty_polygon_is_heard_nowhere() {
    let distances = Distances::simulated(&ring(), &Polygon::<1>::empty());
    for path in ring().paths() {
        assert_eq!(distances.get(path), Folded::Distance(mm(2000)));
    }
}

/// Compares every path in a room with its mirror images.
fn assert_mirror_images(walls: [i64; 4]) {
    let [right, top, left, bottom] = walls;
    let polygon = room(right, top, left, bottom);
    assert_eq!(polygon.elements().len(), 4);
    let distances = Distances::simulated(&ring(), &polygon);
    for path in ring().paths() {
        let found = distance(&distances, path.slot(), path.order());
        // Places at the very border of a cone may go either way, a wall 30° off and the corner beside it each by
        // itself.
        let halves = [[29.7, 29.7], [29.7, 30.3], [30.3, 29.7], [30.3, 30.3]];
        let expected = halves.map(|halves| {
            naive(
                walls.map(|wall| wall as f64),
                path.slot(),
                path.order(),
                halves,
            )
        });
        let off = expected
            .iter()
            .map(|expected| (f64::from(found) - expected).abs());
        // A point at a corner may be counted to either wall, which tilts the shorter one: a tenth
        // of the paper's threshold is allowed for it.
        assert!(
            off.fold(f64::INFINITY, f64::min) <= 10.0,
            "{path:?}: {found} for {expected:?}"
        );
    }
}

/// Sonar 5's foot on the top wall is 30° off its axis, the corner on its other side 29.8°.
#[test]
fn a_wall_and_a_corner_at_the_border_of_a_cone_count_each_by_itself() {
    assert_mirror_images([904, 699, 1741, 2189]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn every_path_of_any_room_is_that_of_mirror_images(
        walls in prop::array::uniform4(500_i64..3000),
    ) {
        assert_mirror_images(walls);
    }

    #[test]
    fn sizes_of_rings_agree_with_the_same_oracle_turned(first in any::<u16>()) {
        // Turning ring and numbering by whole places changes nothing else.
        let spacing = 8192_u16;
        let turned = first / spacing * spacing;
        let config = RingConfig { first: BinaryAngle::from_bits(turned), ..RingConfig::DEFAULT };
        let ring = Ring::<8>::try_new(config).unwrap();
        let straight = Ring::<8>::try_new(RingConfig::DEFAULT).unwrap();
        let polygon = room(1000, 1500, 800, 1200);
        let places = (turned / spacing) as u8;
        let (one, other) = (
            Distances::simulated(&ring, &polygon),
            Distances::simulated(&straight, &polygon),
        );
        for path in ring.paths() {
            let same = Path::new((path.slot() + places) % 8, path.order());
            prop_assert_eq!(one.get(path), other.get(same));
        }
    }
}
