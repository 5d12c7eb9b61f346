//! A stuck sensor on its way through all levels: validation, map and health.
use certainty_core::fusion::{BayesGrid, Beam, BeamConfig, BeamModel, Geometry, Mapper, Strength};
use certainty_core::health::{Health, HealthRules, Status};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Reading, Sweep, ValidationConfig, ValidationRules, Validator};
use certainty_core::units::{BinaryAngle, Millimeters, Point, Ticks};

const DIRECTIONS: u16 = 37;
const ROUND_MS: u32 = 250;

#[test]
fn a_stuck_sensor_loses_health_and_leaves_the_map_alone() {
    let mm = Millimeters::new;
    let degrees = |d: i32| BinaryAngle::from_millidegrees(d * 1000);
    let sweep = Sweep::try_new(degrees(-90), degrees(90), DIRECTIONS).unwrap();
    let config = ValidationConfig::sweeping(mm(100), mm(800), 0, DIRECTIONS, 37 * ROUND_MS);
    let rules = ValidationRules::try_new(config).unwrap();
    let geometry = Geometry::try_new(17, 11, mm(100), Point::from_mm(-850, 0)).unwrap();
    let grid = BayesGrid::try_new(geometry, Strength::MEASUREMENT, [0_u8; 187]).unwrap();
    let mut mapper: Mapper<_, [Health; 1]> = Mapper::new(grid, HealthRules::DEFAULT);
    let model = BeamModel::try_new(BeamConfig::narrow(mm(800))).unwrap();
    let sensor = SensorId::try_new(1).unwrap();
    let mut validator = Validator::new();
    let patience = u32::from(HealthRules::SUSPECT_MISSING);
    for round in 0..u32::from(DIRECTIONS) + patience {
        let reading = Reading::Echo(mm(433)); // of the raw byte 90, in every direction
        let bearing = sweep.direction(round, 0, 1);
        let now = Ticks::new(round * ROUND_MS);
        let validated = validator.validate(&rules, reading, Some(90), bearing, now);
        let beam = Beam {
            origin: Point::ORIGIN,
            bearing: BinaryAngle::QUARTER,
            reading: validated.reading,
        };
        let cells = mapper
            .integrate(sensor, &beam, &model, Ticks::new(round + 1))
            .unwrap();
        assert_eq!(cells == 0, round >= u32::from(DIRECTIONS), "round {round}");
    }
    assert_eq!(mapper.environment().count(Status::Suspect), 1);
}
