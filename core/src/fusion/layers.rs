//! A layer of cells for each sensor, fused on demand: median selection and trimmed fusion.
//!
//! Both need a byte a cell and sensor (\[000\] §5, \[001\] §7) and no history of the sensors. An
//! [`OwnGrid`] defines how a layer takes the measurements of its sensor.

use super::bayes::{LogOdds, Strength};
use super::geometry::{Cell, Geometry};
use super::grid::{CertaintyGrid, GridError, GridErrorKind, Measurement, zeroed};
use super::shape::{ByteArray, FixedShape, Shape, fixed_cells};
use crate::certainty::Certainty;
use crate::health::Health;
use crate::narrow::wrapping_u8;
use heapless::Vec;

/// How a sensor's own layer takes the sensor's next measurement of a cell.
///
/// \[000\] §3.1 lets "each sensor produce its own grid" and leaves open how.
pub trait OwnGrid {
    /// The value in a grid that is a constant.
    const DEFAULT: Self;

    /// Returns the byte that is stored after `measurement`; 0 is a cell that the sensor never saw.
    fn updated(&self, stored: u8, measurement: Certainty) -> u8;

    /// Returns the certainty of a stored byte; `None` if the sensor never saw the cell.
    fn certainty(stored: u8) -> Option<Certainty>;
}

/// The latest measurement counts, as `AddToGrid` takes an owner's measurement "as is".
///
/// Stored is the deviation from *uncertain*; as 0 is the code of *never seen*, certainty 127 is read back
/// as 128, its neighbour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Latest;

impl OwnGrid for Latest {
    const DEFAULT: Self = Self;

    #[inline]
    fn updated(&self, _stored: u8, measurement: Certainty) -> u8 {
        match measurement.deviation() {
            0 => (-1_i8).cast_unsigned(),
            deviation => deviation.cast_unsigned(),
        }
    }

    #[inline]
    fn certainty(stored: u8) -> Option<Certainty> {
        match stored.cast_signed() {
            0 => None,
            -1 => Some(Certainty::UNCERTAIN),
            deviation => Some(Certainty::from_deviation(deviation)),
        }
    }
}

/// The sensor's measurements are fused by eq. 1, so that a single wrong one among many is forgotten.
///
/// Stored are log-odds; a cell that was seen and has even odds takes the code −128.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Accumulated {
    /// The largest odds of one measurement.
    pub strongest: Strength,
}

impl Default for Accumulated {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl OwnGrid for Accumulated {
    const DEFAULT: Self = Self {
        strongest: Strength::OWN,
    };

    #[inline]
    fn updated(&self, stored: u8, measurement: Certainty) -> u8 {
        let before = match stored.cast_signed() {
            i8::MIN => LogOdds::EVEN,
            steps => LogOdds::from_steps(steps),
        };
        let added = self.strongest.odds(measurement);
        match before.saturating_add(added).steps() {
            0 => i8::MIN.cast_unsigned(),
            steps => steps.cast_unsigned(),
        }
    }

