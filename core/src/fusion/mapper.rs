//! The fusion level: readings in, a map and the sensors' health out.

use super::beam::{Beam, BeamModel, CellSink};
use super::geometry::{Cell, Geometry};
use super::grid::{CertaintyGrid, Measurement};
use crate::certainty::Certainty;
use crate::health::{Health, HealthRules, Status};
use crate::sensor::SensorId;
use crate::transducer::Reading;
use crate::units::{Point, Ticks};
use core::fmt;

/// A grid with the health of the sensors that fill it.
///
/// Data flows one way (\[002\] Fig. 1): a reading is recorded in the sensor's health and interpreted as
/// cells, each cell is added to the grid, and every sensor's status is settled. The control level reads
/// the result through [`Mapper::environment`].
///
/// `H` holds the sensors' records in the order of their numbers: an array on a microcontroller, any list on
/// a host. The mapper has as many sensors as the grid has room for and `H` has records, the lesser of
/// the two.
#[derive(Debug, Clone)]
pub struct Mapper<G, H> {
    grid: G,
    records: H,
    rules: HealthRules,
}

/// Writes one sensor's certainties into the grid and counts the cells.
struct GridWriter<'a, G> {
    grid: &'a mut G,
    records: &'a mut [Health],
    sensor: SensorId,
    written: u32,
}

impl<G: CertaintyGrid> CellSink for GridWriter<'_, G> {
    #[inline]
    fn write(&mut self, certainty: Certainty, cells: impl Iterator<Item = Cell>) {
        let measurement = Measurement {
            sensor: self.sensor,
            certainty,
        };
        let mut written = self.written;
        // A grid has less than 2^32 cells, and each is written once.
        let counted = cells.inspect(|_| written = written.wrapping_add(1));
        self.grid.add_all(counted, measurement, self.records);
        self.written = written;
    }
}

/// The mapper has no sensor of this number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct UnknownSensor(pub SensorId);

impl fmt::Display for UnknownSensor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "unknown sensor {}: the grid has no room for it or it has no record",
            self.0
        )
    }
}

impl core::error::Error for UnknownSensor {}

impl<G: CertaintyGrid, const N: usize> Mapper<G, [Health; N]> {
    /// Creates the fusion level from an empty grid, with room for `N` sensors' records.
    ///
    /// The number of sensors and their first record come from the grid. Records beyond its sensors are unused.
    ///
    /// ```
    /// use certainty_core::fusion::{Area, Mapper, MedianArray};
    /// use certainty_core::health::{Health, HealthRules};
    ///
    /// type Yard = Area<17, 11, 100, -850, 0>;
    /// let grid = MedianArray::<Yard, 3>::new(Area);
    /// let mapper: Mapper<_, [Health; 3]> = Mapper::new(grid, HealthRules::DEFAULT);
    /// assert_eq!(mapper.environment().sensors().count(), 3);
    /// ```
    pub fn new(grid: G, rules: HealthRules) -> Self {
        let records = [grid.first_health(); N];
        Self::with_records(grid, records, rules)
    }
}

impl<G, H> Mapper<G, H> {
    /// Creates the fusion level from a grid and records that it goes on with: a list on a host, or records
    /// that were stored.
    pub const fn with_records(grid: G, records: H, rules: HealthRules) -> Self {
        Self {
            grid,
            records,
            rules,
        }
    }

    /// Returns the grid.
    #[must_use]
    pub const fn grid(&self) -> &G {
        &self.grid
    }

    /// Returns the grid, to be written beside the readings.
    pub const fn grid_mut(&mut self) -> &mut G {
        &mut self.grid
    }

    /// Returns the grid and the records.
    #[must_use]
    pub fn into_parts(self) -> (G, H) {
        (self.grid, self.records)
    }
}

