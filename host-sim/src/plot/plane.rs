//! Charts of a plane to scale: a unit is as long upwards as it is to the right.

use super::Line;
use super::axis::{Axis, Scale};
use super::canvas::{Area, Draw, Drawn, fitted, width, write};
use super::frame::{
    Frame, GREY, INK, LABEL, LEFT, Layout, PAPER, Place, RIGHT, Sign, Stroke, Texts, X_TICKS,
    Y_TICKS, series,
};
use super::lines::finite;
use crate::export::{ExportError, OutDir};
use plotters::prelude::DrawingBackend;
use std::path::PathBuf;

/// The first and the last value along an axis.
type Range = (f64, f64);

/// The largest value of which differences and margins are finite.
const LARGEST: f64 = 1e300;

/// Two axes on which a unit has the same number of pixels.
#[derive(Debug)]
struct Plane {
    x: Scale,
    y: Scale,
    titles: [String; 2],
    /// The ranges that the axes show.
    shown: [Range; 2],
}

impl Plane {
    /// Shows these ranges with a margin, and more along one axis than requested.
    fn new(unit: &str, legend: &[(String, Sign)], [x, y]: [Range; 2]) -> Self {
        let bounded = |value: f64| value.clamp(-LARGEST, LARGEST);
        let [x, y] = [x, y].map(|(from, to)| (bounded(from), bounded(to)));
        let margin = 0.05 * (x.1 - x.0).max(y.1 - y.0).max(0.1);
        let [wide, high] = [x, y].map(|(from, to)| to - from + 2.0 * margin);
        let [across, upwards] = Self::pixels(legend);
        let unit_pixels = (across / wide).min(upwards / high);
        let around = |(from, to): Range, pixels: f64| {
            let (middle, half) = (f64::midpoint(from, to), pixels / unit_pixels / 2.0);
            (middle - half, middle + half)
        };
        let shown = [around(x, across), around(y, upwards)];
        let axis = |name, (from, to): Range, ticks| {
            let axis = Axis::new(name, unit).from(from).to(to);
            let scale = Scale::covering(&axis, [from, to].into_iter(), ticks);
            (scale, axis.title().to_owned())
        };
        let (x, x_title) = axis("x", shown[0], X_TICKS);
        let (y, y_title) = axis("y", shown[1], Y_TICKS);
        Self {
            x,
            y,
            titles: [x_title, y_title],
            shown,
        }
    }

    /// The size of the data's part of the picture, in pixels.
    fn pixels(legend: &[(String, Sign)]) -> [f64; 2] {
        let texts = Texts {
            title: "",
            x: "x",
            y: "y",
            legend,
            above: 0.0,
        };
        let layout = Layout::new(texts, &Scale::of_names(&[]));
        [RIGHT - LEFT, layout.bottom - layout.top]
    }

    fn frame<'a, D: DrawingBackend>(
        &self,
        area: &'a Area<D>,
        title: &str,
        legend: &[(String, Sign)],
    ) -> Drawn<D, Frame<'a, D>> {
        let [x, y] = &self.titles;
        let texts = Texts {
            title,
            x,
            y,
            legend,
            above: 0.0,
        };
        Frame::new(area, texts, &self.x, &self.y)
    }
}

/// Paths over a map seen from above, with obstacles and named places.
///
/// The chart shows the paths, the spots, and what lies around them within half of their size, so that
/// a distant obstacle does not shrink the path to a dot.
///
/// # Examples
/// ```
/// use certainty_sim::export::OutDir;
/// use certainty_sim::plot::{Line, Spot, TrackChart};
///
/// let chart = TrackChart {
///     title: "Round a box".into(),
///     unit: "m".into(),
///     obstacles: vec![vec![(1.0, -0.5), (2.0, -0.5), (2.0, 0.5), (1.0, 0.5)]],
///     cells: Vec::new(),
///     tracks: vec![Line::new("robot", vec![(0.0, 0.0), (1.5, 1.2), (3.0, 0.0)])],
///     spots: vec![Spot::new("start", (0.0, 0.0)), Spot::new("goal", (3.0, 0.0)).within(0.5)],
/// };
/// let folder = tempfile::tempdir().unwrap();
/// chart.write(&OutDir::create(folder.path())?, "track")?;
/// # Ok::<(), certainty_sim::export::ExportError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct TrackChart {
    /// What the chart shows.
    pub title: String,
    /// The unit of all coordinates.
    pub unit: String,
    /// Outlines of the obstacles.
    pub obstacles: Vec<Vec<(f64, f64)>>,
    /// Outlines of a map's occupied cells, drawn over the obstacles.
    pub cells: Vec<Vec<(f64, f64)>>,
    /// The paths, the first lowest.
    pub tracks: Vec<Line>,
    /// Places with a name, such as the start.
    pub spots: Vec<Spot>,
}

