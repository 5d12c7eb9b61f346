//! GPIO: a port's sixteen pins.

/// What the microcontroller does to a pin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Drive {
    /// Nothing: an input, or an open drain that is off.
    Released,
    /// Pulled to the supply or to ground, by some 40 kΩ.
    Pulled(bool),
    /// Driven to ground.
    Low,
    /// Driven to the supply.
    High,
    /// Driven by a peripheral.
    Alternate,
}

/// A port's registers.
#[derive(Debug)]
pub(crate) struct Gpio {
    /// CRL and CRH: four bits a pin.
    configuration: u64,
    output: u16,
}

impl Default for Gpio {
    fn default() -> Self {
        Self {
            configuration: 0x4444_4444_4444_4444, // every pin a floating input
            output: 0,
        }
    }
}

impl Gpio {
    /// Reads a register; `pins` gives the levels of the pins.
    pub(crate) fn read(&self, offset: u32, pins: impl FnOnce() -> u16) -> Option<u32> {
        Some(match offset {
            0x00 => self.configuration as u32,
            0x04 => (self.configuration >> 32) as u32,
            0x08 => pins().into(),
            0x0c => self.output.into(),
            0x10 | 0x14 => 0, // BSRR and BRR are write-only
            _ => return None,
        })
    }

    /// Returns whether there is such a register.
    pub(crate) fn write(&mut self, offset: u32, value: u32) -> bool {
        let low = value as u16;
        let high = (value >> 16) as u16;
        match offset {
            0x00 => {
                self.configuration = self.configuration >> 32 << 32 | u64::from(value);
            }
            0x04 => {
                self.configuration = self.configuration & 0xffff_ffff | u64::from(value) << 32;
            }
            0x08 => {}
            0x0c => self.output = low,
            // Set wins over reset.
            0x10 => self.output = self.output & !high | low,
            0x14 => self.output &= !low,
            _ => return false,
        }
        true
    }

    /// What the microcontroller does to pin `pin`, 0 to 15.
    pub(crate) const fn drive(&self, pin: u8) -> Drive {
        let set = self.output >> pin & 1 == 1;
        let bits = self.configuration >> (pin * 4) & 0xf;
        let (mode, configuration) = (bits & 3, bits >> 2);
        match (mode, configuration, set) {
            (0, 2, _) => Drive::Pulled(set),
            (0, _, _) | (_, 1, true) => Drive::Released,
            (_, 0, true) => Drive::High,
            (_, 0 | 1, false) => Drive::Low,
            (_, _, _) => Drive::Alternate,
        }
    }

    /// Whether pin `pin` is digital: an analog input reads 0 whatever its level.
    pub(crate) const fn digital(&self, pin: u8) -> bool {
        self.configuration >> (pin * 4) & 0xf != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn port(pin_5: u32, output: u32) -> Gpio {
        let mut port = Gpio::default();
        port.write(0x00, 0x4444_4444 & !(0xf << 20) | pin_5 << 20);
        port.write(0x0c, output);
        port
    }

    #[test]
    fn four_bits_configure_a_pin() {
        let (set, reset) = (1 << 5, 0);
        // RM0041 table "Port bit configuration": CNF above MODE.
        let cases = [
            (0b0100, set, Drive::Released),
            (0b0000, set, Drive::Released),
            (0b1000, set, Drive::Pulled(true)),
            (0b1000, reset, Drive::Pulled(false)),
            (0b0011, set, Drive::High),
            (0b0001, reset, Drive::Low),
            (0b0111, set, Drive::Released),
            (0b0110, reset, Drive::Low),
            (0b1010, set, Drive::Alternate),
            (0b1110, reset, Drive::Alternate),
        ];
        for (bits, output, drive) in cases {
            assert_eq!(port(bits, output).drive(5), drive, "{bits:04b}");
        }
        assert_eq!(Gpio::default().drive(15), Drive::Released);
        assert!(port(0b0100, 0).digital(5) && !port(0b0000, 0).digital(5));
    }

    #[test]
    fn bits_are_set_and_reset_one_by_one() {
        let mut port = Gpio::default();
        port.write(0x0c, 0x00f0);
        port.write(0x10, 0x0010_0001); // reset bit 4, set bit 0
        assert_eq!(port.read(0x0c, || 0), Some(0x00e1));
        port.write(0x10, 0x0002_0002); // both: set
        port.write(0x14, 0x0080);
        assert_eq!(port.read(0x0c, || 0), Some(0x0063));
        port.write(0x08, 0xffff);
        assert_eq!(port.read(0x08, || 0x1234), Some(0x1234));
    }

    #[test]
    fn the_upper_pins_have_their_own_register() {
        let mut port = Gpio::default();
        port.write(0x04, 0x3444_4444);
        port.write(0x0c, 0x8000);
        assert_eq!(
            (port.drive(15), port.drive(7)),
            (Drive::High, Drive::Released)
        );
        assert_eq!(port.read(0x00, || 0), Some(0x4444_4444));
        assert_eq!(port.read(0x04, || 0), Some(0x3444_4444));
    }
}
