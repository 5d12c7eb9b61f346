//! Charts of one observation, after the figures of \[003\].

use super::acoustics::SONARS;
use super::simulation::{Observation, RingDiagnosis, RingSimulation, Vectors};
use crate::export::{ExportError, OutDir};
use crate::plot::{Axis, BarChart, BarSeries, Ink, Layer, Plan};
use certainty_core::units::BinaryAngle;
use certainty_ring::{
    Distances, Element, ElementKind, FinePoint, Folded, Path, independent_overlaps,
};
use std::path::PathBuf;

/// A point of the robot's frame, in metres.
type Metres = (f64, f64);

/// Writes the scan with its polygon (figures 1 and 2), the simulated echoes (3), the measured echoes (4),
/// the intersections of their arcs (5), and the three vectors; each as PNG and SVG.
///
/// # Errors
///
/// [`ExportError`] if a file cannot be written.
pub fn draw(
    simulation: &RingSimulation<'_>,
    observation: &Observation,
    diagnosis: &RingDiagnosis,
    out: &OutDir,
) -> Result<Vec<PathBuf>, ExportError> {
    let mut files = Vec::new();
    let elements = observation.polygon.elements();
    let outline = |kind: ElementKind| {
        let of_kind = elements
            .iter()
            .filter(move |element| element.kind() == kind);
        of_kind.map(line).collect::<Vec<_>>()
    };
    let points: Vec<Metres> = observation
        .scan
        .points()
        .map(|point| (f64::from(point.x_mm()) / 1e3, f64::from(point.y_mm()) / 1e3))
        .collect();
    let layer = Layer::new;
    let walls = || layer("wall", Ink::Solid, outline(ElementKind::Wall));
    let pseudo = || {
        layer(
            "pseudo line segment",
            Ink::Dashed,
            outline(ElementKind::Pseudo),
        )
    };
    let vertices = elements
        .iter()
        .map(|element| metres(element.start()))
        .collect();
    let scan = Plan {
        title: "Laser scan and polygon, robot's frame".into(),
        layers: vec![
            walls(),
            pseudo(),
            layer("vertex", Ink::Marks, vec![vertices]),
            layer("laser reading", Ink::Dots, vec![points]),
        ],
    };
    files.extend(scan.write(out, "ring-scan")?);
    let arcs = |distances: &Distances<SONARS>, across: bool| -> Vec<Vec<Metres>> {
        let paths = simulation
            .ring
            .paths()
            .filter(|path| (path.order() > 0) == across);
        paths.map(|path| arc(simulation, path, distances)).collect()
    };
    let echoes = |title: &str, distances: &Distances<SONARS>| Plan {
        title: title.to_owned(),
        layers: vec![
            walls(),
            layer("direct echo", Ink::Thin, arcs(distances, false)),
            layer("cross echo", Ink::Thin, arcs(distances, true)),
        ],
    };
    let simulated = echoes("Echoes simulated from the polygon", &diagnosis.expected);
    files.extend(simulated.write(out, "ring-simulated")?);
    let measured = echoes("Echoes heard", &diagnosis.measured);
    files.extend(measured.write(out, "ring-heard")?);
    let crossings = Plan {
        title: "Where independent echoes meet".into(),
        layers: vec![
            layer("direct echo", Ink::Thin, arcs(&diagnosis.measured, false)),
            layer("cross echo", Ink::Thin, arcs(&diagnosis.measured, true)),
            layer(
                "intersection",
                Ink::Dots,
                vec![intersections(simulation, diagnosis)],
            ),
        ],
    };
    files.extend(crossings.write(out, "ring-intersections")?);
    files.extend(vectors(diagnosis).write(out, "ring-vectors")?);
    Ok(files)
}

fn metres(place: FinePoint) -> Metres {
    let steps = f64::from(FinePoint::STEPS) * 1e3;
    (f64::from(place.x()) / steps, f64::from(place.y()) / steps)
}

fn line(element: &Element) -> Vec<Metres> {
    vec![metres(element.start()), metres(element.end())]
}

/// An echo's arc as a function of the direction, for drawing: centre, semi-axes and extent.
struct Curve {
    middle: f64,
    offset: f64,
    ahead: f64,
    aside: f64,
    half: f64,
}

