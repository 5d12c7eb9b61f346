//! The image to flash, pin by pin on the emulated board.

use certainty_control::Wheels;
use certainty_firmware::remote::{Channel, Line};
use certainty_firmware::smart_car::MOTOR;
use certainty_firmware::telemetry::{Drive, DriveState};
use certainty_sim::backend::board::{BoardError, EmulatedBoard, ResetCause, emulated_board};
use certainty_sim::backend::{Image, Received};
use certainty_sim::bench::{Bench, BenchSetup, Wires};
use certainty_sim::transducer::SensorSet;
use certainty_sim::world::World;
use certainty_tests::firmware;
use object::{Object, ObjectSection, ObjectSegment, ObjectSymbol};
use std::fs;
use std::sync::Arc;

const MILLISECOND: u64 = 1_000_000;

/// The schedule's round, in ms.
const ROUND_MS: u64 = 800;

/// The bench with a record of all pin changes and pulses.
struct Recorded {
    bench: Bench,
    levels: Vec<(Line, bool, u64)>,
    pulses: Vec<(Channel, u32, u64)>,
}

impl Wires for Recorded {
    fn set_level(&mut self, line: Line, high: bool, now_ns: u64) {
        self.levels.push((line, high, now_ns));
        Wires::set_level(&mut self.bench, line, high, now_ns);
    }

    fn level(&mut self, line: Line, now_ns: u64) -> bool {
        Wires::level(&mut self.bench, line, now_ns)
    }

    fn set_pulse(&mut self, channel: Channel, width_us: u32, now_ns: u64) {
        self.pulses.push((channel, width_us, now_ns));
        Wires::set_pulse(&mut self.bench, channel, width_us, now_ns);
    }
}

/// Returns the image on its board, before the start; `None` if it cannot be built.
fn board() -> Option<EmulatedBoard<Recorded>> {
    let image = fs::read(firmware::image("smart_car")?).unwrap();
    let setup = BenchSetup {
        world: Arc::new(World::built_in()),
        sensors: SensorSet::default(),
        faults: Vec::new(),
        seed: 1,
    };
    let recorded = Recorded {
        bench: Bench::new(setup).unwrap(),
        levels: Vec::new(),
        pulses: Vec::new(),
    };
    Some(emulated_board(&image, recorded).unwrap())
}

fn run(board: &mut EmulatedBoard<Recorded>, rounds: u64) {
    assert_eq!(board.run_for(rounds * ROUND_MS), Ok(()));
}

/// Returns the drive reports, one a round.
fn drives(board: &mut EmulatedBoard<Recorded>) -> Vec<Drive> {
    let mut received = Received::default();
    received.take(&board.take_serial());
    received.drives().to_vec()
}

/// Returns the motors' pulse widths and their times.
fn motor_pulses(board: &mut EmulatedBoard<Recorded>) -> Vec<(Channel, u32, u64)> {
    let mut pulses = board.with_pins(|pins| pins.0.pulses.clone());
    pulses.retain(|(channel, ..)| matches!(channel, Channel::Motor(_)));
    pulses
}

/// Returns the times from each of these edges to the next, in µs.
fn spans(edges: &[(bool, u64)]) -> Vec<u64> {
    let pairs = edges.iter().zip(edges.iter().skip(1));
    pairs
        .map(|((_, from), (_, to))| (to - from) / 1_000)
        .collect()
}

#[test]
fn sensors_are_clocked_as_in_their_data_sheet() {
    let Some(mut board) = board() else { return };
    run(&mut board, 2);
    let levels = board.with_pins(|pins| pins.0.levels.clone());
    for slot in 0..3 {
        let edges = levels.iter().filter(|(line, ..)| *line == Line::Vin(slot));
        let edges: Vec<_> = edges.map(|&(_, high, at)| (high, at)).collect();
        // A fall to start; eight times up and down; up to end.
        assert_eq!(edges.len(), 2 * (1 + 8 * 2 + 1), "{edges:?}");
        for conversion in edges.chunks(18) {
            assert!(!conversion[0].0);
            let spans = spans(conversion);
            assert!(spans[0] >= 70_000, "{spans:?}");
            // Each level of the clock lasts 50 to 100 µs.
            assert!(
                spans[1..].iter().all(|us| (50..=100).contains(us)),
                "{spans:?}"
            );
        }
    }
}

