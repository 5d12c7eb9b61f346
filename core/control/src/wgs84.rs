//! Places on the Earth: the bearing and the distance of a goal, \[004\] eq. 10.

use certainty_core::units::{BinaryAngle, Direction, Millimeters, Point, fine_sine_q30};
use core::fmt;

/// A place in WGS-84, as a satellite receiver reports it.
///
/// Possession proves that the latitude is within ±90° and the longitude within ±180°.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Wgs84 {
    latitude_e7: i32,
    longitude_e7: i32,
}

/// A latitude is beyond ±90°, or a longitude beyond ±180°.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Wgs84Error;

impl fmt::Display for Wgs84Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("not a place on the Earth: expected a latitude within ±90° and a longitude within ±180°")
    }
}

impl core::error::Error for Wgs84Error {}

/// A quarter turn in 10⁻⁷ of a degree.
const QUARTER_E7: i32 = 900_000_000;

/// A whole turn in 10⁻⁷ of a degree.
const TURN_E7: i64 = 3_600_000_000;

/// 10⁻⁷ of a degree on a sphere with the Earth's mean radius, 6,371,008.8 m, in picometres.
const STEP_PM: i128 = 11_119_507_973;

impl Wgs84 {
    /// Creates the place at a latitude and a longitude in 10⁻⁷ of a degree, north and east positive.
    ///
    /// # Errors
    ///
    /// [`Wgs84Error`] beyond ±90° and ±180°.
    pub const fn try_new(latitude_e7: i32, longitude_e7: i32) -> Result<Self, Wgs84Error> {
        let is_on_earth = latitude_e7.unsigned_abs() <= QUARTER_E7.unsigned_abs()
            && longitude_e7.unsigned_abs() <= QUARTER_E7.unsigned_abs() << 1;
        if is_on_earth {
            Ok(Self {
                latitude_e7,
                longitude_e7,
            })
        } else {
            Err(Wgs84Error)
        }
    }

    /// Returns the azimuth of `goal`: clockwise from north, as a compass shows it; `None` if the goal has no
    /// direction: it is the same place (to a step of the angles, 9 mm), or exactly on the other side.
    ///
    /// Formula (\[004\] eq. 10): atan2(sin ΔL cos B₂, cos B₁ sin B₂ − sin B₁ cos B₂ cos ΔL). Computed as
    /// sin(B₂ − B₁) + 2 sin B₁ cos B₂ sin²(ΔL/2), which is equal: as printed, two numbers near
    /// one half are subtracted to find 10⁻⁵, which leaves nothing of a bearing a hundred metres away.
    ///
    /// Units: nearest 1/65536 of a turn; off by at most 0.1° from 10 m on, 0.01° from 100 m on. It is
    /// the bearing on a sphere, as in \[004\].
    ///
    /// ```
    /// use certainty_control::Wgs84;
    /// use certainty_core::units::BinaryAngle;
    ///
    /// let equator = Wgs84::try_new(0, 0)?;
    /// let east = Wgs84::try_new(0, 10_000)?;
    /// assert_eq!(equator.azimuth(east), Some(BinaryAngle::QUARTER));
    /// # Ok::<(), certainty_control::Wgs84Error>(())
    /// ```
    #[must_use]
    pub fn azimuth(self, goal: Self) -> Option<BinaryAngle> {
        const TURN_QUARTER: u32 = 1 << 30;
        let (from, to) = (fine(self.latitude_e7), fine(goal.latitude_e7));
        let east = fine(goal.longitude_e7).wrapping_sub(fine(self.longitude_e7));
        let cos_to = fine_sine_q30(to.wrapping_add(TURN_QUARTER));
        // Half of the short way round.
        let half_east = (east.cast_signed() / 2).cast_unsigned();
        let half_sine = fine_sine_q30(half_east);
        let bulge = product(
            product(fine_sine_q30(from), cos_to),
            product(half_sine, half_sine),
        );
        let north =
            i64::from(fine_sine_q30(to.wrapping_sub(from))).wrapping_add(i64::from(bulge) << 1);
        let aside = product(fine_sine_q30(east), cos_to);
        // North is where x points, east where y does: clockwise.
        BinaryAngle::towards(saturating_i32(north), aside)
    }

    /// Returns the direction of `goal` counter-clockwise from east, which is how the rest of this crate
    /// counts.
    #[must_use]
    pub fn bearing(self, goal: Self) -> Option<BinaryAngle> {
        let azimuth = self.azimuth(goal)?;
        Some(BinaryAngle::QUARTER - azimuth)
    }

