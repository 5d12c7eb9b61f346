//! AFIO: which pins the peripherals use.

/// The remap register; the pins' interrupt lines are not modelled.
#[derive(Debug, Default)]
pub(crate) struct Afio {
    mapr: u32,
}

const USART1_REMAP: u32 = 1 << 2;
const TIM3_REMAP: u32 = 0b11 << 10;
const TIM4_REMAP: u32 = 1 << 12;
/// Which pins the debugger uses; reads as 0.
const DEBUG_PINS: u32 = 0b111 << 24;

impl Afio {
    pub(crate) const fn read(&self, offset: u32) -> Option<u32> {
        match offset {
            0x04 => Some(self.mapr),
            _ => None,
        }
    }

    /// Returns whether there is such a register.
    pub(crate) const fn write(&mut self, offset: u32, value: u32) -> bool {
        if offset == 0x04 {
            self.mapr = value & !DEBUG_PINS;
        }
        offset == 0x04
    }

    /// Whether USART1 is on PA9 and PA10.
    pub(crate) const fn usart1_in_place(&self) -> bool {
        self.mapr & USART1_REMAP == 0
    }

    /// Whether TIM3 is on PA6, PA7, PB0 and PB1.
    pub(crate) const fn tim3_in_place(&self) -> bool {
        self.mapr & TIM3_REMAP == 0
    }

    /// Whether TIM4 is on PB6 to PB9.
    pub(crate) const fn tim4_in_place(&self) -> bool {
        self.mapr & TIM4_REMAP == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_remapped_peripheral_leaves_its_pins() {
        let mut afio = Afio::default();
        assert!(afio.usart1_in_place() && afio.tim3_in_place());
        afio.write(0x04, 0b10 << 10 | 0b010 << 24);
        assert!(afio.usart1_in_place() && !afio.tim3_in_place());
        assert_eq!(afio.read(0x04), Some(0b10 << 10));
        afio.write(0x04, 1 << 2);
        assert!(!afio.usart1_in_place() && afio.tim3_in_place() && afio.tim4_in_place());
        afio.write(0x04, 1 << 12);
        assert!(afio.usart1_in_place() && afio.tim3_in_place() && !afio.tim4_in_place());
        assert_eq!(afio.read(0x08), None);
    }
}
