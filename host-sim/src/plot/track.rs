//! Ways over a plane: where something went, and what stood there.

use super::Line;
use super::font;
use super::frame::{LABEL, Sign, thin};
use super::palette::{FRAME, INK, PAPER, series};
use super::picture::{Picture, Place};
use super::to_scale::{Range, ToScale, around, clipped, finite};
use crate::export::{ExportError, OutDir};
use std::path::PathBuf;

/// Lines over a map seen from above; a metre is as long upwards as it is to the right.
///
/// What is shown is the ways, the spots, and around them what lies within half of their size: an
/// obstacle far off does not make the way a dot.
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
    /// Outlines of what stands there.
    pub obstacles: Vec<Vec<(f64, f64)>>,
    /// Outlines of what a map says stands there, drawn over the obstacles.
    pub cells: Vec<Vec<(f64, f64)>>,
    /// The ways, the first lowest.
    pub tracks: Vec<Line>,
    /// Places with a name, such as the start.
    pub spots: Vec<Spot>,
}

/// A place with its name beside it: a ring, or where it has a radius a dot in a circle.
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

    /// Draws a circle of `radius` around it: what counts as being there.
    #[must_use]
    pub fn within(self, radius: f64) -> Self {
        Self {
            radius: Some(radius).filter(|radius| radius.is_finite()),
            ..self
        }
    }

    /// The circle, closed; the spot itself where it has none.
    fn circle(&self) -> Vec<(f64, f64)> {
        let (Some(radius), (x, y)) = (self.radius, self.at) else {
            return vec![self.at];
        };
        let parts = (0..=64).map(|part| f64::from(part) / 64.0 * core::f64::consts::TAU);
        parts
            .map(|angle| (x + radius * angle.cos(), y + radius * angle.sin()))
            .collect()
    }
}

/// How far around ways and spots the surroundings are shown, in parts of their size.
const SURROUNDINGS: f64 = 0.5;

/// The radius of a spot's dot, in pixels.
const DOT: f64 = 9.0;

impl TrackChart {
    /// Writes the chart as `STEM.png` and `STEM.svg`.
    ///
    /// # Errors
    /// If `stem` is no plain file name or a file cannot be put in place.
    pub fn write(&self, out: &OutDir, stem: &str) -> Result<[PathBuf; 2], ExportError> {
        self.picture().write(out, stem)
    }

    pub(super) fn picture(&self) -> Picture {
        let signs = self.tracks.iter().enumerate();
        let signs = signs.map(|(index, line)| (line.name.clone(), Sign::Line(line.stroke(index))));
        let legend: Vec<_> = signs.filter(|_| self.tracks.len() > 1).collect();
        let extent = self.extent();
        let mut plane = ToScale::new(&self.title, &self.unit, &legend, extent.unwrap_or_default());
        let shown = plane.shown();
        for (outlines, colour, opacity) in [
            (&self.obstacles, FRAME, 0.55),
            (&self.cells, series(5), 0.45),
        ] {
            for outline in outlines {
                let corners = clipped(outline, shown).into_iter();
                let corners = corners.map(|at| plane.at(at)).collect();
                plane.frame.picture.area(corners, colour, opacity);
            }
        }
        for (index, line) in self.tracks.iter().enumerate() {
            for run in line.points.split(|at| !finite(at)) {
                let run = run.iter().map(|&at| plane.at(at)).collect();
                plane.frame.picture.line(run, line.stroke(index));
            }
        }
        self.mark_spots(&mut plane);
        if extent.is_none() {
            plane.frame.say_no_data();
        }
        plane.frame.finished()
    }

