//! The occupied spread around an echo.

use super::Beam;
use crate::certainty::Certainty;
use crate::narrow::saturating_i8;
use crate::units::{Direction, Point};

/// The occupied spread along a narrow beam: from *occupied* at the echo linearly to *uncertain*.
pub(super) struct Fade<'a> {
    pub(super) beam: &'a Beam,
    pub(super) distance: i64,
    pub(super) spread: i64,
    pub(super) peak: i64,
}

impl Fade<'_> {
    /// What the spread says about the cell with this centre; `None` outside it.
    ///
    /// Rounds towards *uncertain*.
    pub(super) fn at(&self, center: Point) -> Option<Certainty> {
        let direction = self.beam.bearing.direction();
        let part = |mm: i32, origin: i32, unit: i32| {
            // At most 2^29 mm times 2^30.
            i64::from(mm)
                .wrapping_sub(i64::from(origin))
                .wrapping_mul(unit.into())
        };
        let origin = self.beam.origin;
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
