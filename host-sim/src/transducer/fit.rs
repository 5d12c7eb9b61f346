//! Finding the characteristic raw ≈ a / (d + b) + c of a unit from measured points.
//!
//! A [`Calibration`] holds b in whole millimetres, so that is where the fit looks for it: every b
//! from 0 to [`MOST_OFFSET`] is tried, and a and c are the linear least squares for that b. Nothing
//! is iterated, so nothing fails to converge, and the same points give the same bits. Half a
//! millimetre of b, compensated by a and c, moves the curve by a ninth of a count at most.

use super::characteristic::CurvePoint;
use certainty_core::transducer::{Calibration, CalibrationError};
use certainty_core::units::Millimeters;
use thiserror::Error;

/// Largest offset b that is tried, in millimetres; the sixteen shipped units need 2 to 21.
pub const MOST_OFFSET: u32 = 500;

/// A fitted characteristic raw ≈ a / (d + b) + c, and how well it fits.
///
/// Possession proves that every number is finite and that a is positive: the byte falls with
/// distance, as a GP2D02's does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    slope: f64,
    offset: Millimeters,
    floor: f64,
    rms: f64,
    worst: f64,
}

/// Why points have no characteristic, or a characteristic no calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum FitError {
    /// Three parameters need three distances.
    #[error("a characteristic needs points at three distances or more")]
    TooFewPoints,
    /// A distance or a byte is no finite number, or a distance is not above zero.
    #[error("a point's distance must be above 0mm and its byte a finite number")]
    BadPoint,
    /// The byte does not fall with distance.
    #[error("the byte must fall with distance")]
    NotFalling,
    /// The floor c is not a byte.
    #[error("the byte for no object at all must be within 0..=255")]
    Floor,
    /// The core refused the parameters.
    #[error("{0}")]
    Calibration(CalibrationError),
}

impl Fit {
    /// Fits a characteristic through `points`, least squares in counts.
    ///
    /// ```
    /// use certainty_sim::transducer::{CurvePoint, Fit};
    ///
    /// let exact = [100, 200, 400, 800].map(|mm| {
    ///     let distance_mm = f64::from(mm);
    ///     CurvePoint { distance_mm, raw: 13_000.0 / (distance_mm + 10.0) + 60.0 }
    /// });
    /// let fit = Fit::through(&exact)?;
    /// assert_eq!(fit.offset().get(), 10);
    /// assert!((fit.slope() - 13_000.0).abs() < 1e-3 && fit.rms() < 1e-6);
    /// # Ok::<(), certainty_sim::transducer::FitError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`FitError`] tells what the points lack.
    pub fn through(points: &[CurvePoint]) -> Result<Self, FitError> {
        if !points
            .iter()
            .all(|p| p.raw.is_finite() && p.distance_mm.is_finite() && p.distance_mm > 0.0)
        {
            return Err(FitError::BadPoint);
        }
        let mut distances: Vec<f64> = points.iter().map(|p| p.distance_mm).collect();
        distances.sort_by(f64::total_cmp);
        distances.dedup();
        if distances.len() < 3 {
            return Err(FitError::TooFewPoints);
        }
        let best = (0..=MOST_OFFSET)
            .map(|offset| Self::at_offset(points, offset))
            .min_by(|a, b| a.rms.total_cmp(&b.rms))
            .ok_or(FitError::TooFewPoints)?;
        if best.slope > 0.0 && best.rms.is_finite() {
            Ok(best)
        } else {
            Err(FitError::NotFalling)
        }
    }

    /// The linear least squares of raw over 1 / (d + `offset`).
    fn at_offset(points: &[CurvePoint], offset: u32) -> Self {
        let inverse = |p: &CurvePoint| 1.0 / (p.distance_mm + f64::from(offset));
        let count = points.len() as f64;
        let mean_x = points.iter().map(inverse).sum::<f64>() / count;
        let mean_y = points.iter().map(|p| p.raw).sum::<f64>() / count;
        let (mut xx, mut xy) = (0.0, 0.0);
        for p in points {
            let x = inverse(p) - mean_x;
            xx += x * x;
            xy += x * (p.raw - mean_y);
        }
        let slope = xy / xx;
        let floor = mean_y - slope * mean_x;
        let (mut squares, mut worst) = (0.0, 0.0_f64);
        for p in points {
            let error = slope * inverse(p) + floor - p.raw;
            squares += error * error;
            worst = worst.max(error.abs());
        }
        Self {
            slope,
            offset: Millimeters::new(offset),
            floor,
            rms: (squares / count).sqrt(),
            worst,
        }
    }

    /// Returns a, in count-millimetres.
    #[must_use]
    pub const fn slope(&self) -> f64 {
        self.slope
    }

    /// Returns b.
    #[must_use]
    pub const fn offset(&self) -> Millimeters {
        self.offset
    }

    /// Returns c, in counts: what the byte tends to where nothing reflects.
    #[must_use]
    pub const fn floor(&self) -> f64 {
        self.floor
    }

    /// Returns the root of the mean squared error, in counts.
    #[must_use]
    pub const fn rms(&self) -> f64 {
        self.rms
    }

