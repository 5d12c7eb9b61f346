//! The core's mapper for any method and size, with its cells on the heap.

use super::literal::LiteralGrid;
use super::rules::{FusionRules, Landmarks, Method, Own};
use certainty_control::{CastRay, RayHit, RobotMap};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::{
    Accumulated, BayesGrid, Beam, BeamModel, CertaintyGrid, Environment, Geometry, GridError,
    Latest, Mapper, MedianGrid, RobustGrid, TrimmedGrid, UnknownSensor, owner_bytes,
};
use certainty_core::health::{Health, HealthRules};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::{Millimeters, Pose, Ticks};

/// A fusion level on the heap: a [`Mapper`] for any method, size and number of sensors.
///
/// The method is selected once a reading; within a reading the same code runs as on a microcontroller.
#[derive(Debug, Clone)]
pub struct HostMapper(Inner);

type Bytes = Vec<u8>;
/// The most sensors of a vote: all numbers of sensors.
const MOST: usize = 255;

#[derive(Debug, Clone)]
enum Inner {
    Bayes(Mapper<BayesGrid<Geometry, Bytes>, Vec<Health>>),
    Literal(Mapper<LiteralGrid, Vec<Health>>),
    Robust(Mapper<RobustGrid<Geometry, Bytes, Bytes>, Vec<Health>>),
    TrimmedLatest(Mapper<TrimmedGrid<Geometry, Bytes, MOST, Latest>, Vec<Health>>),
    TrimmedAccumulated(Mapper<TrimmedGrid<Geometry, Bytes, MOST, Accumulated>, Vec<Health>>),
    MedianLatest(Mapper<MedianGrid<Geometry, Bytes, MOST, Latest>, Vec<Health>>),
    MedianAccumulated(Mapper<MedianGrid<Geometry, Bytes, MOST, Accumulated>, Vec<Health>>),
}

/// Evaluates an expression for the mapper of any method.
macro_rules! each {
    ($inner:expr, $mapper:ident => $do:expr) => {
        match $inner {
            Inner::Bayes($mapper) => $do,
            Inner::Literal($mapper) => $do,
            Inner::Robust($mapper) => $do,
            Inner::TrimmedLatest($mapper) => $do,
            Inner::TrimmedAccumulated($mapper) => $do,
            Inner::MedianLatest($mapper) => $do,
            Inner::MedianAccumulated($mapper) => $do,
        }
    };
}

/// Returns the mapper of a grid whose storage was made for its geometry.
fn mapper<G: CertaintyGrid, S>(
    grid: Result<G, GridError<S>>,
    health: Vec<Health>,
    rules: HealthRules,
) -> Mapper<G, Vec<Health>> {
    let grid = grid.expect("the storage was made for this geometry");
    Mapper::with_records(grid, health, rules)
}

impl HostMapper {
    /// Creates an empty map for sensors 1 to `sensors`, all with the first confidence of the rules.
    ///
    /// # Panics
    ///
    /// For no sensors.
    #[must_use]
    pub fn new(method: Method, fusion: &FusionRules, geometry: Geometry, sensors: u8) -> Self {
        assert!(sensors > 0, "a map needs a sensor");
        let cells = geometry.cells() as usize;
        let flat = vec![0; cells];
        let layered = || vec![0; cells * usize::from(sensors)];
        let FusionRules {
            own,
            own_strongest,
            middle,
            strongest,
            landmarks,
            robust: add,
            health: rules,
            ..
        } = *fusion;
        let health = vec![add.first_health(); sensors.into()];
        let trim = fusion.trimmed(sensors);
        let accumulated = Accumulated {
            strongest: own_strongest,
        };
        Self(match (method, own) {
            (Method::Bayes, _) if landmarks == Landmarks::Literal => Inner::Literal(
                Mapper::with_records(LiteralGrid::new(geometry), health, rules),
            ),
            (Method::Bayes, _) => {
                let grid = BayesGrid::try_new(geometry, strongest, flat);
                Inner::Bayes(mapper(grid, health, rules))
            }
            (Method::Robust, _) => {
                let owners = vec![0; owner_bytes(cells, sensors)];
                let grid = RobustGrid::try_new(geometry, add, sensors, flat, owners);
                Inner::Robust(mapper(grid, health, rules))
            }
            (Method::Trimmed, Own::Latest) => {
                let grid = TrimmedGrid::try_new(geometry, sensors, trim, Latest, layered());
                Inner::TrimmedLatest(mapper(grid, health, rules))
            }
            (Method::Trimmed, Own::Accumulated) => {
                let grid = TrimmedGrid::try_new(geometry, sensors, trim, accumulated, layered());
                Inner::TrimmedAccumulated(mapper(grid, health, rules))
            }
            (Method::Median, Own::Latest) => {
                let grid = MedianGrid::try_new(geometry, sensors, middle, Latest, layered());
                Inner::MedianLatest(mapper(grid, health, rules))
            }
            (Method::Median, Own::Accumulated) => {
                let grid = MedianGrid::try_new(geometry, sensors, middle, accumulated, layered());
                Inner::MedianAccumulated(mapper(grid, health, rules))
            }
        })
    }

