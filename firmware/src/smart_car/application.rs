//! The Smart Car's application: the activities of its round.

use super::config::{
    CELLS, HEADS, PERIOD_MS, RANGER, RANGER_VALIDATION, RANGERS, SENSORS, SERVO, SWEEP,
    SmartCarGrid, SmartCarShape, UNITS, Unit, VALIDATION, beam_model, mounting,
};
use super::control::RangerInput;
use super::drive::Drive;
use crate::board::{Board, HeadWires, MotorWires, RangerWires, ResetCause, Wiring};
use crate::executive::{Application, Due, Timeliness};
use crate::gp2d02::Gp2d02;
use crate::ranger::Ranger;
use crate::remote::{
    Channel, Line, Link, RemoteBoard, RemoteOutbox, RemotePin, RemotePwm, RemoteTime,
};
use crate::servo::Servo;
use crate::telemetry::{self, Hello, Report, Reporter, SensorHealth, Statistics};
use certainty_core::fusion::{Beam, Mapper, RobustRules, Shape, owner_bytes};
#[cfg(feature = "defmt")]
use certainty_core::health::Status;
use certainty_core::health::{Health, HealthRules};
use certainty_core::schedule::Activity;
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Finding, Missing, Reading, Validator};
use certainty_core::units::{BinaryAngle, Pose, Ticks};
use core::fmt;
use embedded_hal::delay::DelayNs;
use fixed::types::U0F16;

/// One in this many generations of the reported map is a keyframe; a generation is a round.
const KEYFRAME_EVERY: u16 = 20;

/// The most parts of the map in a round's report: enough for the whole map.
const PARTS: u8 = 8;

/// A pivoted infrared sensor: servo, GP2D02, calibration and validation.
///
/// Each round it is aimed, started and read. An error on the way becomes the reason of the missing reading.
struct Head<B: Board> {
    servo: Servo<B::Pwm>,
    sensor: Gp2d02<B::Vin, B::Vout>,
    unit: &'static Unit,
    validator: Validator,
    direction: BinaryAngle,
    error: Option<Missing>,
    reading: Reading,
    finding: Finding,
}

impl<B: Board> Head<B> {
    /// Creates a head with the calibration and accuracy of `unit`.
    fn new(wires: HeadWires<B>, unit: &'static Unit) -> Self {
        Self {
            servo: Servo::new(wires.pwm, SERVO),
            sensor: Gp2d02::new(wires.vin, wires.vout),
            unit,
            validator: Validator::new(),
            direction: BinaryAngle::ZERO,
            error: Some(Missing::Late),
            reading: Reading::Missing(Missing::Late),
            finding: Finding::Missing,
        }
    }

    /// Turns to `direction`, in the frame of its mounting.
    fn aim(&mut self, direction: BinaryAngle) {
        self.direction = direction;
        // If the servo failed, the direction is unknown and so the reading is missing.
        self.error = self.servo.aim(direction).err().map(|error| error.reason());
    }

    /// Starts a conversion.
    fn start(&mut self, delay: &mut impl DelayNs) {
        if self.error.is_none() {
            self.error = self.sensor.start(delay).err().map(|fault| fault.reason());
        }
    }

    /// Reads the result of the conversion and validates it; `heading` is the car's in the map.
    // Not inlined: otherwise its stack adds to that of the deepest slot.
    #[inline(never)]
    fn read(&mut self, delay: &mut impl DelayNs, now: Ticks, heading: BinaryAngle) {
        let raw = match self.error {
            None => self.sensor.read(delay).map_err(|fault| fault.reason()),
            Some(error) => Err(error),
        };
        let reading = match raw {
            Ok(raw) => self.unit.calibration.reading(raw),
            Err(why) => Reading::Missing(why),
        };
        let raw = raw.ok().map(u16::from);
        let bearing = heading + self.direction;
        let validated = (self.validator).validate(&VALIDATION, reading, raw, bearing, now);
        self.reading = validated.reading;
        self.finding = validated.finding;
    }

    /// Notes that one of its slots was skipped.
    fn note_skipped_slot(&mut self) {
        self.error = Some(Missing::Late);
        self.reading = Reading::Missing(Missing::Late);
        self.finding = Finding::Missing;
    }
}

