//! Defects that were found in comparable systems: this one is tested not to have them.
//!
//! Every fusion method is tested, with both ways in which the layered ones keep a sensor's own grid.

use certainty_core::certainty::Certainty;
use certainty_core::fusion::{BayesGrid, Beam, BeamConfig, BeamModel, Geometry, Mapper, Strength};
use certainty_core::health::{Health, HealthRules, Status};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Missing, Reading};
use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose, Ticks};
use certainty_firmware::smart_car;
use certainty_sim::export::{CellState, MapImage, OutDir, write_ros_map};
use certainty_sim::fusion::{FusionRules, HostMapper, Method, Own};
use certainty_sim::replay::{HEADER, LoadOptions, load};
use core::time::Duration;
use std::fs;
use std::time::Instant;

const FARTHEST: Millimeters = Millimeters::new(3000);
const TIMEOUT: Reading = Reading::Missing(Missing::Timeout);

/// 40 by 40 cells of 10 cm, the map's origin in the middle.
fn square() -> Geometry {
    Geometry::try_new(40, 40, Millimeters::new(100), Point::from_mm(-2000, -2000)).unwrap()
}

/// Every method, and both ways for those that keep the sensors apart.
///
/// The trimmed one drops one certainty at each end: with the most that it can it answers only where every sensor
/// of an odd number saw the cell.
fn methods() -> impl Iterator<Item = (Method, FusionRules)> {
    let rules = [Own::Latest, Own::Accumulated].map(|own| FusionRules {
        own,
        trim: Some(1),
        ..FusionRules::default()
    });
    let all = Method::ALL.into_iter();
    all.flat_map(move |method| rules.map(|rules| (method, rules)))
}

fn sensor(number: u8) -> SensorId {
    SensorId::try_new(number).unwrap()
}

fn narrow() -> BeamModel {
    BeamModel::try_new(BeamConfig::narrow(FARTHEST)).unwrap()
}

fn degrees(degrees: i32) -> BinaryAngle {
    BinaryAngle::from_millidegrees(degrees * 1000)
}

/// A beam along +x from the middle of the map.
fn ahead(reading: Reading) -> Beam {
    Beam {
        origin: Point::ORIGIN,
        bearing: BinaryAngle::ZERO,
        reading,
    }
}

const fn echo(mm: u32) -> Reading {
    Reading::Echo(Millimeters::new(mm))
}

fn take(map: &mut HostMapper, number: u8, reading: Reading, now: u32) -> u32 {
    let beam = ahead(reading);
    map.integrate(sensor(number), &beam, &narrow(), Ticks::new(now))
        .unwrap()
}

fn state_at(map: &HostMapper, x_mm: i32, y_mm: i32) -> CellState {
    let cell = map.geometry().cell_at(Point::from_mm(x_mm, y_mm)).unwrap();
    CellState::of(map.cells()[cell.index()])
}

fn status(map: &HostMapper, number: u8) -> Status {
    map.health()[usize::from(number) - 1].1.status()
}

/// nav2: a cell driven to 0 stays 0 after 1,000 occupied readings.
#[test]
fn defect_1_a_saturated_cell_recovers_in_twelve_rounds() {
    for (method, rules) in methods() {
        for (before, after, expected) in [
            (Reading::NoObject, echo(1050), CellState::Occupied),
            (echo(1050), Reading::NoObject, CellState::Free),
        ] {
            let mut map = HostMapper::new(method, &rules, square(), 3);
            for round in 0..1000 {
                for number in 1..=3 {
                    take(&mut map, number, before, round);
                }
            }
            let driven = state_at(&map, 1050, 50);
            assert!(
                driven.is_known() && driven != expected,
                "{method} {rules:?}"
            );
            // 127 steps of log-odds from the bound to even, and 23 on to free, 14 a reading: eleven
            // rounds of one sensor.
            for round in 0..12 {
                for number in 1..=3 {
                    take(&mut map, number, after, 1000 + round);
                }
            }
            assert_eq!(state_at(&map, 1050, 50), expected, "{method} {rules:?}");
        }
    }
}

