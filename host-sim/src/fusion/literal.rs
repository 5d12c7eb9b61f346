//! Eq. 1 of \[001\] as it is printed, in floating point.

use certainty_core::certainty::Certainty;
use certainty_core::fusion::{Cell, CertaintyGrid, Geometry, Measurement};
use certainty_core::health::Health;

/// The grid of \[001\] eq. 1 without any bound: *free* is p = 0, *occupied* is p = 1.
///
/// Formula: 1/P − 1 = ∏ (1/Pᵢ − 1). A factor of 0 or ∞ is absorbing: after the first *free* or *occupied*
/// no measurement changes the cell, since 0 · ∞ has no value and the cell keeps its own.
/// For an evaluation of that effect; a robot uses
/// [`BayesGrid`](certainty_core::fusion::BayesGrid), which bounds each measurement.
///
/// Order: the first *free* or *occupied* stays. Memory: 8 bytes a cell.
#[derive(Debug, Clone)]
pub(super) struct LiteralGrid {
    geometry: Geometry,
    /// 1/P − 1 of each cell: the odds of being free.
    odds: Vec<f64>,
}

impl LiteralGrid {
    /// Creates a grid in which every cell is uncertain.
    pub(super) fn new(geometry: Geometry) -> Self {
        let odds = vec![1.0; geometry.cells() as usize];
        Self { geometry, odds }
    }
}

/// 1/p − 1 of a measurement, in 0..=∞.
fn odds_of_free(certainty: Certainty) -> f64 {
    match certainty {
        Certainty::OCCUPIED => 0.0, // the largest eight-bit value, 0.996, stands for 1 ([001] §6.1)
        other => 256.0 / f64::from(other.to_bits()) - 1.0,
    }
}

impl CertaintyGrid for LiteralGrid {
    fn geometry(&self) -> Geometry {
        self.geometry
    }

    fn add(&mut self, cell: Cell, measurement: Measurement, _sensors: &mut [Health]) {
        if let Some(odds) = self.odds.get_mut(cell.index()) {
            let product = *odds * odds_of_free(measurement.certainty);
            if !product.is_nan() {
                *odds = product;
            }
        }
    }

    fn clear(&mut self) {
        self.odds.fill(1.0);
    }

    fn certainty(&self, cell: Cell) -> Certainty {
        let odds = self.odds.get(cell.index()).copied().unwrap_or(1.0);
        // Within 0..=256; the cast saturates.
        Certainty::from_bits((256.0 / (1.0 + odds)).round() as u8)
    }

    fn memory_bytes(&self) -> usize {
        self.odds.len() * size_of::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::sensor::SensorId;
    use certainty_core::units::{Millimeters, Point};

    fn fused(measurements: &[u8]) -> u8 {
        let geometry = Geometry::try_new(2, 2, Millimeters::new(100), Point::ORIGIN).unwrap();
        let cell = geometry.cell(1, 1).unwrap();
        let mut grid = LiteralGrid::new(geometry);
        for &bits in measurements {
            let measurement = Measurement {
                sensor: SensorId::try_new(1).unwrap(),
                certainty: Certainty::from_bits(bits),
            };
            grid.add(cell, measurement, &mut []);
        }
        let others = geometry.iter().filter(|&other| other != cell);
        assert!(
            others
                .map(|cell| grid.certainty(cell))
                .all(|c| c == Certainty::UNCERTAIN)
        );
        grid.certainty(cell).to_bits()
    }

    #[test]
    fn the_first_landmark_stays() {
        assert_eq!(fused(&[0, 255, 255, 255, 255]), 0);
        assert_eq!(fused(&[255, 0, 0, 0, 0]), 255);
        assert_eq!(fused(&[0, 128, 200]), 0);
    }

    #[test]
    fn uncertain_measurements_are_multiplied() {
        // p = 0.75 twice: (1/3)² to one, so 9/10; then p = 0.25: 3/4 again.
        assert_eq!(fused(&[192]), 192);
        assert_eq!(fused(&[192, 192]), 230);
        assert_eq!(fused(&[192, 192, 64]), 192);
        assert_eq!(fused(&[128, 128]), 128);
    }

    #[test]
    fn a_landmark_replaces_uncertain_measurements() {
        assert_eq!(fused(&[192, 192, 192, 0]), 0);
        assert_eq!(fused(&[1, 1, 1, 255]), 255);
    }
}
