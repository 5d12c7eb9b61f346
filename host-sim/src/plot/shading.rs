//! Intervals of x that are set off: one has its label in it, several have bars above the data.

use super::axis::Scale;
use super::font;
use super::frame::{Frame, LABEL};
use super::lines::Span;
use super::palette::SHADE;

/// How many rows of bars there are at the most; more would leave little of the chart.
const MOST_ROWS: usize = 8;
/// From a row to the next, in pixels.
const ROW: f64 = 31.0;

/// Where intervals and their labels go.
#[derive(Debug)]
pub(super) struct Shading<'a> {
    /// By their beginnings.
    spans: Vec<&'a Span>,
    bars: Vec<Bar<'a>>,
    rows: usize,
    /// How many have no row.
    left_out: usize,
}

/// One interval's bar, in pixels from the left.
#[derive(Debug, Clone, Copy)]
struct Bar<'a> {
    label: &'a str,
    row: usize,
    left: f64,
    right: f64,
    /// Where its label begins, and how much room that has.
    text: f64,
    room: f64,
}

impl<'a> Shading<'a> {
    /// Arranges `spans` along the axis `x` of a frame: each in the first row that has room for it and its
    /// label.
    pub(super) fn of(spans: &'a [Span], frame: &Frame, x: &Scale) -> Self {
        let finite = |span: &&Span| (span.to - span.from).is_finite();
        let mut spans: Vec<&Span> = spans.iter().filter(finite).collect();
        spans.sort_by(|a, b| a.low().total_cmp(&b.low()));
        let across = |part: f64| frame.at(part, 0.0).0;
        let (start, end) = (across(0.0), across(1.0));
        // Up to where each row is taken.
        let mut rows: Vec<f64> = Vec::new();
        let mut bars = Vec::new();
        for span in &spans {
            let [left, right] = [span.low(), span.high()].map(|at| across(x.part(at)));
            let wanted = font::width(&span.label, LABEL) + 4.0;
            let text = (left + 8.0).min(end - wanted).max(start + 8.0);
            let room = wanted.min(end - text);
            let free = rows.iter().position(|&taken| taken < text.min(left));
            let row = free.unwrap_or(rows.len());
            if row == MOST_ROWS {
                continue;
            }
            let taken = right.max(text + room) + 8.0;
            match rows.get_mut(row) {
                Some(row) => *row = taken,
                None => rows.push(taken),
            }
            bars.push(Bar {
                label: &span.label,
                row,
                left,
                right,
                text,
                room,
            });
        }
        Self {
            rows: rows.len(),
            left_out: spans.len() - bars.len(),
            spans,
            bars,
        }
    }

    /// How much room the bars need above the data.
    pub(super) fn height(&self) -> f64 {
        let rows = self.rows + usize::from(self.left_out > 0);
        if self.spans.len() > 1 {
            rows as f64 * ROW
        } else {
            0.0
        }
    }

    /// Draws the shades, which do not add up, and the labels.
    pub(super) fn draw(&self, frame: &mut Frame, x: &Scale) {
        let mut shaded = f64::NEG_INFINITY;
        for span in &self.spans {
            let from = span.low().max(shaded);
            shaded = shaded.max(span.high());
            if from < shaded || self.spans.len() == 1 {
                let (a, b) = (frame.at(x.part(from), 1.0), frame.at(x.part(shaded), 0.0));
                frame.picture.rectangle(a, b, SHADE, 0.16);
            }
        }
        let (start, top) = frame.at(0.0, 1.0);
        let (end, _) = frame.at(1.0, 1.0);
        let top = top - self.height();
        for bar in &self.bars {
            let top = top + ROW * bar.row as f64;
            if self.spans.len() > 1 {
                let right = bar.right.max(bar.left + 3.0);
                let (a, b) = ((bar.left, top), (right, top + ROW - 4.0));
                frame.picture.rectangle(a, b, SHADE, 0.35);
                frame.note(bar.label, (bar.text, top + LABEL * 0.9), bar.room);
            } else {
                frame.note(bar.label, (bar.text, top + 30.0), bar.room);
            }
        }
        if self.left_out > 0 {
            let more = format!("and {} more", self.left_out);
            let base = top + ROW * self.rows as f64 + LABEL * 0.9;
            frame.note(&more, (start + 8.0, base), end - start);
        }
    }
}
