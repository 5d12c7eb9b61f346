//! RCC: the clocks. The internal 8 MHz oscillator only; others never get ready.

/// The peripherals whose clocks and resets are looked at.
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
/// HSEON and PLLON may be set, and are waited for in vain.
const CR_WRITABLE: u32 = 0x010d_00f9;
const LSI_ON: u32 = 1;

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
            csr: 0x0c00_0000, // power-on and pin reset
        }
    }
}

impl Rcc {
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
            0x24 => self.csr = self.csr & !LSI_ON | value & LSI_ON,
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
    fn a_bit_enables_or_resets_its_peripheral_and_no_other() {
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
}
