//! The motion of the robot: six wheels, three per side, one speed per side.

use crate::random::{Purpose, stream};
use crate::world::{Obstacle, World};
use certainty_control::Wheels;
use certainty_core::units::{BinaryAngle, Direction, Millimeters, Point, Pose};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Half of the robot's width, and the radius of its rounded ends, in millimetres.
pub const RADIUS_MM: f64 = 300.0;

/// Half of its length without the rounded ends, in millimetres: with them, the robot measures 0.9 m
/// by 0.6 m in all.
const SPINE_MM: i32 = 150;

/// The distance between the wheels of both sides, in millimetres.
const TRACK_MM: f64 = 500.0;

/// The factor by which the track acts wider in a turn, because wheels without steering slide sideways.
const SCRAPE: f64 = 1.6;

/// Time constant of the motors, in seconds.
const LAG_S: f64 = 0.08;

/// The highest acceleration of a side, in mm/s².
const STRONGEST_MM_S2: f64 = 8000.0;

/// Standard deviation of the slip of a side's wheels, as a part of their speed.
const SLIP: f64 = 0.04;

/// The body: its pose, the speeds of its wheels, its collisions.
///
/// Each side follows its command with a lag and a limit of acceleration; the speed over the ground differs by a
/// slip that changes every tenth of a second. A body that would touch an obstacle stays at its place, and
/// turns if it can do so on the spot; each touch counts once, until it is clear by 5 cm.
#[derive(Debug, Clone)]
pub struct Body {
    /// Millimetres.
    x: f64,
    y: f64,
    /// Turns, within 0..1.
    heading: f64,
    /// Speeds of the wheels, in mm/s.
    right: f64,
    left: f64,
    /// Over the ground, in mm/s.
    speed: f64,
    slip: (f64, f64),
    slip_left_ms: u32,
    rng: ChaCha8Rng,
    touching: bool,
    collisions: u32,
    least_clearance: f64,
}

impl Body {
    /// Creates a body that stands at `pose`, with slip determined by `seed`.
    #[must_use]
    pub fn new(pose: Pose, seed: u64) -> Self {
        Self {
            x: f64::from(pose.at.x_mm()),
            y: f64::from(pose.at.y_mm()),
            heading: f64::from(pose.heading.to_bits()) / 65536.0,
            right: 0.0,
            left: 0.0,
            speed: 0.0,
            slip: (0.0, 0.0),
            slip_left_ms: 0,
            rng: stream(seed, Purpose::Slip, 0, 0),
            touching: false,
            collisions: 0,
            least_clearance: f64::INFINITY,
        }
    }

    /// Returns its pose.
    #[must_use]
    pub fn pose(&self) -> Pose {
        let at = Point::from_mm(self.x.floor() as i32, self.y.floor() as i32);
        Pose::new(at, self.bearing())
    }

    /// Returns the speeds of the right and the left wheels, in mm/s.
    #[must_use]
    pub const fn wheels_mm_s(&self) -> (f64, f64) {
        (self.right, self.left)
    }

    /// Returns its speed over the ground, in mm/s.
    #[must_use]
    pub const fn speed_mm_s(&self) -> f64 {
        self.speed
    }

    /// Returns how many times it touched an obstacle.
    #[must_use]
    pub const fn collisions(&self) -> u32 {
        self.collisions
    }

    /// Returns the least clearance until now, in millimetres: infinite on an open plane, 0 after a
    /// collision.
    #[must_use]
    pub const fn least_clearance_mm(&self) -> f64 {
        self.least_clearance
    }

