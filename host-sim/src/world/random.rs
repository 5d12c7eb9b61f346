//! Random worlds, for evaluations over many scenes.
//!
//! The papers give no obstacle layouts (\[001\] §6.2 says "different obstacle configurations"), so
//! every number here is an open choice: the defaults fill the Smart Car's grid about as densely as
//! the built-in scene. The same layout and seed always make the same world.

use super::obstacle::{Bounds, Obstacle};
use super::scene::World;
use crate::random::{Purpose, stream};
use certainty_core::units::{BinaryAngle, Millimeters, Point};
use core::fmt;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// The parameters of a random world.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    /// Where the obstacles' centres lie; the default is the Smart Car's grid, x −850..=850 mm,
    /// y 0..=1100 mm. An obstacle may reach beyond it by half its size.
    pub area: Bounds,
    /// The number of boxes, each turned at random; 4 by default.
    pub boxes: u16,
    /// The number of discs; 3 by default.
    pub discs: u16,
    /// The shortest side of a box and the smallest diameter of a disc; 60 mm by default.
    pub smallest: Millimeters,
    /// The longest side of a box and the largest diameter of a disc; 300 mm by default.
    pub largest: Millimeters,
    /// The places of the sensors; the origin by default.
    pub sensors: Vec<Point>,
    /// The least distance from any obstacle to any sensor; 150 mm by default, since a GP2D02 does not
    /// measure below 100 mm.
    pub keep_clear: Millimeters,
}

impl Default for Layout {
    fn default() -> Self {
        Self {
            area: Bounds {
                lower_left: Point::from_mm(-850, 0),
                upper_right: Point::from_mm(850, 1100),
            },
            boxes: 4,
            discs: 3,
            smallest: Millimeters::new(60),
            largest: Millimeters::new(300),
            sensors: vec![Point::ORIGIN],
            keep_clear: Millimeters::new(150),
        }
    }
}

/// Why there is no world for a layout.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LayoutError {
    /// The layout has neither a box nor a disc.
    NoObstacle,
    /// The corners of the area are swapped.
    EmptyArea,
    /// The smallest size is zero or above the largest, or the largest is beyond [`Point::LIMIT`].
    Size,
    /// No place far enough from the sensors was found.
    NoRoom,
}

impl fmt::Display for LayoutError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoObstacle => "a random world needs at least one box or disc",
            Self::EmptyArea => "the area's lower left corner must be below and left of the other",
            Self::Size => "obstacle sizes must be above 0mm, the smallest not above the largest",
            Self::NoRoom => "no room clear of the sensors: make the area or the distance smaller",
        })
    }
}

impl core::error::Error for LayoutError {}

impl World {
    /// Creates the world that `layout` and `seed` determine.
    ///
    /// ```
    /// use certainty_core::units::Point;
    /// use certainty_sim::world::{Layout, World};
    ///
    /// let world = World::random(&Layout::default(), 7)?;
    /// assert_eq!(world, World::random(&Layout::default(), 7)?);
    /// assert_ne!(world, World::random(&Layout::default(), 8)?);
    /// assert!(!world.occupied(Point::ORIGIN));
    /// # Ok::<(), certainty_sim::world::LayoutError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`LayoutError`] for a layout that no world fits.
    pub fn random(layout: &Layout, seed: u64) -> Result<Self, LayoutError> {
        layout.check()?;
        let mut rng = stream(seed, Purpose::Layout, 0, 0);
        let total = usize::from(layout.boxes) + usize::from(layout.discs);
        let obstacles = (0..total)
            .map(|n| layout.place(&mut rng, n < usize::from(layout.boxes)))
            .collect::<Result<_, _>>()?;
        Ok(Self::new(format!("random {seed}"), obstacles))
    }
}

impl Layout {
    /// Refuses parameters that [`World::random`] cannot draw from.
    fn check(&self) -> Result<(), LayoutError> {
        let Bounds {
            lower_left: low,
            upper_right: high,
        } = self.area;
        if self.boxes == 0 && self.discs == 0 {
            return Err(LayoutError::NoObstacle);
        }
        if low.x_mm() > high.x_mm() || low.y_mm() > high.y_mm() {
            return Err(LayoutError::EmptyArea);
        }
        if self.smallest == Millimeters::ZERO
            || self.smallest > self.largest
            || self.largest.get() > Point::LIMIT.unsigned_abs()
        {
            return Err(LayoutError::Size);
        }
        Ok(())
    }

