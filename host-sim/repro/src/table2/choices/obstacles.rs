//! What stands around the car.

use super::{Choices, Open};
use certainty_core::units::{Millimeters, Point};
use certainty_sim::world::Layout;

/// How the obstacle layouts are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Obstacles {
    /// Four boxes and three discs of 60 to 300 mm.
    Scattered,
    /// Four boxes of 300 to 600 mm, which hide much of the grid.
    Large,
    /// One box of 200 to 400 mm.
    Sparse,
}

impl Obstacles {
    /// Returns the rules that worlds are drawn by.
    ///
    /// All keep clear of the middle and the ends of the bumper, however the sensors are mounted, so that
    /// every mounting sees the same worlds.
    #[must_use]
    pub fn layout(self) -> Layout {
        let clear = Layout {
            sensors: [-80, 0, 80].map(|x| Point::from_mm(x, 0)).into(),
            ..Layout::default()
        };
        let boxes = |boxes, smallest, largest| Layout {
            boxes,
            discs: 0,
            smallest: Millimeters::new(smallest),
            largest: Millimeters::new(largest),
            ..clear.clone()
        };
        match self {
            Self::Scattered => clear,
            Self::Large => boxes(4, 300, 600),
            Self::Sparse => boxes(1, 200, 400),
        }
    }
}

impl Open for Obstacles {
    const NAME: &'static str = "obstacles";
    const ALL: &'static [Self] = &[Self::Scattered, Self::Large, Self::Sparse];

    fn name(self) -> &'static str {
        match self {
            Self::Scattered => "scattered",
            Self::Large => "large",
            Self::Sparse => "sparse",
        }
    }

    fn reason(self) -> &'static str {
        match self {
            Self::Scattered => {
                "\"different obstacle configurations\": several, as in the built-in scene"
            }
            Self::Large => "the text gives no size: walls and furniture",
            Self::Sparse => "Fig. 1(a) draws a single obstacle, about four cells wide",
        }
    }

    fn of(choices: &mut Choices) -> &mut Self {
        &mut choices.obstacles
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::units::BinaryAngle;
    use certainty_sim::world::World;

    /// How many of many looks into ten worlds end at an obstacle.
    fn hits(obstacles: Obstacles) -> usize {
        let worlds = (0..10).map(|seed| World::random(&obstacles.layout(), seed).unwrap());
        let looks = (0..32).map(|n| BinaryAngle::from_bits(n * 1024));
        let ends = |world: &World, bearing| {
            world
                .distance(Point::ORIGIN, bearing, Millimeters::new(800))
                .is_some()
        };
        worlds
            .map(|world| {
                looks
                    .clone()
                    .filter(|&bearing| ends(&world, bearing))
                    .count()
            })
            .sum()
    }

    #[test]
    fn large_obstacles_end_more_looks_and_a_single_one_fewer() {
        assert!(hits(Obstacles::Large) > hits(Obstacles::Scattered));
        assert!(hits(Obstacles::Scattered) > hits(Obstacles::Sparse));
    }
}