    /// Adds one reading to the map; see [`Mapper::integrate`].
    ///
    /// # Errors
    ///
    /// [`UnknownSensor`] if the map was made for fewer sensors.
    pub fn integrate(
        &mut self,
        sensor: SensorId,
        beam: &Beam,
        model: &BeamModel,
        now: Ticks,
    ) -> Result<u32, UnknownSensor> {
        each!(&mut self.0, mapper => mapper.integrate(sensor, beam, model, now))
    }

    /// Returns the fused value of every cell, row after row from the lowest.
    #[must_use]
    pub fn cells(&self) -> Vec<Certainty> {
        each!(&self.0, mapper => {
            let map: Environment<'_, _> = mapper.environment();
            map.geometry().iter().map(|cell| map.certainty(cell)).collect()
        })
    }

    /// Returns the health of every sensor.
    #[must_use]
    pub fn health(&self) -> Vec<(SensorId, Health)> {
        each!(&self.0, mapper => {
            let sensors = mapper.environment().sensors();
            sensors.map(|(id, health)| (id, *health)).collect()
        })
    }

    /// Updates the status of every sensor without a reading; see [`Mapper::settle`].
    pub fn settle(&mut self, now: Ticks) {
        each!(&mut self.0, mapper => mapper.settle(now));
    }

    /// Returns where the map lies and how it is divided.
    #[must_use]
    pub fn geometry(&self) -> Geometry {
        each!(&self.0, mapper => mapper.grid().geometry())
    }

    /// Returns the bytes of cells and owners (\[001\] §7).
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        each!(&self.0, mapper => mapper.grid().memory_bytes())
    }
}

impl CastRay for HostMapper {
    fn cast(&self, from: Pose, range: Millimeters, obstacle: Certainty) -> RayHit {
        each!(&self.0, mapper => mapper.cast(from, range, obstacle))
    }
}

impl RobotMap for HostMapper {
    fn integrate(
        &mut self,
        sensor: SensorId,
        beam: &Beam,
        model: &BeamModel,
        now: Ticks,
    ) -> Result<u32, UnknownSensor> {
        Self::integrate(self, sensor, beam, model, now)
    }

    fn record(
        &mut self,
        sensor: SensorId,
        reading: Reading,
        now: Ticks,
    ) -> Result<(), UnknownSensor> {
        each!(&mut self.0, mapper => mapper.record(sensor, reading, now))
    }

    fn health(&self) -> &[Health] {
        each!(&self.0, mapper => mapper.health())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::units::Point;

    #[test]
    fn memory_is_the_papers_formula() {
        let geometry = Geometry::try_new(17, 11, Millimeters::new(100), Point::ORIGIN).unwrap();
        for (sensors, owners) in [(3, 47), (4, 71), (5, 71), (7, 71)] {
            let layered = 187 * usize::from(sensors);
            for (method, expected) in [
                (Method::Bayes, 187),
                (Method::Robust, 187 + owners),
                (Method::Trimmed, layered),
                (Method::Median, layered),
            ] {
                for own in [Own::Latest, Own::Accumulated] {
                    let rules = FusionRules {
                        own,
                        ..FusionRules::default()
                    };
                    let map = HostMapper::new(method, &rules, geometry, sensors);
                    assert_eq!(map.memory_bytes(), expected, "{method} for {sensors}");
                }
            }
        }
    }
}
