//! Places on a plane, to scale.

use super::axis::{Axis, Scale};
use super::frame::{Bottom, Frame, Sign, Words, X_TICKS, Y_TICKS};
use super::palette::series;
use super::picture::{Picture, Stroke};
use crate::export::{ExportError, OutDir};
use std::path::PathBuf;

/// Lines and dots on a plane, a metre being as long across as upwards.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// What it shows.
    pub title: String,
    /// What lies on it, the first lowest; each layer has a colour and a line in the legend.
    pub layers: Vec<Layer>,
}

/// What belongs together.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// What the legend calls it.
    pub name: String,
    /// How it is drawn.
    pub ink: Ink,
    /// Lines through places, or places by themselves; metres.
    pub runs: Vec<Vec<(f64, f64)>>,
}

/// How a layer is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ink {
    /// Lines.
    Solid,
    /// Dashed lines: what is not there.
    Dashed,
    /// Thin lines, where there are many.
    Thin,
    /// Dots.
    Dots,
    /// Larger dots, where there are few.
    Marks,
}

impl Ink {
    fn stroke(self, index: usize) -> Stroke {
        Stroke {
            colour: series(index),
            width: if self == Self::Thin { 1.5 } else { 4.0 },
            dashes: (self == Self::Dashed).then_some([14.0, 9.0]),
        }
    }

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
    /// If `stem` is no plain file name or a file cannot be put in place.
    pub fn write(&self, out: &OutDir, stem: &str) -> Result<[PathBuf; 2], ExportError> {
        self.picture().write(out, stem)
    }

    fn picture(&self) -> Picture {
        let places = || {
            let runs = self.layers.iter().flat_map(|layer| &layer.runs);
            runs.flatten()
                .filter(|(x, y)| x.is_finite() && y.is_finite())
        };
        let span = |coordinate: fn(&(f64, f64)) -> f64| {
            let all = places().map(coordinate);
            let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |span, value| {
                (span.0.min(value), span.1.max(value))
            });
            if low > high { (-1.0, 1.0) } else { (low, high) }
        };
        let (x, y) = (span(|place| place.0), span(|place| place.1));
        let legend = self.layers.iter().enumerate();
        let legend: Vec<_> = legend
            .map(|(index, layer)| (layer.name.clone(), Sign::Line(layer.ink.stroke(index))))
            .collect();
        let axis = |name: &str, (from, to): (f64, f64)| {
            let axis = Axis::new(name, "m").from(from).to(to);
            let ticks = if name == "x" { X_TICKS } else { Y_TICKS };
            (Scale::covering(&axis, [from, to].into_iter(), ticks), axis)
        };
        let framed = |x: (f64, f64), y: (f64, f64)| {
            let ((x, x_axis), (y, y_axis)) = (axis("x", x), axis("y", y));
            let words = Words {
                title: &self.title,
                x: x_axis.title(),
                y: y_axis.title(),
                legend: &legend,
            };
            (Frame::new(words, Bottom::Numbers(&x), &y), x, y)
        };
        // A margin, and then more of one direction until a metre is a metre.
        let margin = 0.05 * (x.1 - x.0).max(y.1 - y.0).max(0.1);
        let (mut x, mut y) = ((x.0 - margin, x.1 + margin), (y.0 - margin, y.1 + margin));
        for _ in 0..2 {
            let (frame, ..) = framed(x, y);
            let ((left, bottom), (right, top)) = (frame.at(0.0, 0.0), frame.at(1.0, 1.0));
            let (wide, high) = (right - left, bottom - top);
            let metre = (wide / (x.1 - x.0)).min(high / (y.1 - y.0));
            let around = |(low, high): (f64, f64), length: f64| {
                let middle = f64::midpoint(low, high);
                (middle - length / 2.0, middle + length / 2.0)
            };
            (x, y) = (around(x, wide / metre), around(y, high / metre));
        }
        let (mut frame, x, y) = framed(x, y);
        for (index, layer) in self.layers.iter().enumerate() {
            for run in &layer.runs {
                let run: Vec<_> = run
                    .iter()
                    .filter(|(x, y)| x.is_finite() && y.is_finite())
                    .map(|&(across, up)| frame.at(x.part(across), y.part(up)))
                    .collect();
                match layer.ink.radius() {
                    Some(radius) => {
                        for place in run {
                            frame.picture.dot(place, radius, series(index));
                        }
                    }
                    None => frame.picture.line(run, layer.ink.stroke(index)),
                }
            }
        }
        if places().next().is_none() {
            frame.say_no_data();
        }
        frame.finished()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::picture::Shape;

    #[test]
    fn a_square_is_drawn_as_a_square() {
        let square = vec![(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0), (0.0, 0.0)];
        let plan = Plan {
            title: "square".into(),
            layers: vec![Layer {
                name: "square".into(),
                ink: Ink::Solid,
                runs: vec![square],
            }],
        };
        let picture = plan.picture();
        let drawn = picture.shapes.iter().find_map(|shape| match shape {
            Shape::Line(points, stroke) if points.len() == 5 && stroke.width == 4.0 => Some(points),
            _ => None,
        });
        let drawn = drawn.unwrap();
        let (wide, high) = (drawn[1].0 - drawn[0].0, drawn[0].1 - drawn[3].1);
        assert!(wide > 300.0, "{wide}");
        assert!((wide - high).abs() < 0.01 * wide, "{wide} by {high}");
    }

    #[test]
    fn nothing_at_all_is_a_picture_that_says_so() {
        let plan = Plan {
            title: "nothing".into(),
            layers: vec![Layer {
                name: "no place".into(),
                ink: Ink::Dots,
                runs: vec![vec![(f64::NAN, 0.0)]],
            }],
        };
        let says = |shape: &Shape| matches!(shape, Shape::Text(text) if text.content == "no data");
        assert!(plan.picture().shapes.iter().any(says));
    }
}