/// nav2 drops `range > max`, so "no echo" never clears.
#[test]
fn defect_2_no_object_clears_up_to_the_range() {
    for (method, rules) in methods() {
        let mut map = HostMapper::new(method, &rules, square(), 3);
        for round in 0..10 {
            (1..=3).for_each(|number| _ = take(&mut map, number, echo(1050), round));
        }
        assert_eq!(state_at(&map, 1050, 0), CellState::Occupied);
        for round in 10..22 {
            (1..=3).for_each(|number| _ = take(&mut map, number, Reading::NoObject, round));
        }
        for x_mm in (50..2000).step_by(100) {
            assert_eq!(
                state_at(&map, x_mm, 0),
                CellState::Free,
                "{method} at {x_mm}"
            );
        }
    }
}

/// nav2: `range == max` marks an obstacle.
#[test]
fn defect_2_a_recorded_reading_at_the_largest_range_is_no_object() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("readings.csv");
    let lines = "0,1,0,0,0,2999\n1,1,0,0,0,3000\n2,1,0,0,0,3001\n";
    fs::write(&file, format!("{HEADER}\n{lines}")).unwrap();
    let options = LoadOptions {
        max_range: Some(FARTHEST),
        ..LoadOptions::default()
    };
    let recording = load(&file, &options, &mut |_, _| {}).unwrap();
    let readings: Vec<Reading> = recording.beams.iter().map(|beam| beam.reading).collect();
    assert_eq!(readings, [echo(2999), Reading::NoObject, Reading::NoObject]);
}

/// Neither is a distance: nothing is known of any cell.
#[test]
fn defect_2_too_near_and_missing_leave_the_map_as_it_is() {
    for (method, rules) in methods() {
        let mut map = HostMapper::new(method, &rules, square(), 3);
        (1..=3).for_each(|number| _ = take(&mut map, number, echo(1050), 0));
        let before = map.cells();
        for reading in [
            Reading::TooNear,
            TIMEOUT,
            Reading::Missing(Missing::Bus),
            Reading::Missing(Missing::Implausible),
        ] {
            for number in 1..=3 {
                assert_eq!(take(&mut map, number, reading, 1), 0, "{reading:?}");
            }
            assert_eq!(map.cells(), before, "{method} {rules:?} {reading:?}");
        }
    }
}

/// nav2's timeout is shared: one live sensor hides a dead one.
#[test]
fn defect_3_a_silent_sensor_fails_alone_and_recovers() {
    let patience = HealthRules::DEFAULT.stale_after();
    for (method, rules) in methods() {
        let mut map = HostMapper::new(method, &rules, square(), 3);
        for number in 1..=3 {
            take(&mut map, number, echo(1050), 0);
        }
        // Sensor 2 sends nothing, not even a missing reading.
        for now in (100..=patience).step_by(100) {
            take(&mut map, 1, echo(1050), now);
            take(&mut map, 3, echo(1050), now);
            assert_eq!(status(&map, 2), Status::Healthy, "{method} at {now}");
        }
        let now = patience + 1;
        take(&mut map, 1, echo(1050), now);
        let health = map.health();
        assert!(health[1].1.is_stale(), "{method}");
        assert!(
            !health[0].1.is_stale() && !health[2].1.is_stale(),
            "{method}"
        );
        let statuses = [1, 2, 3].map(|number| status(&map, number));
        let expected = [Status::Healthy, Status::Failed, Status::Healthy];
        assert_eq!(statuses, expected, "{method}");
        // It sends again, and is healthy after some readings.
        let received = u32::from(HealthRules::HEALTHY_RECEIVED);
        for reading in 1..received {
            take(&mut map, 2, echo(1050), now + reading);
            assert_eq!(status(&map, 2), Status::Recovering, "{method}");
        }
        take(&mut map, 2, echo(1050), now + received);
        assert_eq!(status(&map, 2), Status::Healthy, "{method}");
    }
}

/// When all sensors stop sending, no reading comes that would settle their status.
#[test]
fn defect_3_all_silent_sensors_fail_without_a_reading() {
    let grid = BayesGrid::try_new(
        square(),
        Strength::MEASUREMENT,
        vec![0; square().cells() as usize],
    );
    let rules = HealthRules::DEFAULT;
    let mut mapper: Mapper<_, [Health; 3]> = Mapper::new(grid.unwrap(), rules);
    let patience = rules.stale_after();
    mapper.settle(Ticks::new(0));
    mapper.settle(Ticks::new(patience));
    assert_eq!(mapper.environment().count(Status::Healthy), 3);
    mapper.settle(Ticks::new(patience + 1));
    assert_eq!(mapper.environment().count(Status::Failed), 3);
}

