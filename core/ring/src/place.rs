//! Places to a sixteenth of a millimetre, near the robot.

use certainty_core::narrow::saturating_i32;
use certainty_core::units::{Direction, Millimeters, Point};

/// Bits of a fraction of a millimetre.
pub(super) const FINE_BITS: u32 = 4;

/// A place in the robot's frame, in sixteenths of a millimetre.
///
/// A line through noisy points is known better than to a millimetre, and so is where two meet.
///
/// Units and range: each coordinate within ±2^24 sixteenths (about a kilometre, beyond which it
/// saturates), so that products of two differences fit 52 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FinePoint {
    x: i32,
    y: i32,
}

impl FinePoint {
    /// Steps in a millimetre.
    pub const STEPS: i32 = 1 << FINE_BITS;

    /// Largest absolute coordinate, in sixteenths of a millimetre.
    const LIMIT: i64 = 1 << 24;

    /// Creates a place from its coordinates in sixteenths of a millimetre; they saturate.
    #[must_use]
    pub const fn from_sixteenths(x: i64, y: i64) -> Self {
        Self {
            x: limited(x),
            y: limited(y),
        }
    }

    /// Creates a place from whole millimetres.
    #[must_use]
    pub const fn from_point(point: Point) -> Self {
        Self::from_sixteenths(
            (point.x_mm() as i64) << FINE_BITS,
            (point.y_mm() as i64) << FINE_BITS,
        )
    }

    /// Returns the coordinate along +x in sixteenths of a millimetre.
    #[must_use]
    pub const fn x(self) -> i32 {
        self.x
    }

    /// Returns the coordinate along +y in sixteenths of a millimetre.
    #[must_use]
    pub const fn y(self) -> i32 {
        self.y
    }

    /// The place `distance` sixteenths of a millimetre from the origin in `direction`, rounded.
    pub(super) const fn polar(distance: i32, direction: Direction) -> Self {
        Self {
            x: limited(share(distance, direction.cos())),
            y: limited(share(distance, direction.sin())),
        }
    }

    pub(super) const fn plus(self, other: Self) -> Self {
        Self {
            x: self.x.wrapping_add(other.x),
            y: self.y.wrapping_add(other.y),
        }
    }

    /// The displacement from `other` to here.
    pub(super) const fn minus(self, other: Self) -> Self {
        Self {
            x: self.x.wrapping_sub(other.x),
            y: self.y.wrapping_sub(other.y),
        }
    }

    /// How far `other` lies along this displacement, times its length; below 2^52.
    pub(super) const fn dot(self, other: Self) -> i64 {
        let x = (self.x as i64).wrapping_mul(other.x as i64);
        x.wrapping_add((self.y as i64).wrapping_mul(other.y as i64))
    }

    /// How far `other` lies to the left of this displacement, times its length; below 2^52.
    pub(super) const fn cross(self, other: Self) -> i64 {
        let left = (self.x as i64).wrapping_mul(other.y as i64);
        left.wrapping_sub((self.y as i64).wrapping_mul(other.x as i64))
    }

    pub(super) const fn square(self) -> u64 {
        self.dot(self).unsigned_abs()
    }

    /// The length in sixteenths of a millimetre, rounded down.
    pub(super) const fn length(self) -> u64 {
        self.square().isqrt()
    }

    /// How far it lies along the unit vector, in sixteenths of a millimetre, rounded.
    pub(super) const fn along(self, direction: Direction) -> i32 {
        let x = (self.x as i64).wrapping_mul(direction.cos() as i64);
        let y = (self.y as i64).wrapping_mul(direction.sin() as i64);
        rounded(x.wrapping_add(y))
    }

    /// How far it lies to the left of the unit vector, in steps of 2^-30 of a sixteenth.
    pub(super) const fn left_of(self, direction: Direction) -> i64 {
        let y = (self.y as i64).wrapping_mul(direction.cos() as i64);
        y.wrapping_sub((self.x as i64).wrapping_mul(direction.sin() as i64))
    }
}

/// Millimetres in sixteenths; more than a kilometre counts as one.
pub(super) const fn sixteenths(length: Millimeters) -> i32 {
    limited((length.get() as i64) << FINE_BITS)
}

/// `distance * part` of a unit vector, rounded; fits as `distance` does.
const fn share(distance: i32, part: i32) -> i64 {
    rounded((distance as i64).wrapping_mul(part as i64)) as i64
}

/// A product with a unit vector's part, without its 30 bits of fraction.
const fn rounded(product: i64) -> i32 {
    const HALF: i64 = 1 << (Direction::FRACTION_BITS - 1);
    saturating_i32(product.wrapping_add(HALF) >> Direction::FRACTION_BITS)
}

const fn limited(value: i64) -> i32 {
    if value > FinePoint::LIMIT {
        saturating_i32(FinePoint::LIMIT)
    } else if value < FinePoint::LIMIT.wrapping_neg() {
        saturating_i32(FinePoint::LIMIT.wrapping_neg())
    } else {
        saturating_i32(value)
    }
}
