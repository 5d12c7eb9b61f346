//! What byte a GP2D02 answers at which distance.
//!
//! The measured points of a real unit, joined by straight lines. Before the first and after the
//! last point the curve is a model:
//!
//! - *Nearer* the spot leaves the detector and the byte falls again (\[001\] §6.1 gives 10 cm as the
//!   least distance): a straight line from the first point down to the floor at 0 mm. So a near
//!   object gives the same bytes as a far one, which is what makes short distances ambiguous.
//! - *Farther* the byte tends to the floor c of the fitted characteristic (see [`Fit`]), along a
//!   hyperbola that joins the last point: `c + (raw − c) · (last + b) / (d + b)`.

use super::fit::{Fit, FitError};
use thiserror::Error;

/// One measured point of a characteristic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// The distance, in millimetres.
    pub distance_mm: f64,
    /// The byte at that distance, in counts; a mean of several need not be whole.
    pub raw: f64,
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

/// Why points make no characteristic.
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
    /// [`CurveError`] tells what is wrong with the points.
    pub fn through(points: Vec<CurvePoint>) -> Result<Self, CurveError> {
        if !points.is_sorted_by(|a, b| a.distance_mm < b.distance_mm)
            || points.iter().any(|p| p.distance_mm <= 0.0)
        {
            return Err(CurveError::NotAscending);
        }
        if points.iter().any(|p| !(0.0..=255.0).contains(&p.raw)) {
            return Err(CurveError::NoByte);
        }
        let range =
            f64::from(super::gp2d02::NEAREST.get())..=f64::from(super::gp2d02::FARTHEST.get());
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

    /// Returns what the byte tends to where nothing reflects, in counts within `0.0..=255.0`.
    #[must_use]
    pub const fn silence(&self) -> f64 {
        self.fit.floor().clamp(0.0, 255.0)
    }

    /// Returns the byte at `distance_mm` before rounding, in counts within `0.0..=255.0`.
    ///
    /// A negative distance counts as none, what is no number as infinitely far.
    #[must_use]
    pub fn raw(&self, distance_mm: f64) -> f64 {
        let floor = self.silence();
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

    fn typical() -> Characteristic {
        // The bytes of [001]'s sensor family at 10, 20, 40 and 80 cm.
        let points = [(100.0, 190.0), (200.0, 135.0), (400.0, 95.0), (800.0, 75.0)]
            .map(|(distance_mm, raw)| CurvePoint { distance_mm, raw });
        Characteristic::through(points.to_vec()).unwrap()
    }

    #[test]
    fn the_curve_goes_through_its_points_and_straight_between() {
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
        assert!((curve.raw(0.0) - curve.silence()).abs() < 1e-12);
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
            assert!(here < before && here > curve.silence(), "at {mm}");
            before = here;
        }
        assert!((curve.raw(f64::INFINITY) - curve.silence()).abs() < 1e-12);
        assert!((curve.raw(f64::NAN) - curve.silence()).abs() < 1e-12);
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
