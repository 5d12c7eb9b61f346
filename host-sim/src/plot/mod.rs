//! Charts as PNG and SVG.
//!
//! | type | shows |
//! |---|---|
//! | [`LineChart`] | values over an axis of numbers, with intervals shaded |
//! | [`BarChart`] | values of groups side by side |
//! | [`Histogram`] | how many values fall into each bin |
//! | [`TrackChart`] | paths over a plane with obstacles, to scale |
//! | [`Plan`] | layers of lines and points on a plane, to scale |
//!
//! Each chart's `write` puts a PNG of 1600 × 1000 pixels and an SVG of the same drawing in place,
//! whole or not at all. One function draws both, by the crate `plotters`.
//!
//! Any data give a picture: values that are not finite are left out, a single value gets an axis
//! around it, and no value at all gives the text *no data*. The same data give the same bytes: the
//! font is part of the program. Colours are those of Okabe and Ito, which colour-blind people can
//! distinguish.
//!
//! Memory: 24 MB for the pixels.

mod axis;
mod bars;
mod canvas;
mod frame;
mod histogram;
mod lines;
mod plane;

pub use axis::Axis;
pub use bars::{BarChart, BarSeries};
pub use histogram::{Histogram, Sample};
pub use lines::{Line, LineChart, Span};
pub use plane::{Ink, Layer, Plan, Spot, TrackChart};

#[cfg(test)]
mod tests;
