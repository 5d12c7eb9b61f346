//! The microcontroller: processor, memories and peripherals, run cycle by cycle.

use crate::bus::Bus;
use crate::error::RunError;
use crate::flash_image::{FLASH_AT, RAM_AT, RAM_BYTES, flash_image, initial_stack_pointer};
use crate::it_blocks;
use crate::peripherals::{
    CYCLE_NS, PERIPHERALS_AT, PERIPHERALS_BYTES, ResetCause, UnmodelledRegister,
};
use crate::pins::{Connection, Pin, Pins};
use core::fmt;
use rsemu::core::error::Error;
use rsemu::core::space::{AddressSpace, RamStore, Region, RomStore, RomWrite};
use rsemu::cpu::arm::v7m::sys::Exception;
use rsemu::cpu::arm::v7m::{ArmV7m, Config, Regs};
use std::sync::Arc;

/// Cycles of a millisecond.
const CYCLES_PER_MS: u64 = 8_000;

/// USART1's interrupt.
const USART1_INTERRUPT: u16 = 37;

/// A byte of RAM at power-on: anything but zero.
const POWER_ON_RAM: u8 = 0xa5;

/// An emulated STM32F100RB that runs a firmware image against devices on its pins.
pub struct Stm32f100<P> {
    core: ArmV7m,
    bus: Arc<Bus<P>>,
    ram: Arc<RamStore>,
    /// The registers after the last step.
    registers: Regs,
    /// Cycles of sleep that were skipped, not emulated one by one.
    skipped: u64,
    initial_stack: u32,
    lowest_stack: u32,
    skip_sleep: bool,
}

impl<P> fmt::Debug for Stm32f100<P> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Stm32f100")
            .field("pc", &self.core.pc())
            .field("skipped", &self.skipped)
            .field("lowest_stack", &self.lowest_stack)
            .finish_non_exhaustive()
    }
}

