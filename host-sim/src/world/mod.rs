//! The world that simulated sensors look at: obstacles on a plane.
//!
//! Distances are exact: each ray is intersected with each obstacle's outline in closed form, not
//! marched over a raster. Directions come from the core's integer sines, and the rest is additions,
//! products and square roots, so the same bits come out on every machine.
//!
//! Obstacles lie where their coordinates say, to the millimetre: a box from x = 200 to 400 covers
//! the square millimetres 200 to 399. Rays start, and [`World::occupied`] looks, at the *centre* of
//! a [`Point`]'s square millimetre, which never falls on the edge of a box that stands straight.
//!
//! Cost: one intersection an obstacle and a ray; no allocation.

mod builtin;
mod file;
mod obstacle;
mod random;

pub use builtin::{OFFICE, SMART_CAR};
pub use obstacle::{Obstacle, ObstacleError, Shape};
pub use random::{Layout, LayoutError};

use certainty_core::units::{BinaryAngle, Direction, Millimeters, Point};

/// Obstacles on a plane.
#[derive(Debug, Clone, PartialEq)]
pub struct World {
    name: String,
    obstacles: Vec<Obstacle>,
}

/// An upright rectangle of whole millimetres.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bounds {
    /// The lower left corner.
    pub lower_left: Point,
    /// The upper right corner.
    pub upper_right: Point,
}

impl World {
    /// Creates a world called `name` in which `obstacles` stand; they may overlap.
    ///
    /// No obstacle at all is an open plane, on which no ray ever ends.
    #[must_use]
    pub fn new(name: impl Into<String>, obstacles: Vec<Obstacle>) -> Self {
        Self {
            name: name.into(),
            obstacles,
        }
    }

    /// Returns what the world is called.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the obstacles, in the order they were given.
    #[must_use]
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }

    /// Returns how far a ray from `origin` along `bearing` goes before it meets an obstacle.
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

    /// Tells whether the straight way from one place to another is free; its last half millimetre may
    /// touch what it leads to.
    ///
    /// Units: millimetres, as coordinates are written.
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

    /// Tells whether an obstacle covers the place `at`, given as coordinates are written.
    #[must_use]
    pub fn covers(&self, at: (f64, f64)) -> bool {
        let at = Vector { x: at.0, y: at.1 };
        self.obstacles.iter().any(|obstacle| obstacle.covers(at))
    }

    /// Returns how far the nearest obstacle is from the square millimetre `at`, the shortest way; `None`
    /// on an open plane.
    #[must_use]
    pub fn clearance(&self, at: Point) -> Option<f64> {
        let obstacles = self.obstacles.iter();
        let clearances = obstacles.map(|obstacle| obstacle.clearance(at));
        clearances.min_by(f64::total_cmp)
    }

    /// Tells whether an obstacle covers the centre of the square millimetre `at`.
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

/// A place or a displacement, in millimetres.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Vector {
    x: f64,
    y: f64,
}

impl Vector {
    /// The lower left corner of a square millimetre: the coordinates as they are written.
    fn corner_of(point: Point) -> Self {
        Self {
            x: f64::from(point.x_mm()),
            y: f64::from(point.y_mm()),
        }
    }

    /// The centre of a square millimetre.
    fn centre_of(point: Point) -> Self {
        Self::corner_of(point).plus(Self { x: 0.5, y: 0.5 })
    }

    /// The unit vector along `bearing`; exact along the axes.
    fn along(bearing: BinaryAngle) -> Self {
        let direction = bearing.direction();
        let scale = f64::from(1_u32 << Direction::FRACTION_BITS);
        Self {
            x: f64::from(direction.cos()) / scale,
            y: f64::from(direction.sin()) / scale,
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            x: self.x + other.x,
            y: self.y + other.y,
        }
    }

    fn minus(self, other: Self) -> Self {
        Self {
            x: self.x - other.x,
            y: self.y - other.y,
        }
    }

    fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y
    }

    /// How far `other` lies to the left of this direction, times its length.
    fn cross(self, other: Self) -> f64 {
        self.x * other.y - self.y * other.x
    }

    fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// This vector in a frame whose x axis points along the unit vector `axis`.
    fn in_frame(self, axis: Self) -> Self {
        Self {
            x: axis.dot(self),
            y: axis.cross(self),
        }
    }
}

#[cfg(test)]
mod tests;