    /// Returns the distance to `goal`; saturates.
    ///
    /// Formula: that in the plane, with degrees of longitude as long as half way between the two latitudes.
    /// Rounds down to whole millimetres. Off by less than 0.1 % of the distance on the sphere, up to 100 km and
    /// a latitude of 80°.
    #[must_use]
    pub fn distance(self, goal: Self) -> Millimeters {
        let north = i64::from(goal.latitude_e7).saturating_sub(self.latitude_e7.into());
        let east = i64::from(goal.longitude_e7).saturating_sub(self.longitude_e7.into());
        // The short way round.
        let east = if east > TURN_E7 / 2 {
            east.saturating_sub(TURN_E7)
        } else if east < -(TURN_E7 / 2) {
            east.saturating_add(TURN_E7)
        } else {
            east
        };
        let twice = i64::from(self.latitude_e7).saturating_add(goal.latitude_e7.into());
        let middle = i32::try_from(twice / 2).unwrap_or(0);
        let cos = fine_sine_q30(fine(middle).wrapping_add(1 << 30));
        // In micrometres: 32 bits times 34, and 31 more for the east.
        let north = i128::from(north).saturating_mul(STEP_PM) / 1_000_000;
        let east = i128::from(east).saturating_mul(STEP_PM) / 1_000_000;
        let east = east.saturating_mul(cos.into()) >> Direction::FRACTION_BITS;
        let square = north
            .saturating_mul(north)
            .saturating_add(east.saturating_mul(east));
        let mm = square.unsigned_abs().isqrt() / 1000;
        Millimeters::from_saturating(u64::try_from(mm).unwrap_or(u64::MAX))
    }

    /// Returns the place of `goal` in a plane with this place as its origin, x to the east and y to the north;
    /// `None` if it is farther away than [`Point::LIMIT`].
    ///
    /// It lies in the direction of [`Self::bearing`] at [`Self::distance`], so it is off by 5 mm at 100 m.
    ///
    /// ```
    /// use certainty_control::Wgs84;
    ///
    /// let start = Wgs84::try_new(521_000_000, 210_000_000)?;
    /// let goal = Wgs84::try_new(521_000_900, 210_000_000)?;
    /// let goal = start.local(goal).ok_or("too far")?;
    /// assert_eq!((goal.x_mm(), goal.y_mm()), (0, 10_007));
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    #[must_use]
    pub fn local(self, goal: Self) -> Option<Point> {
        let distance = self.distance(goal);
        if distance.get() > Point::LIMIT.unsigned_abs() {
            return None;
        }
        Some(match self.bearing(goal) {
            Some(bearing) => Point::ORIGIN.ahead(bearing.direction(), distance),
            None => Point::ORIGIN,
        })
    }
}

/// 10⁻⁷ of a degree in 2^-32 of a turn, rounded to the nearest.
fn fine(degrees_e7: i32) -> u32 {
    let wide = i64::from(degrees_e7) << 32;
    let steps = wide.saturating_add(TURN_E7 / 2).div_euclid(TURN_E7);
    // Modulo a turn.
    let [a, b, c, d, ..] = steps.to_le_bytes();
    u32::from_le_bytes([a, b, c, d])
}

/// The product of two parts of unit vectors, rounded to the nearest, ties up.
fn product(a: i32, b: i32) -> i32 {
    let wide = i64::from(a).wrapping_mul(b.into());
    saturating_i32(
        wide.wrapping_add(1 << (Direction::FRACTION_BITS - 1)) >> Direction::FRACTION_BITS,
    )
}

