//! One faulty sensor of three is outvoted: a robust grid of 234 bytes.

mod draw;

use certainty_core::certainty::Certainty;
use certainty_core::fusion::{Area, Beam, BeamConfig, BeamModel, Mapper, RobustArray, owner_bytes};
use certainty_core::health::{Health, HealthRules};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Direction, Millimeters, Point, Ticks};

type Yard = Area<17, 11, 100, -850, 0>;
type Map = RobustArray<Yard, 3, { owner_bytes(Yard::CELLS, 3) }>;
const MODEL: BeamModel = BeamModel::new(BeamConfig::narrow(Millimeters::new(800)));

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let mut mapper: Mapper<_, [Health; 3]> = Mapper::new(Map::new(Area), HealthRules::DEFAULT);
    for degrees in (30..=150).step_by(5).cycle().take(3 * 25) {
        let bearing = BinaryAngle::from_millidegrees(degrees * 1000);
        // A wall 61 cm ahead; sensor 2 never sees an object.
        let distance = (610_u64 << Direction::FRACTION_BITS) / bearing.direction().sin() as u64;
        let wall = Reading::Echo(Millimeters::new(distance as u32));
        for (slot, reading) in [wall, Reading::NoObject, wall].into_iter().enumerate() {
            let sensor = SensorId::from_slot(slot).ok_or("too many sensors")?;
            let beam = Beam {
                origin: Point::ORIGIN,
                bearing,
                reading,
            };
            mapper.integrate(sensor, &beam, &MODEL, Ticks::new(0))?;
        }
    }
    let map = mapper.environment();
    print!("{}", draw::drawn(&map));
    for (sensor, health) in map.sensors() {
        println!(
            "sensor {sensor}: confidence {}",
            health.confidence().value()
        );
    }
    let confidences: Vec<_> = map
        .sensors()
        .map(|(_, health)| health.confidence())
        .collect();
    assert!(map.certainty_at(Point::from_mm(0, 610)) > Certainty::UNCERTAIN);
    assert!(confidences[1] < confidences[0] && confidences[1] < confidences[2]);
    Ok(())
}
