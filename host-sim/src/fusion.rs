//! The core's grids with the host's storage, chosen at run time.

mod literal;
mod rules;

pub use literal::LiteralGrid;
pub use rules::{Rules, UnknownRules};

use certainty_control::{ExpectedScan, PerBeam, Views, scan_of_map};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::{
    Accumulated, BayesGrid, Beam, BeamModel, CertaintyGrid, Environment, Geometry, Latest, Mapper,
    MedianGrid, Middle, RobustGrid, RobustRules, Strength, TrimmedGrid, UnknownSensor, owner_bytes,
};
use certainty_core::health::{Health, HealthRules};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::{Millimeters, Pose, Ticks};
use core::fmt;
use core::str::FromStr;

/// A way to fuse, by the name it has on the command line and in reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Method {
    /// Eq. 1 of \[001\]: [`BayesGrid`].
    Bayes,
    /// `AddToGrid`, \[001\] Fig. 3: [`RobustGrid`].
    Robust,
    /// Trim, then eq. 1, \[000\] §3.1: [`TrimmedGrid`].
    Trimmed,
    /// Median selection, \[000\] §3.2: [`MedianGrid`].
    Median,
}

impl Method {
    /// Every method, in the order in which reports list them.
    pub const ALL: [Self; 4] = [Self::Bayes, Self::Robust, Self::Trimmed, Self::Median];

    /// Returns the method's name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bayes => "bayes",
            Self::Robust => "robust",
            Self::Trimmed => "trimmed",
            Self::Median => "median",
        }
    }

    /// Returns how many layers of cells this method keeps for so many sensors.
    #[must_use]
    pub const fn layers(self, sensors: u8) -> u64 {
        match self {
            Self::Bayes | Self::Robust => 1,
            Self::Trimmed | Self::Median => sensors as u64,
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The name is none of a method's.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is no fusion method; use bayes, robust, trimmed or median")]
pub struct UnknownMethod(pub String);

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        let found = Self::ALL.into_iter().find(|method| method.name() == name);
        found.ok_or_else(|| UnknownMethod(name.to_owned()))
    }
}

/// How each sensor's own grid is kept by the trimmed and the median method; \[000\] §3.1 leaves it open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Own {
    /// The sensor's latest word counts.
    Latest,
    /// The sensor's words are fused by eq. 1.
    Accumulated,
}

/// What eq. 1 of \[001\] is told where a measurement says *free* or *occupied*.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Landmarks {
    /// Odds of at most [`FusionRules::strongest`].
    Bounded,
    /// Probabilities of 0 and 1, which eq. 1 can never take back: [`LiteralGrid`].
    Literal,
}

/// What the methods leave open; the defaults are the core's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FusionRules {
    /// How each sensor's own grid is kept; the trimmed and the median method.
    pub own: Own,
    /// The surest that one measurement may be in a sensor's own grid that accumulates.
    pub own_strongest: Strength,
    /// What it takes of an even number of sensors; the median method.
    pub middle: Middle,
    /// The surest that one measurement may be; the Bayes method.
    pub strongest: Strength,
    /// Whether that holds; the Bayes method. The others never take a landmark literally.
    pub landmarks: Landmarks,
    /// The open numbers of `AddToGrid`; the robust method.
    pub robust: RobustRules,
    /// When a sensor is suspect, failed, recovering and healthy; every method.
    pub health: HealthRules,
}

impl Default for FusionRules {
    /// Each sensor accumulates its own grid: beams a few degrees apart cross the same cells, and the
    /// latest word of one that grazes an obstacle's cell would erase what a dozen before it saw.
    fn default() -> Self {
        Self {
            own: Own::Accumulated,
            own_strongest: Strength::OWN,
            middle: Middle::Higher,
            strongest: Strength::MEASUREMENT,
            landmarks: Landmarks::Bounded,
            robust: RobustRules::DEFAULT,
            health: HealthRules::DEFAULT,
        }
    }
}

/// A fusion level on the heap: a [`Mapper`] for any method, size and number of sensors.
///
/// The method is looked up once a reading; within a reading the core's code runs as it does on a
/// microcontroller.
#[derive(Debug, Clone)]
pub struct HostMapper(Inner);

type Bytes = Vec<u8>;
/// A vote may have as many sensors as there are numbers.
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

/// Runs the same expression on whichever mapper it is.
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

