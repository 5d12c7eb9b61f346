//! A GP2D02, by its two pins.

use super::fault::{LineFault, MICROSECOND, MILLISECOND};

/// A simulated Sharp GP2D02, pin by pin.
///
/// It is as slow and as strict as the data sheet allows: a conversion takes nearly its 70 ms, a clock's
/// high half of under 50 µs is ignored, and only 2 ms of high Vin make it idle again, from any state.
#[derive(Debug, Clone, PartialEq, Eq)]
#[expect(
    missing_copy_implementations,
    reason = "a copy would be another device"
)]
pub struct Gp2d02Line {
    /// The state at the last edge of Vin.
    state: State,
    vin: bool,
    /// When Vin last changed.
    vin_since_ns: u64,
    fault: Option<LineFault>,
    /// When the sensor is unplugged.
    unplugged_ns: Option<u64>,
}

/// The state of the sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Waits for Vin to fall; Vout is high.
    Idle,
    /// Converts; Vout is low, and high from `over_ns` on, if ever.
    Converting { over_ns: Option<u64>, byte: u8 },
    /// Shows bit number `shown`, from 1.
    Bits { byte: u8, shown: u8 },
    /// Has lost its supply, and restarts while Vin is high; Vout is low.
    Off,
}

impl Default for Gp2d02Line {
    fn default() -> Self {
        Self::new()
    }
}

impl Gp2d02Line {
    /// The time of a conversion.
    pub const CONVERSION_NS: u64 = 68 * MILLISECOND;

    /// The time of high Vin after which the sensor is idle.
    pub const RECOVERY_NS: u64 = 2 * MILLISECOND;

    /// The same after a loss of supply.
    pub const RESTART_NS: u64 = 10 * MILLISECOND;

    /// The shortest high half of a clock's period that the sensor detects.
    pub const SHORTEST_CLOCK_NS: u64 = 50 * MICROSECOND;

    /// The time from the start of a conversion to [`LineFault::UnpluggedMidConversion`].
    pub const UNPLUGGED_AFTER_NS: u64 = 20 * MILLISECOND;

