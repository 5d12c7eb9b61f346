//! Rays cast into a map: the scan that the sensors are expected to report, and the readings filled in from it.

use crate::failures::{Failure, Failures};
use crate::motion::Effort;
use crate::sensors::{BEAMS, Mountings, RANGEFINDERS, ScanGeometry, distance, nearer};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::{CertaintyGrid, Environment, Ray};
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Millimeters, Pose};

/// Returns what one ray of length `range` along `from` hits in the map: the first cell with a certainty
/// above `obstacle`.
///
/// An *uncertain* cell stops no ray, else no robot could start.
///
/// Formula: the distance to the centre of that cell, rounded down.
///
/// Cost: the cells on one line.
#[must_use]
#[inline(never)]
pub fn beam_in_map<G: CertaintyGrid>(
    map: &Environment<'_, G>,
    from: Pose,
    range: Millimeters,
    obstacle: Certainty,
) -> Reading {
    let geometry = map.geometry();
    let end = from.at.ahead(from.heading.direction(), range);
    let mut cells = Ray::new(&geometry, from.at, end);
    match cells.find(|&cell| map.certainty(cell) > obstacle) {
        Some(cell) => Reading::Echo(from.at.distance(geometry.center(cell))),
        None => Reading::NoObject,
    }
}

/// The result of one ray cast into a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RayHit {
    /// What the ray hits.
    pub hit: Reading,
    /// How far all cells on the ray are surely free.
    pub clear: Millimeters,
}

impl RayHit {
    /// The result where the map shows nothing: no hit, and no cell that is surely free.
    pub const UNKNOWN: Self = Self {
        hit: Reading::NoObject,
        clear: Millimeters::ZERO,
    };

    /// Returns what a ray of length `range` along `from` hits, as in [`beam_in_map`], and how far the cells
    /// on it are as surely free as the hit is occupied.
    ///
    /// Units: mm, to the centre of a cell. Cost: that of [`beam_in_map`], and a comparison per cell.
    #[must_use]
    #[inline(never)]
    pub fn in_map<G: CertaintyGrid>(
        map: &Environment<'_, G>,
        from: Pose,
        range: Millimeters,
        obstacle: Certainty,
    ) -> Self {
        let geometry = map.geometry();
        let end = from.at.ahead(from.heading.direction(), range);
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
                let hit = Reading::Echo(away());
                return Self { hit, clear };
            }
        }
        Self {
            hit: Reading::NoObject,
            clear: clear.unwrap_or(range),
        }
    }
}

/// A map into which rays can be cast.
pub trait CastRay {
    /// Returns what a ray of length `range` along `from` hits: cells with a certainty above `obstacle`.
    fn cast(&self, from: Pose, range: Millimeters, obstacle: Certainty) -> RayHit;
}

impl<G: CertaintyGrid> CastRay for Environment<'_, G> {
    fn cast(&self, from: Pose, range: Millimeters, obstacle: Certainty) -> RayHit {
        RayHit::in_map(self, from, range, obstacle)
    }
}

/// Returns what `B` beams of length `range` from `scanner` hit in the map: cells with a certainty above
/// `obstacle`.
///
/// So the histogram can be made from the map, as in the first vector field histogram, instead of from single
/// beams as in \[004\]: the map keeps what is out of sight, has what one sensor missed and another saw, and
/// weighs the readings of faulty sensors.
///
/// Cost: the cells on `B` lines.
#[must_use]
pub fn scan_of_map<const B: usize>(
    map: &impl CastRay,
    scanner: Pose,
    range: Millimeters,
    obstacle: Certainty,
) -> [Reading; B] {
    let mut scan = [Reading::NoObject; B];
    for (reading, index) in scan.iter_mut().zip(0..=u8::MAX) {
        let heading = scanner.heading + ScanGeometry::<B>::bearing(index);
        *reading = map
            .cast(Pose::new(scanner.at, heading), range, obstacle)
            .hit;
    }
    scan
}

/// Rays to either side of the middle one of a [`RayFan`].
const ASIDE: u16 = 5;

/// Rays of a [`RayFan`].
const RAYS: usize = 2 * ASIDE as usize + 1;

/// The angle between two rays of a [`RayFan`].
const STEP: BinaryAngle = BinaryAngle::from_millidegrees(5000);

