//! Calibration of infrared sensors: a characteristic fitted to measured points, and its errors.
//!
//! [`load`] reads a table of measured points, [`Assessment`] fits a unit and compares its calibrated
//! readings with the true distances, [`error_histogram`] and [`error_over_distance`] draw that as
//! \[001\] Fig. 6 does. The errors are those of the points that were fitted: they show how well the
//! characteristic follows the unit, not how much the unit drifts from day to day.

mod file;

pub use file::{MOST_BYTES, MeasurementsError, load};

use crate::plot::{Axis, Histogram, Line, LineChart, Sample};
use crate::quantity::Excerpt;
use crate::transducer::{Adc, CurvePoint, Fit, FitError, MeasuredUnit};
use certainty_core::transducer::Reading;
use certainty_core::units::Millimeters;
use serde::Serialize;
use std::collections::BTreeMap;
use thiserror::Error;

/// A unit's fitted characteristic and the errors of its calibrated readings.
#[derive(Debug, Clone, PartialEq)]
pub struct Assessment {
    name: String,
    blanks: usize,
    fit: Fit,
    points: usize,
    ignored: usize,
    errors: Vec<PointError>,
}

/// How far a calibrated reading is from the true distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointError {
    /// The true distance, in millimetres.
    pub distance_mm: f64,
    /// The calibrated reading less the true distance, in millimetres.
    pub error_mm: f64,
}

impl PointError {
    /// Returns the error as a percentage of the true distance.
    #[must_use]
    pub fn percent(&self) -> f64 {
        self.error_mm / self.distance_mm * 100.0
    }
}

/// Mean, standard deviation and largest magnitude of errors, in the errors' unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// Their mean, the systematic part.
    pub mean: f64,
    /// Their standard deviation about the mean, the root of the mean square.
    pub sd: f64,
    /// The largest magnitude.
    pub worst: f64,
}

impl Spread {
    /// The spread of `errors`; `None` if there are none.
    fn of(errors: impl Iterator<Item = f64> + Clone) -> Option<Self> {
        let count = errors.clone().count();
        if count == 0 {
            return None;
        }
        let mean = errors.clone().sum::<f64>() / count as f64;
        let squares: f64 = errors.clone().map(|error| (error - mean).powi(2)).sum();
        Some(Self {
            mean,
            sd: (squares / count as f64).sqrt(),
            worst: errors.map(f64::abs).fold(0.0, f64::max),
        })
    }
}

/// Why a unit cannot be calibrated; displays as one line that says what to do.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "unit '{unit}', {points} points from {nearest} to {farthest}: {source}; measure it again or \
     choose another range"
)]
pub struct UnfitError {
    /// The unit's name.
    pub unit: Excerpt,
    /// How many of its points are within the range.
    pub points: usize,
    /// The shortest distance that is used.
    pub nearest: Millimeters,
    /// The longest distance that is used.
    pub farthest: Millimeters,
    /// Why the points do not suffice.
    pub source: FitError,
}

