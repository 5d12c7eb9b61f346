//! The echoes of a ring's sonars in a world, in closed form: flat faces, right angles and discs.

use crate::world::{Shape, World};
use certainty_core::units::{Direction, Pose};
use certainty_ring::{NEIGHBOURS, Ring, RingConfig};

/// The number of sonars.
pub const SONARS: usize = 24;

/// The paper's ring.
pub const PAPER_RING: Ring<SONARS> = Ring::new(RingConfig::DEFAULT);

/// A point or displacement in millimetres.
pub type PointMm = (f64, f64);

/// A flat face of an obstacle; its front is to the right of the direction from `from` to `to`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Face {
    /// Its start.
    pub from: PointMm,
    /// Its end.
    pub to: PointMm,
    /// Unit vector along the face.
    pub along: PointMm,
    /// Its length in millimetres.
    pub length: f64,
}

impl Face {
    fn new(from: PointMm, to: PointMm) -> Self {
        let (x, y) = (to.0 - from.0, to.1 - from.1);
        let length = x.hypot(y);
        Self {
            from,
            to,
            along: (x / length, y / length),
            length,
        }
    }

    /// Returns the position of `point` along the face, and its distance in front of it.
    #[must_use]
    pub fn local(&self, point: PointMm) -> (f64, f64) {
        let (x, y) = (point.0 - self.from.0, point.1 - self.from.1);
        let (ax, ay) = self.along;
        (x * ax + y * ay, x * ay - y * ax)
    }

    /// Returns the point at the position `along` the face.
    #[must_use]
    pub fn at(&self, along: f64) -> PointMm {
        let (ax, ay) = self.along;
        (self.from.0 + ax * along, self.from.1 + ay * along)
    }

    /// The point at the position `along` the face and the distance `before` it.
    fn off(&self, along: f64, before: f64) -> PointMm {
        let (x, y) = self.at(along);
        let (ax, ay) = self.along;
        (x + ay * before, y - ax * before)
    }
}

/// The surfaces of a world's obstacles, which reflect sound and light.
#[derive(Debug, Clone, PartialEq)]
pub struct Surfaces {
    /// Flat faces.
    pub faces: Vec<Face>,
    /// Centres and radii.
    pub discs: Vec<(PointMm, f64)>,
    /// Free points at which two faces meet in a concave right angle, to within 5°.
    pub corners: Vec<PointMm>,
}

impl Surfaces {
    /// Returns the surfaces of `world`.
    #[must_use]
    pub fn of(world: &World) -> Self {
        let (mut faces, mut discs) = (Vec::new(), Vec::new());
        for obstacle in world.obstacles() {
            match obstacle.shape() {
                Shape::Box(corners) => {
                    // Counter-clockwise, so that the inside is to the left.
                    let next = corners.iter().cycle().skip(1);
                    let sides = corners.iter().zip(next);
                    faces.extend(sides.map(|(&from, &to)| Face::new(from, to)));
                }
                Shape::Disc { centre, radius } => discs.push((centre, radius)),
            }
        }
        let corners = corners(world, &faces);
        Self {
            faces,
            discs,
            corners,
        }
    }
}

