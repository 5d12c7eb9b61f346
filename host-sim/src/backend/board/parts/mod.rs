//! The peripherals, one file each, and the bus that they share.

mod afio;
mod flash;
mod gpio;
mod pwm_timer;
mod rcc;
mod unmodelled;
mod usart;
mod watchdog;

use super::BoardError;
use super::pinout::{LINES, PORTS, PULSED, Pin, PortName, SERIAL_OUT, TimerName};
use crate::bench::Wires;
use afio::Afio;
use certainty_firmware::remote::Line;
use core::mem;
use flash::Flash;
use gpio::{Drive, Gpio};
use pwm_timer::PwmTimer;
pub use rcc::ResetCause;
use rcc::{Clocked, Rcc};
use unmodelled::Unmodelled;
pub use unmodelled::UnmodelledRegister;
use usart::Usart;
use watchdog::Watchdog;

/// Cycles of the processor in a microsecond.
pub(super) const CYCLES_PER_US: u64 = 8;

/// Nanoseconds of a cycle.
pub(super) const CYCLE_NS: u64 = 1000 / CYCLES_PER_US;

/// Where the peripherals begin.
pub(super) const PERIPHERALS_AT: u32 = 0x4000_0000;

/// How far they reach.
pub(super) const PERIPHERALS_BYTES: u32 = 0x2_3400;

/// All peripherals of the microcontroller, with the devices on its pins.
#[derive(Debug)]
pub(super) struct Parts<W> {
    pub(super) wires: W,
    rcc: Rcc,
    flash: Flash,
    afio: Afio,
    ports: [Gpio; PORTS.len()],
    tim3: PwmTimer,
    tim4: PwmTimer,
    usart1: Usart,
    watchdog: Watchdog,
    unmodelled: Unmodelled,
    /// What the wires were told last.
    told_levels: [bool; LINES.len()],
    told_pulses: [u32; PULSED.len()],
    serial: Vec<u8>,
    failure: Option<BoardError>,
}

/// What answers at an address.
enum Part {
    Rcc,
    Flash,
    Afio,
    Port(PortName),
    Tim3,
    Tim4,
    Usart1,
    Watchdog,
    Nothing,
}

impl Part {
    const fn at(address: u32) -> Self {
        match address & !0x3ff {
            0x4000_0400 => Self::Tim3,
            0x4000_0800 => Self::Tim4,
            0x4000_3000 => Self::Watchdog,
            0x4001_0000 => Self::Afio,
            0x4001_0800 => Self::Port(PortName::A),
            0x4001_0c00 => Self::Port(PortName::B),
            0x4001_1000 => Self::Port(PortName::C),
            0x4001_3800 => Self::Usart1,
            0x4002_1000 => Self::Rcc,
            0x4002_2000 => Self::Flash,
            _ => Self::Nothing,
        }
    }

    /// Whose clock must run for it; RCC, the flash and the watchdog always answer.
    const fn clocked(&self) -> Option<Clocked> {
        match self {
            Self::Afio => Some(Clocked::Afio),
            Self::Port(PortName::A) => Some(Clocked::GpioA),
            Self::Port(PortName::B) => Some(Clocked::GpioB),
            Self::Port(PortName::C) => Some(Clocked::GpioC),
            Self::Tim3 => Some(Clocked::Tim3),
            Self::Tim4 => Some(Clocked::Tim4),
            Self::Usart1 => Some(Clocked::Usart1),
            Self::Rcc | Self::Flash | Self::Watchdog | Self::Nothing => None,
        }
    }
}

impl<W: Wires> Parts<W> {
    pub(super) fn new(wires: W) -> Self {
        Self {
            wires,
            rcc: Rcc::default(),
            flash: Flash::default(),
            afio: Afio::default(),
            ports: Default::default(),
            tim3: PwmTimer::default(),
            tim4: PwmTimer::default(),
            usart1: Usart::default(),
            watchdog: Watchdog::default(),
            unmodelled: Unmodelled::default(),
            told_levels: LINES.map(|(_, line)| idle_level(line)),
            told_pulses: [0; PULSED.len()],
            serial: Vec::new(),
            failure: None,
        }
    }

