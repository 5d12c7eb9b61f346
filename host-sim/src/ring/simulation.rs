//! A ring and two laser scanners in a world: what they measure, and what the assessment concludes.

use super::acoustics::{Acoustics, Misalignment, PAPER_RING, SONARS};
use super::fault::{RingDefect, RingFault};
use crate::random::{Purpose, stream};
use crate::world::World;
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose};
use certainty_ring::{
    Assessment, Distances, Echoes, Monitor, NEIGHBOURS, Polygon, PolygonRules, Ring, RingRules,
    Scan, Scanner, TooManyElements,
};
use rand::RngExt;
use rand_distr::StandardNormal;
use serde::Serialize;

/// The largest number of elements of a polygon.
pub const ELEMENTS: usize = 128;

/// The number of beams of both scanners.
pub const BEAMS: usize = 722;

/// The accuracy of a laser scanner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScannerModel {
    /// Distances are multiples of this.
    pub resolution: Millimeters,
    /// Standard deviation of a distance before it is rounded, in millimetres.
    pub noise_mm: f64,
}

impl ScannerModel {
    /// The first scanner of \[003\] §3, with a resolution of 50 mm; the noise is our choice.
    pub const COARSE: Self = Self {
        resolution: Millimeters::new(50),
        noise_mm: 5.0,
    };

    /// The second scanner of \[003\] §3, with a resolution of 10 mm; the noise is our choice.
    pub const FINE: Self = Self {
        resolution: Millimeters::new(10),
        noise_mm: 5.0,
    };
}

/// Two antipodal scanners (\[003\] §2, §3) of 361 beams each, half a degree apart: the first faces left,
/// the second right.
#[derive(Debug, Clone, Copy)]
pub struct LaserPair {
    scanners: [(Scanner, ScannerModel); 2],
}

/// Beams of one scanner.
const BEAMS_EACH: u16 = 361;

const _: () = assert!(BEAMS == 2 * BEAMS_EACH as usize);

impl LaserPair {
    /// Distance of a scanner from the robot's centre, in the direction it faces: the two cannot be in one
    /// place.
    pub const OFFSET: Millimeters = Millimeters::new(100);

    /// Range of the scanners.
    pub const RANGE: Millimeters = Millimeters::new(8000);

    const LEFT: Scanner = Scanner::new(
        Pose::new(
            Point::from_mm(0, Self::OFFSET.get().cast_signed()),
            BinaryAngle::QUARTER,
        ),
        Self::RANGE,
    );

    const RIGHT: Scanner = Scanner::new(
        Pose::new(
            Point::from_mm(0, -Self::OFFSET.get().cast_signed()),
            BinaryAngle::HALF.wrapping_add(BinaryAngle::QUARTER),
        ),
        Self::RANGE,
    );

    /// Creates the pair from the models of the left and the right scanner.
    #[must_use]
    pub const fn new([left, right]: [ScannerModel; 2]) -> Self {
        Self {
            scanners: [(Self::LEFT, left), (Self::RIGHT, right)],
        }
    }

    /// Returns the directions of a scanner's beams relative to it, counter-clockwise.
    pub fn bearings() -> impl Iterator<Item = BinaryAngle> {
        let beams = 0..i32::from(BEAMS_EACH);
        beams.map(|beam| BinaryAngle::from_millidegrees(beam * 500 - 90_000))
    }

    /// Returns the scanners, in the order of their beams.
    pub fn scanners(&self) -> impl Iterator<Item = &Scanner> {
        self.scanners.iter().map(|(scanner, _)| scanner)
    }

    /// Scans `world` from the pose `robot`; `part` distinguishes the scans of a run.
    #[must_use]
    pub fn scan(&self, world: &World, robot: Pose, seed: u64, part: u32) -> Scan<BEAMS> {
        let mut scan = Scan::new();
        for (number, (scanner, model)) in (1..).zip(&self.scanners) {
            let mut dice = stream(seed, Purpose::Laser, number, part);
            let place = robot.compose(scanner.mount());
            for bearing in Self::bearings() {
                let noise: f64 = dice.sample(StandardNormal);
                let direction = place.heading.wrapping_add(bearing);
                let distance = world.distance(place.at, direction, scanner.range());
                let reading = distance.map_or(Reading::NoObject, |distance| {
                    let step = f64::from(model.resolution.get().max(1));
                    let noisy = (distance + noise * model.noise_mm).max(0.0);
                    let rounded = (noisy / step).round() * step;
                    Reading::Echo(Millimeters::new(rounded as u32))
                });
                let added = scan.add(scanner, bearing, reading);
                debug_assert!(added.is_ok(), "the scan has the capacity of both scanners");
            }
        }
        scan
    }
}

