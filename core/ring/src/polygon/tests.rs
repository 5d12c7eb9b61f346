use super::*;
use crate::Scanner;
use certainty_core::transducer::Reading;
use certainty_core::units::Pose;
use proptest::prelude::*;

const fn mm(mm: u32) -> Millimeters {
    Millimeters::new(mm)
}

/// A scan of points in whole millimetres, given as they are.
fn scan(points: &[[i32; 2]]) -> Scan<1024> {
    let mut scan = Scan::new();
    for &[x, y] in points {
        scan.place([x as i16, y as i16]);
    }
    scan
}

/// Points every 20 mm along the closed outline through `corners`.
fn outline(corners: &[[i32; 2]]) -> Vec<[i32; 2]> {
    let mut points = Vec::new();
    for (place, &[x, y]) in corners.iter().enumerate() {
        let [to_x, to_y] = corners[(place + 1) % corners.len()];
        let (run, rise) = (to_x - x, to_y - y);
        let steps = run.abs().max(rise.abs()) / 20;
        points.extend((0..steps).map(|step| [x + run * step / steps, y + rise * step / steps]));
    }
    points
}

fn polygon(points: &[[i32; 2]]) -> Polygon<64> {
    Polygon::of(&scan(points), &PolygonRules::DEFAULT).unwrap()
}

fn starts(polygon: &Polygon<64>) -> Vec<[i32; 2]> {
    let starts = polygon.elements().iter().map(|element| element.start());
    starts
        .map(|start| [(start.x() + 8) >> 4, (start.y() + 8) >> 4])
        .collect()
}

const ROOM: [[i32; 2]; 4] = [[1500, -1000], [1500, 2000], [-2000, 2000], [-2000, -1000]];

#[test]
fn a_closed_box_has_four_walls_and_four_corners_wherever_the_scan_begins() {
    let mut points = outline(&ROOM);
    for _ in 0..points.len() / 7 {
        points.rotate_left(7);
        let polygon = polygon(&points);
        let mut found = starts(&polygon);
        // Where the list begins is free; the order is not.
        let first = found.iter().position(|&start| start == ROOM[0]).unwrap();
        found.rotate_left(first);
        assert_eq!(found, ROOM);
        for element in polygon.elements() {
            assert_eq!(element.kind(), ElementKind::Wall);
            assert_eq!(element.joint(), Joint::Corner);
        }
    }
}

#[test]
fn a_pillar_in_a_room_has_edges_and_pseudo_segments_beside_it() {
    // Seen from the origin: the room's wall ahead is hidden between the pillar's sides.
    let around = [
        [1500, -1000],
        [1500, -375], // the pillar's shadow ends
        [800, -200],
        [800, 200],
        [1500, 375],
        [1500, 2000],
        [-2000, 2000],
        [-2000, -1000],
    ];
    let polygon = polygon(&outline(&around));
    let kinds: Vec<_> = polygon
        .elements()
        .iter()
        .map(|element| (element.kind(), element.joint()))
        .collect();
    let wall = |joint| (ElementKind::Wall, joint);
    let pseudo = (ElementKind::Pseudo, Joint::Open);
    let mut expected = [
        wall(Joint::Corner), // the piece of wall to the right of the pillar
        pseudo,
        wall(Joint::Open), // the pillar
        pseudo,
        wall(Joint::Open),
        wall(Joint::Corner),
        wall(Joint::Corner),
        wall(Joint::Corner),
    ];
    let begins = kinds.iter().position(|&kind| kind == pseudo).unwrap();
    expected.rotate_left(1);
    let mut kinds = kinds;
    kinds.rotate_left(begins);
    assert_eq!(kinds, expected);
}

#[test]
fn what_stands_out_into_the_room_is_an_edge() {
    // An L-shaped room; the inner corner at (500, 500) points at the robot.
    let around = [
        [2000, -1000],
        [2000, 500],
        [500, 500],
        [500, 2000],
        [-1000, 2000],
        [-1000, -1000],
    ];
    let polygon = polygon(&outline(&around));
    let edges: Vec<_> = polygon
        .elements()
        .iter()
        .filter(|element| element.joint() == Joint::Edge)
        .map(|element| [element.start().x(), element.start().y()])
        .collect();
    assert_eq!(edges, [[500 * 16, 500 * 16]]);
    let corners = polygon
        .elements()
        .iter()
        .filter(|e| e.joint() == Joint::Corner);
    assert_eq!(corners.count(), 5);
}

#[test]
fn noise_below_the_threshold_leaves_a_wall_whole_and_noise_above_divides_it() {
    // ±δ in turn deviates by δ; the paper accepts below 22 mm.
    let with_noise = |delta: i32| {
        let mut points = outline(&ROOM);
        for (number, point) in points.iter_mut().enumerate() {
            let off = if number % 2 == 0 { delta } else { -delta };
            let [x, y] = *point;
            *point = if x.abs() >= 1500 {
                [x + off, y]
            } else {
                [x, y + off]
            };
        }
        Polygon::<1024>::of(&scan(&points), &PolygonRules::DEFAULT).unwrap()
    };
    assert_eq!(with_noise(15).elements().len(), 4);
    assert!(with_noise(40).elements().len() > 40);
}

