//! One look around: a laser scan, the sonars' echoes, and what is concluded from them.

use super::acoustics::{Acoustics, Turned};
use super::fault::{RingDefect, RingFault};
use super::lasers::{LaserPair, ScannerModel};
use super::{BEAMS, ELEMENTS, SONARS, paper_ring};
use crate::transducer::stream::{Purpose, stream};
use crate::world::World;
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::{Millimeters, Pose};
use certainty_ring::{
    Assessment, Distances, Echoes, Monitor, NEIGHBOURS, Polygon, PolygonRules, Ring, RingRules,
    Scan, TooManyElements,
};
use rand::RngExt;
use rand_distr::StandardNormal;
use serde::Serialize;

/// A row's length: a sonar and its neighbours.
const HEARERS: usize = 2 * NEIGHBOURS as usize + 1;

/// How long the echoes' ways are, by transmitter and receiver's offset; `None` is no echo.
type Lengths = [[Option<f64>; HEARERS]; SONARS];

/// A world with a ring and lasers in it.
#[derive(Debug, Clone)]
pub struct Situation<'a> {
    world: &'a World,
    acoustics: Acoustics<'a>,
    /// The ring.
    pub ring: Ring<SONARS>,
    /// The lasers.
    pub lasers: LaserPair,
    /// What makes points a polygon.
    pub polygon: PolygonRules,
    /// What makes echoes agree.
    pub rules: RingRules,
    /// Standard deviation of the length of an echo's way, in millimetres: an open choice.
    pub noise_mm: f64,
}

/// What was measured at one place.
#[derive(Debug, Clone)]
pub struct Observation {
    /// The lasers' points.
    pub scan: Scan<BEAMS>,
    /// The polygon made of them.
    pub polygon: Polygon<ELEMENTS>,
    /// What the sonars heard.
    pub echoes: Echoes<SONARS>,
}

/// What is concluded from it.
#[derive(Debug, Clone, Copy)]
pub struct Judged {
    /// What the sonars should hear.
    pub expected: Distances<SONARS>,
    /// What they heard, folded.
    pub heard: Distances<SONARS>,
    /// The vectors and verdicts.
    pub assessment: Assessment<SONARS>,
}

impl<'a> Situation<'a> {
    /// Puts the paper's ring and lasers, with the core's defaults, into a world.
    ///
    /// # Panics
    ///
    /// Never: the lasers are within the core's limits.
    #[must_use]
    pub fn new(world: &'a World) -> Self {
        let models = [ScannerModel::COARSE, ScannerModel::FINE];
        Self {
            world,
            acoustics: Acoustics::new(world),
            ring: paper_ring(),
            lasers: LaserPair::try_new(models).expect("these scanners are within limits"),
            polygon: PolygonRules::DEFAULT,
            rules: RingRules::DEFAULT,
            noise_mm: 5.0,
        }
    }

