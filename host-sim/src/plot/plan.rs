//! Places on a plane, to scale.

use super::frame::Sign;
use super::palette::series;
use super::picture::{Picture, Stroke};
use super::to_scale::{ToScale, around, finite};
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
        let legend = self.layers.iter().enumerate();
        let legend: Vec<_> = legend
            .map(|(index, layer)| (layer.name.clone(), Sign::Line(layer.ink.stroke(index))))
            .collect();
        let places = self.layers.iter().flat_map(|layer| &layer.runs).flatten();
        let range = around(places);
        let shown = range.unwrap_or([(-1.0, 1.0); 2]);
        let mut plane = ToScale::new(&self.title, "m", &legend, shown);
        for (index, layer) in self.layers.iter().enumerate() {
            for run in &layer.runs {
                let run: Vec<_> = run
                    .iter()
                    .filter(|place| finite(place))
                    .map(|&place| plane.at(place))
                    .collect();
                match layer.ink.radius() {
                    Some(radius) => {
                        for place in run {
                            plane.frame.picture.dot(place, radius, series(index));
                        }
                    }
                    None => plane.frame.picture.line(run, layer.ink.stroke(index)),
                }
            }
        }
        if range.is_none() {
            plane.frame.say_no_data();
        }
        plane.frame.finished()
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
