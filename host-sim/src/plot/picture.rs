//! What a chart looks like, before it is a file.

use super::palette::Colour;
use super::{raster, svg};
use crate::export::{ExportError, OutDir};
use std::path::PathBuf;

/// A place in a picture: pixels from the left and from the top.
pub(super) type Place = (f64, f64);

/// How wide a picture is, in pixels.
pub(super) const WIDTH: u32 = 1600;
/// How high a picture is, in pixels.
pub(super) const HEIGHT: u32 = 1000;

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stroke {
    pub colour: Colour,
    pub width: f64,
    /// Lengths of dash and gap, where it is dashed.
    pub dashes: Option<[f64; 2]>,
}

/// Which end of a text its place is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// A text on its line.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Text {
    pub content: String,
    /// Pixels an em.
    pub size: f64,
    pub colour: Colour,
    /// On the line that the letters stand on.
    pub place: Place,
    pub anchor: Anchor,
    /// Whether it runs upwards.
    pub upwards: bool,
}

/// One thing in a picture.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Shape {
    /// An open line through two points or more.
    Line(Vec<Place>, Stroke),
    /// An area within three points or more; opaque at 1.
    Area(Vec<Place>, Colour, f64),
    /// A filled circle of a radius.
    Dot(Place, f64, Colour),
    Text(Text),
}

/// Shapes, the lowest first, on white.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Picture {
    pub shapes: Vec<Shape>,
}

impl Picture {
    pub(super) fn line(&mut self, points: Vec<Place>, stroke: Stroke) {
        if points.len() >= 2 {
            self.shapes.push(Shape::Line(points, stroke));
        }
    }

    pub(super) fn area(&mut self, points: Vec<Place>, colour: Colour, opacity: f64) {
        if points.len() >= 3 {
            self.shapes.push(Shape::Area(points, colour, opacity));
        }
    }

    /// The area between two opposite corners.
    pub(super) fn rectangle(&mut self, a: Place, b: Place, colour: Colour, opacity: f64) {
        self.area(vec![a, (b.0, a.1), b, (a.0, b.1)], colour, opacity);
    }

    pub(super) fn dot(&mut self, place: Place, radius: f64, colour: Colour) {
        self.shapes.push(Shape::Dot(place, radius, colour));
    }

    pub(super) fn text(&mut self, text: Text) {
        if !text.content.trim().is_empty() {
            self.shapes.push(Shape::Text(text));
        }
    }

    /// Writes `STEM.png` and `STEM.svg`.
    pub(super) fn write(&self, out: &OutDir, stem: &str) -> Result<[PathBuf; 2], ExportError> {
        let png = out.write(&format!("{stem}.png"), |file| raster::write(self, file))?;
        let svg = out.write_bytes(&format!("{stem}.svg"), svg::text(self).as_bytes())?;
        Ok([png, svg])
    }
}
