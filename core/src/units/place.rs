//! Places on the plane and the poses of what moves there.

use super::angle::{BinaryAngle, Direction};
use super::length::Millimeters;
use crate::narrow::saturating_i32;

/// A place on the plane: the square millimetre whose lower left corner is (x, y).
///
/// Naming the *square* and not the corner has a use: the centre of a square never lies on a cell's
/// border, so a point is in exactly one cell, and mirroring a map mirrors its cells.
///
/// Units and range: millimetres, each coordinate within ±[`Point::LIMIT`] (268 km, beyond which it
/// saturates), so that products of two distances fit 64 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(try_from = "Coordinates", into = "Coordinates")
)]
pub struct Point {
    x: i32,
    y: i32,
}

impl Point {
    /// Largest absolute coordinate, in millimetres: 2^28.
    pub const LIMIT: i32 = 1 << 28;

    /// The origin of the map frame.
    pub const ORIGIN: Self = Self { x: 0, y: 0 };

    /// Creates a place from its coordinates in millimetres; beyond ±[`Self::LIMIT`] they saturate.
    #[must_use]
    pub const fn from_mm(x: i32, y: i32) -> Self {
        Self {
            x: limited(x as i64),
            y: limited(y as i64),
        }
    }

    /// Returns the coordinate along +x in millimetres.
    #[must_use]
    pub const fn x_mm(self) -> i32 {
        self.x
    }

    /// Returns the coordinate along +y in millimetres.
    #[must_use]
    pub const fn y_mm(self) -> i32 {
        self.y
    }

    /// Returns the place that is `distance` away in `direction`.
    ///
    /// Rounds each coordinate to the nearest millimetre, ties away from the start, so that mirrored
    /// directions lead to mirrored places; saturates at [`Self::LIMIT`].
    ///
    /// ```
    /// use certainty_core::units::{BinaryAngle, Millimeters, Point};
    ///
    /// let north = BinaryAngle::QUARTER.direction();
    /// let there = Point::from_mm(10, 20).ahead(north, Millimeters::new(5));
    /// assert_eq!(there, Point::from_mm(10, 25));
    /// ```
    #[must_use]
    pub const fn ahead(self, direction: Direction, distance: Millimeters) -> Self {
        // Beyond twice the limit every distance saturates alike; within it a product takes 60 bits.
        const MOST: u32 = 1 << 29;
        let distance = distance.get();
        let far = if distance > MOST { MOST } else { distance } as i64;
        Self {
            x: limited((self.x as i64).wrapping_add(scaled(far, direction.cos()))),
            y: limited((self.y as i64).wrapping_add(scaled(far, direction.sin()))),
        }
    }
}

impl Point {
    /// Returns how far it is to `other`, rounded down.
    ///
    /// ```
    /// use certainty_core::units::{Millimeters, Point};
    ///
    /// let far = Point::from_mm(1, 2).distance(Point::from_mm(-299, 402));
    /// assert_eq!(far, Millimeters::new(500));
    /// ```
    #[must_use]
    pub const fn distance(self, other: Self) -> Millimeters {
        // Differences are at most 2^29, the sum of their squares at most 2^59.
        let x = (other.x as i64).wrapping_sub(self.x as i64).unsigned_abs();
        let y = (other.y as i64).wrapping_sub(self.y as i64).unsigned_abs();
        let square = x.wrapping_mul(x).wrapping_add(y.wrapping_mul(y));
        Millimeters::new(crate::narrow::low_u32(square.isqrt()))
    }

    /// Returns the direction in which `other` lies; `None` if it is the same place.
    ///
    /// \[004\] eq. 10 in a plane, counter-clockwise from +x.
    #[must_use]
    pub const fn bearing(self, other: Self) -> Option<BinaryAngle> {
        // Both are within 2^28 of the origin.
        BinaryAngle::towards(other.x.wrapping_sub(self.x), other.y.wrapping_sub(self.y))
    }
}

/// A [`Point`] as it is serialised: its coordinates in millimetres.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
struct Coordinates {
    x_mm: i32,
    y_mm: i32,
}

