//! The distances that the sonars should measure in the polygon of the surroundings (\[003\] §4).

use super::distances::{Distances, length_of, of_length, saturating_u16};
use super::geometry::{FinePoint, saturating_i32};
use super::polygon::{Element, ElementKind, Joint, Polygon};
use super::ring::{Ring, Sonar};

impl<const SENSORS: usize> Distances<SENSORS> {
    /// Computes the distance that each path should give in the surroundings `polygon` (\[003\] §4).
    ///
    /// Walls reflect like mirrors, corners (concave) reflect sound back to its source, edges (convex)
    /// scatter and give no echo. A reflection point must be within the cones of both sonars of the path;
    /// it is occluded if the line to either sonar crosses another element of the polygon. Each path gets
    /// its shortest echo, or the range if there is none within it.
    ///
    /// Cost: one reflection for each of 96 paths and each element. A reflection shorter than the path's
    /// current minimum is also tested for occlusion, against all elements.
    #[must_use]
    pub fn simulated<const ELEMENTS: usize>(
        ring: &Ring<SENSORS>,
        polygon: &Polygon<ELEMENTS>,
    ) -> Self {
        let mut distances = Self::UNKNOWN;
        let range = ring.config().range;
        let none = saturating_u16(range.get().into());
        for path in ring.paths() {
            let sonars = ring.sonars(path);
            let longest = length_of(ring, path.order(), range);
            let shortest = shortest(polygon.elements(), &sonars, longest);
            let echo = shortest.and_then(|length| of_length(ring, path.order(), length));
            distances.set(path, echo.map_or(none, |distance| distance.min(none)));
        }
        distances
    }
}

/// The shortest echo path below `longest` between two sonars, in sixteenths of a millimetre.
fn shortest(elements: &[Element], sonars: &[Sonar; 2], longest: u64) -> Option<u64> {
    let mut best = longest;
    let mut before = elements.last();
    for element in elements {
        let wall = (element.kind() == ElementKind::Wall).then(|| off_wall(element, sonars));
        if let Some((length, point)) = wall.flatten()
            && length < best
            && reaches(elements, sonars, point, [element; 2])
        {
            best = length;
        }
        let corner = before.filter(|_| element.joint() == Joint::Corner);
        if let Some(before) = corner {
            let point = element.start();
            let [there, back] = sonars.map(|sonar| point.minus(sonar.at).length());
            let length = there.wrapping_add(back);
            if length < best && reaches(elements, sonars, point, [before, element]) {
                best = length;
            }
        }
        before = Some(element);
    }
    (best < longest).then_some(best)
}

/// Path length and point of the reflection at a wall, by the mirror image of the second sonar.
fn off_wall(element: &Element, sonars: &[Sonar; 2]) -> Option<(u64, FinePoint)> {
    let line = element.line();
    let [from, to] = sonars.map(|sonar| {
        let (depth, along) = (line.signed_distance(sonar.at), line.position(sonar.at));
        (i64::from(depth), i64::from(along))
    });
    if from.0 <= 0 || to.0 <= 0 {
        return None;
    }
    // Below 2^22 and 2^45: points of a scan are below 2^20 sixteenths.
    let deep = from.0.wrapping_add(to.0);
    let weighted = from.1.wrapping_mul(to.0);
    let weighted = weighted.wrapping_add(to.1.wrapping_mul(from.0));
    let along = weighted.checked_div(deep)?;
    let ends = [element.start(), element.end()].map(|end| i64::from(line.position(end)));
    let [start, end] = ends;
    if along < start.min(end) || along > start.max(end) {
        return None;
    }
    let aside = from.1.wrapping_sub(to.1);
    let square = aside.wrapping_mul(aside);
    let square = square.wrapping_add(deep.wrapping_mul(deep)).unsigned_abs();
    Some((square.isqrt(), line.at(saturating_i32(along))))
}

/// Whether `point` is within the cones of both sonars and no element other than those `at` the point
/// occludes it.
fn reaches(elements: &[Element], sonars: &[Sonar; 2], point: FinePoint, at: [&Element; 2]) -> bool {
    let others = || {
        let elements = elements.iter();
        elements.filter(|&element| !at.iter().any(|&own| core::ptr::eq(own, element)))
    };
    sonars.iter().all(|sonar| sonar.covers(point))
        && sonars
            .iter()
            .all(|sonar| !others().any(|element| crosses(element, sonar.at, point)))
}

