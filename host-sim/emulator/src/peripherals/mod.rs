//! The peripherals, one file each, and the addresses and clocks that they share.

mod afio;
mod flash;
mod gpio;
mod pwm_timer;
mod rcc;
mod unmodelled;
mod usart;
mod watchdog;

pub use rcc::ResetCause;
pub use unmodelled::UnmodelledRegister;

use crate::error::RunError;
use crate::pins::{Connection, Pin, Pins, Port, Timer};
use afio::Afio;
use core::mem;
use flash::Flash;
use gpio::{Drive, Gpio};
use pwm_timer::PwmTimer;
use rcc::{Clocked, Rcc};
use unmodelled::Unmodelled;
use usart::Usart;
use watchdog::Watchdog;

/// Cycles of the processor in a microsecond.
const CYCLES_PER_US: u64 = 8;

/// Nanoseconds of a cycle.
pub(crate) const CYCLE_NS: u64 = 1000 / CYCLES_PER_US;

/// Where the peripherals begin.
pub(crate) const PERIPHERALS_AT: u32 = 0x4000_0000;

/// How far they reach.
pub(crate) const PERIPHERALS_BYTES: u32 = 0x2_3400;

/// The pin of the serial output.
const SERIAL_OUT: Pin = Pin::new(Port::A, 9);

/// The channels of the timers, from 0, and their pins.
const CHANNELS: [(Timer, u8, Pin); 6] = [
    (Timer::Tim3, 0, Pin::new(Port::A, 6)),
    (Timer::Tim3, 1, Pin::new(Port::A, 7)),
    (Timer::Tim3, 2, Pin::new(Port::B, 0)),
    (Timer::Tim4, 0, Pin::new(Port::B, 6)),
    (Timer::Tim4, 1, Pin::new(Port::B, 7)),
    (Timer::Tim4, 2, Pin::new(Port::B, 8)),
];

/// All peripherals of the microcontroller, with the devices on its pins.
#[derive(Debug)]
pub(crate) struct Peripherals<P> {
    pub(crate) pins: P,
    lines: Vec<Line>,
    rcc: Rcc,
    flash: Flash,
    afio: Afio,
    ports: [Gpio; Port::ALL.len()],
    tim3: PwmTimer,
    tim4: PwmTimer,
    usart1: Usart,
    watchdog: Watchdog,
    unmodelled: Unmodelled,
    /// The pulses that the devices were given last.
    pulses: [u32; CHANNELS.len()],
    serial: Vec<u8>,
    failure: Option<RunError>,
}

/// A connected pin.
#[derive(Debug)]
struct Line {
    pin: Pin,
    connection: Connection,
    /// The level that the device was given last.
    level: bool,
}

/// What is at an address.
enum Peripheral {
    Rcc,
    Flash,
    Afio,
    Port(Port),
    Tim3,
    Tim4,
    Usart1,
    Watchdog,
    Unmodelled,
}

impl Peripheral {
    const fn at(address: u32) -> Self {
        match address & !0x3ff {
            0x4000_0400 => Self::Tim3,
            0x4000_0800 => Self::Tim4,
            0x4000_3000 => Self::Watchdog,
            0x4001_0000 => Self::Afio,
            0x4001_0800 => Self::Port(Port::A),
            0x4001_0c00 => Self::Port(Port::B),
            0x4001_1000 => Self::Port(Port::C),
            0x4001_3800 => Self::Usart1,
            0x4002_1000 => Self::Rcc,
            0x4002_2000 => Self::Flash,
            _ => Self::Unmodelled,
        }
    }

    /// The clock that it needs; `None` for RCC, the flash and the watchdog, which always answer.
    const fn clocked(&self) -> Option<Clocked> {
        match self {
            Self::Afio => Some(Clocked::Afio),
            Self::Port(Port::A) => Some(Clocked::GpioA),
            Self::Port(Port::B) => Some(Clocked::GpioB),
            Self::Port(Port::C) => Some(Clocked::GpioC),
            Self::Tim3 => Some(Clocked::Tim3),
            Self::Tim4 => Some(Clocked::Tim4),
            Self::Usart1 => Some(Clocked::Usart1),
            Self::Rcc | Self::Flash | Self::Watchdog | Self::Unmodelled => None,
        }
    }
}

