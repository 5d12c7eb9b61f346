//! The characteristic of a GP2D02: its byte as a function of distance.
//!
//! The measured points of a real unit, joined by straight lines. Before the first and after the
//! last point the curve is a model:
//!
//! - *Nearer* the spot leaves the detector and the byte falls again (\[001\] §6.1 gives 10 cm as the
//!   least distance): a straight line from the first point down to the floor at 0 mm. So a near
//!   object gives the same bytes as a far one, which makes short distances ambiguous.
//! - *Farther* the byte tends to the floor c of the fitted characteristic (see [`Fit`]), along a
//!   hyperbola that joins the last point: `c + (raw − c) · (last + b) / (d + b)`.
//!
//! [`Fit`] finds raw ≈ a / (d + b) + c from measured points. A [`Calibration`] holds b in whole millimetres, so
//! the fit tries every b from 0 to 500 mm, with a and c as the linear least squares for that b. It does not
//! iterate, so it always ends, and the same points give the same bits. Half a millimetre of b, compensated by
//! a and c, moves the curve by at most a ninth of a count.

use certainty_core::transducer::{Calibration, CalibrationError};
use certainty_core::units::Millimeters;
use certainty_firmware::smart_car::{FARTHEST, NEAREST};
use thiserror::Error;

/// One measured point of a characteristic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// The distance, in millimetres.
    pub distance_mm: f64,
    /// The byte at that distance, in counts; a mean of several need not be whole.
    pub raw: f64,
}

/// Largest offset b that is tried, in millimetres; the sixteen shipped units need 2 to 21.
const MOST_OFFSET: u32 = 500;

/// A fitted characteristic raw ≈ a / (d + b) + c, and its errors.
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
    /// A distance or a byte is not finite, or a distance is not above zero.
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
    /// [`FitError`] for points without a characteristic.
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

    /// Returns c, in counts: the limit of the byte where nothing reflects.
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

    /// Returns the distance at which the fit has `raw` counts, in millimetres; infinite for the floor
    /// and below.
    #[must_use]
    pub fn distance_mm(&self, raw: f64) -> f64 {
        let signal = raw - self.floor;
        if signal > 0.0 {
            self.slope / signal - f64::from(self.offset.get())
        } else {
            f64::INFINITY
        }
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
        // Parsing decimal text converts to the fixed-point type without naming it: rounded to the
        // nearest 1/256, and an error where it does not fit.
        let floor = format!("{:.6}", self.floor)
            .parse()
            .map_err(|_| FitError::Floor)?;
        // Saturates; beyond Calibration::MAX_SLOPE the core refuses.
        let slope = self.slope.round() as u32;
        Calibration::try_new(slope, self.offset, floor, nearest, farthest)
            .map_err(FitError::Calibration)
    }
}

/// The curve raw(d) of one unit.
///
/// Possession proves that it has three points or more, at ascending distances above 0 mm, their
/// bytes within 0..=255.
#[derive(Debug, Clone, PartialEq)]
pub struct Characteristic {
    points: Vec<CurvePoint>,
    fit: Fit,
}

/// Why there is no curve through points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum CurveError {
    /// The distances do not ascend.
    #[error("the distances of a characteristic must ascend")]
    NotAscending,
    /// A byte is outside 0..=255.
    #[error("the bytes of a characteristic must be within 0..=255")]
    NoByte,
    /// The points within the range of a GP2D02 have no fit.
    #[error("{0}")]
    Fit(FitError),
}

impl Characteristic {
    /// Creates the curve through `points`; its fit is over those from 100 mm to 800 mm, the range
    /// of a GP2D02.
    ///
    /// # Errors
    ///
    /// [`CurveError`] for points that no curve goes through.
    pub fn through(points: Vec<CurvePoint>) -> Result<Self, CurveError> {
        if !points.is_sorted_by(|a, b| a.distance_mm < b.distance_mm)
            || points.iter().any(|p| p.distance_mm <= 0.0)
        {
            return Err(CurveError::NotAscending);
        }
        if points.iter().any(|p| !(0.0..=255.0).contains(&p.raw)) {
            return Err(CurveError::NoByte);
        }
        let range = f64::from(NEAREST.get())..=f64::from(FARTHEST.get());
        let within: Vec<_> = points
            .iter()
            .copied()
            .filter(|p| range.contains(&p.distance_mm))
            .collect();
        let fit = Fit::through(&within).map_err(CurveError::Fit)?;
        Ok(Self { points, fit })
    }

    /// Returns the fitted characteristic over 100 mm to 800 mm.
    #[must_use]
    pub const fn fit(&self) -> &Fit {
        &self.fit
    }