    /// Returns the largest error, in counts.
    #[must_use]
    pub const fn worst(&self) -> f64 {
        self.worst
    }

    /// Returns the fitted byte at `distance_mm`, in counts.
    #[must_use]
    pub fn raw(&self, distance_mm: f64) -> f64 {
        self.slope / (distance_mm + f64::from(self.offset.get())) + self.floor
    }

    /// Returns the calibration a driver uses for this unit, from `nearest` to `farthest`.
    ///
    /// Rounds a to whole count-millimetres and c to 1/256 count: together below 0.02 counts.
    ///
    /// # Errors
    ///
    /// [`FitError::Floor`] where c is no byte, [`FitError::Calibration`] where the core refuses.
    pub fn calibration(
        &self,
        nearest: Millimeters,
        farthest: Millimeters,
    ) -> Result<Calibration, FitError> {
        // Decimal text is the way into a fixed-point type that needs no name for it: rounded to the
        // nearest 1/256, and refused where it does not fit.
        let floor = format!("{:.6}", self.floor)
            .parse()
            .map_err(|_| FitError::Floor)?;
        // Saturates; beyond Calibration::MAX_SLOPE the core refuses.
        let slope = self.slope.round() as u32;
        Calibration::try_new(slope, self.offset, floor, nearest, farthest)
            .map_err(FitError::Calibration)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const fn mm(mm: u32) -> Millimeters {
        Millimeters::new(mm)
    }

    fn curve(slope: f64, offset: f64, floor: f64) -> Vec<CurvePoint> {
        (10..=80)
            .step_by(5)
            .map(|cm| {
                let distance_mm = f64::from(cm) * 10.0;
                CurvePoint {
                    distance_mm,
                    raw: slope / (distance_mm + offset) + floor,
                }
            })
            .collect()
    }

    proptest! {
        #[test]
        fn exact_points_give_their_own_parameters(
            slope in 5_000.0..40_000.0_f64,
            offset in 0..100_u32,
            floor in 0.0..150.0_f64,
        ) {
            let fit = Fit::through(&curve(slope, f64::from(offset), floor)).unwrap();
            prop_assert_eq!(fit.offset(), mm(offset));
            prop_assert!((fit.slope() - slope).abs() < 1e-4, "{}", fit.slope());
            prop_assert!((fit.floor() - floor).abs() < 1e-6, "{}", fit.floor());
            prop_assert!(fit.worst() < 1e-6);
        }

        #[test]
        fn an_offset_between_millimetres_costs_a_ninth_of_a_count_at_most(
            offset in 0.0..100.0_f64,
        ) {
            let fit = Fit::through(&curve(16_000.0, offset, 60.0)).unwrap();
            prop_assert!(fit.worst() < 0.12, "{}", fit.worst());
        }

        #[test]
        fn no_points_panic(points in prop::collection::vec((any::<f64>(), any::<f64>()), 0..6)) {
            let points: Vec<_> = points
                .into_iter()
                .map(|(distance_mm, raw)| CurvePoint { distance_mm, raw })
                .collect();
            if let Ok(fit) = Fit::through(&points) {
                prop_assert!(fit.slope() > 0.0 && fit.rms().is_finite());
                let _: Result<Calibration, FitError> = fit.calibration(mm(100), mm(800));
            }
        }
    }

    #[test]
    fn the_calibration_undoes_the_curve_to_a_millimetre() {
        let calibration = Fit::through(&curve(16_000.0, 12.0, 45.0))
            .unwrap()
            .calibration(mm(100), mm(800))
            .unwrap();
        for raw in 66..=180_u8 {
            let exact = 16_000.0 / (f64::from(raw) - 45.0) - 12.0;
            let certainty_core::transducer::Reading::Echo(read) = calibration.reading(raw) else {
                panic!("no echo at raw {raw}");
            };
            // A floor that is 1/512 count off is worth 0.1 mm per count-millimetre at the far end.
            assert!((f64::from(read.get()) - exact).abs() < 1.1, "raw {raw}");
        }
    }

    #[test]
    fn what_has_no_characteristic_is_refused() {
        let point = |distance_mm, raw| CurvePoint { distance_mm, raw };
        let twice = [point(100.0, 190.0), point(100.0, 191.0), point(800.0, 75.0)];
        assert_eq!(Fit::through(&twice), Err(FitError::TooFewPoints));
        let infinite = [
            point(100.0, f64::INFINITY),
            point(200.0, 1.0),
            point(300.0, 0.0),
        ];
        assert_eq!(Fit::through(&infinite), Err(FitError::BadPoint));
        let rising = [point(100.0, 10.0), point(200.0, 20.0), point(400.0, 25.0)];
        assert_eq!(Fit::through(&rising), Err(FitError::NotFalling));
        let sunken = Fit::through(&curve(16_000.0, 12.0, -20.0)).unwrap();
        assert_eq!(sunken.calibration(mm(100), mm(800)), Err(FitError::Floor));
        let sound = Fit::through(&curve(16_000.0, 12.0, 20.0)).unwrap();
        assert_eq!(
            sound.calibration(mm(800), mm(100)),
            Err(FitError::Calibration(CalibrationError::EmptyRange))
        );
    }
}
