//! Points near the robot, and the line that fits a set of points best (\[003\] §3).
//!
//! Coordinates are in sixteenths of a millimetre: a line fitted to many noisy points is accurate to less
//! than a millimetre, and so is the point where two such lines intersect.

use certainty_core::units::{Direction, Millimeters, Point};

/// Bits of a fraction of a millimetre.
pub(super) const FINE_BITS: u32 = 4;

/// A point in the robot's frame, in sixteenths of a millimetre.
///
/// Units and range: each coordinate is within ±2^24 sixteenths (about a kilometre) and saturates there,
/// so that products of two differences fit 52 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FinePoint {
    x: i32,
    y: i32,
}

impl FinePoint {
    /// Steps in a millimetre.
    pub const STEPS: i32 = 1 << FINE_BITS;

    /// Largest absolute coordinate, in sixteenths of a millimetre.
    const LIMIT: i64 = 1 << 24;

    /// Creates a point from coordinates in sixteenths of a millimetre; they saturate at ±2^24.
    #[must_use]
    pub const fn from_sixteenths(x: i64, y: i64) -> Self {
        Self {
            x: limited(x),
            y: limited(y),
        }
    }

    /// Creates a point from whole millimetres.
    #[must_use]
    pub const fn from_point(point: Point) -> Self {
        Self::from_sixteenths(
            (point.x_mm() as i64) << FINE_BITS,
            (point.y_mm() as i64) << FINE_BITS,
        )
    }

    /// Returns the coordinate along +x in sixteenths of a millimetre.
    #[must_use]
    pub const fn x(self) -> i32 {
        self.x
    }

    /// Returns the coordinate along +y in sixteenths of a millimetre.
    #[must_use]
    pub const fn y(self) -> i32 {
        self.y
    }

    /// The point at `distance` sixteenths of a millimetre from the origin in `direction`, rounded.
    pub(super) const fn polar(distance: i32, direction: Direction) -> Self {
        Self {
            x: limited(share(distance, direction.cos())),
            y: limited(share(distance, direction.sin())),
        }
    }

    pub(super) const fn plus(self, other: Self) -> Self {
        Self {
            x: self.x.wrapping_add(other.x),
            y: self.y.wrapping_add(other.y),
        }
    }

    /// The displacement from `other` to this point.
    pub(super) const fn minus(self, other: Self) -> Self {
        Self {
            x: self.x.wrapping_sub(other.x),
            y: self.y.wrapping_sub(other.y),
        }
    }

    /// The dot product with `other`; below 2^52.
    pub(super) const fn dot(self, other: Self) -> i64 {
        let x = (self.x as i64).wrapping_mul(other.x as i64);
        x.wrapping_add((self.y as i64).wrapping_mul(other.y as i64))
    }

    /// The cross product with `other`, positive if `other` is to the left; below 2^52.
    pub(super) const fn cross(self, other: Self) -> i64 {
        let left = (self.x as i64).wrapping_mul(other.y as i64);
        left.wrapping_sub((self.y as i64).wrapping_mul(other.x as i64))
    }

    pub(super) const fn square(self) -> u64 {
        self.dot(self).unsigned_abs()
    }

    /// The length in sixteenths of a millimetre, rounded down.
    pub(super) const fn length(self) -> u64 {
        self.square().isqrt()
    }

    /// The component along the unit vector, in sixteenths of a millimetre, rounded.
    pub(super) const fn along(self, direction: Direction) -> i32 {
        let x = (self.x as i64).wrapping_mul(direction.cos() as i64);
        let y = (self.y as i64).wrapping_mul(direction.sin() as i64);
        rounded(x.wrapping_add(y))
    }

    /// The component to the left of the unit vector, in steps of 2^-30 of a sixteenth.
    pub(super) const fn left_of(self, direction: Direction) -> i64 {
        let y = (self.y as i64).wrapping_mul(direction.cos() as i64);
        y.wrapping_sub((self.x as i64).wrapping_mul(direction.sin() as i64))
    }
}

/// Millimetres as sixteenths; saturates at 2^24, about a kilometre.
pub(super) const fn sixteenths(length: Millimeters) -> i32 {
    limited((length.get() as i64) << FINE_BITS)
}

/// `distance · part`, `part` being a component of a unit vector, rounded.
const fn share(distance: i32, part: i32) -> i64 {
    rounded((distance as i64).wrapping_mul(part as i64)) as i64
}

