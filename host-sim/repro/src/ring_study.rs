//! Evaluation of \[003\] at many random poses of a world.
//!
//! [`FaultSweep`] counts the faulty sonars that are found, over every kind of fault; [`Extraction`]
//! compares the polygons with the world.

use certainty_core::sensor::SensorId;
use certainty_core::units::{BinaryAngle, Direction, Millimeters, Point, Pose};
use certainty_ring::{Distances, ElementKind, FinePoint, Folded, Polygon, TooManyElements};
use certainty_sim::quantity;
use certainty_sim::random::{Purpose, stream};
use certainty_sim::ring::{
    ELEMENTS, Face, LaserPair, PointMm, RingDefect, RingFault, RingSimulation, SONARS,
    ScannerModel, Surfaces, Vectors,
};
use certainty_sim::world::World;
use rand::RngExt;
use rayon::prelude::*;
use serde::Serialize;
use thiserror::Error;

/// Faults at many poses of a world.
#[derive(Debug, Clone, Copy)]
pub struct FaultSweep<'a> {
    /// The world, the ring and the lasers.
    pub simulation: &'a RingSimulation<'a>,
    /// The fault of the main result; the rows have all kinds.
    pub defect: RingDefect,
    /// The number of poses.
    pub poses: u32,
    /// The seed of poses, faulty sonars and noise.
    pub seed: u64,
}

/// Why a world cannot be used; displays as one line.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum RingStudyError {
    /// No pose far enough from every obstacle.
    #[error(
        "the world '{0}' has no room for a robot with a radius of 0.4 m: make it larger or move \
         obstacles apart"
    )]
    NoRoom(String),
    /// A scan with too many straight pieces.
    #[error("at {x_mm}mm, {y_mm}mm: {source}: use a world with fewer obstacles")]
    TooManyElements {
        /// The robot's x.
        x_mm: i32,
        /// The robot's y.
        y_mm: i32,
        /// The error.
        source: TooManyElements,
    },
}

/// The result at one pose, without a fault and with one faulty sonar.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PoseResult {
    /// The robot's x in millimetres.
    pub x_mm: i32,
    /// The robot's y in millimetres.
    pub y_mm: i32,
    /// The robot's heading in degrees.
    pub heading_deg: f64,
    /// The faulty sonar.
    pub sensor: u8,
    /// Whether it was declared faulty.
    pub found: bool,
    /// The vectors without the fault.
    pub without_fault: Vectors,
    /// The vectors with it.
    pub with_fault: Vectors,
}

/// One kind of fault, of one or two sonars at once, over all poses.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct KindRow {
    /// The kind.
    pub kind: &'static str,
    /// The number of sonars that have it at once.
    pub faulty_sensors: u8,
    /// The number of faults at all poses.
    pub faults: u32,
    /// The number of them that changed no distance of their sonar by the paper's 0.1 m, so that they cannot be
    /// detected.
    pub without_effect: u32,
    /// The number of them that were detected.
    pub found: u32,
    /// The share of all faults that were detected.
    pub detection_rate: f64,
    /// The share of the faults with an effect that were detected.
    pub detection_rate_with_effect: f64,
    /// The number of sound sonars declared faulty.
    pub false_alarms: u32,
    /// The share of all sound sonars.
    pub false_alarm_rate: f64,
}

/// Least distance of the robot's centre from obstacles, in millimetres: the ring's radius and 0.1 m.
const CLEARANCE: f64 = 400.0;

/// Everything evaluated at one pose.
struct PoseOutcome {
    result: PoseResult,
    /// Sonars declared faulty without a fault.
    false_alarms: u32,
    rows: Vec<Counts>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    faults: u32,
    without_effect: u32,
    found: u32,
    false_alarms: u32,
}

/// The result of a [`FaultSweep`].
#[derive(Debug, Clone, PartialEq)]
pub struct SweepResult {
    /// The result at each pose.
    pub poses: Vec<PoseResult>,
    /// The number of sonars declared faulty without a fault, at all poses together.
    pub false_alarms: u32,
    /// Each kind, with one faulty sonar and with two.
    pub rows: Vec<KindRow>,
}

