//! The Smart Car's round: which activity runs at which millisecond.
//!
//! While the servos turn, the two ultrasonic rangers measure, one after the other, as late as possible, so
//! that their readings are recent when the car decides. Then the infrared sensors convert at the same time;
//! their heads are a third of a sweep apart, so that no sensor receives another's light. They are read and
//! fused in the order of their numbers. Then the car decides, sets its motors and reports.
//!
//! Motors take a new pulse at the end of a PWM frame of 20 ms, and frames begin with the round. The slot that
//! sets the pulse lies in the second half of a frame, so that a few microseconds of jitter change nothing.

use super::config::{HEADS, MOTOR, PERIOD_MS, RANGERS, SERVO, SWEEP};
use crate::gp2d02::CONVERSION_US;
use crate::ranger::MEASURE_US;
use certainty_core::health::HealthRules;
use certainty_core::schedule::{
    Activity::{Drive, Fuse, Measure, Move, Read, Report, Start, Steer},
    Aim, Measuring, Schedule, ScheduleConfig, Signal, Slot, Station,
};
use certainty_core::sensor::SensorId;
use certainty_core::units::BinaryAngle;

/// Slots of the round.
pub const SLOTS: usize = 19;

/// Sensors that the schedule serves: heads and rangers.
pub const STATIONS: usize = 5;

/// When the first of the infrared sensors starts to measure, in ms after the round's start; the others start
/// within the same PWM frame of the motors.
const LOOK_AT: u16 = 621;

/// When the motors are set, in ms after the round's start.
const DRIVE_AT: u16 = 772;

/// The PWM frame: the time between two pulses of a motor, in ms.
pub(super) const FRAME_MS: u16 = MOTOR.config().period_us / 1000;

/// PWM frames a round: how long one motor command stays in effect.
pub(super) const ROUND_FRAMES: u16 = PERIOD_MS / FRAME_MS;

/// PWM frames from the start of a motor command until the heads measure.
pub(super) const LOOK_FRAMES: u16 = {
    let in_frame = DRIVE_AT % FRAME_MS;
    assert!(PERIOD_MS.is_multiple_of(FRAME_MS) && FRAME_MS == 20);
    assert!(
        in_frame >= 12 && in_frame < 18,
        "too near a frame's middle or end"
    );
    let look_in_frame = (LOOK_AT + FRAME_MS / 2) % FRAME_MS;
    assert!(
        look_in_frame >= 2 && look_in_frame + 4 < 18,
        "too near where a frame counts"
    );
    // The middle of the next frame: by then its pulse has come.
    let taken_at = DRIVE_AT - in_frame + FRAME_MS + FRAME_MS / 2;
    (LOOK_AT + PERIOD_MS - taken_at) / FRAME_MS
};

/// The least angle between infrared sensors that measure at the same time.
///
/// Open choice: a GP2D02's light spot and field of view are a few degrees wide, and the bumper is narrow.
const APART: BinaryAngle = BinaryAngle::from_millidegrees(30_000);

/// How long echoes of the car's own bursts last, in ms: 7 m there and back.
const FADES_MS: u16 = 45;

const fn id(number: u8) -> SensorId {
    SensorId::new(number)
}

/// Returns µs as whole ms, rounded up.
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

/// The round, checked at compile time.
pub static SCHEDULE: Schedule<SLOTS, STATIONS> = {
    assert!(HEADS + RANGERS == 5);
    let config = ScheduleConfig {
        period: PERIOD_MS,
        stale_after: HealthRules::DEFAULT.stale_after(),
        apart: APART,
        slots: [
            Slot::new(0, 1, Move(id(1))),
            Slot::new(1, 1, Move(id(2))),
            Slot::new(2, 1, Move(id(3))),
            Slot::new(444, 60, Measure(id(4))),
            Slot::new(504, 2, Fuse(id(4))),
            Slot::new(556, 60, Measure(id(5))),
            Slot::new(616, 2, Fuse(id(5))),
            Slot::new(LOOK_AT, 2, Start(id(1))),
            Slot::new(LOOK_AT + 2, 2, Start(id(2))),
            Slot::new(LOOK_AT + 4, 2, Start(id(3))),
            Slot::new(694, 6, Read(id(1))),
            Slot::new(700, 6, Read(id(2))),
            Slot::new(706, 6, Read(id(3))),
            Slot::new(712, 3, Fuse(id(1))),
            Slot::new(715, 3, Fuse(id(2))),
            Slot::new(718, 3, Fuse(id(3))),
            Slot::new(721, 51, Steer),
            Slot::new(DRIVE_AT, 2, Drive),
            Slot::new(774, 26, Report),
        ],
        stations: [head(0), head(1), head(2), RANGER_STATION, RANGER_STATION],
    };
    Schedule::new(config)
};