/// Drops the 30 fraction bits of a product with a unit vector's component, rounding to nearest.
const fn rounded(product: i64) -> i32 {
    const HALF: i64 = 1 << (Direction::FRACTION_BITS - 1);
    saturating_i32(product.wrapping_add(HALF) >> Direction::FRACTION_BITS)
}

/// The nearest coordinate within ±[`FinePoint::LIMIT`].
const fn limited(value: i64) -> i32 {
    if value > FinePoint::LIMIT {
        saturating_i32(FinePoint::LIMIT)
    } else if value < FinePoint::LIMIT.wrapping_neg() {
        saturating_i32(FinePoint::LIMIT.wrapping_neg())
    } else {
        saturating_i32(value)
    }
}

/// The nearest value of 32 bits.
pub(super) const fn saturating_i32(value: i64) -> i32 {
    if value > i32::MAX as i64 {
        i32::MAX
    } else if value < i32::MIN as i64 {
        i32::MIN
    } else {
        #[expect(clippy::cast_possible_truncation, reason = "both bounds are checked")]
        let narrow = value as i32;
        narrow
    }
}

/// A line in Hesse's normal form, as fitted to points of a scan: its unit normal and its distance from
/// the origin.
///
/// Formula (\[003\] §3, Hesse's normal form): `x·cos α + y·sin α = p` with `p ≥ 0`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FittedLine {
    normal: Direction,
    /// In sixteenths of a millimetre.
    distance: i32,
}

impl FittedLine {
    /// Returns the unit vector from the origin to the line: (cos α, sin α).
    #[must_use]
    pub const fn normal(&self) -> Direction {
        self.normal
    }

    /// Returns p, the distance from the origin to the line, rounded to the nearest millimetre.
    #[must_use]
    pub const fn distance(&self) -> Millimeters {
        let distance = self.distance.unsigned_abs();
        Millimeters::new(distance.wrapping_add(1 << (FINE_BITS - 1)) >> FINE_BITS)
    }

    /// The distance from `point` to the line, in sixteenths: positive on the origin's side.
    pub(super) const fn signed_distance(&self, point: FinePoint) -> i32 {
        self.distance.wrapping_sub(point.along(self.normal))
    }

    /// The position of `point` along the line, counter-clockwise as seen from the origin, in sixteenths.
    pub(super) const fn position(&self, point: FinePoint) -> i32 {
        point.along(self.normal.turned_left())
    }

    /// The point on the line at `position`.
    pub(super) const fn at(&self, position: i32) -> FinePoint {
        let foot = FinePoint::polar(self.distance, self.normal);
        foot.plus(FinePoint::polar(position, self.normal.turned_left()))
    }

    /// The point where the two lines intersect; `None` if they are parallel.
    ///
    /// Numerators stay below 2^56 as p is below 2^24 sixteenths.
    pub(super) const fn intersection(&self, other: &Self) -> Option<FinePoint> {
        let (a, b) = (self.normal, other.normal);
        let (p, q) = (self.distance as i64, other.distance as i64);
        let sine = (a.cos() as i64).wrapping_mul(b.sin() as i64);
        let sine = sine.wrapping_sub((a.sin() as i64).wrapping_mul(b.cos() as i64));
        let sine = sine >> Direction::FRACTION_BITS;
        let x = p.wrapping_mul(b.sin() as i64);
        let x = x.wrapping_sub(q.wrapping_mul(a.sin() as i64));
        let y = q.wrapping_mul(a.cos() as i64);
        let y = y.wrapping_sub(p.wrapping_mul(b.cos() as i64));
        match (x.checked_div(sine), y.checked_div(sine)) {
            (Some(x), Some(y)) => Some(FinePoint::from_sixteenths(x, y)),
            _ => None,
        }
    }
}

/// Sums over points, from which the line that fits them best is computed.
///
/// Range: up to 2^15 points of 16 bits a coordinate; the largest product of sums is below 2^60.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Moments {
    points: i64,
    x: i64,
    y: i64,
    xx: i64,
    xy: i64,
    yy: i64,
}

/// The points' covariances times the square of their number: exact integers.
#[derive(Debug, Clone, Copy)]
struct Scatter {
    xx: i64,
    xy: i64,
    yy: i64,
}

