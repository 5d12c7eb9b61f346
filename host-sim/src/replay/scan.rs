//! A laser's scan in a log: metres and radians in, beams out.

use super::RecordedBeam;
use super::skipped::SkipReason;
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Missing, Reading};
use certainty_core::units::{BinaryAngle, Millimeters, Point, Ticks};
use core::f64::consts::TAU;
use core::num::NonZeroU8;

/// One scan: where the laser was, and the readings, still as text.
///
/// Possession proves that pose, time and directions are finite and the pose is within reach of a
/// map; the readings may be anything.
#[derive(Debug, Clone)]
pub(super) struct Scan<I> {
    pub(super) origin: Point,
    pub(super) heading_rad: f64,
    pub(super) time_s: f64,
    pub(super) directions: Directions,
    /// From here on the laser itself means *no echo*.
    pub(super) max_range_m: Option<f64>,
    pub(super) readings: I,
}

/// Where a scan's beams go, relative to the laser's heading: the first, and from each to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Directions {
    pub(super) start_rad: f64,
    pub(super) step_rad: f64,
}

impl<'a, I: Iterator<Item = &'a str>> Scan<I> {
    /// Appends the scan's beams, dealt to `sensors` virtual sensors in turn; all or none.
    pub(super) fn append(
        self,
        at: Ticks,
        sensors: NonZeroU8,
        max_range: Option<Millimeters>,
        beams: &mut Vec<RecordedBeam>,
    ) -> Result<(), SkipReason> {
        let before = beams.len();
        let own_limit_mm = self.max_range_m.map_or(f64::INFINITY, |m| m * 1000.0);
        let limit_mm = max_range.map_or(own_limit_mm, |mm| f64::from(mm.get()).min(own_limit_mm));
        for (index, token) in self.readings.enumerate() {
            let Ok(metres) = token.parse::<f64>() else {
                beams.truncate(before);
                return Err(SkipReason::NotANumber);
            };
            let aside = self
                .directions
                .step_rad
                .mul_add(index as f64, self.directions.start_rad);
            // Below 255, so the slot exists.
            let slot = index % usize::from(sensors.get());
            let Some(sensor) = SensorId::from_slot(slot) else {
                continue;
            };
            beams.push(RecordedBeam {
                at,
                sensor,
                origin: self.origin,
                bearing: angle_from_radians(self.heading_rad + aside),
                reading: reading_from_metres(metres, limit_mm),
            });
        }
        if beams.len() == before {
            return Err(SkipReason::NoReadings);
        }
        Ok(())
    }
}

/// What a laser's number means, in metres, if `limit_mm` and all beyond is *no echo*.
///
/// Rounds to the nearest millimetre. What is negative, not finite, or beyond any map's reach
/// though under the limit, is implausible; what rounds to zero is too near.
fn reading_from_metres(metres: f64, limit_mm: f64) -> Reading {
    let mm = metres * 1000.0;
    if !metres.is_finite() || mm < 0.0 {
        Reading::Missing(Missing::Implausible)
    } else if mm >= limit_mm {
        Reading::NoObject
    } else if mm > 2.0 * f64::from(Point::LIMIT) {
        Reading::Missing(Missing::Implausible)
    } else if mm < 0.5 {
        Reading::TooNear
    } else {
        Reading::Echo(Millimeters::new(mm.round() as u32))
    }
}

/// The angle of `radians`, any finite number of turns; rounds to the nearest step, ties up.
fn angle_from_radians(radians: f64) -> BinaryAngle {
    let steps = (radians.rem_euclid(TAU) / TAU * 65536.0 + 0.5).floor();
    // At most 65536, which is the full turn and wraps to zero.
    BinaryAngle::from_bits((steps as u32 & 0xFFFF) as u16)
}

/// The place at (`x_m`, `y_m`), to the nearest millimetre, if it is within [`Point::LIMIT`].
pub(super) fn point_from_metres(x_m: f64, y_m: f64) -> Result<Point, SkipReason> {
    if !(x_m.is_finite() && y_m.is_finite()) {
        return Err(SkipReason::BadPose);
    }
    let (x, y) = ((x_m * 1000.0).round(), (y_m * 1000.0).round());
    let limit = f64::from(Point::LIMIT);
    if x.abs() > limit || y.abs() > limit {
        return Err(SkipReason::OutOfReach);
    }
    Ok(Point::from_mm(x as i32, y as i32))
}

/// Parses a field that must be a finite number.
pub(super) fn finite(token: Option<&str>, otherwise: SkipReason) -> Result<f64, SkipReason> {
    let number: f64 = token
        .ok_or(SkipReason::FieldCount)?
        .parse()
        .map_err(|_| SkipReason::NotANumber)?;
    if number.is_finite() {
        Ok(number)
    } else {
        Err(otherwise)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reading_at_the_limit_is_no_object_and_just_below_an_echo() {
        assert_eq!(reading_from_metres(8.0, 8000.0), Reading::NoObject);
        assert_eq!(reading_from_metres(81.83, 8000.0), Reading::NoObject);
        assert_eq!(
            reading_from_metres(7.9994, 8000.0),
            Reading::Echo(Millimeters::new(7999))
        );
    }

    #[test]
    fn numbers_that_no_laser_measures_are_implausible() {
        let implausible = Reading::Missing(Missing::Implausible);
        for metres in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.001, -5.0] {
            assert_eq!(reading_from_metres(metres, 8000.0), implausible, "{metres}");
        }
        assert_eq!(reading_from_metres(1e300, f64::INFINITY), implausible);
        assert_eq!(reading_from_metres(1e300, 8000.0), Reading::NoObject);
    }

    #[test]
    fn zero_is_too_near_whatever_its_sign() {
        for metres in [0.0, -0.0, 0.0004] {
            assert_eq!(reading_from_metres(metres, 8000.0), Reading::TooNear);
        }
    }

    #[test]
    fn radians_round_to_the_nearest_step_over_any_number_of_turns() {
        for steps in (0..=u16::MAX).step_by(7) {
            let radians = f64::from(steps) / 65536.0 * TAU;
            for turns in [-3.0, 0.0, 1.0, 1000.0] {
                let angle = angle_from_radians(turns * TAU + radians);
                assert_eq!(angle, BinaryAngle::from_bits(steps), "{steps} {turns}");
            }
        }
        assert_eq!(angle_from_radians(-1e-9), BinaryAngle::ZERO);
        // Any finite angle is some angle.
        let _ = angle_from_radians(f64::MAX);
        let _ = angle_from_radians(f64::MIN);
    }
}