impl Curve {
    fn of(
        simulation: &RingSimulation<'_>,
        path: Path,
        distances: &Distances<SONARS>,
    ) -> Option<Self> {
        let ring = simulation.ring.config();
        // A path without an echo has the range as its distance, and no arc that could meet another.
        let Folded::Distance(distance) = distances.get(path) else {
            return None;
        };
        if distance >= ring.range {
            return None;
        }
        let spacing = core::f64::consts::TAU / SONARS as f64;
        let turned = f64::from(path.order()) * spacing / 2.0;
        let radius = f64::from(ring.radius.get()) / 1e3;
        let (offset, focal) = (radius * turned.cos(), radius * turned.sin());
        let ahead = f64::from(distance.get()) / 1e3;
        let curve = Self {
            middle: radians(simulation.ring.middle(path)),
            offset,
            ahead,
            aside: ahead.hypot(focal),
            half: 0.0,
        };
        // As far as the cones of both sonars: the bearing to the point is within half the opening angle.
        let opening = (f64::from(ring.opening_millidegrees) / 2e3).to_radians();
        let inside = |aside: f64| {
            let r = curve.radius(aside);
            [-turned, turned].iter().all(|axis| {
                let (x, y) = (
                    r * aside.cos() - radius * axis.cos(),
                    r * aside.sin() - radius * axis.sin(),
                );
                let off = y.atan2(x) - axis;
                off.abs() <= opening + 1e-9
            })
        };
        let steps = (0..=400).map(|step| opening * f64::from(step) / 400.0);
        let half = steps.take_while(|&aside| inside(aside)).last()?;
        Some(Self { half, ..curve })
    }

    /// The distance from the robot's centre in the direction `aside` of the arc's middle.
    fn radius(&self, aside: f64) -> f64 {
        let (sin, cos) = aside.sin_cos();
        let (a, b, m) = (self.aside, self.ahead, self.offset);
        let across = (a * cos).powi(2) + (b * sin).powi(2);
        let under = (across - (m * sin).powi(2)).max(0.0);
        (a * a * m * cos + a * b * under.sqrt()) / across
    }

    fn at(&self, aside: f64) -> Metres {
        let (radius, direction) = (self.radius(aside), self.middle + aside);
        (radius * direction.cos(), radius * direction.sin())
    }
}

fn radians(angle: BinaryAngle) -> f64 {
    f64::from(angle.to_bits()) / 65536.0 * core::f64::consts::TAU
}

fn arc(simulation: &RingSimulation<'_>, path: Path, distances: &Distances<SONARS>) -> Vec<Metres> {
    const STEPS: i32 = 24;
    let Some(curve) = Curve::of(simulation, path, distances) else {
        return Vec::new();
    };
    let steps = -STEPS..=STEPS;
    steps
        .map(|step| curve.at(curve.half * f64::from(step) / f64::from(STEPS)))
        .collect()
}

/// The points where arcs of independent overlaps cross, found in small steps, for drawing only.
fn intersections(simulation: &RingSimulation<'_>, diagnosis: &RingDiagnosis) -> Vec<Metres> {
    const STEPS: i32 = 120;
    let mut points = Vec::new();
    for sensor in simulation.ring.sensors() {
        for overlap in independent_overlaps(&simulation.ring, sensor) {
            let curve = |path| Curve::of(simulation, path, &diagnosis.measured);
            let Some((own, other)) = curve(overlap.own).zip(curve(overlap.other)) else {
                continue;
            };
            let turn = core::f64::consts::TAU;
            let apart = (other.middle - own.middle + turn / 2.0).rem_euclid(turn) - turn / 2.0;
            let from = (-own.half).max(apart - other.half);
            let to = own.half.min(apart + other.half);
            let mut before = None;
            for step in 0..=STEPS {
                let at = from + (to - from) * f64::from(step) / f64::from(STEPS);
                let gap = own.radius(at) - other.radius(at - apart);
                if from <= to && before.is_some_and(|was: bool| was != (gap > 0.0)) {
                    points.push(own.at(at));
                }
                before = Some(gap > 0.0);
            }
        }
    }
    points
}

fn vectors(diagnosis: &RingDiagnosis) -> BarChart {
    let vectors = Vectors::of(&diagnosis.assessment);
    let bars = |name: &str, values: &[u8]| BarSeries {
        name: name.to_owned(),
        values: values.iter().map(|&value| Some(value.into())).collect(),
        errors: None,
    };
    BarChart {
        title: "Confidence of each sonar".into(),
        y: Axis::counting("confirmations"),
        groups: (1..=SONARS).map(|number| number.to_string()).collect(),
        bars: vec![
            bars("simulation-based", &vectors.simulation_based),
            bars("intersection-based", &vectors.intersection_based),
            bars("overall", &vectors.overall),
        ],
    }
}