/// Receivers of a pulse: the sonar itself and its neighbours.
const RECEIVERS: usize = 2 * NEIGHBOURS as usize + 1;

/// Path lengths by transmitter and offset of the receiver; `None` is no echo.
type Lengths = [[Option<f64>; RECEIVERS]; SONARS];

/// A ring and lasers in a world, and the rules of the assessment.
#[derive(Debug, Clone)]
pub struct RingSimulation<'a> {
    world: &'a World,
    acoustics: Acoustics<'a>,
    /// The ring.
    pub ring: Ring<SONARS>,
    /// The lasers.
    pub lasers: LaserPair,
    /// The noise with which polygons are extracted.
    pub polygon: PolygonRules,
    /// The limits within which echoes agree.
    pub rules: RingRules,
    /// Standard deviation of a path length, in millimetres: our choice.
    pub noise_mm: f64,
}

/// The measurements at one pose.
#[derive(Debug, Clone)]
pub struct Observation {
    /// The lasers' points.
    pub scan: Scan<BEAMS>,
    /// The polygon extracted from them.
    pub polygon: Polygon<ELEMENTS>,
    /// The sonars' echoes.
    pub echoes: Echoes<SONARS>,
}

/// The assessment of an observation, with the distances it compared.
#[derive(Debug, Clone, Copy)]
pub struct RingDiagnosis {
    /// The distances simulated from the polygon.
    pub expected: Distances<SONARS>,
    /// The measured distances.
    pub measured: Distances<SONARS>,
    /// The vectors and verdicts.
    pub assessment: Assessment<SONARS>,
}

impl<'a> RingSimulation<'a> {
    /// Puts the paper's ring and lasers into a world, with the default rules.
    #[must_use]
    pub fn new(world: &'a World) -> Self {
        Self {
            world,
            acoustics: Acoustics::new(world),
            ring: PAPER_RING,
            lasers: LaserPair::new([ScannerModel::COARSE, ScannerModel::FINE]),
            polygon: PolygonRules::DEFAULT,
            rules: RingRules::DEFAULT,
            noise_mm: 5.0,
        }
    }

