//! A pulse-echo ultrasonic ranger, by its two pins.

use super::fault::{LineFault, MICROSECOND, MILLISECOND};

/// A ranger's measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RangerAnswer {
    /// The nearest object is this many centimetres away.
    Object {
        /// Whole centimetres.
        cm: u16,
    },
    /// No echo came back.
    NoObject,
}

/// A simulated pulse-echo ranger, pin by pin.
///
/// A pulse on Trigger answers with one on Echo, of 58 µs a centimetre or, where nothing came back,
/// of [`NO_OBJECT_NS`](Self::NO_OBJECT_NS). Triggers during the answer are ignored.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[expect(
    missing_copy_implementations,
    reason = "a copy would be another device"
)]
pub struct RangerLine {
    trigger: bool,
    /// When Trigger last rose.
    rose_ns: u64,
    /// When Echo rises and falls.
    pulse: Option<(u64, u64)>,
    fault: Option<LineFault>,
}

impl RangerLine {
    /// The shortest trigger that starts a measurement.
    pub const SHORTEST_TRIGGER_NS: u64 = 10 * MICROSECOND;

    /// From Trigger's fall to Echo's rise.
    pub const DELAY_NS: u64 = 700 * MICROSECOND;

    /// The width of an echo for each centimetre.
    pub const CENTIMETER_NS: u64 = 58 * MICROSECOND;

    /// How long Echo is high where nothing came back.
    pub const NO_OBJECT_NS: u64 = 38 * MILLISECOND;

    /// Creates an idle ranger, its Trigger low.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets Trigger.
    ///
    /// A trigger calls `measure`, also while the line has a fault; `None` is a ranger that does not
    /// answer.
    pub fn set_trigger(
        &mut self,
        high: bool,
        now_ns: u64,
        measure: impl FnOnce() -> Option<RangerAnswer>,
    ) {
        let was = core::mem::replace(&mut self.trigger, high);
        if high {
            if !was {
                self.rose_ns = now_ns;
            }
            return;
        }
        let busy = self.pulse.is_some_and(|(_, fall_ns)| now_ns < fall_ns);
        let long = now_ns.saturating_sub(self.rose_ns) >= Self::SHORTEST_TRIGGER_NS;
        if was && long && !busy {
            let rise_ns = now_ns + Self::DELAY_NS;
            self.pulse = measure().map(|answer| {
                let width_ns = match answer {
                    RangerAnswer::Object { cm } => u64::from(cm) * Self::CENTIMETER_NS,
                    RangerAnswer::NoObject => Self::NO_OBJECT_NS,
                };
                (rise_ns, rise_ns + width_ns)
            });
        }
    }

    /// Returns the level of Echo.
    #[must_use]
    pub fn echo(&self, now_ns: u64) -> bool {
        match self.fault {
            // Where the fault forces no level, the pull-down does.
            Some(fault) => fault.level(now_ns).unwrap_or(false),
            None => self
                .pulse
                .is_some_and(|(rise_ns, fall_ns)| (rise_ns..fall_ns).contains(&now_ns)),
        }
    }

    /// Sets or removes the fault of the line, at once.
    ///
    /// A ranger has neither a conversion nor bits: [`LineFault::UnpluggedMidConversion`] and
    /// [`LineFault::CutShort`] act as [`LineFault::NoAnswer`].
    pub const fn set_fault(&mut self, fault: Option<LineFault>) {
        self.fault = fault;
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_pins::{Clock, Input, Output, Ultrasonic, Wired, pins};
    use super::*;
    use certainty_core::transducer::Reading;
    use certainty_core::units::Millimeters;
    use certainty_firmware::ranger::{Fault, MEASURE_US, Ranger, RangerLimits};
    use certainty_firmware::timing::OPERATION_US;
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
                measured: 0,
            };
            let wired = Wired::new(&clock, sensor);
            let (trigger, echo) = pins(&wired);
            Self {
                clock,
                driver: Ranger::new(trigger, echo, RangerLimits::SRF04),
                sensor: wired.device,
            }
        }

        /// Measures, and waits for the echoes to fade.
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
    fn every_centimetre_is_read_at_any_speed() {
        for operation_us in [0, 1, OPERATION_US] {
            for cm in 1..=320 {
                let mut setup = Setup::new(Some(RangerAnswer::Object { cm }), operation_us);
                let expected = match cm {
                    1..3 => Reading::TooNear,
                    3..=300 => Reading::Echo(Millimeters::new(u32::from(cm) * 10)),
                    _ => Reading::NoObject,
                };
                assert_eq!(setup.measure(), Ok(expected), "{cm} cm");
                assert_eq!(setup.sensor.borrow().measured, 1);
            }
            let mut setup = Setup::new(Some(RangerAnswer::NoObject), operation_us);
            assert_eq!(setup.measure(), Ok(Reading::NoObject));
        }
    }

    #[test]
    fn a_ranger_without_an_answer_is_missing() {
        let mut setup = Setup::new(Some(RangerAnswer::Object { cm: 42 }), 1);
        let right = Ok(Reading::Echo(Millimeters::new(420)));
        for fault in [
            LineFault::NoAnswer,
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
        assert_eq!(setup.sensor.borrow().measured, 0);
        setup.sensor.borrow_mut().line.set_fault(None);
        assert!(setup.measure().is_ok());
    }

    #[test]
    fn a_short_or_early_trigger_is_ignored() {
        let mut line = RangerLine::new();
        let mut measured = 0;
        let mut trigger = |from_ns, to_ns| {
            line.set_trigger(true, from_ns, || None);
            line.set_trigger(false, to_ns, || {
                measured += 1;
                Some(RangerAnswer::Object { cm: 10 })
            });
        };
        trigger(0, 9_999);
        trigger(20_000, 30_000);
        // 700 µs and 10 cm later: 30 + 700 + 580 µs.
        trigger(1_290_000, 1_309_999);
        trigger(1_300_000, 1_310_000);
        assert_eq!(measured, 2);
        assert!(!line.echo(1_310_000 + 699_999));
        assert!(line.echo(1_310_000 + 700_000));
        assert!(line.echo(1_310_000 + 1_279_999));
        assert!(!line.echo(1_310_000 + 1_280_000));
    }
}
