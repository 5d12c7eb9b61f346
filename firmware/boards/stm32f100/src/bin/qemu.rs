//! The Smart Car under QEMU: its pins, pulses and time are at the far end of USART1.
//!
//! The far end simulates time, the world and the sensors (`certainty run --on qemu`). Everything above the
//! pins, drivers and executive included, is the same code as in the image to flash.
#![no_std]
#![no_main]

use certainty_firmware::board::Watchdog;
use certainty_firmware::executive::{Dispatcher, DueQueue, Executive};
use certainty_firmware::remote::{
    Link, RemoteClock, RemoteWatchdog, Request, RequestRefused, wire,
};
use certainty_firmware::smart_car::{SCHEDULE, SmartCar, remote_wiring};
use core::cell::Cell;
use cortex_m as _; // the critical section
#[cfg(feature = "defmt-rtt")]
use defmt_rtt as _;
use stm32f1xx_hal::pac::{Peripherals, RCC, USART1};

/// USART1 of the emulated chip, connected to the far end.
struct Usart {
    port: USART1,
    /// The time of the last answer; `None` once time has passed since.
    micros: Cell<Option<u32>>,
}

impl Usart {
    /// QEMU transfers bytes at once, so the baud rate does not matter.
    fn new(usart: USART1, rcc: &RCC) -> Self {
        rcc.apb2enr().modify(|_, w| w.usart1en().enabled());
        usart
            .cr1()
            .write(|w| w.ue().enabled().te().enabled().re().enabled());
        Self {
            port: usart,
            micros: Cell::new(None),
        }
    }

    /// Sends bytes; QEMU always has room.
    fn write(&self, bytes: &[u8]) {
        for &byte in bytes {
            while self.port.sr().read().txe().bit_is_clear() {}
            self.port.dr().write(|w| w.dr().set(byte.into()));
        }
    }

    /// Waits for a byte from the far end, which ends the emulator when it is done.
    fn read(&self) -> u8 {
        while self.port.sr().read().rxne().bit_is_clear() {}
        self.port.dr().read().dr().bits().to_le_bytes()[0]
    }
}

impl Link for Usart {
    fn request(&self, request: Request) -> Result<u32, RequestRefused> {
        self.write(&wire::encode(request));
        let mut answer = [0; wire::ANSWER];
        for byte in &mut answer {
            *byte = self.read();
        }
        let (answer, micros) = wire::decode_answer(answer);
        self.micros.set(Some(micros));
        answer
    }

    fn pass(&self, nanoseconds: u32) {
        self.micros.set(None);
        self.write(&wire::encode(Request::Pass(nanoseconds)));
    }

    fn micros(&self) -> u32 {
        if self.micros.get().is_none() {
            // On error the time stays unknown, and 0 is returned.
            let _ = self.request(Request::Micros);
        }
        self.micros.get().unwrap_or_default()
    }

    fn report(&self, frame: &[u8]) {
        if let Ok(length) = u8::try_from(frame.len()) {
            self.write(&[wire::REPORT, length]);
            self.write(frame);
        }
    }
}

/// Reports the unused stack before it feeds the watchdog, at the end of a round.
struct StackWatch<'a> {
    link: &'a Usart,
    watchdog: RemoteWatchdog<'a, Usart>,
}

impl Watchdog for StackWatch<'_> {
    fn feed(&mut self) {
        // The number is for information; an error changes nothing.
        let _ = self.link.request(Request::Unused(stack::unused()));
        self.watchdog.feed();
    }
}

#[cortex_m_rt::entry]
fn main() -> ! {
    if let Some(chip) = Peripherals::take() {
        let link = Usart::new(chip.USART1, &chip.RCC);
        // By reference: by value the stack would hold the car twice.
        if let Ok(car) = &mut SmartCar::try_new(remote_wiring(&link)) {
            let queue = DueQueue::new();
            let clock = RemoteClock::new(&link, Dispatcher::new(&SCHEDULE), &queue);
            let watchdog = StackWatch {
                link: &link,
                watchdog: RemoteWatchdog::new(&link),
            };
            let mut executive = Executive::new(&SCHEDULE, clock, watchdog);
            loop {
                executive.step(&queue, car);
            }
        }
    }
    stop()
}

/// Stops; the far end detects that no more requests come.
fn stop() -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    stop()
}

/// Measures the deepest stack by the remaining paint (feature `paint-stack` of the runtime).
mod stack {
    use cortex_m_rt::STACK_PAINT_VALUE;

    unsafe extern "C" {
        static _stack_end: u32;
        static _stack_start: u32;
    }

    /// Returns how many bytes next to the variables still have the runtime's paint.
    pub(crate) fn unused() -> u32 {
        let end = &raw const _stack_end;
        let room = (&raw const _stack_start as usize).wrapping_sub(end as usize) / 4;
        let painted = (0..room).take_while(|&word| {
            // SAFETY: the words between the runtime's two symbols are RAM, aligned, and painted before
            // `main`; they are only read, past the compiler's knowledge of the stack.
            let value = unsafe { end.wrapping_add(word).read_volatile() };
            value == STACK_PAINT_VALUE
        });
        painted.fold(0, |bytes, _| u32::wrapping_add(bytes, 4))
    }
}