impl<P: Pins> Peripherals<P> {
    pub(crate) fn new(wiring: &[(Pin, Connection)], pins: P) -> Self {
        let lines = wiring.iter().map(|&(pin, connection)| Line {
            pin,
            connection,
            level: connection.idle_level(),
        });
        Self {
            pins,
            lines: lines.collect(),
            rcc: Rcc::default(),
            flash: Flash::default(),
            afio: Afio::default(),
            ports: Default::default(),
            tim3: PwmTimer::default(),
            tim4: PwmTimer::default(),
            usart1: Usart::default(),
            watchdog: Watchdog::default(),
            unmodelled: Unmodelled::default(),
            pulses: [0; CHANNELS.len()],
            serial: Vec::new(),
            failure: None,
        }
    }

    /// Sets the reset cause that the program reads; before its first instruction.
    pub(crate) fn set_reset_cause(&mut self, cause: ResetCause) {
        self.rcc = Rcc::after(cause);
    }

    /// Reads the register at `address` in cycle `now`.
    pub(crate) fn read(&mut self, address: u32, now: u64) -> u32 {
        let peripheral = Peripheral::at(address);
        if peripheral
            .clocked()
            .is_some_and(|clocked| !self.rcc.enabled(clocked))
        {
            self.unmodelled.read(address);
            return 0;
        }
        let offset = address & 0x3ff;
        let value = match peripheral {
            Peripheral::Rcc => self.rcc.read(offset),
            Peripheral::Flash => self.flash.read(offset),
            Peripheral::Afio => self.afio.read(offset),
            Peripheral::Port(port) => {
                let Self {
                    ports, lines, pins, ..
                } = self;
                let registers = &ports[port as usize];
                registers.read(offset, || levels(registers, port, lines, pins, now))
            }
            Peripheral::Tim3 => self.tim3.read(offset, now),
            Peripheral::Tim4 => self.tim4.read(offset, now),
            Peripheral::Usart1 => self.usart1.read(offset),
            Peripheral::Watchdog => self.watchdog.read(offset, now),
            Peripheral::Unmodelled => None,
        };
        value.unwrap_or_else(|| self.unmodelled.read(address))
    }

    /// Writes the register at `address` in cycle `now`.
    pub(crate) fn write(&mut self, address: u32, value: u32, now: u64) {
        let peripheral = Peripheral::at(address);
        if peripheral
            .clocked()
            .is_some_and(|clocked| !self.rcc.enabled(clocked))
        {
            self.unmodelled.write(address, 0);
            return;
        }
        let offset = address & 0x3ff;
        let known = match peripheral {
            Peripheral::Rcc => {
                let known = self.rcc.write(offset, value);
                self.apply_resets();
                known
            }
            Peripheral::Flash => self.flash.write(offset, value),
            Peripheral::Afio => self.afio.write(offset, value),
            Peripheral::Port(port) => self.ports[port as usize].write(offset, value),
            Peripheral::Tim3 => self.tim3.write(offset, value, now),
            Peripheral::Tim4 => self.tim4.write(offset, value, now),
            Peripheral::Usart1 => self.usart1.write(offset, value, now),
            Peripheral::Watchdog => self.watchdog.write(offset, value, now),
            Peripheral::Unmodelled => false,
        };
        if !known {
            self.unmodelled.write(address, value);
        }
        self.update_levels(now);
        self.update_pulses(now);
    }

    fn apply_resets(&mut self) {
        for clocked in Clocked::ALL {
            if !self.rcc.in_reset(clocked) {
                continue;
            }
            match clocked {
                Clocked::Afio => self.afio = Afio::default(),
                Clocked::GpioA => self.ports[Port::A as usize] = Gpio::default(),
                Clocked::GpioB => self.ports[Port::B as usize] = Gpio::default(),
                Clocked::GpioC => self.ports[Port::C as usize] = Gpio::default(),
                Clocked::Usart1 => self.usart1 = Usart::default(),
                Clocked::Tim3 => self.tim3 = PwmTimer::default(),
                Clocked::Tim4 => self.tim4 = PwmTimer::default(),
            }
        }
    }

    /// Advances the time to cycle `now`.
    pub(crate) fn advance(&mut self, now: u64) {
        if let Some(loaded_at) = self.tim3.advance(now) {
            self.update_pulses(loaded_at);
        }
        if let Some(loaded_at) = self.tim4.advance(now) {
            self.update_pulses(loaded_at);
        }
        self.usart1.advance(now);
        let sent = self.usart1.take_sent();
        if self.afio.usart1_in_place() && self.drive(SERIAL_OUT) == Drive::Alternate {
            self.serial.extend(sent);
        }
        if let Some(at) = self.watchdog.expires_at().filter(|&at| at <= now) {
            let at_ns = at * CYCLE_NS;
            self.failure
                .get_or_insert(RunError::WatchdogExpired { at_ns });
        }
    }

