//! One run: the same readings through every method, measured against perfect sensors.

use super::{Profile, Reference, Score, SensorLayout, SensorSet};
use crate::fault::{FaultSpec, Faulty, SpecError, assign};
use crate::fusion::{FusionRules, HostMapper, Method};
use crate::replay::RecordedBeam;
use crate::transducer::{Gp2d02Unit, Look, PerfectSensor, Sensor, SensorModel, SimulatedGp2d02};
use crate::world::World;
use certainty_core::certainty::Certainty;
use certainty_core::fusion::{Beam, BeamModel, Shape};
use certainty_core::health::Health;
use certainty_core::sensor::SensorId;
use certainty_core::units::Ticks;
use certainty_firmware::smart_car::{FARTHEST, NEAREST, SmartCarShape};
use std::sync::Arc;

/// Milliseconds from one step of the sweep to the next: a conversion takes up to 70, turning the
/// head the rest.
pub const STEP_MS: u32 = 100;

/// How long a run is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Length {
    /// Until so many readings are taken, of all sensors together.
    Readings(u32),
    /// Until every head had so many turns; a sensor that chatters takes more readings in them.
    Steps(u32),
}

/// What a run is made of.
#[derive(Debug, Clone)]
pub struct Setup {
    /// What stands around the car.
    pub world: Arc<World>,
    /// Which sensors it carries.
    pub crew: SensorSet,
    /// Where they sit and look.
    pub rig: SensorLayout,
    /// How their readings are spread over cells.
    pub profile: Profile,
    /// What is wrong with them.
    pub faults: Vec<FaultSpec>,
    /// How long it is.
    pub length: Length,
    /// What the methods leave open.
    pub fusion: FusionRules,
    /// Names the run: the same seed gives the same bytes.
    pub seed: u64,
}

/// A set-up that cannot be run.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SetupError {
    /// A fault of a sensor that is not there.
    #[error(transparent)]
    Fault(#[from] SpecError),
}

/// One method's map and what it is worth.
#[derive(Debug, Clone)]
pub struct MethodResult {
    /// The method.
    pub method: Method,
    /// Its map, row after row from the lowest.
    pub cells: Vec<Certainty>,
    /// Its distance from the truth.
    pub score: Score,
    /// The bytes of its cells and owners.
    pub bytes: usize,
    /// What it holds of each sensor.
    pub health: Vec<(SensorId, Health)>,
}

/// A set-up whose readings are taken, for as many methods as one likes.
#[derive(Debug, Clone)]
pub struct Run {
    /// What it was made of.
    pub setup: Setup,
    /// How each sensor's readings are spread over cells, in the order of their numbers.
    pub models: Vec<BeamModel>,
    /// The readings in their order.
    pub readings: Vec<TakenReading>,
    /// The grid of perfect sensors that look where the real ones looked.
    pub reference: Reference,
}

/// A reading, and what only a simulator knows of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TakenReading {
    /// The beam with its sensor and time.
    pub beam: RecordedBeam,
    /// Whether a fault spoiled it, or may have.
    pub spoilt: bool,
}

impl Setup {
    /// The shipped car in `world` with the core's defaults, every sensor sound.
    #[must_use]
    pub fn smart_car(world: Arc<World>, crew: SensorSet, length: Length, seed: u64) -> Self {
        Self {
            world,
            crew,
            rig: SensorLayout::SMART_CAR,
            profile: Profile::default(),
            faults: Vec::new(),
            length,
            fusion: FusionRules::default(),
            seed,
        }
    }

    /// How each sensor's readings are spread over cells, in the order of their numbers.
    fn models(&self) -> Vec<BeamModel> {
        let members = self.crew.members().iter();
        members
            .map(|member| self.profile.model(member.model.accuracy()))
            .collect()
    }

    /// Takes the readings.
    ///
    /// # Errors
    ///
    /// [`SetupError`] for a fault of a sensor that is not there.
    pub fn run(self) -> Result<Run, SetupError> {
        let readings = self.take_readings()?;
        let reference = Reference::new(
            SmartCarShape.geometry(),
            &self.profile.model(0.0),
            self.perfect_sensor(),
            readings.iter().map(|taken| taken.look()),
        );
        Ok(Run {
            models: self.models(),
            setup: self,
            readings,
            reference,
        })
    }

    /// A sensor of the GP2D02's range that does not err.
    fn perfect_sensor(&self) -> PerfectSensor {
        PerfectSensor::new(Arc::clone(&self.world), NEAREST, FARTHEST)
    }