    /// Tells the program, which has not begun, why it was reset.
    pub(super) fn reset_by(&mut self, cause: ResetCause) {
        self.rcc = Rcc::after(cause);
    }

    /// Reads the register at `address` in cycle `now`.
    pub(super) fn read(&mut self, address: u32, now: u64) -> u32 {
        let part = Part::at(address);
        if part
            .clocked()
            .is_some_and(|clocked| !self.rcc.enabled(clocked))
        {
            self.unmodelled.read(address);
            return 0;
        }
        let offset = address & 0x3ff;
        let value = match part {
            Part::Rcc => self.rcc.read(offset),
            Part::Flash => self.flash.read(offset),
            Part::Afio => self.afio.read(offset),
            Part::Port(name) => {
                let Self { ports, wires, .. } = self;
                let port = &ports[name as usize];
                port.read(offset, || levels(port, name, wires, now))
            }
            Part::Tim3 => self.tim3.read(offset, now),
            Part::Tim4 => self.tim4.read(offset, now),
            Part::Usart1 => self.usart1.read(offset),
            Part::Watchdog => self.watchdog.read(offset, now),
            Part::Nothing => None,
        };
        value.unwrap_or_else(|| self.unmodelled.read(address))
    }

    /// Writes the register at `address` in cycle `now`.
    pub(super) fn write(&mut self, address: u32, value: u32, now: u64) {
        let part = Part::at(address);
        if part
            .clocked()
            .is_some_and(|clocked| !self.rcc.enabled(clocked))
        {
            self.unmodelled.write(address, 0);
            return;
        }
        let offset = address & 0x3ff;
        let known = match part {
            Part::Rcc => {
                let known = self.rcc.write(offset, value);
                self.apply_resets();
                known
            }
            Part::Flash => self.flash.write(offset, value),
            Part::Afio => self.afio.write(offset, value),
            Part::Port(name) => self.ports[name as usize].write(offset, value),
            Part::Tim3 => self.tim3.write(offset, value, now),
            Part::Tim4 => self.tim4.write(offset, value, now),
            Part::Usart1 => self.usart1.write(offset, value, now),
            Part::Watchdog => self.watchdog.write(offset, value, now),
            Part::Nothing => false,
        };
        if !known {
            self.unmodelled.write(address, value);
        }
        self.tell_levels(now);
        self.tell_pulses(now);
    }

    fn apply_resets(&mut self) {
        for clocked in Clocked::ALL {
            if !self.rcc.in_reset(clocked) {
                continue;
            }
            match clocked {
                Clocked::Afio => self.afio = Afio::default(),
                Clocked::GpioA => self.ports[PortName::A as usize] = Gpio::default(),
                Clocked::GpioB => self.ports[PortName::B as usize] = Gpio::default(),
                Clocked::GpioC => self.ports[PortName::C as usize] = Gpio::default(),
                Clocked::Usart1 => self.usart1 = Usart::default(),
                Clocked::Tim3 => self.tim3 = PwmTimer::default(),
                Clocked::Tim4 => self.tim4 = PwmTimer::default(),
            }
        }
    }

    /// Lets the time until cycle `now` pass.
    pub(super) fn advance(&mut self, now: u64) {
        if let Some(loaded_at) = self.tim3.advance(now) {
            self.tell_pulses(loaded_at);
        }
        if let Some(loaded_at) = self.tim4.advance(now) {
            self.tell_pulses(loaded_at);
        }
        self.usart1.advance(now);
        let sent = self.usart1.take_sent();
        if self.afio.usart1_in_place() && self.drive(SERIAL_OUT) == Drive::Alternate {
            self.serial.extend(sent);
        }
        if let Some(at) = self.watchdog.bites_at().filter(|&at| at <= now) {
            self.fail(BoardError::WatchdogBite {
                at_ns: at * CYCLE_NS,
            });
        }
    }