impl Assessment {
    /// Fits `unit` through its points from `nearest` to `farthest`, both included, and reads each
    /// of them back: its count, rounded to the nearest, through the fit's
    /// [calibration](Fit::calibration), or for volts and an ADC of more than 8 bits, which a calibration does not
    /// take, through the [inverse of the fit](Fit::distance_mm).
    ///
    /// Cost: 500 times the number of points; some seconds for the longest table.
    ///
    /// # Errors
    /// [`UnfitError`] if the points do not suffice.
    ///
    /// # Examples
    /// ```
    /// use certainty_core::units::Millimeters;
    /// use certainty_sim::calibration::Assessment;
    /// use certainty_sim::transducer::MeasuredUnit;
    ///
    /// let table = "distance_mm,raw\n100,190\n200,125\n400,92.5\n800,76.25\n";
    /// let unit = &MeasuredUnit::parse(table).unwrap()[0];
    /// let (nearest, farthest) = (Millimeters::new(100), Millimeters::new(800));
    /// let found = Assessment::of(unit, nearest, farthest)?;
    /// assert!((found.fit().slope() - 13_000.0).abs() < 1.0);
    /// assert!(found.error_mm().unwrap().worst < 15.0); // a quarter of a count at 800 mm
    /// # Ok::<(), certainty_sim::calibration::UnfitError>(())
    /// ```
    pub fn of(
        unit: &MeasuredUnit,
        nearest: Millimeters,
        farthest: Millimeters,
    ) -> Result<Self, UnfitError> {
        let range = f64::from(nearest.get())..=f64::from(farthest.get());
        let all = unit.points().iter().copied();
        let within: Vec<CurvePoint> = all.filter(|p| range.contains(&p.distance_mm)).collect();
        let unfit = |source| UnfitError {
            unit: Excerpt::new(unit.name()),
            points: within.len(),
            nearest,
            farthest,
            source,
        };
        let fit = Fit::through(&within).map_err(unfit)?;
        let byte =
            (unit.adc() == Adc::BYTE).then(|| fit.calibration(nearest, farthest).map_err(unfit));
        let byte = byte.transpose()?;
        let read = |p: &CurvePoint| {
            let read_mm = match byte {
                // Bytes are within 0..=255 already; the cast saturates.
                Some(calibration) => match calibration.reading(p.raw.round() as u8) {
                    Reading::Echo(distance) => Some(f64::from(distance.get())),
                    _ => None,
                },
                None => {
                    Some(fit.distance_mm(p.raw.round()).round()).filter(|mm| range.contains(mm))
                }
            };
            Some(PointError {
                distance_mm: p.distance_mm,
                error_mm: read_mm? - p.distance_mm,
            })
        };
        Ok(Self {
            name: unit.name().to_owned(),
            blanks: unit.blanks(),
            fit,
            points: within.len(),
            ignored: unit.points().len() - within.len(),
            errors: within.iter().filter_map(read).collect(),
        })
    }

    /// Returns the unit's name from its table.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns how many fields of the unit had no reading.
    #[must_use]
    pub const fn blanks(&self) -> usize {
        self.blanks
    }

    /// Returns the fitted characteristic.
    #[must_use]
    pub const fn fit(&self) -> &Fit {
        &self.fit
    }

    /// Returns how many points are within the range: those that were fitted.
    #[must_use]
    pub const fn points(&self) -> usize {
        self.points
    }

    /// Returns how many points are outside the range and not used.
    #[must_use]
    pub const fn ignored(&self) -> usize {
        self.ignored
    }

    /// Returns how many points within the range read as *too near* or *no object* once calibrated.
    #[must_use]
    pub const fn out_of_range(&self) -> usize {
        self.points - self.errors.len()
    }

    /// Returns the errors of the points that read as a distance, in the table's order.
    #[must_use]
    pub fn errors(&self) -> &[PointError] {
        &self.errors
    }

    /// Returns the spread of the errors in millimetres; `None` if no point reads as a distance.
    #[must_use]
    pub fn error_mm(&self) -> Option<Spread> {
        Spread::of(self.errors.iter().map(|error| error.error_mm))
    }

    /// Returns the spread of the errors as percentages of the true distances; `None` if no point reads
    /// as a distance.
    #[must_use]
    pub fn error_percent(&self) -> Option<Spread> {
        Spread::of(self.errors.iter().map(PointError::percent))
    }
}

/// Returns the units to show: all of up to three, else those with the smallest, the middle and the
/// largest standard deviation of the error in millimetres.
///
/// Of an even number of units the lower middle one; of equal ones the first.
#[must_use]
pub fn typical(all: &[Assessment]) -> Vec<&Assessment> {
    let mut units: Vec<&Assessment> = all.iter().collect();
    if units.len() <= 3 {
        return units;
    }
    let sd = |unit: &&Assessment| unit.error_mm().map_or(f64::INFINITY, |spread| spread.sd);
    units.sort_by(|a, b| sd(a).total_cmp(&sd(b)));
    [0, (units.len() - 1) / 2, units.len() - 1]
        .map(|place| units[place])
        .to_vec()
}

/// About the largest number of bins in a histogram.
const BINS: f64 = 25.0;