impl<G: CertaintyGrid, H: AsRef<[Health]> + AsMut<[Health]>> Mapper<G, H> {
    /// Adds one reading of `sensor`, made at `now`, to its record and to the map.
    ///
    /// Returns the number of cells written.
    ///
    /// # Errors
    ///
    /// [`UnknownSensor`] if the mapper has no such sensor; nothing has changed then.
    ///
    /// # Examples
    ///
    /// ```
    /// use certainty_core::certainty::Certainty;
    /// use certainty_core::fusion::{Area, Beam, BeamConfig, BeamModel, Mapper, MedianArray};
    /// use certainty_core::health::{Health, HealthRules};
    /// use certainty_core::sensor::SensorId;
    /// use certainty_core::transducer::Reading;
    /// use certainty_core::units::{BinaryAngle, Millimeters, Point, Ticks};
    ///
    /// const GP2D02: BeamModel = BeamModel::new(BeamConfig::narrow(Millimeters::new(800)));
    ///
    /// let grid = MedianArray::<Area<17, 11, 100, -850, 0>, 3>::new(Area);
    /// let mut mapper: Mapper<_, [Health; 3]> = Mapper::new(grid, HealthRules::DEFAULT);
    /// let ahead = Beam {
    ///     origin: Point::ORIGIN,
    ///     bearing: BinaryAngle::QUARTER,
    ///     reading: Reading::Echo(Millimeters::new(550)),
    /// };
    /// let sensor = SensorId::new(1);
    /// assert_eq!(mapper.integrate(sensor, &ahead, &GP2D02, Ticks::new(0))?, 9);
    ///
    /// let map = mapper.environment();
    /// assert_eq!(map.certainty_at(Point::from_mm(0, 250)), Certainty::FREE);
    /// assert_eq!(map.certainty_at(Point::from_mm(0, 550)), Certainty::OCCUPIED);
    /// assert_eq!(map.certainty_at(Point::from_mm(0, 650)), Certainty::UNCERTAIN);
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    pub fn integrate(
        &mut self,
        sensor: SensorId,
        beam: &Beam,
        model: &BeamModel,
        now: Ticks,
    ) -> Result<u32, UnknownSensor> {
        self.known(sensor)?.record(beam.reading, now);
        let geometry = self.grid.geometry();
        let mut writer = GridWriter {
            grid: &mut self.grid,
            records: self.records.as_mut(),
            sensor,
            written: 0,
        };
        beam.interpret(&geometry, model, &mut writer);
        let written = writer.written;
        self.settle(now);
        Ok(written)
    }

    /// Adds one reading of `sensor`, made at `now`, to its record and not to the map.
    ///
    /// For a reading that must not be drawn, such as that of a sensor diagnosed as faulty: its health still
    /// counts it as received.
    ///
    /// # Errors
    ///
    /// [`UnknownSensor`] if the mapper has no such sensor; nothing has changed then.
    pub fn record(
        &mut self,
        sensor: SensorId,
        reading: Reading,
        now: Ticks,
    ) -> Result<(), UnknownSensor> {
        self.known(sensor)?.record(reading, now);
        self.settle(now);
        Ok(())
    }

    /// Settles every sensor's status at `now`, without a reading.
    ///
    /// [`Self::integrate`] does it with every reading. Call it once a round as well: when all sensors are
    /// silent, no reading comes that would do it.
    pub fn settle(&mut self, now: Ticks) {
        let sensors = self.sensors();
        for each in self.records.as_mut().iter_mut().take(sensors) {
            each.settle(&self.rules, now);
        }
    }

    /// Empties the map; the sensors' records stay.
    pub fn clear(&mut self) {
        self.grid.clear();
    }

    /// Returns the sensors' health, in the order of their numbers.
    #[must_use]
    pub fn health(&self) -> &[Health] {
        let records = self.records.as_ref().get(..self.sensors());
        records.unwrap_or_default()
    }

    /// Returns the sensors' health and the rules that settle it, for another diagnosis of the same sensors,
    /// such as `certainty_ring::Monitor` of a sonar ring.
    pub fn health_mut(&mut self) -> (&mut [Health], &HealthRules) {
        let sensors = self.sensors();
        let records = self.records.as_mut().get_mut(..sensors);
        (records.unwrap_or_default(), &self.rules)
    }

    /// Returns the view of the control level.
    #[must_use]
    pub fn environment(&self) -> Environment<'_, G> {
        Environment::new(&self.grid, self.health())
    }

    /// The number of sensors that have room in the grid and a record.
    fn sensors(&self) -> usize {
        self.records.as_ref().len().min(self.grid.sensors().into())
    }

    fn known(&mut self, sensor: SensorId) -> Result<&mut Health, UnknownSensor> {
        let record = self.health_mut().0.get_mut(sensor.slot());
        record.ok_or(UnknownSensor(sensor))
    }
}

/// A read-only view of the map and of the sensors' health.
///
/// The interface between the fusion level and the control level (\[000\] §2). It shows no sensor's
/// readings, mounting or kind: a sensor that is added is one more entry of [`Self::sensors`], which a control
/// level that weighs the sensors' health has to expect.
#[derive(Debug)]
pub struct Environment<'a, G> {
    grid: &'a G,
    health: &'a [Health],
}