    /// What is shown: the ways, the spots, and what of the rest lies near them; all of the rest where
    /// there is neither way nor spot, `None` where there is nothing at all.
    fn extent(&self) -> Option<[Range; 2]> {
        let circles: Vec<_> = self.spots.iter().map(Spot::circle).collect();
        let ways = self.tracks.iter().map(|track| &track.points);
        let places = ways.chain(&circles).flatten();
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

    fn mark_spots(&self, plane: &mut ToScale) {
        let mut taken: Vec<[Place; 2]> = Vec::new();
        let spots = || self.spots.iter().filter(|spot| finite(&spot.at));
        for spot in spots() {
            let at = plane.at(spot.at);
            let circle: Vec<Place> = spot.circle().into_iter().map(|at| plane.at(at)).collect();
            plane.frame.picture.line(circle, thin(INK, 2.0));
            plane.frame.picture.dot(at, DOT, INK);
            if spot.radius.is_none() {
                plane.frame.picture.dot(at, DOT * 0.55, PAPER);
            }
            taken.push([(at.0 - DOT, at.1 - DOT), (at.0 + DOT, at.1 + DOT)]);
        }
        for spot in spots() {
            let beside = plane.at((spot.at.0 + spot.radius.unwrap_or(0.0), spot.at.1));
            let at = plane.at(spot.at);
            // Clear of the circle along its diagonal.
            let away = DOT.max((beside.0 - at.0) * 0.75) + 4.0;
            let corners = self.label(plane, &spot.name, (at, away), &taken);
            taken.push(corners);
        }
    }

    /// Writes a name `away` from a place, where it hides least, and returns the corners of what it takes.
    fn label(
        &self,
        plane: &mut ToScale,
        name: &str,
        (at, away): (Place, f64),
        taken: &[[Place; 2]],
    ) -> [Place; 2] {
        let ((left, bottom), (right, top)) = (plane.frame.at(0.0, 0.0), plane.frame.at(1.0, 1.0));
        let name = font::fitted(name, LABEL, (right - left) / 3.0);
        let width = font::width(&name, LABEL);
        let corners = |(x, base): Place| {
            let (above, below) = (base - LABEL * 0.85, base + LABEL * 0.3);
            [(x - 3.0, above), (x + width + 3.0, below)]
        };
        let free = |&place: &Place| {
            let [a, b] = corners(place);
            let within = a.0 >= left && b.0 <= right && a.1 >= top && b.1 <= bottom;
            let mut taken = taken.iter();
            within && taken.all(|[c, d]| b.0 <= c.0 || d.0 <= a.0 || b.1 <= c.1 || d.1 <= a.1)
        };
        let off_the_ways = |&place: &Place| {
            let [a, b] = corners(place);
            let range = [(a.0, b.0), (a.1, b.1)];
            let mut steps = self.tracks.iter().flat_map(|track| track.points.windows(2));
            steps.all(|step| {
                let step: Vec<Place> = step
                    .iter()
                    .filter(|at| finite(at))
                    .map(|&at| plane.at(at))
                    .collect();
                clipped(&step, range).is_empty()
            })
        };
        let (to_right, to_left) = (at.0 + away, at.0 - away - width);
        let (above, below) = (at.1 - away, at.1 + away + LABEL * 0.8);
        let places = [to_right, to_left].into_iter();
        let places = places.flat_map(|x| [above, below].map(|base| (x, base)));
        let places: Vec<Place> = places.filter(free).collect();
        let place = places.iter().copied().find(off_the_ways);
        let place = place
            .or(places.first().copied())
            .unwrap_or((to_right, above));
        let [a, b] = corners(place);
        // Letters are read on obstacles too.
        plane.frame.picture.rectangle(a, b, PAPER, 0.7);
        plane.frame.note(&name, place, width + 1.0);
        [a, b]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::picture::Shape;

    fn chart(points: Vec<(f64, f64)>) -> TrackChart {
        TrackChart {
            title: "track".into(),
            unit: "m".into(),
            obstacles: vec![vec![(1.0, -2.0), (2.0, -2.0), (2.0, -1.0), (1.0, -1.0)]],
            cells: Vec::new(),
            tracks: vec![Line::new("robot", points)],
            spots: vec![Spot::new("nowhere", (f64::NAN, 0.0))],
        }
    }

    fn areas(picture: &Picture) -> impl Iterator<Item = &Vec<Place>> {
        picture.shapes.iter().filter_map(|shape| match shape {
            Shape::Area(points, ..) => Some(points),
            _ => None,
        })
    }

    #[test]
    fn a_square_is_drawn_as_a_square_whatever_the_way() {
        for end in [(10.0, 3.0), (3.0, 10.0), (1000.0, -1.0), (0.1, 0.1)] {
            let picture = chart(vec![(1.5, -1.5), end]).picture();
            let square = areas(&picture).next().unwrap();
            let sides = square.iter().zip(square.iter().cycle().skip(1));
            let sides: Vec<f64> = sides.map(|(a, b)| (a.0 - b.0).hypot(a.1 - b.1)).collect();
            assert_eq!(sides.len(), 4);
            for side in &sides {
                assert!((side / sides[0] - 1.0).abs() < 5e-3, "{end:?}: {sides:?}");
            }
        }
    }

    #[test]
    fn an_obstacle_far_away_does_not_shrink_the_way() {
        let mut chart = chart(vec![(0.0, 0.0), (10.0, 0.0)]);
        let near = chart.extent();
        chart
            .obstacles
            .push(vec![(9e4, 0.0), (1e5, 0.0), (1e5, 1.0)]);
        assert_eq!(chart.extent(), near);
        assert_eq!(
            areas(&chart.picture()).count(),
            1,
            "what is not shown is not drawn"
        );
        // Of a wall through the way there is a part.
        chart
            .obstacles
            .push(vec![(5.0, -1e4), (5.1, -1e4), (5.1, 1e4), (5.0, 1e4)]);
        let [x, y] = chart.extent().unwrap();
        assert_eq!((x, y), ((0.0, 10.0), (-5.0, 5.0)));
    }

    #[test]
    fn start_and_goal_have_their_names_and_the_goal_its_radius() {
        let chart = TrackChart {
            spots: vec![
                Spot::new("start", (0.0, 0.0)),
                Spot::new("goal", (0.1, 0.0)).within(0.5),
            ],
            ..chart(vec![(0.0, 0.0), (4.0, 3.0)])
        };
        let picture = chart.picture();
        let place = |name: &str| {
            let mut texts = picture.shapes.iter().filter_map(|shape| match shape {
                Shape::Text(text) if text.content == name => Some(text.place),
                _ => None,
            });
            texts.next().unwrap()
        };
        let ((a, b), (c, d)) = (place("start"), place("goal"));
        assert!(
            (a - c).abs() > 40.0 || (b - d).abs() > 24.0,
            "the names are apart"
        );
        let circles = picture.shapes.iter().filter_map(|shape| match shape {
            Shape::Line(points, _) if points.len() == 65 => Some(points),
            _ => None,
        });
        let circles: Vec<_> = circles.collect();
        assert_eq!(circles.len(), 1);
        let (wide, high) = (
            circles[0][0].0 - circles[0][32].0,
            circles[0][48].1 - circles[0][16].1,
        );
        assert!((wide / high - 1.0).abs() < 5e-3, "{wide} by {high}");
    }

    #[test]
    fn no_points_and_no_numbers_give_a_picture() {
        assert!(!chart(Vec::new()).picture().shapes.is_empty());
        let odd = chart(vec![(0.0, f64::NAN), (f64::INFINITY, 1.0), (1.0, 1.0)]);
        assert!(!odd.picture().shapes.is_empty());
        let huge = chart(vec![(f64::MAX, f64::MIN), (f64::MIN, f64::MAX)]);
        assert!(!huge.picture().shapes.is_empty());
        let mut empty = chart(Vec::new());
        empty.obstacles.clear();
        let says = |shape: &Shape| matches!(shape, Shape::Text(text) if text.content == "no data");
        assert!(empty.picture().shapes.iter().any(says));
    }
}
