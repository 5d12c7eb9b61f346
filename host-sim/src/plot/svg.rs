//! A picture as SVG.

use super::font;
use super::palette::Colour;
use super::picture::{Anchor, HEIGHT, Picture, Place, Shape, Text, WIDTH};
use core::fmt::Write;

/// The SVG document that shows `picture`; its texts stay texts.
pub(super) fn text(picture: &Picture) -> String {
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" \
         width=\"{WIDTH}\" height=\"{HEIGHT}\" font-family=\"{}\">\n\
         <rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#ffffff\"/>\n",
        font::FAMILY
    );
    for shape in &picture.shapes {
        svg += &element(shape);
        svg.push('\n');
    }
    svg += "</svg>\n";
    svg
}

fn element(shape: &Shape) -> String {
    match shape {
        Shape::Line(points, stroke) => {
            let dashes = stroke.dashes.map_or_else(String::new, |[dash, gap]| {
                format!(" stroke-dasharray=\"{dash} {gap}\"")
            });
            format!(
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" \
                 stroke-linejoin=\"round\"{dashes}/>",
                joined(points),
                hex(stroke.colour),
                stroke.width
            )
        }
        Shape::Area(points, colour, opacity) => format!(
            "<polygon points=\"{}\" fill=\"{}\" fill-opacity=\"{opacity}\"/>",
            joined(points),
            hex(*colour)
        ),
        Shape::Dot((x, y), radius, colour) => format!(
            "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius}\" fill=\"{}\"/>",
            hex(*colour)
        ),
        Shape::Text(text) => written(text),
    }
}

fn written(text: &Text) -> String {
    let anchor = match text.anchor {
        Anchor::Start => "start",
        Anchor::Middle => "middle",
        Anchor::End => "end",
    };
    let (x, y) = text.place;
    let turned = if text.upwards {
        format!(" transform=\"rotate(-90 {x:.2} {y:.2})\"")
    } else {
        String::new()
    };
    // The length keeps the layout where the viewer has another font.
    format!(
        "<text x=\"{x:.2}\" y=\"{y:.2}\" font-size=\"{}\" text-anchor=\"{anchor}\" \
         textLength=\"{:.2}\" lengthAdjust=\"spacingAndGlyphs\" fill=\"{}\"{turned}>{}</text>",
        text.size,
        font::width(&text.content, text.size),
        hex(text.colour),
        escaped(&text.content)
    )
}

fn joined(points: &[Place]) -> String {
    let mut text = String::new();
    for (number, (x, y)) in points.iter().enumerate() {
        let space = if number == 0 { "" } else { " " };
        // Writing to a string does not fail.
        let _ok = write!(text, "{space}{x:.2},{y:.2}");
    }
    text
}

fn hex([red, green, blue]: Colour) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// `text` as XML takes it: no markup, and none of the characters that XML forbids.
fn escaped(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '\u{FFFE}' | '\u{FFFF}' => out.push('\u{FFFD}'),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn foreign_names_are_no_markup() {
        assert_eq!(
            escaped("a<b>&\"c\u{0}\u{FFFF}"),
            "a&lt;b&gt;&amp;\"c \u{FFFD}"
        );
    }
}