/// The direction of the first ray from the middle one, a multiple of [`STEP`].
const RIGHTMOST: BinaryAngle =
    BinaryAngle::from_bits(STEP.to_bits().wrapping_mul(ASIDE).wrapping_neg());

/// 11 ray-cast results around a rangefinder's direction, 5° apart, from 25° to the right to 25° to the left.
///
/// Six rangefinders at ±15°, ±45° and ±95° then leave no gap on either side of the robot: unlike a sensor,
/// the map also shows what lies between two beams.
///
/// Memory: 92 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RayFan {
    rays: [Reading; RAYS],
    clear: Millimeters,
}

impl RayFan {
    /// A fan whose rays hit nothing, in a map that shows nothing.
    pub const EMPTY: Self = Self::new([Reading::NoObject; RAYS], Millimeters::ZERO);

    /// Creates a fan from 11 ray-cast results, ordered right to left, and the distance up to which the three
    /// rays in the middle are surely free.
    #[must_use]
    pub const fn new(rays: [Reading; RAYS], clear: Millimeters) -> Self {
        Self { rays, clear }
    }

    /// Casts the rays around `from`.
    ///
    /// Cost: the cells on 11 lines of length `range`.
    #[must_use]
    pub fn of_map(map: &impl CastRay, from: Pose, range: Millimeters, obstacle: Certainty) -> Self {
        let mut heading = from.heading + RIGHTMOST;
        let mut results = [RayHit::UNKNOWN; RAYS];
        for result in &mut results {
            *result = map.cast(Pose::new(from.at, heading), range, obstacle);
            heading += STEP;
        }
        let [_, _, _, _, right, ahead, left, ..] = results;
        let clear = right.clear.min(ahead.clear).min(left.clear);
        Self::new(results.map(|result| result.hit), clear)
    }

    /// Returns the nearest hit of all rays.
    #[must_use]
    pub fn nearest(&self) -> Reading {
        self.rays.into_iter().fold(Reading::NoObject, nearer)
    }

    /// Returns the nearest and the farthest hit of the three rays in the middle; `None` if one of them hits
    /// nothing: the rangefinder's beam may then pass an edge.
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

    /// Returns the nearest hit of the three rays in the middle.
    #[must_use]
    pub fn nearest_ahead(&self) -> Option<Millimeters> {
        let [_, _, _, _, right, ahead, left, ..] = self.rays;
        distance(nearer(nearer(right, ahead), left))
    }

    /// Returns the distance up to which the three rays in the middle are surely free.
    #[must_use]
    pub const fn clear(&self) -> Millimeters {
        self.clear
    }
}

/// The scan that the sensors are expected to report: what the map shows where they look.
///
/// A map drawn by trusted sensors contains objects that no sensor sees now: what is beside the robot, what a
/// failed sensor saw before its failure, what other sensors saw at its place. \[004\] drives by the readings
/// of the moment alone.
///
/// Memory: 1,764 bytes for six rangefinders and 101 beams.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ExpectedScan<const R: usize = RANGEFINDERS, const B: usize = BEAMS> {
    /// The rays around each rangefinder's direction.
    pub fans: [RayFan; R],
    /// The scanner's beams.
    pub scan: [Reading; B],
    /// The distance up to which each of the scanner's beams is surely free.
    pub clear: [Millimeters; B],
}

/// Readings with those of failed sensors replaced by the map's: what the controller works with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Completed<'a, const R: usize = RANGEFINDERS, const B: usize = BEAMS> {
    /// The rangefinders' readings.
    pub rangefinders: [Reading; R],
    /// The scanner's readings.
    pub scan: &'a [Reading; B],
    /// How far each of them has failed.
    pub failures: Failures<R>,
}

impl<const R: usize, const B: usize> ExpectedScan<R, B> {
    /// No hits, and no distance that is surely free.
    pub const EMPTY: Self = Self {
        fans: [RayFan::EMPTY; R],
        scan: [Reading::NoObject; B],
        clear: [Millimeters::ZERO; B],
    };