#[test]
fn rangers_are_triggered_one_after_the_other() {
    let Some(mut board) = board() else { return };
    run(&mut board, 2);
    let levels = board.with_pins(|pins| pins.0.levels.clone());
    let mut rises = Vec::new();
    for slot in 0..2 {
        let edges = levels
            .iter()
            .filter(|(line, ..)| *line == Line::Trigger(slot));
        let edges: Vec<_> = edges.map(|&(_, high, at)| (high, at)).collect();
        assert_eq!(edges.len(), 4, "{edges:?}");
        for pulse in edges.chunks(2) {
            assert!(pulse[0].0 && !pulse[1].0);
            assert!((10..=50).contains(&spans(pulse)[0]), "{pulse:?}");
            rises.push(pulse[0].1);
        }
    }
    rises.sort_unstable();
    let apart = rises.iter().zip(rises.iter().skip(1)).map(|(a, b)| b - a);
    assert!(apart.min() > Some(60 * MILLISECOND), "{rises:?}");
}

#[test]
fn servos_get_whole_pulses_within_their_limits() {
    let Some(mut board) = board() else { return };
    run(&mut board, 5);
    let mut pulses = board.with_pins(|pins| pins.0.pulses.clone());
    pulses.retain(|(channel, ..)| matches!(channel, Channel::Servo(_)));
    assert_eq!(
        pulses.len(),
        3 * 5,
        "one width a servo and round: {pulses:?}"
    );
    assert!(pulses.iter().all(|(_, us, _)| (600..=2_400).contains(us)));
    let first = pulses[0].2;
    for (servo, _, at) in &pulses {
        // A new width begins with a period of 20 ms; the periods are in step with the rounds.
        assert_eq!((at - first) % (20 * MILLISECOND), 0, "{servo:?}");
    }
    for servo in 0..3 {
        let widths: Vec<u32> = pulses
            .iter()
            .filter(|one| one.0 == Channel::Servo(servo))
            .map(|one| one.1)
            .collect();
        let steps = widths
            .iter()
            .zip(widths.iter().skip(1))
            .map(|(a, b)| a.abs_diff(*b));
        // 5° a step of a servo of 900 µs for 90°.
        assert!(steps.clone().all(|us| us == 50), "{widths:?}");
    }
}

/// Both motors' pulses begin with the servos' periods, are at standstill while the car looks around, and change
/// in the period after the slot that sets them.
#[test]
fn motors_are_set_at_the_same_time_of_every_round() {
    let Some(mut board) = board() else { return };
    run(&mut board, 44);
    let first_servo = board.with_pins(|pins| pins.0.pulses[0].2);
    let motors = motor_pulses(&mut board);
    // Only changes are recorded: at first both stand, for 37 rounds.
    assert!(motors[..2].iter().all(|one| one.1 == 1_500), "{motors:?}");
    assert!(motors.len() > 6, "{motors:?}");
    for &(motor, us, at) in &motors {
        assert!((1_000..=2_000).contains(&us), "{motor:?} {us}");
        // 780 ms into a round: the period after the slot at 772 ms. The timers start some cycles apart.
        let off = (at - first_servo) % (ROUND_MS * MILLISECOND);
        let late = off.abs_diff(780 * MILLISECOND);
        assert!(late < 20_000, "{motor:?} {late} ns");
    }
    assert!((motors[2].2 - first_servo) / (ROUND_MS * MILLISECOND) >= 37);
}

