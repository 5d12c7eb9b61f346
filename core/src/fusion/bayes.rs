//! The classic certainty grid: eq. 1 of \[001\], one byte a cell.
//!
//! [`LogOdds`] turns the product of eq. 1 into an addition, [`Strength`] limits what one measurement adds.

use super::geometry::{Cell, Geometry};
use super::grid::{CertaintyGrid, GridError, Measurement, zeroed};
use super::shape::{ByteArray, FixedShape, Shape, fixed_cells};
use crate::certainty::Certainty;
use crate::health::Health;
use crate::narrow::saturating_i8;
use core::borrow::Borrow;
use core::fmt;

/// A grid that fuses by Bayes' rule (\[001\] §3, eq. 1).
///
/// A cell keeps its log-odds, so a measurement is one saturating addition. Every measurement counts
/// alike: a sensor that is always wrong counts as much as a correct one. Prefer it where sensors are
/// sound; it is the smallest and the fastest.
///
/// Its strength is a value ([`Strength`]), or in the type and in no bytes ([`DefaultStrength`]).
///
/// Order: no influence, as long as no cell reaches the bound of [`LogOdds`] on the way. (A cell's sum
/// may rest at −128, one step below it, and reads as −127.)
///
/// Memory: one byte a cell. Cost: one table look-up a beam and one addition a cell.
#[derive(Debug, Clone)]
pub struct BayesGrid<Sh, S, L = Strength> {
    shape: Sh,
    strongest: L,
    cells: S,
}

/// A [`BayesGrid`] of a fixed shape: arrays of zeros, [`Strength::MEASUREMENT`].
pub type BayesArray<Sh> = BayesGrid<Sh, <Sh as FixedShape>::Cells<1>, DefaultStrength>;

impl<Sh, S, L> BayesGrid<Sh, S, L>
where
    Sh: Shape,
    S: AsRef<[u8]> + AsMut<[u8]>,
    L: Borrow<Strength>,
{
    /// Creates a grid in which every cell is uncertain.
    ///
    /// `strongest` limits the odds of one measurement, [`Strength::MEASUREMENT`] for instance.
    ///
    /// # Errors
    ///
    /// [`GridError`] unless `storage` has a byte for each cell.
    ///
    /// # Examples
    ///
    /// ```
    /// use certainty_core::certainty::Certainty;
    /// use certainty_core::fusion::{BayesGrid, CertaintyGrid, Geometry, Measurement, Strength};
    /// use certainty_core::sensor::SensorId;
    /// use certainty_core::units::{Millimeters, Point};
    ///
    /// let shape = Geometry::new(17, 11, Millimeters::new(100), Point::ORIGIN);
    /// let mut grid = BayesGrid::try_new(shape, Strength::MEASUREMENT, [0; 187])?;
    /// let cell = shape.cell(3, 4).ok_or("outside")?;
    /// let sensor = SensorId::new(1);
    /// for _ in 0..2 {
    ///     grid.add(cell, Measurement { sensor, certainty: Certainty::OCCUPIED }, &mut []);
    /// }
    /// assert_eq!(grid.certainty(cell).to_bits(), 253); // 81 to 1
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    pub fn try_new(shape: Sh, strongest: L, storage: S) -> Result<Self, GridError<S>> {
        let cells = zeroed(storage, shape.geometry().cells() as usize)?;
        Ok(Self {
            shape,
            strongest,
            cells,
        })
    }
}

impl<Sh: FixedShape, S: ByteArray> BayesGrid<Sh, S, DefaultStrength> {
    /// Creates a grid in which every cell is uncertain, for a `static`.
    ///
    /// It does not compile where `S` has another length than the shape has cells.
    #[must_use]
    pub const fn new(shape: Sh) -> Self {
        const {
            assert!(
                S::LEN == fixed_cells::<Sh>(),
                "a byte for each cell expected"
            );
        };
        Self {
            shape,
            strongest: DefaultStrength,
            cells: S::ZERO,
        }
    }
}

