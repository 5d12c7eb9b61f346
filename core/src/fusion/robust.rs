//! The robust certainty grid: `AddToGrid`, \[001\] §5 and Fig. 3, in integers.

use super::geometry::{Cell, Geometry};
use super::grid::{CertaintyGrid, GridError, GridErrorKind, Measurement, zeroed};
use super::owners::{Owners, OwnersMut, owner_bytes};
use super::shape::{ByteArray, FixedShape, Shape, fixed_cells};
use crate::certainty::Certainty;
use crate::health::{Claim, Confidence, FaultAttribution, Health, Learning, StepRule};
use crate::narrow::wrapping_u8;
use crate::sensor::SensorId;
use core::borrow::Borrow;
use core::fmt;
use fixed::types::{I2F14, U0F16};

/// The values that \[001\] Fig. 3 leaves open, before they are checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RobustConfig {
    /// `CONFIRMATIONTHRESHOLD`: a comparison above it confirms.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub confirmation: I2F14,
    /// `CONTRADICTIONTHRESHOLD`: a comparison below it contradicts.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub contradiction: I2F14,
    /// `CONTRIBUTIONTHRESHOLD`: a contribution above it makes the sensor the owner.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub contribution: I2F14,
    /// How a comparison moves the confidences of the two sensors: `inc` and `dec`.
    pub learning: Learning,
    /// The confidence that a sensor starts with; full, where nothing is known about it (\[002\] §4).
    pub start: Confidence,
}

impl RobustConfig {
    /// Chosen on the training worlds of the simulator's fault campaign.
    ///
    /// A quarter for both comparisons: each side must, on average, be half way from *uncertain* to the
    /// end. Zero for the contribution: the sensor owns the cell if its measurement is on the same side as the
    /// cell. Agreement on an occupied cell restores a quarter of the missing confidence, agreement on a free
    /// one nothing. After a contradiction between sensors of equal confidence each loses 1/48 of it.
    pub const DEFAULT: Self = Self {
        confirmation: I2F14::from_bits(1 << 12),
        contradiction: I2F14::from_bits(-(1 << 12)),
        contribution: I2F14::from_bits(0),
        learning: Learning {
            raise: U0F16::from_bits(1 << 14),
            raise_free: U0F16::from_bits(0),
            lower: U0F16::from_bits(1365),
            step_rule: StepRule::Proportional,
            attribution: FaultAttribution::Shared,
            floor: Confidence::from_bits(1 << 10),
            ceiling: Confidence::FULL,
        },
        start: Confidence::FULL,
    };

    /// \[001\] §5.1 and \[002\] §4 to the letter: all agreement counts alike, both sides fall alike, and
    /// confidence falls by larger steps than it rises.
    ///
    /// A contradiction weighs 7 confirmations: sound sensors of \[001\] Table 1 have 9 to 22
    /// confirmations a contradiction, 8 beside a random one, which has 4 to 7. So these steps detect a
    /// random sensor best, and one that is stuck far or biased hardly ever.
    pub const TO_THE_LETTER: Self = Self {
        learning: Learning {
            raise: U0F16::from_bits(1 << 7),
            raise_free: U0F16::from_bits(1 << 7),
            lower: U0F16::from_bits(7 << 7),
            step_rule: StepRule::Fixed,
            attribution: FaultAttribution::Alike,
            ..Self::DEFAULT.learning
        },
        ..Self::DEFAULT
    };
}

impl Default for RobustConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The checked [`RobustConfig`].
///
/// Possession proves that no comparison both confirms and contradicts, that confidence both rises and
/// falls (by more than agreeing on something free raises it), and that its bounds leave room.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RobustRules(RobustConfig);

/// Why a configuration is invalid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RobustConfigError {
    /// The contradiction threshold is above the confirmation threshold.
    Thresholds,
    /// The step down is not larger than the step up for agreeing on something free, or there is no
    /// step up for agreeing on something occupied.
    Steps,
    /// The floor is zero, or not below the ceiling, or the start not between them.
    Bounds,
}

impl RobustConfigError {
    const fn message(self) -> &'static str {
        match self {
            Self::Thresholds => {
                "the contradiction threshold must not exceed the confirmation threshold"
            }
            Self::Steps => {
                "confidence must rise, and fall by larger steps than agreement on free cells raises it"
            }
            Self::Bounds => {
                "the floor must be above 0 and below the ceiling, the start between them"
            }
        }
    }
}

impl fmt::Display for RobustConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message())
    }
}

impl core::error::Error for RobustConfigError {}

