use super::*;
use embedded_hal_mock::eh1::MockError;
use embedded_hal_mock::eh1::delay::{CheckedDelay, NoopDelay, Transaction as Wait};
use embedded_hal_mock::eh1::digital::{Mock as Pin, State as Level, Transaction as PinStep};
use std::io::ErrorKind;

/// A stopwatch that shows what it is told to, then nothing more.
struct Shown(Vec<u32>);

impl Stopwatch for Shown {
    fn micros(&mut self) -> u32 {
        self.0.remove(0)
    }
}

struct Frozen;

impl Stopwatch for Frozen {
    fn micros(&mut self) -> u32 {
        7
    }
}

fn pulse() -> [PinStep; 2] {
    [PinStep::set(Level::High), PinStep::set(Level::Low)]
}

fn looks(levels: &[(u32, Level)]) -> Pin {
    let mut steps = Vec::new();
    for &(times, level) in levels {
        steps.extend((0..times).map(|_| PinStep::get(level)));
    }
    Pin::new(&steps)
}

fn measured(
    ranger: Ranger<Pin, Pin>,
    waits: u32,
    stopwatch: &mut impl Stopwatch,
) -> Result<Reading, Fault> {
    let mut ranger = ranger;
    let mut steps = vec![Wait::delay_us(12)];
    steps.extend((0..waits).map(|_| Wait::delay_us(10)));
    let mut delay = CheckedDelay::new(&steps);
    let result = ranger.measure(&mut delay, stopwatch);
    delay.done();
    let (mut trigger, mut echo) = ranger.release();
    trigger.done();
    echo.done();
    result
}

fn ranger(echo: Pin) -> Ranger<Pin, Pin> {
    Ranger::new(Pin::new(&pulse()), echo, RangerLimits::SRF04)
}

#[test]
fn the_pulse_between_echos_edges_is_the_distance_also_where_the_stopwatch_wraps() {
    let echo = looks(&[(1 + 2, Level::Low), (1 + 3, Level::High), (1, Level::Low)]);
    let start = u32::MAX - 30;
    let mut stopwatch = Shown(
        [0, 10, 20, 40, 40, 51, 62, 73, 40 + 290]
            .map(|us| start.wrapping_add(us))
            .to_vec(),
    );
    // Low at 10 and 20, high at 40; then high at 51, 62 and 73, low at 330: 290 µs are 5 cm.
    let reading = measured(ranger(echo), 2 + 3, &mut stopwatch);
    assert_eq!(reading, Ok(Reading::Echo(Millimeters::new(50))));
    assert!(stopwatch.0.is_empty());
}

#[test]
fn a_line_that_is_high_before_the_trigger_gets_no_trigger() {
    let mut ranger = Ranger::new(
        Pin::new(&[]),
        looks(&[(1, Level::High)]),
        RangerLimits::SRF04,
    );
    let result = ranger.measure(&mut NoopDelay::new(), &mut Frozen);
    assert_eq!(result, Err(Fault::StuckHigh));
    let (mut trigger, mut echo) = ranger.release();
    trigger.done();
    echo.done();
}

#[test]
fn a_ranger_that_does_not_answer_is_given_up_by_the_stopwatch() {
    let echo = looks(&[(1 + 2, Level::Low)]);
    let mut stopwatch = Shown(vec![100, 5_100, 5_101]);
    let reading = measured(ranger(echo), 1, &mut stopwatch);
    assert_eq!(reading, Err(Fault::NoAnswer));
}

#[test]
fn a_pulse_that_does_not_end_is_given_up_by_the_stopwatch() {
    let echo = looks(&[(1, Level::Low), (1 + 2, Level::High)]);
    let mut stopwatch = Shown(vec![0, 10, 20, 50_020, 50_021]);
    let reading = measured(ranger(echo), 1, &mut stopwatch);
    assert_eq!(reading, Err(Fault::Endless));
}

#[test]
fn a_stopwatch_that_stands_still_bounds_no_less() {
    // 5 and 50 ms in waits of 10 µs, and a last look after each.
    let echo = looks(&[(1 + 501, Level::Low)]);
    assert_eq!(
        measured(ranger(echo), 501, &mut Frozen),
        Err(Fault::NoAnswer)
    );
    let echo = looks(&[(1, Level::Low), (1 + 5_001, Level::High)]);
    assert_eq!(
        measured(ranger(echo), 5_001, &mut Frozen),
        Err(Fault::Endless)
    );
    // 501 and 5001 turns of 25 µs and what is around them: under a seventh of a second.
    assert!((137_550..138_000).contains(&MEASURE_BLIND_US));
}

#[test]
fn a_stopwatch_that_stands_still_tells_no_distance() {
    let echo = looks(&[(1, Level::Low), (1 + 100, Level::High), (1, Level::Low)]);
    assert_eq!(
        measured(ranger(echo), 100, &mut Frozen),
        Err(Fault::Stopwatch)
    );
}

#[test]
fn a_pin_that_refuses_is_a_fault() {
    let refusal = || MockError::Io(ErrorKind::NotConnected);
    let echo = Pin::new(&[PinStep::get(Level::Low).with_error(refusal())]);
    let mut blind = Ranger::new(Pin::new(&[]), echo, RangerLimits::SRF04);
    let result = blind.measure(&mut NoopDelay::new(), &mut Frozen);
    assert_eq!(result, Err(Fault::Pin));
    let (mut trigger, mut echo) = blind.release();
    trigger.done();
    echo.done();

    let trigger = Pin::new(&[PinStep::set(Level::High).with_error(refusal())]);
    let mut mute = Ranger::new(trigger, looks(&[(1, Level::Low)]), RangerLimits::SRF04);
    let result = mute.measure(&mut NoopDelay::new(), &mut Frozen);
    assert_eq!(result, Err(Fault::Pin));
    let (mut trigger, mut echo) = mute.release();
    trigger.done();
    echo.done();
}

#[test]
fn every_pulse_within_half_a_centimetre_is_that_centimetre() {
    let limits = RangerLimits::SRF04;
    for centimeter in 3..=300_u32 {
        let exact = centimeter * 58;
        let expected = Reading::Echo(Millimeters::new(centimeter * 10));
        for width in exact - 29..exact + 29 {
            assert_eq!(limits.reading(width), expected);
        }
    }
    assert_eq!(limits.reading(3 * 58 - 30), Reading::TooNear);
    assert_eq!(limits.reading(300 * 58 + 29), Reading::NoObject);
    assert_eq!(limits.reading(u32::MAX), Reading::NoObject);
    assert_eq!(limits.reading(0), Reading::TooNear);
}

#[test]
fn limits_that_cannot_be_are_refused() {
    let limits = |near, far| RangerLimits::try_new(Millimeters::new(near), Millimeters::new(far));
    assert_eq!(limits(30, 30), Err(RangerLimitsError::EmptyRange));
    assert_eq!(limits(30, 6_001), Err(RangerLimitsError::TooFar));
    assert_eq!(limits(30, 3_000), Ok(RangerLimits::SRF04));
    assert!(RangerLimits::FARTHEST.get() / 10 * US_PER_CM < 36_000);
}

#[test]
fn each_fault_has_the_reason_of_its_kind() {
    assert_eq!(Fault::NoAnswer.reason(), Missing::Timeout);
    assert_eq!(Fault::Endless.reason(), Missing::Timeout);
    assert_eq!(Fault::StuckHigh.reason(), Missing::Bus);
    assert_eq!(Fault::Pin.reason(), Missing::Bus);
    assert_eq!(Fault::Stopwatch.reason(), Missing::Implausible);
}
