//! What the map shows where a rangefinder looks, and beside it.

use super::map_scan::RayHit;
use super::nearness::{distance, nearer};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::{CertaintyGrid, Environment};
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Millimeters, Pose};

/// Rays to either side of the one in the middle.
const ASIDE: u16 = 5;

/// Rays of a sector.
const RAYS: usize = 2 * ASIDE as usize + 1;

/// Between two rays.
const STEP: BinaryAngle = BinaryAngle::from_millidegrees(5000);

/// Where the first one points, from where the rangefinder looks: in whole steps, so that the one in the
/// middle looks where it does.
const RIGHTMOST: BinaryAngle =
    BinaryAngle::from_bits(STEP.to_bits().wrapping_mul(ASIDE).wrapping_neg());

/// What 11 rays meet in the map, 5° from each other: from 25° to the right of where a rangefinder looks
/// to 25° to the left.
///
/// So six rangefinders at ±15°, ±45° and ±95° leave no gap on either side of the robot: the map, unlike
/// a beam, can be asked for what lies between two of them.
///
/// Memory: 92 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RayFan {
    rays: [Reading; RAYS],
    clear: Millimeters,
}

impl RayFan {
    /// A sector in which the map shows nothing.
    pub const EMPTY: Self = Self::of_rays([Reading::NoObject; RAYS], Millimeters::ZERO);

    /// Creates the sector of rays that met so much, from the right to the left, and of which the three in the
    /// middle are surely `clear` so far.
    #[must_use]
    pub const fn of_rays(rays: [Reading; RAYS], clear: Millimeters) -> Self {
        Self { rays, clear }
    }

    /// Returns what the map shows around `from`: cells surer than `obstacle`.
    ///
    /// Cost: the cells on 11 lines of `farthest` length.
    #[must_use]
    pub fn of_map<G: CertaintyGrid>(
        map: &Environment<'_, G>,
        from: Pose,
        farthest: Millimeters,
        obstacle: Certainty,
    ) -> Self {
        let mut heading = from.heading.wrapping_add(RIGHTMOST);
        let mut sights = [RayHit::UNKNOWN; RAYS];
        for sight in &mut sights {
            *sight = RayHit::in_map(map, Pose::new(from.at, heading), farthest, obstacle);
            heading = heading.wrapping_add(STEP);
        }
        let [_, _, _, _, right, ahead, left, ..] = sights;
        let clear = right.clear.min(ahead.clear).min(left.clear);
        Self::of_rays(sights.map(|sight| sight.met), clear)
    }

    /// Returns the nearest that any ray meets.
    #[must_use]
    pub fn nearest(&self) -> Reading {
        self.rays.into_iter().fold(Reading::NoObject, nearer)
    }

    /// Returns the nearest and the farthest that the three rays in the middle meet, or nothing where one
    /// of them meets nothing: then the rangefinder may pass by an edge.
    #[must_use]
    pub fn ahead(&self) -> Option<(Millimeters, Millimeters)> {
        let [_, _, _, _, right, ahead, left, ..] = self.rays;
        let (Reading::Echo(right), Reading::Echo(ahead), Reading::Echo(left)) =
            (right, ahead, left)
        else {
            return None;
        };
        Some((right.min(ahead).min(left), right.max(ahead).max(left)))
    }

    /// Returns the nearest that one of the three rays in the middle meets.
    #[must_use]
    pub fn nearest_ahead(&self) -> Option<Millimeters> {
        let [_, _, _, _, right, ahead, left, ..] = self.rays;
        distance(nearer(nearer(right, ahead), left))
    }

    /// Returns how far the map surely shows nothing to the three rays in the middle.
    #[must_use]
    pub const fn clear(&self) -> Millimeters {
        self.clear
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::fusion::{BayesGrid, Geometry, Measurement, Strength};
    use certainty_core::sensor::SensorId;
    use certainty_core::units::Point;

    const FAR: Millimeters = Millimeters::new(3000);

    /// A map of 4 m by 4 m in cells of 10 cm, occupied where it is told, and what is seen from its middle.
    fn seen(occupied: &[(i32, i32)], degrees: i32) -> RayFan {
        let shape = Geometry::try_new(40, 40, Millimeters::new(100), Point::from_mm(-2000, -2000));
        let shape = shape.unwrap();
        let mut grid = BayesGrid::try_new(shape, Strength::UNLIMITED, [0; 1600]).unwrap();
        let measurement = Measurement {
            sensor: SensorId::try_new(1).unwrap(),
            certainty: Certainty::OCCUPIED,
        };
        for &(x, y) in occupied {
            let cell = shape.cell_at(Point::from_mm(x, y)).unwrap();
            grid.add(cell, measurement, &mut []);
        }
        let heading = BinaryAngle::from_millidegrees(degrees * 1000);
        let from = Pose::new(Point::from_mm(50, 50), heading);
        let map = Environment::new(&grid, &[]);
        RayFan::of_map(&map, from, FAR, Certainty::from_bits(192))
    }

    const fn echo(mm: u32) -> Reading {
        Reading::Echo(Millimeters::new(mm))
    }

    /// A cell 1 m away at 20° is met by the ray at 20°, and by no ray of a sector that looks away.
    #[test]
    fn what_stands_beside_the_ray_is_in_the_sector() {
        let beside = (50 + 940, 50 + 342);
        // To the centre of its cell, (950, 350).
        let there = (950_f64 - 50.0).hypot(350.0 - 50.0);
        assert_eq!(seen(&[beside], 0).nearest(), echo(there as u32));
        assert_eq!(seen(&[beside], 0).ahead(), None);
        assert_eq!(seen(&[beside], -20), RayFan::EMPTY);
        assert_eq!(seen(&[beside], 60), RayFan::EMPTY);
        assert_eq!(seen(&[], 0).nearest(), Reading::NoObject);
    }

    #[test]
    fn a_wall_is_ahead_and_its_end_is_not() {
        let wall: Vec<(i32, i32)> = (-5..=5).map(|row| (1050, 50 + 100 * row)).collect();
        // To the centres of the cells 1 m ahead: 1000 in the middle, 1004 beside it.
        let ahead = seen(&wall, 0).ahead();
        assert_eq!(
            ahead,
            Some((Millimeters::new(1000), Millimeters::new(1004)))
        );
        assert_eq!(seen(&wall, 0).nearest(), echo(1000));
        // Without its left half only rays to the right and ahead meet it.
        assert_eq!(seen(&wall[..6], 0).ahead(), None);
    }

    /// A ray that meets the cell 1 m ahead, and two beside it that do not.
    #[test]
    fn an_edge_is_the_nearest_that_any_of_three_rays_meets() {
        let edge = seen(&[(1050, 50)], 0);
        assert_eq!(
            (edge.ahead(), edge.nearest_ahead()),
            (None, Some(Millimeters::new(1000)))
        );
        assert_eq!(seen(&[(1050, 450)], 0).nearest_ahead(), None);
        // Nothing is known but the cell that is occupied.
        assert_eq!(edge.clear(), Millimeters::ZERO);
    }

    #[test]
    fn sectors_to_both_sides_mirror_each_other() {
        let left = [(650, 450), (850, 250)];
        let right = left.map(|(x, y)| (x, 100 - y));
        let (mut one, other) = (seen(&left, 45).rays, seen(&right, -45).rays);
        one.reverse();
        assert_eq!(one, other);
    }
}
