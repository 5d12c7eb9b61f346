//! Positions on the plane, and poses: positions with a heading.

use super::angle::{BinaryAngle, Direction};
use super::length::Millimeters;
use crate::narrow::saturating_i32;
use core::ops::{Add, AddAssign, Sub, SubAssign};

/// A position on the plane: the square millimetre whose lower left corner is (x, y).
///
/// A point is the *square*, not the corner, because the centre of a square is never on a cell's
/// border: a point is in exactly one cell, and mirroring a map mirrors its cells.
///
/// Units and range: millimetres, each coordinate within ±[`Point::LIMIT`] (268 km), so that products
/// of two distances fit 64 bits. Coordinates saturate there, those of sums and differences too.
///
/// ```
/// use certainty_core::units::Point;
///
/// let (here, there) = (Point::from_mm(100, 0), Point::from_mm(150, -20));
/// let step = there - here;
/// assert_eq!(step, Point::from_mm(50, -20));
/// assert_eq!(here + step, there);
/// ```
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

    /// Creates a point from its coordinates in millimetres; they saturate at ±[`Self::LIMIT`].
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

    /// Returns the point that is `distance` away in `direction`.
    ///
    /// Rounds each coordinate to the nearest millimetre, ties away from `self`, so that mirrored
    /// directions give mirrored points; saturates at [`Self::LIMIT`].
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

    /// Returns the distance to `other`, rounded down.
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
        Millimeters::from_saturating(square.isqrt())
    }

    /// Returns the direction in which `other` lies; `None` if it is the same point.
    ///
    /// \[004\] eq. 10 in a plane, counter-clockwise from +x.
    #[must_use]
    pub const fn bearing(self, other: Self) -> Option<BinaryAngle> {
        // Both are within 2^28 of the origin.
        BinaryAngle::towards(other.x.wrapping_sub(self.x), other.y.wrapping_sub(self.y))
    }
}

/// Saturates at [`Point::LIMIT`].
impl Add for Point {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::from_mm(
            self.x.saturating_add(other.x),
            self.y.saturating_add(other.y),
        )
    }
}

/// Saturates at [`Point::LIMIT`].
impl AddAssign for Point {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// The way from `other` to `self`; saturates at [`Point::LIMIT`].
impl Sub for Point {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self::from_mm(
            self.x.saturating_sub(other.x),
            self.y.saturating_sub(other.y),
        )
    }
}

