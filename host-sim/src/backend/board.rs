//! The Smart Car's board: the emulated microcontroller with the bench's devices on its pins.
//!
//! [`EmulatedBoard`] connects a [`Stm32f100`], which runs the image that is flashed, to [`Wires`]: the wiring
//! of `docs/hardware.md`. The same image with the same devices does the same in the same cycle, every run.

pub use certainty_stm32::{ResetCause, RunError as BoardError, UnmodelledRegister};

use super::image::Image;
use super::outcome::{BackendError, RunDetails};
use crate::bench::{Bench, Wires};
use certainty_firmware::remote::{Channel, Line};
use certainty_stm32::{Connection, Pin, Pins, Port, Stm32f100, Timer};

/// Milliseconds without a byte after which all reports of a round are complete.
const QUIET_MS: u32 = 2;

/// Milliseconds of the board's time without a byte after which a run ends with an error: a round takes
/// 800.
const SILENCE_LIMIT_MS: u32 = 10_000;

/// The lines, their pins, and how the devices are connected.
const LINES: [(Pin, Line, Connection); 10] = [
    vin(Pin::new(Port::B, 12), 0, "Vin of sensor 1"),
    vin(Pin::new(Port::B, 13), 1, "Vin of sensor 2"),
    vin(Pin::new(Port::B, 14), 2, "Vin of sensor 3"),
    from_device(Pin::new(Port::C, 10), Line::Vout(0)),
    from_device(Pin::new(Port::C, 11), Line::Vout(1)),
    from_device(Pin::new(Port::C, 12), Line::Vout(2)),
    trigger(Pin::new(Port::C, 0), 0),
    trigger(Pin::new(Port::C, 1), 1),
    from_device(Pin::new(Port::B, 10), Line::Echo(0)),
    from_device(Pin::new(Port::B, 11), Line::Echo(1)),
];

/// The timers' channels that are connected, and to what.
const PULSES: [(Timer, u8, Channel); 5] = [
    (Timer::Tim3, 0, Channel::Servo(0)),
    (Timer::Tim3, 1, Channel::Servo(1)),
    (Timer::Tim3, 2, Channel::Servo(2)),
    (Timer::Tim4, 0, Channel::Motor(0)),
    (Timer::Tim4, 1, Channel::Motor(1)),
];

/// A GP2D02's Vin, which the sensor pulls up itself and which takes at most 3 V.
const fn vin(pin: Pin, slot: u8, name: &'static str) -> (Pin, Line, Connection) {
    (pin, Line::Vin(slot), Connection::OpenDrain(name))
}

const fn trigger(pin: Pin, slot: u8) -> (Pin, Line, Connection) {
    (pin, Line::Trigger(slot), Connection::ToDevice)
}

const fn from_device(pin: Pin, line: Line) -> (Pin, Line, Connection) {
    (pin, line, Connection::FromDevice)
}

/// The devices of the Smart Car by pin.
#[derive(Debug)]
pub struct CarPins<W>(pub W);

fn line_at(pin: Pin) -> Option<Line> {
    let found = LINES.iter().find(|(at, ..)| *at == pin);
    found.map(|&(_, line, _)| line)
}

impl<W: Wires> Pins for CarPins<W> {
    fn set_level(&mut self, pin: Pin, high: bool, now_ns: u64) {
        if let Some(line) = line_at(pin) {
            self.0.set_level(line, high, now_ns);
        }
    }

    fn level(&mut self, pin: Pin, now_ns: u64) -> bool {
        line_at(pin).is_some_and(|line| self.0.level(line, now_ns))
    }

    fn set_pulse(&mut self, timer: Timer, channel: u8, width_us: u32, now_ns: u64) {
        let mut connected = PULSES.iter();
        let found = connected.find(|(of, number, _)| (*of, *number) == (timer, channel));
        if let Some(&(.., channel)) = found {
            self.0.set_pulse(channel, width_us, now_ns);
        }
    }
}

/// An emulated board that runs a firmware image against the devices of a Smart Car.
pub type EmulatedBoard<W> = Stm32f100<CarPins<W>>;