/// The car: drivers, map and health records, on any [`Board`].
///
/// Sensors 1 to 3 are the pivoted ones, whose readings are fused into the map. Sensors 4 and 5 are the fixed
/// rangers, whose readings go directly to the control level. Data flows one way: driver, reading, validation,
/// map, control, motors, report.
#[expect(
    missing_debug_implementations,
    reason = "a board's pins need not be printable"
)]
pub struct SmartCar<B: Board> {
    heads: [Head<B>; HEADS as usize],
    rangers: [FixedRanger<B>; RANGERS as usize],
    mapper: CarMapper,
    drive: Drive<B>,
    delay: B::Delay,
    stopwatch: B::Stopwatch,
    reporter: Reporter<B::Outbox, CELLS>,
    /// The status of each sensor when it was last logged.
    #[cfg(feature = "defmt")]
    logged: [Status; (HEADS + RANGERS) as usize],
}

/// A fixed ranger with its last reading and its health.
struct FixedRanger<B: Board> {
    driver: Ranger<B::Trigger, B::Echo>,
    validator: Validator,
    reading: Reading,
    measured: Ticks,
    health: Health,
}

impl<B: Board> FixedRanger<B> {
    /// Measures and validates; `heading` is the car's in the map.
    // Not inlined: otherwise its stack adds to that of the deepest slot.
    #[inline(never)]
    fn measure(
        &mut self,
        delay: &mut B::Delay,
        stopwatch: &mut B::Stopwatch,
        now: Ticks,
        heading: BinaryAngle,
    ) {
        let measured = self.driver.measure(delay, stopwatch);
        self.measured = now;
        let reading = measured.unwrap_or_else(|fault| Reading::Missing(fault.reason()));
        let rules = &RANGER_VALIDATION;
        let validated = (self.validator).validate(rules, reading, None, heading, now);
        self.reading = validated.reading;
    }
}

/// The grid or its reporter refused its configuration; a test shows that this does not happen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct InitError;

impl fmt::Display for InitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the configuration of the grid or its reporter is invalid")
    }
}

impl core::error::Error for InitError {}