    #[inline]
    fn certainty(stored: u8) -> Option<Certainty> {
        match stored.cast_signed() {
            0 => None,
            i8::MIN => Some(Certainty::UNCERTAIN),
            steps => Some(LogOdds::from_steps(steps).certainty()),
        }
    }
}

/// The storage of both grids: the layer of sensor 1, that of sensor 2, and so on.
///
/// `N` is the largest number of sensors, and with it the number of votes on the stack.
#[derive(Debug, Clone)]
struct Layers<Sh, S, const N: usize, K> {
    shape: Sh,
    storage: S,
    /// How many sensors less than `N` there are, so that a full grid is all zeros.
    unused: u8,
    own: K,
}

impl<Sh: FixedShape, S: ByteArray, const N: usize, K: OwnGrid> Layers<Sh, S, N, K> {
    /// The layers of `N` sensors; refuses at compile time.
    const fn new(shape: Sh) -> Self {
        const {
            assert!(0 < N && N <= u8::MAX as usize, "1 to 255 sensors expected");
            assert!(
                S::LEN == fixed_cells::<Sh>().saturating_mul(N),
                "a byte for each cell and sensor expected"
            );
        };
        Self {
            shape,
            storage: S::ZERO,
            unused: 0,
            own: K::DEFAULT,
        }
    }
}

impl<Sh, S, const N: usize, K> Layers<Sh, S, N, K>
where
    Sh: Shape,
    S: AsRef<[u8]> + AsMut<[u8]>,
    K: OwnGrid,
{
    /// The largest number of a sensor that the type has room for.
    const MOST: u8 = if N < u8::MAX as usize {
        let [low, ..] = N.to_le_bytes();
        low
    } else {
        u8::MAX
    };

    fn try_new(shape: Sh, sensors: u8, own: K, storage: S) -> Result<Self, GridError<S>> {
        let cells = shape.geometry().cells() as usize;
        let (1.., Some(unused)) = (sensors, Self::MOST.checked_sub(sensors)) else {
            let kind = GridErrorKind::Sensors { most: N };
            return Err(GridError { kind, storage });
        };
        let storage = zeroed(storage, cells.saturating_mul(sensors.into()))?;
        Ok(Self {
            shape,
            storage,
            unused,
            own,
        })
    }

    fn geometry(&self) -> Geometry {
        self.shape.geometry()
    }

    const fn sensors(&self) -> u8 {
        Self::MOST.saturating_sub(self.unused)
    }

    #[inline]
    fn add(&mut self, cell: Cell, measurement: Measurement) {
        let cells = self.shape.geometry().cells() as usize;
        if measurement.sensor.number() > self.sensors() || cell.index() >= cells {
            return;
        }
        let layer = measurement.sensor.slot().wrapping_mul(cells);
        let index = layer.wrapping_add(cell.index());
        if let Some(stored) = self.storage.as_mut().get_mut(index) {
            *stored = self.own.updated(*stored, measurement.certainty);
        }
    }

    fn clear(&mut self) {
        self.storage.as_mut().fill(0);
    }

    /// The certainties of the sensors that saw the cell, in rising order.
    fn votes(&self, cell: Cell) -> Vec<Certainty, N> {
        let cells = self.shape.geometry().cells() as usize;
        let mut votes = Vec::new();
        for layer in self.storage.as_ref().chunks_exact(cells.max(1)) {
            let stored = layer.get(cell.index()).copied().unwrap_or(0);
            if let Some(certainty) = K::certainty(stored) {
                let index = votes.partition_point(|&vote| vote <= certainty);
                let _ = votes.insert(index, certainty); // there are at most N layers: it fits
            }
        }
        votes
    }

    fn memory_bytes(&self) -> usize {
        self.storage.as_ref().len()
    }
}

/// Fault-tolerant median selection: a cell is the middle of its sensors' certainties (\[000\] §3.2, \[001\] §4).
///
/// Of the n sensors that saw a cell, any ⌊(n − 1)/2⌋ may be wrong, and the value still is one that a correct
/// sensor gave, or lies between two of them. Prefer it where sensors overlap fully and memory allows.
///
/// [`Middle`] selects the value of an even number of sensors.
///
/// Memory: n bytes a cell (\[001\] §7). Cost: adding is one store; reading sorts n votes by insertion.
#[derive(Debug, Clone)]
pub struct MedianGrid<Sh, S, const N: usize, K = Latest> {
    layers: Layers<Sh, S, N, K>,
    middle: Middle,
}

/// A [`MedianGrid`] of a fixed shape for `N` sensors: arrays of zeros, [`Middle::Higher`].
pub type MedianArray<Sh, const N: usize, K = Latest> =
    MedianGrid<Sh, <Sh as FixedShape>::Cells<N>, N, K>;

/// The value taken of an even number of votes, which \[000\] §3.2 and \[001\] §4 leave open.
///
/// Either lies between two correct votes while no more than ⌊(n − 1)/2⌋ are wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Middle {
    /// The higher of the middle two: the median is *selected*, as both papers put it, and where two
    /// sensors disagree, the one that found an obstacle counts.
    #[default]
    Higher,
    /// The mean of the middle two, ties up: a value that no sensor gave, *uncertain* for *free* and
    /// *occupied*.
    Mean,
}