#[test]
fn degenerate_scans_have_defined_polygons() {
    assert_eq!(polygon(&[]).elements().len(), 0);

    let one = polygon(&[[300, 400]]);
    let [element] = one.elements() else { panic!() };
    assert_eq!(element.start(), element.end());
    assert_eq!(element.line().distance(), mm(500));

    let twice = polygon(&[[300, 400]; 50]);
    assert_eq!(twice.elements().len(), 1);
    assert_eq!(twice.elements()[0].points(), 50);

    let collinear: Vec<_> = (-20..=20).map(|step| [1000, step * 50]).collect();
    let wall = polygon(&collinear);
    let [element] = wall.elements() else { panic!() };
    assert_eq!((element.start().y(), element.end().y()), (-16_000, 16_000));
    assert_eq!(element.joint(), Joint::Open);

    // Two places in turn are one line, as often as one looks.
    let two: Vec<_> = (0..100).map(|n| [500, n % 2 * 900]).collect();
    assert_eq!(polygon(&two).elements().len(), 1);
}

#[test]
fn a_scan_that_meets_nothing_is_round_at_the_scanners_range() {
    let scanner = Scanner::try_new(Pose::default(), mm(8000)).unwrap();
    let mut scan = Scan::<722>::new();
    for beam in 0..720 {
        let bearing = BinaryAngle::from_millidegrees(beam * 500);
        scan.add(&scanner, bearing, Reading::NoObject).unwrap();
    }
    let polygon = Polygon::<64>::of(&scan, &PolygonRules::DEFAULT).unwrap();
    // A chord whose points deviate by 22 mm bulges by some 74 mm: 15.6° of 8 m, so 23 chords at least.
    assert!((23..=64).contains(&polygon.elements().len()));
    for element in polygon.elements() {
        assert_eq!(element.kind(), ElementKind::Wall);
        assert!(element.line().distance() > mm(7800));
    }
}

#[test]
fn a_scan_with_too_many_pieces_is_refused_with_the_room_there_was() {
    let zigzag: Vec<_> = (0..200)
        .map(|n| [1000 + n % 2 * 500, n * 20 - 2000])
        .collect();
    let refused = Polygon::<16>::of(&scan(&zigzag), &PolygonRules::DEFAULT);
    assert_eq!(refused.unwrap_err(), TooManyElements { room: 16 });
}

#[test]
fn rules_that_cannot_be_are_refused() {
    let base = PolygonConfig::DEFAULT;
    for spread in [0, 1001] {
        let refused = PolygonRules::try_new(PolygonConfig {
            spread: mm(spread),
            ..base
        });
        assert_eq!(refused, Err(PolygonConfigError::Spread));
    }
    let turn = BinaryAngle::from_millidegrees(90_100);
    let refused = PolygonRules::try_new(PolygonConfig { turn, ..base });
    assert_eq!(refused, Err(PolygonConfigError::Turn));
    assert_eq!(PolygonRules::try_new(base), Ok(PolygonRules::DEFAULT));
}

proptest! {
    #[test]
    fn every_point_is_near_the_element_it_belongs_to(
        // A room whose corners are at random, one in each quadrant.
        corners in prop::array::uniform4((600_i32..5000, 600_i32..5000)),
        begin in 0_usize..1000,
    ) {
        let [a, b, c, d] = corners;
        let around = [[a.0, -a.1], [b.0, b.1], [-c.0, c.1], [-d.0, -d.1]];
        let mut points = outline(&around);
        points.truncate(1024);
        let begin = begin % points.len();
        points.rotate_left(begin);
        let polygon = polygon(&points);
        let mut members = 0;
        for element in polygon.elements() {
            members += usize::from(element.points());
        }
        // Each point is of one element, and each dividing point of two.
        prop_assert_eq!(members, points.len() + polygon.elements().len());
        // The polygon is closed.
        for (place, element) in polygon.elements().iter().enumerate() {
            let next = &polygon.elements()[(place + 1) % polygon.elements().len()];
            prop_assert_eq!(element.end(), next.start());
        }
    }

    #[test]
    fn any_points_make_a_polygon_or_are_refused(
        points in prop::collection::vec(prop::array::uniform2(-32_768_i32..32_768), 0..300),
        repeat in 1_usize..4,
    ) {
        let points: Vec<_> = points.into_iter().flat_map(|p| core::iter::repeat_n(p, repeat)).collect();
        match Polygon::<64>::of(&scan(&points), &PolygonRules::DEFAULT) {
            Ok(polygon) => prop_assert_eq!(polygon.elements().is_empty(), points.is_empty()),
            Err(refused) => prop_assert_eq!(refused.room, 64),
        }
    }
}