impl<Sh, S, L> CertaintyGrid for BayesGrid<Sh, S, L>
where
    Sh: Shape,
    S: AsRef<[u8]> + AsMut<[u8]>,
    L: Borrow<Strength>,
{
    fn geometry(&self) -> Geometry {
        self.shape.geometry()
    }

    #[inline]
    fn add(&mut self, cell: Cell, measurement: Measurement, sensors: &mut [Health]) {
        self.add_all(core::iter::once(cell), measurement, sensors);
    }

    #[inline]
    fn add_all(
        &mut self,
        cells: impl Iterator<Item = Cell>,
        measurement: Measurement,
        _sensors: &mut [Health],
    ) {
        let added = self.strongest.borrow().odds(measurement.certainty);
        let stored = self.cells.as_mut();
        cells.for_each(|cell| {
            if let Some(stored) = stored.get_mut(cell.index()) {
                let sum = stored.cast_signed().saturating_add(added.steps());
                *stored = sum.cast_unsigned();
            }
        });
    }

    fn clear(&mut self) {
        self.cells.as_mut().fill(0);
    }

    fn certainty(&self, cell: Cell) -> Certainty {
        let stored = self.cells.as_ref().get(cell.index()).copied();
        LogOdds::from_steps(stored.unwrap_or(0).cast_signed()).certainty()
    }

    fn memory_bytes(&self) -> usize {
        self.cells.as_ref().len()
    }
}

/// The largest odds that eq. 1 takes from one measurement, for *free* and for *occupied*.
///
/// A measurement of *free* or *occupied* has infinite odds, which eq. 1 could never take back. The two
/// limits differ: an echo comes from an obstacle somewhere in its cell, while a beam that passes has
/// crossed a line through the cell and not the whole cell, so that it passes many cells that hold an obstacle.
///
/// Possession proves that the limit for *free* is not above even odds and that for *occupied* not below.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Strength {
    /// Not above zero.
    free: LogOdds,
    /// Not below zero.
    occupied: LogOdds,
}

/// A limit is on the wrong side of even odds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StrengthError;

impl StrengthError {
    const fn message(self) -> &'static str {
        "the odds of free must not be above even, those of occupied not below"
    }
}

impl fmt::Display for StrengthError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message())
    }
}

impl core::error::Error for StrengthError {}

/// [`Strength::MEASUREMENT`], in no bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DefaultStrength;

impl Borrow<Strength> for DefaultStrength {
    #[inline]
    fn borrow(&self) -> &Strength {
        const { &Strength::MEASUREMENT }
    }
}

impl Strength {
    /// The choice of the simulator's fault campaign: 0.29 and 0.9, the odds of -14/16 and 35/16 nat.
    ///
    /// The sensors of \[001\] Table 1 err in 4 to 18 % of their readings, so nine to one is about what
    /// one echo is worth. The worth of a passing beam was chosen for the least mean squared error of the
    /// maps over all faults.
    pub const MEASUREMENT: Self = Self::new(LogOdds::from_steps(-14), LogOdds::from_steps(35));

    /// The choice of the fault campaign for a grid of one sensor: 0.29 and 0.98, the odds of -14/16 and
    /// 64/16 nat.
    ///
    /// An echo counts more than in [`Self::MEASUREMENT`]: a wrong value in one sensor's grid is outvoted
    /// by the others, while an obstacle that one sensor's grid has lost cannot be restored from theirs.
    pub const OWN: Self = Self::new(LogOdds::from_steps(-14), LogOdds::from_steps(64));

    /// No limit but that of [`LogOdds`].
    pub const UNLIMITED: Self = Self::new(LogOdds::MIN, LogOdds::MAX);

    /// Creates the limits of a constant: [`Self::try_new`] that refuses at compile time.
    ///
    /// # Panics
    ///
    /// With the message of [`StrengthError`]; in a constant that is a compile error.
    #[must_use]
    #[expect(clippy::panic, reason = "for constants, where it is a compile error")]
    pub const fn new(free: LogOdds, occupied: LogOdds) -> Self {
        match Self::try_new(free, occupied) {
            Ok(strength) => strength,
            Err(error) => panic!("{}", error.message()),
        }
    }