    /// Returns the world.
    #[must_use]
    pub const fn world(&self) -> &'a World {
        self.world
    }

    /// Measures at `robot`; `part` tells the observations of a run apart.
    ///
    /// An observation with faults differs from the one without in the faults alone.
    ///
    /// # Errors
    ///
    /// [`TooManyElements`] if the surroundings have more straight pieces than there is room for.
    ///
    /// # Panics
    ///
    /// Never: the scan has room for the lasers' beams.
    pub fn observe(
        &self,
        robot: Pose,
        faults: &[RingFault],
        seed: u64,
        part: u32,
    ) -> Result<Observation, TooManyElements> {
        let scan = self.lasers.scan(self.world, robot, seed, part);
        let scan = scan.expect("the scan has room for the lasers' beams");
        Ok(Observation {
            polygon: Polygon::of(&scan, &self.polygon)?,
            echoes: self.echoes(robot, faults, seed, part),
            scan,
        })
    }

    /// What the sonars hear, faults included.
    #[must_use]
    pub fn echoes(
        &self,
        robot: Pose,
        faults: &[RingFault],
        seed: u64,
        part: u32,
    ) -> Echoes<SONARS> {
        let turned: Vec<Turned> = faults
            .iter()
            .filter_map(|fault| match fault.defect {
                RingDefect::Misaligned(by) => Some(Turned {
                    slot: fault.sensor.slot(),
                    radians: f64::from(by.to_bits().cast_signed()) / 65536.0
                        * core::f64::consts::TAU,
                }),
                _ => None,
            })
            .collect();
        let mut lengths = self.acoustics.lengths(&self.ring, robot, &turned);
        let mut dice = stream(seed, Purpose::Transducer, 0, part);
        for length in lengths.iter_mut().flatten() {
            // Drawn for every path, heard or not, so that no fault changes another's draws.
            let noise: f64 = dice.sample(StandardNormal);
            *length = length.map(|length| (length + noise * self.noise_mm).max(0.0));
        }
        let sound = lengths;
        for fault in faults {
            self.spoil(&mut lengths, &sound, *fault, seed, part);
        }
        let mut echoes = Echoes::unknown();
        for (from, row) in lengths.iter().enumerate() {
            for (column, length) in row.iter().enumerate() {
                let reading = length.map_or(Reading::NoObject, |length| {
                    Reading::Echo(Millimeters::new(length.round() as u32))
                });
                let ends = (
                    SensorId::from_slot(from),
                    SensorId::from_slot(receiver(from, column)),
                );
                if let (Some(from), Some(to)) = ends {
                    let set = echoes.set(from, to, reading);
                    debug_assert!(set.is_ok(), "neighbours hear each other");
                }
            }
        }
        echoes
    }

    /// Applies a fault to what would be heard without any.
    fn spoil(
        &self,
        lengths: &mut Lengths,
        sound: &Lengths,
        fault: RingFault,
        seed: u64,
        part: u32,
    ) {
        let slot = fault.sensor.slot();
        let farthest = 2.0 * f64::from(self.ring.config().range.get());
        let mut dice = stream(seed, Purpose::Fault, fault.sensor.number(), part);
        for (from, row) in lengths.iter_mut().enumerate() {
            for (column, length) in row.iter_mut().enumerate() {
                let to = receiver(from, column);
                let (sends, hears) = (from == slot, to == slot);
                let was = sound[from][column];
                match fault.defect {
                    RingDefect::Falsified(by) if sends || hears => {
                        // Off upwards, or downwards where upwards would be out of range.
                        let (was, by) = (was.unwrap_or(farthest), 2.0 * f64::from(by.get()));
                        let up = was + by;
                        *length = Some(if up <= farthest {
                            up
                        } else {
                            (was - by).max(0.0)
                        });
                    }
                    RingDefect::Blind if sends || hears => *length = None,
                    RingDefect::Stuck(at) if hears => *length = Some(2.0 * f64::from(at.get())),
                    RingDefect::Crosstalk if hears => {
                        // From 0.3 m of way, what a pulse itself lasts, to the echo that would come.
                        let last = was.unwrap_or(farthest).max(301.0);
                        *length = Some(dice.random_range(300.0..last));
                    }
                    _ => {}
                }
            }
        }
    }

    /// Concludes from an observation alone, by a monitor that has removed none before.
    #[must_use]
    pub fn judge(&self, observation: &Observation) -> Judged {
        let expected = Distances::simulated(&self.ring, &observation.polygon);
        let heard = Distances::fold(&self.ring, &observation.echoes, &self.rules);
        let assessment = Monitor::new(self.rules).assess(&self.ring, Some(&expected), &heard);
        Judged {
            expected,
            heard,
            assessment,
        }
    }
}

/// The place in the ring of the receiver in this column of a transmitter's row.
fn receiver(from: usize, column: usize) -> usize {
    (from + column + SONARS - usize::from(NEIGHBOURS)) % SONARS
}

/// The three confidence vectors.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Vectors {
    /// \[003\] §5.
    pub simulation_based: Vec<u8>,
    /// \[003\] §6.
    pub intersection_based: Vec<u8>,
    /// \[003\] §7.
    pub overall: Vec<u8>,
}

impl Vectors {
    /// The vectors of an assessment.
    #[must_use]
    pub fn of(judged: &Judged) -> Self {
        let assessment = &judged.assessment;
        Self {
            simulation_based: assessment.simulation_based().to_vec(),
            intersection_based: assessment.intersection_based().to_vec(),
            overall: assessment.overall().to_vec(),
        }
    }
}
