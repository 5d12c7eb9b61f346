//! Random layouts, for evaluations that must not hang on one scene.
//!
//! The papers give no obstacle layouts (\[001\] §6.2 says "different obstacle configurations"), so
//! every number here is an open choice: the defaults fill the Smart Car's grid about as densely as
//! the built-in scene. The same layout and seed always make the same world.

use super::{Bounds, Obstacle, World};
use crate::transducer::stream::{Purpose, stream};
use certainty_core::units::{BinaryAngle, Millimeters, Point};
use core::fmt;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// How a random world is made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    /// Where the obstacles' centres lie; the default is the Smart Car's grid, x −850..=850 mm,
    /// y 0..=1100 mm. An obstacle may stick out by half its size.
    pub area: Bounds,
    /// How many boxes there are, each turned at random; 4 by default.
    pub boxes: u16,
    /// How many discs there are; 3 by default.
    pub discs: u16,
    /// The shortest side of a box and the smallest diameter of a disc; 60 mm by default.
    pub smallest: Millimeters,
    /// The longest side of a box and the largest diameter of a disc; 300 mm by default.
    pub largest: Millimeters,
    /// Where the sensors sit; the origin by default.
    pub sensors: Vec<Point>,
    /// How far every obstacle stays away from every sensor; 150 mm by default, since below 100 mm
    /// a GP2D02 cannot tell.
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

/// Why a layout makes no world.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LayoutError {
    /// Neither a box nor a disc is asked for.
    NoObstacle,
    /// The area's corners are the wrong way round.
    EmptyArea,
    /// The smallest size is zero or above the largest, or the largest is beyond [`Point::LIMIT`].
    Size,
    /// No place was found that is clear of the sensors.
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
    /// Makes the world that `layout` and `seed` determine.
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
    /// [`LayoutError`] names what the layout asks for that cannot be.
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
    /// Refuses what [`World::random`] could not draw from.
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

    /// Draws obstacles until one is clear of the sensors.
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