impl FaultSweep<'_> {
    /// Runs the sweep on rayon's threads; the result does not depend on their number.
    ///
    /// # Errors
    ///
    /// [`RingStudyError`] if the world has no room for the robot or too many straight pieces.
    pub fn run(&self) -> Result<SweepResult, RingStudyError> {
        let poses = random_poses(self.simulation.world(), self.poses, self.seed)?;
        let outcomes: Result<Vec<PoseOutcome>, RingStudyError> = (0..self.poses)
            .into_par_iter()
            .zip(&poses)
            .map(|(part, &pose)| self.at(pose, part))
            .collect();
        let outcomes = outcomes?;
        let sound = |faulty: u32| (SONARS as u32 - faulty) * self.poses;
        let cases = self.cases();
        let rows = cases.iter().enumerate().map(|(number, &(defect, faulty))| {
            let counts = outcomes.iter().map(|outcome| outcome.rows[number]);
            let sum = counts.fold(Counts::default(), |sum, one| Counts {
                faults: sum.faults + one.faults,
                without_effect: sum.without_effect + one.without_effect,
                found: sum.found + one.found,
                false_alarms: sum.false_alarms + one.false_alarms,
            });
            let rate = |part: u32, of: u32| f64::from(part) / f64::from(of.max(1));
            KindRow {
                kind: defect.kind(),
                faulty_sensors: faulty as u8,
                faults: sum.faults,
                without_effect: sum.without_effect,
                found: sum.found,
                detection_rate: rate(sum.found, sum.faults),
                detection_rate_with_effect: rate(sum.found, sum.faults - sum.without_effect),
                false_alarms: sum.false_alarms,
                false_alarm_rate: rate(sum.false_alarms, sound(faulty as u32)),
            }
        });
        Ok(SweepResult {
            rows: rows.collect(),
            false_alarms: outcomes.iter().map(|outcome| outcome.false_alarms).sum(),
            poses: outcomes.into_iter().map(|outcome| outcome.result).collect(),
        })
    }

    fn at(&self, pose: Pose, part: u32) -> Result<PoseOutcome, RingStudyError> {
        let simulation = self.simulation;
        let full = |source| RingStudyError::TooManyElements {
            x_mm: pose.at.x_mm(),
            y_mm: pose.at.y_mm(),
            source,
        };
        let observed = simulation
            .observe(pose, &[], self.seed, part)
            .map_err(full)?;
        let sound = simulation.assess(&observed);
        let sensors = self.pair(part);
        let with_fault = |defect: RingDefect, faulty: usize| {
            let faults: Vec<RingFault> = sensors[..faulty]
                .iter()
                .map(|&sensor| RingFault { sensor, defect })
                .collect();
            let mut observed = observed.clone();
            observed.echoes = simulation.echoes(pose, &faults, self.seed, part);
            simulation.assess(&observed)
        };
        let rows = self.cases().into_iter().map(|(defect, faulty)| {
            let diagnosis = with_fault(defect, faulty);
            let mut counts = Counts::default();
            for sensor in simulation.ring.sensors() {
                let declared = diagnosis.assessment.faulty().any(|found| found == sensor);
                if sensors[..faulty].contains(&sensor) {
                    counts.faults += 1;
                    counts.found += u32::from(declared);
                    let effect = differs(simulation, sensor, &sound.measured, &diagnosis.measured);
                    counts.without_effect += u32::from(!effect);
                } else {
                    counts.false_alarms += u32::from(declared);
                }
            }
            counts
        });
        let rows = rows.collect();
        let diagnosis = with_fault(self.defect, 1);
        Ok(PoseOutcome {
            result: PoseResult {
                x_mm: pose.at.x_mm(),
                y_mm: pose.at.y_mm(),
                heading_deg: quantity::degrees(pose.heading),
                sensor: sensors[0].number(),
                found: diagnosis
                    .assessment
                    .faulty()
                    .any(|found| found == sensors[0]),
                without_fault: Vectors::of(&sound.assessment),
                with_fault: Vectors::of(&diagnosis.assessment),
            },
            false_alarms: sound.assessment.faulty().count() as u32,
            rows,
        })
    }

    /// Every kind of fault, of one sonar and of two; that of [`Self::defect`] with its value.
    fn cases(&self) -> Vec<(RingDefect, usize)> {
        let kinds = RingDefect::ALL.map(|defect| {
            if defect.kind() == self.defect.kind() {
                self.defect
            } else {
                defect
            }
        });
        let counts = kinds.into_iter();
        counts
            .flat_map(|defect| [(defect, 1), (defect, 2)])
            .collect()
    }

    /// Two different sonars, drawn for each pose.
    fn pair(&self, part: u32) -> [SensorId; 2] {
        let mut dice = stream(self.seed, Purpose::Choice, 1, part);
        let first = dice.random_range(0..SONARS);
        let second = (first + dice.random_range(1..SONARS)) % SONARS;
        [first, second].map(|slot| SensorId::from_slot(slot).expect("a slot of 24 has a number"))
    }
}

