//! The Smart Car's microcontroller, emulated: it runs the image that is flashed, unchanged.
//!
//! A Cortex-M3 core with its NVIC and `SysTick` (the crate `rsemu`), this module's models of the
//! peripherals that the image uses, and devices on its pins ([`Wires`]). Time is the processor's: one
//! cycle of the 8 MHz oscillator is 125 ns, and the same image with the same devices does the same
//! thing in the same cycle, every run.
//!
//! What is modelled, and how strictly: a peripheral whose clock is off reads 0 and takes nothing; the
//! PLL and the crystal never get ready; RAM begins as garbage; a servo's or a motor's new pulse begins with the next
//! 20 ms; a byte takes its ten bits of time on the serial line; the watchdog bites, and that ends the
//! run. The processor's cycles are `rsemu`'s count, not silicon's: each instruction one or a few, flash
//! without wait states.
//!
//! Speed: many times real time, as a sleeping processor is skipped to its next event.

mod bus;
mod conditional_blocks;
#[cfg(test)]
mod elf_of;
mod error;
mod flash_image;
mod parts;
mod pinout;

pub use error::BoardError;
pub use parts::{ResetCause, UnmodelledRegister};

use super::image::Image;
use super::{BackendError, Ran};
use crate::bench::{Bench, Wires};
use bus::Bus;
use core::fmt;
use flash_image::{FLASH_AT, RAM_AT, RAM_BYTES, flash_image, initial_stack_pointer};
use parts::{CYCLE_NS, PERIPHERALS_AT, PERIPHERALS_BYTES};
use rsemu::core::error::Error;
use rsemu::core::space::{AddressSpace, RamStore, Region, RomStore, RomWrite};
use rsemu::cpu::arm::v7m::sys::Exception;
use rsemu::cpu::arm::v7m::{ArmV7m, Config, Regs};
use std::sync::Arc;

/// Cycles of a millisecond.
const CYCLES_PER_MS: u64 = 8_000;

/// After so many milliseconds without a byte a round's reports are all out.
const QUIET_MS: u32 = 2;

/// After so many milliseconds of its time without a byte a firmware has nothing to say: the rounds
/// of this one take 800.
const PATIENCE_MS: u32 = 10_000;

/// USART1's interrupt.
const USART1_INTERRUPT: u16 = 37;

/// What RAM holds when the power comes on: anything but zeros.
const POWER_ON_RAM: u8 = 0xa5;

/// An emulated board that runs a firmware image against devices on its pins.
pub struct EmulatedBoard<W> {
    core: ArmV7m,
    bus: Arc<Bus<W>>,
    ram: Arc<RamStore>,
    /// The registers after the last step.
    registers: Regs,
    /// Cycles that were slept through without emulating them one by one.
    skipped: u64,
    initial_stack: u32,
    lowest_stack: u32,
    skip_sleep: bool,
}

impl<W> fmt::Debug for EmulatedBoard<W> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("EmulatedBoard")
            .field("pc", &self.core.pc())
            .field("skipped", &self.skipped)
            .field("lowest_stack", &self.lowest_stack)
            .finish_non_exhaustive()
    }
}