    /// Returns the world.
    #[must_use]
    pub const fn world(&self) -> &'a World {
        self.world
    }

    /// Measures at the pose `robot`; `part` distinguishes the observations of a run.
    ///
    /// An observation with faults differs from the one without only by the faults.
    ///
    /// # Errors
    ///
    /// [`TooManyElements`] if the scan has more straight pieces than [`ELEMENTS`].
    pub fn observe(
        &self,
        robot: Pose,
        faults: &[RingFault],
        seed: u64,
        part: u32,
    ) -> Result<Observation, TooManyElements> {
        let scan = self.lasers.scan(self.world, robot, seed, part);
        Ok(Observation {
            polygon: Polygon::of(&scan, &self.polygon)?,
            echoes: self.echoes(robot, faults, seed, part),
            scan,
        })
    }

    /// Returns the sonars' echoes, faults included.
    #[must_use]
    pub fn echoes(
        &self,
        robot: Pose,
        faults: &[RingFault],
        seed: u64,
        part: u32,
    ) -> Echoes<SONARS> {
        let misaligned: Vec<Misalignment> = faults
            .iter()
            .filter_map(|fault| match fault.defect {
                RingDefect::Misaligned(by) => Some(Misalignment {
                    slot: fault.sensor.slot(),
                    radians: f64::from(by.to_bits().cast_signed()) / 65536.0
                        * core::f64::consts::TAU,
                }),
                _ => None,
            })
            .collect();
        let mut lengths = self.acoustics.lengths(&self.ring, robot, &misaligned);
        let mut dice = stream(seed, Purpose::Transducer, 0, part);
        for length in lengths.iter_mut().flatten() {
            // Drawn for every path, with or without an echo, so that no fault changes another's draws.
            let noise: f64 = dice.sample(StandardNormal);
            *length = length.map(|length| (length + noise * self.noise_mm).max(0.0));
        }
        let sound = lengths;
        for fault in faults {
            self.apply_fault(&mut lengths, &sound, *fault, seed, part);
        }
        let mut echoes = Echoes::unknown();
        for (from, row) in lengths.iter().enumerate() {
            for (column, length) in row.iter().enumerate() {
                let reading = length.map_or(Reading::NoObject, |length| {
                    Reading::Echo(Millimeters::new(length.round() as u32))
                });
                let ends = (
                    SensorId::from_slot(from),
                    SensorId::from_slot(receiver(from, column)),
                );
                if let (Some(from), Some(to)) = ends {
                    let set = echoes.set(from, to, reading);
                    debug_assert!(set.is_ok(), "neighbours have an echo path");
                }
            }
        }
        echoes
    }

    /// Applies a fault to the path lengths measured without any.
    fn apply_fault(
        &self,
        lengths: &mut Lengths,
        sound: &Lengths,
        fault: RingFault,
        seed: u64,
        part: u32,
    ) {
        let slot = fault.sensor.slot();
        let farthest = 2.0 * f64::from(self.ring.config().range.get());
        let mut dice = stream(seed, Purpose::Fault, fault.sensor.number(), part);
        for (from, row) in lengths.iter_mut().enumerate() {
            for (column, length) in row.iter_mut().enumerate() {
                let to = receiver(from, column);
                let (sends, receives) = (from == slot, to == slot);
                let without_fault = sound[from][column];
                match fault.defect {
                    RingDefect::Falsified(by) if sends || receives => {
                        // Longer, or shorter if longer would be out of range.
                        let was = without_fault.unwrap_or(farthest);
                        let by = 2.0 * f64::from(by.get());
                        let up = was + by;
                        *length = Some(if up <= farthest {
                            up
                        } else {
                            (was - by).max(0.0)
                        });
                    }
                    RingDefect::Blind if sends || receives => *length = None,
                    RingDefect::Stuck(at) if receives => *length = Some(2.0 * f64::from(at.get())),
                    RingDefect::Crosstalk if receives => {
                        // From a path of 0.3 m, the duration of a pulse, to the echo without the fault.
                        let last = without_fault.unwrap_or(farthest).max(301.0);
                        *length = Some(dice.random_range(300.0..last));
                    }
                    _ => {}
                }
            }
        }
    }

    /// Assesses an observation by a monitor that has removed no sonar before.
    #[must_use]
    pub fn assess(&self, observation: &Observation) -> RingDiagnosis {
        let expected = Distances::simulated(&self.ring, &observation.polygon);
        let measured = Distances::fold(&self.ring, &observation.echoes, &self.rules);
        let assessment = Monitor::new(self.rules).assess(&self.ring, Some(&expected), &measured);
        RingDiagnosis {
            expected,
            measured,
            assessment,
        }
    }
}

/// The slot of the receiver in this column of a transmitter's row.
fn receiver(from: usize, column: usize) -> usize {
    (from + column + SONARS - usize::from(NEIGHBOURS)) % SONARS
}

/// The three confidence vectors.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Vectors {
    /// \[003\] §5.
    pub simulation_based: Vec<u8>,
    /// \[003\] §6.
    pub intersection_based: Vec<u8>,
    /// \[003\] §7.
    pub overall: Vec<u8>,
}

impl Vectors {
    /// Returns the vectors of an assessment.
    #[must_use]
    pub fn of(assessment: &Assessment<SONARS>) -> Self {
        Self {
            simulation_based: assessment.simulation_based().to_vec(),
            intersection_based: assessment.intersection_based().to_vec(),
            overall: assessment.overall().to_vec(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scan_goes_around_in_order_and_ends_on_walls() {
        let world = World::office();
        let robot = Pose::new(
            Point::from_mm(1800, 2000),
            BinaryAngle::from_millidegrees(33_000),
        );
        let exact = ScannerModel {
            resolution: Millimeters::new(1),
            noise_mm: 0.0,
        };
        let scan = LaserPair::new([exact; 2]).scan(&world, robot, 1, 0);
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
            let place = robot.to_outer(point);
            let clearance = world.obstacles().iter().map(|o| o.clearance(place));
            let nearest = clearance.min_by(f64::total_cmp).unwrap();
            assert!(nearest < 3.0, "{place:?} is {nearest} mm off any wall");
        }
    }

    #[test]
    fn distances_are_multiples_of_the_resolution() {
        let pair = LaserPair::new([ScannerModel::COARSE, ScannerModel::FINE]);
        let robot = Pose::new(Point::from_mm(1800, 2000), BinaryAngle::ZERO);
        let scan = pair.scan(&World::office(), robot, 7, 0);
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