impl Middle {
    /// The middle of sorted votes; *uncertain* of none.
    fn of(self, votes: &[Certainty]) -> Certainty {
        let upper = votes.len() / 2;
        let lower = match self {
            Self::Higher => upper,
            Self::Mean => votes.len().saturating_sub(1) / 2,
        };
        match (votes.get(lower), votes.get(upper)) {
            (Some(low), Some(high)) => {
                let sum = u32::from(low.to_bits()).wrapping_add(high.to_bits().into());
                Certainty::from_bits(wrapping_u8(sum.wrapping_add(1) >> 1))
            }
            _ => Certainty::UNCERTAIN,
        }
    }
}

impl<Sh: FixedShape, S: ByteArray, const N: usize, K: OwnGrid> MedianGrid<Sh, S, N, K> {
    /// Creates a grid for `N` sensors that have seen nothing yet, for a `static`.
    ///
    /// It does not compile where `S` has not a byte for each cell and sensor.
    #[must_use]
    pub const fn new(shape: Sh) -> Self {
        Self {
            layers: Layers::new(shape),
            middle: Middle::Higher,
        }
    }
}

impl<Sh, S, const N: usize, K> MedianGrid<Sh, S, N, K>
where
    Sh: Shape,
    S: AsRef<[u8]> + AsMut<[u8]>,
    K: OwnGrid,
{
    /// Creates a grid for sensors 1 to `sensors` that have seen nothing yet; `own` takes each sensor's
    /// measurements.
    ///
    /// # Errors
    ///
    /// [`GridError`] unless `sensors` is 1 to `N` and `storage` has a byte for each cell and sensor.
    pub fn try_new(
        shape: Sh,
        sensors: u8,
        middle: Middle,
        own: K,
        storage: S,
    ) -> Result<Self, GridError<S>> {
        Layers::try_new(shape, sensors, own, storage).map(|layers| Self { layers, middle })
    }
}

impl<Sh, S, const N: usize, K> CertaintyGrid for MedianGrid<Sh, S, N, K>
where
    Sh: Shape,
    S: AsRef<[u8]> + AsMut<[u8]>,
    K: OwnGrid,
{
    fn geometry(&self) -> Geometry {
        self.layers.geometry()
    }

    fn sensors(&self) -> u8 {
        self.layers.sensors()
    }

    #[inline]
    fn add(&mut self, cell: Cell, measurement: Measurement, _sensors: &mut [Health]) {
        self.layers.add(cell, measurement);
    }

    fn clear(&mut self) {
        self.layers.clear();
    }

    fn certainty(&self, cell: Cell) -> Certainty {
        self.middle.of(&self.layers.votes(cell))
    }

    fn memory_bytes(&self) -> usize {
        self.layers.memory_bytes()
    }
}

/// Trim, then Bayes: the fault-tolerant average of \[000\] §3.1.
///
/// Drops the t lowest and the t highest certainties of a cell's sensors and fuses the rest by eq. 1. Any t
/// of the sensors that saw a cell may be wrong. A cell seen by fewer than 2t + 1 sensors is *uncertain*, as
/// nothing would be left after trimming. Prefer the median grid where sensors overlap only partly.
///
/// Memory: n bytes a cell (\[000\] §5). Cost: adding is one store; reading sorts n votes by insertion.
#[derive(Debug, Clone)]
pub struct TrimmedGrid<Sh, S, const N: usize, K = Latest> {
    layers: Layers<Sh, S, N, K>,
    /// How many fewer are trimmed than the number of sensors allows, so that a full grid is all zeros.
    untrimmed: u8,
}

