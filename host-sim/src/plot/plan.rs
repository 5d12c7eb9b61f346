//! Charts of a plane to scale: a unit is as long upwards as it is to the right.

use super::frame::{
    Area, Draw, Drawn, Frame, GREY, LARGEST, Place, Sign, Stroke, Texts, series, write,
};
use crate::export::{ExportError, OutDir};
use core::ops::Range;
use plotters::prelude::{Color, DrawingBackend};
use std::path::PathBuf;

/// Layers of lines, points and areas on a plane, to scale, with axes in metres.
///
/// The chart shows all lines and points, and of the areas what lies around them within half of their
/// size, so that a distant obstacle does not shrink a path to a dot.
///
/// # Examples
/// ```
/// use certainty_sim::export::OutDir;
/// use certainty_sim::plot::{Ink, Layer, Plan};
///
/// let plan = Plan {
///     title: "Round a box".into(),
///     layers: vec![
///         Layer::new("obstacle", Ink::Obstacle, vec![vec![(1.0, -0.5), (2.0, -0.5), (2.0, 0.5)]]),
///         Layer::new("robot", Ink::Solid, vec![vec![(0.0, 0.0), (1.5, 1.2), (3.0, 0.0)]]),
///     ],
/// };
/// let folder = tempfile::tempdir().unwrap();
/// plan.write(&OutDir::create(folder.path())?, "track")?;
/// # Ok::<(), certainty_sim::export::ExportError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// What the chart shows.
    pub title: String,
    /// The layers, the first lowest; each has a colour and an entry in the legend.
    pub layers: Vec<Layer>,
}

/// Lines, points or areas of one kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Its name in the legend.
    pub name: String,
    /// How it is drawn.
    pub ink: Ink,
    /// Lines through places, single places, or outlines; in metres.
    pub runs: Vec<Vec<(f64, f64)>>,
}

impl Layer {
    /// Creates a layer.
    #[must_use]
    pub fn new(name: &str, ink: Ink, runs: Vec<Vec<(f64, f64)>>) -> Self {
        Self {
            name: name.to_owned(),
            ink,
            runs,
        }
    }
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
    /// Areas in grey.
    Obstacle,
    /// Translucent areas, such as a map's occupied cells.
    Cells,
}

impl Ink {
    /// How the layer of number `index` is drawn.
    fn sign(self, index: usize) -> Sign {
        let colour = series(index);
        match self {
            Self::Solid => Sign::Line(Stroke::solid(colour, 8)),
            Self::Dashed => Sign::Line(Stroke {
                colour,
                width: 8,
                dashed: true,
            }),
            Self::Thin => Sign::Line(Stroke::solid(colour, 3)),
            Self::Dots => Sign::Dot(colour, 6),
            Self::Marks => Sign::Dot(colour, 14),
            Self::Obstacle => Sign::Area(GREY.mix(0.55)),
            Self::Cells => Sign::Area(colour.mix(0.45)),
        }
    }
}

/// How far around lines and points areas are shown, in parts of their size.
const SURROUNDINGS: f64 = 0.5;

impl Plan {
    /// Writes the plan as `STEM.png` and `STEM.svg`.
    ///
    /// # Errors
    /// If `stem` is not a plain file name or a file cannot be put in place.
    pub fn write(&self, out: &OutDir, stem: &str) -> Result<[PathBuf; 2], ExportError> {
        write(self, out, stem)
    }

    /// The layers with their signs; obstacles, which are grey, do not use up a colour.
    fn signs(&self) -> impl Iterator<Item = (&Layer, Sign)> {
        let mut colours = 0..;
        self.layers.iter().map(move |layer| match layer.ink {
            Ink::Obstacle => (layer, layer.ink.sign(0)),
            ink => (layer, ink.sign(colours.next().unwrap_or(0))),
        })
    }

