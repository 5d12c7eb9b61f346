//! How well the polygon shows the world: segments found, and how far corners are off.

use crate::ring_sweep::{Sweep, SweepError};
use certainty_core::units::{Direction, Millimeters, Pose};
use certainty_ring::{ElementKind, FinePoint, Polygon};
use certainty_sim::ring::surfaces::{Face, Place, Surfaces};
use certainty_sim::ring::{ELEMENTS, LaserPair, ScannerModel, Situation};
use serde::Serialize;

/// Polygons at many places against the world, at one noise and resolution.
#[derive(Debug, Clone, Copy)]
pub struct Extraction<'a> {
    /// The world and the polygon's rules; its lasers are replaced.
    pub situation: &'a Situation<'a>,
    /// How many places.
    pub poses: u32,
    /// Names the run.
    pub seed: u64,
}

/// What came out at one noise and resolution.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ExtractionRow {
    /// Resolution of both scanners.
    pub resolution_mm: u32,
    /// Standard deviation of a distance before it is rounded.
    pub noise_mm: f64,
    /// Stretches of flat faces that at least five beams in a row hit.
    pub segments: u32,
    /// Those of which an element covers at least half, both ends within 60 mm of its line.
    pub segments_found: u32,
    /// Walls in the polygons, pseudo line segments not counted.
    pub walls: u32,
    /// Corners and edges of the world of which both sides are such stretches.
    pub corners: u32,
    /// Those with a vertex within 200 mm.
    pub corners_found: u32,
    /// Mean distance of the vertices from them.
    pub mean_corner_error_mm: f64,
    /// The largest distance.
    pub worst_corner_error_mm: f64,
    /// Places whose polygon did not fit.
    pub refused: u32,
}

/// A stretch of a face that the lasers see: where it begins and ends.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    face: usize,
    beams: u32,
    from: Place,
    to: Place,
}

/// Fewer beams than this make no segment that one could ask for.
const LEAST_BEAMS: u32 = 5;