/// A named place: a ring, or if it has a radius, a dot in a circle.
#[derive(Debug, Clone, PartialEq)]
pub struct Spot {
    name: String,
    at: (f64, f64),
    radius: Option<f64>,
}

impl Spot {
    /// Creates a spot without a radius.
    #[must_use]
    pub fn new(name: &str, at: (f64, f64)) -> Self {
        Self {
            name: name.to_owned(),
            at,
            radius: None,
        }
    }

    /// Draws a circle of `radius` around it, such as that within which a goal is reached.
    #[must_use]
    pub fn within(self, radius: f64) -> Self {
        Self {
            radius: Some(radius).filter(|radius| radius.is_finite()),
            ..self
        }
    }

    /// The closed circle, or the spot itself without a radius.
    fn circle(&self) -> Vec<Place> {
        let (Some(radius), (x, y)) = (self.radius, self.at) else {
            return vec![self.at];
        };
        let parts = (0..=64).map(|part| f64::from(part) / 64.0 * core::f64::consts::TAU);
        parts
            .map(|angle| (x + radius * angle.cos(), y + radius * angle.sin()))
            .collect()
    }
}

/// How far around paths and spots the surroundings are shown, in parts of their size.
const SURROUNDINGS: f64 = 0.5;

/// The radius of a spot's dot, in pixels.
const DOT: f64 = 9.0;

impl TrackChart {
    /// Writes the chart as `STEM.png` and `STEM.svg`.
    ///
    /// # Errors
    /// If `stem` is not a plain file name or a file cannot be put in place.
    pub fn write(&self, out: &OutDir, stem: &str) -> Result<[PathBuf; 2], ExportError> {
        write(self, out, stem)
    }

    /// The range of the paths, the spots, and what lies near them; of everything without path and
    /// spot; `None` without any place.
    fn extent(&self) -> Option<[Range; 2]> {
        let circles: Vec<_> = self.spots.iter().map(Spot::circle).collect();
        let paths = self.tracks.iter().map(|track| &track.points);
        let places = paths.chain(&circles).flatten();
        let outlines = || self.obstacles.iter().chain(&self.cells);
        let Some([x, y]) = around(places) else {
            return around(outlines().flatten());
        };
        let margin = SURROUNDINGS * (x.1 - x.0).max(y.1 - y.0);
        let near = [x, y].map(|(from, to)| (from - margin, to + margin));
        let pieces = outlines().flat_map(|outline| clipped(outline, near));
        let corners = [(x.0, y.0), (x.1, y.1)];
        let all: Vec<_> = pieces.chain(corners).collect();
        around(all.iter())
    }

    fn draw_spots<D: DrawingBackend>(&self, frame: &mut Frame<'_, D>) -> Drawn<D> {
        let mut taken: Vec<[Place; 2]> = Vec::new();
        let spots = || self.spots.iter().filter(|spot| finite(&spot.at));
        for spot in spots() {
            if spot.radius.is_some() {
                frame.line(spot.circle(), Stroke::solid(INK, 2.0))?;
            }
            frame.dot(spot.at, DOT, INK)?;
            if spot.radius.is_none() {
                frame.dot(spot.at, DOT * 0.55, PAPER)?;
            }
            let at = frame.pixel(spot.at);
            taken.push([(at.0 - DOT, at.1 - DOT), (at.0 + DOT, at.1 + DOT)]);
        }
        for spot in spots() {
            let beside = frame.pixel((spot.at.0 + spot.radius.unwrap_or(0.0), spot.at.1));
            let at = frame.pixel(spot.at);
            // Clear of the circle along its diagonal.
            let away = DOT.max((beside.0 - at.0) * 0.75) + 4.0;
            let corners = self.label(frame, &spot.name, (at, away), &taken)?;
            taken.push(corners);
        }
        Ok(())
    }

