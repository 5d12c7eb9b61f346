//! The occupied spread around an echo.

use crate::certainty::Certainty;
use crate::narrow::saturating_i8;
use crate::units::{Direction, Point};

/// The occupied spread along a narrow beam: from *occupied* at the echo linearly to *uncertain*.
pub(super) struct Fade {
    pub(super) origin: Point,
    pub(super) direction: Direction,
    pub(super) distance: i64,
    pub(super) spread: i64,
    pub(super) peak: i64,
}

impl Fade {
    /// What the spread says about the cell with this centre; `None` outside it.
    ///
    /// Rounds towards *uncertain*.
    pub(super) fn at(&self, center: Point) -> Option<Certainty> {
        let part = |mm: i32, origin: i32, unit: i32| {
            // At most 2^29 mm times 2^30.
            i64::from(mm)
                .wrapping_sub(i64::from(origin))
                .wrapping_mul(unit.into())
        };
        let Self {
            origin, direction, ..
        } = self;
        let along = part(center.x_mm(), origin.x_mm(), direction.cos()).wrapping_add(part(
            center.y_mm(),
            origin.y_mm(),
            direction.sin(),
        ));
        let along = along >> Direction::FRACTION_BITS;
        let left = self
            .spread
            .wrapping_sub(along.wrapping_sub(self.distance).saturating_abs());
        let deviation = self.peak.wrapping_mul(left).checked_div(self.spread)?;
        (deviation > 0).then(|| Certainty::from_deviation(saturating_i8(deviation)))
    }
}