impl<'a, G: CertaintyGrid> Environment<'a, G> {
    /// Creates the view of `grid` and its sensors' `health`, in the order of their numbers.
    pub const fn new(grid: &'a G, health: &'a [Health]) -> Self {
        Self { grid, health }
    }

    /// Returns where the map lies and how it is divided.
    #[must_use]
    pub fn geometry(&self) -> Geometry {
        self.grid.geometry()
    }

    /// Returns the certainty that `cell` is occupied.
    #[must_use]
    pub fn certainty(&self, cell: Cell) -> Certainty {
        self.grid.certainty(cell)
    }

    /// Returns the certainty that `place` is occupied; *uncertain* outside the map.
    #[must_use]
    pub fn certainty_at(&self, place: Point) -> Certainty {
        let cell = self.geometry().cell_at(place);
        cell.map_or(Certainty::UNCERTAIN, |cell| self.certainty(cell))
    }

    /// Returns every sensor with its health.
    pub fn sensors(&self) -> impl Iterator<Item = (SensorId, &'a Health)> + use<'a, G> {
        let numbered = self.health.iter().zip(1..=u8::MAX);
        numbered.filter_map(|(health, number)| SensorId::try_new(number).map(|id| (id, health)))
    }

    /// Returns the number of sensors with this status.
    #[must_use]
    pub fn count(&self, status: Status) -> u8 {
        let matching = self
            .sensors()
            .filter(|(_, health)| health.status() == status);
        // Not `Iterator::count`, whose sum can overflow and so panic.
        matching.fold(0, |count: u8, _| count.saturating_add(1))
    }
}

// Not derived: that would require that the grid is `Copy` too.
impl<G> Clone for Environment<'_, G> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<G> Copy for Environment<'_, G> {}

#[cfg(test)]
mod tests {
    use super::super::bayes::{BayesGrid, Strength};
    use super::super::beam::BeamConfig;
    use super::super::layers::{Latest, MedianGrid, Middle};
    use super::super::robust::{RobustGrid, RobustRules};
    use super::*;
    use crate::transducer::Missing;
    use crate::units::{BinaryAngle, Millimeters};

    const fn mm(mm: u32) -> Millimeters {
        Millimeters::new(mm)
    }

    const NARROW: BeamModel = BeamModel::new(BeamConfig::narrow(mm(1100)));
    const SONAR: BeamModel = BeamModel::new(BeamConfig::cone(
        mm(1100),
        BinaryAngle::from_millidegrees(15_000),
    ));

    fn up(degrees: i32, reading: Reading) -> Beam {
        Beam {
            origin: Point::ORIGIN,
            bearing: BinaryAngle::from_millidegrees(90_000 - degrees * 1000),
            reading,
        }
    }

    fn yard() -> Geometry {
        Geometry::new(21, 12, mm(100), Point::from_mm(-1050, 0))
    }

    fn sensors() -> [SensorId; 3] {
        [1, 2, 3].map(|number| SensorId::try_new(number).unwrap())
    }

    /// The grid took no cell of such a sensor, and `integrate` returned `Ok(9)`.
    #[test]
    fn a_sensor_without_room_in_the_grid_is_unknown() {
        let grid =
            MedianGrid::<_, _, 3>::try_new(yard(), 2, Middle::Higher, Latest, [0; 504]).unwrap();
        let mut mapper: Mapper<_, [Health; 3]> = Mapper::new(grid, HealthRules::DEFAULT);
        let (echo, now) = (up(0, Reading::Echo(mm(500))), Ticks::new(0));
        let [first, second, third] = sensors();
        assert!(mapper.integrate(first, &echo, &NARROW, now).is_ok());
        assert!(mapper.integrate(second, &echo, &NARROW, now).is_ok());
        let unknown = mapper.integrate(third, &echo, &NARROW, now);
        assert_eq!(unknown, Err(UnknownSensor(third)));
        assert_eq!(mapper.environment().sensors().count(), 2);
        assert_eq!(mapper.health_mut().0.len(), 2);
    }