impl RobustRules {
    /// The rules of [`RobustConfig::DEFAULT`].
    pub const DEFAULT: Self = Self::new(RobustConfig::DEFAULT);

    /// Checks the configuration of a constant: [`Self::try_new`] that refuses at compile time.
    ///
    /// # Panics
    ///
    /// With the message of the [`RobustConfigError`]; in a constant that is a compile error.
    #[must_use]
    #[expect(clippy::panic, reason = "for constants, where it is a compile error")]
    pub const fn new(config: RobustConfig) -> Self {
        match Self::try_new(config) {
            Ok(rules) => rules,
            Err(error) => panic!("{}", error.message()),
        }
    }

    /// Checks the configuration.
    ///
    /// # Errors
    ///
    /// [`RobustConfigError`] names the first rule that is broken.
    pub const fn try_new(config: RobustConfig) -> Result<Self, RobustConfigError> {
        let learning = &config.learning;
        if config.contradiction.to_bits() > config.confirmation.to_bits() {
            Err(RobustConfigError::Thresholds)
        } else if learning.raise.to_bits() == 0
            || learning.lower.to_bits() <= learning.raise_free.to_bits()
        {
            Err(RobustConfigError::Steps)
        } else if learning.floor.to_bits() == 0
            || learning.floor.to_bits() >= learning.ceiling.to_bits()
            || config.start.to_bits() < learning.floor.to_bits()
            || config.start.to_bits() > learning.ceiling.to_bits()
        {
            Err(RobustConfigError::Bounds)
        } else {
            Ok(Self(config))
        }
    }

    /// Returns the configuration.
    #[must_use]
    pub const fn config(&self) -> &RobustConfig {
        &self.0
    }

    /// Returns the record that a sensor starts with.
    #[must_use]
    pub const fn first_health(&self) -> Health {
        Health::new(self.0.start)
    }
}

impl Default for RobustRules {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// [`RobustRules`] for a number of sensors: the settings of a [`RobustGrid`] made at run time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RobustSetup {
    rules: RobustRules,
    sensors: u8,
}

/// [`RobustRules::DEFAULT`] for `SENSORS` sensors, in no bytes: the settings of a [`RobustArray`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DefaultRules<const SENSORS: u8>;

impl<const SENSORS: u8> Borrow<RobustSetup> for DefaultRules<SENSORS> {
    #[inline]
    fn borrow(&self) -> &RobustSetup {
        const {
            &RobustSetup {
                rules: RobustRules::DEFAULT,
                sensors: SENSORS,
            }
        }
    }
}

/// A grid in which sensors check each other cell by cell, and in which each counts by its confidence.
///
/// Each cell stores the owner of its value. When another sensor measures the cell, the two confirm or
/// contradict each other, which moves both confidences, and the cell takes the mean weighted by them.
/// So a sensor that is often contradicted loses influence everywhere. Prefer it over the median grid where
/// memory is short or views overlap only partly.
///
/// Its settings are a value ([`RobustSetup`]), or in the type and in no bytes ([`DefaultRules`]).
///
/// Order: a later measurement counts more. The same order gives the same grid, bit for bit.
///
/// Memory: \[001\] §7, one byte a cell and ⌈log₂(n + 1)⌉ bits for its owner; 17 × 11 cells and three
/// sensors take 187 + 47 bytes.
#[derive(Debug, Clone)]
pub struct RobustGrid<Sh, S, O, C = RobustSetup> {
    shape: Sh,
    setup: C,
    /// Deviations from *uncertain*, so that zeroed memory is an empty grid.
    cells: S,
    owners: O,
}

/// A [`RobustGrid`] of a fixed shape for `SENSORS` sensors: arrays of zeros, [`RobustRules::DEFAULT`].
///
/// `OWNERS` is [`owner_bytes`] of the cells and sensors, which stable Rust does not compute here; another
/// number does not compile.
pub type RobustArray<Sh, const SENSORS: u8, const OWNERS: usize> =
    RobustGrid<Sh, <Sh as FixedShape>::Cells<1>, [u8; OWNERS], DefaultRules<SENSORS>>;

