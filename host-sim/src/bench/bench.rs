//! The Smart Car's devices on one bench: what is on the other side of the board's pins.

use super::fault::{BenchFault, WireFault};
use super::{
    Gp2d02Line, LineFault, MILLISECOND, MovingCar, RangerAnswer, RangerLine, ServoShaft, Stage,
};
use crate::experiment::SensorSet;
use crate::fault::{Defect, FaultSpec, Faulty, SpecError, Window, assign};
use crate::transducer::{Gp2d02Unit, Look, Sensor, SimulatedGp2d02};
use crate::world::World;
use certainty_core::sensor::SensorId;
use certainty_core::units::{BinaryAngle, Millimeters, Pose, Ticks};
use certainty_firmware::remote::{Channel, Line};
use certainty_firmware::smart_car::{
    HEADS, RANGER, RANGERS, SCHEDULE, SERVO, STATIONS, mounting, ranger_mounting,
};
use std::sync::Arc;
use thiserror::Error;

/// What stands on the bench.
#[derive(Debug, Clone)]
pub struct BenchSetup {
    /// What stands around the car.
    pub world: Arc<World>,
    /// The errors of its infrared sensors; those beyond the car's heads have no place.
    pub crew: SensorSet,
    /// What is wrong with sensors, wires and motors.
    pub faults: Vec<BenchFault>,
    /// Names the run: the same seed gives the same bytes.
    pub seed: u64,
}

/// A bench that cannot be set up.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum BenchError {
    /// A fault of a sensor that is not there.
    #[error(transparent)]
    Fault(#[from] SpecError),
    /// A fault that the sensor cannot have.
    #[error("{fault}: {why}")]
    Misplaced {
        /// The fault.
        fault: String,
        /// What it takes.
        why: &'static str,
    },
}

/// There is no such line or channel, or it is broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("no such line or channel, or it is broken")]
pub struct Broken;

/// The Smart Car's simulated devices, wired to a world.
///
/// Everything is a function of the levels that were set and of the time, in nanoseconds that never
/// go back. Time zero of windows is the first servo pulse, which is the schedule's: so a board may
/// boot as long as it likes. The sensors measure from where the motors have driven the car.
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
    /// [`BenchError`] for a fault of a sensor that is not there, or that it cannot have.
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
        let crew = setup.crew.members().iter().zip(Gp2d02Unit::shipped());
        let heads = (0..HEADS).zip(crew).filter_map(|(slot, (member, unit))| {
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
            car: MovingCar::with_faults(motors, setup.seed),
            epoch_ns: None,
        })
    }

    /// Drives a line.
    ///
    /// # Errors
    ///
    /// [`Broken`] for a line that the board does not drive.
    pub fn set_level(&mut self, line: Line, high: bool, now_ns: u64) -> Result<(), Broken> {
        let instant = self.pass_until(now_ns);
        let car = self.car.pose();
        match line {
            Line::Vin(slot) => {
                let head = self.heads.get_mut(usize::from(slot)).ok_or(Broken)?;
                head.settle_faults(instant, now_ns);
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
                let ranger = self.rangers.get_mut(usize::from(slot)).ok_or(Broken)?;
                ranger.settle_faults(instant);
                let world = &self.world;
                ranger
                    .line
                    .set_trigger(high, now_ns, || Some(echo(world, car, ranger.slot)));
            }
            Line::Vout(_) | Line::Echo(_) => return Err(Broken),
        }
        Ok(())
    }

    /// Returns the level of a line.
    ///
    /// # Errors
    ///
    /// [`Broken`] for a line that the board does not listen to.
    pub fn level(&mut self, line: Line, now_ns: u64) -> Result<bool, Broken> {
        let instant = self.pass_until(now_ns);
        match line {
            Line::Vout(slot) => {
                let head = self.heads.get_mut(usize::from(slot)).ok_or(Broken)?;
                head.settle_faults(instant, now_ns);
                Ok(head.line.vout(now_ns))
            }
            Line::Echo(slot) => {
                let ranger = self.rangers.get_mut(usize::from(slot)).ok_or(Broken)?;
                ranger.settle_faults(instant);
                Ok(ranger.line.echo(now_ns))
            }
            Line::Vin(_) | Line::Trigger(_) => Err(Broken),
        }
    }

    /// Gives a channel pulses of so many microseconds.
    ///
    /// # Errors
    ///
    /// [`Broken`] for a servo or a motor that is not there, or whose channel has failed.
    pub fn set_pulse(
        &mut self,
        channel: Channel,
        pulse_us: u32,
        now_ns: u64,
    ) -> Result<(), Broken> {
        let servo = match channel {
            Channel::Servo(servo) => servo,
            Channel::Motor(motor) => {
                let Instant { at, round } = self.pass_until(now_ns);
                let hears =
                    !self.car.is_off(motor, round, at) && self.car.set_pulse(motor, pulse_us);
                return if hears { Ok(()) } else { Err(Broken) };
            }
        };
        if pulse_us > 0 {
            self.epoch_ns.get_or_insert(now_ns);
        }
        let instant = self.pass_until(now_ns);
        let head = self.heads.get_mut(usize::from(servo)).ok_or(Broken)?;
        head.settle_faults(instant, now_ns);
        if head.has(WireFault::ServoOff, instant) {
            return Err(Broken);
        }
        head.shaft.set_pulse(pulse_us, now_ns);
        Ok(())
    }

    /// Returns where the car was when its heads looked, a round after the other.
    #[must_use]
    pub fn stages(&self) -> &[Stage] {
        self.car.stages()
    }

    /// Lets the car move until now, and says when that is.
    fn pass_until(&mut self, now_ns: u64) -> Instant {
        if let Some(epoch_ns) = self.epoch_ns {
            let since_ns = now_ns.saturating_sub(epoch_ns);
            self.car.advance(&self.world, since_ns);
        }
        self.instant(now_ns)
    }

    /// When it is, for windows: to the nearest millisecond since the first servo pulse.
    ///
    /// A board does what the schedule says some microseconds after its tick; each a little different.
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

/// An instant as windows know it.
#[derive(Debug, Clone, Copy)]
struct Instant {
    at: Ticks,
    round: u64,
}

/// The line fault among `wires` that is there at `instant`: the first one written.
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

    /// Lets faults come and go.
    fn settle_faults(&mut self, instant: Instant, now_ns: u64) {
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
    fn settle_faults(&mut self, instant: Instant) {
        self.line.set_fault(line_fault(&self.wires, instant));
    }
}

/// Where a part of the car looks from, and which way, in the map.
fn look(car: Pose, mut place: Pose, heading: BinaryAngle, at: Ticks) -> Look {
    place.heading = heading;
    let pose = car.compose(place);
    Look {
        origin: pose.at,
        bearing: pose.heading,
        at,
    }
}

/// What ranger `slot` hears: the nearest object within its cone of 30°, by rays 5° apart.
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

/// Refuses what a sensor on a bench cannot have.
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
