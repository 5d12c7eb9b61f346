//! A grid's shape and storage: values chosen at run time, or types.
//!
//! A grid is a shape plus storage. On a host the shape is a [`Geometry`] and the storage a list of bytes.
//! On a microcontroller the shape is a zero-sized type, [`Area`] or one of your own that implements
//! [`FixedShape`], and the storage an array of the size that follows from it. Then the compiler folds the
//! grid's width into the code, and a grid can be a `static` whose bytes are all zero.

use super::geometry::Geometry;
use crate::units::{Millimeters, Point};

/// A source of one geometry: a [`Geometry`] itself, or a type whose geometry is a constant.
pub trait Shape {
    /// Returns the geometry; always the same one.
    fn geometry(&self) -> Geometry;
}

impl Shape for Geometry {
    fn geometry(&self) -> Geometry {
        *self
    }
}

/// A shape whose geometry is a constant of its type, with the arrays that hold such a grid.
///
/// [`Area`] is one. A type of your own gives the numbers a name:
///
/// ```
/// use certainty_core::fusion::{CellArray, FixedShape, Geometry, MedianArray, Shape};
/// use certainty_core::units::{Millimeters, Point};
///
/// #[derive(Clone, Copy)]
/// struct Yard;
///
/// impl FixedShape for Yard {
///     const GEOMETRY: Geometry = Geometry::new(40, 20, Millimeters::new(50), Point::ORIGIN);
///     type Cells<const LAYERS: usize> = CellArray<40, 20, LAYERS>;
/// }
/// assert_eq!(size_of::<Yard>(), 0);
/// assert_eq!(Yard.geometry().cells(), 800);
/// assert_eq!(MedianArray::<Yard, 3>::new(Yard).geometry(), Yard::GEOMETRY);
/// # use certainty_core::fusion::CertaintyGrid;
/// ```
pub trait FixedShape {
    /// The geometry.
    const GEOMETRY: Geometry;

    /// Storage of `LAYERS` bytes a cell.
    type Cells<const LAYERS: usize>: ByteArray;
}

impl<F: FixedShape> Shape for F {
    #[inline]
    fn geometry(&self) -> Geometry {
        F::GEOMETRY
    }
}

/// `COLUMNS` by `ROWS` cells of `CELL_MM` mm, the lower left corner at (`X_MM`, `Y_MM`) mm; in no bytes.
///
/// ```
/// use certainty_core::fusion::{Area, Shape};
///
/// type Yard = Area<17, 11, 100, -850, 0>;
/// assert_eq!(Yard::CELLS, 187);
/// assert_eq!(<Yard>::default().geometry().corner().x_mm(), -850);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Area<
    const COLUMNS: usize,
    const ROWS: usize,
    const CELL_MM: u32,
    const X_MM: i32,
    const Y_MM: i32,
>;

impl<const COLUMNS: usize, const ROWS: usize, const CELL_MM: u32, const X_MM: i32, const Y_MM: i32>
    Area<COLUMNS, ROWS, CELL_MM, X_MM, Y_MM>
{
    /// The number of cells.
    pub const CELLS: usize = COLUMNS.saturating_mul(ROWS);
}

impl<const COLUMNS: usize, const ROWS: usize, const CELL_MM: u32, const X_MM: i32, const Y_MM: i32>
    FixedShape for Area<COLUMNS, ROWS, CELL_MM, X_MM, Y_MM>
{
    const GEOMETRY: Geometry = Geometry::new(
        side(COLUMNS),
        side(ROWS),
        Millimeters::new(CELL_MM),
        Point::from_mm(X_MM, Y_MM),
    );

    type Cells<const LAYERS: usize> = CellArray<COLUMNS, ROWS, LAYERS>;
}

/// A number of columns or rows in the width that [`Geometry`] takes; evaluated at compile time.
const fn side(cells: usize) -> u16 {
    assert!(
        cells <= u16::MAX as usize,
        "a grid's side must be at most 65535 cells"
    );
    let [low, high, ..] = cells.to_le_bytes();
    u16::from_le_bytes([low, high])
}

/// An array of bytes whose length is a constant of its type.
pub trait ByteArray: AsRef<[u8]> + AsMut<[u8]> {
    /// All bytes zero.
    const ZERO: Self;
    /// The number of bytes.
    const LEN: usize;
}

impl<const N: usize> ByteArray for [u8; N] {
    const ZERO: Self = [0; N];
    const LEN: usize = N;
}

/// `LAYERS` bytes for each of `COLUMNS` by `ROWS` cells.
///
/// The same bytes as `[u8; COLUMNS * ROWS * LAYERS]`, a length that stable Rust cannot compute from const
/// parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellArray<const COLUMNS: usize, const ROWS: usize, const LAYERS: usize>(
    [[[u8; COLUMNS]; ROWS]; LAYERS],
);

impl<const COLUMNS: usize, const ROWS: usize, const LAYERS: usize> ByteArray
    for CellArray<COLUMNS, ROWS, LAYERS>
{
    const ZERO: Self = Self([[[0; COLUMNS]; ROWS]; LAYERS]);
    const LEN: usize = size_of::<Self>();
}

impl<const COLUMNS: usize, const ROWS: usize, const LAYERS: usize> AsRef<[u8]>
    for CellArray<COLUMNS, ROWS, LAYERS>
{
    #[inline]
    fn as_ref(&self) -> &[u8] {
        self.0.as_flattened().as_flattened()
    }
}

impl<const COLUMNS: usize, const ROWS: usize, const LAYERS: usize> AsMut<[u8]>
    for CellArray<COLUMNS, ROWS, LAYERS>
{
    #[inline]
    fn as_mut(&mut self) -> &mut [u8] {
        self.0.as_flattened_mut().as_flattened_mut()
    }
}

/// The cells of a fixed shape; evaluated at compile time.
pub(super) const fn fixed_cells<F: FixedShape>() -> usize {
    F::GEOMETRY.cells() as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_array_is_its_bytes_and_no_more() {
        let mut array = CellArray::<17, 11, 3>::ZERO;
        assert_eq!(array.as_ref(), [0; 3 * 187]);
        assert_eq!(array.as_mut().len(), 3 * 187);
        assert_eq!(CellArray::<17, 11, 3>::LEN, 3 * 187);
        assert_eq!(size_of::<CellArray<17, 11, 3>>(), 3 * 187);
    }

    #[test]
    fn an_area_is_the_geometry_of_its_numbers() {
        type Yard = Area<17, 11, 100, -850, 0>;
        let geometry = Geometry::new(17, 11, Millimeters::new(100), Point::from_mm(-850, 0));
        assert_eq!(Yard::GEOMETRY, geometry);
        assert_eq!(<Yard>::default().geometry(), geometry);
        assert_eq!(size_of::<Yard>(), 0);
    }
}
