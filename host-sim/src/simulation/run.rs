//! A run: the same readings for every method, scored against perfect sensors.

use super::score::{Reference, Score};
use super::sensor_layout::{Profile, SensorLayout};
use crate::fault::{FaultSpec, Faulty, SpecError, assign};
use crate::fusion::{FusionRules, HostMapper, Method};
use crate::replay::RecordedBeam;
use crate::transducer::{
    Gp2d02Unit, Look, PerfectSensor, Sensor, SensorModel, SensorSet, SimulatedGp2d02, Validation,
};
use crate::world::World;
use certainty_core::certainty::Certainty;
use certainty_core::fusion::{Beam, BeamModel, Shape};
use certainty_core::health::Health;
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{ValidationConfig, ValidationRules};
use certainty_core::units::Ticks;
use certainty_firmware::smart_car::{FARTHEST, NEAREST, SmartCarShape};
use std::sync::Arc;

/// Milliseconds from one step of the sweep to the next: up to 70 for a conversion, the rest for turning
/// the head.
pub const STEP_MS: u32 = 100;

/// The length of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Length {
    /// This many readings of all sensors together.
    Readings(u32),
    /// This many turns of every head; a sensor that chatters takes more readings in them.
    Steps(u32),
}

/// The parameters of a run.
#[derive(Debug, Clone)]
pub struct Setup {
    /// The obstacles around the car.
    pub world: Arc<World>,
    /// The sensors of the car.
    pub sensors: SensorSet,
    /// Their placement and sweeps.
    pub layout: SensorLayout,
    /// How their readings are spread over cells.
    pub profile: Profile,
    /// Their faults.
    pub faults: Vec<FaultSpec>,
    /// Whether each sensor's readings are validated before they are fused, as \[002\] Fig. 1 draws it.
    pub validated: bool,
    /// The length.
    pub length: Length,
    /// The open numbers of the methods.
    pub fusion: FusionRules,
    /// The seed of all random numbers: the same seed gives the same bytes.
    pub seed: u64,
}

/// Why a set-up cannot be run.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SetupError {
    /// A fault of a sensor that does not exist.
    #[error(transparent)]
    Fault(#[from] SpecError),
}

/// One method's map and its score.
#[derive(Debug, Clone)]
pub struct MethodResult {
    /// The method.
    pub method: Method,
    /// Its map, row after row from the lowest.
    pub cells: Vec<Certainty>,
    /// Its score.
    pub score: Score,
    /// The bytes of its cells and owners.
    pub bytes: usize,
    /// The health of each sensor.
    pub health: Vec<(SensorId, Health)>,
}

/// A set-up with its readings, which any number of methods can fuse.
#[derive(Debug, Clone)]
pub struct Run {
    /// The parameters.
    pub setup: Setup,
    /// How each sensor's readings are spread over cells, in the order of their numbers.
    pub models: Vec<BeamModel>,
    /// The readings in their order.
    pub readings: Vec<SimulatedReading>,
    /// The grid of perfect sensors with the looks of the real ones.
    pub reference: Reference,
}

/// A reading, and whether a fault changed it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SimulatedReading {
    /// The beam with its sensor and time.
    pub beam: RecordedBeam,
    /// Whether a fault was active, and so may have changed it.
    pub faulty: bool,
}

impl Setup {
    /// Creates the set-up of the shipped car in `world` with the core's defaults, every sensor sound.
    #[must_use]
    pub fn smart_car(world: Arc<World>, sensors: SensorSet, length: Length, seed: u64) -> Self {
        Self {
            world,
            sensors,
            layout: SensorLayout::SMART_CAR,
            profile: Profile::default(),
            faults: Vec::new(),
            validated: false,
            length,
            fusion: FusionRules::default(),
            seed,
        }
    }

    /// How each sensor's readings are spread over cells, in the order of their numbers.
    fn models(&self) -> Vec<BeamModel> {
        let members = self.sensors.members().iter();
        members
            .map(|member| self.profile.model(member.model.accuracy()))
            .collect()
    }

    /// Takes the readings.
    ///
    /// # Errors
    ///
    /// [`SetupError`] for a fault of a sensor that does not exist.
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

    /// A perfect sensor with the range of a GP2D02.
    fn perfect_sensor(&self) -> PerfectSensor {
        PerfectSensor::new(Arc::clone(&self.world), NEAREST, FARTHEST)
    }