/// A sensor of the car.
enum Station<'a, B: Board> {
    Head(&'a mut Head<B>),
    Ranger(&'a mut FixedRanger<B>),
}

/// The fusion level of the car.
type CarMapper = Mapper<SmartCarGrid, [Health; SENSORS as usize]>;

/// Adds a head's beam to the map.
///
/// The model is made here, so that the compiler sees a narrow beam and leaves the code of wide ones out.
fn integrate(mapper: &mut CarMapper, sensor: SensorId, beam: &Beam, accuracy: U0F16, now: Ticks) {
    // Cannot fail: the mapper was created for all heads.
    let _ = mapper.integrate(sensor, beam, &beam_model(accuracy), now);
}

impl<B: Board> SmartCar<B> {
    /// Creates the car, stopped and with an empty map.
    ///
    /// # Errors
    ///
    /// [`InitError`], which would be a defect: it does not depend on `wiring`.
    // Not inlined: otherwise its temporaries stay on the stack of the main loop.
    #[inline(never)]
    pub fn try_new(
        wiring: Wiring<B, { HEADS as usize }, { RANGERS as usize }>,
    ) -> Result<Self, InitError> {
        let rules = RobustRules::DEFAULT;
        let owners = [0; owner_bytes(CELLS, SENSORS)];
        let grid = SmartCarGrid::try_new(SmartCarShape, rules, SENSORS, [0; CELLS], owners);
        let mapper = Mapper::new(grid.map_err(|_| InitError)?, HealthRules::DEFAULT);
        let hello = Hello {
            geometry: SmartCarShape.geometry(),
            sensors: HEADS,
            rangers: RANGERS,
            round_ms: PERIOD_MS.into(),
        };
        let reporter = Reporter::try_new(wiring.outbox, hello, KEYFRAME_EVERY);
        let [first, second, third] = wiring.heads;
        let [one, two, three] = &UNITS;
        Ok(Self {
            heads: [
                Head::new(first, one),
                Head::new(second, two),
                Head::new(third, three),
            ],
            rangers: wiring.rangers.map(|wires| FixedRanger {
                driver: Ranger::new(wires.trigger, wires.echo, RANGER),
                validator: Validator::new(),
                reading: Reading::Missing(Missing::Late),
                measured: Ticks::new(0),
                health: Health::default(),
            }),
            mapper,
            drive: Drive::new(wiring.motors, wiring.reset_cause),
            delay: wiring.delay,
            stopwatch: wiring.stopwatch,
            reporter: reporter.map_err(|_| InitError)?,
            #[cfg(feature = "defmt")]
            logged: [Health::default().status(); (HEADS + RANGERS) as usize],
        })
    }

    /// Returns the last reading of `sensor`; `None` if the car has no such sensor.
    #[cfg(feature = "defmt")]
    fn reading(&self, sensor: SensorId) -> Option<Reading> {
        let slot = sensor.slot();
        match slot.checked_sub(HEADS.into()) {
            None => self.heads.get(slot).map(|head| head.reading),
            Some(ranger) => self.rangers.get(ranger).map(|ranger| ranger.reading),
        }
    }

    fn station(&mut self, sensor: SensorId) -> Option<Station<'_, B>> {
        let slot = sensor.slot();
        match slot.checked_sub(HEADS.into()) {
            None => self.heads.get_mut(slot).map(Station::Head),
            Some(ranger) => self.rangers.get_mut(ranger).map(Station::Ranger),
        }
    }

    /// Returns the origin and direction of the beam of head `slot` in the map.
    fn look(&self, slot: u8, head: &Head<B>) -> Pose {
        let mut place = mounting(slot, HEADS);
        place.heading = head.direction;
        self.drive.looks_from().compose(place)
    }

    fn fuse(&mut self, sensor: SensorId, now: Ticks) {
        let slot = sensor.slot();
        match slot.checked_sub(HEADS.into()) {
            None => {
                let Some(head) = self.heads.get(slot) else {
                    return;
                };
                let look = self.look(sensor.number().saturating_sub(1), head);
                let beam = Beam {
                    origin: look.at,
                    bearing: look.heading,
                    reading: head.reading,
                };
                integrate(&mut self.mapper, sensor, &beam, head.unit.accuracy, now);
            }
            Some(slot) => {
                if let Some(ranger) = self.rangers.get_mut(slot) {
                    ranger.health.record(ranger.reading, now);
                    ranger.health.settle(&HealthRules::DEFAULT, now);
                }
            }
        }
    }

    /// Decides the next motor command, from the map and the rangers' readings.
    fn steer(&mut self, due: Due) {
        let rangers = self.rangers.each_ref().map(|ranger| RangerInput {
            reading: ranger.reading,
            measured: ranger.measured,
            health: &ranger.health,
        });
        let missing = |head: &Head<B>| matches!(head.reading, Reading::Missing(_));
        let missing = self.heads.each_ref().map(missing);
        self.drive
            .steer(due, &self.mapper.environment(), &missing, &rangers);
    }

    /// Logs the sensors whose status has changed since the last call.
    #[cfg(feature = "defmt")]
    fn log_status_changes(&mut self) {
        let map = self.mapper.environment();
        let heads = map.sensors().map(|(_, health)| health);
        let rangers = self.rangers.iter().map(|ranger| &ranger.health);
        let numbered = (1_u8..).zip(heads.chain(rangers));
        for ((number, health), logged) in numbered.zip(&mut self.logged) {
            if health.status() != *logged {
                *logged = health.status();
                defmt::info!("sensor {}: status {}", number, *logged);
            }
        }
    }

    /// Reports the round: readings, drive, map, health, and statistics last.
    // Not inlined: otherwise its frames are on the stack in the other slots.
    #[inline(never)]
    fn report(&mut self, now: Ticks, timeliness: Timeliness) {
        let numbers = (1..=u8::MAX).filter_map(SensorId::try_new);
        for (sensor, head) in numbers.clone().zip(&self.heads) {
            self.reporter.send(&Report::Head(telemetry::Head {
                sensor,
                direction: head.direction,
                reading: head.reading,
                finding: head.finding,
            }));
        }
        for (number, ranger) in (1..=RANGERS).zip(&self.rangers) {
            self.reporter.send(&Report::Ranger(telemetry::Ranger {
                number,
                reading: ranger.reading,
            }));
        }
        self.reporter.send(&Report::Drive(self.drive.report()));
        let map = self.mapper.environment();
        self.reporter.send_map(&map, PARTS);
        self.reporter.send_health(&map);
        let rangers = numbers.skip(HEADS.into()).zip(&self.rangers);
        for (sensor, ranger) in rangers {
            let health = SensorHealth::new(sensor, &ranger.health);
            self.reporter.send(&Report::Health(health));
        }
        let unsent = self.reporter.unsent();
        self.reporter.send(&Report::Statistics(Statistics {
            // The report is the round's last slot and completes it.
            round: timeliness.rounds.saturating_add(1),
            tick: now,
            overruns: timeliness.overruns,
            unsent,
        }));
    }
}

