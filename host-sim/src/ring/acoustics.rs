//! What a ring's sonars hear in a world: mirrors, right angles and round things, in closed form.

use super::SONARS;
use super::surfaces::{Place, Surfaces};
use crate::world::World;
use certainty_core::units::{Direction, Pose};
use certainty_ring::{NEIGHBOURS, Ring};

/// Sound in a world.
///
/// Flat faces reflect as mirrors do; a concave right angle sends sound back over both its faces; round
/// things reflect where the angles are equal; convex edges scatter and are not heard (\[003\] §4 found
/// as much). An echo must lie in the cones of both sonars, and nothing may stand in its way.
#[derive(Debug, Clone)]
pub struct Acoustics<'a> {
    world: &'a World,
    surfaces: Surfaces,
}

/// A sonar that does not look where it should: which, counted from 0, and by how many radians it is
/// turned counter-clockwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turned {
    /// Its place in the ring.
    pub slot: usize,
    /// By how much.
    pub radians: f64,
}

/// A sonar in the world.
#[derive(Debug, Clone, Copy)]
struct Sonar {
    at: Place,
    axis: Place,
    /// Cosine of half the opening.
    border: f64,
}

impl Sonar {
    fn sees(&self, place: Place) -> bool {
        let (x, y) = (place.0 - self.at.0, place.1 - self.at.1);
        x * self.axis.0 + y * self.axis.1 >= x.hypot(y) * self.border
    }
}

fn apart(a: Place, b: Place) -> f64 {
    (a.0 - b.0).hypot(a.1 - b.1)
}

impl<'a> Acoustics<'a> {
    /// Prepares a world for many echoes.
    #[must_use]
    pub fn new(world: &'a World) -> Self {
        Self {
            world,
            surfaces: Surfaces::of(world),
        }
    }

    /// Returns how long the way of each echo is, in millimetres: `[transmitter][offset + 3]`.
    ///
    /// `None` where nothing is heard within the ring's range.
    #[must_use]
    pub fn lengths(
        &self,
        ring: &Ring<SONARS>,
        robot: Pose,
        turned: &[Turned],
    ) -> [[Option<f64>; 2 * NEIGHBOURS as usize + 1]; SONARS] {
        let sonars = sonars(ring, robot, turned);
        let farthest = 2.0 * f64::from(ring.config().range.get());
        let mut lengths = [[None; 2 * NEIGHBOURS as usize + 1]; SONARS];
        for (slot, sonar) in sonars.iter().enumerate() {
            for order in 0..=usize::from(NEIGHBOURS) {
                let other = (slot + order) % SONARS;
                let length = self.length(sonar, &sonars[other]);
                let length = length.filter(|&length| length <= farthest);
                // The way back is the way there.
                lengths[slot][usize::from(NEIGHBOURS) + order] = length;
                lengths[other][usize::from(NEIGHBOURS) - order] = length;
            }
        }
        lengths
    }

    /// The shortest echo from one sonar to another.
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
            // Two mirrors at a right angle turn the image about the corner by half a turn.
            let image = (2.0 * x - to.at.0, 2.0 * y - to.at.1);
            (apart(from.at, image), (x, y))
        });
        let round = self.surfaces.discs.iter().map(|&(centre, radius)| {
            let place = on_disc(centre, radius, from.at, to.at);
            (apart(from.at, place) + apart(place, to.at), place)
        });
        let heard = flat.chain(corners).chain(round).filter(|&(_, place)| {
            let clear =
                |sonar: &Sonar| sonar.sees(place) && self.world.free_between(sonar.at, place);
            clear(from) && clear(to)
        });
        heard.map(|(length, _)| length).min_by(f64::total_cmp)
    }
}

/// Where on a disc the way from one place to another over it is shortest.
fn on_disc(centre: Place, radius: f64, from: Place, to: Place) -> Place {
    let angle = |place: Place| (place.1 - centre.1).atan2(place.0 - centre.0);
    let at = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        (centre.0 + radius * cos, centre.1 + radius * sin)
    };
    let way = |angle: f64| apart(from, at(angle)) + apart(at(angle), to);
    let first = angle(from);
    let turn = core::f64::consts::TAU;
    let between = (angle(to) - first + turn / 2.0).rem_euclid(turn) - turn / 2.0;
    // On the side that both see, the way is a single valley.
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

/// The ring's sonars in the world, in floating point from the same angles and radius.
fn sonars(ring: &Ring<SONARS>, robot: Pose, turned: &[Turned]) -> Vec<Sonar> {
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
        let off = turned.iter().filter(|turned| turned.slot == sensor.slot());
        let (off_sin, off_cos) = off.map(|turned| turned.radians).sum::<f64>().sin_cos();
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
    use crate::ring::paper_ring;
    use certainty_core::units::{BinaryAngle, Point};

    fn heard(world: &str, turned: &[Turned]) -> [[Option<f64>; 7]; SONARS] {
        let world = World::parse(world.as_bytes(), "test.toml").unwrap();
        let robot = Pose::new(Point::ORIGIN, BinaryAngle::ZERO);
        Acoustics::new(&world).lengths(&paper_ring(), robot, turned)
    }

    const WALL: &str = r#"
        [[box]]
        center = ["1350mm", "0mm"]
        size = ["100mm", "6m"]
    "#;

    #[test]
    fn a_wall_is_a_mirror() {
        let lengths = heard(WALL, &[]);
        // 1.3 m from the middle, 1 m from sonar 1: twice that.
        assert!((lengths[0][3].unwrap() - 2000.0).abs() < 0.01);
        // Sonars 24 and 2 see each other's image: 2·(1300 − 300·cos 15°) deep, 2·300·sin 15° aside.
        let turn = 15_f64.to_radians();
        let expected = (2.0 * (1300.0 - 300.0 * turn.cos())).hypot(600.0 * turn.sin());
        assert!((lengths[23][5].unwrap() - expected).abs() < 0.05);
        assert_eq!(lengths[23][5], lengths[1][1]);
        // Sonar 4 looks 45° aside.
        assert_eq!(lengths[3][3], None);
    }

    #[test]
    fn a_sonar_that_is_turned_away_hears_nothing_of_it() {
        let radians = 40_f64.to_radians();
        let lengths = heard(WALL, &[Turned { slot: 0, radians }]);
        assert_eq!(lengths[0], [None; 7]);
        assert!(lengths[1][3].is_some());
    }

    #[test]
    fn a_post_is_heard_where_the_angles_are_equal() {
        let post = r#"
            [[disc]]
            center = ["1m", "0mm"]
            radius = "100mm"
        "#;
        let lengths = heard(post, &[]);
        assert!((lengths[0][3].unwrap() - 1200.0).abs() < 0.01);
        // Between sonars 24 and 2, alike about the axis, the place is the post's nearest.
        let turn = 15_f64.to_radians();
        let one = (900.0 - 300.0 * turn.cos()).hypot(300.0 * turn.sin());
        assert!((lengths[23][5].unwrap() - 2.0 * one).abs() < 0.05);
    }

    #[test]
    fn a_post_in_front_of_a_wall_hides_it() {
        let both = format!("{WALL}\n[[disc]]\ncenter = [\"800mm\", \"0mm\"]\nradius = \"50mm\"");
        let lengths = heard(&both, &[]);
        assert!((lengths[0][3].unwrap() - 900.0).abs() < 0.01);
    }
}
