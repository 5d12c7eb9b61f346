//! The Smart Car's round: who does what at which millisecond.
//!
//! While the servos turn, the two ultrasonic rangers measure, one after the other. Then the infrared
//! sensors convert all at once: their heads are a third of a sweep apart, so that none sees another's
//! light. They are read and fused in the order of their numbers, and the round ends with a report.

use super::{HEADS, RANGERS, SERVO, SWEEP};
use crate::gp2d02::CONVERSION_US;
use crate::ranger::MEASURE_US;
use certainty_core::health::HealthRules;
use certainty_core::schedule::{
    Activity::{Fuse, Measure, Move, Read, Report, Start},
    Aim, Measuring, Schedule, ScheduleConfig, Signal, Slot, Station,
};
use certainty_core::sensor::SensorId;
use certainty_core::units::BinaryAngle;

/// Slots of the round.
pub const SLOTS: usize = 17;

/// Sensors that the schedule serves: heads and rangers.
pub const STATIONS: usize = 5;

/// How long a round takes, in ms.
pub(super) const PERIOD_MS: u16 = 800;

/// Infrared sensors that measure at the same time look at least this far apart.
///
/// Open choice: a GP2D02's spot and its lens's view are a few degrees wide, the bumper is narrow.
const APART: BinaryAngle = BinaryAngle::from_millidegrees(30_000);

/// How long an echo of the car's own sound may linger, in ms: 7 m there and back.
const FADES_MS: u16 = 45;

#[expect(clippy::panic, reason = "a constant that panics does not build")]
const fn id(number: u8) -> SensorId {
    match SensorId::new(number) {
        Some(id) => id,
        None => panic!("sensors count from 1"),
    }
}

/// µs as whole ms, rounded up.
const fn whole_ms(micros: u32) -> u16 {
    let ms = micros.div_ceil(1000);
    assert!(ms < 1000, "longer than any slot");
    (ms & 0xFFFF) as u16
}

const fn head(slot: u8) -> Station {
    Station {
        signal: Signal::Light,
        aim: Aim::Sweeping {
            sweep: SWEEP,
            slot: slot as u16,
            heads: HEADS as u16,
            settle: whole_ms(SERVO.worst_settling_ms().saturating_mul(1000)),
        },
        measuring: Measuring::Apart {
            conversion: whole_ms(CONVERSION_US),
        },
        fades: 0,
    }
}

const RANGER_STATION: Station = Station {
    signal: Signal::Sound,
    aim: Aim::Fixed(BinaryAngle::ZERO),
    measuring: Measuring::Whole {
        longest: whole_ms(MEASURE_US),
    },
    fades: FADES_MS,
};

/// The round, checked when the program is built.
pub static SCHEDULE: Schedule<SLOTS, STATIONS> = {
    assert!(HEADS + RANGERS == 5);
    let config = ScheduleConfig {
        period: PERIOD_MS,
        stale_after: HealthRules::DEFAULT.config().stale_after,
        apart: APART,
        slots: [
            Slot::new(0, 1, Move(id(1))),
            Slot::new(1, 1, Move(id(2))),
            Slot::new(2, 1, Move(id(3))),
            Slot::new(10, 60, Measure(id(4))),
            Slot::new(70, 2, Fuse(id(4))),
            Slot::new(150, 60, Measure(id(5))),
            Slot::new(210, 2, Fuse(id(5))),
            Slot::new(630, 2, Start(id(1))),
            Slot::new(632, 2, Start(id(2))),
            Slot::new(634, 2, Start(id(3))),
            Slot::new(710, 6, Read(id(1))),
            Slot::new(716, 6, Read(id(2))),
            Slot::new(722, 6, Read(id(3))),
            Slot::new(728, 6, Fuse(id(1))),
            Slot::new(734, 6, Fuse(id(2))),
            Slot::new(740, 6, Fuse(id(3))),
            Slot::new(746, 54, Report),
        ],
        stations: [head(0), head(1), head(2), RANGER_STATION, RANGER_STATION],
    };
    match Schedule::try_new(config) {
        Ok(schedule) => schedule,
        Err(error) => panic!("{}", error.reason()),
    }
};
