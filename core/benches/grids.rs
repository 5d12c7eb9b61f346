//! How long fusion takes on a host: insertion of each grid, and walking rays.
//!
//! `cargo bench -p certainty-core`. Only ratios from one run mean anything; instructions on a Cortex-M3 are
//! counted elsewhere, under QEMU.

use certainty_core::certainty::Certainty;
use certainty_core::fusion::{
    Accumulated, BayesGrid, Beam, BeamConfig, BeamModel, CertaintyGrid, Geometry, Mapper,
    MedianGrid, Middle, Ray, RobustGrid, RobustRules, Strength, TrimmedGrid, owner_bytes,
};
use certainty_core::health::{Health, HealthRules};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Millimeters, Point, Ticks};
use divan::{Bencher, black_box, counter::ItemsCount};

/// 20 m by 20 m, cells of 10 cm.
const YARD: Geometry = Geometry::new(
    200,
    200,
    Millimeters::new(100),
    Point::from_mm(-10_000, -10_000),
);
const CELLS: usize = YARD.cells() as usize;
const SENSORS: u8 = 3;
const MODEL: BeamModel = BeamModel::new(BeamConfig::narrow(Millimeters::new(8000)));

fn main() {
    divan::main();
}

/// A scan of 361 beams over half a turn from the middle, by each sensor.
fn scans() -> Vec<(SensorId, Beam)> {
    let beams = (0..361_u32).map(|index| Beam {
        origin: Point::ORIGIN,
        bearing: BinaryAngle::from_millidegrees(500 * index as i32),
        reading: Reading::Echo(Millimeters::new(2000 + index * 37 % 6000)),
    });
    let sensors = (1..=SENSORS).filter_map(SensorId::try_new);
    sensors
        .flat_map(|sensor| beams.clone().map(move |beam| (sensor, beam)))
        .collect()
}

/// Inserts the scans again and again into one map.
fn insert(bencher: Bencher<'_, '_>, grid: impl CertaintyGrid) {
    let mut mapper: Mapper<_, [Health; SENSORS as usize]> = Mapper::new(grid, HealthRules::DEFAULT);
    let scans = scans();
    bencher
        .counter(ItemsCount::new(scans.len()))
        .bench_local(|| {
            for (sensor, beam) in &scans {
                let written = mapper.integrate(*sensor, black_box(beam), &MODEL, Ticks::new(0));
                assert!(written.is_ok());
            }
        });
    let drawn = YARD
        .iter()
        .any(|cell| mapper.grid().certainty(cell) > Certainty::UNCERTAIN);
    assert!(drawn);
}

#[divan::bench]
fn bayes(bencher: Bencher<'_, '_>) {
    let grid = BayesGrid::try_new(YARD, Strength::MEASUREMENT, vec![0; CELLS]);
    insert(bencher, grid.expect("a byte a cell"));
}

#[divan::bench]
fn robust(bencher: Bencher<'_, '_>) {
    let owners = vec![0; owner_bytes(CELLS, SENSORS)];
    let grid = RobustGrid::try_new(YARD, RobustRules::DEFAULT, SENSORS, vec![0; CELLS], owners);
    insert(bencher, grid.expect("a byte a cell, and the owners"));
}

#[divan::bench]
fn trimmed(bencher: Bencher<'_, '_>) {
    let (own, storage) = (
        Accumulated::default(),
        vec![0; CELLS * usize::from(SENSORS)],
    );
    let grid = TrimmedGrid::<_, _, 3, _>::try_new(YARD, SENSORS, 1, own, storage);
    insert(bencher, grid.expect("a byte a cell and sensor"));
}

#[divan::bench]
fn median(bencher: Bencher<'_, '_>) {
    let (own, storage) = (
        Accumulated::default(),
        vec![0; CELLS * usize::from(SENSORS)],
    );
    let grid = MedianGrid::<_, _, 3, _>::try_new(YARD, SENSORS, Middle::Higher, own, storage);
    insert(bencher, grid.expect("a byte a cell and sensor"));
}

/// Walks the rays of one scan, without a grid.
#[divan::bench]
fn rays(bencher: Bencher<'_, '_>) {
    let ends: Vec<Point> = (0..361_i32)
        .map(|index| BinaryAngle::from_millidegrees(500 * index).direction())
        .map(|direction| Point::ORIGIN.ahead(direction, Millimeters::new(8000)))
        .collect();
    bencher.counter(ItemsCount::new(ends.len())).bench(|| {
        let walk = |&end: &Point| Ray::new(&YARD, Point::ORIGIN, black_box(end));
        ends.iter()
            .flat_map(walk)
            .fold(0, |sum: usize, cell| sum.wrapping_add(cell.index()))
    });
}