/// Random poses at which the robot fits.
fn random_poses(world: &World, number: u32, seed: u64) -> Result<Vec<Pose>, RingStudyError> {
    const TRIES: u32 = 10_000;
    let no_room = || RingStudyError::NoRoom(world.name().to_owned());
    let bounds = world.bounds().ok_or_else(no_room)?;
    let mut dice = stream(seed, Purpose::Choice, 0, 0);
    let (low, high) = (bounds.lower_left, bounds.upper_right);
    let mut poses = Vec::new();
    for _ in 0..number {
        let mut tries = (0..TRIES).map(|_| {
            let x = dice.random_range(low.x_mm()..=high.x_mm());
            let y = dice.random_range(low.y_mm()..=high.y_mm());
            let heading = BinaryAngle::from_bits(dice.random());
            Pose::new(Point::from_mm(x, y), heading)
        });
        let pose = tries.find(|pose| fits(world, pose.at));
        poses.push(pose.ok_or_else(no_room)?);
    }
    Ok(poses)
}

/// Whether the robot fits at a point.
fn fits(world: &World, at: Point) -> bool {
    world
        .obstacles()
        .iter()
        .all(|obstacle| obstacle.clearance(at) >= CLEARANCE)
}

/// Returns whether a fault changed the distance of any path of `sensor`.
#[must_use]
pub fn differs(
    simulation: &RingSimulation<'_>,
    sensor: SensorId,
    before: &Distances<SONARS>,
    after: &Distances<SONARS>,
) -> bool {
    let limit = simulation.rules.config().uncertainty.get();
    let paths = simulation.ring.paths().filter(|path| {
        let from = path.from().map(SensorId::slot);
        let to = from.map(|from| (from + usize::from(path.order())) % SONARS);
        from == Some(sensor.slot()) || to == Some(sensor.slot())
    });
    paths
        .into_iter()
        .any(|path| match (before.get(path), after.get(path)) {
            (Folded::Distance(a), Folded::Distance(b)) => a.get().abs_diff(b.get()) >= limit,
            (a, b) => a != b,
        })
}

/// Polygons at many poses compared with the world, at several noises and resolutions of the lasers.
#[derive(Debug, Clone, Copy)]
pub struct Extraction<'a> {
    /// The world and the polygon's rules; its lasers are replaced.
    pub simulation: &'a RingSimulation<'a>,
    /// The number of poses.
    pub poses: u32,
    /// The seed of poses and noise.
    pub seed: u64,
}

/// The result at one noise and resolution.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ExtractionRow {
    /// Resolution of both scanners.
    pub resolution_mm: u32,
    /// Standard deviation of a distance before it is rounded.
    pub noise_mm: f64,
    /// Stretches of flat faces that at least five consecutive beams hit.
    pub segments: u32,
    /// Those of which an element covers at least half, both ends within 60 mm of its line.
    pub segments_found: u32,
    /// Walls in the polygons, pseudo line segments not counted.
    pub walls: u32,
    /// Those of which the middle is more than 60 mm from every surface: they do not exist.
    pub phantom_walls: u32,
    /// Corners and edges of the world both sides of which are such stretches.
    pub corners: u32,
    /// Those with a vertex within 200 mm.
    pub corners_found: u32,
    /// Mean distance of the nearest vertices from them.
    pub mean_corner_error_mm: f64,
    /// The largest distance.
    pub worst_corner_error_mm: f64,
    /// Poses at which the scan had too many straight pieces.
    pub refused: u32,
}

/// A stretch of a face that consecutive beams hit.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    face: usize,
    beams: u32,
    from: PointMm,
    to: PointMm,
}

/// The farthest that a wall of a polygon may be from the surface that it stands for.
const OFF_WALL_MM: f64 = 60.0;

/// The least number of beams of a segment.
const LEAST_BEAMS: u32 = 5;

