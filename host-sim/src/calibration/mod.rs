//! What a sensor's bytes are worth: its characteristic from measured points, and its errors then.
//!
//! [`load`] reads a table of measured points, [`Assessment`] fits a unit and holds what it then
//! reads against the truth, [`error_histogram`] and [`error_over_distance`] draw that as \[001\]
//! Fig. 6 does. The errors are those of the very points that were fitted: they say how well the
//! characteristic can follow the unit, not how far the unit strays from one day to the next.

mod assessment;
mod figure;
mod file;

pub use assessment::{Assessment, PointError, Spread, UnfitError, typical};
pub use figure::{error_histogram, error_over_distance};
pub use file::{MOST_BYTES, MeasurementsError, load};
