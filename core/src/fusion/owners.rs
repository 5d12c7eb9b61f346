//! The owner of each cell, packed to as few bits as the number of sensors needs.

use super::geometry::Cell;
use crate::narrow::wrapping_u8;
use crate::sensor::SensorId;

/// Returns the bits that an owner takes: ⌈log₂(sensors + 1)⌉, as *unknown* is one more value (\[001\] §7).
#[must_use]
pub const fn owner_bits(sensors: u8) -> u8 {
    let bits = wrapping_u8(u8::BITS.wrapping_sub(sensors.leading_zeros()));
    // Without sensors there is only *unknown*; one bit avoids a special case.
    if bits == 0 { 1 } else { bits }
}

/// Returns the bytes that the owners of `cells` cells of a grid for `sensors` sensors take.
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

/// The owners of a grid's cells, of a fixed number of bits each. An owner may straddle two bytes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Owners<'a> {
    bits: u8,
    packed: &'a [u8],
}

/// The same, to be written.
#[derive(Debug)]
pub(super) struct OwnersMut<'a> {
    bits: u8,
    packed: &'a mut [u8],
}

/// An owner's place: the byte it starts in, its shift there, and its mask.
#[derive(Debug, Clone, Copy)]
struct Field {
    byte: usize,
    shift: u32,
    mask: u8,
}

impl Field {
    /// The mask at the owner's place, in the low two bytes.
    #[inline]
    const fn mask_in_place(self) -> u32 {
        (self.mask as u32).wrapping_shl(self.shift)
    }

    /// Whether it reaches into the next byte.
    #[inline]
    const fn straddles(self) -> bool {
        self.mask_in_place() > 0xFF
    }

    /// The part of an owner's number that `low`, the byte it starts in, holds.
    #[inline]
    const fn out_of_low(self, low: u8) -> u8 {
        low.wrapping_shr(self.shift) & self.mask
    }

    /// The part that `high`, the byte it reaches into, holds.
    const fn out_of_high(self, high: u8) -> u8 {
        wrapping_u8(((high as u32) << 8).wrapping_shr(self.shift)) & self.mask
    }

    /// The same for the byte after this owner's first in `packed`; rare, so it is kept out of the loop.
    #[cold]
    fn read_high(self, packed: &[u8]) -> u8 {
        let high = packed.get(self.byte.wrapping_add(1)).copied();
        self.out_of_high(high.unwrap_or(0))
    }
}

/// Writes the bits of the second byte of `number` that `mask` selects, after `byte` in `packed`; rare, so
/// it is kept out of the loop.
#[cold]
fn write_high(packed: &mut [u8], byte: usize, mask: u32, number: u32) {
    if let Some(stored) = packed.get_mut(byte.wrapping_add(1)) {
        let ([_, mask, ..], [_, high, ..]) = (mask.to_le_bytes(), number.to_le_bytes());
        *stored = (*stored & !mask) | high;
    }
}

/// An owner's place in storage, looked up once to be read and written.
#[derive(Debug)]
pub(super) struct Slot<'a> {
    field: Field,
    packed: &'a mut [u8],
    /// The owner there; `None` if unknown.
    pub(super) owner: Option<SensorId>,
}

impl<'a> OwnersMut<'a> {
    /// The owners in `packed`, [`owner_bytes`] long, of a grid for `sensors` sensors.
    #[inline]
    pub(super) const fn new(sensors: u8, packed: &'a mut [u8]) -> Self {
        Self {
            bits: owner_bits(sensors),
            packed,
        }
    }

    /// The place of the owner of `cell`; `None` for a cell of another grid that lies outside this one.
    #[inline]
    pub(super) fn slot(&mut self, cell: Cell) -> Option<Slot<'_>> {
        let field = field(cell, self.bits);
        let mut number = field.out_of_low(*self.packed.get(field.byte)?);
        if field.straddles() {
            number |= field.read_high(self.packed);
        }
        Some(Slot {
            field,
            packed: self.packed,
            owner: SensorId::try_new(number),
        })
    }
}

impl Slot<'_> {
    /// Writes `owner`, one of the sensors that the grid has room for.
    #[inline]
    pub(super) fn set(self, owner: Option<SensorId>) {
        let Self { field, packed, .. } = self;
        let mask = field.mask_in_place();
        let number = u32::from(owner.map_or(0, SensorId::number)).wrapping_shl(field.shift);
        if let Some(stored) = packed.get_mut(field.byte) {
            let ([mask, ..], [low, ..]) = (mask.to_le_bytes(), number.to_le_bytes());
            *stored = (*stored & !mask) | low;
        }
        if field.straddles() {
            write_high(packed, field.byte, mask, number);
        }
    }
}

/// The place of the owner of `cell`, where owners take `bits` each.
#[inline]
const fn field(cell: Cell, bits: u8) -> Field {
    // In whole groups of eight cells first: 2^29 groups of 8 bytes are all that 32 bits count.
    let (group, rest) = (cell.number() / 8, cell.number() % 8);
    let rest = rest.wrapping_mul(bits as u32);
    Field {
        byte: group.wrapping_mul(bits as u32).wrapping_add(rest / 8) as usize,
        shift: rest % 8,
        // 1 to 8 bits.
        mask: 0xFF_u8 >> (8_u8.wrapping_sub(bits) & 7),
    }
}

impl<'a> Owners<'a> {
    /// The owners in `packed`, [`owner_bytes`] long, of a grid for `sensors` sensors.
    pub(super) const fn new(sensors: u8, packed: &'a [u8]) -> Self {
        Self {
            bits: owner_bits(sensors),
            packed,
        }
    }

    /// The owner of `cell`; `None` if unknown.
    pub(super) fn get(&self, cell: Cell) -> Option<SensorId> {
        let field = field(cell, self.bits);
        let low = field.out_of_low(*self.packed.get(field.byte)?);
        SensorId::try_new(low | field.read_high(self.packed))
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

    /// The byte and the shift as one position in bits, of 64 bits.
    #[test]
    fn an_owners_place_is_its_bit_in_the_largest_grid_too() {
        for sensors in [1, 3, 5, 8, 30, 60, 100, 255] {
            let bits = owner_bits(sensors);
            let cells = (0..1000).chain(u32::MAX - 1000..=u32::MAX);
            for number in cells.chain((0..u32::MAX).step_by(999_983)) {
                let position = u64::from(number) * u64::from(bits);
                let field = field(Cell::from_index(number), bits);
                assert_eq!(field.byte as u64, position / 8);
                assert_eq!(u64::from(field.shift), position % 8);
            }
        }
    }

    proptest! {
        #[test]
        fn packed_owners_are_an_array_of_owners(
            sensors in 1..=255_u8,
            writes in prop::collection::vec((0..61_u32, 0..=255_u8), 0..200),
        ) {
            let mut packed = vec![0; owner_bytes(61, sensors)];
            let mut plain = [None; 61];
            for (index, number) in writes {
                let owner = SensorId::try_new(number % (sensors.saturating_add(1)).max(1));
                let mut owners = OwnersMut::new(sensors, &mut packed);
                owners.slot(Cell::from_index(index)).unwrap().set(owner);
                plain[index as usize] = owner;
            }
            for (index, &owner) in plain.iter().enumerate() {
                let cell = Cell::from_index(index as u32);
                prop_assert_eq!(Owners::new(sensors, &packed).get(cell), owner);
                let mut owners = OwnersMut::new(sensors, &mut packed);
                prop_assert_eq!(owners.slot(cell).unwrap().owner, owner);
            }
        }
    }
}
