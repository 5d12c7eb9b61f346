//! Devices behind embedded-hal for tests: pins that share a device, and a clock that a delay advances.

use core::cell::{Cell, RefCell};
use core::convert::Infallible;
use embedded_hal::delay::DelayNs;
use embedded_hal::{digital, pwm};
use std::rc::Rc;

use certainty_firmware::servo::{Servo, ServoModel};
use certainty_firmware::timing::Stopwatch;

use super::fault::MICROSECOND;
use super::gp2d02_line::Gp2d02Line;
use super::ranger_line::{RangerAnswer, RangerLine};
use super::servo_shaft::ServoShaft;

/// Virtual time; each operation takes some of it.
#[derive(Clone)]
pub(super) struct Clock {
    now_ns: Rc<Cell<u64>>,
    operation_ns: u64,
}

impl Clock {
    pub(super) fn new(operation_us: u32) -> Self {
        Self {
            // Long after the last event of the devices.
            now_ns: Rc::new(Cell::new(1_000_000_000)),
            operation_ns: u64::from(operation_us) * MICROSECOND,
        }
    }

    pub(super) fn now(&self) -> u64 {
        self.now_ns.get()
    }

    pub(super) fn advance(&self, ns: u64) {
        self.now_ns.set(self.now() + ns);
    }

    /// Runs an operation: its time passes, then it takes effect.
    fn operate<T>(&self, act: impl FnOnce(u64) -> T) -> T {
        self.advance(self.operation_ns);
        act(self.now())
    }
}

impl DelayNs for Clock {
    fn delay_ns(&mut self, ns: u32) {
        self.advance(self.operation_ns + u64::from(ns));
    }
}

impl Stopwatch for Clock {
    fn micros(&mut self) -> u32 {
        self.operate(|now_ns| (now_ns / MICROSECOND) as u32)
    }
}

/// A device and its clock.
pub(super) struct Wired<Device> {
    pub(super) clock: Clock,
    pub(super) device: Rc<RefCell<Device>>,
}

impl<Device> Wired<Device> {
    pub(super) fn new(clock: &Clock, device: Device) -> Self {
        Self {
            clock: clock.clone(),
            device: Rc::new(RefCell::new(device)),
        }
    }
}

/// A GP2D02 with its measurement, and what happened on its pins.
pub(super) struct Infrared {
    pub(super) line: Gp2d02Line,
    pub(super) byte: Option<u8>,
    /// Vin's changes.
    pub(super) edges: Vec<(u64, bool)>,
    pub(super) conversions: u32,
}

impl Infrared {
    pub(super) fn set_vin(&mut self, high: bool, now_ns: u64) {
        if self.edges.last().is_none_or(|&(_, last)| last != high) {
            self.edges.push((now_ns, high));
        }
        let (byte, conversions) = (self.byte, &mut self.conversions);
        self.line.set_vin(high, now_ns, || {
            *conversions += 1;
            byte
        });
    }
}

/// A ranger with its measurement, and how often it was triggered.
pub(super) struct Ultrasonic {
    pub(super) line: RangerLine,
    pub(super) answer: Option<RangerAnswer>,
    pub(super) measured: u32,
}

/// A device on an output pin.
pub(super) trait Driven {
    fn drive(&mut self, high: bool, now_ns: u64);
}

/// A device on an input pin.
pub(super) trait Read {
    fn level(&self, now_ns: u64) -> bool;
}

impl Driven for Infrared {
    fn drive(&mut self, high: bool, now_ns: u64) {
        self.set_vin(high, now_ns);
    }
}

impl Read for Infrared {
    fn level(&self, now_ns: u64) -> bool {
        self.line.vout(now_ns)
    }
}

impl Driven for Ultrasonic {
    fn drive(&mut self, high: bool, now_ns: u64) {
        let (answer, measured) = (self.answer, &mut self.measured);
        self.line.set_trigger(high, now_ns, || {
            *measured += 1;
            answer
        });
    }
}

impl Read for Ultrasonic {
    fn level(&self, now_ns: u64) -> bool {
        self.line.echo(now_ns)
    }
}

pub(super) struct Output<Device>(pub(super) Wired<Device>);

pub(super) struct Input<Device>(pub(super) Wired<Device>);

/// The two pins of a device.
pub(super) fn pins<Device>(wired: &Wired<Device>) -> (Output<Device>, Input<Device>) {
    let pin = || Wired {
        clock: wired.clock.clone(),
        device: Rc::clone(&wired.device),
    };
    (Output(pin()), Input(pin()))
}

impl<Device> digital::ErrorType for Output<Device> {
    type Error = Infallible;
}

impl<Device> digital::ErrorType for Input<Device> {
    type Error = Infallible;
}

impl<Device: Driven> Output<Device> {
    fn set(&self, high: bool) {
        let Wired { clock, device } = &self.0;
        clock.operate(|now_ns| device.borrow_mut().drive(high, now_ns));
    }
}

impl<Device: Driven> digital::OutputPin for Output<Device> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.set(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.set(true);
        Ok(())
    }
}

impl<Device: Read> digital::InputPin for Input<Device> {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        let Wired { clock, device } = &self.0;
        Ok(clock.operate(|now_ns| device.borrow().level(now_ns)))
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        self.is_high().map(|high| !high)
    }
}

/// A PWM channel with pulses each 20 ms, of a timer at 2 MHz.
pub(super) struct Channel(pub(super) Wired<ServoShaft>);

impl pwm::ErrorType for Channel {
    type Error = Infallible;
}

impl pwm::SetDutyCycle for Channel {
    fn max_duty_cycle(&self) -> u16 {
        40_000
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        let pulse_us = u32::from(duty).div_ceil(2);
        let now_ns = self.0.clock.now();
        self.0.device.borrow_mut().set_pulse(pulse_us, now_ns);
        Ok(())
    }
}

/// A common servo's driver on a shaft that stands at `pulse_us`.
pub(super) fn servo(clock: &Clock, pulse_us: u32) -> (Servo<Channel>, Rc<RefCell<ServoShaft>>) {
    let shaft = ServoShaft::new(ServoModel::COMMON.config(), pulse_us);
    let wired = Wired::new(clock, shaft);
    let shaft = Rc::clone(&wired.device);
    (Servo::new(Channel(wired), ServoModel::COMMON), shaft)
}
