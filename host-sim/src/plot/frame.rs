//! What every chart has around its data: title, legend, axes, grid.

use super::axis::Scale;
use super::font::{self, HALF_X_HEIGHT};
use super::palette::{Colour, FRAME, GRID, INK};
use super::picture::{Anchor, HEIGHT, Picture, Place, Stroke, Text, WIDTH};

/// About how many ticks the x axis has.
pub(super) const X_TICKS: u32 = 10;
/// About how many ticks the y axis has.
pub(super) const Y_TICKS: u32 = 7;

const MARGIN: f64 = 36.0;
const TITLE: f64 = 34.0;
const AXIS_TITLE: f64 = 26.0;
/// How large a label is, in pixels.
pub(super) const LABEL: f64 = 24.0;
const LEGEND_ROW: f64 = 38.0;
/// More rows would leave little of the chart.
const MOST_LEGEND_ROWS: usize = 6;
const SIGN_WIDTH: f64 = 48.0;
/// What is left of a label of the y axis, and of an upright one of the x axis.
const LONGEST_LABEL: f64 = 280.0;

/// How a legend shows what it names.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Sign {
    Line(Stroke),
    Area(Colour, f64),
}

/// What lies along the x axis.
#[derive(Debug, Clone, Copy)]
pub(super) enum Bottom<'a> {
    Numbers(&'a Scale),
    /// Each with an equal part of the axis.
    Names(&'a [String]),
}

/// What is written around the data.
#[derive(Debug, Clone, Copy)]
pub(super) struct Words<'a> {
    pub title: &'a str,
    pub x: &'a str,
    pub y: &'a str,
    pub legend: &'a [(String, Sign)],
    /// How many pixels are left free above the data.
    pub above: f64,
}

/// A picture with all but the data, and where the data go.
#[derive(Debug)]
pub(super) struct Frame {
    pub picture: Picture,
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

impl Frame {
    pub(super) fn new(words: Words<'_>, x: Bottom<'_>, y: &Scale) -> Self {
        let (width, height) = (f64::from(WIDTH), f64::from(HEIGHT));
        let widest = |texts: &mut dyn Iterator<Item = &str>| {
            let widths = texts.map(|text| font::width(text, LABEL));
            widths.fold(0.0, f64::max).min(LONGEST_LABEL)
        };
        let y_labels = widest(&mut y.ticks.iter().map(|tick| tick.text.as_str()));
        // The x axis's first and last labels reach beyond its ends.
        let overhang = match x {
            Bottom::Numbers(scale) => {
                widest(&mut scale.ticks.iter().map(|tick| tick.text.as_str())) / 2.0 + 4.0
            }
            Bottom::Names(_) => 0.0,
        };
        let left = overhang.max(MARGIN + AXIS_TITLE * 1.6 + y_labels + 16.0);
        let right = width - overhang.max(MARGIN);
        let mut frame = Self {
            picture: Picture::default(),
            left,
            right,
            top: MARGIN + TITLE * 1.3,
            bottom: height,
        };
        frame.write(words.title, TITLE, (left, MARGIN + TITLE * 0.8), right);
        frame.legend(words.legend);
        frame.top += 16.0 + words.above;
        // Names stand upright where they are too wide for their part of the axis.
        let (upright, below) = match x {
            Bottom::Numbers(_) => (false, LABEL * 1.6),
            Bottom::Names(names) => {
                let names_width = widest(&mut names.iter().map(String::as_str));
                let room = (right - left) / names.len().max(1) as f64;
                let upright = names_width > room * 0.94;
                (
                    upright,
                    if upright {
                        names_width + 12.0
                    } else {
                        LABEL * 1.6
                    },
                )
            }
        };
        let title_below = if words.x.is_empty() {
            0.0
        } else {
            AXIS_TITLE * 1.5
        };
        frame.bottom = height - MARGIN - below - title_below;
        frame.grid(x, y, upright);
        frame.axis_titles(words);
        frame
    }

    /// The place at these parts of the two axes.
    pub(super) fn at(&self, x: f64, y: f64) -> Place {
        (
            self.left + (self.right - self.left) * x,
            self.bottom - (self.bottom - self.top) * y,
        )
    }

    /// Says that there is nothing to show.
    pub(super) fn say_no_data(&mut self) {
        let place = self.at(0.5, 0.5);
        self.picture.text(Text {
            content: "no data".into(),
            size: TITLE,
            colour: FRAME,
            place,
            anchor: Anchor::Middle,
            upwards: false,
        });
    }

    /// Writes a word at a place in the data, shortened to `room` pixels.
    pub(super) fn note(&mut self, text: &str, place: Place, room: f64) {
        self.write(text, LABEL, place, place.0 + room);
    }

    /// The picture, the axes drawn over the data.
    pub(super) fn finished(mut self) -> Picture {
        let corners = [(0.0, 1.0), (0.0, 0.0), (1.0, 0.0)];
        let axes = corners.map(|(x, y)| self.at(x, y)).to_vec();
        self.picture.line(axes, thin(FRAME, 2.0));
        self.picture
    }

