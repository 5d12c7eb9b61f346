//! \[001\] Fig. 6: how the errors of calibrated sensors are spread.

use super::Assessment;
use crate::plot::{Axis, Histogram, Line, LineChart, Sample};
use crate::quantity::Excerpt;
use std::collections::BTreeMap;

/// A histogram has at most about so many bins.
const BINS: f64 = 25.0;

/// Returns how the errors of `units` are spread, as \[001\] Fig. 6 shows those of three sensors.
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
        name: called(unit),
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
        Line::new(&called(unit), points).with_band(by_distance.values().map(ends).collect())
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
fn called(unit: &Assessment) -> String {
    let name = Excerpt::new(unit.name());
    match unit.error_mm() {
        Some(spread) => format!("{name} (σ = {:.1} mm)", spread.sd),
        None => format!("{name} (no distance)"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transducer::MeasuredUnit;
    use certainty_core::units::Millimeters;

    #[test]
    fn the_figures_show_every_error_once() {
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
