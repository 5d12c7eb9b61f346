//! A picture as PNG.

use super::font::{self, Pen};
use super::palette::Colour;
use super::picture::{Anchor, HEIGHT, Picture, Place, Shape, Text, WIDTH};
use png::{BitDepth, ColorType, Compression, Encoder};
use std::io::{self, Write};
use tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, StrokeDash,
    Transform,
};

/// Writes `picture` as a PNG in colours.
pub(super) fn write(picture: &Picture, out: impl Write) -> io::Result<()> {
    let mut encoder = Encoder::new(out, WIDTH, HEIGHT);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Balanced);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&pixels(picture)?)?;
    writer.finish()?;
    Ok(())
}

/// The rows of `picture` from the top, three bytes a pixel.
fn pixels(picture: &Picture) -> io::Result<Vec<u8>> {
    let mut canvas = Pixmap::new(WIDTH, HEIGHT)
        .ok_or_else(|| io::Error::other("no canvas of the charts' size"))?;
    canvas.fill(Color::WHITE);
    for shape in &picture.shapes {
        draw(&mut canvas, shape);
    }
    // The paper is opaque, so the pixels are as well.
    Ok(canvas
        .pixels()
        .iter()
        .flat_map(|pixel| [pixel.red(), pixel.green(), pixel.blue()])
        .collect())
}

fn draw(canvas: &mut Pixmap, shape: &Shape) {
    match shape {
        Shape::Line(points, stroke) => {
            let Some(path) = polygon(points, false) else {
                return;
            };
            let dash = stroke.dashes.and_then(|dashes| {
                StrokeDash::new(dashes.map(|length| length as f32).to_vec(), 0.0)
            });
            let pen = Stroke {
                width: stroke.width as f32,
                line_cap: LineCap::Butt,
                line_join: LineJoin::Round,
                dash,
                ..Stroke::default()
            };
            let paint = paint(stroke.colour, 1.0);
            canvas.stroke_path(&path, &paint, &pen, Transform::identity(), None);
        }
        Shape::Area(points, colour, opacity) => {
            if let Some(path) = polygon(points, true) {
                fill(canvas, &path, &paint(*colour, *opacity));
            }
        }
        Shape::Dot((x, y), radius, colour) => {
            if let Some(path) = PathBuilder::from_circle(*x as f32, *y as f32, *radius as f32) {
                fill(canvas, &path, &paint(*colour, 1.0));
            }
        }
        Shape::Text(text) => {
            let mut pen = Letters {
                path: PathBuilder::new(),
                text,
                before: match text.anchor {
                    Anchor::Start => 0.0,
                    Anchor::Middle => font::width(&text.content, text.size) / 2.0,
                    Anchor::End => font::width(&text.content, text.size),
                },
            };
            font::outline(&text.content, text.size, &mut pen);
            if let Some(path) = pen.path.finish() {
                fill(canvas, &path, &paint(text.colour, 1.0));
            }
        }
    }
}

fn fill(canvas: &mut Pixmap, path: &Path, paint: &Paint<'_>) {
    canvas.fill_path(path, paint, FillRule::Winding, Transform::identity(), None);
}

fn paint(colour: Colour, opacity: f64) -> Paint<'static> {
    let mut paint = Paint::default();
    let [red, green, blue] = colour;
    paint.set_color_rgba8(red, green, blue, (opacity * 255.0).round() as u8);
    paint.anti_alias = true;
    paint
}

fn polygon(points: &[Place], closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    let mut points = points.iter().map(|&(x, y)| (x as f32, y as f32));
    let (x, y) = points.next()?;
    path.move_to(x, y);
    for (x, y) in points {
        path.line_to(x, y);
    }
    if closed {
        path.close();
    }
    path.finish()
}

/// Puts the letters of a text in their place.
struct Letters<'a> {
    path: PathBuilder,
    text: &'a Text,
    /// How much of the text comes before its place.
    before: f64,
}

impl Letters<'_> {
    fn place(&self, (along, above): Place) -> (f32, f32) {
        let (x, y) = self.text.place;
        let along = along - self.before;
        let (x, y) = if self.text.upwards {
            (x - above, y - along)
        } else {
            (x + along, y - above)
        };
        (x as f32, y as f32)
    }
}

impl Pen for Letters<'_> {
    fn move_to(&mut self, to: Place) {
        let (x, y) = self.place(to);
        self.path.move_to(x, y);
    }

    fn line_to(&mut self, to: Place) {
        let (x, y) = self.place(to);
        self.path.line_to(x, y);
    }

    fn quad_to(&mut self, by: Place, to: Place) {
        let ((bx, by), (x, y)) = (self.place(by), self.place(to));
        self.path.quad_to(bx, by, x, y);
    }

    fn cubic_to(&mut self, [a, b]: [Place; 2], to: Place) {
        let ((ax, ay), (bx, by), (x, y)) = (self.place(a), self.place(b), self.place(to));
        self.path.cubic_to(ax, ay, bx, by, x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}
