//! The surfaces of a world's obstacles: flat faces, round ones, and the corners between faces.

use crate::world::{Shape, World};

/// A place or displacement in millimetres.
pub type Place = (f64, f64);

/// A flat face of an obstacle; what is in front of it is to its right, going from `from` to `to`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Face {
    /// Where it begins.
    pub from: Place,
    /// Where it ends.
    pub to: Place,
    /// Unit vector along the face.
    pub along: Place,
    /// From end to end, in millimetres.
    pub length: f64,
}

impl Face {
    fn new(from: Place, to: Place) -> Self {
        let (x, y) = (to.0 - from.0, to.1 - from.1);
        let length = x.hypot(y);
        Self {
            from,
            to,
            along: (x / length, y / length),
            length,
        }
    }

    /// How far along the face `place` is, and how far in front of it.
    #[must_use]
    pub fn local(&self, place: Place) -> (f64, f64) {
        let (x, y) = (place.0 - self.from.0, place.1 - self.from.1);
        let (ax, ay) = self.along;
        (x * ax + y * ay, x * ay - y * ax)
    }

    /// The place so far along the face.
    #[must_use]
    pub fn at(&self, along: f64) -> Place {
        let (ax, ay) = self.along;
        (self.from.0 + ax * along, self.from.1 + ay * along)
    }

    /// A place `along` the face and `before` it.
    fn off(&self, along: f64, before: f64) -> Place {
        let (x, y) = self.at(along);
        let (ax, ay) = self.along;
        (x + ay * before, y - ax * before)
    }
}

/// What sends sound and light back.
#[derive(Debug, Clone, PartialEq)]
pub struct Surfaces {
    /// Flat faces.
    pub faces: Vec<Face>,
    /// Centre and radius.
    pub discs: Vec<(Place, f64)>,
    /// Where two faces meet in the open at a right angle, to within 5°: concave.
    pub corners: Vec<Place>,
}

impl Surfaces {
    /// Returns the surfaces of `world`.
    #[must_use]
    pub fn of(world: &World) -> Self {
        let (mut faces, mut discs) = (Vec::new(), Vec::new());
        for obstacle in world.obstacles() {
            match obstacle.shape() {
                Shape::Box(corners) => {
                    // Counter-clockwise, so that what is inside is to the left.
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
fn corners(world: &World, faces: &[Face]) -> Vec<Place> {
    /// How far around a corner one looks, in millimetres.
    const LOOK: f64 = 5.0;
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
            let place = one.at(along);
            let (beside, _) = other.local(place);
            let on = |at: f64, length: f64| (-0.5..=length + 0.5).contains(&at);
            if !on(along, one.length) || !on(beside, other.length) {
                continue;
            }
            // Free in front of both, and behind each nothing but the other's obstacle.
            let front = |one: f64, other_front: f64| {
                let (x, y) = (place.0, place.1);
                let normal = |face: &Face, by: f64| {
                    let (nx, ny) = face.off(0.0, by);
                    (nx - face.from.0, ny - face.from.1)
                };
                let (ox, oy) = normal(other, other_front);
                let (sx, sy) = normal(&faces[number], one);
                (x + ox + sx, y + oy + sy)
            };
            let open = !world.covers(front(LOOK, LOOK));
            if open && world.covers(front(LOOK, -LOOK)) && world.covers(front(-LOOK, LOOK)) {
                found.push(place);
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_room_of_walls_has_four_corners_and_a_box_in_it_has_none() {
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
