//! RCC: the clocks. Only the internal 8 MHz oscillator is emulated; the others never get ready.

/// The peripherals whose clocks and resets are emulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Clocked {
    Afio,
    GpioA,
    GpioB,
    GpioC,
    Usart1,
    Tim3,
    Tim4,
}

impl Clocked {
    pub(crate) const ALL: [Self; 7] = [
        Self::Afio,
        Self::GpioA,
        Self::GpioB,
        Self::GpioC,
        Self::Usart1,
        Self::Tim3,
        Self::Tim4,
    ];

    /// Its bus, 1 or 2, and its bit in that bus's registers.
    const fn place(self) -> (usize, u32) {
        match self {
            Self::Afio => (2, 0),
            Self::GpioA => (2, 2),
            Self::GpioB => (2, 3),
            Self::GpioC => (2, 4),
            Self::Usart1 => (2, 14),
            Self::Tim3 => (1, 1),
            Self::Tim4 => (1, 2),
        }
    }
}

const HSI_ON: u32 = 1;
const HSI_READY: u32 = 1 << 1;
/// HSEON and PLLON may be set; their ready flags stay 0.
const CR_WRITABLE: u32 = 0x010d_00f9;
const LSI_ON: u32 = 1;
/// RMVF: clears the reset flags.
const CLEAR_RESET_FLAGS: u32 = 1 << 24;
const RESETS: u32 = 0xfc00_0000;

/// Why the microcontroller was reset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ResetCause {
    /// Power-on.
    #[default]
    PowerOn,
    /// The reset pin alone.
    Pin,
    /// The program requested it.
    Software,
    /// The independent watchdog expired.
    Watchdog,
    /// The window watchdog expired.
    WindowWatchdog,
    /// The program entered a low-power mode that the option bytes forbid.
    LowPower,
}

impl ResetCause {
    /// The flags in CSR; every reset pulls the pin.
    const fn flags(self) -> u32 {
        const PIN: u32 = 1 << 26;
        PIN | match self {
            Self::Pin => 0,
            Self::PowerOn => 1 << 27,
            Self::Software => 1 << 28,
            Self::Watchdog => 1 << 29,
            Self::WindowWatchdog => 1 << 30,
            Self::LowPower => 1 << 31,
        }
    }
}

/// RCC's registers.
#[derive(Debug)]
pub(crate) struct Rcc {
    cr: u32,
    cfgr: u32,
    /// By bus; 0 is not used.
    reset: [u32; 3],
    enable: [u32; 3],
    ahb_enable: u32,
    csr: u32,
}

impl Default for Rcc {
    fn default() -> Self {
        Self {
            cr: 0x81,
            cfgr: 0,
            reset: [0; 3],
            enable: [0; 3],
            ahb_enable: 0x14,
            csr: ResetCause::PowerOn.flags(),
        }
    }
}

impl Rcc {
    /// The registers after a reset.
    pub(crate) fn after(cause: ResetCause) -> Self {
        Self {
            csr: cause.flags(),
            ..Self::default()
        }
    }

    pub(crate) fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            0x00 => self.cr | ((self.cr & HSI_ON) * HSI_READY),
            0x04 => self.cfgr,
            0x0c => self.reset[2],
            0x10 => self.reset[1],
            0x14 => self.ahb_enable,
            0x18 => self.enable[2],
            0x1c => self.enable[1],
            0x24 => self.csr | ((self.csr & LSI_ON) << 1),
            _ => return None,
        })
    }

    /// Returns whether there is such a register.
    pub(crate) fn write(&mut self, offset: u32, value: u32) -> bool {
        match offset {
            // The oscillator that drives the system cannot be stopped.
            0x00 => self.cr = value & CR_WRITABLE | HSI_ON,
            // Switching to a clock that is not ready does nothing: SW and SWS stay 0.
            0x04 => self.cfgr = value & 0x07ff_fff0,
            0x0c => self.reset[2] = value,
            0x10 => self.reset[1] = value,
            0x14 => self.ahb_enable = value,
            0x18 => self.enable[2] = value,
            0x1c => self.enable[1] = value,
            0x24 => {
                let forgets = value & CLEAR_RESET_FLAGS != 0;
                let kept = if forgets { 0 } else { self.csr & RESETS };
                self.csr = kept | value & LSI_ON;
            }
            _ => return false,
        }
        true
    }

    /// Whether its clock runs; without it a peripheral reads 0 and takes nothing.
    pub(crate) const fn enabled(&self, peripheral: Clocked) -> bool {
        let (bus, bit) = peripheral.place();
        self.enable[bus] >> bit & 1 == 1
    }

    /// Whether it is held in reset.
    pub(crate) const fn in_reset(&self, peripheral: Clocked) -> bool {
        let (bus, bit) = peripheral.place();
        self.reset[bus] >> bit & 1 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_internal_oscillator_gets_ready() {
        let mut rcc = Rcc::default();
        assert_eq!(rcc.read(0x00), Some(0x83));
        rcc.write(0x00, 0x0101_0000); // HSE and PLL on, HSI off
        assert_eq!(rcc.read(0x00), Some(0x0101_0003));
        rcc.write(0x04, 2); // the PLL as the system's clock
        assert_eq!(rcc.read(0x04), Some(0));
    }

    #[test]
    fn a_bit_acts_on_its_peripheral_only() {
        for peripheral in Clocked::ALL {
            let mut rcc = Rcc::default();
            let (bus, bit) = peripheral.place();
            rcc.write(if bus == 2 { 0x18 } else { 0x1c }, 1 << bit);
            rcc.write(if bus == 2 { 0x0c } else { 0x10 }, 1 << bit);
            for other in Clocked::ALL {
                assert_eq!(rcc.enabled(other), other == peripheral);
                assert_eq!(rcc.in_reset(other), other == peripheral);
            }
        }
        assert!(!Rcc::default().write(0x2c, 0));
    }

    #[test]
    fn reset_flags_stay_until_they_are_cleared() {
        // RM0041, RCC_CSR: its value after the power came on.
        assert_eq!(Rcc::default().read(0x24), Some(0x0c00_0000));
        for (cause, flags) in [
            (ResetCause::Pin, 0x0400_0000),
            (ResetCause::Software, 0x1400_0000),
            (ResetCause::Watchdog, 0x2400_0000),
            (ResetCause::WindowWatchdog, 0x4400_0000),
            (ResetCause::LowPower, 0x8400_0000),
        ] {
            let mut rcc = Rcc::after(cause);
            assert_eq!(rcc.read(0x24), Some(flags), "{cause:?}");
            // The flags cannot be written, and the oscillator beside them can.
            rcc.write(0x24, 0xf800_0001);
            assert_eq!(rcc.read(0x24), Some(flags | 3), "{cause:?}");
            rcc.write(0x24, 1 << 24 | 1);
            assert_eq!(rcc.read(0x24), Some(3), "{cause:?}");
        }
    }
}
