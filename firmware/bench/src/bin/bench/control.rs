//! The control level: instructions of a control step, of the cross-check and of map lookups.

use crate::clock::{instructions, ticks_of};
use certainty_control::{
    BEAMS, ControlInput, ControlRules, Controller, CrossCheck, CrossCheckConfig, ExpectedScan,
    Failures, Mountings, PerBeam, PerRangefinder, Side, SpeedLimit, Stamped, Verdict,
};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::{
    BayesGrid, CertaintyGrid, Environment, Geometry, Measurement, Strength,
};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::{Millimeters, Point, Pose, Ticks};
use certainty_firmware_bench::fusion_run::InitError;
use cortex_m_semihosting::hprintln;

/// Prints the instructions of control steps in several scenes.
#[inline(never)]
pub(crate) fn run() -> Result<(), InitError> {
    let near = [
        echo(1400),
        echo(2000),
        Reading::NoObject,
        Reading::NoObject,
        echo(2000),
        echo(1400),
    ];
    measure("open", &OPEN, &[Reading::NoObject; 6]);
    measure("a post ahead", &POST, &near);
    measure("walls all around", &WALLS, &[echo(700); 6]);
    measure_map("an empty map", None, &OPEN, &near)?;
    measure_map("a wall in the map", Some(1450), &POST, &near)
}

const CHECK: CrossCheck = {
    match CrossCheck::try_new(CrossCheckConfig::new(Mountings::IBIS)) {
        Ok(check) => check,
        Err(_) => panic!("no such check"),
    }
};

const fn echo(mm: u32) -> Reading {
    Reading::Echo(Millimeters::new(mm))
}

/// A scan without an echo.
static OPEN: PerBeam<Reading> = [Reading::NoObject; BEAMS];

/// A scan with a post of 21 beams at 1.5 m.
static POST: PerBeam<Reading> = {
    let mut scan = [Reading::NoObject; BEAMS];
    let (_, mut rest) = scan.split_at_mut(40);
    while let [reading, others @ ..] = rest {
        if others.len() >= 40 {
            *reading = echo(1500);
        }
        rest = others;
    }
    scan
};

/// A scan with walls at 0.9 m.
static WALLS: PerBeam<Reading> = [echo(900); BEAMS];

/// Cells of a map of 4 m by 4 m around the robot, of 10 cm each.
type Cells = [u8; 1600];

/// Returns a map with an occupied line across, `x` ahead, or an empty one.
fn map(x: Option<i32>, cells: &mut Cells) -> Option<BayesGrid<Geometry, &mut Cells>> {
    let corner = Point::from_mm(-500, -2000);
    let shape = Geometry::try_new(40, 40, Millimeters::new(100), corner).ok()?;
    let mut grid = BayesGrid::try_new(shape, Strength::UNLIMITED, cells).ok()?;
    let occupied = Measurement {
        sensor: SensorId::try_new(1)?,
        certainty: Certainty::OCCUPIED,
    };
    for y in (-1950..2000).step_by(100) {
        if let Some(cell) = x.and_then(|x| shape.cell_at(Point::from_mm(x, y))) {
            grid.add(cell, occupied, &mut []);
        }
    }
    Some(grid)
}

/// Casts the expected scan of a map; returns the ticks.
///
/// Not inlined, so that the map is not on the stack when the cross-check runs: both do not fit.
#[inline(never)]
fn cast(wall_x: Option<i32>, expected: &mut ExpectedScan) -> Result<u32, InitError> {
    let mut cells: Cells = [0; 1600];
    let grid = map(wall_x, &mut cells).ok_or(InitError)?;
    let (ticks, ()) = ticks_of(|| {
        let map = Environment::new(&grid, &[]);
        let obstacle = Certainty::from_bits(192);
        *expected = ExpectedScan::of_map(&map, Pose::default(), &Mountings::IBIS, obstacle);
    });
    Ok(ticks)
}

/// Measures the expected scan of a map and the cross-check with it.
#[inline(never)]
fn measure_map(
    name: &str,
    wall_x: Option<i32>,
    scan: &PerBeam<Reading>,
    near: &PerRangefinder<Reading>,
) -> Result<(), InitError> {
    let (nothing, ()) = ticks_of(|| ());
    let mut expected = ExpectedScan::EMPTY;
    let casting = cast(wall_x, &mut expected)?;
    let mut check = CHECK;
    let (observing, verdicts) = ticks_of(|| check.observe(near, scan, Some(&expected)));
    let (completing, completed) = ticks_of(|| {
        expected
            .complete(near, scan, &check.failures())
            .rangefinders
    });
    let agrees = match verdicts.scanner {
        Verdict::Agreement => "agrees",
        Verdict::Contradiction => "contradicts",
        Verdict::Phantom | Verdict::Past | Verdict::Silence => "silent",
    };
    // A fold, because the overflow check of `count` links a panic.
    let pairs = completed.iter().zip(near);
    let nearer = pairs.fold(0_u32, |nearer, (one, other)| {
        nearer.wrapping_add(u32::from(one != other))
    });
    hprintln!(
        "control: {}: expected scan {} instructions, cross-check {}, completion {}; scanner {}, {} nearer",
        name,
        instructions(casting.wrapping_sub(nothing)),
        instructions(observing.wrapping_sub(nothing)),
        instructions(completing.wrapping_sub(nothing)),
        agrees,
        nearer
    );
    Ok(())
}

/// Measures a control step and the cross-check in one scene.
#[inline(never)]
fn measure(name: &str, scan: &PerBeam<Reading>, near: &PerRangefinder<Reading>) {
    let mut controller = Controller::new(ControlRules::DEFAULT, Side::Left);
    let mut check = CHECK;
    let (nothing, ()) = ticks_of(|| ());
    let (checking, failures) = ticks_of(|| {
        check.observe(near, scan, None);
        check.failures()
    });
    let now = Ticks::new(50);
    let input = |failures: Failures| ControlInput {
        now,
        pose: Pose::default(),
        goal: Point::from_mm(10_000, 1000),
        rangefinders: near.map(|what| Stamped { what, at: now }),
        scan: Stamped {
            what: scan,
            at: now,
        },
        failures,
    };
    let (stepping, command) = ticks_of(|| controller.step(&input(failures)));
    let limit = match command.speed_limit {
        SpeedLimit::None => "none",
        SpeedLimit::NoWay => "no way",
        SpeedLimit::Arrived | SpeedLimit::Slowed | SpeedLimit::Blind => "slowed",
    };
    hprintln!(
        "control: {}: step {} instructions, cross-check {}; limit {}",
        name,
        instructions(stepping.wrapping_sub(nothing)),
        instructions(checking.wrapping_sub(nothing)),
        limit
    );
}