/// The reported speeds are the motors' pulses: round for round, to the microsecond.
#[test]
fn motor_pulses_are_those_of_the_telemetry() {
    let Some(mut board) = board() else { return };
    run(&mut board, 60);
    let first_servo = board.with_pins(|pins| pins.0.pulses[0].2);
    let pulses = motor_pulses(&mut board);
    let drives = drives(&mut board);
    assert!(drives.len() >= 59, "{}", drives.len());
    let stand = i32::from(MOTOR.config().stand_us);
    let mut moved = 0;
    for (round, drive) in (0..).zip(&drives) {
        // The middle of the period after the one in which they are set.
        let by = first_servo + (round * ROUND_MS + 790) * MILLISECOND;
        let Wheels { right, left } = drive.wheels;
        for (motor, speed) in [(0, right), (1, left)] {
            let mut given = pulses.iter().rev();
            let last = given.find(|one| one.0 == Channel::Motor(motor) && one.2 < by);
            let expected = stand + i32::from(MOTOR.pulse_change_us(speed));
            let given = last.map(|one| one.1.cast_signed());
            assert_eq!(given, Some(expected), "round {round}: {drive:?}");
            moved += u32::from(expected != stand);
        }
    }
    assert!(moved > 20, "{moved}");
}

/// 51 ms have 408,000 cycles; an eighth is left for differences between the emulator's count and silicon.
#[test]
fn deciding_takes_at_most_360_000_cycles() {
    let Some(mut board) = board() else { return };
    let mut most = 0;
    for _ in 0..80 {
        // The boot takes less than a millisecond, so that the slots begin soon after whole ones.
        assert_eq!(board.run_for(721), Ok(()));
        let before = board.cycles_awake();
        assert_eq!(board.run_for(51), Ok(()));
        most = most.max(board.cycles_awake() - before);
        assert_eq!(board.run_for(28), Ok(()));
    }
    assert!((100_000..=360_000).contains(&most), "{most} cycles");
    assert_eq!(
        drives(&mut board).last().map(|drive| drive.state),
        Some(DriveState::Arrived)
    );
}

/// After an automatic reset the car's pose is unknown, so it does not drive.
#[test]
fn after_an_automatic_reset_it_stands_and_reports_it() {
    let rounds = 42;
    for (cause, drove) in [
        (ResetCause::PowerOn, true),
        (ResetCause::Pin, true),
        (ResetCause::Watchdog, false),
        (ResetCause::WindowWatchdog, false),
        (ResetCause::Software, false),
        (ResetCause::LowPower, false),
    ] {
        let Some(board) = board() else { return };
        let mut board = board.after(cause);
        run(&mut board, rounds);
        let pulses = motor_pulses(&mut board);
        let moved = pulses.iter().any(|one| one.1 != 1_500);
        assert_eq!(moved, drove, "{cause:?}: {pulses:?}");
        assert!(pulses.len() >= 2, "{cause:?}: both are set to stand");
        let mut received = Received::default();
        received.take(&board.take_serial());
        let restarted = |drive: &Drive| drive.state == DriveState::Restarted;
        let drives = received.drives();
        assert_eq!(drives.iter().all(restarted), !drove, "{cause:?}");
        assert_eq!(drives.iter().any(restarted), !drove, "{cause:?}");
        // It continues to sense and report.
        assert!(received.map().is_some(), "{cause:?}");
        assert_eq!(received.statistics().overruns, 0);
        assert_eq!(board.unmodelled(), []);
    }
}

/// Returns the image with this instruction in place of the first one of `main`.
fn with_first_instruction(instruction: u16) -> Option<Vec<u8>> {
    let mut image = fs::read(firmware::image("smart_car")?).unwrap();
    let at = {
        let file = object::File::parse(&*image).unwrap();
        let main = file.symbols().find(|symbol| symbol.name() == Ok("main"));
        // Thumb code has odd addresses.
        let main = main.unwrap().address() & !1;
        let text = file.section_by_name(".text").unwrap();
        let (offset, _) = text.file_range().unwrap();
        usize::try_from(offset + main - text.address()).unwrap()
    };
    image[at..at + 2].copy_from_slice(&instruction.to_le_bytes());
    Some(image)
}

