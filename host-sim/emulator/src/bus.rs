//! The processor's view of the peripherals.

use crate::peripherals::{PERIPHERALS_AT, Peripherals};
use crate::pins::{Connection, Pin, Pins};
use core::fmt;
use core::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use rsemu::core::error::BusError;
use rsemu::core::space::{AccessConstraints, MemAttrs, MemOps, MemResult};
use rsemu::core::value::{Endian, Width};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The peripherals behind a lock, with copies of what the main loop reads before every instruction.
pub(crate) struct Bus<P> {
    peripherals: Mutex<Peripherals<P>>,
    now: AtomicU64,
    next_event: AtomicU64,
    serial_interrupts: AtomicBool,
}

impl<P: Pins> Bus<P> {
    pub(crate) fn new(wiring: &[(Pin, Connection)], pins: P) -> Self {
        Self {
            peripherals: Mutex::new(Peripherals::new(wiring, pins)),
            now: AtomicU64::new(0),
            next_event: AtomicU64::new(u64::MAX),
            serial_interrupts: AtomicBool::new(false),
        }
    }

    pub(crate) fn peripherals(&self) -> MutexGuard<'_, Peripherals<P>> {
        // A panic in a device leaves the registers complete, so a poisoned lock is still usable.
        self.peripherals
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets the cycle of the next instruction.
    pub(crate) fn set_now(&self, now: u64) {
        self.now.store(now, Ordering::Relaxed);
    }

    /// The next cycle in which a peripheral changes without an access.
    pub(crate) fn next_event(&self) -> u64 {
        self.next_event.load(Ordering::Relaxed)
    }

    /// Whether USART1 requests its interrupt.
    pub(crate) fn serial_interrupts(&self) -> bool {
        self.serial_interrupts.load(Ordering::Relaxed)
    }

    /// Runs `act` on the peripherals, then updates the copies that the main loop reads.
    pub(crate) fn with<T>(&self, act: impl FnOnce(&mut Peripherals<P>, u64) -> T) -> T {
        let mut peripherals = self.peripherals();
        let result = act(&mut peripherals, self.now.load(Ordering::Relaxed));
        self.next_event
            .store(peripherals.next_event(), Ordering::Relaxed);
        let interrupts = peripherals.serial_interrupts();
        self.serial_interrupts.store(interrupts, Ordering::Relaxed);
        result
    }
}

impl<P> fmt::Debug for Bus<P> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("Bus").finish_non_exhaustive()
    }
}

impl<P: Pins + Send> MemOps for Bus<P> {
    fn read(&self, offset: u64, bytes: &mut [u8], _: MemAttrs) -> MemResult {
        let address = PERIPHERALS_AT + offset as u32;
        let mut peripherals = self.peripherals();
        let value = peripherals
            .read(address, self.now.load(Ordering::Relaxed))
            .to_le_bytes();
        let part = value.get(..bytes.len()).ok_or(BusError::BadAccess)?;
        bytes.copy_from_slice(part);
        Ok(())
    }

    fn write(&self, offset: u64, bytes: &[u8], _: MemAttrs) -> MemResult {
        let address = PERIPHERALS_AT + offset as u32;
        let mut value = [0; 4];
        value
            .get_mut(..bytes.len())
            .ok_or(BusError::BadAccess)?
            .copy_from_slice(bytes);
        let value = u32::from_le_bytes(value);
        self.with(|peripherals, now| peripherals.write(address, value, now));
        Ok(())
    }

    /// Registers are accessed whole: as words, or as half-words where they are 16 bits wide.
    fn constraints(&self) -> AccessConstraints {
        AccessConstraints::word(Width::U32, Endian::Little).with_widths(Width::U16, Width::U32)
    }
}
