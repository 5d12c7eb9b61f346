//! One control step on a Cortex-M3 under QEMU: how many instructions it takes.
//!
//! Run with `-icount shift=5`: an instruction takes 32 ns of the machine's time, and `SysTick` counts at 24
//! MHz whatever the firmware sets, so a tick is 1.302 instructions.
#![no_std]
#![no_main]

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
use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose, Ticks};
use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_semihosting::{debug, hprintln};
use stm32f1xx_hal as _; // the interrupt vectors

/// The largest count of `SysTick`.
const FULL: u32 = 0x00FF_FFFF;

/// Instructions from the count of `SysTick`, at 32 ns an instruction and 24 MHz.
const fn instructions(ticks: u32) -> u32 {
    // 1e9 / 24e6 / 32 = 1.302083… = 125 / 96.
    (ticks.wrapping_mul(125)).wrapping_div(96)
}

const fn pose(x: i32, y: i32, degrees: i32) -> Pose {
    let heading = BinaryAngle::from_millidegrees(degrees.wrapping_mul(1000));
    Pose::new(Point::from_mm(x, y), heading)
}

/// Sensors as on the simulator's robot.
const VIEWS: Mountings = Mountings {
    rangefinders: [
        pose(390, 170, 15),
        pose(310, 240, 45),
        pose(0, 280, 95),
        pose(0, -280, -95),
        pose(310, -240, -45),
        pose(390, -170, -15),
    ],
    scanner: pose(420, 0, 0),
    rangefinder_range: Millimeters::new(4000),
    scanner_range: Millimeters::new(4000),
};

const CHECK: CrossCheck = {
    match CrossCheck::try_new(CrossCheckConfig::new(VIEWS)) {
        Ok(check) => check,
        Err(_) => panic!("no such check"),
    }
};

const fn echo(mm: u32) -> Reading {
    Reading::Echo(Millimeters::new(mm))
}

/// Nothing in sight.
static OPEN: PerBeam<Reading> = [Reading::NoObject; BEAMS];

/// A post of 21 beams at 1.5 m.
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

/// Walls at 0.9 m.
static WALLS: PerBeam<Reading> = [echo(900); BEAMS];

fn ticks<T>(clock: &mut SYST, mut work: impl FnMut() -> T) -> (u32, T) {
    clock.clear_current();
    let before = SYST::get_current();
    let done = work();
    let after = SYST::get_current();
    (before.wrapping_sub(after) & FULL, done)
}

/// Cells of a map of 4 m by 4 m around the robot, of 10 cm each.
type Cells = [u8; 1600];

/// Returns a map in which a line across, `x` ahead, is occupied, or nothing.
fn map(x: Option<i32>, cells: &mut Cells) -> Option<BayesGrid<Geometry, &mut Cells>> {
    let corner = Point::from_mm(-500, -2000);
    let shape = Geometry::try_new(40, 40, Millimeters::new(100), corner).ok()?;
    let mut grid = BayesGrid::try_new(shape, Strength::UNLIMITED, cells).ok()?;
    let seen = Measurement {
        sensor: SensorId::try_new(1)?,
        certainty: Certainty::OCCUPIED,
    };
    for y in (-1950..2000).step_by(100) {
        if let Some(cell) = x.and_then(|x| shape.cell_at(Point::from_mm(x, y))) {
            grid.add(cell, seen, &mut []);
        }
    }
    Some(grid)
}

/// What it costs to remember, and to hold that against the sensors.
#[inline(never)]
fn measure_memory(
    clock: &mut SYST,
    name: &str,
    (x, cells): (Option<i32>, &mut Cells),
    scan: &PerBeam<Reading>,
    near: &PerRangefinder<Reading>,
) {
    let Some(grid) = map(x, cells) else {
        return;
    };
    let (nothing, ()) = ticks(clock, || ());
    let mut memory = ExpectedScan::EMPTY;
    let (remembering, ()) = ticks(clock, || {
        let map = Environment::new(&grid, &[]);
        let obstacle = Certainty::from_bits(192);
        memory = ExpectedScan::of_map(&map, Pose::default(), &VIEWS, obstacle);
    });
    let mut check = CHECK;
    let (observing, verdicts) = ticks(clock, || check.observe(near, scan, Some(&memory)));
    let (completing, completed) = ticks(clock, || {
        memory.complete(near, scan, &check.failures()).rangefinders
    });
    let agrees = match verdicts.scanner {
        Verdict::Agreement => "agrees",
        Verdict::Contradiction => "contradicts",
        Verdict::Phantom | Verdict::Past | Verdict::Silence => "silent",
    };
    // `count` would check its sum, which is a way to panic.
    let pairs = completed.iter().zip(near);
    let nearer = pairs.fold(0_u32, |nearer, (one, other)| {
        nearer.wrapping_add(u32::from(one != other))
    });
    hprintln!(
        "{}: recollection {} instructions, cross-check {}, completion {}; scanner {}, {} nearer",
        name,
        instructions(remembering.wrapping_sub(nothing)),
        instructions(observing.wrapping_sub(nothing)),
        instructions(completing.wrapping_sub(nothing)),
        agrees,
        nearer
    );
}

fn measure(clock: &mut SYST, name: &str, scan: &PerBeam<Reading>, near: &PerRangefinder<Reading>) {
    let mut controller = Controller::new(ControlRules::DEFAULT, Side::Left);
    let mut check = CHECK;
    let (nothing, ()) = ticks(clock, || ());
    let (checking, failures) = ticks(clock, || {
        check.observe(near, scan, None);
        check.failures()
    });
    let now = Ticks::new(50);
    let situation = |failures: Failures| ControlInput {
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
    let (stepping, command) = ticks(clock, || controller.step(&situation(failures)));
    let caution = match command.speed_limit {
        SpeedLimit::None => "none",
        SpeedLimit::NoWay => "no way",
        SpeedLimit::Arrived | SpeedLimit::Slowed | SpeedLimit::Blind => "held back",
    };
    hprintln!(
        "{}: step {} instructions, cross-check {}; caution {}",
        name,
        instructions(stepping.wrapping_sub(nothing)),
        instructions(checking.wrapping_sub(nothing)),
        caution
    );
}

#[cortex_m_rt::entry]
fn main() -> ! {
    // The entry point lends it out once.
    static mut CELLS: Cells = [0; 1600];
    let status = match Peripherals::take() {
        Some(mut board) => {
            let clock = &mut board.SYST;
            clock.set_clock_source(SystClkSource::Core);
            clock.set_reload(FULL);
            clock.enable_counter();
            let near = [
                echo(1400),
                echo(2000),
                Reading::NoObject,
                Reading::NoObject,
                echo(2000),
                echo(1400),
            ];
            measure(clock, "open", &OPEN, &[Reading::NoObject; 6]);
            measure(clock, "a post ahead", &POST, &near);
            measure(clock, "walls all around", &WALLS, &[echo(700); 6]);
            measure_memory(clock, "nothing remembered", (None, CELLS), &OPEN, &near);
            let wall = (Some(1450), CELLS);
            measure_memory(clock, "a wall remembered", wall, &POST, &near);
            debug::EXIT_SUCCESS
        }
        None => debug::EXIT_FAILURE,
    };
    loop {
        debug::exit(status);
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
