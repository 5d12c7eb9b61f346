//! The image that is flashed, pin by pin on the emulated board.

use certainty_control::Wheels;
use certainty_firmware::remote::{Channel, Line};
use certainty_firmware::smart_car::MOTOR;
use certainty_firmware::telemetry::{Drive, DriveState};
use certainty_sim::backend::board::{BoardError, EmulatedBoard, ResetCause};
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

/// The bench, and everything that the board did to it.
struct Watched {
    bench: Bench,
    levels: Vec<(Line, bool, u64)>,
    pulses: Vec<(Channel, u32, u64)>,
}

impl Wires for Watched {
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

/// The shipped image on its board, about to start; `None` where it cannot be built.
fn board() -> Option<EmulatedBoard<Watched>> {
    let image = fs::read(firmware::image("smart_car")?).unwrap();
    let setup = BenchSetup {
        world: Arc::new(World::built_in()),
        sensors: SensorSet::default(),
        faults: Vec::new(),
        seed: 1,
    };
    let watched = Watched {
        bench: Bench::new(setup).unwrap(),
        levels: Vec::new(),
        pulses: Vec::new(),
    };
    Some(EmulatedBoard::new(&image, watched).unwrap())
}

fn run(board: &mut EmulatedBoard<Watched>, rounds: u64) {
    let done = board.run_until(rounds * ROUND_MS, |_| false);
    assert_eq!(done, Ok(false));
}

/// How the board said to drive, a round after the other.
fn drives(board: &mut EmulatedBoard<Watched>) -> Vec<Drive> {
    let mut received = Received::default();
    received.take(&board.take_serial());
    received.drives().to_vec()
}

/// The widths that the motors were given, and when.
fn motor_pulses(board: &mut EmulatedBoard<Watched>) -> Vec<(Channel, u32, u64)> {
    let mut pulses = board.with_wires(|wires| wires.pulses.clone());
    pulses.retain(|(channel, ..)| matches!(channel, Channel::Motor(_)));
    pulses
}

/// The times from each of these edges to the next, in µs.
fn spans(edges: &[(bool, u64)]) -> Vec<u64> {
    let pairs = edges.iter().zip(edges.iter().skip(1));
    pairs
        .map(|((_, from), (_, to))| (to - from) / 1_000)
        .collect()
}

#[test]
fn the_sensors_are_started_and_clocked_as_their_data_sheet_says() {
    let Some(mut board) = board() else { return };
    run(&mut board, 2);
    let levels = board.with_wires(|wires| wires.levels.clone());
    for slot in 0..3 {
        let edges = levels.iter().filter(|(line, ..)| *line == Line::Vin(slot));
        let edges: Vec<_> = edges.map(|&(_, high, at)| (high, at)).collect();
        // A fall to start; eight times up and down; up to end.
        assert_eq!(edges.len(), 2 * (1 + 8 * 2 + 1), "{edges:?}");
        for conversion in edges.chunks(18) {
            assert!(!conversion[0].0);
            let spans = spans(conversion);
            assert!(spans[0] >= 70_000, "{spans:?}");
            // Each level of the clock 50 to 100 µs, beyond what a bit is looked at twice.
            assert!(
                spans[1..].iter().all(|us| (50..=100).contains(us)),
                "{spans:?}"
            );
        }
    }
}

#[test]
fn the_rangers_are_triggered_for_ten_microseconds_and_never_both_at_once() {
    let Some(mut board) = board() else { return };
    run(&mut board, 2);
    let levels = board.with_wires(|wires| wires.levels.clone());
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
fn the_servos_get_whole_pulses_within_their_limits_from_the_first_move_on() {
    let Some(mut board) = board() else { return };
    run(&mut board, 5);
    let mut pulses = board.with_wires(|wires| wires.pulses.clone());
    pulses.retain(|(channel, ..)| matches!(channel, Channel::Servo(_)));
    assert_eq!(pulses.len(), 3 * 5, "a width a servo and round: {pulses:?}");
    assert!(pulses.iter().all(|(_, us, _)| (600..=2_400).contains(us)));
    let first = pulses[0].2;
    for (servo, _, at) in &pulses {
        // A new width begins with a period of 20 ms, which keep step with the rounds.
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

/// Both motors' pulses begin with the servos' frames, stand while the car looks around, and change in
/// the frame after the slot that gives them.
#[test]
fn the_motors_are_told_at_the_same_time_of_every_round() {
    let Some(mut board) = board() else { return };
    run(&mut board, 44);
    let first_servo = board.with_wires(|wires| wires.pulses[0].2);
    let motors = motor_pulses(&mut board);
    // Only changes are told: first both stand, for 37 rounds.
    assert!(motors[..2].iter().all(|one| one.1 == 1_500), "{motors:?}");
    assert!(motors.len() > 6, "{motors:?}");
    for &(motor, us, at) in &motors {
        assert!((1_000..=2_000).contains(&us), "{motor:?} {us}");
        // 780 ms into a round: the frame after the slot at 772 ms. The timers start some cycles apart.
        let off = (at - first_servo) % (ROUND_MS * MILLISECOND);
        let late = off.abs_diff(780 * MILLISECOND);
        assert!(late < 20_000, "{motor:?} {late} ns");
    }
    assert!((motors[2].2 - first_servo) / (ROUND_MS * MILLISECOND) >= 37);
}

/// What a watcher reads is what the wheels are told: round for round, to the microsecond.
#[test]
fn the_motors_pulses_are_those_that_the_telemetry_says() {
    let Some(mut board) = board() else { return };
    run(&mut board, 60);
    let first_servo = board.with_wires(|wires| wires.pulses[0].2);
    let pulses = motor_pulses(&mut board);
    let drives = drives(&mut board);
    assert!(drives.len() >= 59, "{}", drives.len());
    let stand = i32::from(MOTOR.config().stand_us);
    let mut moved = 0;
    for (round, drive) in (0..).zip(&drives) {
        // The frame after the one in which they are told, to the half of it.
        let by = first_servo + (round * ROUND_MS + 790) * MILLISECOND;
        let Wheels { right, left } = drive.wheels;
        for (motor, told) in [(0, right), (1, left)] {
            let mut given = pulses.iter().rev();
            let last = given.find(|one| one.0 == Channel::Motor(motor) && one.2 < by);
            let expected = stand + i32::from(MOTOR.thrust_us(told));
            let given = last.map(|one| one.1.cast_signed());
            assert_eq!(given, Some(expected), "round {round}: {drive:?}");
            moved += u32::from(expected != stand);
        }
    }
    assert!(moved > 20, "{moved}");
}

/// 51 ms of 8,000 cycles: an eighth is left for what `rsemu` counts otherwise than silicon.
#[test]
fn deciding_takes_at_most_360_000_of_the_408_000_cycles_of_its_slot() {
    let Some(mut board) = board() else { return };
    let mut most = 0;
    for _ in 0..80 {
        // The boot takes less than a millisecond, so that the slots begin soon after whole ones.
        assert_eq!(board.run_until(721, |_| false), Ok(false));
        let before = board.cycles_awake();
        assert_eq!(board.run_until(51, |_| false), Ok(false));
        most = most.max(board.cycles_awake() - before);
        assert_eq!(board.run_until(28, |_| false), Ok(false));
    }
    assert!((100_000..=360_000).contains(&most), "{most} cycles");
    assert_eq!(
        drives(&mut board).last().map(|drive| drive.conduct),
        Some(DriveState::Arrived)
    );
}

/// Nobody took the car back to where it starts: so it does not drive on from where it is.
#[test]
fn after_a_reset_that_nobody_did_by_hand_it_stands_and_says_so() {
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
        assert!(pulses.len() >= 2, "{cause:?}: both are told to stand");
        let mut received = Received::default();
        received.take(&board.take_serial());
        let restarted = |drive: &Drive| drive.conduct == DriveState::Restarted;
        let drives = received.drives();
        assert_eq!(drives.iter().all(restarted), !drove, "{cause:?}");
        assert_eq!(drives.iter().any(restarted), !drove, "{cause:?}");
        // It goes on looking and reporting.
        assert!(received.map().is_some(), "{cause:?}");
        assert_eq!(received.statistics().overruns, 0);
        assert_eq!(board.unmodelled(), []);
    }
}

/// The shipped image with this instruction in place of the first of `main`.
fn broken(instruction: u16) -> Option<Vec<u8>> {
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

/// A reset ends the pulses at once, and the start after it is one that nobody did by hand.
#[test]
fn a_fault_or_an_unknown_exception_resets_at_once() {
    let undefined = 0xDE00;
    let call_of_a_supervisor = 0xDF00;
    for instruction in [undefined, call_of_a_supervisor] {
        let Some(image) = broken(instruction) else {
            return;
        };
        let mut board = EmulatedBoard::new(&image, NoWires).unwrap();
        let ended = board.run_until(ROUND_MS, |_| false);
        let soon = matches!(ended, Err(BoardError::Reset { at_ns }) if at_ns < 5 * MILLISECOND);
        assert!(soon, "{instruction:x}: {ended:?}");
    }
}

#[test]
fn every_register_that_it_uses_is_modelled() {
    let Some(mut board) = board() else { return };
    run(&mut board, 40);
    assert_eq!(board.unmodelled(), []);
}

#[test]
fn two_runs_do_the_same_in_the_same_cycle() {
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
        |board: &mut EmulatedBoard<Watched>| board.with_wires(|wires| wires.levels.clone());
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
fn another_microcontrollers_program_is_refused() {
    let Some(image) = firmware::image("smart_car") else {
        return;
    };
    let mut image = fs::read(image).unwrap();
    image[18] = 243; // RISC-V
    let told = EmulatedBoard::new(&image, NoWires).unwrap_err();
    assert_eq!(
        told,
        BoardError::NotAnImage("it is for another processor".into())
    );
}

/// Nothing on the pins.
#[derive(Debug)]
struct NoWires;

impl Wires for NoWires {
    fn set_level(&mut self, _: Line, _: bool, _: u64) {}

    fn level(&mut self, _: Line, _: u64) -> bool {
        false
    }

    fn set_pulse(&mut self, _: Channel, _: u32, _: u64) {}
}

/// With nothing on its pins the car has no reading, and goes on all the same: the watchdog is fed.
#[test]
fn without_any_device_the_schedule_goes_on() {
    let Some(image) = firmware::image("smart_car") else {
        return;
    };
    let image = fs::read(image).unwrap();
    let mut board = EmulatedBoard::new(&image, NoWires).unwrap();
    assert_eq!(board.run_until(10 * ROUND_MS, |_| false), Ok(false));
    assert!(!board.take_serial().is_empty());
}

#[test]
fn an_image_takes_of_the_flash_what_a_programmer_writes() {
    let Some(path) = firmware::image("smart_car") else {
        return;
    };
    let told = Image::load(Some(&path), "smart_car").unwrap().sizes();
    let bytes = fs::read(path).unwrap();
    let file = object::File::parse(&*bytes).unwrap();
    let written = file.segments().map(|segment| segment.file_range().1);
    assert_eq!(u64::from(told.flash_bytes), written.sum::<u64>());
}
