//! A robot with four fixed time-of-flight sensors that drives along a wall.
//!
//! The sensors look forward, left, backward and right. The schedule sets when each measures and when its
//! reading is fused; a round that breaks a rule does not compile.

mod draw;

use certainty_core::certainty::Certainty;
use certainty_core::fusion::{Accumulated, Area, Beam, BeamConfig, BeamModel, Mapper, MedianArray};
use certainty_core::health::{Health, HealthRules, Status};
use certainty_core::schedule::{
    Activity::{Fuse, Measure},
    Aim, Measuring, Schedule, ScheduleConfig, Signal, Slot, Station,
};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Missing, Reading};
use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose, Ticks};

const SENSORS: usize = 4;
const FARTHEST: Millimeters = Millimeters::new(1200);
const MODEL: BeamModel = BeamModel::new(BeamConfig::narrow(FARTHEST));

/// 30 × 12 cells of 100 mm, the lower left corner at (-200, -600) mm.
type Corridor = Area<30, 12, 100, -200, -600>;

/// The direction of a sensor as seen from the robot: a quarter turn left of the one before.
const fn aim(slot: u16) -> BinaryAngle {
    BinaryAngle::from_bits(slot.wrapping_mul(BinaryAngle::QUARTER.to_bits()))
}

const fn station(slot: u16) -> Station {
    Station {
        signal: Signal::Light,
        aim: Aim::Fixed(aim(slot)),
        measuring: Measuring::Whole { longest: 20 },
        fades: 0,
    }
}

/// Every 100 ms each sensor measures for 20 ms, one after the other, and all readings are fused.
const ROUND: Schedule<8, SENSORS> = Schedule::new(ScheduleConfig {
    period: 100,
    stale_after: 2000,
    apart: BinaryAngle::from_millidegrees(60_000),
    slots: [
        Slot::new(0, 20, Measure(SensorId::new(1))),
        Slot::new(20, 20, Measure(SensorId::new(2))),
        Slot::new(40, 20, Measure(SensorId::new(3))),
        Slot::new(60, 20, Measure(SensorId::new(4))),
        Slot::new(80, 2, Fuse(SensorId::new(1))),
        Slot::new(82, 2, Fuse(SensorId::new(2))),
        Slot::new(84, 2, Fuse(SensorId::new(3))),
        Slot::new(86, 2, Fuse(SensorId::new(4))),
    ],
    stations: [station(0), station(1), station(2), station(3)],
});

/// The world: walls at y = 450 mm and x = 2450 mm. The sensor to the right is unplugged.
fn measured(slot: usize, robot: Pose) -> Reading {
    let distance = match slot {
        0 => 2450_i32.saturating_sub(robot.at.x_mm()),
        1 => 450_i32.saturating_sub(robot.at.y_mm()),
        2 => return Reading::NoObject,
        _ => return Reading::Missing(Missing::Timeout),
    };
    match u32::try_from(distance).map(Millimeters::new) {
        Ok(distance) if distance <= FARTHEST => Reading::Echo(distance),
        _ => Reading::NoObject,
    }
}

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let grid = MedianArray::<Corridor, SENSORS, Accumulated>::new(Area);
    let mut mapper: Mapper<_, [Health; SENSORS]> = Mapper::new(grid, HealthRules::DEFAULT);
    let mut readings = [Reading::Missing(Missing::Late); SENSORS];
    for now in 0..4000_u32 {
        // 0.5 m/s along +x.
        let robot = Pose::new(Point::from_mm((now / 2) as i32, 0), BinaryAngle::ZERO);
        let tick = now % u32::from(ROUND.period());
        let due = ROUND.slots().iter().find(|slot| u32::from(slot.at) == tick);
        match due.map(|slot| slot.activity) {
            Some(Measure(sensor)) => readings[sensor.slot()] = measured(sensor.slot(), robot),
            Some(Fuse(sensor)) => {
                let own = Pose::new(Point::ORIGIN, aim(sensor.slot() as u16));
                let look = robot.compose(own);
                let beam = Beam {
                    origin: look.at,
                    bearing: look.heading,
                    reading: readings[sensor.slot()],
                };
                mapper.integrate(sensor, &beam, &MODEL, Ticks::new(now))?;
            }
            _ => {}
        }
    }
    let map = mapper.environment();
    print!("{}", draw::drawn(&map));
    for (sensor, health) in map.sensors() {
        println!("sensor {sensor}: {:?}", health.status());
    }
    assert!(map.certainty_at(Point::from_mm(1000, 450)) > Certainty::from_bits(200));
    assert!(map.certainty_at(Point::from_mm(2450, 0)) > Certainty::from_bits(200));
    assert!(map.certainty_at(Point::from_mm(1000, 0)) < Certainty::UNCERTAIN);
    let statuses: Vec<Status> = map.sensors().map(|(_, health)| health.status()).collect();
    assert_eq!(statuses[3], Status::Failed, "the unplugged sensor");
    assert_eq!(statuses[..3], [Status::Healthy; 3]);
    Ok(())
}