/// The reset ends the pulses at once, and the start after it is automatic.
#[test]
fn a_fault_or_unknown_exception_resets_at_once() {
    let undefined = 0xDE00;
    let supervisor_call = 0xDF00;
    for instruction in [undefined, supervisor_call] {
        let Some(image) = with_first_instruction(instruction) else {
            return;
        };
        let mut board = emulated_board(&image, NoWires).unwrap();
        let ended = board.run_for(ROUND_MS);
        let soon = matches!(ended, Err(BoardError::Reset { at_ns }) if at_ns < 5 * MILLISECOND);
        assert!(soon, "{instruction:x}: {ended:?}");
    }
}

#[test]
fn every_used_register_is_modelled() {
    let Some(mut board) = board() else { return };
    run(&mut board, 40);
    assert_eq!(board.unmodelled(), []);
}

#[test]
fn two_runs_are_equal_in_every_cycle() {
    let (Some(mut one), Some(mut other)) = (board(), board()) else {
        return;
    };
    for _ in 0..2 * ROUND_MS {
        one.step_ms().unwrap();
        other.step_ms().unwrap();
        assert_eq!(one.take_serial(), other.take_serial());
        assert_eq!(one.cycles(), other.cycles());
    }
    let levels =
        |board: &mut EmulatedBoard<Recorded>| board.with_pins(|pins| pins.0.levels.clone());
    assert_eq!(levels(&mut one), levels(&mut other));
    assert_eq!(one.lowest_stack_pointer(), other.lowest_stack_pointer());
}

#[test]
fn it_sleeps_most_of_the_time() {
    let Some(mut board) = board() else { return };
    run(&mut board, 5);
    let (awake, all) = (board.cycles_awake(), board.cycles());
    assert!(awake * 5 < all, "{awake} of {all} cycles");
    assert!(awake * 100 > all, "{awake} of {all} cycles");
}

#[test]
fn an_image_for_another_processor_is_refused() {
    let Some(image) = firmware::image("smart_car") else {
        return;
    };
    let mut image = fs::read(image).unwrap();
    image[18] = 243; // RISC-V
    let error = emulated_board(&image, NoWires).unwrap_err();
    assert_eq!(
        error,
        BoardError::NotAnImage("it is for another processor".into())
    );
}

/// No devices on the pins.
#[derive(Debug)]
struct NoWires;

impl Wires for NoWires {
    fn set_level(&mut self, _: Line, _: bool, _: u64) {}

    fn level(&mut self, _: Line, _: u64) -> bool {
        false
    }

    fn set_pulse(&mut self, _: Channel, _: u32, _: u64) {}
}

/// Without devices on its pins the car has no readings, but the schedule continues and the watchdog is fed.
#[test]
fn without_devices_the_schedule_continues() {
    let Some(image) = firmware::image("smart_car") else {
        return;
    };
    let image = fs::read(image).unwrap();
    let mut board = emulated_board(&image, NoWires).unwrap();
    assert_eq!(board.run_for(10 * ROUND_MS), Ok(()));
    assert!(!board.take_serial().is_empty());
}

#[test]
fn flash_bytes_are_what_a_programmer_writes() {
    let Some(path) = firmware::image("smart_car") else {
        return;
    };
    let sizes = Image::load(Some(&path), "smart_car").unwrap().sizes();
    let bytes = fs::read(path).unwrap();
    let file = object::File::parse(&*bytes).unwrap();
    let written = file.segments().map(|segment| segment.file_range().1);
    assert_eq!(u64::from(sizes.flash_bytes), written.sum::<u64>());
}