/// Whether an element crosses the straight way from one point to another.
///
/// A way through a vertex crosses exactly one of the two elements there: a point on the way counts as
/// left of it.
fn crosses(element: &Element, from: FinePoint, to: FinePoint) -> bool {
    let (start, end) = (element.start(), element.end());
    let way = to.minus(from);
    let along = end.minus(start);
    let left_of_way = |point: FinePoint| way.cross(point.minus(from)) >= 0;
    let left_of_element = |point: FinePoint| along.cross(point.minus(start)) >= 0;
    left_of_way(start) != left_of_way(end) && left_of_element(from) != left_of_element(to)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Folded, Path, PolygonRules, RingConfig, Scan, Scanner};
    use certainty_core::transducer::Reading;
    use certainty_core::units::{BinaryAngle, Direction, Millimeters, Pose};
    use proptest::prelude::*;

    const fn mm(mm: u32) -> Millimeters {
        Millimeters::new(mm)
    }

    /// The polygon of an axis-parallel room around the origin, scanned from there with an error of 1 mm at
    /// most.
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
    /// each wall and corner, within cones of the given half angles in degrees.
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
    fn a_wall_ahead_gives_its_distance_on_all_paths() {
        let distances = Distances::simulated(&ring(), &room(1300, 5000, 5000, 5000));
        assert_eq!(distance(&distances, 0, 0), 1000);
        // Sonars 24 and 2, with their midpoint 0.3 m · cos 15° ahead: 1300 − 289.8.
        assert_eq!(distance(&distances, 23, 2), 1010);
        // Sonar 13 faces the other way, where nothing is within 2 m.
        assert_eq!(distance(&distances, 12, 0), 2000);
    }

    #[test]
    fn a_corner_reflects_to_the_sonar_that_faces_it() {
        let distances = Distances::simulated(&ring(), &room(1000, 1000, 5000, 5000));
        // Sonar 4 faces 45°: (1000, 1000) is √2 m from the centre, 0.3 m less from the sonar. The feet of
        // both walls are 45° off its axis, outside its cone.
        let found = distance(&distances, 3, 0);
        assert!((1113..=1115).contains(&found), "{found}");
    }

    #[test]
    fn an_occluded_wall_gives_no_echo() {
        // A pillar 0.6 m ahead, in front of a wall at 1.2 m: sonar 1 measures the pillar.
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
        // Sonar 2 at 15°: its foot on the wall, (1200, 78), is behind the pillar, as is all of the wall
        // that could reflect. It measures the pillar: 600 − 300·cos 15°.
        assert_eq!(distance(&distances, 1, 0), 310);
        // Sonar 4 at 45°: the wall's foot at y = 212 is behind the pillar's shadow; the wall above at
        // 900 − 212 = 688 is 45° off; the corner at (1200, 900) is 34.9° from the centre.
        let corner = (1200.0_f64 - 212.13).hypot(900.0 - 212.13).round() as u32;
        assert_eq!(distance(&distances, 3, 0), corner);
    }

    #[test]
    fn edges_give_no_echo() {
        // An L-shaped room whose inner corner, at (500, 500), points at the robot. Sonar 4 faces it, and its
        // walls are outside the cone: the edge alone is within 2 m, and it scatters.
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
    fn an_empty_polygon_gives_no_echo() {
        let distances = Distances::simulated(&ring(), &Polygon::<1>::empty());
        for path in ring().paths() {
            assert_eq!(distances.get(path), Folded::Distance(mm(2000)));
        }
    }

    /// Compares every path in a room with the mirror images.
    fn assert_mirror_images(walls: [i64; 4]) {
        let [right, top, left, bottom] = walls;
        let polygon = room(right, top, left, bottom);
        assert_eq!(polygon.elements().len(), 4);
        let distances = Distances::simulated(&ring(), &polygon);
        for path in ring().paths() {
            let found = distance(&distances, path.slot(), path.order());
            // Points at the border of a cone may count or not: a wall 30° off and the corner beside it, each
            // on its own.
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
            // A point at a corner may be assigned to either wall, which tilts the shorter one: a tenth of
            // the paper's threshold is allowed for it.
            assert!(
                off.fold(f64::INFINITY, f64::min) <= 10.0,
                "{path:?}: {found} for {expected:?}"
            );
        }
    }

    /// Sonar 5's foot on the top wall is 30° off its axis, the corner on its other side 29.8°.
    #[test]
    fn a_wall_and_a_corner_at_a_cone_border() {
        assert_mirror_images([904, 699, 1741, 2189]);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn any_path_of_any_room_is_that_of_mirror_images(
            walls in prop::array::uniform4(500_i64..3000),
        ) {
            assert_mirror_images(walls);
        }

        #[test]
        fn turning_the_ring_by_slots_renumbers_it_only(first in any::<u16>()) {
            // Turning the ring by whole slots renumbers its sonars and changes nothing else.
            let spacing = 8192_u16;
            let turned = first / spacing * spacing;
            let config = RingConfig { first: BinaryAngle::from_bits(turned), ..RingConfig::DEFAULT };
            let ring = Ring::<8>::try_new(config).unwrap();
            let straight = Ring::<8>::try_new(RingConfig::DEFAULT).unwrap();
            let polygon = room(1000, 1500, 800, 1200);
            let slots = (turned / spacing) as u8;
            let (one, other) = (
                Distances::simulated(&ring, &polygon),
                Distances::simulated(&straight, &polygon),
            );
            for path in ring.paths() {
                let same = Path::new((path.slot() + slots) % 8, path.order());
                prop_assert_eq!(one.get(path), other.get(same));
            }
        }
    }
}