/// Returns the distribution of the errors of `units`, as \[001\] Fig. 6 shows that of three sensors.
///
/// Bins are 1, 2 or 5 times a power of ten millimetres wide.
#[must_use]
pub fn error_histogram(units: &[&Assessment]) -> Histogram {
    let errors = units.iter().flat_map(|unit| unit.errors());
    let errors = errors.map(|error| error.error_mm);
    let low = errors.clone().fold(0.0, f64::min);
    let high = errors.fold(0.0, f64::max);
    let mut widths = (0..9).flat_map(|power| [1.0, 2.0, 5.0].map(|mm| mm * 10.0_f64.powi(power)));
    let bin_width = widths.find(|width| (high - low) / width <= BINS);
    let sample = |unit: &&Assessment| Sample {
        name: legend_name(unit),
        values: unit.errors().iter().map(|error| error.error_mm).collect(),
    };
    let bin_width = bin_width.unwrap_or(1e9);
    Histogram {
        title: "Error of the calibrated distance".into(),
        x: Axis::new("reading less true distance", "mm"),
        y: Axis::counting(&format!("readings in {bin_width} mm")),
        bin_width,
        samples: units.iter().map(sample).collect(),
    }
}

/// Returns the mean error of `units` at each distance, with a band from the least to the largest.
#[must_use]
pub fn error_over_distance(units: &[&Assessment]) -> LineChart {
    let line = |unit: &&Assessment| {
        // Distances are above zero, so their bits are in their order.
        let mut by_distance: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
        for error in unit.errors() {
            let errors = by_distance.entry(error.distance_mm.to_bits()).or_default();
            errors.push(error.error_mm);
        }
        let at = |(&distance, errors): (&u64, &Vec<f64>)| {
            let mean = errors.iter().sum::<f64>() / errors.len() as f64;
            (f64::from_bits(distance), mean)
        };
        let ends = |errors: &Vec<f64>| {
            let errors = || errors.iter().copied();
            let least = errors().fold(f64::INFINITY, f64::min);
            (least, errors().fold(f64::NEG_INFINITY, f64::max))
        };
        let points = by_distance.iter().map(at).collect();
        Line::new(&legend_name(unit), points).with_band(by_distance.values().map(ends).collect())
    };
    LineChart {
        title: "Error of the calibrated distance over the distance".into(),
        x: Axis::new("true distance", "mm").including(0.0),
        y: Axis::new("reading less true distance", "mm").including(0.0),
        lines: units.iter().map(line).collect(),
        shaded: Vec::new(),
    }
}