    /// The next cycle in which a peripheral changes without an access.
    pub(crate) fn next_event(&self) -> u64 {
        if self.failure.is_some() {
            return 0;
        }
        let events = [
            self.tim3.next_event(),
            self.tim4.next_event(),
            self.usart1.next_event(),
            self.watchdog.expires_at(),
        ];
        events.into_iter().flatten().min().unwrap_or(u64::MAX)
    }

    /// Whether USART1 requests its interrupt.
    pub(crate) const fn serial_interrupts(&self) -> bool {
        self.usart1.interrupts()
    }

    /// The first failure, if there was one.
    pub(crate) fn failure(&self) -> Option<&RunError> {
        self.failure.as_ref()
    }

    /// Takes the bytes that were sent on the serial line since the last call.
    pub(crate) fn take_serial(&mut self) -> Vec<u8> {
        mem::take(&mut self.serial)
    }

    /// The registers that were used without a model.
    pub(crate) fn unmodelled(&self) -> Vec<UnmodelledRegister> {
        self.unmodelled.listing()
    }

    fn drive(&self, pin: Pin) -> Drive {
        self.ports[pin.port() as usize].drive(pin.number())
    }

    /// Passes changed levels on to the devices.
    fn update_levels(&mut self, now: u64) {
        let at_ns = now * CYCLE_NS;
        for line in &mut self.lines {
            let drive = self.ports[line.pin.port() as usize].drive(line.pin.number());
            let level = match (line.connection, drive) {
                (Connection::FromDevice, _) => continue,
                (Connection::OpenDrain(line), Drive::High | Drive::Pulled(true)) => {
                    let driven_high = RunError::DrivenHigh { line, at_ns };
                    self.failure.get_or_insert(driven_high);
                    true
                }
                (_, Drive::Low | Drive::Pulled(false)) => false,
                (_, Drive::High | Drive::Pulled(true)) => true,
                (connection, Drive::Released | Drive::Alternate) => connection.idle_level(),
            };
            if mem::replace(&mut line.level, level) != level {
                self.pins.set_level(line.pin, level, at_ns);
            }
        }
    }

    /// Passes changed pulses on to the devices.
    fn update_pulses(&mut self, now: u64) {
        for (index, (timer, channel, pin)) in CHANNELS.into_iter().enumerate() {
            let (registers, in_place) = match timer {
                Timer::Tim3 => (&self.tim3, self.afio.tim3_in_place()),
                Timer::Tim4 => (&self.tim4, self.afio.tim4_in_place()),
            };
            let out = in_place && self.drive(pin) == Drive::Alternate;
            let cycles = if out {
                registers.pulse_cycles(channel.into())
            } else {
                0
            };
            // At most 2^32 cycles: 65,536 counts of 65,536 cycles.
            let width_us = ((cycles + CYCLES_PER_US / 2) / CYCLES_PER_US) as u32;
            if mem::replace(&mut self.pulses[index], width_us) != width_us {
                self.pins
                    .set_pulse(timer, channel, width_us, now * CYCLE_NS);
            }
        }
    }
}

