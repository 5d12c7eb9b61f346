//! A grid in a `static`, as a microcontroller has it: all zeros, so that it takes RAM and no flash.
//!
//! On a microcontroller `Mutex` is that of the crate `critical-section`, or the grid is in a
//! `ConstStaticCell` of the crate `static_cell`; here it is the standard library's.

mod draw;

use certainty_core::certainty::Certainty;
use certainty_core::fusion::{
    Beam, BeamConfig, BeamModel, CellArray, FixedShape, Geometry, Mapper, RobustArray, owner_bytes,
};
use certainty_core::health::{Health, HealthRules};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Millimeters, Point, Ticks};
use std::sync::Mutex;

/// The robot's grid: 17 by 11 cells of 10 cm in front of it.
struct Front;

impl FixedShape for Front {
    const GEOMETRY: Geometry =
        Geometry::new(17, 11, Millimeters::new(100), Point::from_mm(-850, 0));
    type Cells<const LAYERS: usize> = CellArray<17, 11, LAYERS>;
}

const SENSORS: u8 = 3;
const OWNERS: usize = owner_bytes(Front::GEOMETRY.cells() as usize, SENSORS);

static GRID: Mutex<RobustArray<Front, SENSORS, OWNERS>> = Mutex::new(RobustArray::new(Front));

fn main() -> Result<(), Box<dyn core::error::Error>> {
    const MODEL: BeamModel = BeamModel::new(BeamConfig::narrow(Millimeters::new(800)));
    let mut grid = GRID.lock()?;
    assert_eq!(size_of_val(&*grid), 187 + 47);

    // The mapper borrows the grid.
    let mut mapper: Mapper<_, [Health; SENSORS as usize]> =
        Mapper::new(&mut *grid, HealthRules::DEFAULT);
    for degrees in (45..=135).step_by(5) {
        for number in 1..=SENSORS {
            let beam = Beam {
                origin: Point::ORIGIN,
                bearing: BinaryAngle::from_millidegrees(degrees * 1000),
                reading: Reading::Echo(Millimeters::new(700)),
            };
            let sensor = SensorId::try_new(number).ok_or("sensors count from 1")?;
            mapper.integrate(sensor, &beam, &MODEL, Ticks::new(0))?;
        }
    }
    print!("{}", draw::drawn(&mapper.environment()));
    let ahead = Point::from_mm(0, 700);
    assert_eq!(
        mapper.environment().certainty_at(ahead),
        Certainty::OCCUPIED
    );

    // The robot was carried elsewhere: the map is void, the sensors' health is not.
    mapper.clear();
    assert_eq!(
        mapper.environment().certainty_at(ahead),
        Certainty::UNCERTAIN
    );
    assert!(
        mapper
            .environment()
            .sensors()
            .all(|(_, health)| health.confirmations() > 0)
    );
    Ok(())
}
