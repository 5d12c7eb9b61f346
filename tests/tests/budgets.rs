//! Sizes in bytes that the documentation states.

use certainty_core::certainty::Certainty;
use certainty_core::fusion::{
    BayesGrid, Cell, CertaintyGrid, Geometry, Latest, MedianGrid, Middle, RobustGrid, RobustRules,
    Strength, TrimmedGrid, owner_bits, owner_bytes,
};
use certainty_core::health::{Confidence, Health};
use certainty_core::sensor::SensorId;
use certainty_firmware::smart_car::{CELLS, SENSORS, SmartCarGrid, SmartCarShape};
use certainty_sim::replay::RecordedBeam;

/// \[001\] §7: 187 bytes of cells and ⌈log₂(3 + 1)⌉ · 187 / 8 = 46.75 bytes of owners.
#[test]
fn the_robust_grid_of_the_smart_car_takes_234_bytes() {
    let grid = SmartCarGrid::try_new(
        SmartCarShape,
        RobustRules::DEFAULT,
        SENSORS,
        [0; CELLS],
        [0; 47],
    );
    assert_eq!(grid.unwrap().memory_bytes(), 234);
    assert_eq!(CELLS, 17 * 11);
}

#[test]
fn every_method_takes_the_documented_bytes() {
    let shape = SmartCarShape;
    let bayes = BayesGrid::try_new(shape, Strength::UNLIMITED, [0; 187]).unwrap();
    assert_eq!(bayes.memory_bytes(), 187, "one byte a cell");
    let median =
        MedianGrid::<_, _, 3>::try_new(shape, 3, Middle::Higher, Latest, [0; 3 * 187]).unwrap();
    assert_eq!(median.memory_bytes(), 561, "a byte a cell and sensor");
    let trimmed = TrimmedGrid::<_, _, 3>::try_new(shape, 3, 1, Latest, [0; 3 * 187]).unwrap();
    assert_eq!(trimmed.memory_bytes(), 561, "a byte a cell and sensor");
}

/// Besides cells and owners a robust grid has rules, sensor count and owner width.
#[test]
fn a_constant_shape_adds_at_most_22_bytes() {
    assert_eq!(size_of::<SmartCarShape>(), 0);
    assert!(
        size_of::<SmartCarGrid>() <= 234 + 22,
        "{}",
        size_of::<SmartCarGrid>()
    );
    type Huge = RobustGrid<SmartCarShape, [u8; 10_000], [u8; 2500]>;
    let besides = size_of::<SmartCarGrid>() - 234;
    assert!(
        size_of::<Huge>() - 12_500 <= besides + 1,
        "nothing else grows"
    );
}

#[test]
fn types_have_their_documented_sizes() {
    assert_eq!(size_of::<Health>(), 32, "Memory: 32 bytes a sensor");
    assert_eq!(size_of::<RecordedBeam>(), 24, "Memory: 24 bytes a beam");
    assert_eq!(size_of::<Option<SensorId>>(), 1, "takes one byte");
    assert_eq!(size_of::<Certainty>(), 1);
    assert_eq!(size_of::<Strength>(), 2);
    assert_eq!(size_of::<Confidence>(), 2, "steps of 2^-16");
    assert_eq!(size_of::<Cell>(), 4);
    assert_eq!(size_of::<Geometry>(), 16);
}

/// \[001\] §7 in real numbers: ⌈log₂(sensors + 1)⌉ · cells / 8.
#[test]
fn owners_take_the_papers_formula() {
    for sensors in 1..=u8::MAX {
        let bits = (f64::from(sensors) + 1.0).log2().ceil();
        assert_eq!(f64::from(owner_bits(sensors)), bits, "{sensors} sensors");
        for cells in (0..=300).chain([4095, 4096, 4097, 25_000_000]) {
            let exact = f64::from(cells) * bits / 8.0;
            let bytes = owner_bytes(cells as usize, sensors) as f64;
            assert_eq!(bytes, exact.ceil(), "{cells} cells, {sensors} sensors");
        }
    }
}