impl<Sh, S, O, const SENSORS: u8> RobustGrid<Sh, S, O, DefaultRules<SENSORS>>
where
    Sh: FixedShape,
    S: ByteArray,
    O: ByteArray,
{
    /// Creates a grid for sensors 1 to `SENSORS` in which every cell is uncertain and unowned, for a
    /// `static`.
    ///
    /// It does not compile where the storage has not the bytes that the shape takes.
    ///
    /// ```
    /// use certainty_core::fusion::{Area, RobustArray, owner_bytes};
    ///
    /// type Yard = Area<17, 11, 100, -850, 0>;
    /// type Map = RobustArray<Yard, 3, { owner_bytes(Yard::CELLS, 3) }>;
    /// const EMPTY: Map = Map::new(Area);
    /// assert_eq!(size_of_val(&EMPTY), 187 + 47);
    /// ```
    ///
    /// ```compile_fail
    /// use certainty_core::fusion::{Area, RobustArray};
    ///
    /// let _ = RobustArray::<Area<17, 11, 100, -850, 0>, 3, 46>::new(Area); // 47 are needed
    /// ```
    #[must_use]
    pub const fn new(shape: Sh) -> Self {
        const {
            let cells = fixed_cells::<Sh>();
            assert!(SENSORS > 0, "at least one sensor expected");
            assert!(S::LEN == cells, "a byte for each cell expected");
            assert!(
                O::LEN == owner_bytes(cells, SENSORS),
                "owner_bytes of the cells expected"
            );
        };
        Self {
            shape,
            setup: DefaultRules,
            cells: S::ZERO,
            owners: O::ZERO,
        }
    }
}

impl<Sh, S, O> RobustGrid<Sh, S, O>
where
    Sh: Shape,
    S: AsRef<[u8]> + AsMut<[u8]>,
    O: AsRef<[u8]> + AsMut<[u8]>,
{
    /// Creates a grid for sensors 1 to `sensors` in which every cell is uncertain and unowned.
    ///
    /// # Errors
    ///
    /// [`GridError`] unless there is a sensor, `storage` has a byte for each cell and `owners` has
    /// [`owner_bytes`]; both are handed back.
    ///
    /// # Examples
    ///
    /// One faulty sensor of three is outvoted:
    ///
    /// ```
    /// use certainty_core::certainty::Certainty;
    /// use certainty_core::fusion::{CertaintyGrid, Geometry, Measurement, RobustGrid, RobustRules};
    /// use certainty_core::health::Health;
    /// use certainty_core::sensor::SensorId;
    /// use certainty_core::units::{Millimeters, Point};
    ///
    /// let shape = Geometry::new(17, 11, Millimeters::new(100), Point::ORIGIN);
    /// let mut grid = RobustGrid::try_new(shape, RobustRules::DEFAULT, 3, [0; 187], [0; 47])?;
    /// assert_eq!(grid.memory_bytes(), 234);
    ///
    /// let cell = shape.cell(3, 4).ok_or("outside")?;
    /// let mut sensors = [Health::default(); 3];
    /// for _round in 0..9 {
    ///     for (number, certainty) in [(1, Certainty::OCCUPIED), (2, Certainty::FREE), (3, Certainty::OCCUPIED)] {
    ///         let sensor = SensorId::try_new(number).ok_or("zero")?;
    ///         grid.add(cell, Measurement { sensor, certainty }, &mut sensors);
    ///     }
    /// }
    /// assert!(grid.certainty(cell) > Certainty::UNCERTAIN);
    /// assert!(sensors[1].confidence() < sensors[0].confidence());
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    pub fn try_new(
        shape: Sh,
        rules: RobustRules,
        sensors: u8,
        storage: S,
        owners: O,
    ) -> Result<Self, GridError<(S, O)>> {
        if sensors == 0 {
            let kind = GridErrorKind::Sensors {
                most: u8::MAX as usize,
            };
            let storage = (storage, owners);
            return Err(GridError { kind, storage });
        }
        let cells = match zeroed(storage, shape.geometry().cells() as usize) {
            Ok(cells) => cells,
            Err(GridError { kind, storage }) => {
                let storage = (storage, owners);
                return Err(GridError { kind, storage });
            }
        };
        match zeroed(owners, owner_bytes(cells.as_ref().len(), sensors)) {
            Ok(owners) => Ok(Self {
                shape,
                setup: RobustSetup { rules, sensors },
                cells,
                owners,
            }),
            Err(GridError { kind, storage }) => Err(GridError {
                kind,
                storage: (cells, storage),
            }),
        }
    }
}

impl<Sh, S, O, C> RobustGrid<Sh, S, O, C>
where
    O: AsRef<[u8]>,
    C: Borrow<RobustSetup>,
{
    /// Returns the owner of the cell's value; `None` is *unknown* (\[001\] §5.1).
    pub fn owner(&self, cell: Cell) -> Option<SensorId> {
        let sensors = self.setup.borrow().sensors;
        Owners::new(sensors, self.owners.as_ref()).get(cell)
    }
}

