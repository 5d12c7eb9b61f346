//! Claims about the simulated GP2D02; the rates with fixed seeds and bounds on both sides.

use super::*;
use crate::world::Obstacle;
use certainty_core::units::{BinaryAngle, Point, Ticks};

const LOOK: Look = Look {
    origin: Point::ORIGIN,
    bearing: BinaryAngle::QUARTER,
    at: Ticks::new(0),
};

const READINGS: u32 = 20_000;

fn id(number: u8) -> SensorId {
    SensorId::try_new(number).unwrap()
}

/// A wall across the way, its face `away` millimetres from where the beam starts.
fn wall(away: i32) -> Arc<World> {
    let y = away + 10;
    let wall = Obstacle::wall(
        Point::from_mm(-900, y),
        Point::from_mm(900, y),
        Millimeters::new(20),
    );
    Arc::new(World::new("wall", vec![wall.unwrap()]))
}

fn open() -> Arc<World> {
    Arc::new(World::new("open", vec![]))
}

fn readings(world: &Arc<World>, unit: &Gp2d02Unit, model: SensorModel) -> Vec<Reading> {
    let mut sensor = SimulatedGp2d02::new(Arc::clone(world), unit.clone(), model, 11, id(1));
    (0..READINGS).map(|_| sensor.sense(&LOOK)).collect()
}

fn share(readings: &[Reading], wanted: fn(&Reading) -> bool) -> f64 {
    readings.iter().filter(|r| wanted(r)).count() as f64 / readings.len() as f64
}

fn echoes(readings: &[Reading]) -> Vec<f64> {
    readings
        .iter()
        .filter_map(|r| match r {
            Reading::Echo(distance) => Some(f64::from(distance.get())),
            _ => None,
        })
        .collect()
}

/// The relative error's standard deviation and mean at `away` mm, averaged over all units.
///
/// One unit's tabulated curve is locally steeper or flatter than its fit; sixteen are less so.
fn scatter(model: SensorModel, away: i32) -> (f64, f64) {
    let units = Gp2d02Unit::shipped();
    let (mut deviation, mut offset) = (0.0, 0.0);
    for unit in units {
        let truth = f64::from(away) - 0.5;
        let errors: Vec<f64> = echoes(&readings(&wall(away), unit, model))
            .iter()
            .map(|mm| mm / truth - 1.0)
            .collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let squares: f64 = errors.iter().map(|e| (e - mean).powi(2)).sum();
        deviation += (squares / errors.len() as f64).sqrt() / units.len() as f64;
        offset += mean / units.len() as f64;
    }
    (deviation, offset)
}

/// Four standard deviations of a rate's estimate.
fn four_sigma(rate: f64) -> f64 {
    4.0 * (rate * (1.0 - rate) / f64::from(READINGS)).sqrt()
}

#[test]
fn no_object_is_missed_as_often_as_table_1_says() {
    for (letter, model) in SensorModel::TABLE_1 {
        for unit in [0, 5, 8] {
            let all = readings(&open(), &Gp2d02Unit::shipped()[unit], model);
            let failed = share(&all, |r| matches!(r, Reading::Echo(_)));
            let rate = model.p_failed_inf();
            assert!(
                (failed - rate).abs() < four_sigma(rate),
                "{letter}, unit {unit}: {failed}"
            );
            let silent = share(&all, |r| matches!(r, Reading::NoObject));
            assert!((failed + silent - 1.0).abs() < 1e-9, "nothing else is said");
        }
    }
}

#[test]
fn an_object_is_missed_as_often_as_table_1_says_at_every_distance() {
    for (letter, model) in SensorModel::TABLE_1 {
        for away in [200, 400, 799] {
            let all = readings(&wall(away), &Gp2d02Unit::shipped()[0], model);
            let missed = share(&all, |r| matches!(r, Reading::NoObject));
            let rate = model.p_false_inf();
            assert!(
                (missed - rate).abs() < four_sigma(rate),
                "{letter} at {away} mm: {missed}"
            );
        }
    }
}

