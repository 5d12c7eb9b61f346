//! Simulated devices, pin by pin, for the shipped drivers.
//!
//! The state of a device depends only on the levels of its pins and on the time, in nanoseconds of virtual
//! time that never decreases. There are no events: the owner of the clock may step it by any amount. A
//! device gets its measurement from a closure when it measures, so it does not depend on worlds.

mod fault;
mod gp2d02_line;
mod moving_car;
mod ranger_line;
mod servo_shaft;
#[cfg(test)]
mod test_pins;

pub(crate) use fault::MILLISECOND;
pub use fault::{BenchFault, LineFault, MotorFault, WireFault};
pub use gp2d02_line::Gp2d02Line;
pub use moving_car::GroundTruth;
pub use ranger_line::{RangerAnswer, RangerLine};
pub use servo_shaft::ServoShaft;

use crate::fault::{Defect, FaultSpec, Faulty, SpecError, Window, assign};
use crate::transducer::{Gp2d02Unit, Look, Sensor, SensorSet, SimulatedGp2d02};
use crate::world::World;
use certainty_core::sensor::SensorId;
use certainty_core::units::{BinaryAngle, Millimeters, Pose, Ticks};
use certainty_firmware::remote::{Channel, Line};
use certainty_firmware::smart_car::{
    HEADS, RANGER, RANGERS, SCHEDULE, SERVO, STATIONS, mounting, ranger_mounting,
};
use moving_car::MovingCar;
use std::sync::Arc;
use thiserror::Error;

/// What the bench is set up with.
#[derive(Debug, Clone)]
pub struct BenchSetup {
    /// The obstacles around the car.
    pub world: Arc<World>,
    /// Its infrared sensors, one a head; more than the car has heads are ignored.
    pub sensors: SensorSet,
    /// Faults of sensors, wires and motors.
    pub faults: Vec<BenchFault>,
    /// The seed of all random numbers: the same seed gives the same bytes.
    pub seed: u64,
}

/// Why a bench cannot be set up.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum BenchError {
    /// A fault of a sensor that does not exist.
    #[error(transparent)]
    Fault(#[from] SpecError),
    /// A fault that the sensor cannot have.
    #[error("{fault}: {why}")]
    Misplaced {
        /// The fault.
        fault: String,
        /// Why not, and what to write.
        why: &'static str,
    },
}

/// There is no such line or channel, or it has failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("no such line or channel, or it has failed")]
pub struct Unavailable;

/// The Smart Car's simulated devices in a world.
///
/// Their state depends only on the levels that were set and on the time, in nanoseconds that never
/// decrease. Time zero of windows is the first servo pulse, the start of the schedule, so the time that a
/// board takes to boot does not matter. The sensors measure from where the motors have driven the car.
#[derive(Debug)]
pub struct Bench {
    heads: Vec<Head>,
    rangers: Vec<Ranger>,
    world: Arc<World>,
    car: MovingCar,
    epoch_ns: Option<u64>,
}

/// A pivoted infrared sensor.
#[derive(Debug)]
struct Head {
    line: Gp2d02Line,
    shaft: ServoShaft,
    sensor: Faulty<SimulatedGp2d02>,
    unit: Gp2d02Unit,
    wires: Vec<(WireFault, Window)>,
}

/// A fixed ultrasonic ranger.
#[derive(Debug)]
struct Ranger {
    slot: u8,
    line: RangerLine,
    wires: Vec<(WireFault, Window)>,
}

impl Bench {
    /// Sets the bench up.
    ///
    /// # Errors
    ///
    /// [`BenchError`] for a fault of a sensor that does not exist, or that the sensor cannot have.
    pub fn new(setup: BenchSetup) -> Result<Self, BenchError> {
        let names = [""; STATIONS];
        let mut sensor_faults: Vec<FaultSpec> = Vec::new();
        let mut wires = vec![Vec::new(); STATIONS];
        let mut motors = Vec::new();
        for fault in &setup.faults {
            match fault {
                BenchFault::Motor {
                    motor,
                    fault,
                    window,
                } => motors.push((*motor, *fault, *window)),
                BenchFault::Sensor(spec) => {
                    check_sensor_fault(spec, fault, &names)?;
                    sensor_faults.push(spec.clone());
                }
                BenchFault::Wire {
                    sensor,
                    fault: wire,
                    window,
                } => {
                    let slot = sensor.resolve(&names)?.slot();
                    let is_servo = !matches!(wire, WireFault::Line(_));
                    if is_servo && slot >= usize::from(HEADS) {
                        let why = "the rangers 4 and 5 have no servo; write 1 to 3";
                        return Err(misplaced(fault, why));
                    }
                    wires[slot].push((*wire, *window));
                }
            }
        }
        let mut faults = assign(&sensor_faults, &names)?;
        let sensors = setup.sensors.members().iter().zip(Gp2d02Unit::shipped());
        let heads = (0..HEADS)
            .zip(sensors)
            .filter_map(|(slot, (member, unit))| {
                let id = SensorId::from_slot(slot.into())?;
                let world = Arc::clone(&setup.world);
                let sound = SimulatedGp2d02::new(world, unit.clone(), member.model, setup.seed, id);
                let faults = core::mem::take(&mut faults[usize::from(slot)]);
                let servo = SERVO.config();
                Some(Head {
                    line: Gp2d02Line::new(),
                    shaft: ServoShaft::new(servo, servo.ahead_us.into()),
                    sensor: Faulty::new(sound, id, faults, setup.seed),
                    unit: unit.clone(),
                    wires: core::mem::take(&mut wires[usize::from(slot)]),
                })
            });
        let heads = heads.collect();
        let rangers = (0..RANGERS).map(|slot| Ranger {
            slot,
            line: RangerLine::new(),
            wires: core::mem::take(&mut wires[usize::from(HEADS + slot)]),
        });
        Ok(Self {
            heads,
            rangers: rangers.collect(),
            world: Arc::clone(&setup.world),
            car: MovingCar::new(motors, setup.seed),
            epoch_ns: None,
        })
    }

