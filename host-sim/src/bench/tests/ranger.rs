use super::pins::{Clock, Input, Output, Ultrasonic, Wired, pins};
use crate::bench::{LineFault, MICROSECOND, MILLISECOND, RangerAnswer, RangerLine};
use certainty_core::transducer::Reading;
use certainty_core::units::Millimeters;
use certainty_firmware::ranger::{Fault, MEASURE_US, Ranger, RangerLimits};
use certainty_firmware::stopwatch::OPERATION_US;
use core::cell::RefCell;
use std::rc::Rc;

struct Setup {
    clock: Clock,
    driver: Ranger<Output<Ultrasonic>, Input<Ultrasonic>>,
    sensor: Rc<RefCell<Ultrasonic>>,
}

impl Setup {
    fn new(answer: Option<RangerAnswer>, operation_us: u32) -> Self {
        let clock = Clock::new(operation_us);
        let sensor = Ultrasonic {
            line: RangerLine::new(),
            answer,
            heard: 0,
        };
        let wired = Wired::new(&clock, sensor);
        let (trigger, echo) = pins(&wired);
        Self {
            clock,
            driver: Ranger::new(trigger, echo, RangerLimits::SRF04),
            sensor: wired.device,
        }
    }

    /// Measures and lets the echoes fade.
    fn measure(&mut self) -> Result<Reading, Fault> {
        let since = self.clock.now();
        let mut stopwatch = self.clock.clone();
        let reading = self.driver.measure(&mut self.clock, &mut stopwatch);
        let took = self.clock.now() - since;
        assert!(took <= u64::from(MEASURE_US) * MICROSECOND);
        self.clock.advance(20 * MILLISECOND);
        reading
    }
}

#[test]
fn every_centimetre_arrives_however_long_operations_take() {
    for operation_us in [0, 1, OPERATION_US] {
        for cm in 1..=320 {
            let mut setup = Setup::new(Some(RangerAnswer::Object { cm }), operation_us);
            let expected = match cm {
                1..3 => Reading::TooNear,
                3..=300 => Reading::Echo(Millimeters::new(u32::from(cm) * 10)),
                _ => Reading::NoObject,
            };
            assert_eq!(setup.measure(), Ok(expected), "{cm} cm");
            assert_eq!(setup.sensor.borrow().heard, 1);
        }
        let mut setup = Setup::new(Some(RangerAnswer::NoObject), operation_us);
        assert_eq!(setup.measure(), Ok(Reading::NoObject));
    }
}

#[test]
fn a_ranger_that_does_not_answer_is_missing_until_it_does() {
    let mut setup = Setup::new(Some(RangerAnswer::Object { cm: 42 }), 1);
    let right = Ok(Reading::Echo(Millimeters::new(420)));
    for fault in [
        LineFault::Mute,
        LineFault::StuckLow,
        LineFault::UnpluggedMidConversion,
        LineFault::CutShort,
    ] {
        setup.sensor.borrow_mut().line.set_fault(Some(fault));
        assert_eq!(setup.measure(), Err(Fault::NoAnswer));
        setup.sensor.borrow_mut().line.set_fault(None);
        assert_eq!(setup.measure(), right);
    }
    setup.sensor.borrow_mut().answer = None;
    assert_eq!(setup.measure(), Err(Fault::NoAnswer));
}

#[test]
fn a_line_that_is_stuck_high_is_not_triggered() {
    let mut setup = Setup::new(Some(RangerAnswer::Object { cm: 42 }), 1);
    let fault = Some(LineFault::StuckHigh);
    setup.sensor.borrow_mut().line.set_fault(fault);
    assert_eq!(setup.measure(), Err(Fault::StuckHigh));
    assert_eq!(setup.sensor.borrow().heard, 0);
    setup.sensor.borrow_mut().line.set_fault(None);
    assert!(setup.measure().is_ok());
}

#[test]
fn a_trigger_that_is_too_short_or_too_soon_goes_unheard() {
    let mut line = RangerLine::new();
    let mut heard = 0;
    let mut trigger = |from_ns, to_ns| {
        line.set_trigger(true, from_ns, || None);
        line.set_trigger(false, to_ns, || {
            heard += 1;
            Some(RangerAnswer::Object { cm: 10 })
        });
    };
    trigger(0, 9_999);
    trigger(20_000, 30_000);
    // 700 µs and 10 cm later: 30 + 700 + 580 µs.
    trigger(1_290_000, 1_309_999);
    trigger(1_300_000, 1_310_000);
    assert_eq!(heard, 2);
    assert!(!line.echo(1_310_000 + 699_999));
    assert!(line.echo(1_310_000 + 700_000));
    assert!(line.echo(1_310_000 + 1_279_999));
    assert!(!line.echo(1_310_000 + 1_280_000));
}
