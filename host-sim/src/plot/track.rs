//! Ways over a plane: where something went, and what stood there.

use super::axis::{Axis, Scale};
use super::frame::{Bottom, Frame, Sign, Words, X_TICKS, Y_TICKS};
use super::palette::{FRAME, series};
use super::picture::{Picture, Stroke};
use super::{Line, picture};
use crate::export::{ExportError, OutDir};
use std::path::PathBuf;

/// Lines over a map seen from above; a metre is as long upwards as it is to the right.
///
/// # Examples
/// ```
/// use certainty_sim::export::OutDir;
/// use certainty_sim::plot::{Line, TrackChart};
///
/// let chart = TrackChart {
///     title: "Round a box".into(),
///     unit: "m".into(),
///     obstacles: vec![vec![(1.0, -0.5), (2.0, -0.5), (2.0, 0.5), (1.0, 0.5)]],
///     cells: Vec::new(),
///     tracks: vec![Line::new("robot", vec![(0.0, 0.0), (1.5, 1.2), (3.0, 0.0)])],
///     places: vec![(3.0, 0.0)],
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
    /// Places set off by a dot.
    pub places: Vec<(f64, f64)>,
}

/// What a chart has of the picture's width by its height, about.
const ASPECT: f64 = 1.75;

impl TrackChart {
    /// Writes the chart as `STEM.png` and `STEM.svg`.
    ///
    /// # Errors
    /// If `stem` is no plain file name or a file cannot be put in place.
    pub fn write(&self, out: &OutDir, stem: &str) -> Result<[PathBuf; 2], ExportError> {
        self.picture().write(out, stem)
    }

    pub(super) fn picture(&self) -> Picture {
        let ([left, right], [low, high]) = self.extent();
        let x = Axis::new("x", &self.unit).from(left).to(right);
        let y = Axis::new("y", &self.unit).from(low).to(high);
        let x_scale = Scale::covering(&x, [left, right].into_iter(), X_TICKS);
        let y_scale = Scale::covering(&y, [low, high].into_iter(), Y_TICKS);
        let signs = self.tracks.iter().enumerate();
        let signs = signs.map(|(index, line)| (line.name.clone(), Sign::Line(stroke(line, index))));
        let legend: Vec<_> = signs.filter(|_| self.tracks.len() > 1).collect();
        let words = Words {
            title: &self.title,
            x: x.title(),
            y: y.title(),
            legend: &legend,
        };
        let mut frame = Frame::new(words, Bottom::Numbers(&x_scale), &y_scale);
        let place = |frame: &Frame, (at_x, at_y): (f64, f64)| {
            frame.at(x_scale.part(at_x), y_scale.part(at_y))
        };
        for (outlines, colour, opacity) in [
            (&self.obstacles, FRAME, 0.55),
            (&self.cells, series(5), 0.45),
        ] {
            for outline in outlines {
                let corners = outline.iter().filter(|at| finite(at));
                let corners: Vec<picture::Place> = corners.map(|&at| place(&frame, at)).collect();
                frame.picture.area(corners, colour, opacity);
            }
        }
        for (index, line) in self.tracks.iter().enumerate() {
            for run in line.points.split(|at| !finite(at)) {
                let run = run.iter().map(|&at| place(&frame, at)).collect();
                frame.picture.line(run, stroke(line, index));
            }
        }
        for &at in self.places.iter().filter(|at| finite(at)) {
            let at = place(&frame, at);
            frame.picture.dot(at, 9.0, series(6));
        }
        frame.finished()
    }

    /// The ends of both axes: around all that is drawn, as wide by as high as the chart is.
    fn extent(&self) -> ([f64; 2], [f64; 2]) {
        let outlines = self.obstacles.iter().flatten();
        let points = outlines.chain(self.tracks.iter().flat_map(|track| &track.points));
        let points = points.chain(&self.places).filter(|at| finite(at));
        let ends = points.fold(None, |ends: Option<[f64; 4]>, &(x, y)| {
            let [left, right, low, high] = ends.unwrap_or([x, x, y, y]);
            Some([left.min(x), right.max(x), low.min(y), high.max(y)])
        });
        let [left, right, low, high] = ends.unwrap_or([0.0; 4]);
        let (width, height) = ((right - left) * 1.08, (high - low) * 1.08);
        let width = width.max(height * ASPECT).max(1e-3);
        let height = width / ASPECT;
        let around = |from: f64, to: f64, size: f64| {
            let middle = f64::midpoint(from, to);
            [middle - size / 2.0, middle + size / 2.0]
        };
        (around(left, right, width), around(low, high, height))
    }
}

fn stroke(line: &Line, index: usize) -> Stroke {
    Stroke {
        colour: series(index),
        width: 4.0,
        dashes: line.dashed.then_some([14.0, 9.0]),
    }
}

fn finite(&(x, y): &(f64, f64)) -> bool {
    x.is_finite() && y.is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(points: Vec<(f64, f64)>) -> TrackChart {
        TrackChart {
            title: "track".into(),
            unit: "m".into(),
            obstacles: vec![vec![(1.0, -9.0), (2.0, -9.0), (2.0, -8.0)]],
            cells: Vec::new(),
            tracks: vec![Line::new("robot", points)],
            places: vec![(f64::NAN, 0.0)],
        }
    }

    #[test]
    fn a_metre_is_as_long_upwards_as_to_the_right() {
        let ([left, right], [low, high]) = chart(vec![(0.0, 0.0), (10.0, 3.0)]).extent();
        assert!(((right - left) / (high - low) - ASPECT).abs() < 1e-9);
        assert!(left <= 0.0 && right >= 10.0 && low <= -9.0 && high >= 3.0);
    }

    #[test]
    fn no_points_and_no_numbers_give_a_picture() {
        assert!(!chart(Vec::new()).picture().shapes.is_empty());
        let odd = chart(vec![(0.0, f64::NAN), (f64::INFINITY, 1.0), (1.0, 1.0)]);
        assert!(!odd.picture().shapes.is_empty());
    }
}