/// A [`TrimmedGrid`] of a fixed shape for `N` sensors: arrays of zeros, trims ⌊(N − 1)/2⌋ at each end.
pub type TrimmedArray<Sh, const N: usize, K = Latest> =
    TrimmedGrid<Sh, <Sh as FixedShape>::Cells<N>, N, K>;

impl<Sh: FixedShape, S: ByteArray, const N: usize, K: OwnGrid> TrimmedGrid<Sh, S, N, K> {
    /// Creates a grid for `N` sensors, of which any minority may be wrong, for a `static`.
    ///
    /// It does not compile where `S` has not a byte for each cell and sensor.
    #[must_use]
    pub const fn new(shape: Sh) -> Self {
        Self {
            layers: Layers::new(shape),
            untrimmed: 0,
        }
    }
}

impl<Sh, S, const N: usize, K> TrimmedGrid<Sh, S, N, K>
where
    Sh: Shape,
    S: AsRef<[u8]> + AsMut<[u8]>,
    K: OwnGrid,
{
    /// Creates a grid for sensors 1 to `sensors`, of which `trim` may be wrong at a time; `own` takes each
    /// sensor's measurements.
    ///
    /// # Errors
    ///
    /// [`GridError`] unless `sensors` is 1 to `N` and at least 2 · `trim` + 1, and `storage` has a byte for
    /// each cell and sensor.
    pub fn try_new(
        shape: Sh,
        sensors: u8,
        trim: u8,
        own: K,
        storage: S,
    ) -> Result<Self, GridError<S>> {
        let most = most_trimmed(sensors);
        match most.checked_sub(trim) {
            Some(untrimmed) if sensors > 0 => Layers::try_new(shape, sensors, own, storage)
                .map(|layers| Self { layers, untrimmed }),
            _ => {
                let kind = GridErrorKind::Trim;
                Err(GridError { kind, storage })
            }
        }
    }

    /// The certainties that are dropped at each end.
    const fn trim(&self) -> u8 {
        most_trimmed(self.layers.sensors()).saturating_sub(self.untrimmed)
    }
}

/// ⌊(sensors − 1)/2⌋: the most that can be trimmed at each end.
const fn most_trimmed(sensors: u8) -> u8 {
    sensors.saturating_sub(1) / 2
}

impl<Sh, S, const N: usize, K> CertaintyGrid for TrimmedGrid<Sh, S, N, K>
where
    Sh: Shape,
    S: AsRef<[u8]> + AsMut<[u8]>,
    K: OwnGrid,
{
    fn geometry(&self) -> Geometry {
        self.layers.geometry()
    }

    fn sensors(&self) -> u8 {
        self.layers.sensors()
    }

    #[inline]
    fn add(&mut self, cell: Cell, measurement: Measurement, _sensors: &mut [Health]) {
        self.layers.add(cell, measurement);
    }

    fn clear(&mut self) {
        self.layers.clear();
    }

    fn certainty(&self, cell: Cell) -> Certainty {
        trimmed(&self.layers.votes(cell), self.trim().into())
    }

    fn memory_bytes(&self) -> usize {
        self.layers.memory_bytes()
    }
}

/// Eq. 1 of sorted votes without the `trim` lowest and highest.
///
/// The odds are summed exactly and limited once, at the end: limited in between, the result of many votes would
/// be that of the last ones, which are the highest.
fn trimmed(votes: &[Certainty], trim: usize) -> Certainty {
    let end = votes.len().saturating_sub(trim);
    let kept = votes.get(trim..end).unwrap_or(&[]);
    // At most 255 votes of 127 steps.
    let sum = kept.iter().fold(0_i16, |sum, &vote| {
        sum.wrapping_add(LogOdds::of(vote).steps().into())
    });
    LogOdds::from_steps_saturating(sum).certainty()
}

#[cfg(test)]
mod tests {
    use super::super::picture::draw_grid;
    use super::super::shape::Area;
    use super::*;
    use crate::sensor::SensorId;
    use crate::units::{Millimeters, Point};
    use proptest::prelude::*;
    use std::vec::Vec;