impl HostMapper {
    /// Creates an empty map for sensors 1 to `sensors`, all trusted as far as the rules start.
    ///
    /// The trimmed method trims one sensor each way, none where there are fewer than three.
    ///
    /// # Panics
    ///
    /// For no sensors.
    #[must_use]
    pub fn new(method: Method, fusion: &FusionRules, geometry: Geometry, sensors: u8) -> Self {
        const RIGHT_SIZE: &str = "the storage was made for this geometry";
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
        } = *fusion;
        let health = vec![add.first_health(); sensors.into()];
        let trim = u8::from(sensors >= 3);
        let accumulated = Accumulated {
            strongest: own_strongest,
        };
        Self(match (method, own) {
            (Method::Bayes, _) if landmarks == Landmarks::Literal => Inner::Literal(
                Mapper::with_records(LiteralGrid::new(geometry), health, rules),
            ),
            (Method::Bayes, _) => {
                let grid = BayesGrid::try_new(geometry, strongest, flat);
                Inner::Bayes(Mapper::with_records(grid.expect(RIGHT_SIZE), health, rules))
            }
            (Method::Robust, _) => {
                let owners = vec![0; owner_bytes(cells, sensors)];
                let grid = RobustGrid::try_new(geometry, add, sensors, flat, owners);
                Inner::Robust(Mapper::with_records(grid.expect(RIGHT_SIZE), health, rules))
            }
            (Method::Trimmed, Own::Latest) => {
                let grid = TrimmedGrid::try_new(geometry, sensors, trim, Latest, layered());
                Inner::TrimmedLatest(Mapper::with_records(grid.expect(RIGHT_SIZE), health, rules))
            }
            (Method::Trimmed, Own::Accumulated) => {
                let grid = TrimmedGrid::try_new(geometry, sensors, trim, accumulated, layered());
                Inner::TrimmedAccumulated(Mapper::with_records(
                    grid.expect(RIGHT_SIZE),
                    health,
                    rules,
                ))
            }
            (Method::Median, Own::Latest) => {
                let grid = MedianGrid::try_new(geometry, sensors, middle, Latest, layered());
                Inner::MedianLatest(Mapper::with_records(grid.expect(RIGHT_SIZE), health, rules))
            }
            (Method::Median, Own::Accumulated) => {
                let grid = MedianGrid::try_new(geometry, sensors, middle, accumulated, layered());
                Inner::MedianAccumulated(Mapper::with_records(
                    grid.expect(RIGHT_SIZE),
                    health,
                    rules,
                ))
            }
        })
    }

    /// Takes one reading into the map; see [`Mapper::integrate`].
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

    /// Adds one reading to the sensor's record and not to the map; see [`Mapper::record`].
    ///
    /// # Errors
    ///
    /// [`UnknownSensor`] if the map was made for fewer sensors.
    pub fn record(
        &mut self,
        sensor: SensorId,
        reading: Reading,
        now: Ticks,
    ) -> Result<(), UnknownSensor> {
        each!(&mut self.0, mapper => mapper.record(sensor, reading, now))
    }

    /// Returns the fused value of every cell, row after row from the lowest.
    #[must_use]
    pub fn cells(&self) -> Vec<Certainty> {
        each!(&self.0, mapper => {
            let map: Environment<'_, _> = mapper.environment();
            map.geometry().iter().map(|cell| map.certainty(cell)).collect()
        })
    }

    /// Returns every sensor with its health.
    #[must_use]
    pub fn health(&self) -> Vec<(SensorId, Health)> {
        each!(&self.0, mapper => {
            let sensors = mapper.environment().sensors();
            sensors.map(|(id, health)| (id, *health)).collect()
        })
    }

    /// Draws the conclusion about every sensor without a reading; see [`Mapper::settle`].
    pub fn settle(&mut self, now: Ticks) {
        each!(&mut self.0, mapper => mapper.settle(now));
    }

    /// Returns what a scanner would see in the map; see [`scan_of_map`].
    #[must_use]
    pub fn scan(
        &self,
        scanner: Pose,
        farthest: Millimeters,
        obstacle: Certainty,
    ) -> PerBeam<Reading> {
        each!(&self.0, mapper => scan_of_map(&mapper.environment(), scanner, farthest, obstacle))
    }

    /// Returns what the map shows where a robot's sensors look; see [`ExpectedScan::of_map`].
    #[must_use]
    pub fn recollection(&self, robot: Pose, views: &Views, obstacle: Certainty) -> ExpectedScan {
        each!(&self.0, mapper => ExpectedScan::of_map(&mapper.environment(), robot, views, obstacle))
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

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::units::Point;

    #[test]
    fn memory_is_the_papers_formula_for_every_method() {
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

    #[test]
    fn names_are_read_back_and_others_refused() {
        for method in Method::ALL {
            assert_eq!(method.name().parse(), Ok(method));
        }
        assert_eq!(
            "Bayes".parse::<Method>(),
            Err(UnknownMethod("Bayes".into()))
        );
    }
}
