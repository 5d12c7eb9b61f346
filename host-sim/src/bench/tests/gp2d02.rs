use super::pins::{Clock, Infrared, Input, Output, Wired, pins};
use crate::bench::{Gp2d02Line, LineFault, MICROSECOND, MILLISECOND};
use certainty_core::transducer::Missing;
use certainty_firmware::gp2d02::{CONVERSION_US, Fault, Gp2d02, MEASURE_US, READ_US, START_US};
use certainty_firmware::stopwatch::OPERATION_US;
use core::cell::RefCell;
use std::rc::Rc;

/// A driver, its sensor, and the clock of both.
struct Setup {
    clock: Clock,
    driver: Gp2d02<Output<Infrared>, Input<Infrared>>,
    sensor: Rc<RefCell<Infrared>>,
}

const FAULTS: [LineFault; 6] = [
    LineFault::StuckHigh,
    LineFault::StuckLow,
    LineFault::Floating { seed: 7 },
    LineFault::UnpluggedMidConversion,
    LineFault::CutShort,
    LineFault::Mute,
];

impl Setup {
    fn new(byte: u8, operation_us: u32) -> Self {
        let clock = Clock::new(operation_us);
        let sensor = Infrared {
            line: Gp2d02Line::new(),
            byte: Some(byte),
            edges: Vec::new(),
            conversions: 0,
        };
        let wired = Wired::new(&clock, sensor);
        let (vin, vout) = pins(&wired);
        Self {
            clock,
            driver: Gp2d02::new(vin, vout),
            sensor: wired.device,
        }
    }

    fn start(&mut self) -> Result<(), Fault> {
        self.driver.start(&mut self.clock)
    }

    fn read(&mut self) -> Result<u8, Fault> {
        self.driver.read(&mut self.clock)
    }

    fn measure(&mut self) -> Result<u8, Fault> {
        self.driver.measure(&mut self.clock)
    }

    fn pass_ms(&mut self, ms: u64) {
        self.clock.advance(ms * MILLISECOND);
    }

    /// A slot of the schedule: started, left alone for 70 ms, read.
    fn slot(&mut self) -> Result<u8, Fault> {
        self.start()?;
        self.pass_ms(70);
        self.read()
    }

    fn set_fault(&mut self, fault: Option<LineFault>) {
        let now_ns = self.clock.now();
        self.sensor.borrow_mut().line.set_fault(fault, now_ns);
    }
}

#[test]
fn every_byte_arrives_however_long_operations_take() {
    for operation_us in [0, 1, OPERATION_US] {
        for byte in 0..=u8::MAX {
            let mut setup = Setup::new(byte, operation_us);
            assert_eq!(setup.slot(), Ok(byte));
            setup.sensor.borrow_mut().byte = Some(!byte);
            assert_eq!(setup.measure(), Ok(!byte));
            assert_eq!(setup.sensor.borrow().conversions, 2);
        }
    }
}

#[test]
fn no_step_takes_longer_than_it_says() {
    for byte in [0, 0xFF] {
        let mut setup = Setup::new(byte, OPERATION_US);
        let clock = setup.clock.clone();
        let mut since = clock.now();
        let mut took_us = || {
            let took = (clock.now() - since) / MICROSECOND;
            since = clock.now();
            took as u32
        };
        setup.start().unwrap();
        // What is not needed is what giving up would take: letting go of Vin.
        assert_eq!(took_us(), START_US - OPERATION_US);
        setup.pass_ms(70);
        took_us();
        setup.read().unwrap();
        assert_eq!(took_us(), READ_US - OPERATION_US);
        setup.sensor.borrow_mut().byte = None;
        setup.measure().unwrap_err();
        assert!((100_000..=MEASURE_US).contains(&took_us()));
    }
}

#[test]
fn each_half_of_the_clocks_period_has_50_to_100_us_and_the_end_2_ms() {
    for operation_us in [0, OPERATION_US] {
        let mut setup = Setup::new(0xA5, operation_us);
        setup.slot().unwrap();
        let sensor = setup.sensor.borrow();
        // Down to start, eight times up and down, up to end.
        assert_eq!(sensor.edges.len(), 1 + 2 * 8 + 1);
        for pair in sensor.edges[1..].windows(2) {
            let half_us = (pair[1].0 - pair[0].0) / MICROSECOND;
            assert!((50..=100).contains(&half_us), "{half_us}");
        }
        let (end_ns, high) = sensor.edges[17];
        assert!(high && setup.clock.now() - end_ns >= 2 * MILLISECOND);
    }
}

/// What the first two slots of a faulty line say, and whether the third is right after healing.
fn around(fault: LineFault, byte: u8) -> [Result<u8, Fault>; 3] {
    let mut setup = Setup::new(byte, 1);
    assert_eq!(setup.slot(), Ok(byte));
    setup.pass_ms(20);
    setup.set_fault(Some(fault));
    let first = setup.slot();
    setup.pass_ms(20);
    let second = setup.slot();
    setup.set_fault(None);
    setup.pass_ms(20);
    [first, second, setup.slot()]
}