/// Saturates at [`Point::LIMIT`].
impl SubAssign for Point {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
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

/// `x` and `y` rotated counter-clockwise by the angle with this cosine and sine; each coordinate
/// rounded to the nearest, ties up.
///
/// Range: the coordinates are at most 2^29 and the components at most 2^30, so a sum takes 60 bits.
const fn rotated(x: i64, y: i64, cos: i64, sin: i64) -> (i64, i64) {
    let along = x.wrapping_mul(cos).wrapping_sub(y.wrapping_mul(sin));
    let across = x.wrapping_mul(sin).wrapping_add(y.wrapping_mul(cos));
    (
        along.wrapping_add(HALF) >> Direction::FRACTION_BITS,
        across.wrapping_add(HALF) >> Direction::FRACTION_BITS,
    )
}

/// A position and a heading.
///
/// A sensor's mounting is a pose in the robot's frame (+x ahead, +y to the left); the robot's pose is
/// one in the map's frame; [`Pose::compose`] chains them. The frame *of* a pose has its origin at the
/// pose's position and its +x along the heading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Pose {
    /// The position.
    pub at: Point,
    /// The direction of +x of the pose's frame.
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
        Self {
            at: self.to_outer(part.at),
            heading: self.heading.wrapping_add(part.heading),
        }
    }

    /// Returns the point in the outer frame that is at `local` in this pose's frame.
    ///
    /// Formula: `at + R(heading) · local`; rounds to the nearest millimetre, ties up; saturates at
    /// [`Point::LIMIT`].
    #[must_use]
    pub const fn to_outer(self, local: Point) -> Point {
        let direction = self.heading.direction();
        let (cos, sin) = (direction.cos() as i64, direction.sin() as i64);
        let (x, y) = rotated(local.x as i64, local.y as i64, cos, sin);
        Point {
            x: limited((self.at.x as i64).wrapping_add(x)),
            y: limited((self.at.y as i64).wrapping_add(y)),
        }
    }

    /// Returns the point in this pose's frame that is at `outer` in the outer frame: the inverse of
    /// [`Self::to_outer`], within 1 mm in each coordinate.
    ///
    /// Formula: `R(−heading) · (outer − at)`; rounds to the nearest millimetre, ties up; saturates at
    /// [`Point::LIMIT`].
    ///
    /// ```
    /// use certainty_core::units::{BinaryAngle, Point, Pose};
    ///
    /// // A robot at (1 m, 0) looks along +y: what is at (900 mm, 0) is 10 cm to its left.
    /// let robot = Pose::new(Point::from_mm(1000, 0), BinaryAngle::QUARTER);
    /// let left = Point::from_mm(0, 100);
    /// assert_eq!(robot.to_local(Point::from_mm(900, 0)), left);
    /// assert_eq!(robot.to_outer(left), Point::from_mm(900, 0));
    /// ```
    #[must_use]
    pub const fn to_local(self, outer: Point) -> Point {
        let direction = self.heading.direction();
        let (cos, sin) = (direction.cos() as i64, direction.sin() as i64);
        let x = (outer.x as i64).wrapping_sub(self.at.x as i64);
        let y = (outer.y as i64).wrapping_sub(self.at.y as i64);
        let (x, y) = rotated(x, y, cos, sin.wrapping_neg());
        Point {
            x: limited(x),
            y: limited(y),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn points(limit: i32) -> impl Strategy<Value = Point> {
        (-limit..=limit, -limit..=limit).prop_map(|(x, y)| Point::from_mm(x, y))
    }

    #[test]
    fn sums_and_differences_saturate() {
        let limit = Point::LIMIT;
        let corner = Point::from_mm(limit, -limit);
        let step = Point::from_mm(1, -1);
        assert_eq!(corner + step, corner);
        assert_eq!(corner - step, Point::from_mm(limit - 1, 1 - limit));
        assert_eq!(Point::ORIGIN - corner, Point::from_mm(-limit, limit));
        let mut point = corner;
        point += corner;
        assert_eq!(point, corner);
        point -= corner;
        assert_eq!(point, Point::ORIGIN);
        point -= corner;
        point -= corner;
        assert_eq!(point, Point::from_mm(-limit, limit));
    }

    #[test]
    fn frames_saturate_at_the_limit() {
        let corner = Point::from_mm(Point::LIMIT, Point::LIMIT);
        let opposite = Point::from_mm(-Point::LIMIT, -Point::LIMIT);
        let pose = Pose::new(corner, BinaryAngle::ZERO);
        assert_eq!(pose.to_outer(corner), corner);
        assert_eq!(pose.to_local(opposite), opposite);
        let turned = Pose::new(corner, BinaryAngle::HALF);
        assert_eq!(turned.to_local(opposite), corner);
    }

    proptest! {
        #[test]
        fn to_local_inverts_to_outer_within_a_millimetre(
            at in points(1 << 26),
            local in points(1 << 26),
            heading: u16,
        ) {
            let pose = Pose::new(at, BinaryAngle::from_bits(heading));
            let found = pose.to_local(pose.to_outer(local));
            prop_assert!((found.x - local.x).abs() <= 1, "{found:?} {local:?}");
            prop_assert!((found.y - local.y).abs() <= 1, "{found:?} {local:?}");
        }

        #[test]
        fn to_local_is_exact_at_quarter_turns(
            at in points(1 << 26),
            local in points(1 << 26),
            quarters in 0_u16..4,
        ) {
            let pose = Pose::new(at, BinaryAngle::from_bits(quarters << 14));
            prop_assert_eq!(pose.to_local(pose.to_outer(local)), local);
        }
    }
}