impl<Sh, S, O, C> CertaintyGrid for RobustGrid<Sh, S, O, C>
where
    Sh: Shape,
    S: AsRef<[u8]> + AsMut<[u8]>,
    O: AsRef<[u8]> + AsMut<[u8]>,
    C: Borrow<RobustSetup>,
{
    fn geometry(&self) -> Geometry {
        self.shape.geometry()
    }

    fn sensors(&self) -> u8 {
        self.setup.borrow().sensors
    }

    fn first_health(&self) -> Health {
        self.setup.borrow().rules.first_health()
    }

    #[inline]
    fn add_all(
        &mut self,
        cells: impl Iterator<Item = Cell>,
        measurement: Measurement,
        sensors: &mut [Health],
    ) {
        // `AddToGrid` of \[001\] Fig. 3.
        let Measurement { sensor, certainty } = measurement;
        let setup = self.setup.borrow();
        let Some(own) = sensors.get(sensor.slot()) else {
            return;
        };
        if sensor.number() > setup.sensors {
            return;
        }
        let mut update = Update::new(&setup.rules, measurement, own);
        let stored = self.cells.as_mut();
        let mut owners = OwnersMut::new(setup.sensors, self.owners.as_mut());
        cells.for_each(|cell| {
            let Some((stored, slot)) = stored.get_mut(cell.index()).zip(owners.slot(cell)) else {
                return;
            };
            // if (cell.owner = unknown) or (cell.owner = sensor)
            match slot.owner {
                Some(owner) if owner != sensor => {
                    // An owner without a record cannot be compared.
                    if let Some(owner) = sensors.get_mut(owner.slot()) {
                        slot.set(update.compare(stored, owner));
                    }
                }
                known => {
                    *stored = certainty.deviation().cast_unsigned();
                    if known.is_none() {
                        slot.set(Some(sensor));
                    }
                }
            }
        });
        // Only owners other than this sensor were written above, so its record is unchanged in the list.
        if let Some(health) = sensors.get_mut(sensor.slot()) {
            *health = update.own;
        }
    }

    #[inline]
    fn add(&mut self, cell: Cell, measurement: Measurement, sensors: &mut [Health]) {
        self.add_all(core::iter::once(cell), measurement, sensors);
    }

    fn clear(&mut self) {
        self.cells.as_mut().fill(0);
        self.owners.as_mut().fill(0);
    }

    fn certainty(&self, cell: Cell) -> Certainty {
        let stored = self.cells.as_ref().get(cell.index()).copied();
        Certainty::from_deviation(stored.unwrap_or(0).cast_signed())
    }

    fn memory_bytes(&self) -> usize {
        self.cells
            .as_ref()
            .len()
            .saturating_add(self.owners.as_ref().len())
    }
}

/// One sensor's measurement of several cells, compared with the values of their owners.
#[derive(Debug)]
struct Update<'a> {
    /// A copy of the sensor's record, written back after the last cell.
    own: Health,
    rules: &'a RobustRules,
    /// The deviation of the measured certainty.
    measured: i32,
    sensor: SensorId,
}

impl<'a> Update<'a> {
    #[inline]
    fn new(rules: &'a RobustRules, measurement: Measurement, own: &Health) -> Self {
        Self {
            own: *own,
            rules,
            measured: measurement.certainty.deviation().into(),
            sensor: measurement.sensor,
        }
    }

    /// Compares the measurement with a cell that `owner` wrote, `stored` as its deviation; returns the new owner.
    ///
    /// \[001\] Fig. 3 from the comparison on, in the figure's order. Not generic, so that an image with
    /// several grids contains it once.
    fn compare(&mut self, stored: &mut u8, owner: &mut Health) -> Option<SensorId> {
        let (RobustRules(config), measured) = (self.rules, self.measured);
        let own = &mut self.own;
        let occ = i32::from(stored.cast_signed());
        let comparison = agreement(occ, measured);
        // Most cells: the mean of two equal values is that value at any weights, without a division.
        let mut contribution = comparison;
        if occ != measured {
            // The confidences are still the old ones here.
            let fused = weighted_mean(occ, owner.confidence(), measured, own.confidence());
            *stored = wrapping_u8(fused.cast_unsigned());
            contribution = agreement(fused, measured);
        }
        if comparison > i32::from(config.confirmation.to_bits()) {
            let claim = Claim::of_deviation(measured);
            Health::confirm([owner, own], claim, &config.learning);
        } else if comparison < i32::from(config.contradiction.to_bits()) {
            let claims = [Claim::of_deviation(occ), Claim::of_deviation(measured)];
            Health::contradict([owner, own], claims, &config.learning);
        }
        (contribution > i32::from(config.contribution.to_bits())).then_some(self.sensor)
    }
}