impl Extraction<'_> {
    /// Resolutions of the paper's two scanners (\[003\] §3), in millimetres.
    pub const RESOLUTIONS: [u32; 2] = [10, 50];
    /// Noise before rounding, in millimetres.
    pub const NOISES: [f64; 4] = [0.0, 5.0, 10.0, 20.0];

    /// Measures every resolution at every noise, on rayon's threads; the result does not depend on their
    /// number.
    ///
    /// # Errors
    ///
    /// [`RingStudyError::NoRoom`] if the robot does not fit anywhere.
    pub fn run(&self) -> Result<Vec<ExtractionRow>, RingStudyError> {
        let poses = random_poses(self.simulation.world(), self.poses, self.seed)?;
        let resolutions = Self::RESOLUTIONS.into_iter();
        let models: Vec<(u32, f64)> = resolutions
            .flat_map(|resolution_mm| Self::NOISES.map(|noise_mm| (resolution_mm, noise_mm)))
            .collect();
        let rows = models.into_par_iter().map(|(resolution_mm, noise_mm)| {
            let model = ScannerModel {
                resolution: Millimeters::new(resolution_mm),
                noise_mm,
            };
            let lasers = LaserPair::new([model; 2]);
            self.row(&lasers, &poses, resolution_mm, noise_mm)
        });
        Ok(rows.collect())
    }

    /// Whether a wall of a polygon does not exist: its middle is far from every surface.
    fn is_phantom(&self, &(from, to): &(PointMm, PointMm)) -> bool {
        let middle = |a: f64, b: f64| (f64::midpoint(a, b)).round() as i32;
        let at = Point::from_mm(middle(from.0, to.0), middle(from.1, to.1));
        let clearance = self.simulation.world().clearance(at);
        clearance.is_none_or(|clearance| clearance > OFF_WALL_MM)
    }

    fn row(
        &self,
        lasers: &LaserPair,
        poses: &[Pose],
        resolution_mm: u32,
        noise_mm: f64,
    ) -> ExtractionRow {
        let surfaces = Surfaces::of(self.simulation.world());
        let mut row = ExtractionRow {
            resolution_mm,
            noise_mm,
            segments: 0,
            segments_found: 0,
            walls: 0,
            phantom_walls: 0,
            corners: 0,
            corners_found: 0,
            mean_corner_error_mm: 0.0,
            worst_corner_error_mm: 0.0,
            refused: 0,
        };
        let mut sum = 0.0;
        for (part, &robot) in (0..).zip(poses) {
            let scan = lasers.scan(self.simulation.world(), robot, self.seed, part);
            let Ok(polygon) = Polygon::<ELEMENTS>::of(&scan, &self.simulation.polygon) else {
                row.refused += 1;
                continue;
            };
            let walls = walls(&polygon, robot);
            row.walls += walls.len() as u32;
            let phantoms = walls.iter().filter(|wall| self.is_phantom(wall));
            row.phantom_walls += phantoms.count() as u32;
            let stretches = stretches(&surfaces, lasers, robot);
            for stretch in &stretches {
                row.segments += 1;
                let found = walls.iter().any(|wall| covers(wall, stretch));
                row.segments_found += u32::from(found);
            }
            for corner in corners(&surfaces, &stretches) {
                row.corners += 1;
                let vertices = polygon
                    .elements()
                    .iter()
                    .map(|e| in_world(e.start(), robot));
                let away = vertices.map(|(x, y)| (x - corner.0).hypot(y - corner.1));
                let nearest = away.fold(f64::INFINITY, f64::min);
                if nearest <= 200.0 {
                    row.corners_found += 1;
                    sum += nearest;
                    row.worst_corner_error_mm = row.worst_corner_error_mm.max(nearest);
                }
            }
        }
        row.mean_corner_error_mm = sum / f64::from(row.corners_found.max(1));
        row
    }
}

/// Transforms a point from the robot's frame to the world's, in millimetres.
fn in_world(point: FinePoint, robot: Pose) -> PointMm {
    let scale = f64::from(1_u32 << Direction::FRACTION_BITS);
    let heading = robot.heading.direction();
    let (cos, sin) = (
        f64::from(heading.cos()) / scale,
        f64::from(heading.sin()) / scale,
    );
    let steps = f64::from(FinePoint::STEPS);
    let (x, y) = (f64::from(point.x()) / steps, f64::from(point.y()) / steps);
    (
        f64::from(robot.at.x_mm()) + x * cos - y * sin,
        f64::from(robot.at.y_mm()) + x * sin + y * cos,
    )
}

/// The polygon's walls in the world.
fn walls(polygon: &Polygon<ELEMENTS>, robot: Pose) -> Vec<(PointMm, PointMm)> {
    let walls = polygon.elements().iter();
    let walls = walls.filter(|element| element.kind() == ElementKind::Wall);
    walls
        .map(|wall| (in_world(wall.start(), robot), in_world(wall.end(), robot)))
        .collect()
}