    /// Creates the limits: the lowest odds of a measurement of *free*, the highest of one of *occupied*.
    ///
    /// Even odds take nothing from measurements of that side.
    ///
    /// # Errors
    ///
    /// [`StrengthError`] if a limit is on the wrong side of even odds.
    pub const fn try_new(free: LogOdds, occupied: LogOdds) -> Result<Self, StrengthError> {
        if free.steps() > 0 || occupied.steps() < 0 {
            Err(StrengthError)
        } else {
            Ok(Self { free, occupied })
        }
    }

    /// Returns the odds of a measurement, within the limits.
    ///
    /// ```
    /// use certainty_core::certainty::Certainty;
    /// use certainty_core::fusion::Strength;
    ///
    /// assert_eq!(Strength::MEASUREMENT.odds(Certainty::FREE).steps(), -14);
    /// assert_eq!(Strength::MEASUREMENT.odds(Certainty::OCCUPIED).steps(), 35);
    /// assert_eq!(Strength::MEASUREMENT.odds(Certainty::UNCERTAIN).steps(), 0);
    /// ```
    #[must_use]
    #[inline]
    pub const fn odds(self, measurement: Certainty) -> LogOdds {
        let odds = LogOdds::of(measurement);
        if odds.steps() > self.occupied.steps() {
            self.occupied
        } else if odds.steps() < self.free.steps() {
            self.free
        } else {
            odds
        }
    }
}

/// The logarithm of the odds of being occupied, in steps of 1/16 nat.
///
/// Formula: 16 · ln(p / (1 − p)). In this form eq. 1 of \[001\], which multiplies odds, is an addition.
///
/// Units and range: −127 to 127, which is p = 0.00036 to 0.99964; the sum saturates there. Eq. 1 itself
/// divides by zero at p = 0 and never leaves 0 or 1 again; with the bound a cell recovers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LogOdds(i8);

impl LogOdds {
    /// Steps in one nat.
    pub const STEPS_PER_NAT: u8 = 16;
    /// Even odds.
    pub const EVEN: Self = Self(0);
    /// The highest odds of being occupied.
    pub const MAX: Self = Self(127);

    /// The lowest odds of being occupied.
    pub const MIN: Self = Self(-127);

    /// Creates log-odds of `steps`; −128 becomes −127.
    #[must_use]
    pub const fn from_steps(steps: i8) -> Self {
        Self(if steps == i8::MIN { -127 } else { steps })
    }

    /// Creates the log-odds nearest to `steps`.
    pub(super) const fn from_steps_saturating(steps: i16) -> Self {
        Self::from_steps(saturating_i8(steps as i64))
    }

    /// Returns the number of steps, `-127..=127`.
    #[must_use]
    pub const fn steps(self) -> i8 {
        self.0
    }

    /// Returns the log-odds of `certainty`.
    ///
    /// Rounds to the nearest step. *Free* and *occupied*, whose odds are infinite, are ∓127.
    ///
    /// ```
    /// use certainty_core::certainty::Certainty;
    /// use certainty_core::fusion::LogOdds;
    ///
    /// assert_eq!(LogOdds::from(Certainty::UNCERTAIN), LogOdds::EVEN);
    /// assert_eq!(LogOdds::from(Certainty::OCCUPIED), LogOdds::MAX);
    /// assert_eq!(LogOdds::from(Certainty::from_bits(192)).steps(), 18); // 16 · ln 3
    /// ```
    #[must_use]
    #[expect(
        clippy::indexing_slicing,
        reason = "a byte is always inside a table of 256"
    )]
    pub const fn of(certainty: Certainty) -> Self {
        Self(OF_CERTAINTY[certainty.to_bits() as usize])
    }

    /// Returns the certainty with these odds.
    ///
    /// Rounds to the nearest step of 1/256.
    #[must_use]
    #[expect(
        clippy::indexing_slicing,
        reason = "a byte is always inside a table of 256"
    )]
    pub const fn certainty(self) -> Certainty {
        Certainty::from_bits(OF_LOG_ODDS[self.0.cast_unsigned() as usize])
    }

    /// Returns the odds after another, independent measurement: eq. 1 of \[001\] for n = 2.
    #[must_use]
    pub const fn saturating_add(self, other: Self) -> Self {
        Self::from_steps(self.0.saturating_add(other.0))
    }
}