/// The agreement of a cell and a measurement: `comparison` and `contribution` of \[001\] Fig. 3.
///
/// Formula: 4 · (occ − 0.5) · (measurement − 0.5). With deviations in 1/256 the product is the result
/// in 1/2^14, exactly.
///
/// Range: −0.992 (free against occupied) to 1 (free and free).
#[inline]
const fn agreement(occ: i32, measurement: i32) -> i32 {
    occ.wrapping_mul(measurement)
}

/// The new value of a cell: the mean of old value and measurement, each weighted by its distance from
/// *uncertain* and by its sensor's confidence. All three are deviations.
///
/// Formula (\[001\] Fig. 3): (occ · weight1 + measurement · weight2) / (weight1 + weight2), with
/// weight = |value − 0.5| · conf; the plain mean where both weights are equal. Rounds to the nearest
/// step of 1/256, ties up.
///
/// Range: a weight is at most 128 · 65535, a numerator with its rounding at most 255.5 · 2 of them,
/// 4 286 513 280, which 32 bits hold.
#[inline]
fn weighted_mean(occ: i32, owner: Confidence, measurement: i32, sensor: Confidence) -> i32 {
    let weight = |value: i32, confidence: Confidence| {
        value
            .unsigned_abs()
            .wrapping_mul(confidence.to_bits().into())
    };
    let (weight1, weight2) = (weight(occ, owner), weight(measurement, sensor));
    // As certainties, 0 to 255, so that nothing is negative.
    let certainty = |deviation: i32| deviation.wrapping_add(128).cast_unsigned();
    let (occ, measurement) = (certainty(occ), certainty(measurement));
    // Both may be zero, which must not be divided by.
    let mean = if weight1 == weight2 {
        occ.wrapping_add(measurement).wrapping_add(1) >> 1
    } else {
        let total = weight1.wrapping_add(weight2);
        let sum = occ
            .wrapping_mul(weight1)
            .wrapping_add(measurement.wrapping_mul(weight2))
            .wrapping_add(total >> 1);
        // Different weights are not both zero.
        sum.checked_div(total).unwrap_or(occ)
    };
    mean.cast_signed().wrapping_sub(128)
}

#[cfg(test)]
mod tests {
    use super::super::picture::draw;
    use super::super::shape::Area;
    use super::*;
    use crate::units::{Millimeters, Point};
    use proptest::prelude::*;

    type Small = RobustGrid<Geometry, Vec<u8>, Vec<u8>>;

    fn grid(columns: u16, rows: u16, sensors: u8) -> Small {
        with_rules(columns, rows, sensors, RobustRules::DEFAULT)
    }

    fn with_rules(columns: u16, rows: u16, sensors: u8, rules: RobustRules) -> Small {
        let shape = Geometry::new(columns, rows, Millimeters::new(100), Point::ORIGIN);
        let cells = shape.cells() as usize;
        let owners = vec![0xFF; owner_bytes(cells, sensors)];
        RobustGrid::try_new(shape, rules, sensors, vec![0xFF; cells], owners).unwrap()
    }

    fn measured(number: u8, bits: u8) -> Measurement {
        Measurement {
            sensor: SensorId::try_new(number).unwrap(),
            certainty: Certainty::from_bits(bits),
        }
    }

    /// The mean of \[001\] Fig. 3 in real numbers, rounded once, up, to a step of 1/256.
    fn naive_mean(occ: f64, conf1: f64, measurement: f64, conf2: f64) -> f64 {
        let weight1 = (occ - 0.5).abs() * conf1;
        let weight2 = (measurement - 0.5).abs() * conf2;
        let exact = if weight1 == weight2 {
            f64::midpoint(occ, measurement)
        } else {
            (occ * weight1 + measurement * weight2) / (weight1 + weight2)
        };
        (exact * 256.0 + 0.5).floor() / 256.0
    }

    /// \[001\] Fig. 3 in real numbers, with the integers' rounding of cell.occ and nothing else.
    ///
    /// `conf` holds the confidences of sensors 1 to 3 in [their occupied cells, their free cells].
    #[derive(Debug)]
    struct Naive {
        occ: f64,
        owner: usize,
        conf: [[f64; 2]; 4],
        rules: RobustRules,
    }