    /// Returns the first obstacle of `world` that it overlaps.
    #[must_use]
    pub fn touched<'w>(&self, world: &'w World) -> Option<&'w Obstacle> {
        let overlaps =
            |obstacle: &&Obstacle| self.clearance(|at| Some(obstacle.clearance(at))) <= 0.0;
        world.obstacles().iter().find(overlaps)
    }

    /// Moves for `ms` milliseconds with `wheels` as parts of `full_speed_mm_s`.
    pub fn drive(&mut self, world: &World, wheels: Wheels, full_speed_mm_s: f64, ms: u32) {
        /// Milliseconds of one step of the motion: a centimetre at full speed.
        const STEP_MS: u32 = 10;
        let full = full_speed_mm_s;
        let wanted = (
            wheels.right.to_num::<f64>() * full,
            wheels.left.to_num::<f64>() * full,
        );
        for _ in 0..ms.div_ceil(STEP_MS) {
            self.renew_slip(STEP_MS);
            let seconds = f64::from(STEP_MS) / 1000.0;
            self.right = followed(self.right, wanted.0, seconds);
            self.left = followed(self.left, wanted.1, seconds);
            let (right, left) = (
                self.right * (1.0 - self.slip.0),
                self.left * (1.0 - self.slip.1),
            );
            self.step(world, f64::midpoint(right, left), right - left, seconds);
        }
    }

    fn renew_slip(&mut self, ms: u32) {
        if self.slip_left_ms == 0 {
            let mut draw = || -> f64 {
                let normal: f64 = StandardNormal.sample(&mut self.rng);
                (normal * SLIP).clamp(-3.0 * SLIP, 3.0 * SLIP)
            };
            // Both ways: on a slope a wheel slips forwards as well as backwards.
            self.slip = (draw(), draw());
            self.slip_left_ms = 100;
        }
        self.slip_left_ms = self.slip_left_ms.saturating_sub(ms);
    }

    /// One step over the ground, unless an obstacle is in the way.
    fn step(&mut self, world: &World, ahead: f64, difference: f64, seconds: f64) {
        let before = (self.x, self.y, self.heading);
        let scale = f64::from(1_u32 << Direction::FRACTION_BITS);
        let direction = self.bearing().direction();
        let gone = ahead * seconds;
        self.x += gone * f64::from(direction.cos()) / scale;
        self.y += gone * f64::from(direction.sin()) / scale;
        let turned = difference * seconds / (TRACK_MM * SCRAPE * core::f64::consts::TAU);
        self.heading = (self.heading + turned).rem_euclid(1.0);
        self.speed = ahead.abs();
        let clearance = self.clearance(|at| world.clearance(at));
        if clearance <= 0.0 {
            if !self.touching {
                self.touching = true;
                self.collisions += 1;
            }
            (self.x, self.y, _) = before;
            if self.clearance(|at| world.clearance(at)) <= 0.0 {
                self.heading = before.2;
            }
            self.speed = 0.0;
            self.least_clearance = 0.0;
        } else {
            self.least_clearance = self.least_clearance.min(clearance);
            if clearance > 50.0 {
                self.touching = false;
            }
        }
    }

    /// The distance from the outline to obstacles of which `clearance` is the distance from a place, in
    /// millimetres; below 0 within one, infinite on an open plane.
    ///
    /// Computed from five places along the spine: too large by less than 3 mm.
    fn clearance(&self, clearance: impl Fn(Point) -> Option<f64>) -> f64 {
        let pose = self.pose();
        let places = (-2..=2).map(|place| {
            let along = Pose::new(Point::from_mm(SPINE_MM * place / 2, 0), BinaryAngle::ZERO);
            let away = clearance(pose.compose(along).at);
            away.map_or(f64::INFINITY, |away| away - RADIUS_MM)
        });
        places.fold(f64::INFINITY, f64::min)
    }

    fn bearing(&self) -> BinaryAngle {
        // A whole turn wraps to 0.
        BinaryAngle::from_bits((self.heading * 65536.0).round() as u32 as u16)
    }
}

/// Returns the largest distance of the outline from the middle.
#[must_use]
pub const fn reach() -> Millimeters {
    Millimeters::new(RADIUS_MM as u32 + SPINE_MM.unsigned_abs())
}

/// The speed of a side after `seconds`.
fn followed(speed: f64, wanted: f64, seconds: f64) -> f64 {
    let change = (wanted - speed) * (seconds / (LAG_S + seconds));
    let most = STRONGEST_MM_S2 * seconds;
    speed + change.clamp(-most, most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity;
    use certainty_control::Effort;

    fn wheels(right: f64, left: f64) -> Wheels {
        Wheels {
            right: Effort::from_num(right),
            left: Effort::from_num(left),
        }
    }

    fn open() -> World {
        World::new("open", Vec::new())
    }

    #[test]
    fn full_speed_is_a_metre_a_second_within_the_slip() {
        let mut body = Body::new(Pose::default(), 1);
        body.drive(&open(), wheels(1.0, 1.0), 1000.0, 10_000);
        let gone = body.pose().at.distance(Point::ORIGIN).get();
        // 10 s less the motors' lag of a tenth of a second or two.
        assert!((9500..=10_100).contains(&gone), "{gone}");
        assert!((body.wheels_mm_s().0 - 1000.0).abs() < 1.0);
    }

    #[test]
    fn opposite_wheels_turn_it_on_the_spot() {
        let mut body = Body::new(Pose::default(), 1);
        body.drive(&open(), wheels(0.5, -0.5), 1000.0, 1000);
        // 1000 mm/s over a track that acts 800 mm wide: 1.25 rad/s, less the lag.
        let turned = quantity::degrees(body.pose().heading);
        assert!((60.0..=75.0).contains(&turned), "{turned}");
        assert!(body.pose().at.distance(Point::ORIGIN).get() < 50);
    }

    #[test]
    fn it_stops_at_a_wall_and_counts_one_collision() {
        let wall = Obstacle::wall(
            Point::from_mm(1500, -2000),
            Point::from_mm(1500, 2000),
            Millimeters::new(100),
        );
        let world = World::new("wall", vec![wall.unwrap()]);
        let mut body = Body::new(Pose::default(), 1);
        body.drive(&world, wheels(1.0, 1.0), 1000.0, 5000);
        // 1450 is the wall's face, 450 the robot's front.
        let x = body.pose().at.x_mm();
        assert!((985..=1000).contains(&x), "{x}");
        assert_eq!(body.collisions(), 1);
        assert_eq!(body.least_clearance_mm(), 0.0);
        // Backing away frees it; the next touch is another.
        body.drive(&world, wheels(-1.0, -1.0), 1000.0, 1500);
        body.drive(&world, wheels(1.0, 1.0), 1000.0, 4000);
        assert_eq!(body.collisions(), 2);
    }

    #[test]
    fn the_seed_determines_the_slip() {
        let run = |seed| {
            let mut body = Body::new(Pose::default(), seed);
            body.drive(&open(), wheels(1.0, 0.9), 1000.0, 3000);
            body.pose()
        };
        assert_eq!(run(1), run(1));
        assert_ne!(run(1), run(2));
    }
}
