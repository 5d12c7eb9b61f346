//! What a scanner would see in the certainty grid.

use super::histogram::{BEAMS, PerBeam, beam_bearing};
use crate::certainty::Certainty;
use crate::fusion::{CertaintyGrid, Environment, Ray};
use crate::transducer::Reading;
use crate::units::{Millimeters, Point, Pose};

/// Returns what 101 beams of `farthest` length from `scanner` meet in the map: cells surer than
/// `obstacle`.
///
/// So the histogram can be made from the map, as the vector field histogram was at first, in place of
/// raw beams as in \[004\]: what one sensor misses another has seen, what is out of sight is remembered,
/// and what a liar says is weighed. A cell that is *uncertain* stops no beam, or no robot would start.
///
/// Formula: the distance to the centre of the first such cell on the beam's line, rounded down.
///
/// Cost: the cells on 101 lines.
#[must_use]
pub fn scan_of_map<G: CertaintyGrid>(
    map: &Environment<'_, G>,
    scanner: Pose,
    farthest: Millimeters,
    obstacle: Certainty,
) -> PerBeam<Reading> {
    let mut scan = [Reading::NoObject; BEAMS];
    for (reading, index) in scan.iter_mut().zip(0..=u8::MAX) {
        let heading = scanner.heading.wrapping_add(beam_bearing(index));
        *reading = beam_in_map(map, Pose::new(scanner.at, heading), farthest, obstacle);
    }
    scan
}

/// Returns what one beam of `farthest` length along `from` meets in the map, as in [`scan_of_map`].
#[must_use]
#[inline(never)]
pub fn beam_in_map<G: CertaintyGrid>(
    map: &Environment<'_, G>,
    from: Pose,
    farthest: Millimeters,
    obstacle: Certainty,
) -> Reading {
    let geometry = map.geometry();
    let end: Point = from.at.ahead(from.heading.direction(), farthest);
    let mut cells = Ray::new(&geometry, from.at, end);
    match cells.find(|&cell| map.certainty(cell) > obstacle) {
        Some(cell) => Reading::Echo(from.at.distance(geometry.center(cell))),
        None => Reading::NoObject,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fusion::{BayesGrid, Geometry, Measurement, Strength};
    use crate::sensor::SensorId;
    use crate::units::BinaryAngle;

    #[test]
    fn beams_end_at_the_first_occupied_cell() {
        let shape = Geometry::try_new(40, 40, Millimeters::new(100), Point::from_mm(0, -2000));
        let shape = shape.unwrap();
        let mut grid = BayesGrid::try_new(shape, Strength::UNLIMITED, [0; 1600]).unwrap();
        let sensor = SensorId::new(1).unwrap();
        for (x, certainty) in [
            (1050, Certainty::FREE),
            (2050, Certainty::OCCUPIED),
            (3050, Certainty::OCCUPIED),
        ] {
            let cell = shape.cell_at(Point::from_mm(x, 50)).unwrap();
            grid.add(cell, Measurement { sensor, certainty }, &mut []);
        }
        let map = Environment::new(&grid, &[]);
        let scanner = Pose::new(Point::from_mm(50, 50), BinaryAngle::ZERO);
        let far = Millimeters::new(3000);
        let scan = scan_of_map(&map, scanner, far, Certainty::from_bits(160));
        assert_eq!(scan[50], Reading::Echo(Millimeters::new(2000)));
        // The cell is 100 wide at 2000: 2.9°, so the beams 1° aside meet it and those 2° aside do not.
        let met: Vec<usize> = (0..BEAMS)
            .filter(|&beam| scan[beam] != Reading::NoObject)
            .collect();
        assert_eq!(met, [49, 50, 51]);
        let near = scan_of_map(
            &map,
            scanner,
            Millimeters::new(1900),
            Certainty::from_bits(160),
        );
        assert_eq!(near, [Reading::NoObject; BEAMS]);
    }
}