/// A unit in a legend: its name and its standard deviation.
fn legend_name(unit: &Assessment) -> String {
    let name = Excerpt::new(unit.name());
    match unit.error_mm() {
        Some(spread) => format!("{name} (σ = {:.1} mm)", spread.sd),
        None => format!("{name} (no distance)"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transducer::GP2D02_UNITS;

    fn assessed(table: &str, nearest: u32, farthest: u32) -> Result<Vec<Assessment>, UnfitError> {
        let units = MeasuredUnit::parse(table).unwrap();
        let mm = Millimeters::new;
        let units = units.iter();
        units
            .map(|unit| Assessment::of(unit, mm(nearest), mm(farthest)))
            .collect()
    }

    #[test]
    fn spread_is_of_its_errors() {
        let spread = Spread::of([-3.0, 1.0, 5.0].into_iter()).unwrap();
        assert_eq!((spread.mean, spread.worst), (1.0, 5.0));
        assert!((spread.sd - (32.0_f64 / 3.0).sqrt()).abs() < 1e-12);
        assert_eq!(Spread::of([].into_iter()), None);
    }

    #[test]
    fn wrong_byte_is_an_error_at_its_distance() {
        // a 12 000, b 0, c 60, exact; twenty readings at each distance outweigh the wrong one.
        let distances = [100, 150, 200, 240, 300, 400, 600, 800];
        let line = |mm: u32| format!("{mm},{}\n", 60 + 12_000 / mm).repeat(20);
        let exact: String = distances.map(line).concat();
        let table = format!("distance_mm,raw\n50,250\n{exact}400,89\n900,60\n");
        let found = &assessed(&table, 100, 800).unwrap()[0];
        assert_eq!(
            (found.points(), found.ignored(), found.out_of_range()),
            (161, 2, 0)
        );
        let wrong = found.errors().last().unwrap();
        // 12 000 / 29 is 414 mm.
        assert!((wrong.error_mm - 14.0).abs() <= 2.0, "{wrong:?}");
        assert!((wrong.percent() - wrong.error_mm / 4.0).abs() < 1e-12);
        let spread = found.error_mm().unwrap();
        assert!((spread.worst - wrong.error_mm).abs() < 1e-12, "{spread:?}");
        assert!(
            spread.mean.abs() < 1.0 && (0.5..2.0).contains(&spread.sd),
            "{spread:?}"
        );
    }

    #[test]
    fn points_without_distance_are_counted_only() {
        // The byte at 800 mm is far below the curve: it reads as no object.
        let table = "distance_mm,raw\n100,180\n100,180\n200,120\n200,120\n400,90\n400,90\n800,66\n";
        let found = &assessed(table, 100, 800).unwrap()[0];
        assert_eq!(found.out_of_range() + found.errors().len(), found.points());
        assert!(found.out_of_range() > 0);
    }

    /// \[001\] Table 1 gives real units an accuracy of 3 % to 12 %.
    #[test]
    fn shipped_units_err_as_much_as_the_papers() {
        let units = assessed(GP2D02_UNITS, 100, 800).unwrap();
        assert_eq!(units.len(), 16);
        for unit in &units {
            let percent = unit.error_percent().unwrap();
            println!("{} {:?} {percent:?}", unit.name(), unit.error_mm());
            assert!(
                (0.3..12.0).contains(&percent.sd),
                "{}: {percent:?}",
                unit.name()
            );
        }
        let three = typical(&units);
        let sd = |unit: &Assessment| unit.error_mm().unwrap().sd;
        assert!(sd(three[0]) < sd(three[1]) && sd(three[1]) < sd(three[2]));
        let least = units.iter().map(sd).fold(f64::INFINITY, f64::min);
        assert_eq!(sd(three[0]), least);
        assert_eq!(
            units.iter().filter(|unit| sd(unit) < sd(three[1])).count(),
            7
        );
    }

    #[test]
    fn unit_without_calibration_is_named() {
        let line = |table| assessed(table, 100, 800).unwrap_err().to_string();
        assert_eq!(
            line("dist_cm,left\n5,200\n10,190\n20,135\n"),
            "unit 'left', 2 points from 100mm to 800mm: a characteristic needs points at three \
             distances or more; measure it again or choose another range"
        );
        let rising = line("dist_cm,A\n10,10\n20,20\n40,30\n");
        assert!(
            rising.contains("the byte must fall with distance"),
            "{rising}"
        );
        let flat = line("dist_cm,A\n10,10\n20,10\n40,10\n");
        assert!(flat.contains("the byte must fall with distance"), "{flat}");
    }

    #[test]
    fn figures_show_every_error_once() {
        let table = "distance_mm,raw\n100,180\n100,182\n200,120\n300,100\n400,90\n";
        let unit = &MeasuredUnit::parse(table).unwrap()[0];
        let unit = Assessment::of(unit, Millimeters::new(50), Millimeters::new(800)).unwrap();
        let counts = error_histogram(&[&unit, &unit]).counts();
        assert_eq!(counts.len(), 2);
        assert_eq!(counts[0].iter().map(|bin| bin.1).sum::<u64>(), 5);
        assert!((1..=26).contains(&counts[0].len()));
        let chart = error_over_distance(&[&unit]);
        let line = &chart.lines[0];
        let distances: Vec<f64> = line.points.iter().map(|point| point.0).collect();
        assert_eq!(distances, [100.0, 200.0, 300.0, 400.0]);
        let (low, high) = line.band.as_ref().unwrap()[0];
        assert!(low < line.points[0].1 && line.points[0].1 < high);
        assert!(line.name.starts_with("raw (σ = "), "{}", line.name);
    }
}