impl<B: Board> Application for SmartCar<B> {
    fn perform(&mut self, activity: Activity, due: Due, timeliness: Timeliness) {
        match activity {
            Activity::Move(sensor) => {
                let slot = u16::from(sensor.number().saturating_sub(1));
                if let Some(Station::Head(head)) = self.station(sensor) {
                    head.aim(SWEEP.direction(due.round, slot, HEADS.into()));
                }
            }
            Activity::Start(sensor) => {
                if let Some(head) = self.heads.get_mut(sensor.slot()) {
                    head.start(&mut self.delay);
                }
            }
            Activity::Read(sensor) => {
                let heading = self.drive.looks_from().heading;
                if let Some(head) = self.heads.get_mut(sensor.slot()) {
                    head.read(&mut self.delay, due.at, heading);
                }
            }
            Activity::Measure(sensor) => {
                let slot = sensor.slot().wrapping_sub(HEADS.into());
                let heading = self.drive.looks_from().heading;
                if let Some(ranger) = self.rangers.get_mut(slot) {
                    ranger.measure(&mut self.delay, &mut self.stopwatch, due.at, heading);
                }
            }
            Activity::Fuse(sensor) => self.fuse(sensor, due.at),
            Activity::Steer => {
                self.mapper.settle(due.at);
                self.steer(due);
            }
            Activity::Drive => self.drive.drive(),
            Activity::Report => {
                self.mapper.settle(due.at);
                #[cfg(feature = "defmt")]
                self.log_status_changes();
                self.report(due.at, timeliness);
            }
        }
        #[cfg(feature = "defmt")]
        if let Activity::Read(sensor) | Activity::Measure(sensor) = activity
            && let Some(Reading::Missing(reason)) = self.reading(sensor)
        {
            defmt::warn!("sensor {}: no reading: {}", sensor.number(), reason);
        }
    }

    fn skip(&mut self, activity: Activity, due: Due) {
        // The control level misses an input, so it stands for this round.
        self.drive.note_skipped_slot();
        match activity {
            Activity::Move(sensor)
            | Activity::Start(sensor)
            | Activity::Read(sensor)
            | Activity::Measure(sensor) => match self.station(sensor) {
                Some(Station::Head(head)) => head.note_skipped_slot(),
                Some(Station::Ranger(ranger)) => ranger.reading = Reading::Missing(Missing::Late),
                None => {}
            },
            // The reading is not fused late; its absence is recorded in the sensor's health.
            Activity::Fuse(sensor) => {
                match self.station(sensor) {
                    Some(Station::Head(head)) => head.note_skipped_slot(),
                    Some(Station::Ranger(ranger)) => {
                        ranger.reading = Reading::Missing(Missing::Late);
                    }
                    None => {}
                }
                self.fuse(sensor, due.at);
            }
            // Late, but the motors must not continue with the previous decision.
            Activity::Drive => self.drive.drive_late(),
            Activity::Steer | Activity::Report => {}
        }
    }
}

/// Returns the wiring of a car whose pins, pulses and time are at the far end of `link`, after a manual reset.
pub fn remote_wiring<L: Link>(
    link: &L,
) -> Wiring<RemoteBoard<'_, L>, { HEADS as usize }, { RANGERS as usize }> {
    let head = |slot| HeadWires {
        vin: RemotePin::new(link, Line::Vin(slot)),
        vout: RemotePin::new(link, Line::Vout(slot)),
        pwm: RemotePwm::new(link, Channel::Servo(slot)),
    };
    let ranger = |slot| RangerWires {
        trigger: RemotePin::new(link, Line::Trigger(slot)),
        echo: RemotePin::new(link, Line::Echo(slot)),
    };
    Wiring {
        heads: [head(0), head(1), head(2)],
        rangers: [ranger(0), ranger(1)],
        motors: MotorWires {
            right: RemotePwm::new(link, Channel::Motor(0)),
            left: RemotePwm::new(link, Channel::Motor(1)),
        },
        delay: RemoteTime::new(link),
        stopwatch: RemoteTime::new(link),
        outbox: RemoteOutbox::new(link),
        reset_cause: ResetCause::Manual,
    }
}