    /// Drives a line.
    ///
    /// # Errors
    ///
    /// [`Unavailable`] for a line that the board does not drive.
    pub fn set_level(&mut self, line: Line, high: bool, now_ns: u64) -> Result<(), Unavailable> {
        let instant = self.pass_until(now_ns);
        let car = self.car.pose();
        match line {
            Line::Vin(slot) => {
                let head = self.heads.get_mut(usize::from(slot)).ok_or(Unavailable)?;
                head.apply_faults(instant, now_ns);
                let Head {
                    line,
                    shaft,
                    sensor,
                    unit,
                    ..
                } = head;
                let heading = shaft.angle(now_ns);
                line.set_vin(high, now_ns, || {
                    let look = look(car, mounting(slot, HEADS), heading, instant.at);
                    unit.byte_for(sensor.sense(&look))
                });
            }
            Line::Trigger(slot) => {
                let ranger = self.rangers.get_mut(usize::from(slot)).ok_or(Unavailable)?;
                ranger.apply_faults(instant);
                let world = &self.world;
                ranger
                    .line
                    .set_trigger(high, now_ns, || Some(echo(world, car, ranger.slot)));
            }
            Line::Vout(_) | Line::Echo(_) => return Err(Unavailable),
        }
        Ok(())
    }

    /// Returns the level of a line.
    ///
    /// # Errors
    ///
    /// [`Unavailable`] for a line that the board does not read.
    pub fn level(&mut self, line: Line, now_ns: u64) -> Result<bool, Unavailable> {
        let instant = self.pass_until(now_ns);
        match line {
            Line::Vout(slot) => {
                let head = self.heads.get_mut(usize::from(slot)).ok_or(Unavailable)?;
                head.apply_faults(instant, now_ns);
                Ok(head.line.vout(now_ns))
            }
            Line::Echo(slot) => {
                let ranger = self.rangers.get_mut(usize::from(slot)).ok_or(Unavailable)?;
                ranger.apply_faults(instant);
                Ok(ranger.line.echo(now_ns))
            }
            Line::Vin(_) | Line::Trigger(_) => Err(Unavailable),
        }
    }

    /// Gives a channel pulses of `pulse_us`.
    ///
    /// # Errors
    ///
    /// [`Unavailable`] for a servo or a motor that does not exist, or whose channel has failed.
    pub fn set_pulse(
        &mut self,
        channel: Channel,
        pulse_us: u32,
        now_ns: u64,
    ) -> Result<(), Unavailable> {
        let servo = match channel {
            Channel::Servo(servo) => servo,
            Channel::Motor(motor) => {
                let Instant { at, round } = self.pass_until(now_ns);
                let is_set =
                    !self.car.is_off(motor, round, at) && self.car.set_pulse(motor, pulse_us);
                return if is_set { Ok(()) } else { Err(Unavailable) };
            }
        };
        if pulse_us > 0 {
            self.epoch_ns.get_or_insert(now_ns);
        }
        let instant = self.pass_until(now_ns);
        let head = self.heads.get_mut(usize::from(servo)).ok_or(Unavailable)?;
        head.apply_faults(instant, now_ns);
        if head.has(WireFault::ServoOff, instant) {
            return Err(Unavailable);
        }
        head.shaft.set_pulse(pulse_us, now_ns);
        Ok(())
    }

    /// Returns the true pose of the car in each round, when its heads measured.
    #[must_use]
    pub fn ground_truth(&self) -> &[GroundTruth] {
        self.car.ground_truth()
    }

    /// Moves the car up to `now_ns`, and returns that instant.
    fn pass_until(&mut self, now_ns: u64) -> Instant {
        if let Some(epoch_ns) = self.epoch_ns {
            let since_ns = now_ns.saturating_sub(epoch_ns);
            self.car.advance(&self.world, since_ns);
        }
        self.instant(now_ns)
    }