/// Creates a board with the program of the ELF file `elf` in its flash, before its first instruction after
/// power-on.
///
/// # Errors
///
/// [`BoardError::NotAnImage`] where `elf` is no program for it.
pub fn emulated_board<W: Wires + Send + 'static>(
    elf: &[u8],
    wires: W,
) -> Result<EmulatedBoard<W>, BoardError> {
    let wiring = LINES.map(|(pin, _, connection)| (pin, connection));
    Stm32f100::new(elf, &wiring, CarPins(wires))
}

/// Runs `image` against `bench` until `done` returns true for its telemetry.
///
/// # Errors
///
/// [`BackendError::BadImage`] or [`BackendError::Board`], with what ended the run.
pub(super) fn run(
    image: &Image,
    bench: Bench,
    done: &mut dyn FnMut(&[u8]) -> bool,
) -> Result<RunDetails, BackendError> {
    let failed = |error: BoardError| BackendError::Board(error.to_string());
    let mut board = emulated_board(image.bytes(), bench).map_err(|error| match error {
        BoardError::NotAnImage(why) => BackendError::BadImage {
            path: image.path().to_path_buf(),
            why,
        },
        error => failed(error),
    })?;
    let mut is_done = false;
    let mut quiet_ms = 0;
    // The stack is read after the last report, when the port has nothing left to send.
    while !is_done || quiet_ms < QUIET_MS {
        if quiet_ms == SILENCE_LIMIT_MS {
            return Err(BackendError::Timeout);
        }
        board.step_ms().map_err(failed)?;
        let telemetry = board.take_serial();
        quiet_ms = if telemetry.is_empty() {
            quiet_ms + 1
        } else {
            0
        };
        is_done |= !telemetry.is_empty() && done(&telemetry);
    }
    Ok(RunDetails {
        sizes: Some(image.sizes()),
        stack_bytes: Some(board.stack_bytes()),
        ground_truth: board.with_pins(|pins| pins.0.ground_truth().to_vec()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Records its calls; Vout 1 and Echo 0 are high.
    #[derive(Debug, Default)]
    struct Recorder(Vec<String>);

    impl Wires for Recorder {
        fn set_level(&mut self, line: Line, high: bool, now_ns: u64) {
            self.0.push(format!("{line:?} {high} at {now_ns}"));
        }

        fn level(&mut self, line: Line, _: u64) -> bool {
            matches!(line, Line::Vout(1) | Line::Echo(0))
        }

        fn set_pulse(&mut self, channel: Channel, width_us: u32, now_ns: u64) {
            self.0.push(format!("{channel:?} {width_us} at {now_ns}"));
        }
    }

    #[test]
    fn pins_are_the_lines_of_the_wiring() {
        let mut pins = CarPins(Recorder::default());
        pins.set_level(Pin::new(Port::B, 12), false, 1);
        pins.set_level(Pin::new(Port::C, 1), true, 2);
        pins.set_level(Pin::new(Port::A, 0), true, 3);
        assert_eq!(pins.0.0, ["Vin(0) false at 1", "Trigger(1) true at 2"]);
        let high = LINES.iter().filter(|(pin, ..)| pins.level(*pin, 4));
        let high: Vec<Line> = high.map(|&(_, line, _)| line).collect();
        assert_eq!(high, [Line::Vout(1), Line::Echo(0)]);
    }

    #[test]
    fn channels_are_the_servos_and_motors_of_the_wiring() {
        let mut pins = CarPins(Recorder::default());
        for timer in [Timer::Tim3, Timer::Tim4] {
            for channel in 0..3 {
                pins.set_pulse(timer, channel, 1_500, 7);
            }
        }
        let expected = ["Servo(0)", "Servo(1)", "Servo(2)", "Motor(0)", "Motor(1)"];
        assert_eq!(pins.0.0, expected.map(|name| format!("{name} 1500 at 7")));
    }

    #[test]
    fn each_vin_is_open_drain_and_named_by_its_sensor() {
        for (_, line, connection) in LINES {
            let expected = match line {
                Line::Vin(0) => Connection::OpenDrain("Vin of sensor 1"),
                Line::Vin(1) => Connection::OpenDrain("Vin of sensor 2"),
                Line::Vin(_) => Connection::OpenDrain("Vin of sensor 3"),
                Line::Trigger(_) => Connection::ToDevice,
                Line::Vout(_) | Line::Echo(_) => Connection::FromDevice,
            };
            assert_eq!(connection, expected, "{line:?}");
        }
    }
}
