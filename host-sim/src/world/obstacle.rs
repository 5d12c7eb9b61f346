//! An obstacle, which is a box, a wall or a disc, and where a ray enters it.

use certainty_core::units::{BinaryAngle, Direction, Millimeters, Point};
use core::fmt;

/// An upright rectangle of whole millimetres.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bounds {
    /// The lower left corner.
    pub lower_left: Point,
    /// The upper right corner.
    pub upper_right: Point,
}

/// An obstacle: a box, a wall or a disc.
///
/// Possession proves that it covers an area: no side, radius or thickness is zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Obstacle(Outline);

/// The outline of an obstacle; lengths in millimetres.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Outline {
    Box {
        centre: Vector,
        /// Half the sides, along the box's own axes.
        half: Vector,
        /// Unit vector along the box's own x axis.
        axis: Vector,
    },
    Disc {
        centre: Vector,
        radius: f64,
    },
}

/// The shape of an obstacle, in millimetres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// The corners of a box or wall, counter-clockwise.
    Box([(f64, f64); 4]),
    /// A disc.
    Disc {
        /// Its centre.
        centre: (f64, f64),
        /// Its radius.
        radius: f64,
    },
}

impl fmt::Display for Obstacle {
    /// Writes its kind and place, such as *the disc around 500mm,0mm*.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, centre) = match self.0 {
            Outline::Box { centre, .. } => ("box or wall", centre),
            Outline::Disc { centre, .. } => ("disc", centre),
        };
        // No zero is written with a sign.
        let (x, y) = (centre.x.round() + 0.0, centre.y.round() + 0.0);
        write!(f, "the {what} around {x}mm,{y}mm")
    }
}

/// Why an obstacle was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ObstacleError {
    /// A side, a radius or a thickness is zero.
    NoArea,
    /// A wall ends where it starts.
    NoLength,
    /// A side, a radius or a thickness is beyond [`Point::LIMIT`].
    TooLarge,
}

impl fmt::Display for ObstacleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoArea => "an obstacle needs a size above 0mm",
            Self::NoLength => "a wall must end elsewhere than it starts",
            Self::TooLarge => "an obstacle may be at most 268435456mm long",
        })
    }
}

impl core::error::Error for ObstacleError {}

impl Obstacle {
    /// Creates a box of `size` (along its own x and y) around `centre`, turned by `rotation`.
    ///
    /// # Errors
    ///
    /// [`ObstacleError::NoArea`] for a side of zero, [`ObstacleError::TooLarge`] for one beyond
    /// [`Point::LIMIT`].
    pub fn rectangle(
        centre: Point,
        size: (Millimeters, Millimeters),
        rotation: BinaryAngle,
    ) -> Result<Self, ObstacleError> {
        Ok(Self(Outline::Box {
            centre: Vector::corner_of(centre),
            half: Vector {
                x: extent(size.0)? / 2.0,
                y: extent(size.1)? / 2.0,
            },
            axis: Vector::along(rotation),
        }))
    }

    /// Creates a disc around `centre`.
    ///
    /// # Errors
    ///
    /// [`ObstacleError::NoArea`] for a radius of zero, [`ObstacleError::TooLarge`] for one beyond
    /// [`Point::LIMIT`].
    pub fn disc(centre: Point, radius: Millimeters) -> Result<Self, ObstacleError> {
        Ok(Self(Outline::Disc {
            centre: Vector::corner_of(centre),
            radius: extent(radius)?,
        }))
    }

    /// Creates a straight wall between two points, `thickness` wide, with square ends.
    ///
    /// # Errors
    ///
    /// [`ObstacleError::NoArea`] for a thickness of zero, [`ObstacleError::NoLength`] where `from`
    /// is `to`, [`ObstacleError::TooLarge`] for a thickness beyond [`Point::LIMIT`].
    pub fn wall(from: Point, to: Point, thickness: Millimeters) -> Result<Self, ObstacleError> {
        let (start, end) = (Vector::corner_of(from), Vector::corner_of(to));
        let run = end.minus(start);
        let length = run.length();
        if length == 0.0 {
            return Err(ObstacleError::NoLength);
        }
        Ok(Self(Outline::Box {
            centre: Vector {
                x: f64::midpoint(start.x, end.x),
                y: f64::midpoint(start.y, end.y),
            },
            half: Vector {
                x: length / 2.0,
                y: extent(thickness)? / 2.0,
            },
            axis: Vector {
                x: run.x / length,
                y: run.y / length,
            },
        }))
    }

    /// Returns the obstacle's shape.
    #[must_use]
    pub fn shape(&self) -> Shape {
        match self.0 {
            Outline::Box { centre, half, axis } => {
                let corner = |right: f64, up: f64| {
                    let (x, y) = (half.x * right, half.y * up);
                    (
                        centre.x + axis.x * x - axis.y * y,
                        centre.y + axis.y * x + axis.x * y,
                    )
                };
                Shape::Box([
                    corner(-1.0, -1.0),
                    corner(1.0, -1.0),
                    corner(1.0, 1.0),
                    corner(-1.0, 1.0),
                ])
            }
            Outline::Disc { centre, radius } => Shape::Disc {
                centre: (centre.x, centre.y),
                radius,
            },
        }
    }

    /// Returns the distance from the square millimetre `at` to the obstacle; 0 where the obstacle covers it.
    ///
    /// Units: millimetres from the centre of the square to the nearest point of the outline.
    #[must_use]
    pub fn clearance(&self, at: Point) -> f64 {
        let at = Vector::centre_of(at);
        match self.0 {
            Outline::Box { centre, half, axis } => {
                let local = at.minus(centre).in_frame(axis);
                Vector {
                    x: (local.x.abs() - half.x).max(0.0),
                    y: (local.y.abs() - half.y).max(0.0),
                }
                .length()
            }
            Outline::Disc { centre, radius } => (at.minus(centre).length() - radius).max(0.0),
        }
    }

