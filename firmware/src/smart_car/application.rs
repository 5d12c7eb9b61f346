//! The Smart Car's application: what is done in each slot of its round.

use super::drive::{Drive, RangerInput};
use super::head::Head;
use super::round::PERIOD_MS;
use super::{
    CELLS, HEADS, RANGER, RANGERS, SENSORS, SWEEP, SmartCarGrid, SmartCarShape, UNITS, mounting,
};
use crate::board::{Board, Wiring};
use crate::executive::{Application, Due, Timeliness};
use crate::ranger::Ranger;
use crate::telemetry::{self, Hello, Report, Reporter, SensorHealth, Statistics};
use certainty_core::fusion::{Beam, Mapper, RobustRules, Shape, owner_bytes};
use certainty_core::health::{Health, HealthRules};
use certainty_core::schedule::Activity;
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Missing, Reading};
use certainty_core::units::{Pose, Ticks};
use core::fmt;

/// One generation of the reported map in so many is whole; a generation is a round.
const KEYFRAME_EVERY: u16 = 20;

/// Parts of the map that a round reports at most: all of it.
const PARTS: u8 = 8;

/// The car: drivers, map and records, on any [`Board`].
///
/// Sensors 1 to 3 are the pivoted ones, which make the map; 4 and 5 the fixed rangers, whose readings
/// control hears beside the map, and whose silence is noticed. Data flows one way: a driver's answer
/// becomes a reading, the reading is checked and fused, the map says where to go, and what came of it is
/// reported.
#[expect(
    missing_debug_implementations,
    reason = "a board's pins need not be printable"
)]
pub struct SmartCar<B: Board> {
    heads: [Head<B>; HEADS as usize],
    rangers: [FixedRanger<B>; RANGERS as usize],
    mapper: Mapper<SmartCarGrid, [Health; SENSORS as usize]>,
    drive: Drive<B>,
    delay: B::Delay,
    stopwatch: B::Stopwatch,
    reporter: Reporter<B::Outbox, CELLS>,
}

/// A ranger with its record.
struct FixedRanger<B: Board> {
    driver: Ranger<B::Trigger, B::Echo>,
    reading: Reading,
    measured: Ticks,
    health: Health,
}

impl<B: Board> FixedRanger<B> {
    // Not inlined: the stack of the main loop is under that of the deepest slot.
    #[inline(never)]
    fn measure(&mut self, delay: &mut B::Delay, stopwatch: &mut B::Stopwatch, now: Ticks) {
        let measured = self.driver.measure(delay, stopwatch);
        self.measured = now;
        self.reading = measured.unwrap_or_else(|fault| Reading::Missing(fault.reason()));
    }
}

/// The car's parts do not fit each other; they always do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct InitError;

impl fmt::Display for InitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the grid or its report was refused")
    }
}

impl core::error::Error for InitError {}

/// Whose turn it is.
enum Station<'a, B: Board> {
    Head(&'a mut Head<B>),
    Ranger(&'a mut FixedRanger<B>),
}

impl<B: Board> SmartCar<B> {
    /// Creates the car, at rest and with an empty map.
    ///
    /// # Errors
    ///
    /// [`InitError`], which would be a defect here: nothing depends on the outside.
    // Not inlined: its temporaries would stay on the stack of whoever runs the car for ever.
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
                reading: Reading::Missing(Missing::Late),
                measured: Ticks::new(0),
                health: Health::default(),
            }),
            mapper,
            drive: Drive::new(wiring.motors, wiring.start),
            delay: wiring.delay,
            stopwatch: wiring.stopwatch,
            reporter: reporter.map_err(|_| InitError)?,
        })
    }

    /// Returns what `sensor` said last, where the car has it.
    #[must_use]
    pub fn reading(&self, sensor: SensorId) -> Option<Reading> {
        let slot = sensor.slot();
        match slot.checked_sub(HEADS.into()) {
            None => self.heads.get(slot).map(Head::reading),
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

    /// Where head `slot` looks from, and which way, in the map.
    fn look(&self, slot: u8, head: &Head<B>) -> Pose {
        let mut place = mounting(slot, HEADS);
        place.heading = head.direction();
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
                    reading: head.reading(),
                };
                // The mapper was made for all heads.
                let _told = self.mapper.integrate(sensor, &beam, head.model(), now);
            }
            Some(slot) => {
                if let Some(ranger) = self.rangers.get_mut(slot) {
                    ranger.health.record(ranger.reading, now);
                    ranger.health.settle(&HealthRules::DEFAULT, now);
                }
            }
        }
    }

    /// Decides where to go, from the map and from what the rangers said.
    fn steer(&mut self, due: Due) {
        let eyes = self.rangers.each_ref().map(|ranger| RangerInput {
            reading: ranger.reading,
            measured: ranger.measured,
            health: &ranger.health,
        });
        let silent = |head: &Head<B>| matches!(head.reading(), Reading::Missing(_));
        let silent = self.heads.each_ref().map(silent);
        self.drive
            .steer(due, &self.mapper.environment(), &silent, &eyes);
    }

    /// Reports the round: what each sensor said, how the car drives, the map, the records, and last how it
    /// went.
    // Not inlined: what it sends must not be on the stack of the other slots.
    #[inline(never)]
    fn report(&mut self, now: Ticks, timeliness: Timeliness) {
        let numbers = (1..=u8::MAX).filter_map(SensorId::try_new);
        for (sensor, head) in numbers.clone().zip(&self.heads) {
            self.reporter.send(&Report::Head(telemetry::Head {
                sensor,
                direction: head.direction(),
                reading: head.reading(),
                finding: head.finding(),
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
            // The report is the round's last slot: with it the round is complete.
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
                if let Some(head) = self.heads.get_mut(sensor.slot()) {
                    head.read(&mut self.delay, due.at);
                }
            }
            Activity::Measure(sensor) => {
                let slot = sensor.slot().wrapping_sub(HEADS.into());
                if let Some(ranger) = self.rangers.get_mut(slot) {
                    ranger.measure(&mut self.delay, &mut self.stopwatch, due.at);
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
                self.report(due.at, timeliness);
            }
        }
    }

    fn skip(&mut self, activity: Activity, due: Due) {
        // Whatever it was, the car knows less than it should.
        self.drive.falter();
        match activity {
            Activity::Move(sensor)
            | Activity::Start(sensor)
            | Activity::Read(sensor)
            | Activity::Measure(sensor) => match self.station(sensor) {
                Some(Station::Head(head)) => head.miss(),
                Some(Station::Ranger(ranger)) => ranger.reading = Reading::Missing(Missing::Late),
                None => {}
            },
            // What was read is not fused late; that nothing was fused is on the record.
            Activity::Fuse(sensor) => {
                match self.station(sensor) {
                    Some(Station::Head(head)) => head.miss(),
                    Some(Station::Ranger(ranger)) => {
                        ranger.reading = Reading::Missing(Missing::Late);
                    }
                    None => {}
                }
                self.fuse(sensor, due.at);
            }
            // Late, but the motors must not go on with what was decided a round ago.
            Activity::Drive => self.drive.drive_late(),
            Activity::Steer | Activity::Report => {}
        }
    }
}
