//! USART1: the transmitter; the receiver is not modelled.

const TXE: u32 = 1 << 7;
const TC: u32 = 1 << 6;
const UE: u32 = 1 << 13;
const TE: u32 = 1 << 3;
const WORD_9: u32 = 1 << 12;
const TXE_INTERRUPT: u32 = 1 << 7;
const TC_INTERRUPT: u32 = 1 << 6;

/// The byte that is being sent.
#[derive(Debug, Clone, Copy)]
struct Shifting {
    byte: u8,
    until: u64,
}

/// The serial port.
#[derive(Debug, Default)]
pub(crate) struct Usart {
    /// CR1, CR2, CR3.
    control: [u32; 3],
    divisor: u32,
    waiting: Option<u8>,
    shifting: Option<Shifting>,
    sent: Vec<u8>,
}

impl Usart {
    pub(crate) fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            0x00 => self.status(),
            0x04 => 0, // nothing was ever received
            0x08 => self.divisor,
            0x0c | 0x10 | 0x14 => self.control[control(offset)],
            _ => return None,
        })
    }

    /// Returns whether there is such a register.
    pub(crate) fn write(&mut self, offset: u32, value: u32, now: u64) -> bool {
        self.advance(now);
        match offset {
            // TXE and TC follow the transmitter; the other flags are the receiver's.
            0x00 => {}
            0x04 => self.send(value as u8, now),
            0x08 => self.divisor = value & 0xffff,
            0x0c | 0x10 | 0x14 => self.control[control(offset)] = value,
            _ => return false,
        }
        true
    }

    const fn status(&self) -> u32 {
        let empty = if self.waiting.is_none() { TXE } else { 0 };
        let complete = if self.shifting.is_none() { TC } else { 0 };
        empty | complete
    }

    /// A byte that is written while another waits replaces it: the other is lost, as in the real chip.
    fn send(&mut self, byte: u8, now: u64) {
        if self.control[0] & (UE | TE) != UE | TE {
            return;
        }
        if self.shifting.is_some() {
            self.waiting = Some(byte);
        } else {
            self.shift(byte, now);
        }
    }

    fn shift(&mut self, byte: u8, from: u64) {
        let until = from + self.frame_cycles();
        self.shifting = Some(Shifting { byte, until });
    }

    /// Start bit, eight or nine bits, stop bits; BRR is the cycles of a bit (16 times oversampled).
    fn frame_cycles(&self) -> u64 {
        let word = if self.control[0] & WORD_9 == 0 { 8 } else { 9 };
        let stop = if self.control[1] >> 12 & 0b11 == 0b10 {
            2
        } else {
            1
        };
        u64::from(self.divisor) * (1 + word + stop)
    }

    /// When the byte that is being sent is complete.
    pub(crate) fn next_event(&self) -> Option<u64> {
        self.shifting.map(|shifting| shifting.until)
    }

    /// Advances the transmitter to `now`.
    pub(crate) fn advance(&mut self, now: u64) {
        while let Some(Shifting { byte, until }) = self.shifting.filter(|one| one.until <= now) {
            self.sent.push(byte);
            self.shifting = None;
            if let Some(next) = self.waiting.take() {
                self.shift(next, until);
            }
        }
    }

    /// Whether it requests its interrupt.
    pub(crate) const fn interrupts(&self) -> bool {
        let enabled = self.control[0];
        let status = self.status();
        (enabled & TXE_INTERRUPT != 0 && status & TXE != 0)
            || (enabled & TC_INTERRUPT != 0 && status & TC != 0)
    }

    /// Takes the bytes that were sent since the last call.
    pub(crate) fn take_sent(&mut self) -> Vec<u8> {
        core::mem::take(&mut self.sent)
    }
}

/// The index of the control register at `offset`.
const fn control(offset: u32) -> usize {
    ((offset - 0x0c) / 4) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 115,200 baud out of 8 MHz.
    fn port(control: u32) -> Usart {
        let mut port = Usart::default();
        port.write(0x08, 69, 0);
        port.write(0x0c, UE | TE | control, 0);
        port
    }

    #[test]
    fn a_byte_takes_ten_bits_of_time() {
        let mut port = port(0);
        assert_eq!(port.read(0x00), Some(TXE | TC));
        port.write(0x04, b'a'.into(), 1_000);
        assert_eq!(port.read(0x00), Some(TXE));
        assert_eq!(port.next_event(), Some(1_690));
        port.advance(1_689);
        assert_eq!(port.take_sent(), b"");
        port.advance(1_690);
        assert_eq!(
            (port.take_sent(), port.read(0x00)),
            (b"a".to_vec(), Some(TXE | TC))
        );
    }

    #[test]
    fn a_third_byte_replaces_the_second() {
        let mut port = port(0);
        port.write(0x04, b'a'.into(), 0);
        port.write(0x04, b'b'.into(), 1);
        assert_eq!(port.read(0x00), Some(0));
        port.write(0x04, b'c'.into(), 2);
        port.advance(10_000);
        assert_eq!(port.take_sent(), b"ac");
        // Back to back: the second began when the first was out.
        port.write(0x04, b'd'.into(), 20_000);
        port.write(0x04, b'e'.into(), 20_001);
        port.advance(20_690);
        assert_eq!(port.next_event(), Some(20_000 + 2 * 690));
    }

    #[test]
    fn its_interrupt_follows_its_flags() {
        assert!(!port(0).interrupts());
        let mut port = port(TXE_INTERRUPT);
        assert!(port.interrupts());
        port.write(0x04, 1, 0);
        assert!(port.interrupts());
        port.write(0x04, 2, 1);
        assert!(!port.interrupts());
        port.advance(690);
        assert!(port.interrupts());
        port.write(0x0c, UE | TE | TC_INTERRUPT, 691);
        assert!(!port.interrupts());
        port.advance(1_380);
        assert!(port.interrupts());
    }

    #[test]
    fn nothing_is_sent_before_it_is_enabled() {
        let mut port = Usart::default();
        port.write(0x04, 1, 0);
        port.write(0x0c, TE, 0);
        port.write(0x04, 1, 0);
        assert_eq!(port.next_event(), None);
    }

    #[test]
    fn nine_bits_and_two_stop_bits_take_longer() {
        let mut port = port(WORD_9);
        port.write(0x10, 0b10 << 12, 0);
        port.write(0x04, 1, 0);
        assert_eq!(port.next_event(), Some(12 * 69));
    }
}