#[test]
fn distances_scatter_as_table_1_says() {
    for (letter, model) in SensorModel::TABLE_1 {
        for away in [200, 300] {
            let (deviation, offset) = scatter(model, away);
            // Rounding to a byte adds 0.8 %, in squares.
            let ratio = deviation / model.accuracy().hypot(0.008);
            assert!((ratio - 1.0).abs() < 0.04, "{letter} at {away}: {ratio}");
            assert!(offset.abs() < 0.015, "{letter} at {away}: off by {offset}");
        }
    }
}

#[test]
fn distances_scatter_more_where_the_real_units_have_a_kink() {
    // From 36 to 44 cm many of the tabulated units fall more steeply than their fits.
    for (letter, model) in SensorModel::TABLE_1 {
        let ratio = scatter(model, 400).0 / model.accuracy().hypot(0.008);
        assert!((1.05..1.30).contains(&ratio), "{letter}: {ratio}");
    }
}

#[test]
fn false_distances_come_from_the_far_half_of_the_range() {
    let all = echoes(&readings(
        &open(),
        &Gp2d02Unit::shipped()[12],
        SensorModel::D,
    ));
    let (least, most) = all
        .iter()
        .fold((f64::MAX, 0.0_f64), |(l, m), &d| (l.min(d), m.max(d)));
    // The range is 100 to 800; one count is 35 mm at its far end.
    assert!((430.0..=470.0).contains(&least), "{least}");
    assert!((760.0..=800.0).contains(&most), "{most}");
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    assert!((610.0..=640.0).contains(&mean), "{mean}");
}

#[test]
fn a_flawless_model_still_has_the_units_own_misfit_and_byte() {
    let unit = &Gp2d02Unit::shipped()[4];
    for away in (110..800).step_by(30) {
        let mut sensor =
            SimulatedGp2d02::new(wall(away), unit.clone(), SensorModel::FLAWLESS, 1, id(1));
        let Reading::Echo(read) = sensor.sense(&LOOK) else {
            panic!("no echo at {away} mm");
        };
        let error = f64::from(read.get()) / (f64::from(away) - 0.5) - 1.0;
        assert!(error.abs() < 0.14, "{away} mm reads {read}");
    }
}

#[test]
fn an_object_that_is_too_near_folds_back_to_a_far_one() {
    let unit = &Gp2d02Unit::shipped()[0];
    let read = |away| {
        SimulatedGp2d02::new(wall(away), unit.clone(), SensorModel::FLAWLESS, 1, id(1)).sense(&LOOK)
    };
    assert_eq!(read(85), Reading::TooNear);
    let Reading::Echo(folded) = read(30) else {
        panic!("{:?}", read(30));
    };
    assert!(folded.get() > 150, "{folded}");
}

#[test]
fn an_object_beyond_the_range_is_none() {
    let all = readings(&wall(820), &Gp2d02Unit::shipped()[0], SensorModel::FLAWLESS);
    assert!(all.iter().all(|r| *r == Reading::NoObject));
}

#[test]
fn what_a_sensor_draws_depends_on_nobody_else() {
    let unit = &Gp2d02Unit::shipped()[0];
    let sensor = |world: &Arc<World>, number| {
        SimulatedGp2d02::new(
            Arc::clone(world),
            unit.clone(),
            SensorModel::D,
            3,
            id(number),
        )
    };
    let (wall, open) = (wall(400), open());
    let (mut alone, mut among) = (sensor(&wall, 2), sensor(&wall, 2));
    let mut other = sensor(&wall, 1);
    let alone: Vec<_> = (0..200).map(|_| alone.sense(&LOOK)).collect();
    let among: Vec<_> = (0..200)
        .map(|_| {
            other.sense(&LOOK);
            among.sense(&LOOK)
        })
        .collect();
    assert_eq!(alone, among);
    let others: Vec<_> = (0..200).map(|_| other.sense(&LOOK)).collect();
    assert_ne!(alone, others);
    // Nor on what it saw before: another world for the first hundred looks.
    let mut moved = sensor(&open, 2);
    for _ in 0..100 {
        moved.sense(&LOOK);
    }
    moved.world = wall;
    let moved: Vec<_> = (100..200).map(|_| moved.sense(&LOOK)).collect();
    assert_eq!(moved, alone[100..]);
}
