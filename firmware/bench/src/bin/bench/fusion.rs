//! The fusion level: the digest of a run, and instructions a cell and a beam.

use crate::clock::{instructions, ticks_of};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::{
    BayesGrid, Beam, CertaintyGrid, Mapper, Measurement, RobustRules, Strength, owner_bytes,
};
use certainty_core::health::{Health, HealthRules};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Millimeters, Point, Ticks};
use certainty_firmware::smart_car::{
    CELLS, SENSORS, SmartCarGrid, SmartCarShape, UNITS, beam_model,
};
use certainty_firmware_bench::fusion_run::{self, InitError};
use core::hint::black_box;
use cortex_m_semihosting::hprintln;

/// Prints the digest of a run and the instructions of its parts.
#[inline(never)]
pub(crate) fn run() -> Result<(), InitError> {
    let outcome = fusion_run::run()?;
    hprintln!(
        "fusion: digest {:08x} of {} updates",
        outcome.digest,
        outcome.updates
    );
    measure().ok_or(InitError)
}

/// Adds one measurement to every cell of the grid and prints the instructions a cell.
fn every_cell(
    what: &str,
    grid: &mut impl CertaintyGrid,
    health: &mut [Health],
    by: SensorId,
    certainty: Certainty,
) {
    let measurement = Measurement {
        sensor: by,
        certainty: black_box(certainty),
    };
    let geometry = grid.geometry();
    let (ticks, ()) = ticks_of(|| grid.add_all(geometry.iter(), measurement, health));
    hprintln!(
        "fusion: {} {} instructions a cell",
        what,
        instructions(ticks) / CELLS as u32
    );
}

fn robust() -> Option<SmartCarGrid> {
    let owners = [0; owner_bytes(CELLS, SENSORS)];
    let rules = RobustRules::DEFAULT;
    SmartCarGrid::try_new(SmartCarShape, rules, SENSORS, [0; CELLS], owners).ok()
}

#[inline(never)]
fn measure() -> Option<()> {
    const KNOWN: u32 = 100_000;
    // Checks the counting. cortex-m 0.7.10: a loop of two instructions, run once more than the argument.
    let (ticks, ()) = ticks_of(|| cortex_m::asm::delay(KNOWN));
    hprintln!(
        "fusion: known-loop {} instructions, expected {}",
        instructions(ticks),
        2 * (KNOWN + 1)
    );

    let first = SensorId::new(1);
    let second = SensorId::new(2);
    let third = SensorId::new(3);
    let mut health = [Health::default(); SENSORS as usize];
    let mut grid = robust()?;
    every_cell(
        "robust-unowned",
        &mut grid,
        &mut health,
        first,
        Certainty::OCCUPIED,
    );
    every_cell(
        "robust-own",
        &mut grid,
        &mut health,
        first,
        Certainty::OCCUPIED,
    );
    every_cell(
        "robust-confirmed",
        &mut grid,
        &mut health,
        second,
        Certainty::OCCUPIED,
    );
    every_cell(
        "robust-contradicted",
        &mut grid,
        &mut health,
        third,
        Certainty::FREE,
    );

    let mut bayes = BayesGrid::try_new(SmartCarShape, Strength::MEASUREMENT, [0; CELLS]).ok()?;
    every_cell("bayes", &mut bayes, &mut health, first, Certainty::FREE);

    let model = beam_model(UNITS[0].accuracy);
    let mut mapper = Mapper::with_records(robust()?, health, HealthRules::DEFAULT);
    for (what, degrees, reading) in [
        ("beam-echo-ahead", 90, Reading::Echo(Millimeters::new(550))),
        ("beam-echo-aslant", 63, Reading::Echo(Millimeters::new(550))),
        ("beam-no-object-aslant", 117, Reading::NoObject),
    ] {
        let beam = Beam {
            origin: Point::ORIGIN,
            bearing: BinaryAngle::from_millidegrees(i32::wrapping_mul(degrees, 1000)),
            reading: black_box(reading),
        };
        for by in [first, second] {
            let (ticks, cells) = ticks_of(|| mapper.integrate(by, &beam, &model, Ticks::new(0)));
            hprintln!(
                "fusion: {} {} instructions for {} cells",
                what,
                instructions(ticks),
                cells.unwrap_or_default()
            );
        }
    }
    Some(())
}