impl Extraction<'_> {
    /// Resolutions of the paper's two scanners (\[003\] §3), in millimetres.
    pub const RESOLUTIONS: [u32; 2] = [10, 50];
    /// Noise before rounding, in millimetres.
    pub const NOISES: [f64; 4] = [0.0, 5.0, 10.0, 20.0];

    /// Measures every resolution at every noise.
    ///
    /// # Errors
    ///
    /// [`SweepError::NoRoom`] if the robot fits nowhere.
    ///
    /// # Panics
    ///
    /// Never: the scanners are within the core's limits.
    pub fn run(&self) -> Result<Vec<ExtractionRow>, SweepError> {
        let sweep = Sweep {
            situation: self.situation,
            defect: certainty_sim::ring::RingDefect::Blind,
            poses: self.poses,
            seed: self.seed,
        };
        let places = sweep.places()?;
        let mut rows = Vec::new();
        for resolution_mm in Self::RESOLUTIONS {
            for noise_mm in Self::NOISES {
                let model = ScannerModel {
                    resolution: Millimeters::new(resolution_mm),
                    noise_mm,
                };
                let lasers = LaserPair::try_new([model; 2]).expect("within the core's limits");
                rows.push(self.row(&lasers, &places, resolution_mm, noise_mm));
            }
        }
        Ok(rows)
    }

    fn row(
        &self,
        lasers: &LaserPair,
        places: &[Pose],
        resolution_mm: u32,
        noise_mm: f64,
    ) -> ExtractionRow {
        let surfaces = Surfaces::of(self.situation.world());
        let mut row = ExtractionRow {
            resolution_mm,
            noise_mm,
            segments: 0,
            segments_found: 0,
            walls: 0,
            corners: 0,
            corners_found: 0,
            mean_corner_error_mm: 0.0,
            worst_corner_error_mm: 0.0,
            refused: 0,
        };
        let mut sum = 0.0;
        for (part, &robot) in (0..).zip(places) {
            let scan = lasers.scan(self.situation.world(), robot, self.seed, part);
            let scan = scan.expect("the scan has room for the lasers' beams");
            let Ok(polygon) = Polygon::<ELEMENTS>::of(&scan, &self.situation.polygon) else {
                row.refused += 1;
                continue;
            };
            let walls = walls(&polygon, robot);
            row.walls += walls.len() as u32;
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

/// A place in the robot's frame, in the world's.
fn in_world(place: FinePoint, robot: Pose) -> Place {
    let scale = f64::from(1_u32 << Direction::FRACTION_BITS);
    let heading = robot.heading.direction();
    let (cos, sin) = (
        f64::from(heading.cos()) / scale,
        f64::from(heading.sin()) / scale,
    );
    let steps = f64::from(FinePoint::STEPS);
    let (x, y) = (f64::from(place.x()) / steps, f64::from(place.y()) / steps);
    (
        f64::from(robot.at.x_mm()) + x * cos - y * sin,
        f64::from(robot.at.y_mm()) + x * sin + y * cos,
    )
}

/// The polygon's walls in the world.
fn walls(polygon: &Polygon<ELEMENTS>, robot: Pose) -> Vec<(Place, Place)> {
    let walls = polygon.elements().iter();
    let walls = walls.filter(|element| element.kind() == ElementKind::Wall);
    walls
        .map(|wall| (in_world(wall.start(), robot), in_world(wall.end(), robot)))
        .collect()
}

/// Whether a wall of the polygon shows at least half of a stretch, both its ends within 60 mm.
fn covers(&(from, to): &(Place, Place), stretch: &Stretch) -> bool {
    let (x, y) = (to.0 - from.0, to.1 - from.1);
    let length = x.hypot(y);
    if length == 0.0 {
        return false;
    }
    let local = |place: Place| {
        let (px, py) = (place.0 - from.0, place.1 - from.1);
        ((px * x + py * y) / length, (px * y - py * x).abs() / length)
    };
    let ((a, off_a), (b, off_b)) = (local(stretch.from), local(stretch.to));
    let shared = a.max(b).min(length) - a.min(b).max(0.0);
    off_a <= 60.0 && off_b <= 60.0 && shared >= 0.5 * (a - b).abs()
}

/// The stretches of faces that the lasers see, in the beams' order.
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
                (Some(stretch), Some((face, place))) if stretch.face == face => {
                    stretch.beams += 1;
                    stretch.to = place;
                }
                _ => {
                    stretches.extend(open.take());
                    open = hit.map(|(face, place)| Stretch {
                        face,
                        beams: 1,
                        from: place,
                        to: place,
                    });
                }
            }
        }
    }
    stretches.extend(open);
    stretches.retain(|stretch| stretch.beams >= LEAST_BEAMS);
    stretches
}

/// The flat face that a ray meets first, and where; `None` if that is something round, or nothing.
fn hit(surfaces: &Surfaces, from: Place, along: Place) -> Option<(usize, Place)> {
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

/// Where two stretches in a row meet: a corner or an edge of the world, both of whose sides are seen.
fn corners(surfaces: &Surfaces, stretches: &[Stretch]) -> Vec<Place> {
    let next = stretches.iter().cycle().skip(1);
    let pairs = stretches.iter().zip(next).filter_map(|(one, other)| {
        let (a, b): (&Face, &Face) = (&surfaces.faces[one.face], &surfaces.faces[other.face]);
        let sine = a.along.0 * b.along.1 - a.along.1 * b.along.0;
        if sine.abs() < 0.3 {
            return None;
        }
        let (dx, dy) = (b.from.0 - a.from.0, b.from.1 - a.from.1);
        let place = a.at((dx * b.along.1 - dy * b.along.0) / sine);
        let near = |end: Place| (end.0 - place.0).hypot(end.1 - place.1) <= 100.0;
        (near(one.to) && near(other.from)).then_some(place)
    });
    pairs.collect()
}