impl From<Certainty> for LogOdds {
    fn from(certainty: Certainty) -> Self {
        Self::of(certainty)
    }
}

/// Computed at compile time; none of the code that makes it is in an image.
static OF_CERTAINTY: [i8; 256] = of_certainty();
static OF_LOG_ODDS: [u8; 256] = of_log_odds();

#[expect(
    clippy::indexing_slicing,
    clippy::arithmetic_side_effects,
    clippy::cast_possible_truncation,
    clippy::float_arithmetic,
    reason = "evaluated at compile time, where a mistake is a compile error"
)]
const fn of_certainty() -> [i8; 256] {
    let mut table = [0; 256];
    table[0] = -127;
    table[255] = 127;
    let mut bits = 1;
    while bits < 255 {
        let odds = bits as f64 / (256 - bits) as f64;
        let steps = LogOdds::STEPS_PER_NAT as f64 * ln(odds);
        table[bits] = rounded(steps) as i8;
        bits += 1;
    }
    table
}

#[expect(
    clippy::indexing_slicing,
    clippy::arithmetic_side_effects,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::float_arithmetic,
    reason = "evaluated at compile time, where a mistake is a compile error"
)]
const fn of_log_odds() -> [u8; 256] {
    let mut table = [0; 256];
    let mut steps = -127_i32;
    while steps <= 127 {
        let odds = exp(steps as f64 / LogOdds::STEPS_PER_NAT as f64);
        let bits = rounded(256.0 * odds / (1.0 + odds));
        table[(steps & 0xFF) as usize] = if bits > 255 { 255 } else { bits as u8 };
        steps += 1;
    }
    table
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::float_arithmetic,
    reason = "compile time"
)]
const fn rounded(value: f64) -> i32 {
    (if value < 0.0 {
        value - 0.5
    } else {
        value + 0.5
    }) as i32
}

/// ln of a positive number: 2 · artanh((x − 1) / (x + 1)) after taking out powers of e.
#[expect(
    clippy::arithmetic_side_effects,
    clippy::float_arithmetic,
    reason = "compile time"
)]
const fn ln(value: f64) -> f64 {
    let mut x = value;
    let mut whole = 0.0;
    while x > core::f64::consts::E {
        x /= core::f64::consts::E;
        whole += 1.0;
    }
    while x < 1.0 {
        x *= core::f64::consts::E;
        whole -= 1.0;
    }
    let z = (x - 1.0) / (x + 1.0);
    let mut power = z;
    let mut sum = 0.0;
    let mut k = 1;
    while k < 60 {
        sum += power / k as f64;
        power *= z * z;
        k += 2;
    }
    whole + 2.0 * sum
}

