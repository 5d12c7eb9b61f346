//! Transcripts: every level, every sample and every wait, in the order of the protocol.

use super::*;
use embedded_hal_mock::eh1::MockError;
use embedded_hal_mock::eh1::delay::{CheckedDelay, Transaction as Wait};
use embedded_hal_mock::eh1::digital::{Mock as Pin, State as Level, Transaction as PinStep};
use std::io::ErrorKind;

/// What the three mocks expect.
#[derive(Default)]
struct Transcript {
    vin: Vec<PinStep>,
    vout: Vec<PinStep>,
    waits: Vec<Wait>,
}

impl Transcript {
    fn vin(mut self, level: Level) -> Self {
        self.vin.push(PinStep::set(level));
        self
    }

    fn vout(mut self, level: Level) -> Self {
        self.vout.push(PinStep::get(level));
        self
    }

    fn wait(mut self, us: u32) -> Self {
        self.waits.push(Wait::delay_us(us));
        self
    }

    /// Five samples, 20 µs apart.
    fn check(self, level: Level) -> Self {
        (1..5).fold(self.vout(level), |script, _| script.wait(20).vout(level))
    }

    fn start(self) -> Self {
        let script = self.check(Level::High).vin(Level::Low).wait(200);
        script.check(Level::Low)
    }

    fn bits(self, bits: &[Level]) -> Self {
        bits.iter().fold(self, |script, &bit| {
            let script = script.vin(Level::High).wait(60).vin(Level::Low);
            script.wait(30).vout(bit).wait(30).vout(bit)
        })
    }

    fn byte(self, byte: u8) -> Self {
        let bits = format!("{byte:08b}");
        let bits: Vec<Level> = bits
            .chars()
            .map(|bit| if bit == '1' { Level::High } else { Level::Low })
            .collect();
        self.check(Level::High)
            .bits(&bits)
            .vin(Level::High)
            .wait(2_200)
    }

    /// Runs `act` on a new driver; everything expected must have happened.
    fn run<T>(self, act: impl FnOnce(&mut Gp2d02<Pin, Pin>, &mut CheckedDelay) -> T) -> T {
        let mut delay = CheckedDelay::new(&self.waits);
        let mut sensor = Gp2d02::new(Pin::new(&self.vin), Pin::new(&self.vout));
        let result = act(&mut sensor, &mut delay);
        delay.done();
        let (mut vin, mut vout) = sensor.release();
        vin.done();
        vout.done();
        result
    }
}

fn script() -> Transcript {
    Transcript::default()
}

fn refusal() -> MockError {
    MockError::Io(ErrorKind::NotConnected)
}

#[test]
fn a_reading_follows_the_protocol_and_the_highest_bit_comes_first() {
    for byte in [0x00, 0x80, 0x01, 0xA5, 190, 75, 0xFF] {
        let read = script()
            .start()
            .vout(Level::Low) // not ready yet
            .vout(Level::High)
            .byte(byte)
            .check(Level::High)
            .run(|sensor, delay| {
                sensor.start(delay).unwrap();
                assert_eq!(sensor.ready(), Ok(false));
                assert_eq!(sensor.ready(), Ok(true));
                sensor.read(delay)
            });
        assert_eq!(read, Ok(byte));
    }
}

#[test]
fn a_blocking_measurement_polls_every_millisecond() {
    let read = script()
        .start()
        .vout(Level::Low)
        .wait(1_000)
        .vout(Level::Low)
        .wait(1_000)
        .vout(Level::High)
        .byte(108)
        .check(Level::High)
        .run(|sensor, delay| sensor.measure(delay));
    assert_eq!(read, Ok(108));
}

#[test]
fn a_blocking_measurement_gives_up_after_100_ms_and_lets_vin_go() {
    let waiting = (0..100).fold(script().start(), |script, _| {
        script.vout(Level::Low).wait(1_000)
    });
    let read = waiting
        .check(Level::Low)
        .vin(Level::High)
        .run(|sensor, delay| sensor.measure(delay));
    assert_eq!(read, Err(Fault::Timeout));
}

#[test]
fn a_line_that_is_low_before_the_start_starts_nothing() {
    let started = script()
        .check(Level::Low)
        .vin(Level::High)
        .run(|sensor, delay| sensor.start(delay));
    assert_eq!(started, Err(Fault::StuckLow));
}

#[test]
fn a_line_that_stays_high_is_stuck_high() {
    let started = script()
        .check(Level::High)
        .vin(Level::Low)
        .wait(200)
        .check(Level::High)
        .vin(Level::High)
        .run(|sensor, delay| sensor.start(delay));
    assert_eq!(started, Err(Fault::StuckHigh));
}