    /// The instant for windows, to the nearest millisecond since the first servo pulse.
    ///
    /// Rounding hides that backends act some microseconds after the schedule's tick, each differently.
    fn instant(&self, now_ns: u64) -> Instant {
        let since = self
            .epoch_ns
            .map_or(0, |epoch| now_ns.saturating_sub(epoch));
        let ms = (since + MILLISECOND / 2) / MILLISECOND;
        Instant {
            at: Ticks::new(ms as u32),
            round: ms / u64::from(SCHEDULE.period()),
        }
    }
}

/// An instant as windows count it.
#[derive(Debug, Clone, Copy)]
struct Instant {
    at: Ticks,
    round: u64,
}

/// The first line fault among `wires` that is active at `instant`.
fn line_fault(wires: &[(WireFault, Window)], instant: Instant) -> Option<LineFault> {
    let there = wires
        .iter()
        .filter(|(_, window)| window.contains(instant.round, instant.at));
    there
        .filter_map(|&(fault, _)| match fault {
            WireFault::Line(fault) => Some(fault),
            WireFault::ServoJammed | WireFault::ServoOff => None,
        })
        .next()
}

impl Head {
    fn has(&self, fault: WireFault, instant: Instant) -> bool {
        let mut wires = self.wires.iter();
        wires.any(|(each, window)| *each == fault && window.contains(instant.round, instant.at))
    }

    /// Applies the faults of this instant.
    fn apply_faults(&mut self, instant: Instant, now_ns: u64) {
        let fault = line_fault(&self.wires, instant);
        if fault != self.line.fault() {
            self.line.set_fault(fault, now_ns);
        }
        let jammed = self.has(WireFault::ServoJammed, instant);
        if jammed != self.shaft.is_jammed() {
            self.shaft.set_jammed(jammed, now_ns);
        }
    }
}

impl Ranger {
    fn apply_faults(&mut self, instant: Instant) {
        self.line.set_fault(line_fault(&self.wires, instant));
    }
}

/// The look, in the map frame, of a part of the car at `place` that points to `heading`.
fn look(car: Pose, mut place: Pose, heading: BinaryAngle, at: Ticks) -> Look {
    place.heading = heading;
    let pose = car.compose(place);
    Look {
        origin: pose.at,
        bearing: pose.heading,
        at,
    }
}

/// The answer of ranger `slot`: the nearest object within its cone of 30°, by rays 5° apart.
fn echo(world: &World, car: Pose, slot: u8) -> RangerAnswer {
    let place = ranger_mounting(slot);
    let farthest: Millimeters = RANGER.farthest();
    let rays = (-3..=3).filter_map(|ray| {
        let turned = BinaryAngle::from_millidegrees(ray * 5000);
        let heading = place.heading.wrapping_add(turned);
        let look = look(car, place, heading, Ticks::new(0));
        world.distance(look.origin, look.bearing, farthest)
    });
    match rays.min_by(f64::total_cmp) {
        Some(nearest) => RangerAnswer::Object {
            cm: (nearest / 10.0).round() as u16,
        },
        None => RangerAnswer::NoObject,
    }
}

fn misplaced(fault: &BenchFault, why: &'static str) -> BenchError {
    BenchError::Misplaced {
        fault: fault.to_string(),
        why,
    }
}

/// Refuses a fault that a sensor on a bench cannot have.
fn check_sensor_fault(
    spec: &FaultSpec,
    fault: &BenchFault,
    names: &[&str],
) -> Result<(), BenchError> {
    if spec.sensor.resolve(names)?.slot() >= usize::from(HEADS) {
        let why = "the rangers 4 and 5 have line faults only, such as mute:4";
        return Err(misplaced(fault, why));
    }
    if matches!(spec.fault.defect, Defect::Chatter(_)) {
        let why = "the schedule gives every sensor one turn a round, so none can chatter";
        return Err(misplaced(fault, why));
    }
    Ok(())
}

/// The devices of the Smart Car, by line and channel, on the pins of an emulated board.
///
/// Times are the board's, in nanoseconds since its reset, and never decrease.
pub trait Wires {
    /// Takes over that the board changes the level of `line` from now on.
    ///
    /// Called for changes only. Before the first one a Vin is high, by the sensor's own pull-up, and a
    /// trigger low.
    fn set_level(&mut self, line: Line, high: bool, now_ns: u64);

    /// Returns whether `line` is high.
    ///
    /// A board reads a whole port at once, so this is called for lines that the firmware does not look
    /// at. The answer must depend on the line and the time, not on how often it is called.
    fn level(&mut self, line: Line, now_ns: u64) -> bool;

    /// Takes over that `channel` gives pulses of `width_us` from now on; 0 for none.
    fn set_pulse(&mut self, channel: Channel, width_us: u32, now_ns: u64);
}

/// A device that does not exist ignores its pins, and its line reads low.
impl Wires for Bench {
    fn set_level(&mut self, line: Line, high: bool, now_ns: u64) {
        let _ = self.set_level(line, high, now_ns); // no such device
    }

    fn level(&mut self, line: Line, now_ns: u64) -> bool {
        self.level(line, now_ns).unwrap_or(false)
    }

    fn set_pulse(&mut self, channel: Channel, width_us: u32, now_ns: u64) {
        let _ = self.set_pulse(channel, width_us, now_ns); // no such device
    }
}
