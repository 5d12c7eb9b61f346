//! One run: the same readings through every method, measured against perfect sensors.

use super::{Crew, Reference, Score};
use crate::fault::{FaultSpec, Faulty, SpecError, assign};
use crate::fusion::{HostMapper, Method, Own};
use crate::replay::RecordedBeam;
use crate::transducer::{Gp2d02Unit, Look, PerfectSensor, Sensor, SimulatedGp2d02};
use crate::world::World;
use certainty_core::certainty::Certainty;
use certainty_core::fusion::{Beam, BeamModel, Shape};
use certainty_core::health::Health;
use certainty_core::sensor::SensorId;
use certainty_core::units::Ticks;
use certainty_firmware::smart_car::{self, FARTHEST, NEAREST, SmartCarShape};
use fixed::types::U0F16;
use std::sync::Arc;

/// Milliseconds from one step of the sweep to the next: a conversion takes up to 70, turning the
/// head the rest.
pub const STEP_MS: u32 = 100;

/// What a run is made of.
#[derive(Debug, Clone)]
pub struct Setup {
    /// What stands around the car.
    pub world: Arc<World>,
    /// Which sensors it carries.
    pub crew: Crew,
    /// What is wrong with them.
    pub faults: Vec<FaultSpec>,
    /// How many readings are taken, of all sensors together.
    pub readings: u32,
    /// The methods to compare.
    pub methods: Vec<Method>,
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

/// A finished run.
#[derive(Debug, Clone)]
pub struct Run {
    /// What it was made of.
    pub setup: Setup,
    /// The grid of perfect sensors.
    pub reference: Reference,
    /// The methods in the order asked for.
    pub methods: Vec<MethodResult>,
}

impl Setup {
    /// Takes the readings and fuses them by every method.
    ///
    /// The trimmed and the median method let each sensor accumulate its own grid: beams 5° apart
    /// cross the same cells, and the latest word of one that grazes an obstacle's cell would erase
    /// what a dozen before it saw.
    ///
    /// # Errors
    ///
    /// [`SetupError`] for a fault of a sensor that is not there.
    ///
    /// # Panics
    ///
    /// Never: a crew has at most 15 sensors.
    pub fn run(self) -> Result<Run, SetupError> {
        let beams = self.take_readings()?;
        let exact = smart_car::beam_model(U0F16::ZERO);
        let models: Vec<_> = self
            .crew
            .members()
            .iter()
            .map(|m| model(m.model.accuracy()))
            .collect();
        let reference = Reference::new(
            SmartCarShape.geometry(),
            &exact,
            PerfectSensor::new(Arc::clone(&self.world), NEAREST, FARTHEST),
            beams.iter().map(|beam| Look {
                origin: beam.origin,
                bearing: beam.bearing,
                at: beam.at,
            }),
        );
        let fuse = |&method: &Method| {
            let mut mapper = HostMapper::new(
                method,
                Own::Accumulated,
                SmartCarShape.geometry(),
                self.crew.count(),
            );
            for recorded in &beams {
                let beam = Beam::from(recorded);
                let model = &models[recorded.sensor.slot()];
                mapper
                    .integrate(recorded.sensor, &beam, model, recorded.at)
                    .expect("the crew is the mapper's");
            }
            let cells = mapper.cells();
            MethodResult {
                method,
                score: Score::of(&cells, reference.cells()),
                cells,
                bytes: mapper.memory_bytes(),
                health: mapper.health(),
            }
        };
        let methods = self.methods.iter().map(fuse).collect();
        Ok(Run {
            setup: self,
            reference,
            methods,
        })
    }

    /// Lets every head look in turn, step after step of the sweep, until enough readings are taken.
    ///
    /// A sensor that chatters reports more often than its turn comes; what it reports counts as
    /// readings too.
    fn take_readings(&self) -> Result<Vec<RecordedBeam>, SetupError> {
        let heads = self.crew.count();
        let mut sensors = self.sensors()?;
        let mut beams = Vec::with_capacity(self.readings as usize);
        for step in 0_u32.. {
            let start = Ticks::new(step.wrapping_mul(STEP_MS));
            for (slot, (id, sensor)) in (0_u8..).zip(&mut sensors) {
                let pose = smart_car::look(slot, heads, step);
                let look = Look {
                    origin: pose.at,
                    bearing: pose.heading,
                    at: start,
                };
                for _ in 0..sensor.reports_per_turn(start) {
                    if beams.len() == self.readings as usize {
                        return Ok(beams);
                    }
                    beams.push(RecordedBeam {
                        at: look.at,
                        sensor: *id,
                        origin: look.origin,
                        bearing: look.bearing,
                        reading: sensor.sense(&look),
                    });
                }
            }
        }
        Ok(beams)
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

/// The beam of a sensor with this accuracy, a fraction.
fn model(accuracy: f64) -> BeamModel {
    smart_car::beam_model(U0F16::saturating_from_num(accuracy))
}