#[test]
fn one_sample_that_differs_is_a_floating_line() {
    let started = script()
        .vout(Level::High)
        .wait(20)
        .vout(Level::High)
        .wait(20)
        .vout(Level::Low)
        .vin(Level::High)
        .run(|sensor, delay| sensor.start(delay));
    assert_eq!(started, Err(Fault::Floating));
}

#[test]
fn a_bit_that_changes_while_it_is_sampled_is_a_floating_line() {
    let read = script()
        .start()
        .check(Level::High)
        .bits(&[Level::High, Level::Low])
        .vin(Level::High)
        .wait(60)
        .vin(Level::Low)
        .wait(30)
        .vout(Level::High)
        .wait(30)
        .vout(Level::Low)
        .vin(Level::High)
        .run(|sensor, delay| {
            sensor.start(delay).unwrap();
            sensor.read(delay)
        });
    assert_eq!(read, Err(Fault::Floating));
}

#[test]
fn a_line_that_stays_low_after_the_bits_voids_them() {
    let read = script()
        .start()
        .byte(0b1010_0000)
        .check(Level::Low)
        .vin(Level::High)
        .run(|sensor, delay| {
            sensor.start(delay).unwrap();
            sensor.read(delay)
        });
    assert_eq!(read, Err(Fault::CutShort));
}

#[test]
fn a_late_conversion_is_given_up_and_the_next_one_works() {
    let read = script()
        .start()
        .check(Level::Low)
        .vin(Level::High)
        .start()
        .byte(75)
        .check(Level::High)
        .run(|sensor, delay| {
            sensor.start(delay).unwrap();
            assert_eq!(sensor.read(delay), Err(Fault::Timeout));
            sensor.start(delay).unwrap();
            sensor.read(delay)
        });
    assert_eq!(read, Ok(75));
}

#[test]
fn a_read_without_a_start_and_a_second_start_are_out_of_turn() {
    script()
        .vin(Level::High)
        .vin(Level::High)
        .start()
        .vin(Level::High)
        .start()
        .run(|sensor, delay| {
            assert_eq!(sensor.read(delay), Err(Fault::OutOfTurn));
            assert_eq!(sensor.ready(), Err(Fault::OutOfTurn));
            assert_eq!(sensor.start(delay), Ok(()));
            assert_eq!(sensor.start(delay), Err(Fault::OutOfTurn));
            assert_eq!(sensor.start(delay), Ok(()));
        });
}

#[test]
fn a_pin_that_refuses_is_a_fault_and_vin_is_let_go() {
    let mut refused = script();
    refused
        .vout
        .push(PinStep::get(Level::High).with_error(refusal()));
    let started = refused
        .vin(Level::High)
        .run(|sensor, delay| sensor.start(delay));
    assert_eq!(started, Err(Fault::Pin));

    let mut refused = script().check(Level::High);
    refused
        .vin
        .push(PinStep::set(Level::Low).with_error(refusal()));
    refused
        .vin
        .push(PinStep::set(Level::High).with_error(refusal()));
    let started = refused.run(|sensor, delay| sensor.start(delay));
    assert_eq!(started, Err(Fault::Pin));
}

#[test]
fn each_fault_has_the_reason_of_its_kind() {
    use certainty_core::transducer::Missing;
    for fault in [
        Fault::StuckLow,
        Fault::StuckHigh,
        Fault::Floating,
        Fault::CutShort,
        Fault::Pin,
    ] {
        assert_eq!(fault.reason(), Missing::Bus, "{fault}");
    }
    for fault in [Fault::Timeout, Fault::OutOfTurn] {
        assert_eq!(fault.reason(), Missing::Timeout, "{fault}");
    }
}

#[test]
fn the_stated_durations_are_the_transcripts() {
    // Each mock's step is an operation, and so is each call of a wait.
    let longest = |script: &Transcript| {
        let operations = script.vin.len() + script.vout.len() + script.waits.len();
        let mut us = 5 * operations as u32;
        for wait in [20, 30, 60, 200, 1_000, 2_200] {
            let same = Wait::delay_us(wait);
            us += wait * script.waits.iter().filter(|step| **step == same).count() as u32;
        }
        us
    };
    // The worst is what fails at the very end.
    let start = script()
        .check(Level::High)
        .vin(Level::Low)
        .wait(200)
        .check(Level::High)
        .vin(Level::High);
    assert_eq!(START_US, longest(&start));
    let read = script().byte(0).check(Level::Low).vin(Level::High);
    assert_eq!(READ_US, longest(&read));
    let waiting = (0..100).fold(script(), |script, _| script.vout(Level::Low).wait(1_000));
    assert_eq!(MEASURE_US, START_US + longest(&waiting) + READ_US);
}