/// The levels of the pins of `port`.
fn levels(registers: &Gpio, port: Port, lines: &[Line], pins: &mut impl Pins, now: u64) -> u16 {
    let mut levels = 0;
    for number in 0..16 {
        if !registers.digital(number) {
            continue;
        }
        let pin = Pin::new(port, number);
        let line = lines.iter().find(|line| line.pin == pin);
        let connection = line.map(|line| line.connection);
        let high = match (registers.drive(number), connection) {
            (Drive::Low, _) => false,
            (Drive::High, _) => true,
            (_, Some(Connection::FromDevice)) => pins.level(pin, now * CYCLE_NS),
            (_, Some(connection)) => connection.idle_level(),
            (Drive::Pulled(up), None) => up,
            (Drive::Released | Drive::Alternate, None) => false,
        };
        levels |= u16::from(high) << number;
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three lines of 3 V, three inputs, a push-pull output, two more inputs.
    const WIRING: [(Pin, Connection); 9] = [
        (
            Pin::new(Port::B, 12),
            Connection::OpenDrain("Vin of sensor 1"),
        ),
        (
            Pin::new(Port::B, 13),
            Connection::OpenDrain("Vin of sensor 2"),
        ),
        (
            Pin::new(Port::B, 14),
            Connection::OpenDrain("Vin of sensor 3"),
        ),
        (Pin::new(Port::C, 10), Connection::FromDevice),
        (Pin::new(Port::C, 11), Connection::FromDevice),
        (Pin::new(Port::C, 12), Connection::FromDevice),
        (Pin::new(Port::C, 1), Connection::ToDevice),
        (Pin::new(Port::B, 10), Connection::FromDevice),
        (Pin::new(Port::B, 11), Connection::FromDevice),
    ];

    /// Records its calls; PC11 and PB10 are high.
    #[derive(Debug, Default)]
    struct Recorder(Vec<String>);

    impl Pins for Recorder {
        fn set_level(&mut self, pin: Pin, high: bool, now_ns: u64) {
            self.0.push(format!("{pin} {high} at {now_ns}"));
        }

        fn level(&mut self, pin: Pin, _: u64) -> bool {
            pin == Pin::new(Port::C, 11) || pin == Pin::new(Port::B, 10)
        }

        fn set_pulse(&mut self, timer: Timer, channel: u8, width_us: u32, now_ns: u64) {
            self.0
                .push(format!("{timer:?}.{channel} {width_us} at {now_ns}"));
        }
    }

    const RCC: u32 = 0x4002_1000;
    const GPIO_A: u32 = 0x4001_0800;
    const GPIO_B: u32 = 0x4001_0c00;
    const GPIO_C: u32 = 0x4001_1000;
    const TIM3: u32 = 0x4000_0400;
    const TIM4: u32 = 0x4000_0800;
    const USART1: u32 = 0x4001_3800;
    const IWDG: u32 = 0x4000_3000;

    /// With the clocks of all modelled peripherals on.
    fn clocked() -> Peripherals<Recorder> {
        let mut chip = Peripherals::new(&WIRING, Recorder::default());
        chip.write(RCC + 0x18, 0x401d, 0);
        chip.write(RCC + 0x1c, 0x6, 0);
        chip
    }

    #[test]
    fn without_its_clock_a_peripheral_reads_zero() {
        let mut chip = Peripherals::new(&WIRING, Recorder::default());
        chip.write(GPIO_C + 0x0c, 0xffff, 0);
        assert_eq!(chip.read(GPIO_C, 0), 0);
        chip.write(RCC + 0x18, 0x10, 0);
        assert_eq!(chip.read(GPIO_C, 0), 0x4444_4444);
        assert_eq!(chip.read(GPIO_C + 0x0c, 0), 0);
        let listed: Vec<String> = chip.unmodelled().into_iter().map(|one| one.name).collect();
        assert_eq!(listed, ["GPIOC+0x00", "GPIOC+0x0c"]);
    }

    #[test]
    fn a_reset_bit_puts_its_peripheral_back() {
        let mut chip = clocked();
        chip.write(GPIO_B, 0x3333_3333, 0);
        chip.write(RCC + 0x0c, 0x8, 0);
        chip.write(RCC + 0x0c, 0, 0);
        assert_eq!(chip.read(GPIO_B, 0), 0x4444_4444);
    }

    #[test]
    fn an_open_drain_passes_on_its_edges() {
        let mut chip = clocked();
        let vin_0 = 1 << 12;
        chip.write(GPIO_B + 0x10, vin_0, 0);
        chip.write(GPIO_B + 0x04, 0x4447_4444, 8); // PB12 open drain
        assert_eq!(chip.pins.0, [""; 0]);
        chip.write(GPIO_B + 0x14, vin_0, 16);
        assert_eq!(chip.read(GPIO_B + 0x08, 16) & vin_0, 0);
        chip.write(GPIO_B + 0x10, vin_0, 24);
        assert_eq!(chip.read(GPIO_B + 0x08, 24) & vin_0, vin_0);
        assert_eq!(chip.pins.0, ["PB12 false at 2000", "PB12 true at 3000"]);
        assert_eq!(chip.failure(), None);
    }

    #[test]
    fn driving_a_3_volt_line_high_ends_the_run() {
        let mut chip = clocked();
        chip.write(GPIO_B + 0x10, 1 << 13, 0);
        chip.write(GPIO_B + 0x04, 0x4434_4444, 8_000); // PB13 push-pull
        let failure = RunError::DrivenHigh {
            line: "Vin of sensor 2",
            at_ns: 1_000_000,
        };
        assert_eq!(chip.failure(), Some(&failure));
        assert_eq!(chip.next_event(), 0);
        assert_eq!(
            failure.to_string(),
            "Vin of sensor 2 was driven high, at 1 ms: it takes 3 V at most"
        );
    }

    #[test]
    fn a_port_reads_devices_and_pulls() {
        let mut chip = clocked();
        // PC8 pulled with nothing on it, PC10 to PC12 pulled down with devices on them, PC13 analog.
        chip.write(GPIO_C + 0x04, 0x4408_8848, 0);
        assert_eq!(chip.read(GPIO_C + 0x08, 0) & 0x7f00, 1 << 11);
        chip.write(GPIO_C + 0x0c, 1 << 8, 0);
        assert_eq!(chip.read(GPIO_C + 0x08, 0) & 0x7f00, 1 << 11 | 1 << 8);
        assert_eq!(chip.read(GPIO_B + 0x08, 0), 1 << 10 | 0b111 << 12);
    }

    #[test]
    fn a_push_pull_output_passes_on_its_edges() {
        let mut chip = clocked();
        chip.write(GPIO_C, 0x4444_4432, 0); // PC1 push-pull
        chip.write(GPIO_C + 0x10, 2, 8);
        chip.write(GPIO_C + 0x10, 2 << 16, 88);
        assert_eq!(chip.pins.0, ["PC1 true at 1000", "PC1 false at 11000"]);
    }

    #[test]
    fn pulses_begin_once_the_pin_is_the_timers() {
        let mut chip = clocked();
        for (register, value) in [(0x18, 0x6868), (0x20, 0x11), (0x28, 7), (0x2c, 19_999)] {
            chip.write(TIM3 + register, value, 0);
        }
        chip.write(TIM3 + 0x38, 1_234, 0);
        chip.write(TIM3 + 0x14, 1, 0);
        chip.write(TIM3, 0x81, 0);
        assert_eq!(chip.pins.0, [""; 0]);
        chip.write(GPIO_A, 0xb444_4444, 80); // PA7
        chip.write(TIM3 + 0x38, 2_000, 160);
        assert_eq!(chip.next_event(), 160_000);
        chip.advance(160_000);
        assert_eq!(
            chip.pins.0,
            ["Tim3.1 1234 at 10000", "Tim3.1 2000 at 20000000"]
        );
    }

    #[test]
    fn tim4_has_a_clock_of_its_own() {
        let mut chip = clocked();
        chip.write(GPIO_B, 0xb444_4444, 0); // PB7
        for (register, value) in [(0x18, 0x6868), (0x20, 0x11), (0x28, 7), (0x2c, 19_999)] {
            chip.write(TIM4 + register, value, 0);
        }
        chip.write(TIM4 + 0x38, 1_600, 0);
        chip.write(TIM4 + 0x14, 1, 0);
        chip.write(TIM4, 0x81, 8);
        assert_eq!(chip.pins.0, ["Tim4.1 1600 at 1000"]);
        chip.write(RCC + 0x1c, 0x2, 16); // TIM3's clock only
        chip.write(TIM4 + 0x38, 1_700, 24);
        assert_eq!(chip.next_event(), u64::MAX);
    }

    #[test]
    fn a_pulse_is_rounded_to_the_nearest_microsecond() {
        let mut chip = clocked();
        chip.write(GPIO_A, 0x4b44_4444, 0); // PA6
        for (register, value) in [(0x18, 0x60), (0x20, 1), (0x28, 2), (0x2c, 53_332)] {
            chip.write(TIM3 + register, value, 0);
        }
        chip.write(TIM3 + 0x14, 1, 0);
        chip.write(TIM3, 1, 0);
        chip.write(TIM3 + 0x34, 4_001, 0); // 1500.375 µs
        chip.write(TIM3 + 0x34, 4_002, 8); // 1500.75 µs
        assert_eq!(chip.pins.0, ["Tim3.0 1500 at 0", "Tim3.0 1501 at 1000"]);
    }

    #[test]
    fn serial_bytes_need_their_pin() {
        let mut chip = clocked();
        chip.write(USART1 + 0x08, 69, 0);
        chip.write(USART1 + 0x0c, 0x2008, 0);
        chip.write(USART1 + 0x04, 1, 0);
        chip.advance(1_000);
        chip.write(GPIO_A + 0x04, 0x4444_44b4, 1_000); // PA9
        chip.write(USART1 + 0x04, 2, 1_000);
        assert_eq!(chip.next_event(), 1_690);
        chip.advance(1_690);
        assert_eq!(chip.take_serial(), [2]);
        assert_eq!(chip.take_serial(), [0; 0]);
    }

    #[test]
    fn an_expired_watchdog_ends_the_run() {
        let mut chip = clocked();
        chip.write(IWDG, 0xcccc, 0);
        assert_eq!(chip.next_event(), 3_276_800);
        chip.advance(3_276_799);
        assert_eq!(chip.failure(), None);
        chip.advance(3_280_000);
        let expired = RunError::WatchdogExpired { at_ns: 409_600_000 };
        assert_eq!(chip.failure(), Some(&expired));
        assert_eq!(
            expired.to_string(),
            "the watchdog expired at 409 ms: it was not fed"
        );
    }
}
