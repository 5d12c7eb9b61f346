//! The fusion level: readings in, a map and the sensors' health out.

use super::{Beam, BeamModel, Cell, CertaintyGrid, Environment, Listener, Measurement};
use crate::certainty::Certainty;
use crate::health::{Health, HealthRules};
use crate::sensor::SensorId;
use crate::units::Ticks;
use core::fmt;

/// A grid with the health of the sensors that fill it.
///
/// Data flows one way (\[002\] Fig. 1): a reading is recorded, interpreted as cells, each cell is added
/// to the grid, and the sensors' status is settled. The control level looks in through
/// [`Mapper::environment`].
///
/// `H` lists one [`Health`] a sensor, in the order of their numbers: an array on a microcontroller, any
/// list on a host.
#[derive(Debug, Clone)]
pub struct Mapper<G, H> {
    grid: G,
    health: H,
    rules: HealthRules,
}

/// Writes what one sensor says into the grid.
struct GridWriter<'a, G> {
    grid: &'a mut G,
    health: &'a mut [Health],
    sensor: SensorId,
    told: u32,
}

impl<G: CertaintyGrid> Listener for GridWriter<'_, G> {
    #[inline]
    fn hear(&mut self, certainty: Certainty, cells: impl Iterator<Item = Cell>) {
        let measurement = Measurement {
            sensor: self.sensor,
            certainty,
        };
        let mut told = self.told;
        // A grid has less than 2^32 cells, and each is told once.
        let counted = cells.inspect(|_| told = told.wrapping_add(1));
        self.grid.add_all(counted, measurement, self.health);
        self.told = told;
    }
}

/// The sensor is none that the mapper was made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct UnknownSensor(pub SensorId);

impl fmt::Display for UnknownSensor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "there is no sensor {}", self.0)
    }
}

impl core::error::Error for UnknownSensor {}

impl<G: CertaintyGrid, H: AsRef<[Health]> + AsMut<[Health]>> Mapper<G, H> {
    /// Creates the fusion level from an empty grid and each sensor's first health.
    pub const fn new(grid: G, health: H, rules: HealthRules) -> Self {
        Self {
            grid,
            health,
            rules,
        }
    }

    /// Takes one reading of `sensor`, at `now`, into the map.
    ///
    /// Returns the number of cells that the reading said something about.
    ///
    /// # Errors
    ///
    /// [`UnknownSensor`] if the mapper was made for fewer sensors; nothing has changed then.
    ///
    /// # Examples
    ///
    /// ```
    /// use certainty_core::certainty::Certainty;
    /// use certainty_core::fusion::{Beam, BeamConfig, BeamModel, Geometry, Mapper, Latest, MedianGrid, Middle};
    /// use certainty_core::health::{Health, HealthRules};
    /// use certainty_core::sensor::SensorId;
    /// use certainty_core::transducer::Reading;
    /// use certainty_core::units::{BinaryAngle, Millimeters, Point, Ticks};
    ///
    /// let mm = Millimeters::new;
    /// let shape = Geometry::try_new(17, 11, mm(100), Point::from_mm(-850, 0))?;
    /// let grid = MedianGrid::<_, _, 3>::try_new(shape, 3, Middle::Higher, Latest, [0; 3 * 187])?;
    /// let mut mapper = Mapper::new(grid, [Health::default(); 3], HealthRules::DEFAULT);
    ///
    /// let gp2d02 = BeamModel::try_new(BeamConfig::narrow(mm(800)))?;
    /// let ahead = Beam {
    ///     origin: Point::ORIGIN,
    ///     bearing: BinaryAngle::QUARTER,
    ///     reading: Reading::Echo(mm(550)),
    /// };
    /// let sensor = SensorId::try_new(1).ok_or("zero")?;
    /// assert_eq!(mapper.integrate(sensor, &ahead, &gp2d02, Ticks::new(0))?, 9);
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
        let Self { grid, health, .. } = self;
        let health = health.as_mut();
        health
            .get_mut(sensor.slot())
            .ok_or(UnknownSensor(sensor))?
            .record(beam.reading, now);
        let geometry = grid.geometry();
        let mut pen = GridWriter {
            grid,
            health,
            sensor,
            told: 0,
        };
        beam.interpret(&geometry, model, &mut pen);
        let told = pen.told;
        self.settle(now);
        Ok(told)
    }

    /// Draws the conclusion about every sensor at `now`, without a reading.
    ///
    /// [`Self::integrate`] does it with every reading. A robot calls this once a round as well: when
    /// all its sensors fall silent there is no reading any more that would say so.
    pub fn settle(&mut self, now: Ticks) {
        for each in self.health.as_mut() {
            each.settle(&self.rules, now);
        }
    }

    /// Returns the sensors' health and the rules that settle it, for whoever else judges these sensors,
    /// such as `certainty_ring::Monitor` of a sonar ring.
    pub fn health_mut(&mut self) -> (&mut [Health], &HealthRules) {
        (self.health.as_mut(), &self.rules)
    }

    /// Returns what the control level sees.
    #[must_use]
    pub fn environment(&self) -> Environment<'_, G> {
        Environment::new(&self.grid, self.health.as_ref())
    }

    /// Returns the grid.
    #[must_use]
    pub const fn grid(&self) -> &G {
        &self.grid
    }
}
