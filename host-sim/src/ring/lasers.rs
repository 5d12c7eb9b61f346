//! Two antipodal laser scanners (\[003\] §2, §3).

use super::BEAMS;
use crate::transducer::stream::{Purpose, stream};
use crate::world::World;
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose};
use certainty_ring::{Scan, Scanner, ScannerError, TooManyBeams};
use rand::RngExt;
use rand_distr::StandardNormal;

/// How well a scanner tells distances.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScannerModel {
    /// Distances are multiples of this.
    pub resolution: Millimeters,
    /// Standard deviation of a distance before it is rounded, in millimetres.
    pub noise_mm: f64,
}

impl ScannerModel {
    /// A scanner with the 50 mm that \[003\] §3 gives for the first; the noise is an open choice.
    pub const COARSE: Self = Self {
        resolution: Millimeters::new(50),
        noise_mm: 5.0,
    };

    /// A scanner with the 10 mm that \[003\] §3 gives for the second; the noise is an open choice.
    pub const FINE: Self = Self {
        resolution: Millimeters::new(10),
        noise_mm: 5.0,
    };
}

/// Two scanners of 361 beams each, half a degree apart: the first looks to the left, the second to the
/// right.
#[derive(Debug, Clone, Copy)]
pub struct LaserPair {
    scanners: [(Scanner, ScannerModel); 2],
}

/// Beams of one scanner.
const HALF: u16 = 361;

impl LaserPair {
    /// How far a scanner sits from the robot's middle, the way it looks: two cannot sit in one place.
    pub const OFFSET: Millimeters = Millimeters::new(100);

    /// How far a scanner sees.
    pub const FARTHEST: Millimeters = Millimeters::new(8000);

    /// Creates the pair.
    ///
    /// # Errors
    ///
    /// Never with these constants; the core's check is passed on.
    pub fn try_new(models: [ScannerModel; 2]) -> Result<Self, ScannerError> {
        let offset = Self::OFFSET.get().cast_signed();
        let [left, right] = models;
        let at = |y, heading| Pose::new(Point::from_mm(0, y), heading);
        let behind = BinaryAngle::HALF.wrapping_add(BinaryAngle::QUARTER);
        let scanner = |mount| Scanner::try_new(mount, Self::FARTHEST);
        Ok(Self {
            scanners: [
                (scanner(at(offset, BinaryAngle::QUARTER))?, left),
                (scanner(at(-offset, behind))?, right),
            ],
        })
    }

    /// The beams' directions relative to their scanner, counter-clockwise.
    pub fn bearings() -> impl Iterator<Item = BinaryAngle> {
        let beams = 0..i32::from(HALF);
        beams.map(|beam| BinaryAngle::from_millidegrees(beam * 500 - 90_000))
    }

    /// The scanners, in the order of their beams.
    pub fn scanners(&self) -> impl Iterator<Item = &Scanner> {
        self.scanners.iter().map(|(scanner, _)| scanner)
    }

    /// Scans `world` from where `robot` is; `part` tells the scans of a run apart.
    ///
    /// # Errors
    ///
    /// Never: there is room for all beams.
    pub fn scan(
        &self,
        world: &World,
        robot: Pose,
        seed: u64,
        part: u32,
    ) -> Result<Scan<BEAMS>, TooManyBeams> {
        let mut scan = Scan::new();
        for (number, (scanner, model)) in (1..).zip(&self.scanners) {
            let mut dice = stream(seed, Purpose::Laser, number, part);
            let place = robot.compose(scanner.mount());
            for bearing in Self::bearings() {
                let noise: f64 = dice.sample(StandardNormal);
                let direction = place.heading.wrapping_add(bearing);
                let distance = world.distance(place.at, direction, scanner.farthest());
                let reading = distance.map_or(Reading::NoObject, |distance| {
                    let step = f64::from(model.resolution.get().max(1));
                    let noisy = (distance + noise * model.noise_mm).max(0.0);
                    let rounded = (noisy / step).round() * step;
                    Reading::Echo(Millimeters::new(rounded as u32))
                });
                scan.add(scanner, bearing, reading)?;
            }
        }
        Ok(scan)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scan_goes_once_around_in_order_and_ends_on_the_walls() {
        let world = World::office();
        let robot = Pose::new(
            Point::from_mm(1800, 2000),
            BinaryAngle::from_millidegrees(33_000),
        );
        let exact = ScannerModel {
            resolution: Millimeters::new(1),
            noise_mm: 0.0,
        };
        let pair = LaserPair::try_new([exact, exact]).unwrap();
        let scan = pair.scan(&world, robot, 1, 0).unwrap();
        assert_eq!(scan.points().len(), 722);
        let mut turned = 0.0;
        let points: Vec<_> = scan.points().collect();
        for pair in points.windows(2) {
            let angle = |p: Point| f64::from(p.y_mm()).atan2(f64::from(p.x_mm()));
            let turn = core::f64::consts::TAU;
            let step = (angle(pair[1]) - angle(pair[0]) + turn / 2.0).rem_euclid(turn) - turn / 2.0;
            turned += step;
        }
        // From 0° of the first to 360° of the second, both 0.1 m off the axis.
        assert!((5.9..6.4).contains(&turned), "{turned}");
        for point in points {
            let place = robot.compose(Pose::new(point, BinaryAngle::ZERO)).at;
            let clearance = world.obstacles().iter().map(|o| o.clearance(place));
            let nearest = clearance.min_by(f64::total_cmp).unwrap();
            assert!(nearest < 3.0, "{place:?} is {nearest} mm off any wall");
        }
    }

    #[test]
    fn a_coarse_scanner_tells_multiples_of_its_resolution() {
        let pair = LaserPair::try_new([ScannerModel::COARSE, ScannerModel::FINE]).unwrap();
        let robot = Pose::new(Point::from_mm(1800, 2000), BinaryAngle::ZERO);
        let scan = pair.scan(&World::office(), robot, 7, 0).unwrap();
        let away =
            |point: Point, y: i32| f64::from(point.x_mm()).hypot(f64::from(point.y_mm() - y));
        for (number, point) in scan.points().enumerate() {
            let (y, step) = if number < 361 {
                (100, 50.0)
            } else {
                (-100, 10.0)
            };
            let distance = away(point, y);
            let off = (distance / step).round() * step - distance;
            assert!(off.abs() < 1.5, "beam {number}: {distance}");
        }
    }
}
