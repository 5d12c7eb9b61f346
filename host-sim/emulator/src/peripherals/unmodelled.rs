//! Registers without a model: they store what is written, and accesses are counted.

use std::collections::BTreeMap;

/// A register that the firmware used without a model behind it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnmodelledRegister {
    /// The peripheral and the register's offset, such as `TIM4+0x2c`.
    pub name: String,
    /// Its address.
    pub address: u32,
    /// How often it was read.
    pub reads: u64,
    /// How often it was written.
    pub writes: u64,
}

#[derive(Debug, Default)]
struct Cell {
    value: u32,
    reads: u64,
    writes: u64,
}

/// Registers that store what is written and do nothing.
#[derive(Debug, Default)]
pub(crate) struct Unmodelled(BTreeMap<u32, Cell>);

impl Unmodelled {
    pub(crate) fn read(&mut self, address: u32) -> u32 {
        let cell = self.0.entry(address).or_default();
        cell.reads += 1;
        cell.value
    }

    pub(crate) fn write(&mut self, address: u32, value: u32) {
        let cell = self.0.entry(address).or_default();
        cell.writes += 1;
        cell.value = value;
    }

    pub(crate) fn listing(&self) -> Vec<UnmodelledRegister> {
        let listed = self.0.iter().map(|(&address, cell)| UnmodelledRegister {
            name: name(address),
            address,
            reads: cell.reads,
            writes: cell.writes,
        });
        listed.collect()
    }
}

/// The peripherals' addresses, each 1 KiB (STM32F100 reference manual RM0041, memory map).
const BLOCKS: [(u32, &str); 35] = [
    (0x4000_0000, "TIM2"),
    (0x4000_0400, "TIM3"),
    (0x4000_0800, "TIM4"),
    (0x4000_1000, "TIM6"),
    (0x4000_1400, "TIM7"),
    (0x4000_2800, "RTC"),
    (0x4000_2c00, "WWDG"),
    (0x4000_3000, "IWDG"),
    (0x4000_3800, "SPI2"),
    (0x4000_4400, "USART2"),
    (0x4000_4800, "USART3"),
    (0x4000_5400, "I2C1"),
    (0x4000_5800, "I2C2"),
    (0x4000_6c00, "BKP"),
    (0x4000_7000, "PWR"),
    (0x4000_7400, "DAC"),
    (0x4000_7800, "CEC"),
    (0x4001_0000, "AFIO"),
    (0x4001_0400, "EXTI"),
    (0x4001_0800, "GPIOA"),
    (0x4001_0c00, "GPIOB"),
    (0x4001_1000, "GPIOC"),
    (0x4001_1400, "GPIOD"),
    (0x4001_1800, "GPIOE"),
    (0x4001_2400, "ADC1"),
    (0x4001_2c00, "TIM1"),
    (0x4001_3000, "SPI1"),
    (0x4001_3800, "USART1"),
    (0x4001_4000, "TIM15"),
    (0x4001_4400, "TIM16"),
    (0x4001_4800, "TIM17"),
    (0x4002_0000, "DMA1"),
    (0x4002_1000, "RCC"),
    (0x4002_2000, "FLASH"),
    (0x4002_3000, "CRC"),
];

fn name(address: u32) -> String {
    let block = BLOCKS.iter().find(|(base, _)| *base == address & !0x3ff);
    let name = block.map_or("reserved", |(_, name)| name);
    format!("{name}+{:#04x}", address & 0x3ff)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_register_without_a_model_is_listed() {
        let mut registers = Unmodelled::default();
        assert_eq!(registers.read(0x4000_082c), 0);
        registers.write(0x4000_082c, 999);
        assert_eq!(registers.read(0x4000_082c), 999);
        registers.write(0x4000_0c00, 1);
        let listed = registers.listing();
        assert_eq!(listed[0].name, "TIM4+0x2c");
        assert_eq!((listed[0].reads, listed[0].writes), (2, 1));
        assert_eq!(listed[1].name, "reserved+0x00");
    }
}
