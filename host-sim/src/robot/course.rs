//! Where the robot drives: from the origin, looking along +x, to a goal.

use crate::fusion::{FusionRules, HostMapper, Method};
use crate::world::{Bounds, Layout, LayoutError, World};
use certainty_core::fusion::Geometry;
use certainty_core::units::{Millimeters, Point, Pose};
use std::sync::Arc;

/// The built-in course: obstacles on the way, in the manner of \[004\] Fig. 6.
///
/// The paper gives no layout in numbers.
pub const BUILT_IN: &str = include_str!("../../data/course.toml");

/// A world and where to go in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    /// The obstacles.
    pub world: Arc<World>,
    /// Where the robot starts; the origin, looking along +x, unless said otherwise.
    pub start: Pose,
    /// Where it shall be.
    pub goal: Point,
}

/// How far the goal of the built-in and of random courses is: straight ahead.
pub const GOAL: Point = Point::from_mm(10_000, 0);

impl Course {
    /// Returns the built-in course.
    ///
    /// # Panics
    ///
    /// Never: a test proves that the file, which is part of the program, is a world.
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

    /// Returns the random course that `seed` names: six obstacles of 0.3 m to 0.9 m between start and
    /// goal, clear of both by 1.2 m.
    ///
    /// Some have no way through that the robot is narrow enough for; that is part of the figures.
    ///
    /// # Errors
    ///
    /// [`LayoutError`], never in practice: there is room for six.
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

    /// Returns an empty map of the course and 2 m around it, in cells of 10 cm, or larger ones where the
    /// world is too large for that.
    ///
    /// # Panics
    ///
    /// For no sensors; never for a size.
    #[must_use]
    pub fn map(&self, method: Method, sensors: u8) -> HostMapper {
        const MARGIN: i32 = 2000;
        /// 1000 cells a side.
        const MOST: i32 = 1000;
        let ends = [self.start.at, self.goal];
        let around = self.world.bounds().into_iter();
        let corners = around.flat_map(|bounds| [bounds.lower_left, bounds.upper_right]);
        let (mut low, mut high) = (ends[0], ends[0]);
        for point in ends.into_iter().chain(corners) {
            low = Point::from_mm(low.x_mm().min(point.x_mm()), low.y_mm().min(point.y_mm()));
            high = Point::from_mm(high.x_mm().max(point.x_mm()), high.y_mm().max(point.y_mm()));
        }
        // A world kilometres away is no part of the way.
        let bounded = |mm: i32| mm.clamp(-100_000_000, 100_000_000);
        let corner = Point::from_mm(bounded(low.x_mm()) - MARGIN, bounded(low.y_mm()) - MARGIN);
        let side = |low: i32, high: i32| bounded(high) - bounded(low) + 2 * MARGIN;
        let (width, height) = (side(low.x_mm(), high.x_mm()), side(low.y_mm(), high.y_mm()));
        let cell = 100.max(width.max(height).div_euclid(MOST) + 1);
        let cells = |side: i32| (side.div_euclid(cell) + 1) as u16;
        let geometry = Geometry::try_new(
            cells(width),
            cells(height),
            Millimeters::new(cell.unsigned_abs()),
            corner,
        );
        HostMapper::new(
            method,
            &FusionRules::default(),
            geometry.expect("at most 1001 cells a side, within 200 km"),
            sensors,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_course_blocks_the_straight_way_and_leaves_start_and_goal_clear() {
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
    fn the_map_of_a_huge_world_is_no_larger_than_others() {
        let far = Point::from_mm(Point::LIMIT, -Point::LIMIT);
        let course = Course::to(far, World::new("open", Vec::new()));
        let map = course.map(Method::Robust, 7);
        assert!(map.geometry().cells() <= 1_002_001);
    }
}