/// `ArduPilot` #25913 and #5659: a dead sensor stopped everything, or went unnoticed.
#[test]
fn defect_4_a_dead_sensor_is_failed_and_mapping_goes_on() {
    for (method, rules) in methods() {
        // Four live sensors: the trimmed grid answers only where 2t + 1 saw a cell.
        let mut map = HostMapper::new(method, &rules, square(), 5);
        for round in 0..10 {
            for number in [1, 2, 4, 5] {
                assert!(take(&mut map, number, echo(1050), round) > 0);
            }
            assert_eq!(take(&mut map, 3, TIMEOUT, round), 0);
        }
        let statuses = [1, 2, 3, 4, 5].map(|number| status(&map, number));
        let (live, dead) = (Status::Healthy, Status::Failed);
        assert_eq!(
            statuses,
            [live, live, dead, live, live],
            "{method} {rules:?}"
        );
        assert_eq!(map.health()[2].1.missing(), 10);
        assert_eq!(
            state_at(&map, 1050, 0),
            CellState::Occupied,
            "{method} {rules:?}"
        );
        assert_eq!(
            state_at(&map, 550, 0),
            CellState::Free,
            "{method} {rules:?}"
        );
    }
}

/// nav2: a cone that left the grid on the negative side wrapped into a huge loop.
#[test]
fn defect_5_beams_and_cones_end_at_the_grids_border() {
    let start = Instant::now();
    let far = Millimeters::new(Point::LIMIT.unsigned_abs());
    let cone = BeamModel::try_new(BeamConfig::cone(FARTHEST, degrees(15))).unwrap();
    let endless = BeamModel::try_new(BeamConfig::narrow(far)).unwrap();
    let mut map = HostMapper::new(Method::Bayes, &FusionRules::default(), square(), 1);
    let limit = Point::LIMIT;
    let origins = [
        (-1999, -1999),
        (1999, 1999),
        (-2001, 0),
        (0, -2500),
        (-limit, -limit),
        (limit, -limit),
        (i32::MIN, i32::MAX),
    ];
    for (x, y) in origins {
        for bits in (0..=u16::MAX).step_by(64) {
            for (model, reading) in [
                (&cone, Reading::NoObject),
                (&cone, echo(2900)),
                (&endless, Reading::NoObject),
                (&endless, echo(far.get())),
                (&narrow(), echo(u32::MAX)),
            ] {
                let beam = Beam {
                    origin: Point::from_mm(x, y),
                    bearing: BinaryAngle::from_bits(bits),
                    reading,
                };
                let written = map
                    .integrate(sensor(1), &beam, model, Ticks::new(0))
                    .unwrap();
                assert!(written <= 1600, "{written} cells written by {beam:?}");
                let outwards = x == -1999 && (0x8000..=0xC000).contains(&bits);
                if outwards && model != &cone {
                    assert_eq!(written, 1, "from the lower left corner: {beam:?}");
                }
            }
        }
    }
    assert!(
        start.elapsed() < Duration::from_secs(20),
        "{:?}",
        start.elapsed()
    );
}

/// What is drawn at the far end must not appear on the opposite side.
#[test]
fn defect_5_cones_at_opposite_borders_are_mirror_images() {
    let cone = BeamModel::try_new(BeamConfig::cone(FARTHEST, degrees(15))).unwrap();
    let drawn = |y_mm: i32, bearing: i32| {
        let mut map = HostMapper::new(Method::Bayes, &FusionRules::default(), square(), 1);
        let beam = Beam {
            // Through the middle of a column.
            origin: Point::from_mm(50, y_mm),
            bearing: degrees(bearing),
            reading: echo(1000),
        };
        let written = map
            .integrate(sensor(1), &beam, &cone, Ticks::new(0))
            .unwrap();
        let known: Vec<u32> = map
            .geometry()
            .iter()
            .zip(map.cells())
            .filter(|(_, certainty)| *certainty != Certainty::UNCERTAIN)
            .map(|(cell, _)| u32::from(map.geometry().column_and_row(cell).1))
            .collect();
        (
            written,
            known.iter().min().copied(),
            known.iter().max().copied(),
        )
    };
    // Half of each cone is outside: it starts 50 cm from the border, its echo is 1 m away.
    let (below, lowest, highest) = drawn(-1500, 270);
    assert!(below > 0);
    assert_eq!((lowest, highest), (Some(0), Some(4)), "the rows below it");
    let (above, lowest, highest) = drawn(1499, 90);
    assert_eq!(above, below);
    assert_eq!((lowest, highest), (Some(35), Some(39)), "the rows above it");
}

