//! The bearing of a place on the Earth: \[004\] eq. 10.

use certainty_core::narrow::{saturating_i32, wrapping_u32};
use certainty_core::units::{BinaryAngle, Direction, fine_sine_q30};

/// A place in WGS-84, as a receiver reports it.
///
/// Possession proves that the latitude is within ±90° and the longitude within ±180°.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Wgs84 {
    latitude_e7: i32,
    longitude_e7: i32,
}

/// A quarter turn in 10⁻⁷ of a degree.
const QUARTER_E7: i32 = 900_000_000;

impl Wgs84 {
    /// Creates the place at a latitude and a longitude in 10⁻⁷ of a degree, north and east positive;
    /// `None` beyond ±90° and ±180°.
    #[must_use]
    pub const fn try_new(latitude_e7: i32, longitude_e7: i32) -> Option<Self> {
        let on_earth = latitude_e7.unsigned_abs() <= QUARTER_E7.unsigned_abs()
            && longitude_e7.unsigned_abs() <= QUARTER_E7.unsigned_abs() << 1;
        if on_earth {
            Some(Self {
                latitude_e7,
                longitude_e7,
            })
        } else {
            None
        }
    }

    /// Returns the azimuth of `goal`: clockwise from north, as a compass shows it; `None` where no
    /// direction leads there (it is here, or so near that a step of the angles, 9 mm, hides it, or
    /// exactly on the other side).
    ///
    /// Formula (\[004\] eq. 10): atan2(sin ΔL cos B₂, cos B₁ sin B₂ − sin B₁ cos B₂ cos ΔL). Computed as
    /// sin(B₂ − B₁) + 2 sin B₁ cos B₂ sin²(ΔL/2), the same by a theorem: as printed, two numbers near
    /// one half are subtracted to find 10⁻⁵, which leaves nothing of a bearing a hundred metres away.
    ///
    /// Units: nearest 1/65536 of a turn; off by at most 0.1° from 10 m on, 0.01° from 100 m on. It is
    /// the bearing on a sphere, as in \[004\].
    ///
    /// ```
    /// use certainty_control::Wgs84;
    /// use certainty_core::units::BinaryAngle;
    ///
    /// let equator = Wgs84::try_new(0, 0).ok_or("beyond")?;
    /// let east = Wgs84::try_new(0, 10_000).ok_or("beyond")?;
    /// assert_eq!(equator.azimuth(east), Some(BinaryAngle::QUARTER));
    /// # Ok::<(), &str>(())
    /// ```
    #[must_use]
    pub const fn azimuth(self, goal: Self) -> Option<BinaryAngle> {
        const TURN_QUARTER: u32 = 1 << 30;
        let (from, to) = (fine(self.latitude_e7), fine(goal.latitude_e7));
        let east = fine(goal.longitude_e7).wrapping_sub(fine(self.longitude_e7));
        let cos_to = fine_sine_q30(to.wrapping_add(TURN_QUARTER));
        // Half of the short way round.
        let half_east = wrapping_u32((east.cast_signed() / 2) as i64);
        let half_sine = fine_sine_q30(half_east);
        let bulge = product(
            product(fine_sine_q30(from), cos_to),
            product(half_sine, half_sine),
        );
        let north = (fine_sine_q30(to.wrapping_sub(from)) as i64).wrapping_add((bulge as i64) << 1);
        let aside = product(fine_sine_q30(east), cos_to);
        // North is where x points, east where y does: clockwise.
        BinaryAngle::towards(saturating_i32(north), aside)
    }

    /// Returns the direction of `goal` counter-clockwise from east, which is what the rest of this
    /// crate counts in.
    #[must_use]
    pub const fn bearing(self, goal: Self) -> Option<BinaryAngle> {
        match self.azimuth(goal) {
            Some(azimuth) => Some(BinaryAngle::QUARTER.wrapping_sub(azimuth)),
            None => None,
        }
    }
}

/// 10⁻⁷ of a degree in 2^-32 of a turn, rounded to the nearest.
const fn fine(degrees_e7: i32) -> u32 {
    const TURN_E7: i64 = 3_600_000_000;
    let wide = (degrees_e7 as i64) << 32;
    wrapping_u32(wide.wrapping_add(TURN_E7 / 2).div_euclid(TURN_E7))
}

/// The product of two parts of unit vectors, rounded to the nearest, ties up.
const fn product(a: i32, b: i32) -> i32 {
    let wide = (a as i64).wrapping_mul(b as i64);
    saturating_i32(
        wide.wrapping_add(1 << (Direction::FRACTION_BITS - 1)) >> Direction::FRACTION_BITS,
    )
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
    fn what_is_not_on_earth_is_refused() {
        assert_eq!(Wgs84::try_new(QUARTER_E7 + 1, 0), None);
        assert_eq!(Wgs84::try_new(0, 2 * QUARTER_E7 + 1), None);
        assert!(Wgs84::try_new(-QUARTER_E7, -2 * QUARTER_E7).is_some());
        assert_eq!(Wgs84::try_new(i32::MIN, i32::MIN), None);
    }

    proptest! {
        #[test]
        fn a_bearing_near_by_is_eq_10_within_a_tenth_of_a_degree(
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

        #[test]
        fn a_bearing_anywhere_is_eq_10(
            a in -89.0..89.0_f64, b in -180.0..180.0_f64, c in -89.0..89.0_f64, d in -180.0..180.0_f64,
        ) {
            let (from, to) = (place(a, b), place(c, d));
            // Near the same and the opposite place every direction is as good as another.
            let off = (a - c).abs() + (b - d).abs();
            let opposite = (a + c).abs() + ((b - d).abs() - 180.0).abs();
            prop_assume!(off > 0.1 && opposite > 0.1);
            prop_assert!(apart(azimuth(from, to), printed(from, to)) < 0.01);
        }
    }
}