    impl Naive {
        /// The state of a [`RobustGrid`], so that each step is compared by itself.
        fn like(grid: &Small, cell: Cell, sensors: &[Health; 3]) -> Self {
            let mut conf = [[0.0; 2]; 4];
            for (own, health) in conf[1..].iter_mut().zip(sensors) {
                *own =
                    [Claim::Occupied, Claim::Free].map(|claim| real(health.confidence_in(claim)));
            }
            Self {
                occ: f64::from(grid.certainty(cell).to_bits()) / 256.0,
                owner: grid.owner(cell).map_or(0, |owner| owner.number().into()),
                conf,
                rules: grid.setup.rules,
            }
        }

        fn add(&mut self, sensor: usize, measurement: f64) {
            if self.owner == 0 || self.owner == sensor {
                self.occ = measurement;
                self.owner = sensor;
                return;
            }
            let config = *self.rules.config();
            let comparison = 4.0 * (self.occ - 0.5) * (measurement - 0.5);
            let least = |id: usize| self.conf[id][0].min(self.conf[id][1]);
            let claims = [
                (self.owner, usize::from(self.occ <= 0.5)),
                (sensor, usize::from(measurement <= 0.5)),
            ];
            self.occ = naive_mean(self.occ, least(self.owner), measurement, least(sensor));
            if comparison > config.confirmation.to_num::<f64>() {
                for (id, claim) in claims {
                    self.agree(id, claim);
                }
            }
            if comparison < config.contradiction.to_num::<f64>() {
                let [a, b] = claims.map(|(id, claim)| self.conf[id][claim]);
                for ((id, claim), (own, other)) in claims.into_iter().zip([(a, b), (b, a)]) {
                    self.disagree(id, claim, own, other);
                }
            }
            let contribution = 4.0 * (self.occ - 0.5) * (measurement - 0.5);
            let contributes = contribution > config.contribution.to_num::<f64>();
            self.owner = if contributes { sensor } else { 0 };
        }

        fn agree(&mut self, id: usize, claim: usize) {
            let learning = self.rules.config().learning;
            let step: f64 = [learning.raise, learning.raise_free][claim].to_num();
            let ceiling = real(learning.ceiling);
            for (of, own) in self.conf[id].iter_mut().enumerate() {
                if learning.attribution == FaultAttribution::Alike || claim == 0 || of == claim {
                    let whole = match learning.step_rule {
                        StepRule::Fixed => 1.0,
                        StepRule::Proportional => ceiling - *own,
                    };
                    *own = (*own + step * whole).min(ceiling);
                }
            }
        }

        fn disagree(&mut self, id: usize, claim: usize, own: f64, other: f64) {
            let learning = self.rules.config().learning;
            let floor = real(learning.floor);
            // Bayes' rule: the probability that this one is wrong if one of the two is, times two.
            let doubt = |confidence: f64| real(Confidence::FULL) - confidence + floor;
            let wrong = [doubt(own) * other, doubt(other) * own];
            let share = match learning.attribution {
                FaultAttribution::Alike => 1.0,
                FaultAttribution::Shared => 2.0 * wrong[0] / (wrong[0] + wrong[1]),
            };
            let step = learning.lower.to_num::<f64>() * share;
            for (of, own) in self.conf[id].iter_mut().enumerate() {
                if learning.attribution == FaultAttribution::Alike || of == claim {
                    let whole = match learning.step_rule {
                        StepRule::Fixed => 1.0,
                        StepRule::Proportional => *own,
                    };
                    *own = (*own - step * whole).max(floor);
                }
            }
        }
    }

    fn real(confidence: Confidence) -> f64 {
        confidence.value().to_num()
    }

    #[test]
    fn an_unowned_or_own_cell_takes_the_measurement_as_is() {
        let mut grid = grid(1, 1, 3);
        let cell = grid.geometry().cell(0, 0).unwrap();
        let mut sensors = [Health::default(); 3];
        for bits in [200, 10, 128, 255] {
            grid.add(cell, measured(2, bits), &mut sensors);
            assert_eq!(grid.certainty(cell).to_bits(), bits);
            assert_eq!(grid.owner(cell), SensorId::try_new(2));
        }
        assert_eq!(sensors, [Health::default(); 3], "nothing was compared");
    }

