//! What sensors would see in the certainty grid.

use super::histogram::{BEAMS, PerBeam, beam_bearing};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::{CertaintyGrid, Environment, Ray};
use certainty_core::transducer::Reading;
use certainty_core::units::{Millimeters, Point, Pose};

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

/// What a ray sees in the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RayHit {
    /// What it meets.
    pub met: Reading,
    /// How far it surely meets nothing.
    pub clear: Millimeters,
}

impl RayHit {
    /// Where nothing is known: nothing is met, and nothing surely.
    pub const UNKNOWN: Self = Self {
        met: Reading::NoObject,
        clear: Millimeters::ZERO,
    };

    /// Returns what a ray of `farthest` length along `from` meets, as in [`beam_in_map`], and how far the cells
    /// on it are as surely free as that is occupied.
    ///
    /// Units: mm, to the centre of a cell. Cost: that of [`beam_in_map`], and a comparison a cell.
    #[must_use]
    #[inline(never)]
    pub fn in_map<G: CertaintyGrid>(
        map: &Environment<'_, G>,
        from: Pose,
        farthest: Millimeters,
        obstacle: Certainty,
    ) -> Self {
        let geometry = map.geometry();
        let end: Point = from.at.ahead(from.heading.direction(), farthest);
        let free = Certainty::from_bits(u8::MAX.saturating_sub(obstacle.to_bits()));
        let mut clear = None;
        for cell in Ray::new(&geometry, from.at, end) {
            let certainty = map.certainty(cell);
            if certainty <= free {
                continue;
            }
            let away = || from.at.distance(geometry.center(cell));
            let clear = *clear.get_or_insert_with(away);
            if certainty > obstacle {
                let met = Reading::Echo(away());
                return Self { met, clear };
            }
        }
        Self {
            met: Reading::NoObject,
            clear: clear.unwrap_or(farthest),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::fusion::{BayesGrid, Geometry, Measurement, Strength};
    use certainty_core::sensor::SensorId;
    use certainty_core::units::BinaryAngle;

    #[test]
    fn beams_end_at_the_first_occupied_cell() {
        let shape = Geometry::try_new(40, 40, Millimeters::new(100), Point::from_mm(0, -2000));
        let shape = shape.unwrap();
        let mut grid = BayesGrid::try_new(shape, Strength::UNLIMITED, [0; 1600]).unwrap();
        let sensor = SensorId::try_new(1).unwrap();
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

    /// Cells of 10 cm ahead: three are free, one is not known, one is occupied.
    #[test]
    fn a_ray_is_clear_as_far_as_its_cells_are_surely_free() {
        let shape =
            Geometry::try_new(20, 1, Millimeters::new(100), Point::from_mm(0, -50)).unwrap();
        let mut grid = BayesGrid::try_new(shape, Strength::UNLIMITED, [0; 20]).unwrap();
        let sensor = SensorId::try_new(1).unwrap();
        let cells = (0..3)
            .map(|x| (x, Certainty::FREE))
            .chain([(4, Certainty::OCCUPIED)]);
        for (x, certainty) in cells {
            let cell = shape.cell_at(Point::from_mm(100 * x + 50, 0)).unwrap();
            grid.add(cell, Measurement { sensor, certainty }, &mut []);
        }
        let map = Environment::new(&grid, &[]);
        let seen = |from: i32, heading: i32, far: u32| {
            let heading = BinaryAngle::from_millidegrees(heading * 1000);
            let from = Pose::new(Point::from_mm(from, 0), heading);
            let obstacle = Certainty::from_bits(192);
            let sight = RayHit::in_map(&map, from, Millimeters::new(far), obstacle);
            let met = beam_in_map(&map, from, Millimeters::new(far), obstacle);
            assert_eq!(sight.met, met);
            (sight.clear.get(), met)
        };
        let echo = |mm| Reading::Echo(Millimeters::new(mm));
        assert_eq!(seen(0, 0, 1000), (350, echo(450)));
        assert_eq!(seen(0, 0, 200), (200, Reading::NoObject));
        assert_eq!(seen(600, 0, 1000), (50, Reading::NoObject));
        assert_eq!(seen(600, 180, 1000), (50, echo(150)));
        // Beyond the map nothing speaks against a ray.
        assert_eq!(seen(250, 180, 1000), (1000, Reading::NoObject));
    }
}