/// The concave right angles.
fn corners(world: &World, faces: &[Face]) -> Vec<PointMm> {
    /// The distance from a corner at which its four quadrants are tested, in millimetres.
    const STEP: f64 = 5.0;
    let mut found = Vec::new();
    for (number, one) in faces.iter().enumerate() {
        for other in &faces[number + 1..] {
            let cosine = one.along.0 * other.along.0 + one.along.1 * other.along.1;
            if cosine.abs() > 5_f64.to_radians().sin() {
                continue;
            }
            let sine = one.along.0 * other.along.1 - one.along.1 * other.along.0;
            let (dx, dy) = (other.from.0 - one.from.0, other.from.1 - one.from.1);
            let along = (dx * other.along.1 - dy * other.along.0) / sine;
            let point = one.at(along);
            let (beside, _) = other.local(point);
            let on = |at: f64, length: f64| (-0.5..=length + 0.5).contains(&at);
            if !on(along, one.length) || !on(beside, other.length) {
                continue;
            }
            // Free in front of both faces, and occupied behind each.
            let front = |one: f64, other_front: f64| {
                let (x, y) = (point.0, point.1);
                let normal = |face: &Face, by: f64| {
                    let (nx, ny) = face.off(0.0, by);
                    (nx - face.from.0, ny - face.from.1)
                };
                let (ox, oy) = normal(other, other_front);
                let (sx, sy) = normal(&faces[number], one);
                (x + ox + sx, y + oy + sy)
            };
            let open = !world.covers(front(STEP, STEP));
            if open && world.covers(front(STEP, -STEP)) && world.covers(front(-STEP, STEP)) {
                found.push(point);
            }
        }
    }
    found
}

/// Sound in a world.
///
/// Flat faces reflect like mirrors; a concave right angle reflects sound back over both its faces; discs
/// reflect where the angles are equal; convex edges scatter and give no echo (as \[003\] §4 found). The
/// reflection point must be within the cones of both sonars, and the ways to it must be free.
#[derive(Debug, Clone)]
pub struct Acoustics<'a> {
    world: &'a World,
    surfaces: Surfaces,
}

/// A sonar that is mounted at a wrong angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Misalignment {
    /// Its slot in the ring, from 0.
    pub slot: usize,
    /// The angle by which it is turned counter-clockwise, in radians.
    pub radians: f64,
}

/// A sonar in the world.
#[derive(Debug, Clone, Copy)]
struct Sonar {
    at: PointMm,
    axis: PointMm,
    /// Cosine of half the opening angle.
    border: f64,
}

impl Sonar {
    fn covers(&self, point: PointMm) -> bool {
        let (x, y) = (point.0 - self.at.0, point.1 - self.at.1);
        x * self.axis.0 + y * self.axis.1 >= x.hypot(y) * self.border
    }
}

fn apart(a: PointMm, b: PointMm) -> f64 {
    (a.0 - b.0).hypot(a.1 - b.1)
}

impl<'a> Acoustics<'a> {
    /// Extracts the surfaces of a world.
    #[must_use]
    pub fn new(world: &'a World) -> Self {
        Self {
            world,
            surfaces: Surfaces::of(world),
        }
    }

    /// Computes the path length of each echo, in millimetres: `[transmitter][offset + 3]`.
    ///
    /// `None` if there is no echo within the ring's range.
    #[must_use]
    pub fn lengths(
        &self,
        ring: &Ring<SONARS>,
        robot: Pose,
        misaligned: &[Misalignment],
    ) -> [[Option<f64>; 2 * NEIGHBOURS as usize + 1]; SONARS] {
        let sonars = sonars(ring, robot, misaligned);
        let farthest = 2.0 * f64::from(ring.config().range.get());
        let mut lengths = [[None; 2 * NEIGHBOURS as usize + 1]; SONARS];
        for (slot, sonar) in sonars.iter().enumerate() {
            for order in 0..=usize::from(NEIGHBOURS) {
                let other = (slot + order) % SONARS;
                let length = self.length(sonar, &sonars[other]);
                let length = length.filter(|&length| length <= farthest);
                // The path is the same in both directions.
                lengths[slot][usize::from(NEIGHBOURS) + order] = length;
                lengths[other][usize::from(NEIGHBOURS) - order] = length;
            }
        }
        lengths
    }