    /// Writes a name `away` from a pixel, where it covers least, and returns the corners of its box.
    fn label<D: DrawingBackend>(
        &self,
        frame: &Frame<'_, D>,
        name: &str,
        (at, away): (Place, f64),
        taken: &[[Place; 2]],
    ) -> Drawn<D, [Place; 2]> {
        let Layout { top, bottom, .. } = frame.layout;
        let name = fitted(name, LABEL, (RIGHT - LEFT) / 3.0);
        let wide = width(&name, LABEL);
        let corners = |(x, base): Place| {
            let (above, below) = (base - LABEL * 0.85, base + LABEL * 0.3);
            [(x - 3.0, above), (x + wide + 3.0, below)]
        };
        let free = |&place: &Place| {
            let [a, b] = corners(place);
            let within = a.0 >= LEFT && b.0 <= RIGHT && a.1 >= top && b.1 <= bottom;
            let mut taken = taken.iter();
            within && taken.all(|[c, d]| b.0 <= c.0 || d.0 <= a.0 || b.1 <= c.1 || d.1 <= a.1)
        };
        let off_the_paths = |&place: &Place| {
            let [a, b] = corners(place);
            let mut steps = self.tracks.iter().flat_map(|track| track.points.windows(2));
            steps.all(|step| {
                let step = step.iter().copied().filter(finite);
                let step: Vec<Place> = step.map(|at| frame.pixel(at)).collect();
                clipped(&step, [(a.0, b.0), (a.1, b.1)]).is_empty()
            })
        };
        let above_right = (at.0 + away, at.1 - away);
        let (left, below) = (at.0 - away - wide, at.1 + away + LABEL * 0.8);
        let places = [
            above_right,
            (above_right.0, below),
            (left, above_right.1),
            (left, below),
        ];
        let mut free = places.iter().copied().filter(free);
        let first = free.clone().next().unwrap_or(above_right);
        let place = free.find(off_the_paths).unwrap_or(first);
        let corners = corners(place);
        // Letters stay readable on obstacles.
        frame.pixel_rectangle(corners, PAPER, 0.7)?;
        frame.label(&name, place, wide + 1.0)?;
        Ok(corners)
    }
}

impl Draw for TrackChart {
    fn draw<D: DrawingBackend>(&self, area: &Area<D>) -> Drawn<D> {
        let signs = self.tracks.iter().enumerate();
        let signs = signs.map(|(index, line)| (line.name.clone(), Sign::Line(line.stroke(index))));
        let legend: Vec<_> = signs.filter(|_| self.tracks.len() > 1).collect();
        let extent = self.extent();
        let plane = Plane::new(&self.unit, &legend, extent.unwrap_or_default());
        let mut frame = plane.frame(area, &self.title, &legend)?;
        for (outlines, colour, opacity) in [
            (&self.obstacles, GREY, 0.55),
            (&self.cells, series(5), 0.45),
        ] {
            for outline in outlines {
                frame.area(clipped(outline, plane.shown), colour, opacity)?;
            }
        }
        for (index, line) in self.tracks.iter().enumerate() {
            for run in line
                .points
                .split(|at| !finite(at))
                .filter(|run| run.len() > 1)
            {
                frame.line(run.to_vec(), line.stroke(index))?;
            }
        }
        self.draw_spots(&mut frame)?;
        if extent.is_none() {
            frame.no_data()?;
        }
        frame.finish()
    }
}

/// Layers of lines and points on a plane, to scale.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// What the chart shows.
    pub title: String,
    /// The layers, the first lowest; each has a colour and an entry in the legend.
    pub layers: Vec<Layer>,
}

/// Lines or points of one kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Its name in the legend.
    pub name: String,
    /// How it is drawn.
    pub ink: Ink,
    /// Lines through places, or single places; in metres.
    pub runs: Vec<Vec<(f64, f64)>>,
}

