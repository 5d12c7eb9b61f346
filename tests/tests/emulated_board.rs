//! The image that is flashed, pin by pin on the emulated board.

use certainty_firmware::remote::{Channel, Line};
use certainty_sim::backend::Image;
use certainty_sim::backend::board::{BoardError, EmulatedBoard};
use certainty_sim::bench::{Bench, BenchSetup, Wires};
use certainty_sim::experiment::Crew;
use certainty_sim::world::World;
use certainty_tests::firmware;
use object::{Object, ObjectSegment};
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
        crew: Crew::default(),
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
    let pulses = board.with_wires(|wires| wires.pulses.clone());
    let first_servo = pulses[0].2;
    let motors = pulses
        .iter()
        .filter(|one| matches!(one.0, Channel::Motor(_)));
    let motors: Vec<_> = motors.copied().collect();
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