    /// The shortest echo path from one sonar to another.
    fn length(&self, from: &Sonar, to: &Sonar) -> Option<f64> {
        let flat = self.surfaces.faces.iter().filter_map(|face| {
            let ((a, before_a), (b, before_b)) = (face.local(from.at), face.local(to.at));
            if before_a <= 0.0 || before_b <= 0.0 {
                return None;
            }
            let along = (a * before_b + b * before_a) / (before_a + before_b);
            let on = (0.0..=face.length).contains(&along);
            on.then(|| ((a - b).hypot(before_a + before_b), face.at(along)))
        });
        let corners = self.surfaces.corners.iter().map(|&(x, y)| {
            // Two mirrors at a right angle rotate the image about the corner by half a turn.
            let image = (2.0 * x - to.at.0, 2.0 * y - to.at.1);
            (apart(from.at, image), (x, y))
        });
        let round = self.surfaces.discs.iter().map(|&(centre, radius)| {
            let point = on_disc(centre, radius, from.at, to.at);
            (apart(from.at, point) + apart(point, to.at), point)
        });
        let echoes = flat.chain(corners).chain(round).filter(|&(_, point)| {
            let clear =
                |sonar: &Sonar| sonar.covers(point) && self.world.free_between(sonar.at, point);
            clear(from) && clear(to)
        });
        echoes.map(|(length, _)| length).min_by(f64::total_cmp)
    }
}

/// The point on a disc at which the path from one point to another is shortest.
fn on_disc(centre: PointMm, radius: f64, from: PointMm, to: PointMm) -> PointMm {
    let angle = |point: PointMm| (point.1 - centre.1).atan2(point.0 - centre.0);
    let at = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        (centre.0 + radius * cos, centre.1 + radius * sin)
    };
    let way = |angle: f64| apart(from, at(angle)) + apart(at(angle), to);
    let first = angle(from);
    let turn = core::f64::consts::TAU;
    let between = (angle(to) - first + turn / 2.0).rem_euclid(turn) - turn / 2.0;
    // On the side that faces both, the path length has a single minimum.
    let (mut low, mut high) = (first.min(first + between), first.max(first + between));
    for _ in 0..60 {
        let third = (high - low) / 3.0;
        if way(low + third) < way(high - third) {
            high -= third;
        } else {
            low += third;
        }
    }
    at(f64::midpoint(low, high))
}

