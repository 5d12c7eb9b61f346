//! Reports: a queue of bytes that USART1's interrupt sends, one after the other.

use certainty_firmware::mailbox::Mailbox;
use certainty_firmware::telemetry::Outbox;
use core::cell::Cell;
use cortex_m::peripheral::NVIC;
use critical_section::Mutex;
use stm32f1xx_hal::pac::{Interrupt, USART1, interrupt};

/// Room for the bytes of a round's reports that are not sent while they are made.
const ROOM: usize = 640;

/// The bytes that wait.
static BYTES: Mailbox<u8, ROOM> = Mailbox::new();

/// The port lies here until the interrupt comes for it.
static HANDOVER: Mutex<Cell<Option<USART1>>> = Mutex::new(Cell::new(None));

/// Sets USART1 up for 115,200 baud, 8 bits, no parity, one stop bit.
///
/// Its clock must run already.
pub(crate) fn start(usart: USART1, nvic: &mut NVIC) -> SerialOutbox {
    // 8 MHz / 115,200 = 69.4, and 69 = 16 · 4 + 5: 0.6 % fast, of the 2 % or so that a receiver takes.
    usart
        .brr()
        .write(|w| w.div_mantissa().set(4).div_fraction().set(5));
    usart.cr1().write(|w| w.ue().enabled().te().enabled());
    critical_section::with(|section| HANDOVER.borrow(section).set(Some(usart)));
    nvic_unmask(nvic);
    SerialOutbox(())
}

fn nvic_unmask(_: &mut NVIC) {
    // SAFETY: the interrupt shares nothing with the main loop but what is made for sharing, a queue and
    // a handover, and no critical section here relies on interrupt masks of its own.
    unsafe { NVIC::unmask(Interrupt::USART1) }
}

/// The queue's other end.
pub(crate) struct SerialOutbox(());

impl Outbox for SerialOutbox {
    fn send(&mut self, frame: &[u8]) -> bool {
        if BYTES.room() < frame.len() {
            return false;
        }
        for &byte in frame {
            // There is room: only this end takes it up.
            let _full = BYTES.put(byte);
        }
        NVIC::pend(Interrupt::USART1);
        true
    }
}

/// Comes when bytes were put into the queue, and then whenever the port has room for one.
#[interrupt]
fn USART1() {
    static mut PORT: Option<USART1> = None;

    if PORT.is_none() {
        *PORT = critical_section::with(|section| HANDOVER.borrow(section).take());
    }
    let Some(usart) = PORT else {
        return;
    };
    if usart.sr().read().txe().bit_is_clear() {
        return;
    }
    let next = BYTES.take();
    if let Some(byte) = next {
        usart.dr().write(|w| w.dr().set(byte.into()));
    }
    usart.cr1().modify(|_, w| w.txeie().bit(next.is_some()));
}
