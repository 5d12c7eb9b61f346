//! Beams drawn on a strip of cells.

use super::*;
use crate::fusion::picture::draw_beam;
use crate::transducer::Missing;
use fixed::types::U0F16;
use proptest::prelude::*;

const fn mm(mm: u32) -> Millimeters {
    Millimeters::new(mm)
}

fn strip() -> Geometry {
    Geometry::try_new(12, 1, mm(100), Point::ORIGIN).unwrap()
}

fn beam(reading: Reading) -> Beam {
    Beam {
        origin: Point::from_mm(50, 50),
        bearing: BinaryAngle::ZERO,
        reading,
    }
}

fn drawn(reading: Reading, config: BeamConfig) -> String {
    draw_beam(
        &strip(),
        &beam(reading),
        &BeamModel::try_new(config).unwrap(),
    )
    .concat()
}

#[test]
fn free_before_occupied_at_and_uncertain_behind_the_echo() {
    let exact = BeamConfig::narrow(mm(800));
    assert_eq!(drawn(Reading::Echo(mm(400)), exact), "....#????   ");
    let silent = BeamConfig {
        behind: Behind::Untouched,
        ..exact
    };
    assert_eq!(drawn(Reading::Echo(mm(400)), silent), "....#       ");
}

#[test]
fn the_occupied_spread_follows_the_accuracy_and_fades_both_ways() {
    // A quarter of 800 mm is two cells to each side: the nearer ones half a spread away, the
    // outer ones at its end, where it says nothing and what lies behind is uncertain.
    let vague = BeamConfig {
        accuracy: U0F16::lit("0.25"),
        ..BeamConfig::narrow(mm(1100))
    };
    assert_eq!(drawn(Reading::Echo(mm(800)), vague), "...... +#+??");
    // At 300 mm it begins inside the cell before the echo's, which so is not left free.
    assert_eq!(drawn(Reading::Echo(mm(300)), vague), ".. #????????");
}

/// PEERS: nav2 dropped a range above the maximum, so that *no echo* never cleared, and made an
/// obstacle of a range at the maximum.
#[test]
fn no_object_frees_up_to_the_range_and_marks_nothing() {
    let exact = BeamConfig::narrow(mm(800));
    assert_eq!(drawn(Reading::NoObject, exact), ".........   ");
}

#[test]
fn an_echo_at_the_very_range_is_an_obstacle_there() {
    let exact = BeamConfig::narrow(mm(800));
    assert_eq!(drawn(Reading::Echo(mm(800)), exact), "........#   ");
}

#[test]
fn what_says_nothing_tells_no_cell() {
    for reading in [Reading::TooNear, Reading::Missing(Missing::Timeout)] {
        let exact = BeamConfig::narrow(mm(800));
        assert_eq!(drawn(reading, exact), " ".repeat(12), "{reading:?}");
    }
}

#[test]
fn an_echo_outside_the_grid_frees_what_is_inside() {
    let exact = BeamConfig::narrow(mm(90_000));
    assert_eq!(drawn(Reading::Echo(mm(70_000)), exact), "............");
}

#[test]
fn an_echo_before_the_grid_makes_the_grid_uncertain() {
    let beam = Beam {
        origin: Point::from_mm(-2000, 50),
        ..beam(Reading::Echo(mm(1000)))
    };
    let model = BeamModel::try_new(BeamConfig::narrow(mm(2650))).unwrap();
    assert_eq!(draw_beam(&strip(), &beam, &model).concat(), "???????     ");
}

#[test]
fn what_cannot_be_is_refused() {
    let base = BeamConfig::narrow(mm(800));
    let refused = |config| BeamModel::try_new(config).unwrap_err();
    let endless = BeamConfig {
        farthest: mm(u32::MAX),
        ..base
    };
    assert_eq!(refused(endless), BeamError::Range);
    assert_eq!(refused(BeamConfig::narrow(mm(0))), BeamError::Range);
    let flat = BeamConfig {
        half_width: BinaryAngle::QUARTER,
        ..base
    };
    assert_eq!(refused(flat), BeamError::Width);
    let clear = BeamConfig {
        half_clear: BinaryAngle::from_bits(1),
        ..base
    };
    assert_eq!(refused(clear), BeamError::Width);
    let upside_down = BeamConfig {
        free: Certainty::OCCUPIED,
        ..base
    };
    assert_eq!(refused(upside_down), BeamError::Certainties);
}

proptest! {
    #[test]
    fn every_echo_inside_the_grid_is_drawn_at_its_place_and_nothing_twice(
        x in -2000..2000_i32, y in -2000..2000_i32, bearing: u16, distance in 0..=2500_u32,
        accuracy: u16, width in 0..0x3000_u16,
    ) {
        let geometry = Geometry::try_new(20, 20, mm(97), Point::from_mm(-900, -900)).unwrap();
        let beam = Beam {
            origin: Point::from_mm(x, y),
            bearing: BinaryAngle::from_bits(bearing),
            reading: Reading::Echo(mm(distance)),
        };
        let narrow = BeamConfig {
            accuracy: U0F16::from_bits(accuracy / 4),
            ..BeamConfig::narrow(mm(2500))
        };
        let model = BeamModel::try_new(narrow).unwrap();
        let mut told = vec![None; geometry.cells() as usize];
        beam.interpret(&geometry, &model, &mut |cell: Cell, certainty: Certainty| {
            assert_eq!(told[cell.index()].replace(certainty), None);
        });
        let hit = geometry.cell_at(beam.origin.ahead(beam.bearing.direction(), mm(distance)));
        if let Some(hit) = hit {
            prop_assert_eq!(told[hit.index()], Some(Certainty::OCCUPIED));
        }
        let cone = BeamConfig {
            accuracy: narrow.accuracy,
            ..BeamConfig::cone(mm(2500), BinaryAngle::from_bits(width))
        };
        let model = BeamModel::try_new(cone).unwrap();
        let mut told = vec![None; geometry.cells() as usize];
        beam.interpret(&geometry, &model, &mut |cell: Cell, certainty: Certainty| {
            assert_eq!(told[cell.index()].replace(certainty), None);
        });
        if let Some(hit) = hit {
            prop_assert_eq!(told[hit.index()], Some(Certainty::OCCUPIED), "cone");
        }
    }
}

#[test]
fn an_echo_at_or_near_the_range_keeps_its_spread_whatever_lies_behind() {
    let vague = |behind| BeamConfig {
        accuracy: U0F16::lit("0.25"),
        behind,
        ..BeamConfig::narrow(mm(800))
    };
    let silent = drawn(Reading::Echo(mm(800)), vague(Behind::Untouched));
    assert_eq!(silent, "...... +#+  ");
    // Where the spread has faded away, uncertain is what is left to say.
    let told = drawn(Reading::Echo(mm(800)), vague(Behind::Uncertain));
    assert_eq!(told, "...... +#+? ");
}

#[test]
fn an_echo_from_beyond_the_range_is_no_object_within_it() {
    let exact = BeamConfig::narrow(mm(800));
    let free = drawn(Reading::NoObject, exact);
    for distance in [801, 5000, u32::MAX] {
        assert_eq!(drawn(Reading::Echo(mm(distance)), exact), free);
    }
}