/// How a layer is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ink {
    /// Lines.
    Solid,
    /// Dashed lines.
    Dashed,
    /// Thin lines, for many.
    Thin,
    /// Dots.
    Dots,
    /// Larger dots, for few.
    Marks,
}

impl Ink {
    const fn stroke(self, index: usize) -> Stroke {
        Stroke {
            colour: series(index),
            width: if matches!(self, Self::Thin) { 1.5 } else { 4.0 },
            dashed: matches!(self, Self::Dashed),
        }
    }

    /// The radius of a dot, in pixels.
    const fn radius(self) -> Option<f64> {
        match self {
            Self::Solid | Self::Dashed | Self::Thin => None,
            Self::Dots => Some(3.0),
            Self::Marks => Some(7.0),
        }
    }
}

impl Plan {
    /// Writes the plan as `STEM.png` and `STEM.svg`.
    ///
    /// # Errors
    /// If `stem` is not a plain file name or a file cannot be put in place.
    pub fn write(&self, out: &OutDir, stem: &str) -> Result<[PathBuf; 2], ExportError> {
        write(self, out, stem)
    }
}

impl Draw for Plan {
    fn draw<D: DrawingBackend>(&self, area: &Area<D>) -> Drawn<D> {
        let legend = self.layers.iter().enumerate();
        let legend = legend.map(|(index, layer)| {
            let sign = match layer.ink.radius() {
                Some(radius) => Sign::Dot(series(index), radius),
                None => Sign::Line(layer.ink.stroke(index)),
            };
            (layer.name.clone(), sign)
        });
        let legend: Vec<_> = legend.collect();
        let places = self.layers.iter().flat_map(|layer| &layer.runs).flatten();
        let range = around(places);
        let plane = Plane::new("m", &legend, range.unwrap_or([(-1.0, 1.0); 2]));
        let mut frame = plane.frame(area, &self.title, &legend)?;
        for (index, layer) in self.layers.iter().enumerate() {
            for run in &layer.runs {
                let run: Vec<Place> = run.iter().copied().filter(finite).collect();
                match layer.ink.radius() {
                    Some(radius) => {
                        for place in run {
                            frame.dot(place, radius, series(index))?;
                        }
                    }
                    None if run.len() > 1 => frame.line(run, layer.ink.stroke(index))?,
                    None => {}
                }
            }
        }
        if range.is_none() {
            frame.no_data()?;
        }
        frame.finish()
    }
}

/// The smallest range along both axes that holds all finite `places`; `None` if there is none.
fn around<'a>(places: impl Iterator<Item = &'a (f64, f64)>) -> Option<[Range; 2]> {
    let places = places.filter(|place| finite(place));
    places.fold(None, |range, &(x, y)| {
        let [across, upwards] = range.unwrap_or([(x, x), (y, y)]);
        Some([
            (across.0.min(x), across.1.max(x)),
            (upwards.0.min(y), upwards.1.max(y)),
        ])
    })
}