    /// The next cycle in which something happens of itself.
    pub(super) fn next_event(&self) -> u64 {
        if self.failure.is_some() {
            return 0;
        }
        let own = [
            self.tim3.next_event(),
            self.tim4.next_event(),
            self.usart1.next_event(),
            self.watchdog.bites_at(),
        ];
        own.into_iter().flatten().min().unwrap_or(u64::MAX)
    }

    /// Whether USART1 asks for its interrupt.
    pub(super) const fn serial_interrupts(&self) -> bool {
        self.usart1.interrupts()
    }

    /// What went wrong, if anything.
    pub(super) fn failure(&self) -> Option<&BoardError> {
        self.failure.as_ref()
    }

    /// Takes the bytes that left on the serial line since it was last taken.
    pub(super) fn take_serial(&mut self) -> Vec<u8> {
        mem::take(&mut self.serial)
    }

    pub(super) fn unmodelled(&self) -> Vec<UnmodelledRegister> {
        self.unmodelled.listing()
    }

    fn drive(&self, (port, pin): Pin) -> Drive {
        self.ports[port as usize].drive(pin)
    }

    /// The first failure is what is told.
    fn fail(&mut self, failure: BoardError) {
        self.failure.get_or_insert(failure);
    }

    fn tell_levels(&mut self, now: u64) {
        let at_ns = now * CYCLE_NS;
        for (index, (pin, line)) in LINES.into_iter().enumerate() {
            let drive = self.drive(pin);
            let level = match (line, drive) {
                (Line::Vout(_) | Line::Echo(_), _) => continue,
                (Line::Vin(slot), Drive::High | Drive::Pulled(true)) => {
                    self.fail(BoardError::VinDrivenHigh { slot, at_ns });
                    true
                }
                (_, Drive::Low | Drive::Pulled(false)) => false,
                (_, Drive::High | Drive::Pulled(true)) => true,
                (_, Drive::Released | Drive::Alternate) => idle_level(line),
            };
            if mem::replace(&mut self.told_levels[index], level) != level {
                self.wires.set_level(line, level, at_ns);
            }
        }
    }

    fn tell_pulses(&mut self, now: u64) {
        for (index, (timer, channel, pin, wired)) in PULSED.into_iter().enumerate() {
            let (timer, in_place) = match timer {
                TimerName::Tim3 => (&self.tim3, self.afio.tim3_in_place()),
                TimerName::Tim4 => (&self.tim4, self.afio.tim4_in_place()),
            };
            let out = in_place && self.drive(pin) == Drive::Alternate;
            let cycles = if out { timer.pulse_cycles(channel) } else { 0 };
            // At most 2^32 cycles: 65,536 counts of 65,536 cycles.
            let width_us = ((cycles + CYCLES_PER_US / 2) / CYCLES_PER_US) as u32;
            if mem::replace(&mut self.told_pulses[index], width_us) != width_us {
                self.wires.set_pulse(wired, width_us, now * CYCLE_NS);
            }
        }
    }
}

/// The level of a line that the board does not drive: a GP2D02 pulls its Vin up itself.
const fn idle_level(line: Line) -> bool {
    matches!(line, Line::Vin(_))
}

/// The levels of a port's pins.
fn levels(port: &Gpio, name: PortName, wires: &mut impl Wires, now: u64) -> u16 {
    let mut levels = 0;
    for pin in 0..16 {
        if !port.digital(pin) {
            continue;
        }
        let line = LINES.iter().find(|(at, _)| *at == (name, pin));
        let high = match (port.drive(pin), line) {
            (Drive::Low, _) => false,
            (Drive::High, _) => true,
            (_, Some((_, line @ (Line::Vout(_) | Line::Echo(_))))) => {
                wires.level(*line, now * CYCLE_NS)
            }
            (_, Some((_, line))) => idle_level(*line),
            (Drive::Pulled(up), None) => up,
            (Drive::Released | Drive::Alternate, None) => false,
        };
        levels |= u16::from(high) << pin;
    }
    levels
}

#[cfg(test)]
mod tests;