/// The ring's sonars in the world, in floating point, from the same angles and radius.
fn sonars(ring: &Ring<SONARS>, robot: Pose, misaligned: &[Misalignment]) -> Vec<Sonar> {
    let radius = f64::from(ring.config().radius.get());
    let opening = f64::from(ring.config().opening_millidegrees) / 1000.0;
    let scale = f64::from(1_u32 << Direction::FRACTION_BITS);
    let sensors = ring.sensors();
    let sonars = sensors.map(|sensor| {
        let bearing = robot.heading.wrapping_add(ring.bearing(sensor)).direction();
        let (cos, sin) = (
            f64::from(bearing.cos()) / scale,
            f64::from(bearing.sin()) / scale,
        );
        let off = misaligned
            .iter()
            .filter(|wrong| wrong.slot == sensor.slot());
        let (off_sin, off_cos) = off.map(|wrong| wrong.radians).sum::<f64>().sin_cos();
        Sonar {
            at: (
                f64::from(robot.at.x_mm()) + radius * cos,
                f64::from(robot.at.y_mm()) + radius * sin,
            ),
            axis: (cos * off_cos - sin * off_sin, sin * off_cos + cos * off_sin),
            border: (opening / 2.0).to_radians().cos(),
        }
    });
    sonars.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::units::{BinaryAngle, Point};

    fn lengths(world: &str, misaligned: &[Misalignment]) -> [[Option<f64>; 7]; SONARS] {
        let world = World::parse(world.as_bytes(), "test.toml").unwrap();
        let robot = Pose::new(Point::ORIGIN, BinaryAngle::ZERO);
        Acoustics::new(&world).lengths(&PAPER_RING, robot, misaligned)
    }

    const WALL: &str = r#"
        [[box]]
        center = ["1350mm", "0mm"]
        size = ["100mm", "6m"]
    "#;

    #[test]
    fn a_wall_reflects_like_a_mirror() {
        let lengths = lengths(WALL, &[]);
        // 1.3 m from the centre, 1 m from sonar 1: twice that.
        assert!((lengths[0][3].unwrap() - 2000.0).abs() < 0.01);
        // Sonars 24 and 2, by the mirror image: 2·(1300 − 300·cos 15°) deep, 2·300·sin 15° aside.
        let turn = 15_f64.to_radians();
        let expected = (2.0 * (1300.0 - 300.0 * turn.cos())).hypot(600.0 * turn.sin());
        assert!((lengths[23][5].unwrap() - expected).abs() < 0.05);
        assert_eq!(lengths[23][5], lengths[1][1]);
        // Sonar 4 faces 45° aside.
        assert_eq!(lengths[3][3], None);
    }

    #[test]
    fn a_sonar_turned_away_from_a_wall_has_no_echo() {
        let radians = 40_f64.to_radians();
        let lengths = lengths(WALL, &[Misalignment { slot: 0, radians }]);
        assert_eq!(lengths[0], [None; 7]);
        assert!(lengths[1][3].is_some());
    }

    #[test]
    fn a_post_reflects_where_the_angles_are_equal() {
        let post = r#"
            [[disc]]
            center = ["1m", "0mm"]
            radius = "100mm"
        "#;
        let lengths = lengths(post, &[]);
        assert!((lengths[0][3].unwrap() - 1200.0).abs() < 0.01);
        // Sonars 24 and 2 are symmetric about the axis: the reflection is at the post's nearest point.
        let turn = 15_f64.to_radians();
        let one = (900.0 - 300.0 * turn.cos()).hypot(300.0 * turn.sin());
        assert!((lengths[23][5].unwrap() - 2.0 * one).abs() < 0.05);
    }

    #[test]
    fn a_post_in_front_of_a_wall_occludes_it() {
        let both = format!("{WALL}\n[[disc]]\ncenter = [\"800mm\", \"0mm\"]\nradius = \"50mm\"");
        let lengths = lengths(&both, &[]);
        assert!((lengths[0][3].unwrap() - 900.0).abs() < 0.01);
    }

    #[test]
    fn a_room_has_four_corners_and_a_box_in_it_none() {
        let room = br#"
            [[box]]
            center = ["0mm", "-1050mm"]
            size = ["2200mm", "100mm"]
            [[box]]
            center = ["0mm", "1050mm"]
            size = ["2200mm", "100mm"]
            [[box]]
            center = ["-1050mm", "0mm"]
            size = ["100mm", "2200mm"]
            [[box]]
            center = ["1050mm", "0mm"]
            size = ["100mm", "2200mm"]
            [[box]]
            center = ["0mm", "0mm"]
            size = ["300mm", "300mm"]
        "#;
        let surfaces = Surfaces::of(&World::parse(room, "room.toml").unwrap());
        assert_eq!(surfaces.faces.len(), 20);
        let mut corners = surfaces.corners;
        corners.sort_by(|a, b| a.partial_cmp(b).unwrap());
        let expected = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)];
        assert_eq!(corners.len(), 4, "{corners:?}");
        for (found, expected) in corners.iter().zip(expected) {
            assert!((found.0 - expected.0 * 1000.0).abs() < 1e-6);
            assert!((found.1 - expected.1 * 1000.0).abs() < 1e-6);
        }
    }

    #[test]
    fn the_front_of_a_face_is_outside_its_box() {
        let one = br#"
            [[box]]
            center = ["0mm", "0mm"]
            size = ["200mm", "100mm"]
            rotation = "30deg"
        "#;
        let world = World::parse(one, "box.toml").unwrap();
        for face in Surfaces::of(&world).faces {
            let middle = face.length / 2.0;
            assert!(!world.covers(face.off(middle, 1.0)));
            assert!(world.covers(face.off(middle, -1.0)));
            assert_eq!(face.local(face.off(middle, 7.0)).1.round(), 7.0);
        }
    }
}
