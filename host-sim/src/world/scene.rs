//! Obstacles on a plane, and the distance at which a ray meets one.

use super::obstacle::{Bounds, Obstacle, Vector};
use certainty_core::units::{BinaryAngle, Millimeters, Point};

/// Obstacles on a plane.
#[derive(Debug, Clone, PartialEq)]
pub struct World {
    name: String,
    obstacles: Vec<Obstacle>,
}

impl World {
    /// Creates a world called `name` with these obstacles, which may overlap.
    ///
    /// A world without obstacles is an open plane, on which no ray ends.
    #[must_use]
    pub fn new(name: impl Into<String>, obstacles: Vec<Obstacle>) -> Self {
        Self {
            name: name.into(),
            obstacles,
        }
    }

    /// Returns the name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the obstacles, in the order they were given.
    #[must_use]
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }

    /// Returns the distance from `origin` along `bearing` to the first obstacle.
    ///
    /// Units: millimetres, exact to about 10⁻⁸ of the distance. 0 where the ray starts inside an
    /// obstacle; `None` where it meets nothing up to and including `within`.
    ///
    /// ```
    /// use certainty_core::units::{BinaryAngle, Millimeters, Point};
    /// use certainty_sim::world::{Obstacle, World};
    ///
    /// let mm = Millimeters::new;
    /// let disc = Obstacle::disc(Point::from_mm(0, 500), mm(100))?;
    /// let world = World::new("a disc ahead", vec![disc]);
    /// let ahead = world.distance(Point::ORIGIN, BinaryAngle::QUARTER, mm(800));
    /// assert!((ahead.unwrap() - 399.5).abs() < 0.01); // from the centre of the first millimetre
    /// assert_eq!(world.distance(Point::ORIGIN, BinaryAngle::ZERO, mm(800)), None);
    /// # Ok::<(), certainty_sim::world::ObstacleError>(())
    /// ```
    #[must_use]
    pub fn distance(
        &self,
        origin: Point,
        bearing: BinaryAngle,
        within: Millimeters,
    ) -> Option<f64> {
        let (from, along) = (Vector::centre_of(origin), Vector::along(bearing));
        let nearest = self
            .obstacles
            .iter()
            .filter_map(|obstacle| obstacle.entered_by(from, along))
            .min_by(f64::total_cmp)?;
        (nearest <= f64::from(within.get())).then_some(nearest)
    }

    /// Returns whether the straight line from one point to another is free; its last half millimetre may
    /// touch an obstacle.
    ///
    /// Units: millimetres, in the frame of the coordinates.
    #[must_use]
    pub fn free_between(&self, from: (f64, f64), to: (f64, f64)) -> bool {
        let start = Vector {
            x: from.0,
            y: from.1,
        };
        let way = Vector { x: to.0, y: to.1 }.minus(start);
        let length = way.length();
        if length == 0.0 {
            return true;
        }
        let along = Vector {
            x: way.x / length,
            y: way.y / length,
        };
        let entered = self
            .obstacles
            .iter()
            .filter_map(|obstacle| obstacle.entered_by(start, along));
        entered
            .min_by(f64::total_cmp)
            .is_none_or(|first| first >= length - 0.5)
    }

    /// Returns whether an obstacle covers the point `at`, in millimetres in the frame of the coordinates.
    #[must_use]
    pub fn covers(&self, at: (f64, f64)) -> bool {
        let at = Vector { x: at.0, y: at.1 };
        self.obstacles.iter().any(|obstacle| obstacle.covers(at))
    }

    /// Returns the distance from the square millimetre `at` to the nearest obstacle; `None` on an open
    /// plane.
    #[must_use]
    pub fn clearance(&self, at: Point) -> Option<f64> {
        let obstacles = self.obstacles.iter();
        let clearances = obstacles.map(|obstacle| obstacle.clearance(at));
        clearances.min_by(f64::total_cmp)
    }

    /// Returns whether an obstacle covers the centre of the square millimetre `at`.
    #[must_use]
    pub fn occupied(&self, at: Point) -> bool {
        let at = Vector::centre_of(at);
        self.obstacles.iter().any(|obstacle| obstacle.covers(at))
    }

    /// Returns the smallest upright rectangle around every obstacle; `None` on an open plane.
    ///
    /// Rounds outwards to whole millimetres.
    #[must_use]
    pub fn bounds(&self) -> Option<Bounds> {
        self.obstacles
            .iter()
            .map(Obstacle::bounds)
            .reduce(|a, b| Bounds {
                lower_left: Point::from_mm(
                    a.lower_left.x_mm().min(b.lower_left.x_mm()),
                    a.lower_left.y_mm().min(b.lower_left.y_mm()),
                ),
                upper_right: Point::from_mm(
                    a.upper_right.x_mm().max(b.upper_right.x_mm()),
                    a.upper_right.y_mm().max(b.upper_right.y_mm()),
                ),
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn mm(mm: u32) -> Millimeters {
        Millimeters::new(mm)
    }

    const fn degrees(degrees: i32) -> BinaryAngle {
        BinaryAngle::from_millidegrees(degrees * 1000)
    }

    const FAR: Millimeters = mm(10_000);

    fn only(obstacle: Obstacle) -> World {
        World::new("one", vec![obstacle])
    }

    fn near(actual: Option<f64>, expected: f64) -> bool {
        actual.is_some_and(|mm| (mm - expected).abs() < 1e-3)
    }

    #[test]
    fn a_ray_ends_at_the_near_side_of_a_box() {
        let world = only(
            Obstacle::rectangle(Point::from_mm(0, 500), (mm(200), mm(100)), degrees(0)).unwrap(),
        );
        assert_eq!(
            world.distance(Point::ORIGIN, degrees(90), FAR),
            Some(450.0 - 0.5)
        );
        assert_eq!(world.distance(Point::ORIGIN, degrees(-90), FAR), None);
        assert_eq!(world.distance(Point::ORIGIN, degrees(0), FAR), None);
        // From the side, along a line through it.
        assert_eq!(
            world.distance(Point::from_mm(-1000, 500), degrees(0), FAR),
            Some(900.0 - 0.5)
        );
        // A hair beside it: the ray runs along x = 100.5.
        assert_eq!(
            world.distance(Point::from_mm(100, 0), degrees(90), FAR),
            None
        );
        assert_eq!(
            world.distance(Point::from_mm(99, 0), degrees(90), FAR),
            Some(449.5)
        );
    }

    #[test]
    fn a_ray_ends_at_the_corner_of_a_turned_box() {
        // A square of side 200 on its corner reaches 100·√2 towards the ray.
        let world = only(
            Obstacle::rectangle(Point::from_mm(0, 500), (mm(200), mm(200)), degrees(45)).unwrap(),
        );
        let from = Point::from_mm(0, 0);
        let met = world.distance(from, degrees(90), FAR);
        // The ray runs half a millimetre beside the corner, where the side is half a millimetre up.
        assert!(near(met, 500.0 - 100.0 * 2.0_f64.sqrt()), "{met:?}");
    }

    #[test]
    fn a_ray_ends_on_the_circle_of_a_disc() {
        let world = only(Obstacle::disc(Point::from_mm(300, 400), mm(50)).unwrap());
        let towards = BinaryAngle::from_millidegrees(53_130); // 3-4-5
        let met = world.distance(Point::ORIGIN, towards, FAR).unwrap();
        let expected = (299.5_f64.powi(2) + 399.5_f64.powi(2)).sqrt() - 50.0;
        assert!((met - expected).abs() < 0.01, "{met} vs {expected}");
        assert_eq!(
            world.distance(Point::ORIGIN, towards.wrapping_add(BinaryAngle::HALF), FAR),
            None
        );
    }

    #[test]
    fn a_wall_has_its_thickness() {
        let world = only(
            Obstacle::wall(Point::from_mm(-500, 600), Point::from_mm(500, 600), mm(20)).unwrap(),
        );
        assert_eq!(world.distance(Point::ORIGIN, degrees(90), FAR), Some(589.5));
        assert!(world.occupied(Point::from_mm(0, 590)) && world.occupied(Point::from_mm(0, 609)));
        assert!(!world.occupied(Point::from_mm(0, 589)) && !world.occupied(Point::from_mm(0, 610)));
        assert!(
            !world.occupied(Point::from_mm(500, 600)) && world.occupied(Point::from_mm(499, 600))
        );
    }

    #[test]
    fn a_box_covers_the_millimetres_between_its_sides() {
        let world = only(
            Obstacle::rectangle(Point::from_mm(300, 500), (mm(200), mm(100)), degrees(0)).unwrap(),
        );
        let covered = (0..1000)
            .filter(|&x| world.occupied(Point::from_mm(x, 500)))
            .collect::<Vec<_>>();
        assert_eq!(covered, (200..400).collect::<Vec<_>>());
    }

    #[test]
    fn a_ray_from_inside_has_length_zero() {
        let rectangle = Obstacle::rectangle(Point::ORIGIN, (mm(100), mm(50)), degrees(30)).unwrap();
        let disc = Obstacle::disc(Point::ORIGIN, mm(40)).unwrap();
        for obstacle in [rectangle, disc] {
            for bearing in (0..360).step_by(7) {
                let met = only(obstacle).distance(Point::ORIGIN, degrees(bearing), FAR);
                assert_eq!(met, Some(0.0), "{obstacle:?} at {bearing}");
            }
        }
    }

    #[test]
    fn an_obstacle_beyond_the_range_is_not_met() {
        let world = only(Obstacle::disc(Point::from_mm(0, 1000), mm(100)).unwrap());
        assert!(
            world
                .distance(Point::ORIGIN, degrees(90), mm(899))
                .is_none()
        );
        assert!(
            world
                .distance(Point::ORIGIN, degrees(90), mm(900))
                .is_some()
        );
    }

    #[test]
    fn the_nearest_obstacle_ends_the_ray() {
        let far = Obstacle::disc(Point::from_mm(0, 1000), mm(100)).unwrap();
        let close = Obstacle::disc(Point::from_mm(0, 500), mm(100)).unwrap();
        for order in [vec![far, close], vec![close, far]] {
            let met = World::new("two", order).distance(Point::ORIGIN, degrees(90), FAR);
            assert!(met.unwrap() < 401.0);
        }
    }

    #[test]
    fn bounds_enclose_all_obstacles() {
        let world = World::new(
            "two",
            vec![
                Obstacle::rectangle(Point::from_mm(0, 0), (mm(200), mm(200)), degrees(45)).unwrap(),
                Obstacle::disc(Point::from_mm(1000, -50), mm(10)).unwrap(),
            ],
        );
        assert_eq!(
            world.bounds(),
            Some(Bounds {
                lower_left: Point::from_mm(-142, -142),
                upper_right: Point::from_mm(1010, 142),
            })
        );
        assert_eq!(World::new("open", vec![]).bounds(), None);
    }
}