/// The corners of the part of `outline` within a rectangle; empty if nothing lies in it.
///
/// Sutherland and Hodgman's algorithm, exact for convex outlines.
fn clipped(outline: &[(f64, f64)], [x, y]: [Range; 2]) -> Vec<(f64, f64)> {
    let corners = outline.iter().filter(|place| finite(place));
    let mut corners: Vec<(f64, f64)> = corners
        .map(|&(x, y)| (x.clamp(-LARGEST, LARGEST), y.clamp(-LARGEST, LARGEST)))
        .collect();
    // How far a place is within each side.
    let sides: [&dyn Fn((f64, f64)) -> f64; 4] = [
        &|place| place.0 - x.0,
        &|place| x.1 - place.0,
        &|place| place.1 - y.0,
        &|place| y.1 - place.1,
    ];
    for within in sides {
        let before = corners.iter().cycle().skip(corners.len().max(1) - 1);
        let edges = before.zip(&corners);
        let kept = edges.flat_map(|(&from, &to)| {
            let (a, b) = (within(from), within(to));
            let crossing = ((a < 0.0) != (b < 0.0)).then(|| {
                let part = a / (a - b);
                (
                    from.0 + (to.0 - from.0) * part,
                    from.1 + (to.1 - from.1) * part,
                )
            });
            crossing.into_iter().chain((b >= 0.0).then_some(to))
        });
        corners = kept.collect();
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn chart(points: Vec<Place>) -> TrackChart {
        TrackChart {
            title: "track".into(),
            unit: "m".into(),
            obstacles: vec![vec![(1.0, -2.0), (2.0, -2.0), (2.0, -1.0), (1.0, -1.0)]],
            cells: Vec::new(),
            tracks: vec![Line::new("robot", points)],
            spots: Vec::new(),
        }
    }

    #[test]
    fn distant_obstacle_does_not_shrink_path() {
        let mut chart = chart(vec![(0.0, 0.0), (10.0, 0.0)]);
        let near = chart.extent();
        let far = vec![(9e4, 0.0), (1e5, 0.0), (1e5, 1.0)];
        chart.obstacles.push(far);
        assert_eq!(chart.extent(), near);
        // A wall across the path is shown in part.
        let wall = vec![(5.0, -1e4), (5.1, -1e4), (5.1, 1e4), (5.0, 1e4)];
        chart.obstacles.push(wall);
        let [x, y] = chart.extent().unwrap();
        assert_eq!((x, y), ((0.0, 10.0), (-5.0, 5.0)));
    }

    #[test]
    fn area_is_clipped_to_rectangle() {
        let range = [(0.0, 4.0), (0.0, 2.0)];
        let square = [(1.0, 1.0), (3.0, 1.0), (3.0, 3.0), (1.0, 3.0)];
        let cut = clipped(&square, range);
        assert_eq!(around(cut.iter()), Some([(1.0, 3.0), (1.0, 2.0)]));
        let within = [(1.0, 0.5), (2.0, 0.5), (2.0, 1.5)];
        let mut same = clipped(&within, range);
        let first = same.iter().position(|&at| at == within[0]);
        same.rotate_left(first.unwrap());
        assert_eq!(same, within);
        let around_all = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)];
        assert_eq!(around(clipped(&around_all, range).iter()), Some(range));
        // A rhombus whose corners all lie outside; clamped to the sides it would be another shape.
        let rhombus = [(2.0, -1.0), (5.0, 1.0), (2.0, 3.0), (-1.0, 1.0)];
        assert_eq!(clipped(&rhombus, range).len(), 8);
        for none in [
            &[][..],
            &[(5.0, 5.0), (6.0, 5.0), (6.0, 6.0)],
            &[(f64::NAN, 0.0)],
        ] {
            assert_eq!(clipped(none, range), []);
        }
    }

    proptest! {
        #[test]
        fn unit_is_as_long_upwards_as_across(
            x in (-1e4..1e4, 0.0..300.0),
            y in (-1e4..1e4, 0.0..300.0),
            legend in 0..4_usize,
        ) {
            let [x, y]: [Range; 2] = [x, y].map(|(from, length): Range| (from, from + length));
            let legend = vec![("a line".to_owned(), Sign::Area(GREY)); legend];
            let plane = Plane::new("m", &legend, [x, y]);
            let [across, upwards] = Plane::pixels(&legend);
            let [shown_x, shown_y] = plane.shown;
            let (across, upwards) = (across / (shown_x.1 - shown_x.0), upwards / (shown_y.1 - shown_y.0));
            prop_assert!((across / upwards - 1.0).abs() < 1e-3, "{across} {upwards}");
            prop_assert!(shown_x.0 <= x.0 && x.1 <= shown_x.1);
            prop_assert!(shown_y.0 <= y.0 && y.1 <= shown_y.1);
        }

        #[test]
        fn any_ranges_have_a_plane(places in prop::collection::vec(any::<Place>(), 0..4)) {
            let range = around(places.iter());
            prop_assert_eq!(range.is_some(), places.iter().any(finite));
            let plane = Plane::new("m", &[], range.unwrap_or_default());
            for (x, y) in places.iter().filter(|place| finite(place)) {
                let parts = [plane.x.part(*x), plane.y.part(*y)];
                prop_assert!(parts.iter().all(|part| (0.0..=1.0).contains(part)), "{parts:?}");
            }
        }
    }
}