    #[test]
    fn the_latest_is_kept_but_for_the_code_of_never_seen() {
        assert_eq!(Latest::certainty(0), None);
        for bits in 0..=u8::MAX {
            let stored = Latest.updated(77, Certainty::from_bits(bits));
            let expected = if bits == 127 { 128 } else { bits };
            assert_eq!(
                Latest::certainty(stored),
                Some(Certainty::from_bits(expected))
            );
        }
    }

    #[test]
    fn accumulated_measurements_are_eq_1() {
        assert_eq!(Accumulated::certainty(0), None);
        let own = Accumulated {
            strongest: Strength::MEASUREMENT,
        };
        let occupied = own.updated(0, Certainty::OCCUPIED);
        assert_eq!(
            Accumulated::certainty(occupied).map(Certainty::to_bits),
            Some(230)
        ); // 0.9
        // 35 steps up twice, 14 down five times: even odds in a cell that was seen.
        let occupied_twice = [Certainty::OCCUPIED; 2].into_iter();
        let measured = occupied_twice.chain([Certainty::FREE; 5]);
        let balanced = measured.fold(0, |stored, certainty| own.updated(stored, certainty));
        assert_eq!(Accumulated::certainty(balanced), Some(Certainty::UNCERTAIN));
        let again = own.updated(balanced, Certainty::OCCUPIED);
        assert_eq!(again, occupied);
    }

    fn votes(bits: &[u8]) -> Vec<Certainty> {
        let mut votes: Vec<_> = bits.iter().copied().map(Certainty::from_bits).collect();
        votes.sort();
        votes
    }

    #[test]
    fn the_middle_of_an_odd_number_is_one_of_them() {
        for middle in [Middle::Higher, Middle::Mean] {
            assert_eq!(middle.of(&votes(&[9, 255, 3])).to_bits(), 9);
            assert_eq!(middle.of(&votes(&[77])).to_bits(), 77);
        }
    }

    #[test]
    fn the_middle_of_an_even_number_is_the_higher_or_the_mean() {
        assert_eq!(Middle::Higher.of(&votes(&[0, 255])).to_bits(), 255);
        assert_eq!(Middle::Higher.of(&votes(&[0, 10, 12, 255])).to_bits(), 12);
        assert_eq!(Middle::Mean.of(&votes(&[0, 255])).to_bits(), 128);
        assert_eq!(Middle::Mean.of(&votes(&[0, 10, 11, 255])).to_bits(), 11);
    }

    #[test]
    fn no_vote_is_uncertain() {
        for middle in [Middle::Higher, Middle::Mean] {
            assert_eq!(middle.of(&[]), Certainty::UNCERTAIN);
        }
    }

    #[test]
    fn no_minority_of_liars_moves_the_median_out() {
        every_minority(|all, correct| {
            for middle in [Middle::Higher, Middle::Mean] {
                let value = middle.of(&votes(all)).to_bits();
                let between = correct[0]..=correct[correct.len() - 1];
                assert!(between.contains(&value), "{middle:?} of {all:?}: {value}");
            }
        });
    }

    #[test]
    fn the_vote_adapts_to_the_sensors_that_saw_the_cell() {
        let shape = Geometry::new(4, 1, Millimeters::new(100), Point::ORIGIN);
        let mut grid =
            MedianGrid::<_, _, 3>::try_new(shape, 3, Middle::Higher, Latest, [0; 12]).unwrap();
        // Sensor 3 is wrong everywhere; the further right a cell, the fewer sensors see it.
        for (column, seen_by) in [(0, [1, 2, 3].as_slice()), (1, &[1, 3]), (2, &[3])] {
            let cell = shape.cell(column, 0).unwrap();
            for &number in seen_by {
                let certainty = if number == 3 {
                    Certainty::FREE
                } else {
                    Certainty::OCCUPIED
                };
                let sensor = SensorId::try_new(number).unwrap();
                grid.add(cell, Measurement { sensor, certainty }, &mut []);
            }
        }
        assert_eq!(draw_grid(&grid), ["##.?"]);
    }