#[test]
fn each_fault_of_the_line_is_named_and_the_sensor_is_back_once_it_heals() {
    use Fault::{CutShort, Floating, StuckHigh, StuckLow, Timeout};
    for byte in [0, 75, 190, 0xFF] {
        let expected = |first, second| [Err(first), Err(second), Ok(byte)];
        for (fault, [first, second]) in [
            (LineFault::StuckHigh, [StuckHigh, StuckHigh]),
            (LineFault::StuckLow, [StuckLow, StuckLow]),
            (LineFault::Floating { seed: 7 }, [Floating, Floating]),
            (LineFault::UnpluggedMidConversion, [Timeout, StuckLow]),
            (LineFault::CutShort, [CutShort, CutShort]),
            (LineFault::Mute, [Timeout, Timeout]),
        ] {
            assert_eq!(around(fault, byte), expected(first, second), "{fault:?}");
        }
    }
}

#[test]
fn a_sensor_that_does_not_convert_is_a_timeout_and_comes_back() {
    let mut setup = Setup::new(75, 0);
    setup.sensor.borrow_mut().byte = None;
    assert_eq!(setup.slot(), Err(Fault::Timeout));
    setup.pass_ms(2);
    setup.sensor.borrow_mut().byte = Some(76);
    assert_eq!(setup.slot(), Ok(76));
}

#[test]
fn noise_never_reads_as_a_byte() {
    let mut reasons = [0, 0];
    for seed in 0..4_000 {
        let mut setup = Setup::new(75, 1);
        setup.set_fault(Some(LineFault::Floating { seed }));
        match setup.slot().unwrap_err().reason() {
            Missing::Bus => reasons[0] += 1,
            _ => reasons[1] += 1,
        }
    }
    // It passes for an idle, then for a converting line in one of 2^10 cases, for one that never
    // gets done in one of 2^15.
    assert!(reasons[0] >= 3_995, "{reasons:?}");
}

/// Starts a conversion, runs `fault` from `from_ms` of it to `until_ms`, and reads at 70 ms.
fn struck(fault: LineFault, from_ms: u64, until_ms: u64) -> (Setup, Result<u8, Fault>) {
    let mut setup = Setup::new(75, 0);
    setup.start().unwrap();
    setup.pass_ms(from_ms);
    setup.set_fault(Some(fault));
    setup.pass_ms(until_ms - from_ms);
    if until_ms < 70 {
        setup.set_fault(None);
        setup.pass_ms(70 - until_ms);
    }
    let read = setup.read();
    (setup, read)
}

#[test]
fn what_comes_and_goes_during_a_conversion_reads_right_or_missing() {
    for fault in FAULTS {
        for from_ms in 0..69 {
            for until_ms in from_ms + 1..70 {
                let (mut setup, read) = struck(fault, from_ms, until_ms);
                let lost = fault == LineFault::UnpluggedMidConversion;
                let expected = if lost { Err(Fault::Timeout) } else { Ok(75) };
                assert_eq!(read, expected, "{fault:?} {from_ms}..{until_ms}");
                setup.pass_ms(10);
                assert_eq!(setup.slot(), Ok(75));
            }
        }
    }
}

#[test]
fn what_comes_during_a_conversion_and_stays_reads_missing() {
    for from_ms in 0..69 {
        for (fault, expected) in [
            (LineFault::StuckLow, Fault::Timeout),
            (LineFault::UnpluggedMidConversion, Fault::Timeout),
            (LineFault::CutShort, Fault::CutShort),
            (LineFault::Mute, Fault::Timeout),
        ] {
            let (mut setup, read) = struck(fault, from_ms, 70);
            assert_eq!(read, Err(expected), "{fault:?} from {from_ms}");
            setup.set_fault(None);
            setup.pass_ms(10);
            assert_eq!(setup.slot(), Ok(75));
        }
        let noise = LineFault::Floating { seed: from_ms };
        assert!(struck(noise, from_ms, 70).1.is_err());
    }
}

#[test]
fn a_line_that_sticks_high_during_a_conversion_reads_255_once_and_no_more() {
    // Nothing in the protocol tells it from a sensor that sends ones.
    let (mut setup, read) = struck(LineFault::StuckHigh, 30, 70);
    assert_eq!(read, Ok(0xFF));
    assert_eq!(setup.slot(), Err(Fault::StuckHigh));
}

#[test]
fn a_conversion_has_its_70_ms_and_less_is_a_timeout() {
    let mut setup = Setup::new(75, 0);
    setup.start().unwrap();
    setup.pass_ms(60);
    assert_eq!(setup.driver.ready(), Ok(false));
    assert_eq!(setup.read(), Err(Fault::Timeout));
    assert!(Gp2d02Line::CONVERSION_NS < u64::from(CONVERSION_US) * MICROSECOND);
}

#[test]
fn the_sensor_misses_a_clock_that_is_too_fast_and_nothing_but_2_ms_ends_the_bits() {
    let mut setup = Setup::new(0b1000_0000, 0);
    setup.start().unwrap();
    setup.pass_ms(70);
    let mut sensor = setup.sensor.borrow_mut();
    let mut now_ns = setup.clock.now();
    let mut clock = |sensor: &mut Infrared, high_ns| {
        sensor.set_vin(true, now_ns);
        now_ns += high_ns;
        sensor.set_vin(false, now_ns);
        let bit = sensor.line.vout(now_ns);
        now_ns += 50_000;
        bit
    };
    assert!(clock(&mut sensor, 50_000)); // the first bit
    assert!(clock(&mut sensor, 49_999)); // still
    assert!(!clock(&mut sensor, 50_000)); // the second
    assert!(!clock(&mut sensor, 1_999_999)); // the third
    assert_eq!(sensor.conversions, 1);
    assert!(!clock(&mut sensor, 2_000_000)); // idle, and a new conversion
    assert_eq!(sensor.conversions, 2);
}
