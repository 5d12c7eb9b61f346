//! A sector: which cells lie in a beam with a width, as an ultrasonic ranger has.

use super::geometry::Geometry;
use crate::units::{BinaryAngle, Direction, Millimeters, Point};
use core::num::Wrapping;
use core::ops::Range;

/// A sector in the map's frame.
pub(super) struct Cone {
    origin: Point,
    bearing: BinaryAngle,
    axis: Direction,
    edge: Direction,
    half_width: BinaryAngle,
    half_cell: i64,
    belongs: Belongs,
}

/// When a cell belongs to a cone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Belongs {
    /// When half of it does.
    ByItsHalf,
    /// When its centre does, or the axis crosses it.
    ByItsCenter,
}

/// The place of a cell's centre in a cone.
pub(super) struct Place {
    /// From the apex, in millimetres.
    pub(super) distance: i64,
    /// 0 on the axis, 256 at the edge or beyond.
    pub(super) off_axis: i64,
}

impl Cone {
    /// Creates the sector of rays from `origin` within `half_width` of `bearing`.
    pub(super) fn new(
        origin: Point,
        bearing: BinaryAngle,
        half_width: BinaryAngle,
        half_cell: i64,
        belongs: Belongs,
    ) -> Self {
        Self {
            origin,
            bearing,
            axis: bearing.direction(),
            edge: half_width.direction(),
            half_width,
            half_cell,
            belongs,
        }
    }

    /// Returns the place of the cell with this `center`; `None` if it does not belong to the cone.
    pub(super) fn place(&self, center: Point) -> Option<Place> {
        let part = |mm: i32, origin: i32| Wrapping(i64::from(mm).wrapping_sub(i64::from(origin)));
        let x = part(center.x_mm(), self.origin.x_mm());
        let y = part(center.y_mm(), self.origin.y_mm());
        let (cos, sin) = (
            Wrapping(i64::from(self.axis.cos())),
            Wrapping(i64::from(self.axis.sin())),
        );
        // At most 2^30 mm times 2^30, twice: 61 bits.
        const FRACTION: usize = Direction::FRACTION_BITS as usize;
        let along = (x * cos + y * sin) >> FRACTION;
        // The magnitude first: a mirrored cell is as far from the axis.
        let across = Wrapping((y * cos - x * sin).0.saturating_abs()) >> FRACTION;
        if along.0 < 0 {
            return None;
        }
        let off = match self.belongs {
            _ if across.0 <= self.half_cell => 0, // the axis crosses it
            Belongs::ByItsHalf => across.0.saturating_sub(self.half_cell),
            Belongs::ByItsCenter => across.0,
        };
        // tan(off axis) ≤ tan(half width), both sides times both cosines.
        let (edge_cos, edge_sin) = (
            Wrapping(i64::from(self.edge.cos())),
            Wrapping(i64::from(self.edge.sin())),
        );
        let (reached, limit) = (Wrapping(off) * edge_cos, along * edge_sin);
        if reached > limit {
            return None;
        }
        let unit = (limit.0 >> 8).max(1);
        let square = (along * along + across * across).0;
        Some(Place {
            distance: square.checked_isqrt().unwrap_or(0),
            off_axis: reached.0.checked_div(unit).unwrap_or(256).min(256),
        })
    }

    /// The columns and rows of the box around the cone, clipped to the grid; `None` if outside.
    pub(super) fn bounds(
        &self,
        geometry: &Geometry,
        reach: Millimeters,
    ) -> Option<(Range<u32>, Range<u32>)> {
        // A sector's box is spanned by its apex, the ends of its edges, and where its arc meets the
        // axes of the map.
        let corners = [
            Some(self.bearing + self.half_width),
            Some(self.bearing - self.half_width),
        ];
        let poles = [0_u16, 0x4000, 0x8000, 0xC000].map(|bits| {
            let pole = BinaryAngle::from_bits(bits);
            (pole.separation(self.bearing) <= self.half_width).then_some(pole)
        });
        let (mut low, mut high) = (self.origin, self.origin);
        for direction in corners.into_iter().chain(poles).flatten() {
            let tip = self.origin.ahead(direction.direction(), reach);
            low = Point::from_mm(low.x_mm().min(tip.x_mm()), low.y_mm().min(tip.y_mm()));
            high = Point::from_mm(high.x_mm().max(tip.x_mm()), high.y_mm().max(tip.y_mm()));
        }
        let (first, last) = (geometry.address(low), geometry.address(high));
        // One cell more on each side for the half cell that a cone is widened by.
        let clipped = |first: i64, last: i64, cells: u16| {
            let first = first.saturating_sub(1).max(0);
            let end = last.saturating_add(2).min(cells.into());
            let (first, end) = (u32::try_from(first).ok()?, u32::try_from(end).ok()?);
            (first < end).then_some(first..end)
        };
        Some((
            clipped(first.0, last.0, geometry.columns())?,
            clipped(first.1, last.1, geometry.rows())?,
        ))
    }
}