impl<P: Pins + Send + 'static> Stm32f100<P> {
    /// Creates a microcontroller with the program of the ELF file `elf` in its flash, before its first
    /// instruction after power-on.
    ///
    /// `wiring` lists the connected pins, and `pins` is the devices on them. Levels that one write to a
    /// port changes are passed on in the order of `wiring`.
    ///
    /// # Errors
    ///
    /// [`RunError::NotAnImage`] where `elf` is no program for it.
    pub fn new(elf: &[u8], wiring: &[(Pin, Connection)], pins: P) -> Result<Self, RunError> {
        let flash = flash_image(elf)?;
        let initial_stack = initial_stack_pointer(&flash);
        let bus = Arc::new(Bus::new(wiring, pins));
        let ram = Arc::new(RamStore::new(RAM_BYTES as u64));
        let space =
            memory(&flash, &ram, &bus).map_err(|error| RunError::Emulator(error.to_string()))?;
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

    /// Sets the reset cause that the program reads, in place of power-on; before the first step.
    #[must_use]
    pub fn after(self, cause: ResetCause) -> Self {
        self.bus.peripherals().set_reset_cause(cause);
        self
    }

    /// Runs to the next whole millisecond.
    ///
    /// # Errors
    ///
    /// What ended the run; every later step ends with it again.
    pub fn step_ms(&mut self) -> Result<(), RunError> {
        let until = (self.cycles() / CYCLES_PER_MS + 1) * CYCLES_PER_MS;
        self.run_to_cycle(until)
    }

    /// Runs for `milliseconds`, each to the next whole one.
    ///
    /// # Errors
    ///
    /// What ended the run.
    pub fn run_for(&mut self, milliseconds: u64) -> Result<(), RunError> {
        (0..milliseconds).try_for_each(|_| self.step_ms())
    }

    /// Takes the bytes that the serial port sent since the last call.
    pub fn take_serial(&mut self) -> Vec<u8> {
        self.bus.peripherals().take_serial()
    }

    /// Runs `act` on the devices on the pins.
    pub fn with_pins<T>(&mut self, act: impl FnOnce(&mut P) -> T) -> T {
        act(&mut self.bus.peripherals().pins)
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

    /// Returns the cycles in which the processor was awake.
    #[must_use]
    pub fn cycles_awake(&self) -> u64 {
        self.core.cycles()
    }

    /// Returns the lowest value of the stack pointer since the reset.
    #[must_use]
    pub const fn lowest_stack_pointer(&self) -> u32 {
        self.lowest_stack
    }

    /// Returns the deepest stack since the reset, in bytes.
    #[must_use]
    pub const fn stack_bytes(&self) -> u32 {
        self.initial_stack - self.lowest_stack
    }

    /// Returns the registers that the firmware used without a model behind them, and those of
    /// peripherals whose clock was off.
    #[must_use]
    pub fn unmodelled(&self) -> Vec<UnmodelledRegister> {
        self.bus.peripherals().unmodelled()
    }

    fn run_to_cycle(&mut self, until: u64) -> Result<(), RunError> {
        let mut now = self.cycles();
        let mut interrupts = self.core.irq_asserted(USART1_INTERRUPT);
        while now < until {
            self.bus.set_now(now);
            if now >= self.bus.next_event() {
                self.bus.with(|peripherals, now| peripherals.advance(now));
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

    /// Evaluates the registers after a step: the stack pointer, and IT blocks.
    fn note_registers(&mut self) {
        let mut registers = self.core.regs();
        self.lowest_stack = self.lowest_stack.min(registers.msp);
        it_blocks::restore(
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

    /// Returns what ended the run as an error, if it has ended.
    fn check(&self) -> Result<(), RunError> {
        let at_ns = self.now_ns();
        if let Some(failure) = self.bus.peripherals().failure() {
            return Err(failure.clone());
        }
        if self.core.is_locked_up() {
            let pc = self.core.pc();
            return Err(RunError::LockedUp { at_ns, pc });
        }
        if self.core.reset_requested() {
            return Err(RunError::Reset { at_ns });
        }
        if self.core.current_exception() == Exception::HARD_FAULT {
            let (_, address) = self.core.bus_faults();
            return Err(RunError::HardFault { at_ns, address });
        }
        Ok(())
    }
}

/// The microcontroller's address space: flash, mapped at 0 too as it boots from it, RAM, peripherals.
fn memory<P: Pins + Send + 'static>(
    flash: &[u8],
    ram: &Arc<RamStore>,
    bus: &Arc<Bus<P>>,
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
mod tests {
    //! Programs of a few instructions, assembled by hand.

    use super::*;
    use crate::test_elf::elf_of;

    /// The vectors up to `SysTick`'s; handlers in the order of their numbers, where there are any.
    fn program(handlers: [u32; 15], code: &[u16]) -> Vec<u8> {
        let mut data = 0x2000_2000_u32.to_le_bytes().to_vec();
        for handler in handlers {
            data.extend(handler.to_le_bytes());
        }
        for half in code {
            data.extend(half.to_le_bytes());
        }
        elf_of(FLASH_AT, &data)
    }

    /// The code's first instruction is here, as a Thumb address.
    const START: u32 = FLASH_AT + 0x41;

    fn chip(image: &[u8]) -> Stm32f100<()> {
        Stm32f100::new(image, &[], ()).unwrap()
    }

    /// Starts a 1 kHz `SysTick`, turns USART1 on, sleeps forever; `SysTick`'s handler sends a byte.
    fn ticking() -> Vec<u8> {
        let mut handlers = [START; 15];
        handlers[14] = START + 2 * 16; // SysTick
        let code = [
            // 0: literals are behind the code, at half-word 22
            0x4c0a, // ldr r4, [pc, #40] ; SysTick
            0x4d0b, // ldr r5, [pc, #44] ; RCC
            0x4e0b, // ldr r6, [pc, #44] ; USART1
            0x4f0c, // ldr r7, [pc, #48] ; GPIOA
            0x480c, // ldr r0, [pc, #48] ; reload
            0x6060, // str r0, [r4, #4]
            0x2007, // movs r0, #7
            0x6020, // str r0, [r4, #0]
            // 8
            0x480b, // ldr r0, [pc, #44] ; clocks
            0x61a8, // str r0, [r5, #24]
            0x2045, // movs r0, #69
            0x60b0, // str r0, [r6, #8]
            0x480a, // ldr r0, [pc, #40] ; UE and TE
            0x60f0, // str r0, [r6, #12]
            0xbf30, // wfi
            0xe7fd, // b to the wfi
            // 16: the handler
            0x20b0, // movs r0, #0xb0
            0x6078, // str r0, [r7, #4] ; PA9 is the port's
            0x202a, // movs r0, #42
            0x6070, // str r0, [r6, #4]
            0x4770, // bx lr
            0xbf00, // nop
            // 22
            0xe010, 0xe000, // SysTick
            0x1000, 0x4002, // RCC
            0x3800, 0x4001, // USART1
            0x0800, 0x4001, // GPIOA
            0x1f3f, 0x0000, // 7999
            0x4004, 0x0000, // port A and USART1
            0x2008, 0x0000, // UE and TE
        ];
        program(handlers, &code)
    }

    #[test]
    fn a_tick_wakes_the_processor_every_millisecond() {
        let mut chip = chip(&ticking());
        for _ in 0..100 {
            chip.step_ms().unwrap();
        }
        assert_eq!(chip.now_ns() / 1_000_000, 100);
        // The first tick is a millisecond after the start, and a byte takes a part of one.
        assert_eq!(chip.take_serial(), [42; 99]);
        assert!(chip.cycles_awake() < chip.cycles() / 10, "{chip:?}");
        assert_eq!(chip.stack_bytes(), 32); // one exception's frame
        assert_eq!(chip.lowest_stack_pointer(), 0x2000_2000 - 32);
        assert_eq!(chip.unmodelled(), []);
    }

    #[test]
    fn skipping_sleep_changes_no_result() {
        let mut skipping = chip(&ticking());
        let mut stepping = chip(&ticking());
        stepping.skip_sleep = false;
        for _ in 0..20 {
            skipping.step_ms().unwrap();
            stepping.step_ms().unwrap();
            assert_eq!(skipping.cycles(), stepping.cycles());
            assert_eq!(skipping.take_serial(), stepping.take_serial());
            let clock = |chip: &Stm32f100<()>| chip.core.with_sys(|system| system.syst_cvr);
            assert_eq!(clock(&skipping), clock(&stepping));
        }
        assert_eq!(stepping.skipped, 0);
        assert!(skipping.skipped > 19 * CYCLES_PER_MS);
    }

    #[test]
    fn an_undefined_instruction_is_a_hard_fault() {
        let mut handlers = [START; 15];
        handlers[2] = START + 2;
        let mut chip = chip(&program(handlers, &[0xde00, 0xe7fe])); // udf; b .
        let error = chip.step_ms().unwrap_err();
        assert!(matches!(error, RunError::HardFault { .. }), "{error}");
        assert_eq!(
            chip.step_ms().unwrap_err().to_string().split(" ms").next(),
            Some("hard fault at 2")
        );
    }

    #[test]
    fn a_fault_within_the_fault_handler_locks_up() {
        let mut handlers = [START; 15];
        handlers[2] = START;
        let mut chip = chip(&program(handlers, &[0xde00]));
        let error = chip.step_ms().unwrap_err();
        assert!(matches!(error, RunError::LockedUp { .. }), "{error}");
    }

    #[test]
    fn without_an_interrupt_the_watchdog_ends_the_sleep() {
        let code = [
            0x4802, // ldr r0, [pc, #8] ; IWDG
            0x4903, // ldr r1, [pc, #12] ; the key that starts it
            0x6001, // str r1, [r0, #0]
            0xbf30, // wfi
            0xe7fd, // b to the wfi
            0xbf00, 0x3000, 0x4000, 0xcccc, 0x0000,
        ];
        let mut chip = chip(&program([START; 15], &code));
        let error = (0..1_000).find_map(|_| chip.step_ms().err()).unwrap();
        let RunError::WatchdogExpired { at_ns } = error else {
            panic!("{error}")
        };
        // 4096 counts of 100 µs after the first few instructions.
        assert!((409_600_000..409_610_000).contains(&at_ns), "{at_ns}");
        assert_eq!(chip.step_ms(), Err(error));
    }

    #[test]
    fn a_requested_reset_ends_the_run() {
        let code = [
            0x4801, // ldr r0, [pc, #4] ; AIRCR
            0x4902, // ldr r1, [pc, #8] ; key and SYSRESETREQ
            0x6001, // str r1, [r0, #0]
            0xe7fe, // b .
            0xed0c, 0xe000, 0x0004, 0x05fa,
        ];
        let mut chip = chip(&program([START; 15], &code));
        let error = chip.step_ms().unwrap_err();
        assert!(matches!(error, RunError::Reset { .. }), "{error}");
    }

    /// Loops over an IT block whose condition is never true while `SysTick` interrupts it.
    ///
    /// Returns the sum that the block added up; `handler` is `SysTick`'s.
    fn added_in_an_it_block(handler: [u16; 3]) -> u32 {
        let mut handlers = [START; 15];
        handlers[14] = START + 2 * 13;
        let mut code = vec![
            0x4c07, // ldr r4, [pc, #28] ; SysTick
            0x2061, // movs r0, #97 ; cycles between interrupts, less one
            0x6060, // str r0, [r4, #4]
            0x2007, // movs r0, #7
            0x6020, // str r0, [r4, #0]
            0x2100, // movs r1, #0
            0x2801, // cmp r0, #1 ; it is 7
            0xbf01, // itttt eq
            0x3101, 0x3101, 0x3101, 0x3101, // four times adds r1, #1
            0xe7f8, // b to the comparison
        ];
        code.extend(handler);
        code.extend([0xe010, 0xe000]);
        let mut chip = chip(&program(handlers, &code));
        chip.step_ms().unwrap();
        assert_eq!(chip.stack_bytes(), 32, "it was not interrupted");
        chip.core.reg(1)
    }

    #[test]
    fn an_interrupted_it_block_keeps_its_condition() {
        // bx lr
        assert_eq!(added_in_an_it_block([0x4770, 0xbf00, 0xbf00]), 0);
    }

    #[test]
    fn a_return_from_an_it_block_keeps_the_interrupted_one() {
        // it ne; bx lr; bx lr
        assert_eq!(added_in_an_it_block([0xbf18, 0x4770, 0x4770]), 0);
    }
}