    #[test]
    fn more_sensors_than_n_are_refused() {
        let shape = Geometry::new(1, 1, Millimeters::new(100), Point::ORIGIN);
        for sensors in [0, 4] {
            let storage = vec![0; sensors.into()];
            let own = Accumulated::default();
            let middle = Middle::Higher;
            let refused = MedianGrid::<_, _, 3, _>::try_new(shape, sensors, middle, own, storage);
            assert_eq!(
                refused.unwrap_err().kind,
                GridErrorKind::Sensors { most: 3 }
            );
        }
    }

    fn fused(bits: &[u8], trim: usize) -> Certainty {
        let mut votes: Vec<_> = bits.iter().copied().map(Certainty::from_bits).collect();
        votes.sort();
        trimmed(&votes, trim)
    }

    #[test]
    fn the_rest_is_fused_by_eq_1() {
        // 0.75 and 0.75 of [0, 0.75, 0.75, 1]: odds 3 · 3, so 0.9, which is 230.4; each vote is
        // rounded to a step of log-odds, 1.4 of these at most.
        for (votes, trim) in [([0, 192, 255, 192].as_slice(), 1), (&[192, 192], 0)] {
            assert!(fused(votes, trim).to_bits().abs_diff(230) <= 2);
        }
    }

    /// Summed one by one and limited after each, the last votes alone would decide, and these are the highest.
    #[test]
    fn the_order_of_sorted_votes_does_not_decide() {
        let split = [0, 0, 0, 0, 255, 255, 255];
        assert_eq!(fused(&split, 1), Certainty::FREE);
        let many = [[200; 100].as_slice(), &[56; 100]].concat();
        assert_eq!(fused(&many, 0), Certainty::UNCERTAIN);
    }

    proptest! {
        #[test]
        fn any_votes_are_fused_by_eq_1(
            bits in prop::collection::vec(any::<u8>(), 1..40),
            trim in 0..3_usize,
        ) {
            let mut sorted = bits.clone();
            sorted.sort_unstable();
            let end = sorted.len().saturating_sub(trim);
            let kept = sorted.get(trim..end).unwrap_or(&[]);
            let steps = |&bits: &u8| f64::from(LogOdds::of(Certainty::from_bits(bits)).steps());
            let sum: f64 = kept.iter().map(steps).sum();
            let expected = 256.0 / (1.0 + (-sum.clamp(-127.0, 127.0) / 16.0).exp());
            let value = f64::from(fused(&bits, trim).to_bits());
            prop_assert!((value - expected).abs() <= 1.0, "{value} {expected}");
        }
    }

    #[test]
    fn a_trim_that_leaves_nothing_is_refused() {
        let shape = Geometry::new(1, 1, Millimeters::new(100), Point::ORIGIN);
        let with = |trim| TrimmedGrid::<_, _, 3>::try_new(shape, 3, trim, Latest, [0; 3]);
        assert!(with(1).is_ok());
        assert_eq!(with(2).unwrap_err().kind, GridErrorKind::Trim);
    }

    #[test]
    fn three_votes_trimmed_by_one_are_their_median() {
        // But for the rounding to a step of log-odds.
        for (votes, middle) in [([0, 200, 255], 200), ([0, 0, 255], 0), ([255, 7, 255], 255)] {
            assert!(
                fused(&votes, 1).to_bits().abs_diff(middle) <= 2,
                "{votes:?}"
            );
        }
    }

