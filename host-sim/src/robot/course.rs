//! A course: from the origin, heading along +x, to a goal.

use crate::fusion::{FusionRules, HostMapper, Method};
use crate::world::{Bounds, Layout, LayoutError, World};
use certainty_core::fusion::Geometry;
use certainty_core::units::{Millimeters, Point, Pose};
use std::sync::Arc;

/// The built-in course: obstacles on the way, similar to \[004\] Fig. 6.
///
/// The paper gives no layout in numbers.
pub const BUILT_IN: &str = include_str!("../../data/course.toml");

/// A world with a start and a goal.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    /// The obstacles.
    pub world: Arc<World>,
    /// The pose at the start: the origin, heading along +x, unless set otherwise.
    pub start: Pose,
    /// The goal.
    pub goal: Point,
}

/// The goal of the built-in and of random courses: 10 m straight ahead.
pub const GOAL: Point = Point::from_mm(10_000, 0);

impl Course {
    /// Returns the built-in course.
    ///
    /// # Panics
    ///
    /// Only if the file, which is part of the program, is not a world, which a test excludes.
    #[must_use]
    pub fn built_in() -> Self {
        let world = World::parse(BUILT_IN.as_bytes(), "course.toml");
        Self::to(GOAL, world.expect("the built-in course is valid"))
    }

    /// Returns the course through `world` to `goal`.
    #[must_use]
    pub fn to(goal: Point, world: World) -> Self {
        Self {
            world: Arc::new(world),
            start: Pose::default(),
            goal,
        }
    }

    /// Returns a random course, determined by `seed`: six obstacles of 0.3 m to 0.9 m between start and
    /// goal, clear of both by 1.2 m.
    ///
    /// Some have no gap wide enough for the robot; the studies count them too.
    ///
    /// # Errors
    ///
    /// [`LayoutError`] if the obstacles do not fit; there is room for six.
    pub fn random(seed: u64) -> Result<Self, LayoutError> {
        let layout = Layout {
            area: Bounds {
                lower_left: Point::from_mm(1500, -2000),
                upper_right: Point::from_mm(8500, 2000),
            },
            boxes: 3,
            discs: 3,
            smallest: Millimeters::new(300),
            largest: Millimeters::new(900),
            sensors: vec![Point::ORIGIN, GOAL],
            keep_clear: Millimeters::new(1200),
        };
        Ok(Self::to(GOAL, World::random(&layout, seed)?))
    }

    /// Returns an empty map of the course and 2 m around it, in cells of 10 cm, as far as the robot can come.
    ///
    /// # Panics
    ///
    /// If `sensors` is 0.
    #[must_use]
    pub fn map(&self, method: Method, sensors: u8) -> HostMapper {
        const MARGIN: i32 = 2000;
        const CELL: i32 = 100;
        let ends = [self.start.at, self.goal];
        let around = self.world.bounds().into_iter();
        let corners = around.flat_map(|bounds| [bounds.lower_left, bounds.upper_right]);
        let points = || ends.into_iter().chain(corners.clone());
        // First cell and number of cells along an axis.
        let side = |along: fn(Point) -> i32| {
            let from = along(self.start.at);
            let within = |point| (along(point)).clamp(from - FARTHEST_MM, from + FARTHEST_MM);
            let low = points().map(within).min().unwrap_or(from) - MARGIN;
            let high = points().map(within).max().unwrap_or(from) + MARGIN;
            (low, ((high - low).div_euclid(CELL) + 1) as u16)
        };
        let ((x, width), (y, height)) = (side(Point::x_mm), side(Point::y_mm));
        let cell = Millimeters::new(CELL.unsigned_abs());
        let geometry = Geometry::try_new(width, height, cell, Point::from_mm(x, y));
        HostMapper::new(
            method,
            &FusionRules::default(),
            geometry.expect("at most 2121 cells a side"),
            sensors,
        )
    }
}

/// How far a robot can come and see that goes 1 m/s for [`LONGEST_MS`](super::drive::LONGEST_MS).
const FARTHEST_MM: i32 = 104_000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_course_blocks_the_straight_way_only() {
        let course = Course::built_in();
        let blocked = (0..10_000).any(|x| course.world.occupied(Point::from_mm(x, 0)));
        assert!(blocked);
        for end in [course.start.at, course.goal] {
            assert!(course.world.clearance(end).unwrap() > 1000.0);
        }
    }

    #[test]
    fn random_courses_are_clear_at_both_ends() {
        for seed in 0..100 {
            let course = Course::random(seed).unwrap();
            assert_eq!(course.world.obstacles().len(), 6);
            for end in [course.start.at, course.goal] {
                assert!(course.world.clearance(end).unwrap() >= 1200.0, "{seed}");
            }
        }
    }

    #[test]
    fn a_map_covers_what_can_be_reached() {
        let cells = |goal| {
            let course = Course::to(goal, World::new("open", Vec::new()));
            let geometry = course.map(Method::Robust, 7).geometry();
            assert_eq!(geometry.cell_size(), Millimeters::new(100));
            assert!(geometry.cell_at(course.start.at).is_some());
            geometry.cells()
        };
        // 10 m and twice 2 m; 104 m and as much.
        assert_eq!(cells(GOAL), 141 * 41);
        let far = Point::from_mm(Point::LIMIT, -Point::LIMIT);
        assert_eq!(cells(far), 1081 * 1081);
    }
}