    /// The range of the lines and points, and of the areas near them; of all areas if there is no line
    /// and no point; `None` without any place.
    fn extent(&self) -> Option<[Range<f64>; 2]> {
        let runs = |areas: bool| {
            let layers = self.signs();
            let layers = layers.filter(move |(_, sign)| matches!(sign, Sign::Area(..)) == areas);
            layers.flat_map(|(layer, _)| &layer.runs)
        };
        let Some([x, y]) = around(runs(false).flatten().copied()) else {
            return around(runs(true).flatten().copied());
        };
        let margin = SURROUNDINGS * (x.end - x.start).max(y.end - y.start);
        let near = [&x, &y].map(|axis| axis.start - margin..axis.end + margin);
        let pieces = runs(true).flat_map(|outline| clipped(outline, &near));
        let corners = [(x.start, y.start), (x.end, y.end)];
        around(pieces.chain(corners))
    }
}

impl Draw for Plan {
    fn draw<D: DrawingBackend>(&self, area: &Area<D>) -> Drawn<D> {
        let texts = Texts {
            title: &self.title,
            x: "x (m)",
            y: "y (m)",
            legend: self
                .signs()
                .map(|(layer, sign)| (layer.name.clone(), sign))
                .collect(),
            ..Texts::default()
        };
        let extent = self.extent();
        let shown = to_scale(&texts, extent.clone().unwrap_or([-1.0..1.0, -1.0..1.0]));
        let frame = Frame::new(area, &texts, shown.clone())?;
        for (layer, sign) in self.signs() {
            for run in &layer.runs {
                match sign {
                    Sign::Area(colour) => {
                        frame.fill(frame.all(&clipped(run, &shown)), colour)?;
                    }
                    Sign::Dot(colour, radius) => {
                        for &place in run.iter().filter(|place| finite(place)) {
                            frame.dot(frame.at(place), radius, colour)?;
                        }
                    }
                    Sign::Line(stroke) => {
                        let pieces = run.split(|place| !finite(place));
                        for piece in pieces.filter(|piece| piece.len() > 1) {
                            frame.line(frame.all(piece), stroke)?;
                        }
                    }
                }
            }
        }
        if extent.is_none() {
            frame.no_data()?;
        }
        Ok(())
    }
}

/// The ranges with a margin, and more along one axis, so that a unit has the same number of pixels on
/// both.
fn to_scale(texts: &Texts<'_>, shown: [Range<f64>; 2]) -> [Range<f64>; 2] {
    let [(left, top), (right, bottom)] = texts.corners();
    let [across, upwards] = [right - left, bottom - top].map(f64::from);
    let [wide, high] = [&shown[0], &shown[1]].map(|axis| axis.end - axis.start);
    let margin = 0.05 * wide.max(high).max(0.1);
    let unit = (across / (wide + 2.0 * margin)).min(upwards / (high + 2.0 * margin));
    let [x, y] = shown;
    [(x, across), (y, upwards)].map(|(axis, pixels)| {
        let (middle, half) = (f64::midpoint(axis.start, axis.end), pixels / unit / 2.0);
        middle - half..middle + half
    })
}

/// Whether both coordinates of a place are numbers.
pub(super) fn finite(&(x, y): &Place) -> bool {
    x.is_finite() && y.is_finite()
}

/// The smallest ranges along both axes that hold all finite `places`; `None` if there is none.
fn around(places: impl Iterator<Item = Place>) -> Option<[Range<f64>; 2]> {
    let places = places.filter(finite).map(bounded);
    places.fold(None, |ranges, (x, y)| {
        let [across, upwards] = ranges.unwrap_or([x..x, y..y]);
        Some([
            across.start.min(x)..across.end.max(x),
            upwards.start.min(y)..upwards.end.max(y),
        ])
    })
}

fn bounded((x, y): Place) -> Place {
    (x.clamp(-LARGEST, LARGEST), y.clamp(-LARGEST, LARGEST))
}