/// MRPT's `CObservationRange` inserted two sonars at 0° and 90° along the same direction.
#[test]
fn defect_6_sensors_draw_in_their_own_directions() {
    let mountings = [
        Pose::new(Point::from_mm(100, 0), BinaryAngle::ZERO),
        Pose::new(Point::from_mm(0, 100), BinaryAngle::QUARTER),
    ];
    // The robot's pose, and where an echo at 1 m of each sensor lies then, worked out by hand.
    let cases = [
        (
            Pose::new(Point::from_mm(50, 50), BinaryAngle::ZERO),
            [(1150, 50), (50, 1150)],
        ),
        (
            Pose::new(Point::from_mm(50, 50), BinaryAngle::QUARTER),
            [(50, 1150), (-1050, 50)],
        ),
        (
            Pose::new(Point::from_mm(50, 50), BinaryAngle::HALF),
            [(-1050, 50), (50, -1050)],
        ),
    ];
    for (method, rules) in methods() {
        for (robot, places) in cases {
            let mut map = HostMapper::new(method, &rules, square(), 6);
            // Three sensors at each mounting: the trimmed grid answers only where 2t + 1 saw a cell.
            for (number, mounting) in (1..).zip([0, 0, 0, 1, 1, 1].map(|i: usize| mountings[i])) {
                let look = robot.compose(mounting);
                let beam = Beam {
                    origin: look.at,
                    bearing: look.heading,
                    reading: echo(1000),
                };
                map.integrate(sensor(number), &beam, &narrow(), Ticks::new(0))
                    .unwrap();
            }
            let geometry = map.geometry();
            let drawn: Vec<_> = geometry
                .iter()
                .zip(map.cells())
                .filter(|&(_, certainty)| CellState::of(certainty) == CellState::Occupied)
                .map(|(cell, _)| cell)
                .collect();
            let mut expected = places.map(|(x, y)| geometry.cell_at(Point::from_mm(x, y)).unwrap());
            expected.sort_unstable();
            assert_eq!(drawn, expected, "{method} {rules:?} from {robot:?}");
        }
    }
}

/// The same of the Smart Car: its heads start at different phases and places.
#[test]
fn defect_6_no_two_heads_of_the_smart_car_look_the_same_way() {
    for step in 0..u32::from(smart_car::SWEEP.directions()) {
        let looks = [0, 1, 2].map(|slot| smart_car::look(slot, 3, step));
        for (a, b) in [(0, 1), (0, 2), (1, 2)] {
            assert_ne!(looks[a].heading, looks[b].heading, "step {step}");
            assert_ne!(looks[a].at, looks[b].at, "step {step}");
        }
        // All look into the grid, which lies on the car's left half plane along +x.
        for look in looks {
            assert!(look.heading <= BinaryAngle::HALF, "{look:?}");
        }
    }
}

/// `free_thresh: 0.25` turns unknown (205) into free in two loaders.
#[test]
fn defect_7_unknown_stays_unknown_to_every_loader() {
    let folder = tempfile::tempdir().unwrap();
    let out = OutDir::create(folder.path()).unwrap();
    let cells = [Certainty::FREE, Certainty::UNCERTAIN, Certainty::OCCUPIED];
    let map = MapImage::try_new(3, 1, &cells, 100, Point::ORIGIN).unwrap();
    let files = write_ros_map(&out, "map", &map).unwrap();
    let yaml = fs::read_to_string(files.yaml).unwrap();
    assert!(yaml.contains("\nfree_thresh: 0.196\n"), "{yaml}");
    assert!(yaml.contains("\noccupied_thresh: 0.65\n"), "{yaml}");
    assert!(yaml.contains("\nnegate: 0\n"), "{yaml}");
    let image = fs::read(files.pgm).unwrap();
    let (width, height, pixels) = certainty_tests::pgm::pgm(&image);
    assert_eq!((width, height), (3, 1));
    assert_eq!(pixels, [254, 205, 0]);
    // Strictly between the thresholds, so inclusive and exclusive loaders agree.
    let darkness = |pixel: u8| f64::from(255 - pixel) / 255.0;
    assert!(darkness(254) < 0.196 && darkness(0) > 0.65);
    assert!(0.196 < darkness(205) && darkness(205) < 0.65);
    assert!(darkness(205) < 0.25, "which is why 0.25 would be wrong");
}