    /// Returns the measured points, by ascending distance.
    #[must_use]
    pub fn points(&self) -> &[CurvePoint] {
        &self.points
    }

    /// Returns the limit of the byte where nothing reflects, in counts within `0.0..=255.0`.
    #[must_use]
    pub const fn no_object_raw(&self) -> f64 {
        self.fit.floor().clamp(0.0, 255.0)
    }

    /// Returns the byte at `distance_mm` before rounding, in counts within `0.0..=255.0`.
    ///
    /// A negative distance counts as 0, NaN as infinitely far.
    #[must_use]
    pub fn raw(&self, distance_mm: f64) -> f64 {
        let floor = self.no_object_raw();
        let (Some(first), Some(last)) = (self.points.first(), self.points.last()) else {
            return floor;
        };
        if distance_mm < first.distance_mm {
            let part = distance_mm.max(0.0) / first.distance_mm;
            return floor + (first.raw - floor) * part;
        }
        // The first point that is farther; NaN is beyond all of them.
        let Some(next) = self.points.iter().position(|p| distance_mm < p.distance_mm) else {
            let offset = f64::from(self.fit.offset().get());
            let part = (last.distance_mm + offset) / (distance_mm + offset);
            // NaN falls to 0 here: infinitely far.
            return floor + (last.raw - floor) * part.max(0.0);
        };
        let (near, far) = (self.points[next - 1], self.points[next]);
        let part = (distance_mm - near.distance_mm) / (far.distance_mm - near.distance_mm);
        near.raw + (far.raw - near.raw) * part
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
        fn a_fractional_offset_costs_a_ninth_of_a_count(
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
    fn the_calibration_inverts_the_curve() {
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
    fn points_without_a_characteristic_are_refused() {
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

    fn typical() -> Characteristic {
        // The bytes of [001]'s sensor family at 10, 20, 40 and 80 cm.
        let points = [(100.0, 190.0), (200.0, 135.0), (400.0, 95.0), (800.0, 75.0)]
            .map(|(distance_mm, raw)| CurvePoint { distance_mm, raw });
        Characteristic::through(points.to_vec()).unwrap()
    }

    #[test]
    fn the_curve_is_straight_between_its_points() {
        let curve = typical();
        for point in curve.points() {
            assert!((curve.raw(point.distance_mm) - point.raw).abs() < 1e-12);
        }
        assert!((curve.raw(300.0) - 115.0).abs() < 1e-12);
    }

    #[test]
    fn below_the_first_point_the_byte_folds_back() {
        let curve = typical();
        assert!(curve.raw(50.0) < curve.raw(100.0) - 30.0);
        assert!((curve.raw(0.0) - curve.no_object_raw()).abs() < 1e-12);
        assert_eq!(curve.raw(-5.0).to_bits(), curve.raw(0.0).to_bits());
        // Ambiguous: some near distance gives the byte of 400 mm.
        assert!((0..100).any(|mm| (curve.raw(f64::from(mm)) - 95.0).abs() < 1.0));
    }

    #[test]
    fn beyond_the_last_point_the_byte_tends_to_the_floor() {
        let curve = typical();
        let mut before = curve.raw(800.0);
        for mm in [801.0, 900.0, 2000.0, 1e6] {
            let here = curve.raw(mm);
            assert!(here < before && here > curve.no_object_raw(), "at {mm}");
            before = here;
        }
        assert!((curve.raw(f64::INFINITY) - curve.no_object_raw()).abs() < 1e-12);
        assert!((curve.raw(f64::NAN) - curve.no_object_raw()).abs() < 1e-12);
    }

    #[test]
    fn points_out_of_order_are_refused() {
        let point = |distance_mm, raw| CurvePoint { distance_mm, raw };
        let good = [point(100.0, 190.0), point(200.0, 135.0), point(400.0, 95.0)];
        let mut swapped = good.to_vec();
        swapped.swap(0, 1);
        assert_eq!(
            Characteristic::through(swapped),
            Err(CurveError::NotAscending)
        );
        let mut loud = good.to_vec();
        loud[0].raw = 256.0;
        assert_eq!(Characteristic::through(loud), Err(CurveError::NoByte));
        let nan = vec![good[0], point(f64::NAN, 1.0), good[2]];
        assert_eq!(Characteristic::through(nan), Err(CurveError::NotAscending));
        let few = Characteristic::through(good[..2].to_vec());
        assert_eq!(few, Err(CurveError::Fit(FitError::TooFewPoints)));
    }
}