impl Moments {
    pub(super) fn of<'a>(points: impl Iterator<Item = &'a [i16; 2]>) -> Self {
        points.fold(Self::default(), |sums, &[x, y]| {
            let (x, y) = (i64::from(x), i64::from(y));
            Self {
                points: sums.points.wrapping_add(1),
                x: sums.x.wrapping_add(x),
                y: sums.y.wrapping_add(y),
                xx: sums.xx.wrapping_add(x.wrapping_mul(x)),
                xy: sums.xy.wrapping_add(x.wrapping_mul(y)),
                yy: sums.yy.wrapping_add(y.wrapping_mul(y)),
            }
        })
    }

    const fn scatter(&self) -> Scatter {
        let Self {
            points: n,
            x,
            y,
            xx,
            xy,
            yy,
        } = *self;
        Scatter {
            xx: n.wrapping_mul(xx).wrapping_sub(x.wrapping_mul(x)),
            xy: n.wrapping_mul(xy).wrapping_sub(x.wrapping_mul(y)),
            yy: n.wrapping_mul(yy).wrapping_sub(y.wrapping_mul(y)),
        }
    }

    /// Returns whether the points' standard deviation from their best line is below `limit`.
    ///
    /// Formula: the variance across the best line is the smaller eigenvalue λ of the covariance
    /// matrix C (divided by n, not n − 1). λ < σ² unless C − σ²·I has no negative eigenvalue, which is
    /// decided by the signs of its diagonal and its determinant: exact, without a square root.
    pub(super) const fn spread_below(&self, limit: Millimeters) -> bool {
        let Scatter { xx, xy, yy } = self.scatter();
        let limit = (limit.get() as i64).wrapping_mul(self.points);
        let limit = limit.wrapping_mul(limit);
        let (xx, xy, yy) = (
            xx.wrapping_sub(limit) as i128,
            xy as i128,
            yy.wrapping_sub(limit) as i128,
        );
        let no_negative = xx >= 0 && yy >= 0 && xx.wrapping_mul(yy) >= xy.wrapping_mul(xy);
        !no_negative
    }

    /// The line of total least squares: it minimises the squared distances of the points *from the line*.
    ///
    /// Points without a principal axis, such as a single point, get the line that faces the origin.
    pub(super) fn line(&self) -> FittedLine {
        const AHEAD: Direction = certainty_core::units::BinaryAngle::ZERO.direction();
        let Scatter { xx, xy, yy } = self.scatter();
        // Twice the angle of the principal axis has this direction; below 2^60.
        let (double_cos, double_sin) = (xx.wrapping_sub(yy), xy.wrapping_mul(2));
        let axis = Direction::towards(double_cos, double_sin).and_then(|double| {
            // (1 + cos 2φ, sin 2φ) and (sin 2φ, 1 − cos 2φ) both have the angle φ; the longer is exact.
            const ONE: i64 = 1 << Direction::FRACTION_BITS;
            let (cos, sin) = (i64::from(double.cos()), i64::from(double.sin()));
            if cos >= 0 {
                Direction::towards(ONE.wrapping_add(cos), sin)
            } else {
                Direction::towards(sin, ONE.wrapping_sub(cos))
            }
        });
        let normal = axis.map(Direction::turned_left);
        let normal = normal.or_else(|| Direction::towards(self.x, self.y));
        let normal = normal.unwrap_or(AHEAD);
        let x = self.x.wrapping_mul(normal.cos().into());
        let y = self.y.wrapping_mul(normal.sin().into());
        // In steps of 2^-30 mm and times the number of points; now sixteenths, and divided.
        let steps = self.points << (Direction::FRACTION_BITS - FINE_BITS);
        let sum = x.wrapping_add(y);
        let half = steps >> 1;
        let magnitude = sum.wrapping_abs().wrapping_add(half).checked_div(steps);
        FittedLine {
            normal: if sum < 0 { normal.reversed() } else { normal },
            distance: saturating_i32(magnitude.unwrap_or(0)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn moments(points: &[[i16; 2]]) -> Moments {
        Moments::of(points.iter())
    }

    /// Angle of the normal, distance in mm and standard deviation, in floating point.
    fn naive(points: &[[i16; 2]]) -> (f64, f64, f64) {
        let n = points.len() as f64;
        let mean = |f: &dyn Fn(&[i16; 2]) -> f64| points.iter().map(f).sum::<f64>() / n;
        let (mx, my) = (mean(&|p| p[0].into()), mean(&|p| p[1].into()));
        let about =
            |f: &dyn Fn(f64, f64) -> f64| mean(&|p| f(f64::from(p[0]) - mx, f64::from(p[1]) - my));
        let (xx, xy, yy) = (
            about(&|x, _| x * x),
            about(&|x, y| x * y),
            about(&|_, y| y * y),
        );
        let axis = 0.5 * (2.0 * xy).atan2(xx - yy);
        let (sin, cos) = axis.sin_cos();
        let (nx, ny) = (-sin, cos);
        let across = nx * nx * xx + 2.0 * nx * ny * xy + ny * ny * yy;
        (axis, (nx * mx + ny * my).abs(), across.max(0.0).sqrt())
    }

    #[test]
    fn a_vertical_wall_fits_as_well_as_a_level_one() {
        // Vertical in the plane, which y = a + b·x cannot express.
        let wall: Vec<_> = (-50..50).map(|step| [1500, step * 20]).collect();
        let line = moments(&wall).line();
        assert_eq!(line.distance(), Millimeters::new(1500));
        assert_eq!((line.normal().cos(), line.normal().sin()), (1 << 30, 0));
        let level: Vec<_> = wall.iter().map(|&[x, y]| [y, -x]).collect();
        let line = moments(&level).line();
        assert_eq!(line.distance(), Millimeters::new(1500));
        assert_eq!((line.normal().cos(), line.normal().sin()), (0, -(1 << 30)));
    }

    #[test]
    fn the_deviation_is_compared_exactly() {
        // Ten millimetres to either side of a line: 10 mm, and that is not below 10 mm.
        let points: Vec<_> = (0..40)
            .map(|n| [n / 2 * 100, 500 + (n % 2 * 20 - 10)])
            .collect();
        let moments = moments(&points);
        assert!(!moments.spread_below(Millimeters::new(10)));
        assert!(moments.spread_below(Millimeters::new(11)));
    }

    #[test]
    fn points_without_an_axis_face_the_origin() {
        let one = moments(&[[300, -400]]).line();
        assert_eq!(one.distance(), Millimeters::new(500));
        assert_eq!(one.normal(), Direction::towards(3, -4).unwrap());
        let square = moments(&[[10, 0], [12, 0], [10, 2], [12, 2]]).line();
        assert_eq!(square.normal(), Direction::towards(11, 1).unwrap());
        let nowhere = moments(&[[0, 0], [0, 0]]).line();
        assert_eq!(nowhere.distance(), Millimeters::ZERO);
        let none = moments(&[]).line();
        assert_eq!(none.distance(), Millimeters::ZERO);
    }

    #[test]
    fn two_lines_intersect_at_their_corner() {
        let ahead = moments(&[[1000, 0], [1000, 50]]).line();
        let left = moments(&[[0, 700], [50, 700]]).line();
        let corner = ahead.intersection(&left).unwrap();
        assert_eq!((corner.x(), corner.y()), (16_000, 11_200));
        assert_eq!(ahead.intersection(&ahead), None);
    }

    proptest! {
        #[test]
        fn the_line_is_that_of_least_squares(
            points in prop::collection::vec([-20_000_i16..20_000, -20_000_i16..20_000], 2..60),
            limit in 1_u32..20_000,
        ) {
            let (_, distance, deviation) = naive(&points);
            let moments = moments(&points);
            let line = moments.line();
            let scatter = moments.scatter();
            // Nearly round clouds have no well-defined axis.
            let (wide, narrow) = ((scatter.xx - scatter.yy) as f64, 2.0 * scatter.xy as f64);
            if wide.hypot(narrow) > 1e-4 * (scatter.xx + scatter.yy) as f64 {
                let found = f64::from(line.signed_distance(FinePoint::default())) / 16.0;
                prop_assert!((found - distance).abs() < 0.2, "{found} for {distance}");
            }
            if (deviation - f64::from(limit)).abs() > 1e-3 {
                prop_assert_eq!(moments.spread_below(Millimeters::new(limit)), deviation < f64::from(limit));
            }
        }

        #[test]
        fn extreme_points_overflow_nothing(
            points in prop::collection::vec(prop::array::uniform2(prop::sample::select(
                vec![i16::MIN, i16::MAX, 0, 1])), 0..400),
        ) {
            let moments = moments(&points);
            let line = moments.line();
            prop_assert!(line.distance() <= Millimeters::new(46_342));
            prop_assert!(moments.spread_below(Millimeters::new(1000)) || points.len() > 2 || points.is_empty());
        }
    }
}