/// The corners of the part of `outline` within a rectangle; empty if nothing lies in it.
///
/// Sutherland and Hodgman's algorithm, exact for convex outlines.
fn clipped(outline: &[Place], [x, y]: &[Range<f64>; 2]) -> Vec<Place> {
    let corners = outline.iter().copied().filter(finite);
    let mut corners: Vec<Place> = corners.map(bounded).collect();
    // How far a place is within each side.
    let sides: [&dyn Fn(Place) -> f64; 4] = [
        &|place| place.0 - x.start,
        &|place| x.end - place.0,
        &|place| place.1 - y.start,
        &|place| y.end - place.1,
    ];
    for within in sides {
        let mut kept = Vec::new();
        for (index, &to) in corners.iter().enumerate() {
            let from = corners[(index + corners.len() - 1) % corners.len()];
            let (a, b) = (within(from), within(to));
            if (a < 0.0) != (b < 0.0) {
                let part = a / (a - b);
                kept.push((
                    from.0 + (to.0 - from.0) * part,
                    from.1 + (to.1 - from.1) * part,
                ));
            }
            if b >= 0.0 {
                kept.push(to);
            }
        }
        corners = kept;
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn plan(outlines: Vec<Vec<Place>>) -> Plan {
        let track = vec![vec![(0.0, 0.0), (10.0, 0.0)]];
        Plan {
            title: "plan".into(),
            layers: vec![
                Layer::new("obstacle", Ink::Obstacle, outlines),
                Layer::new("robot", Ink::Solid, track),
            ],
        }
    }

    #[test]
    fn distant_obstacle_does_not_shrink_path() {
        let far = vec![(9e4, 0.0), (1e5, 0.0), (1e5, 1.0)];
        assert_eq!(plan(vec![far]).extent(), plan(vec![]).extent());
        // A wall across the path is shown in part.
        let wall = vec![(5.0, -1e4), (5.1, -1e4), (5.1, 1e4), (5.0, 1e4)];
        assert_eq!(plan(vec![wall]).extent(), Some([0.0..10.0, -5.0..5.0]));
    }

    #[test]
    fn area_is_clipped_to_rectangle() {
        let range = [0.0..4.0, 0.0..2.0];
        let square = [(1.0, 1.0), (3.0, 1.0), (3.0, 3.0), (1.0, 3.0)];
        let cut = clipped(&square, &range);
        assert_eq!(around(cut.into_iter()), Some([1.0..3.0, 1.0..2.0]));
        let within = [(1.0, 0.5), (2.0, 0.5), (2.0, 1.5)];
        let mut same = clipped(&within, &range);
        let first = same.iter().position(|&at| at == within[0]);
        same.rotate_left(first.unwrap());
        assert_eq!(same, within);
        let around_all = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)];
        let cut = clipped(&around_all, &range);
        assert_eq!(around(cut.into_iter()), Some(range.clone()));
        // A rhombus whose corners all lie outside; clamped to the sides it would be another shape.
        let rhombus = [(2.0, -1.0), (5.0, 1.0), (2.0, 3.0), (-1.0, 1.0)];
        assert_eq!(clipped(&rhombus, &range).len(), 8);
        for none in [
            &[][..],
            &[(5.0, 5.0), (6.0, 5.0), (6.0, 6.0)],
            &[(f64::NAN, 0.0)],
        ] {
            assert_eq!(clipped(none, &range), []);
        }
    }

    proptest! {
        #[test]
        fn unit_is_as_long_upwards_as_across(
            x in (-1e4..1e4, 0.0..300.0),
            y in (-1e4..1e4, 0.0..300.0),
            legend in 0..4_usize,
        ) {
            let [x, y] = [x, y].map(|(from, length): Place| from..from + length);
            let legend = vec![("a line".to_owned(), Sign::Area(GREY.mix(1.0))); legend];
            let texts = Texts { x: "x", y: "y", legend, ..Texts::default() };
            let [(left, top), (right, bottom)] = texts.corners();
            let [shown_x, shown_y] = to_scale(&texts, [x.clone(), y.clone()]);
            let across = f64::from(right - left) / (shown_x.end - shown_x.start);
            let upwards = f64::from(bottom - top) / (shown_y.end - shown_y.start);
            prop_assert!((across / upwards - 1.0).abs() < 1e-3, "{across} {upwards}");
            prop_assert!(shown_x.start <= x.start && x.end <= shown_x.end);
            prop_assert!(shown_y.start <= y.start && y.end <= shown_y.end);
        }
    }
}