/// e to the power of `value`: the series of value / 32, squared five times.
#[expect(
    clippy::arithmetic_side_effects,
    clippy::float_arithmetic,
    reason = "compile time"
)]
const fn exp(value: f64) -> f64 {
    let x = value / 32.0;
    let mut sum = 1.0;
    let mut term = 1.0;
    let mut k = 1;
    while k < 20 {
        term *= x / k as f64;
        sum += term;
        k += 1;
    }
    let mut squarings = 5;
    while squarings > 0 {
        sum *= sum;
        squarings -= 1;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::super::grid::GridErrorKind;
    use super::super::shape::Area;
    use super::*;
    use crate::sensor::SensorId;
    use crate::units::{Millimeters, Point};
    use proptest::prelude::*;

    fn one_cell(strongest: Strength) -> (BayesGrid<Geometry, [u8; 1]>, Cell) {
        let shape = Geometry::try_new(1, 1, Millimeters::new(100), Point::ORIGIN).unwrap();
        let grid = BayesGrid::try_new(shape, strongest, [7]).unwrap();
        (grid, shape.cell(0, 0).unwrap())
    }

    fn fused(strongest: Strength, measurements: &[u8]) -> Certainty {
        let (mut grid, cell) = one_cell(strongest);
        let sensor = SensorId::try_new(1).unwrap();
        for &bits in measurements {
            let certainty = Certainty::from_bits(bits);
            grid.add(cell, Measurement { sensor, certainty }, &mut []);
        }
        grid.certainty(cell)
    }

    /// Eq. 1 of \[001\] in real numbers: the product of the odds against.
    fn naive(measurements: &[u8]) -> f64 {
        let against = |bits: u8| 256.0 / f64::from(bits) - 1.0;
        let product: f64 = measurements.iter().map(|&bits| against(bits)).product();
        1.0 / (product + 1.0)
    }

    #[test]
    fn a_new_grid_is_uncertain() {
        let (grid, cell) = one_cell(Strength::MEASUREMENT);
        assert_eq!(grid.certainty(cell), Certainty::UNCERTAIN);
    }

    /// A defect of nav2: a cell driven to 0 stayed 0 after 1,000 occupied readings.
    #[test]
    fn a_cell_driven_to_either_end_recovers() {
        for (wrong, right) in [(0, 255), (255, 0)] {
            let driven = [wrong; 1000];
            assert_eq!(fused(Strength::MEASUREMENT, &driven).to_bits(), wrong);
            let back: Vec<u8> = driven.into_iter().chain([right; 20]).collect();
            assert_eq!(fused(Strength::MEASUREMENT, &back).to_bits(), right);
        }
    }

    #[test]
    fn storage_of_another_size_is_handed_back() {
        let shape = Geometry::try_new(2, 2, Millimeters::new(100), Point::ORIGIN).unwrap();
        let refused = BayesGrid::try_new(shape, Strength::MEASUREMENT, [9; 3]).unwrap_err();
        assert_eq!(
            (refused.kind, refused.storage),
            (GridErrorKind::Storage { needed: 4 }, [9; 3])
        );
    }

    proptest! {
        /// With eight bits it holds until a sum passes the bound; the part beyond is lost.
        #[test]
        fn order_is_irrelevant_while_no_cell_reaches_the_bound(
            measurements in prop::collection::vec(0..=255_u8, 0..4), order: prop::sample::Index,
        ) {
            // Three measurements of at most 35 steps stay below 127.
            let mut other = measurements.clone();
            if !other.is_empty() {
                let turn = order.index(other.len());
                other.rotate_left(turn);
                other.reverse();
            }
            prop_assert_eq!(
                fused(Strength::MEASUREMENT, &measurements),
                fused(Strength::MEASUREMENT, &other)
            );
        }

        #[test]
        fn beyond_the_bound_order_moves_a_cell_by_the_excess(
            ups in 0..30_usize, downs in 0..30_usize,
        ) {
            let (ups, downs) = (vec![255_u8; ups], vec![0_u8; downs]);
            let steps = |measurements: Vec<u8>| {
                let (mut grid, cell) = one_cell(Strength::MEASUREMENT);
                let sensor = SensorId::try_new(1).unwrap();
                for bits in measurements {
                    let certainty = Certainty::from_bits(bits);
                    grid.add(cell, Measurement { sensor, certainty }, &mut []);
                }
                i32::from(grid.cells[0].cast_signed())
            };
            let cut = |n: usize| (35 * n as i32 - 127).max(0);
            let bound = cut(ups.len()) + cut(downs.len());
            let one_way = steps([ups.clone(), downs.clone()].concat());
            let other_way = steps([downs, ups].concat());
            prop_assert!((one_way - other_way).abs() <= bound);
        }

        #[test]
        fn fusion_is_eq_1_to_within_the_rounding_of_its_inputs(
            measurements in prop::collection::vec(30..=226_u8, 1..4),
        ) {
            let fused = f64::from(fused(Strength::UNLIMITED, &measurements).to_bits()) / 256.0;
            // Half a step of 1/16 nat each, where the odds move fastest a quarter as much of p.
            let tolerance = 0.5 / 16.0 / 4.0 * measurements.len() as f64 + 0.5 / 256.0 + 1e-9;
            prop_assert!((fused - naive(&measurements)).abs() <= tolerance);
        }
    }

    #[test]
    fn every_measurement_is_within_the_limits_and_on_its_side() {
        let limits = Strength::new(LogOdds::from_steps(-8), LogOdds::from_steps(20));
        for bits in 0..=u8::MAX {
            let certainty = Certainty::from_bits(bits);
            let (exact, limited) = (
                LogOdds::of(certainty).steps(),
                limits.odds(certainty).steps(),
            );
            assert_eq!(limited, exact.clamp(-8, 20), "{bits}");
            assert_eq!(Strength::UNLIMITED.odds(certainty).steps(), exact);
        }
    }

    #[test]
    fn limits_on_the_wrong_side_are_refused() {
        let strength = |free, occupied| {
            Strength::try_new(LogOdds::from_steps(free), LogOdds::from_steps(occupied))
        };
        assert_eq!(strength(5, 5), Err(StrengthError));
        assert_eq!(strength(-5, -5), Err(StrengthError));
        let even = strength(0, 0).unwrap();
        for bits in 0..=u8::MAX {
            assert_eq!(even.odds(Certainty::from_bits(bits)), LogOdds::EVEN);
        }
    }

    #[test]
    fn a_fixed_grid_is_zeros_and_fuses_alike() {
        type Yard = Area<2, 1, 100, 0, 0>;
        let mut fixed = BayesArray::<Yard>::new(Area);
        assert_eq!(size_of_val(&fixed), 2);
        let cell = fixed.geometry().cell(1, 0).unwrap();
        let sensor = SensorId::try_new(1).unwrap();
        let certainty = Certainty::OCCUPIED;
        fixed.add(cell, Measurement { sensor, certainty }, &mut []);
        assert_eq!(fixed.certainty(cell), fused(Strength::MEASUREMENT, &[255]));
        fixed.clear();
        assert_eq!(fixed.cells.as_ref(), [0, 0]);
    }

    #[test]
    fn both_tables_are_the_formula_rounded() {
        for bits in 1..=254_u8 {
            let p = f64::from(bits) / 256.0;
            let exact = 16.0 * (p / (1.0 - p)).ln();
            let steps = LogOdds::of(Certainty::from_bits(bits)).steps();
            assert_eq!(f64::from(steps), exact.round(), "certainty {bits}");
        }
        for steps in -127..=127_i8 {
            let p = 1.0 / (1.0 + (-f64::from(steps) / 16.0).exp());
            let bits = LogOdds::from_steps(steps).certainty().to_bits();
            assert_eq!(
                f64::from(bits),
                (256.0 * p).round().min(255.0),
                "{steps} steps"
            );
        }
    }

    #[test]
    fn the_landmarks_survive_the_way_there_and_back() {
        for landmark in [Certainty::FREE, Certainty::UNCERTAIN, Certainty::OCCUPIED] {
            assert_eq!(LogOdds::of(landmark).certainty(), landmark);
        }
    }

    #[test]
    fn there_and_back_loses_no_more_than_half_a_step() {
        // A step of 1/16 nat is 4 certainties wide in the middle.
        for bits in 0..=u8::MAX {
            let back = LogOdds::of(Certainty::from_bits(bits))
                .certainty()
                .to_bits();
            assert!(back.abs_diff(bits) <= 2, "{bits} came back as {back}");
        }
    }
}
