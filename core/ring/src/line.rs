//! The line through noisy points, in Hesse's normal form (\[003\] §3).

use super::place::{FINE_BITS, FinePoint};
use certainty_core::narrow::saturating_i32;
use certainty_core::units::{Direction, Millimeters};

/// A line: its normal, and how far it passes from the origin.
///
/// Formula (\[003\] §3, Hesse's normal form): `x·cos α + y·sin α = p` with `p ≥ 0`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Line {
    normal: Direction,
    /// In sixteenths of a millimetre.
    distance: i32,
}

impl Line {
    /// Returns the unit vector from the origin to the line: (cos α, sin α).
    #[must_use]
    pub const fn normal(&self) -> Direction {
        self.normal
    }

    /// Returns p, how far the line passes from the origin, rounded to the nearest millimetre.
    #[must_use]
    pub const fn distance(&self) -> Millimeters {
        let distance = self.distance.unsigned_abs();
        Millimeters::new(distance.wrapping_add(1 << (FINE_BITS - 1)) >> FINE_BITS)
    }

    /// How far `place` is from the line, in sixteenths: positive on the origin's side.
    pub(super) const fn before(&self, place: FinePoint) -> i32 {
        self.distance.wrapping_sub(place.along(self.normal))
    }

    /// How far along the line `place` is, counter-clockwise as seen from the origin, in sixteenths.
    pub(super) const fn position(&self, place: FinePoint) -> i32 {
        place.along(self.normal.turned_left())
    }

    /// The place on the line at `position`.
    pub(super) const fn at(&self, position: i32) -> FinePoint {
        let foot = FinePoint::polar(self.distance, self.normal);
        foot.plus(FinePoint::polar(position, self.normal.turned_left()))
    }

    /// Where the two lines meet; `None` if they are parallel.
    ///
    /// Numerators stay below 2^56 as p is below 2^24 sixteenths.
    pub(super) const fn meet(&self, other: &Self) -> Option<FinePoint> {
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

/// Sums over points, enough for the line that fits them best.
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

/// The points' covariances, times the square of their number: exact integers.
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

    /// Tells whether the points' standard deviation from their line is below `limit`.
    ///
    /// Formula: the variance across the best line is the smaller eigenvalue λ of the covariance
    /// matrix C (divided by n, not n − 1). λ < σ² unless C − σ²·I has no negative eigenvalue, which its
    /// diagonal and its determinant tell: exact, without a root.
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

    /// The line that fits best: the squares of the points' distances *from the line* are least.
    ///
    /// Points without a direction of their own (a single one, say) are taken to face the origin.
    pub(super) fn line(&self) -> Line {
        const AHEAD: Direction = certainty_core::units::BinaryAngle::ZERO.direction();
        let Scatter { xx, xy, yy } = self.scatter();
        // Twice the angle of the principal axis has this direction; below 2^60.
        let (double_cos, double_sin) = (xx.wrapping_sub(yy), xy.wrapping_mul(2));
        let axis = Direction::towards(double_cos, double_sin).and_then(|double| {
            // (1 + cos 2φ, sin 2φ) and (sin 2φ, 1 − cos 2φ) both lie at φ; the longer is exact.
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
        Line {
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
    fn a_wall_straight_ahead_is_a_line_whatever_its_slope() {
        // Vertical in the plane, which y = a + b·x cannot say.
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
    fn points_without_a_direction_face_the_origin() {
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
    fn two_lines_meet_where_they_should() {
        let ahead = moments(&[[1000, 0], [1000, 50]]).line();
        let left = moments(&[[0, 700], [50, 700]]).line();
        let corner = ahead.meet(&left).unwrap();
        assert_eq!((corner.x(), corner.y()), (16_000, 11_200));
        assert_eq!(ahead.meet(&ahead), None);
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
            // Nearly round clouds have no axis to agree on.
            let (wide, narrow) = ((scatter.xx - scatter.yy) as f64, 2.0 * scatter.xy as f64);
            if wide.hypot(narrow) > 1e-4 * (scatter.xx + scatter.yy) as f64 {
                let found = f64::from(line.before(FinePoint::default())) / 16.0;
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
