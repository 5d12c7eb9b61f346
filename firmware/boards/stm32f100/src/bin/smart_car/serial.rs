//! Telemetry: a queue of bytes that the interrupt of USART1 sends.

use certainty_firmware::mailbox::Mailbox;
use certainty_firmware::telemetry::Outbox;
use core::cell::Cell;
use cortex_m::peripheral::NVIC;
use critical_section::Mutex;
#[cfg(feature = "defmt-rtt")]
use defmt_rtt as _;
use stm32f1xx_hal::pac::{Interrupt, USART1, interrupt};

// The time stamp of the logs on RTT.
#[cfg(feature = "defmt-rtt")]
defmt::timestamp!("{=u32:ms}", crate::clock::ticks());

/// Room for the bytes of a round's reports that are not sent while the round is reported.
const ROOM: usize = 639;

/// The bytes to send.
static BYTES: Mailbox<u8, ROOM> = Mailbox::new();

/// Holds the port until the first interrupt takes it.
static HANDOVER: Mutex<Cell<Option<USART1>>> = Mutex::new(Cell::new(None));

/// Configures USART1 for 115,200 baud, 8 bits, no parity, one stop bit.
///
/// Its clock must be enabled.
pub(crate) fn start(usart: USART1, nvic: &mut NVIC) -> SerialOutbox {
    // 8 MHz / 115,200 = 69.4, and 69 = 16 · 4 + 5: 0.6 % fast; a receiver tolerates about 2 %.
    usart
        .brr()
        .write(|w| w.div_mantissa().set(4).div_fraction().set(5));
    usart.cr1().write(|w| w.ue().enabled().te().enabled());
    critical_section::with(|section| HANDOVER.borrow(section).set(Some(usart)));
    nvic_unmask(nvic);
    SerialOutbox(())
}

fn nvic_unmask(_: &mut NVIC) {
    // SAFETY: the interrupt shares only a `Mailbox` and a `Mutex` with the main loop, and no critical section
    // here relies on the mask of this interrupt.
    unsafe { NVIC::unmask(Interrupt::USART1) }
}

/// The main loop's end of the queue.
pub(crate) struct SerialOutbox(());

impl Outbox for SerialOutbox {
    fn send(&mut self, frame: &[u8]) -> bool {
        if BYTES.room() < frame.len() {
            return false;
        }
        for &byte in frame {
            // Cannot fail: there is room, and only this end adds bytes.
            let _ = BYTES.put(byte);
        }
        NVIC::pend(Interrupt::USART1);
        true
    }
}

/// Runs when bytes were put into the queue, and then whenever the port has room for a byte.
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
