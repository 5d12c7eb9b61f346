//! Who owns each cell, packed to as few bits as the number of sensors takes.

use super::Cell;
use crate::narrow::{saturating_usize, wrapping_u8};
use crate::sensor::SensorId;

/// Returns the bits that an owner takes: ⌈log₂(sensors + 1)⌉, *unknown* being one more (\[001\] §7).
#[must_use]
pub const fn owner_bits(sensors: u8) -> u8 {
    let bits = wrapping_u8(u8::BITS.wrapping_sub(sensors.leading_zeros()));
    // Without sensors there is only *unknown*; one bit keeps the arithmetic simple.
    if bits == 0 { 1 } else { bits }
}

/// Returns the bytes that the owners of `cells` cells take with so many `sensors`.
///
/// Formula (\[001\] §7): ⌈log₂(sensors + 1)⌉ · cells / 8, rounded up.
///
/// ```
/// use certainty_core::fusion::owner_bytes;
///
/// assert_eq!(owner_bytes(17 * 11, 3), 47); // 46.75
/// assert_eq!(owner_bytes(17 * 11, 5), 71); // three bits each, 70.125
/// ```
#[must_use]
pub const fn owner_bytes(cells: usize, sensors: u8) -> usize {
    // In whole groups of eight cells first, so that no grid that fits memory overflows.
    let bits = owner_bits(sensors) as usize;
    let rest = (cells % 8).wrapping_mul(bits).div_ceil(8);
    (cells / 8).saturating_mul(bits).saturating_add(rest)
}

/// The owners of a grid's cells.
///
/// Owners may straddle two bytes: three bits a cell are three bits a cell.
#[derive(Debug, Clone)]
pub(super) struct Owners<O> {
    bits: u8,
    packed: O,
}

/// Where an owner is: the byte it starts in, how far it is shifted there, and its mask.
#[derive(Debug, Clone, Copy)]
pub(super) struct Field {
    byte: usize,
    shift: u32,
    mask: u16,
}

impl Field {
    /// Whether it reaches into the next byte.
    const fn straddles(self) -> bool {
        self.mask << self.shift > 0xFF
    }
}

impl<O: AsRef<[u8]> + AsMut<[u8]>> Owners<O> {
    /// Creates owners in `packed`, zeros of [`owner_bytes`] length.
    pub(super) const fn new(sensors: u8, packed: O) -> Self {
        Self {
            bits: owner_bits(sensors),
            packed,
        }
    }

    /// Where the owner of `cell` is.
    #[inline]
    pub(super) const fn field(&self, cell: Cell) -> Field {
        // The bits before this owner's: at most 2^32 cells of 8.
        let position = (cell.number() as u64).wrapping_mul(self.bits as u64);
        let [low, ..] = position.to_le_bytes();
        Field {
            byte: saturating_usize(position / 8),
            shift: (low % 8) as u32,
            mask: (1_u16 << (self.bits & 15)).wrapping_sub(1),
        }
    }

    /// The owner there; `None` if unknown.
    #[inline]
    pub(super) fn get(&self, field: Field) -> Option<SensorId> {
        let packed = self.packed.as_ref();
        let at = |byte: usize| u16::from(packed.get(byte).copied().unwrap_or(0));
        let mut window = at(field.byte);
        if field.straddles() {
            window |= at(field.byte.wrapping_add(1)) << 8;
        }
        SensorId::new(wrapping_u8(((window >> field.shift) & field.mask).into()))
    }

    /// Makes `owner` the owner there.
    #[inline]
    pub(super) fn set(&mut self, field: Field, owner: Option<SensorId>) {
        let Field { byte, shift, mask } = field;
        let number = u16::from(owner.map_or(0, SensorId::number)) & mask;
        let packed = self.packed.as_mut();
        let [low_mask, high_mask] = (mask << shift).to_le_bytes();
        let [low, high] = (number << shift).to_le_bytes();
        if let Some(stored) = packed.get_mut(byte) {
            *stored = (*stored & !low_mask) | low;
        }
        if field.straddles()
            && let Some(stored) = packed.get_mut(byte.wrapping_add(1))
        {
            *stored = (*stored & !high_mask) | high;
        }
    }

    pub(super) fn memory_bytes(&self) -> usize {
        self.packed.as_ref().len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn bits_are_the_ceiling_of_the_logarithm() {
        for sensors in 1..=u8::MAX {
            let exact = (f64::from(sensors) + 1.0).log2().ceil();
            assert_eq!(f64::from(owner_bits(sensors)), exact, "{sensors} sensors");
        }
    }

    #[test]
    fn bytes_are_the_papers_formula() {
        for sensors in [1, 2, 3, 4, 5, 7, 8, 15, 24, 255] {
            for cells in 0..400 {
                let exact = (usize::from(owner_bits(sensors)) * cells).div_ceil(8);
                assert_eq!(owner_bytes(cells, sensors), exact);
            }
        }
    }

    proptest! {
        #[test]
        fn packed_owners_are_an_array_of_owners(
            sensors in 1..=255_u8,
            writes in prop::collection::vec((0..61_u32, 0..=255_u8), 0..200),
        ) {
            let mut owners = Owners::new(sensors, vec![0; owner_bytes(61, sensors)]);
            let mut plain = [None; 61];
            for (index, number) in writes {
                let owner = SensorId::new(number % (sensors.saturating_add(1)).max(1));
                owners.set(owners.field(Cell::from_index(index)), owner);
                plain[index as usize] = owner;
            }
            for (index, &owner) in plain.iter().enumerate() {
                let field = owners.field(Cell::from_index(index as u32));
                prop_assert_eq!(owners.get(field), owner);
            }
        }
    }
}