    #[test]
    fn a_contradiction_lowers_both_confidences() {
        let mut grid = grid(1, 1, 2);
        let cell = grid.geometry().cell(0, 0).unwrap();
        let mut sensors = [Health::default(); 2];
        grid.add(cell, measured(1, 255), &mut sensors);
        grid.add(cell, measured(2, 0), &mut sensors);
        // (255 · 127 + 0 · 128) / 255 = 127: nearer to free, so sensor 2 contributes.
        assert_eq!(grid.certainty(cell).to_bits(), 127);
        assert_eq!(grid.owner(cell), SensorId::try_new(2));
        // Each by 1/48, for its own claim and not for the other.
        for (health, claim) in sensors.iter().zip([Claim::Occupied, Claim::Free]) {
            let lowered = health.confidence_in(claim).to_bits();
            assert!(lowered.abs_diff(65_535 - 1365) <= 2, "{lowered}");
            assert_eq!(health.confidence().to_bits(), lowered);
        }
        assert_eq!(sensors[0].confidence_in(Claim::Free), Confidence::FULL);
        assert_eq!(sensors[1].confidence_in(Claim::Occupied), Confidence::FULL);
        assert!(sensors.iter().all(|health| health.contradictions() == 1));
    }

    #[test]
    fn uncertain_keeps_the_value_and_removes_the_owner() {
        let mut grid = grid(1, 1, 2);
        let cell = grid.geometry().cell(0, 0).unwrap();
        let mut sensors = [Health::default(); 2];
        grid.add(cell, measured(1, 0), &mut sensors);
        grid.add(cell, measured(2, 128), &mut sensors);
        assert_eq!(grid.certainty(cell), Certainty::FREE);
        assert_eq!(grid.owner(cell), None);
        // So the next measurement is taken as is: *uncertain* replaces what a blind sensor freed.
        grid.add(cell, measured(2, 128), &mut sensors);
        assert_eq!(grid.certainty(cell), Certainty::UNCERTAIN);
    }

    #[test]
    fn the_last_sensor_of_a_cell_owns_it() {
        let mut grid = grid(4, 2, 3);
        let mut sensors = [Health::default(); 3];
        for (column, row, number) in [(0, 0, 1), (1, 0, 2), (2, 0, 3), (1, 1, 1), (1, 0, 3)] {
            let cell = grid.geometry().cell(column, row).unwrap();
            grid.add(cell, measured(number, 255), &mut sensors);
        }
        let drawn = draw(&grid.geometry(), |cell| match grid.owner(cell) {
            Some(owner) => (b'0' + owner.number()) as char,
            None => '-',
        });
        assert_eq!(drawn, ["-1--", "133-"]);
    }

    #[test]
    fn a_sensor_without_a_record_or_room_is_not_added() {
        for (number, room, records) in [(2, 3, 1), (3, 2, 3)] {
            let mut grid = grid(1, 1, room);
            let cell = grid.geometry().cell(0, 0).unwrap();
            let mut sensors = vec![Health::default(); records];
            grid.add(cell, measured(number, 255), &mut sensors);
            assert_eq!(grid.certainty(cell), Certainty::UNCERTAIN);
            assert_eq!(grid.owner(cell), None);
        }
    }

    #[test]
    fn storage_of_another_size_is_handed_back() {
        let shape = Geometry::new(2, 2, Millimeters::new(100), Point::ORIGIN);
        let refused = |cells: usize, owners: usize| {
            let (cells, owners) = (vec![1; cells], vec![2; owners]);
            RobustGrid::try_new(shape, RobustRules::DEFAULT, 3, cells, owners).unwrap_err()
        };
        let cells = refused(3, 1);
        assert_eq!(cells.kind, GridErrorKind::Storage { needed: 4 });
        assert_eq!(cells.storage, (vec![1; 3], vec![2; 1]));
        let owners = refused(4, 2);
        assert_eq!(owners.kind, GridErrorKind::Storage { needed: 1 });
        assert_eq!(owners.storage.1, vec![2; 2]);
    }

    proptest! {
        #[test]
        fn any_run_of_measurements_follows_the_figure(
            to_the_letter in any::<bool>(),
            run in prop::collection::vec((1..=3_u8, 0..=255_u8), 0..300),
        ) {
            const LETTER: RobustRules = RobustRules::new(RobustConfig::TO_THE_LETTER);
            let rules = if to_the_letter { LETTER } else { RobustRules::DEFAULT };
            // Fixed steps are exact; proportional ones are rounded down, and shares to 2^-12.
            let error = if to_the_letter { 0.0 } else { 3.0 / 65536.0 };
            let mut grid = with_rules(1, 1, 3, rules);
            let cell = grid.geometry().cell(0, 0).unwrap();
            let mut sensors = [Health::default(); 3];
            for (number, bits) in run {
                let mut naive = Naive::like(&grid, cell, &sensors);
                grid.add(cell, measured(number, bits), &mut sensors);
                naive.add(number.into(), f64::from(bits) / 256.0);
                let after = Naive::like(&grid, cell, &sensors);
                prop_assert_eq!(after.occ, naive.occ);
                prop_assert_eq!(after.owner, naive.owner);
                for (own, expected) in after.conf.as_flattened().iter().zip(naive.conf.as_flattened()) {
                    prop_assert!((own - expected).abs() <= error, "{} {}", own, expected);
                }
            }
        }
    }