    #[test]
    fn fixed_grids_are_zeros_for_all_n_sensors() {
        type Yard = Area<4, 2, 100, 0, 0>;
        let median = MedianArray::<Yard, 3>::new(Area);
        assert_eq!((median.sensors(), median.memory_bytes()), (3, 24));
        assert_eq!((median.layers.unused, median.middle as u8), (0, 0));
        let mut trimmed = TrimmedArray::<Yard, 5>::new(Area);
        assert_eq!((trimmed.sensors(), trimmed.trim()), (5, 2));
        assert_eq!((trimmed.layers.unused, trimmed.untrimmed), (0, 0));
        let cell = trimmed.geometry().cell(3, 1).unwrap();
        for number in 1..=5 {
            let sensor = SensorId::try_new(number).unwrap();
            let certainty = Certainty::OCCUPIED;
            trimmed.add(cell, Measurement { sensor, certainty }, &mut []);
        }
        assert_eq!(trimmed.certainty(cell), Certainty::OCCUPIED);
        trimmed.clear();
        assert_eq!(trimmed.certainty(cell), Certainty::UNCERTAIN);
        // Every number of sensors and every trim is read back.
        for sensors in 1..=255 {
            for trim in 0..=most_trimmed(sensors) {
                let storage = vec![0; sensors.into()];
                let shape = Geometry::new(1, 1, Millimeters::new(1), Point::ORIGIN);
                let grid = TrimmedGrid::<_, _, 255>::try_new(shape, sensors, trim, Latest, storage);
                let grid = grid.unwrap();
                assert_eq!((grid.sensors(), grid.trim()), (sensors, trim));
            }
        }
    }

    #[test]
    fn fewer_than_2t_plus_1_votes_are_uncertain() {
        for trim in 1..4_usize {
            for votes in 0..2 * trim + 1 {
                assert_eq!(fused(&vec![255; votes], trim), Certainty::UNCERTAIN);
            }
            assert_eq!(fused(&vec![255; 2 * trim + 1], trim), Certainty::OCCUPIED);
        }
    }

    /// Of an odd number one certainty is left, which is a correct one or lies between two. Of an even
    /// number two are left, and eq. 1 makes their agreement more certain than either: the value is between
    /// eq. 1 of the lowest correct certainty twice and of the highest twice.
    #[test]
    fn no_trimmed_minority_of_liars_moves_the_value_out() {
        const ROUNDING: u8 = 2;
        every_minority(|all, correct| {
            let trim = (all.len() - 1) / 2;
            let kept = all.len() - 2 * trim;
            let agreed = |bits: u8| fused(&vec![bits; kept], 0).to_bits();
            let lowest = agreed(correct[0]) - ROUNDING;
            let highest = agreed(correct[correct.len() - 1]) + ROUNDING;
            let value = fused(all, trim).to_bits();
            assert!((lowest..=highest).contains(&value), "{all:?}: {value}");
        });
    }

    /// \[000\] §3.1: values outside are removed, values between two correct ones do no harm.
    #[test]
    fn t_liars_of_2t_plus_1_cannot_turn_agreement() {
        for trim in 1..4_usize {
            for lie in 0..=u8::MAX {
                let mut votes = vec![230; trim + 1];
                votes.extend(vec![lie; trim]);
                let certainty = fused(&votes, trim).to_bits();
                assert!(certainty >= 229, "{trim} liars with {lie}: {certainty}");
            }
        }
    }

    /// The fault hypothesis of \[001\] §2.1, exhaustively: calls `check` with the certainties of up to seven
    /// sensors and with those of the correct ones among them, lowest first, for every minority of at most
    /// ⌊(n − 1)/2⌋ liars that give 0, 120 or 255 each.
    fn every_minority(mut check: impl FnMut(&[u8], &[u8])) {
        for sensors in 1..=7_u32 {
            let minority = |liars: &u32| liars.count_ones() <= (sensors - 1) / 2;
            for liars in (0_u32..1 << sensors).filter(minority) {
                for mut lies in 0..3_u32.pow(liars.count_ones()) {
                    let (mut all, mut correct) = (Vec::new(), Vec::new());
                    for sensor in 0..sensors {
                        if liars >> sensor & 1 == 0 {
                            correct.push(100 + 7 * sensor as u8);
                            all.push(100 + 7 * sensor as u8);
                        } else {
                            all.push([0, 120, 255][lies as usize % 3]);
                            lies /= 3;
                        }
                    }
                    check(&all, &correct);
                }
            }
        }
    }
}