    /// Takes the readings: every head in turn, step after step of the sweep.
    ///
    /// A sensor that chatters reports more than once in its turn; each report is a reading.
    fn take_readings(&self) -> Result<Vec<SimulatedReading>, SetupError> {
        let heads = self.sensors.count();
        let mut sensors = self.sensors()?;
        let mut validations = vec![self.validation(); sensors.len()];
        let (steps, most) = match self.length {
            Length::Readings(readings) => (u32::MAX, readings as usize),
            Length::Steps(steps) => (steps, usize::MAX),
        };
        let mut readings = Vec::new();
        for step in 0..steps {
            let at = Ticks::new(step.wrapping_mul(STEP_MS));
            let turns = sensors.iter_mut().zip(&mut validations);
            for (slot, ((id, sensor), validation)) in (0_u8..).zip(turns) {
                let pose = self.layout.look(slot, heads, step);
                let look = Look {
                    origin: pose.at,
                    bearing: pose.heading,
                    at,
                };
                for _ in 0..sensor.reports_per_turn(at) {
                    if readings.len() == most {
                        return Ok(readings);
                    }
                    let measured = sensor.sense(&look);
                    let reading = match validation {
                        Some(validation) => validation.check(measured, &look),
                        None => measured,
                    };
                    let beam = RecordedBeam {
                        at: look.at,
                        sensor: *id,
                        origin: look.origin,
                        bearing: look.bearing,
                        reading,
                    };
                    readings.push(SimulatedReading {
                        beam,
                        faulty: sensor.last_was_faulty(),
                    });
                }
            }
        }
        Ok(readings)
    }

    /// The checks of a sensor's readings: those of the shipped car, with the sweeps of this run.
    fn validation(&self) -> Option<Validation> {
        let directions = self.layout.directions();
        let sweep_ms = STEP_MS * u32::from(directions);
        let config = ValidationConfig::sweeping(NEAREST, FARTHEST, 0, directions, sweep_ms);
        let rules = ValidationRules::try_new(config).ok();
        rules.filter(|_| self.validated).map(Validation::new)
    }

    /// The sensors with their faults, each with the curve of another real unit.
    fn sensors(&self) -> Result<Vec<(SensorId, Faulty<SimulatedGp2d02>)>, SetupError> {
        let mut faults = assign(&self.faults, &self.sensors.names())?;
        let units = Gp2d02Unit::shipped().iter().cycle();
        let sensors = self
            .sensors
            .members()
            .iter()
            .zip(units)
            .zip(&mut faults)
            .enumerate();
        let sensors = sensors.filter_map(|(slot, ((member, unit), faults))| {
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
    #[must_use]
    pub fn fuse(&self, method: Method) -> MethodResult {
        self.fuse_watching(method, |_, _| {})
    }

    /// Fuses the readings by `method`, and calls `watch` with every reading and the map after it.
    pub fn fuse_watching(
        &self,
        method: Method,
        watch: impl FnMut(&SimulatedReading, &HostMapper),
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

    /// Returns the map of `method` with other rules than the set-up's.
    #[must_use]
    pub fn map_by(&self, method: Method, rules: &FusionRules) -> Vec<Certainty> {
        self.integrate(method, rules, |_, _| {}).cells()
    }

    /// Returns the run of perfect sensors with the same looks.
    ///
    /// Their readings are spread over cells as those of sensors without scatter.
    #[must_use]
    pub fn of_perfect_sensors(&self) -> Self {
        let mut perfect = self.setup.perfect_sensor();
        let readings = self.readings.iter().map(|taken| SimulatedReading {
            beam: RecordedBeam {
                reading: perfect.sense(&taken.look()),
                ..taken.beam
            },
            faulty: false,
        });
        let readings = readings.collect();
        let flawless = |_| SensorModel::FLAWLESS;
        let setup = Setup {
            sensors: self.setup.sensors.clone().with_models(flawless),
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

    /// Adds every reading to a mapper of `method`.
    fn integrate(
        &self,
        method: Method,
        rules: &FusionRules,
        mut watch: impl FnMut(&SimulatedReading, &HostMapper),
    ) -> HostMapper {
        let sensors = self.setup.sensors.count();
        let geometry = self.reference.geometry();
        let mut mapper = HostMapper::new(method, rules, geometry, sensors);
        for taken in &self.readings {
            let beam = Beam::from(&taken.beam);
            let model = &self.models[taken.beam.sensor.slot()];
            // Never an error: the mapper was created for these sensors.
            let _ = mapper.integrate(taken.beam.sensor, &beam, model, taken.beam.at);
            watch(taken, &mapper);
        }
        mapper
    }
}

impl SimulatedReading {
    /// The look of the sensor.
    const fn look(&self) -> Look {
        Look {
            origin: self.beam.origin,
            bearing: self.beam.bearing,
            at: self.beam.at,
        }
    }
}