    #[test]
    fn the_mean_is_the_figures_for_all_values() {
        let all = || (0..=u8::MAX).flat_map(|a| (0..=u8::MAX).map(move |b| (a, b)));
        let deviation = |bits: u8| i32::from(bits) - 128;
        let confidences = [0, 1, 2, 1 << 10, 20_000, 1 << 15, 65_534, u16::MAX];
        for (conf1, conf2) in confidences
            .iter()
            .flat_map(|&a| confidences.map(|b| (a, b)))
        {
            let [owner, sensor] = [conf1, conf2].map(Confidence::from_bits);
            for (occ, measured) in all() {
                let mean = weighted_mean(deviation(occ), owner, deviation(measured), sensor);
                let [a, b] = [occ, measured].map(|bits| f64::from(bits) / 256.0);
                let naive = naive_mean(a, conf1.into(), b, conf2.into()) * 256.0 - 128.0;
                assert_eq!(
                    f64::from(mean),
                    naive,
                    "{occ} at {conf1}, {measured} at {conf2}"
                );
            }
        }
    }

    #[test]
    fn agreement_is_the_figures_for_all_values() {
        for (a, b) in (0..=u8::MAX).flat_map(|a| (0..=u8::MAX).map(move |b| (a, b))) {
            let exact = 4.0 * (f64::from(a) / 256.0 - 0.5) * (f64::from(b) / 256.0 - 0.5);
            let agreement = agreement(i32::from(a) - 128, i32::from(b) - 128);
            assert_eq!(f64::from(agreement) / 16_384.0, exact);
        }
    }

    #[test]
    fn a_fixed_grid_is_234_bytes_of_zeros_and_fuses_alike() {
        type Yard = Area<17, 11, 100, -850, 0>;
        let mut fixed = RobustArray::<Yard, 3, 47>::new(Area);
        assert_eq!(size_of_val(&fixed), 187 + 47);
        assert_eq!((fixed.sensors(), fixed.memory_bytes()), (3, 234));
        let mut flexible = grid(17, 11, 3);
        let mut sensors = [[Health::default(); 3]; 2];
        for (index, number) in (0..187_u32).zip([1, 2, 3, 3].into_iter().cycle()) {
            for cell in [Cell::from_index(index), Cell::from_index(index / 2)] {
                let measured = measured(number, (index * 37) as u8);
                fixed.add(cell, measured, &mut sensors[0]);
                flexible.add(cell, measured, &mut sensors[1]);
            }
        }
        assert_eq!(fixed.cells.as_ref(), flexible.cells.as_slice());
        assert_eq!(fixed.owners.as_slice(), flexible.owners.as_slice());
        assert_eq!(sensors[0], sensors[1]);
        fixed.clear();
        assert_eq!(fixed.cells.as_ref(), [0; 187]);
        assert_eq!(fixed.owners, [0; 47]);
    }

    #[test]
    fn the_shipped_configurations_pass_their_own_check() {
        let checked = RobustRules::try_new(RobustConfig::DEFAULT);
        assert_eq!(checked, Ok(RobustRules::DEFAULT));
        assert!(RobustRules::try_new(RobustConfig::TO_THE_LETTER).is_ok());
    }

    #[test]
    fn invalid_rules_are_refused() {
        let refused = |change: fn(&mut RobustConfig)| {
            let mut config = RobustConfig::TO_THE_LETTER;
            change(&mut config);
            RobustRules::try_new(config).unwrap_err()
        };
        let crossed = refused(|config| config.contradiction = I2F14::ONE);
        assert_eq!(crossed, RobustConfigError::Thresholds);
        let no_net_fall = refused(|config| config.learning.lower = config.learning.raise_free);
        let no_rise = refused(|config| config.learning.raise = U0F16::ZERO);
        assert_eq!([no_net_fall, no_rise], [RobustConfigError::Steps; 2]);
        let below = refused(|config| config.start = Confidence::NONE);
        let no_room = refused(|config| config.learning.ceiling = config.learning.floor);
        let no_floor = refused(|config| config.learning.floor = Confidence::NONE);
        assert_eq!([below, no_room, no_floor], [RobustConfigError::Bounds; 3]);
    }
}