    #[test]
    fn a_sensor_without_a_record_is_unknown() {
        let grid = RobustGrid::try_new(yard(), RobustRules::DEFAULT, 3, [0; 252], [0; 63]).unwrap();
        let mut mapper: Mapper<_, [Health; 2]> = Mapper::new(grid, HealthRules::DEFAULT);
        let [.., third] = sensors();
        let reading = Reading::NoObject;
        let unknown = mapper.integrate(third, &up(0, reading), &NARROW, Ticks::new(0));
        assert_eq!(unknown, Err(UnknownSensor(third)));
        let unknown = mapper.record(third, reading, Ticks::new(0));
        assert_eq!(unknown, Err(UnknownSensor(third)));
    }

    #[test]
    fn a_recorded_reading_is_counted_and_not_drawn() {
        let grid = BayesGrid::try_new(yard(), Strength::MEASUREMENT, [0; 252]).unwrap();
        let mut mapper: Mapper<_, [Health; 1]> = Mapper::new(grid, HealthRules::DEFAULT);
        let [sensor, ..] = sensors();
        let now = Ticks::new(7);
        mapper.record(sensor, Reading::Echo(mm(500)), now).unwrap();
        let missing = Reading::Missing(Missing::Timeout);
        mapper.record(sensor, missing, now).unwrap();
        let (grid, [health]) = mapper.into_parts();
        assert_eq!((health.readings(), health.missing()), (1, 1));
        let all = yard()
            .iter()
            .all(|cell| grid.certainty(cell) == Certainty::UNCERTAIN);
        assert!(all);
    }

    #[test]
    fn a_cleared_map_is_uncertain_and_keeps_the_records() {
        let mut grid = BayesGrid::try_new(yard(), Strength::MEASUREMENT, [0; 252]).unwrap();
        let mut mapper: Mapper<_, [Health; 1]> = Mapper::new(&mut grid, HealthRules::DEFAULT);
        let [sensor, ..] = sensors();
        let now = Ticks::new(0);
        let echo = up(0, Reading::Echo(mm(500)));
        mapper.integrate(sensor, &echo, &NARROW, now).unwrap();
        let place = Point::from_mm(0, 500);
        assert!(mapper.environment().certainty_at(place) > Certainty::UNCERTAIN);
        mapper.clear();
        assert_eq!(
            mapper.environment().certainty_at(place),
            Certainty::UNCERTAIN
        );
        let (_, [health]) = mapper.into_parts();
        assert_eq!(health.readings(), 1);
    }

    /// A defect of `navigation_layers`: neighbouring cones erased each other's obstacles.
    #[test]
    fn neighbouring_cones_erase_no_obstacle() {
        // Two sonars 15° apart on one ring. The first sees a post at 700 mm on its axis, which is at the
        // edge of the second's cone; the second, a hundred times, sees nothing. For several offsets of the
        // cells' borders.
        for shift in (0..100).step_by(7) {
            let corner = Point::from_mm(-1050 + shift, shift - 100);
            let yard = Geometry::new(21, 12, mm(100), corner);
            let seen = up(-7, Reading::Echo(mm(700)));
            let unseen = up(8, Reading::NoObject);
            let post = yard.cell_at(seen.origin.ahead(seen.bearing.direction(), mm(700)));
            let post = post.unwrap();
            let bayes = BayesGrid::try_new(yard, Strength::MEASUREMENT, [0; 252]).unwrap();
            let robust = RobustGrid::try_new(yard, RobustRules::DEFAULT, 2, [0; 252], [0; 63]);
            let median =
                MedianGrid::<_, _, 2>::try_new(yard, 2, Middle::Higher, Latest, [0; 504]).unwrap();
            let outcomes = [
                erased(bayes, &seen, &unseen, post),
                erased(robust.unwrap(), &seen, &unseen, post),
                erased(median, &seen, &unseen, post),
            ];
            for (grid, certainty) in ["bayes", "robust", "median"].iter().zip(outcomes) {
                assert!(
                    certainty.to_bits() > 200,
                    "{grid}, shift {shift}: {certainty}"
                );
            }
        }
    }

    fn erased(grid: impl CertaintyGrid, seen: &Beam, unseen: &Beam, post: Cell) -> Certainty {
        let mut mapper: Mapper<_, [Health; 2]> = Mapper::new(grid, HealthRules::DEFAULT);
        let [first, second, _] = sensors();
        let now = Ticks::new(0);
        mapper.integrate(first, seen, &SONAR, now).unwrap();
        for _ in 0..100 {
            mapper.integrate(second, unseen, &SONAR, now).unwrap();
        }
        mapper.environment().certainty(post)
    }
}
