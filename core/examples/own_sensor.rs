//! A sensor of your own: from the width of its echo pulse to a map.
//!
//! There is no trait to implement. A sensor is a number, a mounting, and code that turns its raw answer into
//! a [`Reading`] which gives the reason where there is no distance.

mod draw;

use certainty_core::certainty::Certainty;
use certainty_core::fusion::{
    Area, Beam, BeamConfig, BeamModel, CertaintyGrid, Mapper, MedianArray, UnknownSensor,
};
use certainty_core::health::{Health, HealthRules};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Missing, Reading, ValidationConfig, ValidationRules, Validator};
use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose, Ticks};

const NEAREST: Millimeters = Millimeters::new(30);
const FARTHEST: Millimeters = Millimeters::new(2000);

/// A beam of 15° to each side.
const MODEL: BeamModel = BeamModel::new(BeamConfig::cone(
    FARTHEST,
    BinaryAngle::from_millidegrees(15_000),
));

/// An ultrasonic ranger: the width of its pulse is the time of flight.
struct Sonar {
    id: SensorId,
    /// Where it sits on the robot and looks.
    mounting: Pose,
    rules: ValidationRules,
    validator: Validator,
}

impl Sonar {
    /// Turns a pulse into a reading; `None` is a pulse that never came.
    fn reading(pulse_us: Option<u32>) -> Reading {
        let Some(us) = pulse_us else {
            return Reading::Missing(Missing::Timeout);
        };
        // 343 m/s, there and back: 0.1715 mm in a microsecond.
        let distance = Millimeters::new(us.saturating_mul(343) / 2000);
        if distance < NEAREST {
            Reading::TooNear
        } else if distance > FARTHEST {
            Reading::NoObject
        } else {
            Reading::Echo(distance)
        }
    }

    /// Measures: the pulse becomes a reading, the reading is checked, and the map takes it.
    fn measured<G: CertaintyGrid>(
        &mut self,
        pulse_us: Option<u32>,
        robot: Pose,
        mapper: &mut Mapper<G, [Health; 2]>,
        now: Ticks,
    ) -> Result<u32, UnknownSensor> {
        let look = robot.compose(self.mounting);
        let reading = Self::reading(pulse_us);
        let checked = self
            .validator
            .validate(&self.rules, reading, None, look.heading, now);
        let beam = Beam {
            origin: look.at,
            bearing: look.heading,
            reading: checked.reading,
        };
        mapper.integrate(self.id, &beam, &MODEL, now)
    }
}

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let config = ValidationConfig::sweeping(NEAREST, FARTHEST, 500, 1, 100);
    let rules = ValidationRules::try_new(config)?;
    let sonar = |number, y, degrees: i32| {
        let heading = BinaryAngle::from_millidegrees(degrees * 1000);
        Sonar {
            id: SensorId::new(number),
            mounting: Pose::new(Point::from_mm(100, y), heading),
            rules,
            validator: Validator::new(),
        }
    };
    let (mut left, mut right) = (sonar(1, 80, 10), sonar(2, -80, -10));

    // 20 × 16 cells of 100 mm; the robot stands in the middle of the left edge and looks along +x.
    let grid = MedianArray::<Area<20, 16, 100, 0, -800>, 2>::new(Area);
    let mut mapper: Mapper<_, [Health; 2]> = Mapper::new(grid, HealthRules::DEFAULT);
    let robot = Pose::new(Point::ORIGIN, BinaryAngle::ZERO);
    for round in 0..5 {
        let now = Ticks::new(100 * round);
        left.measured(Some(6997), robot, &mut mapper, now)?; // 1.2 m
        right.measured((round > 0).then_some(20_000), robot, &mut mapper, now)?; // beyond its range
    }

    let map = mapper.environment();
    print!("{}", draw::drawn(&map));
    let hit = Point::from_mm(1282, 288); // 1.2 m along 10° from (100, 80)
    assert_eq!(map.certainty_at(hit), Certainty::OCCUPIED);
    assert_eq!(map.certainty_at(Point::from_mm(650, -177)), Certainty::FREE);
    let missing: Vec<u32> = map.sensors().map(|(_, health)| health.missing()).collect();
    assert_eq!(
        missing,
        [0, 1],
        "the first pulse of the right one never came"
    );
    Ok(())
}