    /// Casts the rays of all sensors of a robot at `robot`; cells with a certainty above `obstacle` stop them.
    ///
    /// Cost: the cells on 11 `R` + `B` lines, 167 for \[004\]'s robot.
    #[must_use]
    pub fn of_map(
        map: &impl CastRay,
        robot: Pose,
        mountings: &Mountings<R>,
        obstacle: Certainty,
    ) -> Self {
        let fan = |mounting| {
            let from = robot.compose(mounting);
            RayFan::of_map(map, from, mountings.rangefinder_range, obstacle)
        };
        let mut expected = Self {
            fans: mountings.rangefinders.map(fan),
            ..Self::EMPTY
        };
        let scanner = robot.compose(mountings.scanner);
        let beams = expected.scan.iter_mut().zip(&mut expected.clear);
        for ((reading, clear), index) in beams.zip(0..=u8::MAX) {
            let heading = scanner.heading + ScanGeometry::<B>::bearing(index);
            let along = Pose::new(scanner.at, heading);
            let result = map.cast(along, mountings.scanner_range, obstacle);
            (*reading, *clear) = (result.hit, result.clear);
        }
        expected
    }

    /// Fills in the readings of failed sensors from the map.
    ///
    /// - A missing reading counts as a failure for now ([`Failures::or_missing`]).
    /// - A rangefinder that has not failed: the nearer of its reading and the nearest hit of its fan.
    /// - A rangefinder that has failed (by half at least): the nearest hit of its fan. The scanner: the beams
    ///   cast into the map.
    /// - What is filled in has a failure of 1 less the map's trust, at most the sensor's own. The map's trust is
    ///   the scanner's, which draws nearly all of it; without the scanner the mean of the rangefinders' trust,
    ///   at most a half. So if all sensors have failed the map has no trust, and the robot stands.
    #[must_use]
    pub fn complete<'a>(
        &'a self,
        rangefinders: &[Reading; R],
        scan: &'a [Reading; B],
        failures: &Failures<R>,
    ) -> Completed<'a, R, B> {
        let failures = failures.or_missing(rangefinders, Some(scan));
        let of_map = Failure::new_saturating(Effort::ONE - map_trust(&failures));
        let mut completed = Completed {
            rangefinders: *rangefinders,
            scan,
            failures,
        };
        let own = completed.failures.rangefinders.iter_mut();
        let each = completed.rangefinders.iter_mut().zip(own);
        for ((reading, failure), fan) in each.zip(&self.fans) {
            if failure.is_failed() {
                *reading = fan.nearest();
                *failure = of_map.min(*failure);
            } else {
                *reading = nearer(*reading, fan.nearest());
            }
        }
        if failures.scanner.is_failed() {
            completed.scan = &self.scan;
            completed.failures.scanner = of_map.min(failures.scanner);
        }
        completed
    }
}