    fn write(&mut self, text: &str, size: f64, place: Place, end: f64) {
        self.picture.text(Text {
            content: font::fitted(text, size, end - place.0),
            size,
            colour: INK,
            place,
            anchor: Anchor::Start,
            upwards: false,
        });
    }

    /// Signs and names in rows below the title; data never lie under them.
    fn legend(&mut self, entries: &[(String, Sign)]) {
        let (mut x, mut row) = (self.left, 0);
        for (number, (name, sign)) in entries.iter().enumerate() {
            let name = font::fitted(name, LABEL, 480.0);
            let needed = SIGN_WIDTH + 12.0 + font::width(&name, LABEL);
            if x > self.left && x + needed > self.right {
                (x, row) = (self.left, row + 1);
            }
            let middle = self.top + LEGEND_ROW * (row as f64 + 0.5);
            let base = middle + LABEL * HALF_X_HEIGHT;
            if row + 1 == MOST_LEGEND_ROWS && number + 1 < entries.len() {
                let more = format!("and {} more", entries.len() - number);
                self.write(&more, LABEL, (x, base), self.right);
                break;
            }
            match *sign {
                Sign::Line(stroke) => {
                    let line = vec![(x, middle), (x + SIGN_WIDTH, middle)];
                    self.picture.line(line, stroke);
                }
                Sign::Area(colour, opacity) => {
                    let (from, to) = ((x, middle - 11.0), (x + SIGN_WIDTH, middle + 11.0));
                    self.picture.rectangle(from, to, colour, opacity);
                }
            }
            self.write(&name, LABEL, (x + SIGN_WIDTH + 12.0, base), f64::MAX);
            x += needed + 36.0;
        }
        if !entries.is_empty() {
            self.top += LEGEND_ROW * (row as f64 + 1.0);
        }
    }

    fn grid(&mut self, x: Bottom<'_>, y: &Scale, upright: bool) {
        for tick in &y.ticks {
            let part = y.part(tick.value);
            let place = self.at(0.0, part);
            self.picture
                .line(vec![place, self.at(1.0, part)], thin(GRID, 1.5));
            self.picture.text(Text {
                content: tick.text.clone(),
                size: LABEL,
                colour: INK,
                place: (place.0 - 12.0, place.1 + LABEL * 0.36),
                anchor: Anchor::End,
                upwards: false,
            });
        }
        let labels: Vec<(f64, String)> = match x {
            Bottom::Numbers(scale) => {
                let ticks = scale.ticks.iter();
                ticks
                    .map(|tick| (scale.part(tick.value), tick.text.clone()))
                    .collect()
            }
            Bottom::Names(names) => {
                let count = names.len() as f64;
                let names = names.iter().enumerate();
                names
                    .map(|(number, name)| {
                        let room = if upright { LONGEST_LABEL } else { f64::MAX };
                        let part = (number as f64 + 0.5) / count;
                        (part, font::fitted(name, LABEL, room))
                    })
                    .collect()
            }
        };
        let mut taken = f64::NEG_INFINITY;
        for (part, text) in labels {
            let (x_at, bottom) = self.at(part, 0.0);
            if matches!(x, Bottom::Numbers(_)) {
                let line = vec![(x_at, bottom), self.at(part, 1.0)];
                self.picture.line(line, thin(GRID, 1.5));
            }
            // How much of the axis the label covers; what has no room is left out.
            let half = if upright {
                LABEL * 0.5
            } else {
                font::width(&text, LABEL) / 2.0
            };
            if x_at - half < taken {
                continue;
            }
            taken = x_at + half + 4.0;
            let (place, anchor) = if upright {
                ((x_at + LABEL * 0.36, bottom + 12.0), Anchor::End)
            } else {
                ((x_at, bottom + LABEL * 1.4), Anchor::Middle)
            };
            self.picture.text(Text {
                content: text,
                size: LABEL,
                colour: INK,
                place,
                anchor,
                upwards: upright,
            });
        }
    }

    fn axis_titles(&mut self, words: Words<'_>) {
        let height = f64::from(HEIGHT);
        let along = font::fitted(words.x, AXIS_TITLE, self.right - self.left);
        self.picture.text(Text {
            content: along,
            size: AXIS_TITLE,
            colour: INK,
            place: (
                f64::midpoint(self.left, self.right),
                height - MARGIN + AXIS_TITLE * 0.2,
            ),
            anchor: Anchor::Middle,
            upwards: false,
        });
        let up = font::fitted(words.y, AXIS_TITLE, self.bottom - self.top);
        self.picture.text(Text {
            content: up,
            size: AXIS_TITLE,
            colour: INK,
            place: (
                MARGIN + AXIS_TITLE * 0.7,
                f64::midpoint(self.top, self.bottom),
            ),
            anchor: Anchor::Middle,
            upwards: true,
        });
    }
}

/// An undashed line.
pub(super) const fn thin(colour: Colour, width: f64) -> Stroke {
    Stroke {
        colour,
        width,
        dashes: None,
    }
}