    /// Creates an idle sensor, its Vin high.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            state: State::Idle,
            vin: true,
            vin_since_ns: 0,
            fault: None,
            unplugged_ns: None,
        }
    }

    /// Sets Vin, which is high while it is not driven.
    ///
    /// The start of a conversion calls `convert` for its byte, also while the line has a fault, but not
    /// while the sensor is unplugged; `None` is a conversion that never ends.
    pub fn set_vin(&mut self, high: bool, now_ns: u64, convert: impl FnOnce() -> Option<u8>) {
        if high == self.vin {
            return;
        }
        self.state = match self.state_at(now_ns) {
            _ if self.is_unplugged(now_ns) => State::Off,
            State::Idle => self.converting(convert(), now_ns),
            state if high || !self.is_clock(now_ns) => state,
            State::Converting { byte, .. } if self.is_over(now_ns) => {
                State::Bits { byte, shown: 1 }
            }
            State::Bits { shown: 4, .. } if self.fault == Some(LineFault::CutShort) => State::Off,
            State::Bits { byte, shown } if shown < 8 => State::Bits {
                byte,
                shown: shown + 1,
            },
            state => state,
        };
        self.vin = high;
        self.vin_since_ns = now_ns;
    }

    /// Returns the level of Vout, with a pull-down where it is connected to nothing.
    #[must_use]
    pub fn vout(&self, now_ns: u64) -> bool {
        if let Some(level) = self.fault.and_then(|fault| fault.level(now_ns)) {
            return level;
        }
        if self.is_unplugged(now_ns) {
            return false;
        }
        match self.state_at(now_ns) {
            State::Idle => true,
            State::Converting { .. } => self.is_over(now_ns),
            State::Bits { byte, shown } => byte >> (8 - shown) & 1 == 1,
            State::Off => false,
        }
    }

    /// Sets or removes the fault of the line.
    ///
    /// A sensor that was unplugged restarts after [`RESTART_NS`](Self::RESTART_NS) of high Vin, as does
    /// one whose bits were cut short.
    pub fn set_fault(&mut self, fault: Option<LineFault>, now_ns: u64) {
        let unplug = fault == Some(LineFault::UnpluggedMidConversion);
        if unplug {
            if matches!(self.state_at(now_ns), State::Converting { .. }) {
                self.unplugged_ns.get_or_insert(now_ns);
            }
        } else {
            if self.is_unplugged(now_ns) {
                self.state = State::Off;
                self.vin_since_ns = now_ns;
            }
            self.unplugged_ns = None;
        }
        self.fault = fault;
    }

    /// Returns the fault of the line.
    #[must_use]
    pub const fn fault(&self) -> Option<LineFault> {
        self.fault
    }

    fn converting(&mut self, byte: Option<u8>, now_ns: u64) -> State {
        if self.fault == Some(LineFault::UnpluggedMidConversion) {
            self.unplugged_ns = Some(now_ns + Self::UNPLUGGED_AFTER_NS);
        }
        State::Converting {
            over_ns: byte.map(|_| now_ns + Self::CONVERSION_NS),
            byte: byte.unwrap_or(0),
        }
    }

    /// The state now: idle after a long enough high Vin, else as at the last edge.
    fn state_at(&self, now_ns: u64) -> State {
        let rest = match self.state {
            State::Off => Self::RESTART_NS,
            _ => Self::RECOVERY_NS,
        };
        if self.vin && self.held(now_ns) >= rest {
            State::Idle
        } else {
            self.state
        }
    }

    fn is_over(&self, now_ns: u64) -> bool {
        match self.state_at(now_ns) {
            State::Converting {
                over_ns: Some(over_ns),
                ..
            } => now_ns >= over_ns && self.fault != Some(LineFault::NoAnswer),
            _ => false,
        }
    }

    fn is_unplugged(&self, now_ns: u64) -> bool {
        self.unplugged_ns
            .is_some_and(|unplugged_ns| now_ns >= unplugged_ns)
    }

    fn is_clock(&self, now_ns: u64) -> bool {
        self.held(now_ns) >= Self::SHORTEST_CLOCK_NS
    }

    /// The time since the last edge of Vin.
    fn held(&self, now_ns: u64) -> u64 {
        now_ns.saturating_sub(self.vin_since_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_pins::{Clock, Infrared, Input, Output, Wired, pins};
    use super::*;
    use certainty_core::transducer::Missing;
    use certainty_firmware::gp2d02::{CONVERSION_US, Fault, Gp2d02, MEASURE_US, READ_US, START_US};
    use certainty_firmware::timing::OPERATION_US;
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
        LineFault::NoAnswer,
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

        /// A slot of the schedule: a start, 70 ms, a read.
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
    fn every_byte_is_read_at_any_speed() {
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
    fn each_step_takes_at_most_its_stated_time() {
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
            // The rest is for an abort, which releases Vin.
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
    fn the_clock_keeps_the_data_sheets_times() {
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

    /// The results of two slots with the fault, and of one after it.
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
    fn each_line_fault_is_named_and_recovered_from() {
        use Fault::{CutShort, Floating, StuckHigh, StuckLow, Timeout};
        for byte in [0, 75, 190, 0xFF] {
            let expected = |first, second| [Err(first), Err(second), Ok(byte)];
            for (fault, [first, second]) in [
                (LineFault::StuckHigh, [StuckHigh, StuckHigh]),
                (LineFault::StuckLow, [StuckLow, StuckLow]),
                (LineFault::Floating { seed: 7 }, [Floating, Floating]),
                (LineFault::UnpluggedMidConversion, [Timeout, StuckLow]),
                (LineFault::CutShort, [CutShort, CutShort]),
                (LineFault::NoAnswer, [Timeout, Timeout]),
            ] {
                assert_eq!(around(fault, byte), expected(first, second), "{fault:?}");
            }
        }
    }

    #[test]
    fn a_conversion_without_an_end_is_a_timeout() {
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
        // Noise looks like an idle and then a converting line in one of 2^10 cases, like a conversion
        // without an end in one of 2^15.
        assert!(reasons[0] >= 3_995, "{reasons:?}");
    }

    /// Starts a conversion, sets `fault` from `from_ms` to `until_ms`, and reads at 70 ms.
    fn read_with(fault: LineFault, from_ms: u64, until_ms: u64) -> (Setup, Result<u8, Fault>) {
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
    fn a_fault_within_a_conversion_never_falsifies() {
        for fault in FAULTS {
            for from_ms in 0..69 {
                for until_ms in from_ms + 1..70 {
                    let (mut setup, read) = read_with(fault, from_ms, until_ms);
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
    fn a_fault_from_within_a_conversion_on_is_missing() {
        for from_ms in 0..69 {
            for (fault, expected) in [
                (LineFault::StuckLow, Fault::Timeout),
                (LineFault::UnpluggedMidConversion, Fault::Timeout),
                (LineFault::CutShort, Fault::CutShort),
                (LineFault::NoAnswer, Fault::Timeout),
            ] {
                let (mut setup, read) = read_with(fault, from_ms, 70);
                assert_eq!(read, Err(expected), "{fault:?} from {from_ms}");
                setup.set_fault(None);
                setup.pass_ms(10);
                assert_eq!(setup.slot(), Ok(75));
            }
            let noise = LineFault::Floating { seed: from_ms };
            assert!(read_with(noise, from_ms, 70).1.is_err());
        }
    }

    #[test]
    fn a_line_stuck_high_in_a_conversion_reads_255_once() {
        // The protocol cannot distinguish it from a sensor that sends ones.
        let (mut setup, read) = read_with(LineFault::StuckHigh, 30, 70);
        assert_eq!(read, Ok(0xFF));
        assert_eq!(setup.slot(), Err(Fault::StuckHigh));
    }

    #[test]
    fn a_read_before_70_ms_is_a_timeout() {
        let mut setup = Setup::new(75, 0);
        setup.start().unwrap();
        setup.pass_ms(60);
        assert_eq!(setup.driver.ready(), Ok(false));
        assert_eq!(setup.read(), Err(Fault::Timeout));
        assert!(Gp2d02Line::CONVERSION_NS < u64::from(CONVERSION_US) * MICROSECOND);
    }

    #[test]
    fn the_sensor_ignores_a_clock_that_is_too_fast() {
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
}