/// The trust in a map that sensors with these failures draw.
fn map_trust<const R: usize>(failures: &Failures<R>) -> Effort {
    let each = failures.rangefinders.iter();
    let (sum, count) = each.fold((Effort::ZERO, 0_i32), |(sum, count), failure| {
        (sum + failure.trust(), count.wrapping_add(1))
    });
    let mean = sum.checked_div_int(count).unwrap_or(Effort::ZERO);
    failures.scanner.trust().max(mean.min(Effort::HALF))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::PerBeam;
    use certainty_core::fusion::{BayesGrid, Geometry, Measurement, Strength};
    use certainty_core::sensor::SensorId;
    use certainty_core::transducer::Missing;
    use certainty_core::units::Point;

    #[test]
    fn beams_end_at_the_first_occupied_cell() {
        let shape = Geometry::try_new(40, 40, Millimeters::new(100), Point::from_mm(0, -2000));
        let shape = shape.unwrap();
        let mut grid = BayesGrid::try_new(shape, Strength::UNLIMITED, [0; 1600]).unwrap();
        let sensor = SensorId::new(1);
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
        let scan: PerBeam<Reading> = scan_of_map(&map, scanner, far, Certainty::from_bits(160));
        assert_eq!(scan[50], Reading::Echo(Millimeters::new(2000)));
        // The cell is 100 wide at 2000: 2.9°, so the beams 1° aside hit it and those 2° aside do not.
        let hits: Vec<usize> = (0..BEAMS)
            .filter(|&beam| scan[beam] != Reading::NoObject)
            .collect();
        assert_eq!(hits, [49, 50, 51]);
        let near: PerBeam<Reading> = scan_of_map(
            &map,
            scanner,
            Millimeters::new(1900),
            Certainty::from_bits(160),
        );
        assert_eq!(near, [Reading::NoObject; BEAMS]);
    }

    /// Cells of 10 cm ahead: three are free, one is uncertain, one is occupied.
    #[test]
    fn a_ray_is_clear_up_to_the_first_uncertain_cell() {
        let shape =
            Geometry::try_new(20, 1, Millimeters::new(100), Point::from_mm(0, -50)).unwrap();
        let mut grid = BayesGrid::try_new(shape, Strength::UNLIMITED, [0; 20]).unwrap();
        let sensor = SensorId::new(1);
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
            let result = RayHit::in_map(&map, from, Millimeters::new(far), obstacle);
            let hit = beam_in_map(&map, from, Millimeters::new(far), obstacle);
            assert_eq!(result.hit, hit);
            (result.clear.get(), hit)
        };
        assert_eq!(seen(0, 0, 1000), (350, echo(450)));
        assert_eq!(seen(0, 0, 200), (200, Reading::NoObject));
        assert_eq!(seen(600, 0, 1000), (50, Reading::NoObject));
        assert_eq!(seen(600, 180, 1000), (50, echo(150)));
        // Outside the map there are no cells.
        assert_eq!(seen(250, 180, 1000), (1000, Reading::NoObject));
    }

    const FAR: Millimeters = Millimeters::new(3000);

    /// The fan in `degrees` from the middle of a map of 4 m by 4 m in cells of 10 cm, some of them occupied.
    fn fan(occupied: &[(i32, i32)], degrees: i32) -> RayFan {
        let shape = Geometry::try_new(40, 40, Millimeters::new(100), Point::from_mm(-2000, -2000));
        let shape = shape.unwrap();
        let mut grid = BayesGrid::try_new(shape, Strength::UNLIMITED, [0; 1600]).unwrap();
        let measurement = Measurement {
            sensor: SensorId::new(1),
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

    /// The ray at 20° hits a cell 1 m away at 20°; no ray of a fan that looks elsewhere does.
    #[test]
    fn an_object_beside_the_middle_ray_is_in_the_fan() {
        let beside = (50 + 940, 50 + 342);
        // To the centre of its cell, (950, 350).
        let there = (950_f64 - 50.0).hypot(350.0 - 50.0);
        assert_eq!(fan(&[beside], 0).nearest(), echo(there as u32));
        assert_eq!(fan(&[beside], 0).ahead(), None);
        assert_eq!(fan(&[beside], -20), RayFan::EMPTY);
        assert_eq!(fan(&[beside], 60), RayFan::EMPTY);
        assert_eq!(fan(&[], 0).nearest(), Reading::NoObject);
    }

    #[test]
    fn a_wall_is_ahead_and_its_end_is_not() {
        let wall: Vec<(i32, i32)> = (-5..=5).map(|row| (1050, 50 + 100 * row)).collect();
        // To the centres of the cells 1 m ahead: 1000 in the middle, 1004 beside it.
        let ahead = fan(&wall, 0).ahead();
        assert_eq!(
            ahead,
            Some((Millimeters::new(1000), Millimeters::new(1004)))
        );
        assert_eq!(fan(&wall, 0).nearest(), echo(1000));
        // Without its left half only rays to the right and ahead hit it.
        assert_eq!(fan(&wall[..6], 0).ahead(), None);
    }

    /// One ray hits the cell 1 m ahead, and two beside it do not.
    #[test]
    fn an_edge_is_the_nearest_hit_of_three_rays() {
        let edge = fan(&[(1050, 50)], 0);
        assert_eq!(
            (edge.ahead(), edge.nearest_ahead()),
            (None, Some(Millimeters::new(1000)))
        );
        assert_eq!(fan(&[(1050, 450)], 0).nearest_ahead(), None);
        // Every other cell is uncertain.
        assert_eq!(edge.clear(), Millimeters::ZERO);
    }

    #[test]
    fn fans_to_both_sides_mirror_each_other() {
        let left = [(650, 450), (850, 250)];
        let right = left.map(|(x, y)| (x, 100 - y));
        let (mut one, other) = (fan(&left, 45).rays, fan(&right, -45).rays);
        one.reverse();
        assert_eq!(one, other);
    }

    const NOTHING: PerBeam<Reading> = [Reading::NoObject; BEAMS];

    /// An object a metre away in every direction.
    fn map() -> ExpectedScan {
        ExpectedScan {
            fans: [RayFan::new([echo(1000); 11], Millimeters::new(1000)); RANGEFINDERS],
            scan: [echo(1000); BEAMS],
            clear: [Millimeters::new(1000); BEAMS],
        }
    }

    fn failed(rangefinders: usize, scanner: bool) -> Failures {
        let mut failures = Failures::NONE;
        failures.rangefinders[..rangefinders].fill(Failure::TOTAL);
        if scanner {
            failures.scanner = Failure::TOTAL;
        }
        failures
    }

    #[test]
    fn it_takes_the_memory_that_is_documented() {
        assert_eq!(size_of::<ExpectedScan>(), 1764);
        assert_eq!(size_of::<RayFan>(), 92);
    }

    #[test]
    fn a_trusted_sensor_has_the_nearer_of_reading_and_map() {
        let mut readings = [Reading::NoObject; RANGEFINDERS];
        readings[0] = echo(400);
        readings[1] = echo(1400);
        readings[2] = Reading::Missing(Missing::Timeout);
        let map = map();
        let completed = map.complete(&readings, &NOTHING, &Failures::NONE);
        let (near, far) = (echo(400), echo(1000));
        assert_eq!(completed.rangefinders, [near, far, far, far, far, far]);
        // The scanner is trusted, so its own beams count.
        assert_eq!(completed.scan, &NOTHING);
        assert_eq!(completed.failures, Failures::NONE);
    }

    /// No sensor has failed yet, but none sends anything either: the map has no trust.
    #[test]
    fn a_map_of_sensors_that_are_all_missing_has_no_trust() {
        let map = map();
        let missing = [Reading::Missing(Missing::Timeout); RANGEFINDERS];
        let completed = map.complete(&missing, &NOTHING, &failed(0, true));
        assert_eq!(completed.failures, Failures::ALL);
        let no_beams = [Reading::Missing(Missing::Timeout); BEAMS];
        let completed = map.complete(&missing, &no_beams, &Failures::NONE);
        assert_eq!(completed.failures, Failures::ALL);
    }

    #[test]
    fn a_failed_sensors_readings_come_from_the_map() {
        let map = map();
        let close = [echo(100); RANGEFINDERS];
        let completed = map.complete(&close, &NOTHING, &failed(1, false));
        assert_eq!(completed.rangefinders[0], echo(1000));
        assert_eq!(completed.rangefinders[1..], [echo(100); 5]);
        assert_eq!(completed.failures, Failures::NONE);
        let completed = map.complete(&close, &NOTHING, &failed(0, true));
        assert_eq!(completed.scan, &map.scan);
    }

    /// By hand: without the scanner the map's trust is (6 − n) / 6 if n rangefinders have failed, at most a half.
    #[test]
    fn a_map_has_the_trust_of_the_sensors_that_draw_it() {
        let map = map();
        let filled_in = |failures: &Failures| {
            let readings = [Reading::NoObject; RANGEFINDERS];
            let completed = map.complete(&readings, &NOTHING, failures).failures;
            let [first, ..] = completed.rangefinders;
            let parts = [first, completed.scanner].map(|failure| failure.part().to_num::<f64>());
            (parts[0], parts[1])
        };
        assert_eq!(filled_in(&failed(6, false)), (0.0, 0.0));
        assert_eq!(filled_in(&failed(0, true)), (0.0, 0.5));
        assert_eq!(filled_in(&failed(2, true)), (0.5, 0.5));
        let trust = 1.0 / 3.0;
        let (rangefinder, scanner) = filled_in(&failed(4, true));
        assert!((rangefinder - (1.0 - trust)).abs() < 1e-4 && rangefinder == scanner);
        assert_eq!(
            map.complete(&[echo(9); 6], &NOTHING, &Failures::ALL)
                .failures,
            Failures::ALL
        );
        // A reading that is filled in has no larger failure than the sensor.
        let mut half = failed(0, true);
        half.rangefinders = [Failure::TOTAL; RANGEFINDERS];
        half.rangefinders[0] = Failure::new_saturating(Effort::HALF);
        half.rangefinders[1] = Failure::NONE;
        // The mean trust is a quarter.
        assert_eq!(filled_in(&half), (0.5, 0.75));
    }
}
