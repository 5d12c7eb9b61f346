//! FLASH: its access control register; programming is not modelled.

/// The access control register.
#[derive(Debug, Default)]
pub(crate) struct Flash {
    acr: u32,
}

impl Flash {
    pub(crate) const fn read(&self, offset: u32) -> Option<u32> {
        match offset {
            0x00 => Some(self.acr),
            _ => None,
        }
    }

    /// Returns whether there is such a register.
    pub(crate) const fn write(&mut self, offset: u32, value: u32) -> bool {
        if offset == 0x00 {
            self.acr = value & 0b1000; // half-cycle access, the only bit of an STM32F100
        }
        offset == 0x00
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_control_register_stores_one_bit() {
        let mut flash = Flash::default();
        assert!(flash.write(0x00, 0xff));
        assert_eq!(flash.read(0x00), Some(8));
        assert!(!flash.write(0x04, 0x4567_0123)); // the key that unlocks programming
        assert_eq!(flash.read(0x04), None);
    }
}