    /// Lets every head look in turn, step after step of the sweep.
    ///
    /// A sensor that chatters reports more often than its turn comes; what it reports counts as
    /// readings too.
    fn take_readings(&self) -> Result<Vec<TakenReading>, SetupError> {
        let heads = self.crew.count();
        let mut sensors = self.sensors()?;
        let (steps, most) = match self.length {
            Length::Readings(readings) => (u32::MAX, readings as usize),
            Length::Steps(steps) => (steps, usize::MAX),
        };
        let mut readings = Vec::new();
        for step in 0..steps {
            let at = Ticks::new(step.wrapping_mul(STEP_MS));
            for (slot, (id, sensor)) in (0_u8..).zip(&mut sensors) {
                let pose = self.rig.look(slot, heads, step);
                let look = Look {
                    origin: pose.at,
                    bearing: pose.heading,
                    at,
                };
                for _ in 0..sensor.reports_per_turn(at) {
                    if readings.len() == most {
                        return Ok(readings);
                    }
                    let beam = RecordedBeam {
                        at: look.at,
                        sensor: *id,
                        origin: look.origin,
                        bearing: look.bearing,
                        reading: sensor.sense(&look),
                    };
                    readings.push(TakenReading {
                        beam,
                        spoilt: sensor.spoilt_last(),
                    });
                }
            }
        }
        Ok(readings)
    }

    /// The crew at its places, each a real unit of its own, with its faults.
    fn sensors(&self) -> Result<Vec<(SensorId, Faulty<SimulatedGp2d02>)>, SetupError> {
        let mut faults = assign(&self.faults, &self.crew.names())?;
        let units = Gp2d02Unit::shipped().iter().cycle();
        let crew = self
            .crew
            .members()
            .iter()
            .zip(units)
            .zip(&mut faults)
            .enumerate();
        let sensors = crew.filter_map(|(slot, ((member, unit), faults))| {
            let id = SensorId::from_slot(slot)?;
            let world = Arc::clone(&self.world);
            let sound = SimulatedGp2d02::new(world, unit.clone(), member.model, self.seed, id);
            Some((
                id,
                Faulty::new(sound, id, core::mem::take(faults), self.seed),
            ))
        });
        Ok(sensors.collect())
    }
}

impl Run {
    /// Fuses the readings by `method` and scores its map.
    ///
    /// # Panics
    ///
    /// Never: the mapper is made for the crew.
    #[must_use]
    pub fn fuse(&self, method: Method) -> MethodResult {
        self.fuse_watching(method, |_, _| {})
    }

    /// Fuses the readings by `method`, letting `watch` see every reading and the map after it.
    ///
    /// # Panics
    ///
    /// Never: the mapper is made for the crew.
    pub fn fuse_watching(
        &self,
        method: Method,
        watch: impl FnMut(&TakenReading, &HostMapper),
    ) -> MethodResult {
        let mapper = self.integrate(method, &self.setup.fusion, watch);
        let cells = mapper.cells();
        MethodResult {
            method,
            score: Score::of(&cells, self.reference.cells()),
            cells,
            bytes: mapper.memory_bytes(),
            health: mapper.health(),
        }
    }

    /// Returns the map that `method` makes of the readings by other rules than the set-up's.
    ///
    /// # Panics
    ///
    /// Never: the mapper is made for the crew.
    #[must_use]
    pub fn map_by(&self, method: Method, rules: &FusionRules) -> Vec<Certainty> {
        self.integrate(method, rules, |_, _| {}).cells()
    }

    /// Returns the run of perfect sensors that looked where these did.
    ///
    /// Each is read as what it is: a sensor whose distances do not scatter.
    #[must_use]
    pub fn of_perfect_sensors(&self) -> Self {
        let mut perfect = self.setup.perfect_sensor();
        let readings = self.readings.iter().map(|taken| TakenReading {
            beam: RecordedBeam {
                reading: perfect.sense(&taken.look()),
                ..taken.beam
            },
            spoilt: false,
        });
        let readings = readings.collect();
        let flawless = |_| SensorModel::FLAWLESS;
        let setup = Setup {
            crew: self.setup.crew.clone().with_models(flawless),
            faults: Vec::new(),
            ..self.setup.clone()
        };
        Self {
            readings,
            models: setup.models(),
            setup,
            reference: self.reference.clone(),
        }
    }

    /// Lets a mapper of `method` hear every reading.
    fn integrate(
        &self,
        method: Method,
        rules: &FusionRules,
        mut watch: impl FnMut(&TakenReading, &HostMapper),
    ) -> HostMapper {
        let crew = self.setup.crew.count();
        let geometry = self.reference.geometry();
        let mut mapper = HostMapper::new(method, rules, geometry, crew);
        for taken in &self.readings {
            let beam = Beam::from(&taken.beam);
            let model = &self.models[taken.beam.sensor.slot()];
            mapper
                .integrate(taken.beam.sensor, &beam, model, taken.beam.at)
                .expect("the crew is the mapper's");
            watch(taken, &mapper);
        }
        mapper
    }
}

impl TakenReading {
    /// Where the sensor looked, and when.
    const fn look(&self) -> Look {
        Look {
            origin: self.beam.origin,
            bearing: self.beam.bearing,
            at: self.beam.at,
        }
    }
}
