//! One control step on a Cortex-M3 under QEMU: how many instructions it takes.
//!
//! Run with `-icount shift=5`: an instruction takes 32 ns of the machine's time, and `SysTick` counts at 24
//! MHz whatever the firmware sets, so a tick is 1.302 instructions.
#![no_std]
#![no_main]

use certainty_core::control::{
    BEAMS, Caution, ControlRules, Controller, CrossCheck, CrossCheckConfig, Dated, Failures,
    PerBeam, PerRangefinder, Side, Situation, Views,
};
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
const CHECK: CrossCheckConfig = CrossCheckConfig {
    views: Views {
        rangefinders: [
            pose(420, 200, 15),
            pose(350, 260, 45),
            pose(0, 280, 95),
            pose(0, -280, -95),
            pose(350, -260, -45),
            pose(420, -200, -15),
        ],
        scanner: pose(420, 0, 0),
        rangefinders_see: Millimeters::new(4000),
        scanner_sees: Millimeters::new(4000),
    },
    tolerance: Millimeters::new(150),
    contradiction: 4,
    agreement: 2,
    most: 48,
    credit: 16,
    unlikely: 12,
};

const fn echo(mm: u32) -> Reading {
    Reading::Echo(Millimeters::new(mm))
}

fn ticks<T>(clock: &mut SYST, mut work: impl FnMut() -> T) -> (u32, T) {
    clock.clear_current();
    let before = SYST::get_current();
    let done = work();
    let after = SYST::get_current();
    (before.wrapping_sub(after) & FULL, done)
}

fn measure(clock: &mut SYST, name: &str, scan: &PerBeam<Reading>, near: &PerRangefinder<Reading>) {
    let mut controller = Controller::new(ControlRules::DEFAULT, Side::Left);
    let mut check = CrossCheck::new(CHECK);
    let (nothing, ()) = ticks(clock, || ());
    let (checking, failures) = ticks(clock, || {
        check.observe(near, scan);
        check.failures()
    });
    let now = Ticks::new(50);
    let situation = |failures: Failures| Situation {
        now,
        pose: Pose::default(),
        goal: Point::from_mm(10_000, 1000),
        rangefinders: near.map(|what| Dated { what, at: now }),
        scan: Dated {
            what: scan,
            at: now,
        },
        failures,
    };
    let (stepping, command) = ticks(clock, || controller.step(&situation(failures)));
    let caution = match command.caution {
        Caution::None => "none",
        Caution::NoWay => "no way",
        Caution::Arrived | Caution::Slowed | Caution::Blind => "held back",
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
    let status = match Peripherals::take() {
        Some(mut board) => {
            let clock = &mut board.SYST;
            clock.set_clock_source(SystClkSource::Core);
            clock.set_reload(FULL);
            clock.enable_counter();
            let open = [Reading::NoObject; BEAMS];
            measure(clock, "open", &open, &[Reading::NoObject; 6]);
            let mut post = open;
            for reading in post.iter_mut().skip(40).take(21) {
                *reading = echo(1500);
            }
            let near = [
                echo(1400),
                echo(2000),
                Reading::NoObject,
                Reading::NoObject,
                echo(2000),
                echo(1400),
            ];
            measure(clock, "a post ahead", &post, &near);
            measure(
                clock,
                "walls all around",
                &[echo(900); BEAMS],
                &[echo(700); 6],
            );
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