fn saturating_i32(wide: i64) -> i32 {
    i32::try_from(wide).unwrap_or(if wide < 0 { i32::MIN } else { i32::MAX })
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;
    use proptest::prelude::*;

    fn place(latitude: f64, longitude: f64) -> Wgs84 {
        Wgs84::try_new(
            (latitude * 1e7).round() as i32,
            (longitude * 1e7).round() as i32,
        )
        .unwrap()
    }

    /// Degrees of the azimuth.
    fn azimuth(from: Wgs84, to: Wgs84) -> f64 {
        f64::from(from.azimuth(to).unwrap().to_bits()) / 65536.0 * 360.0
    }

    /// Eq. 10 as it is printed, in real numbers.
    fn printed(from: Wgs84, to: Wgs84) -> f64 {
        let radians = |e7: i32| (f64::from(e7) / 1e7).to_radians();
        let (b1, b2) = (radians(from.latitude_e7), radians(to.latitude_e7));
        let east = radians(to.longitude_e7) - radians(from.longitude_e7);
        let y = east.sin() * b2.cos();
        let x = b1.cos() * b2.sin() - b1.sin() * b2.cos() * east.cos();
        y.atan2(x).rem_euclid(TAU).to_degrees()
    }

    fn apart(a: f64, b: f64) -> f64 {
        let difference = (a - b).rem_euclid(360.0);
        difference.min(360.0 - difference)
    }

    #[test]
    fn the_four_winds() {
        let home = place(52.0, 21.0);
        for (to, expected) in [
            (place(52.001, 21.0), 0.0),
            (place(52.0, 21.001), 90.0),
            (place(51.999, 21.0), 180.0),
            (place(52.0, 20.999), 270.0),
        ] {
            assert!(apart(azimuth(home, to), expected) < 0.01);
        }
        assert_eq!(home.azimuth(home), None);
        assert_eq!(
            home.bearing(place(52.001, 21.0)),
            Some(BinaryAngle::QUARTER)
        );
    }

    /// By hand: from Baghdad (35° N, 45° E) to Osaka (35° N, 135° E) the bearing is
    /// atan2(cos 35°, cos 35° sin 35°) = atan(1 / sin 35°) = 60.16°.
    #[test]
    fn eq_10_by_hand() {
        let bearing = azimuth(place(35.0, 45.0), place(35.0, 135.0));
        assert!((bearing - 60.16).abs() < 0.01, "{bearing}");
    }

    #[test]
    fn across_the_date_line_is_the_short_way() {
        let bearing = azimuth(place(0.0, 179.9999), place(0.0, -179.9999));
        assert!((bearing - 90.0).abs() < 0.01, "{bearing}");
    }

    #[test]
    fn places_not_on_the_earth_are_refused() {
        assert_eq!(Wgs84::try_new(QUARTER_E7 + 1, 0), Err(Wgs84Error));
        assert_eq!(Wgs84::try_new(0, 2 * QUARTER_E7 + 1), Err(Wgs84Error));
        assert!(Wgs84::try_new(-QUARTER_E7, -2 * QUARTER_E7).is_ok());
        assert_eq!(Wgs84::try_new(i32::MIN, i32::MIN), Err(Wgs84Error));
    }

    proptest! {
        #[test]
        fn a_bearing_near_by_is_eq_10_to_a_tenth_degree(
            latitude in -80.0..80.0_f64, longitude in -180.0..179.0_f64,
            turn in 0.0..TAU, metres in 10.0..1000.0_f64,
        ) {
            let degrees = metres / 111_320.0;
            let from = place(latitude, longitude);
            let to = place(
                latitude + degrees * turn.cos(),
                longitude + degrees * turn.sin() / latitude.to_radians().cos(),
            );
            let allowed = if metres < 100.0 { 0.1 } else { 0.0125 };
            prop_assert!(apart(azimuth(from, to), printed(from, to)) < allowed);
        }

        /// Against the distance on the sphere (haversine), in real numbers.
        #[test]
        fn a_distance_near_by_is_that_on_the_sphere(
            latitude in -80.0..80.0_f64, longitude in -180.0..180.0_f64,
            turn in 0.0..TAU, metres in 10.0..100_000.0_f64,
        ) {
            let degrees = metres / 111_320.0;
            let from = place(latitude, longitude);
            let east = degrees * turn.sin() / latitude.to_radians().cos();
            let to = place(
                latitude + degrees * turn.cos(),
                (longitude + east + 540.0).rem_euclid(360.0) - 180.0,
            );
            let radians = |e7: i32| (f64::from(e7) / 1e7).to_radians();
            let (b1, b2) = (radians(from.latitude_e7), radians(to.latitude_e7));
            let half = |angle: f64| (angle / 2.0).sin().powi(2);
            let east = radians(to.longitude_e7) - radians(from.longitude_e7);
            let sphere = half(b2 - b1) + b1.cos() * b2.cos() * half(east);
            let expected = 2.0 * 6_371_008.8 * sphere.sqrt().asin();
            let ours = f64::from(from.distance(to).get()) / 1000.0;
            prop_assert!((ours - expected).abs() < 0.002 + expected * 0.001, "{ours} {expected}");
        }

        #[test]
        fn a_local_place_has_the_bearing_and_the_distance(
            latitude in -80.0..80.0_f64, longitude in -170.0..170.0_f64,
            east in -1e-3..1e-3_f64, north in -1e-3..1e-3_f64,
        ) {
            let (from, to) = (place(latitude, longitude), place(latitude + north, longitude + east));
            let local = from.local(to).unwrap();
            let distance = from.distance(to).get();
            prop_assert!(local.distance(Point::ORIGIN).get().abs_diff(distance) <= 2);
            prop_assume!(distance > 10_000);
            let off = Point::ORIGIN.bearing(local).unwrap().separation(from.bearing(to).unwrap());
            prop_assert!(off.to_bits() <= 8, "{off:?}");
        }

        #[test]
        fn a_bearing_anywhere_is_eq_10(
            a in -89.0..89.0_f64, b in -180.0..180.0_f64, c in -89.0..89.0_f64, d in -180.0..180.0_f64,
        ) {
            let (from, to) = (place(a, b), place(c, d));
            // Near the same and the opposite place the direction is ill-conditioned.
            let off = (a - c).abs() + (b - d).abs();
            let opposite = (a + c).abs() + ((b - d).abs() - 180.0).abs();
            prop_assume!(off > 0.1 && opposite > 0.1);
            prop_assert!(apart(azimuth(from, to), printed(from, to)) < 0.01);
        }
    }
}