#[cfg(feature = "serde")]
impl From<Point> for Coordinates {
    fn from(point: Point) -> Self {
        Self {
            x_mm: point.x,
            y_mm: point.y,
        }
    }
}

#[cfg(feature = "serde")]
impl TryFrom<Coordinates> for Point {
    type Error = &'static str;

    /// Refuses coordinates beyond [`Point::LIMIT`], which [`Point::from_mm`] would change.
    fn try_from(coordinates: Coordinates) -> Result<Self, Self::Error> {
        let Coordinates { x_mm, y_mm } = coordinates;
        let point = Self::from_mm(x_mm, y_mm);
        if (point.x, point.y) == (x_mm, y_mm) {
            Ok(point)
        } else {
            Err("a coordinate is beyond 268435456 mm")
        }
    }
}

/// One half in the fraction of a [`Direction`].
const HALF: i64 = 1 << (Direction::FRACTION_BITS - 1);

/// `distance * part` of a unit vector, rounded to the nearest, ties away from zero.
const fn scaled(distance: i64, part: i32) -> i64 {
    let product = distance.wrapping_mul((part as i64).wrapping_abs());
    let magnitude = product.wrapping_add(HALF) >> Direction::FRACTION_BITS;
    if part < 0 {
        magnitude.wrapping_neg()
    } else {
        magnitude
    }
}

/// `mm` within ±[`Point::LIMIT`].
const fn limited(mm: i64) -> i32 {
    let mm = saturating_i32(mm);
    if mm > Point::LIMIT {
        Point::LIMIT
    } else if mm < Point::LIMIT.wrapping_neg() {
        Point::LIMIT.wrapping_neg()
    } else {
        mm
    }
}

/// Where something is and which way it looks.
///
/// A sensor's mounting on the robot is a pose in the robot's frame (+x ahead, +y to the left); the
/// robot's pose is one in the map's frame; [`Pose::compose`] chains them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Pose {
    /// The place.
    pub at: Point,
    /// The direction it looks in.
    pub heading: BinaryAngle,
}

impl Pose {
    /// Creates a pose.
    #[must_use]
    pub const fn new(at: Point, heading: BinaryAngle) -> Self {
        Self { at, heading }
    }

    /// Returns the pose in the outer frame of something mounted at `part` in this one's frame.
    ///
    /// Formula: `at + R(heading) · part.at`, `heading + part.heading`; rounds to the nearest
    /// millimetre.
    ///
    /// ```
    /// use certainty_core::units::{BinaryAngle, Point, Pose};
    ///
    /// // A robot at (1 m, 0) looks along +y; its left sensor sits 10 cm to the left and looks left.
    /// let robot = Pose::new(Point::from_mm(1000, 0), BinaryAngle::QUARTER);
    /// let left = Pose::new(Point::from_mm(0, 100), BinaryAngle::QUARTER);
    /// let sensor = robot.compose(left);
    /// assert_eq!(sensor, Pose::new(Point::from_mm(900, 0), BinaryAngle::HALF));
    /// ```
    #[must_use]
    pub const fn compose(self, part: Self) -> Self {
        let direction = self.heading.direction();
        let (cos, sin) = (direction.cos() as i64, direction.sin() as i64);
        let (x, y) = (part.at.x as i64, part.at.y as i64);
        // At most 2^28 mm times 2^30, twice: 59 bits.
        let ahead = x.wrapping_mul(cos).wrapping_sub(y.wrapping_mul(sin));
        let aside = x.wrapping_mul(sin).wrapping_add(y.wrapping_mul(cos));
        let ahead = ahead.wrapping_add(HALF) >> Direction::FRACTION_BITS;
        let aside = aside.wrapping_add(HALF) >> Direction::FRACTION_BITS;
        Self {
            at: Point {
                x: limited((self.at.x as i64).wrapping_add(ahead)),
                y: limited((self.at.y as i64).wrapping_add(aside)),
            },
            heading: self.heading.wrapping_add(part.heading),
        }
    }
}