impl<W: Wires + Send + 'static> EmulatedBoard<W> {
    /// Creates a board with the program of the ELF file `elf` in its flash, about to come out of
    /// reset.
    ///
    /// # Errors
    ///
    /// [`BoardError::NotAnImage`] where `elf` is no program for it.
    pub fn new(elf: &[u8], wires: W) -> Result<Self, BoardError> {
        let flash = flash_image(elf)?;
        let initial_stack = initial_stack_pointer(&flash);
        let bus = Arc::new(Bus::new(wires));
        let ram = Arc::new(RamStore::new(RAM_BYTES as u64));
        let space =
            memory(&flash, &ram, &bus).map_err(|error| BoardError::Emulator(error.to_string()))?;
        let core = ArmV7m::new(Config::CORTEX_M3.with_priority_bits(4));
        core.attach_space(Arc::new(space));
        Ok(Self {
            registers: core.regs(),
            core,
            bus,
            ram,
            skipped: 0,
            initial_stack,
            lowest_stack: initial_stack,
            skip_sleep: true,
        })
    }

    /// Makes its start one for this reason, in place of its power that came on; before it runs.
    #[must_use]
    pub fn after(self, cause: ResetCause) -> Self {
        self.bus.parts().reset_by(cause);
        self
    }

    /// Runs to the next whole millisecond.
    ///
    /// # Errors
    ///
    /// What ended the run; running on ends it again at once.
    pub fn step_ms(&mut self) -> Result<(), BoardError> {
        let until = (self.cycles() / CYCLES_PER_MS + 1) * CYCLES_PER_MS;
        self.run_to_cycle(until)
    }

    /// Runs until `done`, which is asked every millisecond, for at most `limit_ms`.
    ///
    /// Returns whether it is done.
    ///
    /// # Errors
    ///
    /// What ended the run.
    pub fn run_until(
        &mut self,
        limit_ms: u64,
        mut done: impl FnMut(&mut Self) -> bool,
    ) -> Result<bool, BoardError> {
        for _ in 0..limit_ms {
            self.step_ms()?;
            if done(self) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Takes the bytes that the serial port sent since they were last taken.
    pub fn take_serial(&mut self) -> Vec<u8> {
        self.bus.parts().take_serial()
    }

    /// Does something with the devices on the pins.
    pub fn with_wires<T>(&mut self, act: impl FnOnce(&mut W) -> T) -> T {
        act(&mut self.bus.parts().wires)
    }

    /// Returns the cycles since the reset.
    #[must_use]
    pub fn cycles(&self) -> u64 {
        self.core.cycles() + self.skipped
    }

    /// Returns the nanoseconds since the reset.
    #[must_use]
    pub fn now_ns(&self) -> u64 {
        self.cycles() * CYCLE_NS
    }

    /// Returns the cycles that the processor was awake.
    #[must_use]
    pub fn cycles_awake(&self) -> u64 {
        self.core.cycles()
    }

    /// Returns the lowest that the stack pointer ever was.
    #[must_use]
    pub const fn lowest_stack_pointer(&self) -> u32 {
        self.lowest_stack
    }

    /// Returns how deep the stack ever was, in bytes.
    #[must_use]
    pub const fn stack_bytes(&self) -> u32 {
        self.initial_stack - self.lowest_stack
    }

    /// Returns whether the processor stands still after a fault within the fault handler.
    #[must_use]
    pub fn is_locked_up(&self) -> bool {
        self.core.is_locked_up()
    }

    /// Returns the registers that the firmware used though no model stands behind them, and those of
    /// peripherals whose clock was off.
    #[must_use]
    pub fn unmodelled(&self) -> Vec<UnmodelledRegister> {
        self.bus.parts().unmodelled()
    }

    fn run_to_cycle(&mut self, until: u64) -> Result<(), BoardError> {
        let mut now = self.cycles();
        let mut interrupts = self.core.irq_asserted(USART1_INTERRUPT);
        while now < until {
            self.bus.set_now(now);
            if now >= self.bus.next_event() {
                self.bus.with(|parts, now| parts.advance(now));
                self.check()?;
            }
            if self.bus.serial_interrupts() != interrupts {
                interrupts = !interrupts;
                self.core.set_irq(USART1_INTERRUPT, interrupts);
            }
            let used = self.core.step();
            now += used;
            self.note_registers();
            // A sleeping processor spends its cycles one by one.
            if used == 1 && self.skip_sleep && self.core.is_asleep() {
                now += self.sleep(until.min(self.bus.next_event()).saturating_sub(now));
            }
        }
        self.bus.set_now(now);
        self.check()
    }

    /// Looks at the registers after a step.
    fn note_registers(&mut self) {
        let mut registers = self.core.regs();
        self.lowest_stack = self.lowest_stack.min(registers.msp);
        conditional_blocks::mend(
            &self.core,
            &self.ram,
            RAM_AT,
            &self.registers,
            &mut registers,
        );
        self.registers = registers;
    }

    /// Sleeps for at most `cycles`, and wakes one cycle before `SysTick` would; returns how long.
    fn sleep(&mut self, cycles: u64) -> u64 {
        let slept = self.core.with_sys(|system| {
            if system.highest_pending().is_some() {
                return 0;
            }
            let counts = system.syst_csr & 1 == 1 && system.syst_rvr != 0;
            let slept = match (counts, system.syst_cvr) {
                (false, _) => cycles,
                (true, 0) => 0,
                (true, count) => cycles.min(u64::from(count) - 1),
            };
            system.tick_systick(slept);
            system.tick_cyccnt(slept);
            slept
        });
        self.skipped += slept;
        slept
    }

    /// Tells what ended the run, if it has ended.
    fn check(&self) -> Result<(), BoardError> {
        let at_ns = self.now_ns();
        if let Some(failure) = self.bus.parts().failure() {
            return Err(failure.clone());
        }
        if self.core.is_locked_up() {
            let pc = self.core.pc();
            return Err(BoardError::LockedUp { at_ns, pc });
        }
        if self.core.reset_requested() {
            return Err(BoardError::Reset { at_ns });
        }
        if self.core.current_exception() == Exception::HARD_FAULT {
            let (_, address) = self.core.bus_faults();
            return Err(BoardError::HardFault { at_ns, address });
        }
        Ok(())
    }
}

/// Runs `image` against `bench` until `enough` of its telemetry has come.
///
/// # Errors
///
/// [`BackendError::BadImage`] or [`BackendError::Board`], with what ended the run.
pub(super) fn run(
    image: &Image,
    bench: Bench,
    enough: &mut dyn FnMut(&[u8]) -> bool,
) -> Result<Ran, BackendError> {
    let failed = |error: BoardError| BackendError::Board(error.to_string());
    let mut board = EmulatedBoard::new(image.bytes(), bench).map_err(|error| match error {
        BoardError::NotAnImage(why) => BackendError::BadImage {
            path: image.path().to_path_buf(),
            why,
        },
        error => failed(error),
    })?;
    let mut told_enough = false;
    let mut quiet_ms = 0;
    // The stack is told after the last report, when the port has nothing left to send.
    while !told_enough || quiet_ms < QUIET_MS {
        if quiet_ms == PATIENCE_MS {
            return Err(BackendError::Silent);
        }
        board.step_ms().map_err(failed)?;
        let telemetry = board.take_serial();
        quiet_ms = if telemetry.is_empty() {
            quiet_ms + 1
        } else {
            0
        };
        told_enough |= !telemetry.is_empty() && enough(&telemetry);
    }
    Ok(Ran {
        sizes: Some(image.sizes()),
        stack_bytes: Some(board.stack_bytes()),
        stages: board.with_wires(|bench| bench.stages().to_vec()),
    })
}

/// The microcontroller's address space: flash, seen at 0 too as it boots from it, RAM, peripherals.
fn memory<W: Wires + Send + 'static>(
    flash: &[u8],
    ram: &Arc<RamStore>,
    bus: &Arc<Bus<W>>,
) -> Result<AddressSpace, Error> {
    let space = AddressSpace::new("STM32F100RB", 32);
    let rom = Arc::new(RomStore::from_slice(flash));
    let refused = |error| Error::Config {
        at: "RAM".to_owned(),
        message: format!("{error:?}"),
    };
    ram.fill(0, RAM_BYTES as u64, POWER_ON_RAM)
        .map_err(refused)?;
    let rom = Arc::new(Region::rom("flash", rom, RomWrite::Fault));
    let bus = Arc::clone(bus);
    let peripherals = Region::io("peripherals", PERIPHERALS_BYTES.into(), bus);
    let mut topology = space.topology();
    topology.map(Arc::clone(&rom), FLASH_AT.into())?;
    topology.map(rom, 0)?;
    topology.map(Region::ram("RAM", Arc::clone(ram)), RAM_AT.into())?;
    topology.map(peripherals, PERIPHERALS_AT.into())?;
    drop(topology);
    Ok(space)
}

#[cfg(test)]
mod tests;