    /// Returns the corners of the outline, counter-clockwise, in millimetres; for a disc 48 points.
    #[must_use]
    pub fn outline(&self) -> Vec<(f64, f64)> {
        match self.shape() {
            Shape::Box(corners) => corners.to_vec(),
            Shape::Disc {
                centre: (x, y),
                radius,
            } => (0..48_i32)
                .map(|part| {
                    let along = Vector::along(BinaryAngle::from_millidegrees(part * 7500));
                    (x + radius * along.x, y + radius * along.y)
                })
                .collect(),
        }
    }

    /// Returns the smallest upright rectangle around the obstacle, rounded outwards.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let (centre, reach) = match self.0 {
            Outline::Box { centre, half, axis } => (
                centre,
                Vector {
                    x: half.x * axis.x.abs() + half.y * axis.y.abs(),
                    y: half.x * axis.y.abs() + half.y * axis.x.abs(),
                },
            ),
            Outline::Disc { centre, radius } => (
                centre,
                Vector {
                    x: radius,
                    y: radius,
                },
            ),
        };
        let (low, high) = (centre.minus(reach), centre.plus(reach));
        Bounds {
            lower_left: Point::from_mm(low.x.floor() as i32, low.y.floor() as i32),
            upper_right: Point::from_mm(high.x.ceil() as i32, high.y.ceil() as i32),
        }
    }

    /// Whether the obstacle, its outline included, covers `at`.
    pub(super) fn covers(&self, at: Vector) -> bool {
        match self.0 {
            Outline::Box { centre, half, axis } => {
                let local = at.minus(centre).in_frame(axis);
                local.x.abs() <= half.x && local.y.abs() <= half.y
            }
            Outline::Disc { centre, radius } => {
                let away = at.minus(centre);
                away.dot(away) <= radius * radius
            }
        }
    }

    /// The distance from `origin` at which a ray along the unit vector `along` enters; 0 from inside.
    pub(super) fn entered_by(&self, origin: Vector, along: Vector) -> Option<f64> {
        match self.0 {
            Outline::Box { centre, half, axis } => {
                let from = origin.minus(centre).in_frame(axis);
                let along = along.in_frame(axis);
                // The ray is inside the box while it is between both pairs of sides.
                let (enter_x, leave_x) = between_sides(from.x, along.x, half.x)?;
                let (enter_y, leave_y) = between_sides(from.y, along.y, half.y)?;
                let (enter, leave) = (enter_x.max(enter_y), leave_x.min(leave_y));
                (enter <= leave && leave >= 0.0).then_some(enter.max(0.0))
            }
            Outline::Disc { centre, radius } => {
                if self.covers(origin) {
                    return Some(0.0);
                }
                let to_centre = centre.minus(origin);
                let aside = along.cross(to_centre);
                let ahead = along.dot(to_centre);
                // From outside, a disc with its centre behind is behind.
                if ahead <= 0.0 || aside.abs() > radius {
                    return None;
                }
                let half_chord = (radius * radius - aside * aside).sqrt();
                Some((ahead - half_chord).max(0.0))
            }
        }
    }
}

/// A side, radius or thickness as a float.
fn extent(length: Millimeters) -> Result<f64, ObstacleError> {
    if length == Millimeters::ZERO {
        Err(ObstacleError::NoArea)
    } else if length.get() > Point::LIMIT.unsigned_abs() {
        Err(ObstacleError::TooLarge)
    } else {
        Ok(f64::from(length.get()))
    }
}

/// The interval of t in which `from` + t · `along` is within ±`half`.
fn between_sides(from: f64, along: f64, half: f64) -> Option<(f64, f64)> {
    if along == 0.0 {
        return (from.abs() <= half).then_some((f64::NEG_INFINITY, f64::INFINITY));
    }
    let (a, b) = ((-half - from) / along, (half - from) / along);
    Some((a.min(b), a.max(b)))
}

/// A point or a displacement, in millimetres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Vector {
    pub(super) x: f64,
    pub(super) y: f64,
}

impl Vector {
    /// The lower left corner of a square millimetre: the coordinates themselves.
    pub(super) fn corner_of(point: Point) -> Self {
        Self {
            x: f64::from(point.x_mm()),
            y: f64::from(point.y_mm()),
        }
    }

    /// The centre of a square millimetre.
    pub(super) fn centre_of(point: Point) -> Self {
        Self::corner_of(point).plus(Self { x: 0.5, y: 0.5 })
    }

    /// The unit vector along `bearing`; exact along the axes.
    pub(super) fn along(bearing: BinaryAngle) -> Self {
        let direction = bearing.direction();
        let scale = f64::from(1_u32 << Direction::FRACTION_BITS);
        Self {
            x: f64::from(direction.cos()) / scale,
            y: f64::from(direction.sin()) / scale,
        }
    }

    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            x: self.x + other.x,
            y: self.y + other.y,
        }
    }

    pub(super) fn minus(self, other: Self) -> Self {
        Self {
            x: self.x - other.x,
            y: self.y - other.y,
        }
    }

    pub(super) fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y
    }

    /// The cross product: the distance of `other` to the left of this direction, times its length.
    pub(super) fn cross(self, other: Self) -> f64 {
        self.x * other.y - self.y * other.x
    }

    pub(super) fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// This vector in a frame whose x axis points along the unit vector `axis`.
    pub(super) fn in_frame(self, axis: Self) -> Self {
        Self {
            x: axis.dot(self),
            y: axis.cross(self),
        }
    }
}