/// Whether a wall of the polygon covers at least half of a stretch, with both its ends within 60 mm.
fn covers(&(from, to): &(PointMm, PointMm), stretch: &Stretch) -> bool {
    let (x, y) = (to.0 - from.0, to.1 - from.1);
    let length = x.hypot(y);
    if length == 0.0 {
        return false;
    }
    let local = |point: PointMm| {
        let (px, py) = (point.0 - from.0, point.1 - from.1);
        ((px * x + py * y) / length, (px * y - py * x).abs() / length)
    };
    let ((a, off_a), (b, off_b)) = (local(stretch.from), local(stretch.to));
    let shared = a.max(b).min(length) - a.min(b).max(0.0);
    off_a <= OFF_WALL_MM && off_b <= OFF_WALL_MM && shared >= 0.5 * (a - b).abs()
}

/// The stretches of faces that the lasers hit, in the order of the beams.
fn stretches(surfaces: &Surfaces, lasers: &LaserPair, robot: Pose) -> Vec<Stretch> {
    let mut stretches: Vec<Stretch> = Vec::new();
    let mut open: Option<Stretch> = None;
    for scanner in lasers.scanners() {
        let mount = robot.compose(scanner.mount());
        for bearing in LaserPair::bearings() {
            let direction = mount.heading.wrapping_add(bearing).direction();
            let scale = f64::from(1_u32 << Direction::FRACTION_BITS);
            let along = (
                f64::from(direction.cos()) / scale,
                f64::from(direction.sin()) / scale,
            );
            let from = (f64::from(mount.at.x_mm()), f64::from(mount.at.y_mm()));
            let hit = hit(surfaces, from, along);
            match (&mut open, hit) {
                (Some(stretch), Some((face, point))) if stretch.face == face => {
                    stretch.beams += 1;
                    stretch.to = point;
                }
                _ => {
                    stretches.extend(open.take());
                    open = hit.map(|(face, point)| Stretch {
                        face,
                        beams: 1,
                        from: point,
                        to: point,
                    });
                }
            }
        }
    }
    stretches.extend(open);
    stretches.retain(|stretch| stretch.beams >= LEAST_BEAMS);
    stretches
}

/// The flat face that a ray hits first, and the point; `None` if it hits a disc first, or nothing.
fn hit(surfaces: &Surfaces, from: PointMm, along: PointMm) -> Option<(usize, PointMm)> {
    let faces = surfaces
        .faces
        .iter()
        .enumerate()
        .filter_map(|(number, face)| {
            let sine = along.0 * face.along.1 - along.1 * face.along.0;
            let (dx, dy) = (face.from.0 - from.0, face.from.1 - from.1);
            let away = (dx * face.along.1 - dy * face.along.0) / sine;
            let at = (dx * along.1 - dy * along.0) / sine;
            let met = away > 0.0 && (0.0..=face.length).contains(&at);
            met.then_some((away, Some(number)))
        });
    let discs = surfaces.discs.iter().filter_map(|&(centre, radius)| {
        let (dx, dy) = (centre.0 - from.0, centre.1 - from.1);
        let ahead = dx * along.0 + dy * along.1;
        let aside = dx * along.1 - dy * along.0;
        let met = ahead > 0.0 && aside.abs() < radius;
        met.then(|| (ahead - (radius * radius - aside * aside).sqrt(), None))
    });
    let first = faces.chain(discs).min_by(|a, b| a.0.total_cmp(&b.0))?;
    let (away, face) = first;
    Some((face?, (from.0 + along.0 * away, from.1 + along.1 * away)))
}

/// The points where two consecutive stretches meet: corners and edges of the world with both sides hit.
fn corners(surfaces: &Surfaces, stretches: &[Stretch]) -> Vec<PointMm> {
    let next = stretches.iter().cycle().skip(1);
    let pairs = stretches.iter().zip(next).filter_map(|(one, other)| {
        let (a, b): (&Face, &Face) = (&surfaces.faces[one.face], &surfaces.faces[other.face]);
        let sine = a.along.0 * b.along.1 - a.along.1 * b.along.0;
        if sine.abs() < 0.3 {
            return None;
        }
        let (dx, dy) = (b.from.0 - a.from.0, b.from.1 - a.from.1);
        let point = a.at((dx * b.along.1 - dy * b.along.0) / sine);
        let near = |end: PointMm| (end.0 - point.0).hypot(end.1 - point.1) <= 100.0;
        (near(one.to) && near(other.from)).then_some(point)
    });
    pairs.collect()
}