    /// Draws obstacles until one is far enough from the sensors.
    fn place(&self, rng: &mut ChaCha8Rng, is_box: bool) -> Result<Obstacle, LayoutError> {
        // A place that is free one time in fifty is missed once in 5·10⁸ worlds.
        const ATTEMPTS: u32 = 1000;
        let Bounds {
            lower_left: low,
            upper_right: high,
        } = self.area;
        for _ in 0..ATTEMPTS {
            let centre = Point::from_mm(
                rng.random_range(low.x_mm()..=high.x_mm()),
                rng.random_range(low.y_mm()..=high.y_mm()),
            );
            let side =
                |rng: &mut ChaCha8Rng| rng.random_range(self.smallest.get()..=self.largest.get());
            let drawn = if is_box {
                let size = (Millimeters::new(side(rng)), Millimeters::new(side(rng)));
                Obstacle::rectangle(centre, size, BinaryAngle::from_bits(rng.random()))
            } else {
                Obstacle::disc(centre, Millimeters::new(side(rng).div_ceil(2)))
            };
            let obstacle = drawn.map_err(|_| LayoutError::Size)?;
            let clear = f64::from(self.keep_clear.get());
            if self
                .sensors
                .iter()
                .all(|&at| obstacle.clearance(at) >= clear)
            {
                return Ok(obstacle);
            }
        }
        Err(LayoutError::NoRoom)
    }
}

#[cfg(test)]
mod tests {
    use super::super::obstacle::Vector;
    use super::*;
    use proptest::prelude::*;

    const fn mm(mm: u32) -> Millimeters {
        Millimeters::new(mm)
    }

    #[test]
    fn random_worlds_keep_clear_of_every_sensor() {
        let layout = Layout {
            sensors: vec![Point::from_mm(-100, 0), Point::from_mm(100, 20)],
            ..Layout::default()
        };
        for seed in 0..200 {
            let world = World::random(&layout, seed).unwrap();
            assert_eq!(world.obstacles().len(), 7);
            for obstacle in world.obstacles() {
                for &sensor in &layout.sensors {
                    assert!(obstacle.clearance(sensor) >= 150.0, "seed {seed}");
                }
            }
        }
    }

    #[test]
    fn impossible_layouts_are_refused() {
        let ok = Layout::default;
        let full = Layout {
            keep_clear: mm(5000),
            ..ok()
        };
        assert_eq!(World::random(&full, 1), Err(LayoutError::NoRoom));
        let none = Layout {
            boxes: 0,
            discs: 0,
            ..ok()
        };
        assert_eq!(World::random(&none, 1), Err(LayoutError::NoObstacle));
        let inverted = Layout {
            smallest: mm(301),
            ..ok()
        };
        assert_eq!(World::random(&inverted, 1), Err(LayoutError::Size));
        let turned = Layout {
            area: Bounds {
                lower_left: Point::from_mm(1, 0),
                upper_right: Point::ORIGIN,
            },
            ..ok()
        };
        assert_eq!(World::random(&turned, 1), Err(LayoutError::EmptyArea));
    }

    /// The naive distance: tests places along the ray, a quarter of a millimetre apart.
    fn marched(world: &World, origin: Point, bearing: BinaryAngle, most: f64) -> Option<f64> {
        let (from, along) = (Vector::centre_of(origin), Vector::along(bearing));
        let mut gone = 0.0;
        while gone <= most {
            let here = from.plus(Vector {
                x: along.x * gone,
                y: along.y * gone,
            });
            if world.obstacles().iter().any(|o| o.covers(here)) {
                return Some(gone);
            }
            gone += 0.25;
        }
        None
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        #[test]
        fn rays_agree_with_marching(
            seed in 0..1000_u64,
            x in -850..850_i32,
            y in -100..1100_i32,
            bearing in any::<u16>(),
        ) {
            let world = World::random(&Layout::default(), seed).unwrap();
            let (origin, bearing) = (Point::from_mm(x, y), BinaryAngle::from_bits(bearing));
            let cast = world.distance(origin, bearing, mm(1500));
            match (cast, marched(&world, origin, bearing, 1500.0)) {
                (Some(cast), Some(marched)) => {
                    // Marching may step over a corner that the ray cuts; the ray misses nothing that marching meets.
                    prop_assert!(cast <= marched + 1e-6, "{cast} vs {marched}");
                    if cast < marched - 0.2501 {
                        let from = Vector::centre_of(origin);
                        let along = Vector::along(bearing);
                        let at = from.plus(Vector { x: along.x * cast, y: along.y * cast });
                        let touches = world.obstacles().iter().any(|o| {
                            let nudged = |by: f64| o.covers(at.plus(Vector { x: along.x * by, y: along.y * by }));
                            nudged(1e-6) || nudged(0.01)
                        });
                        prop_assert!(touches, "{cast} vs {marched}");
                    }
                }
                (None, Some(marched)) => prop_assert!(marched > 1499.9, "missed {marched}"),
                _ => {}
            }
        }
    }
}
