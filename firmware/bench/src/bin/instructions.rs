//! How many instructions fusion takes on a Cortex-M3, counted by QEMU.
//!
//! Run with `-icount shift=5`: an instruction then takes 32 ns of the emulator's time and SysTick, which
//! counts at 24 MHz there whatever the firmware sets, tells how many there were: 125 for 96 ticks.
//! The first line checks that by a loop whose instructions are known.
#![no_std]
#![no_main]

use certainty_core::certainty::Certainty;
use certainty_core::fusion::{
    BayesGrid, Beam, CertaintyGrid, Mapper, Measurement, RobustRules, Shape, Strength, owner_bytes,
};
use certainty_core::health::{Health, HealthRules};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Millimeters, Point, Ticks};
use certainty_firmware::smart_car::{
    CELLS, SENSORS, SmartCarGrid, SmartCarShape, UNITS, beam_model,
};
use core::hint::black_box;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_semihosting::{debug, hprintln};
use stm32f1xx_hal as _; // the interrupt vectors

/// Runs `work` and returns how many instructions it took, the two looks at the clock included.
fn count(work: impl FnOnce()) -> u32 {
    let before = SYST::get_current();
    work();
    let after = SYST::get_current();
    // It counts down, modulo 2^24.
    let ticks = before.wrapping_sub(after) & 0x00FF_FFFF;
    // At most 2^24 ticks: 125 times as many fit.
    ticks.saturating_mul(125) / 96
}

const fn sensor(number: u8) -> SensorId {
    SensorId::new(number)
}

/// Adds one measurement to every cell of the grid and tells the instructions a cell.
fn every_cell(
    what: &str,
    grid: &mut impl CertaintyGrid,
    health: &mut [Health],
    by: u8,
    certainty: Certainty,
) {
    let measurement = Measurement {
        sensor: sensor(by),
        certainty: black_box(certainty),
    };
    let geometry = grid.geometry();
    let taken = count(|| grid.add_all(geometry.iter(), measurement, health));
    hprintln!("{} {} instructions a cell", what, taken / CELLS as u32);
}

fn robust() -> Option<SmartCarGrid> {
    let owners = [0; owner_bytes(CELLS, SENSORS)];
    let rules = RobustRules::DEFAULT;
    SmartCarGrid::try_new(SmartCarShape, rules, SENSORS, [0; CELLS], owners).ok()
}

fn measure() -> Option<()> {
    const KNOWN: u32 = 100_000;
    // cortex-m 0.7.10: a loop of two instructions, once more than asked.
    let known = count(|| cortex_m::asm::delay(KNOWN));
    hprintln!(
        "known-loop {} instructions where {} are",
        known,
        2 * (KNOWN + 1)
    );

    let mut health = [Health::default(); SENSORS as usize];
    let mut grid = robust()?;
    every_cell(
        "robust-unowned",
        &mut grid,
        &mut health,
        1,
        Certainty::OCCUPIED,
    );
    every_cell("robust-own", &mut grid, &mut health, 1, Certainty::OCCUPIED);
    every_cell(
        "robust-confirmed",
        &mut grid,
        &mut health,
        2,
        Certainty::OCCUPIED,
    );
    every_cell(
        "robust-contradicted",
        &mut grid,
        &mut health,
        3,
        Certainty::FREE,
    );

    let mut bayes = BayesGrid::try_new(SmartCarShape, Strength::MEASUREMENT, [0; CELLS]).ok()?;
    every_cell("bayes", &mut bayes, &mut health, 1, Certainty::FREE);

    let model = beam_model(UNITS[0].accuracy);
    let mut mapper = Mapper::with_records(robust()?, health, HealthRules::DEFAULT);
    for (what, degrees, reading) in [
        ("beam-echo-ahead", 90, Reading::Echo(Millimeters::new(550))),
        ("beam-echo-aslant", 63, Reading::Echo(Millimeters::new(550))),
        ("beam-no-object-aslant", 117, Reading::NoObject),
    ] {
        let beam = Beam {
            origin: Point::ORIGIN,
            bearing: BinaryAngle::from_millidegrees(degrees * 1000),
            reading: black_box(reading),
        };
        for by in [1, 2] {
            let mut told = 0;
            let taken = count(|| {
                let cells = mapper.integrate(sensor(by), &beam, &model, Ticks::new(0));
                told = cells.unwrap_or_default();
            });
            hprintln!("{} {} instructions for {} cells", what, taken, told);
        }
    }
    SmartCarShape.geometry().cell(0, 0).map(drop)
}

#[cortex_m_rt::entry]
fn main() -> ! {
    let status = match cortex_m::Peripherals::take() {
        Some(mut core) => {
            core.SYST.set_clock_source(SystClkSource::Core);
            core.SYST.set_reload(0x00FF_FFFF);
            core.SYST.clear_current();
            core.SYST.enable_counter();
            measure()
        }
        None => None,
    };
    loop {
        debug::exit(match status {
            Some(()) => debug::EXIT_SUCCESS,
            None => debug::EXIT_FAILURE,
        });
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
