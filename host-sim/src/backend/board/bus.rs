//! The processor's view of the peripherals.

use super::parts::{PERIPHERALS_AT, Parts};
use crate::bench::Wires;
use core::fmt;
use core::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use rsemu::core::error::BusError;
use rsemu::core::space::{AccessConstraints, MemAttrs, MemOps, MemResult};
use rsemu::core::value::{Endian, Width};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The peripherals behind a lock, and what the main loop asks before every instruction beside it.
pub(super) struct Bus<W> {
    parts: Mutex<Parts<W>>,
    now: AtomicU64,
    next_event: AtomicU64,
    serial_interrupts: AtomicBool,
}

impl<W: Wires> Bus<W> {
    pub(super) fn new(wires: W) -> Self {
        Self {
            parts: Mutex::new(Parts::new(wires)),
            now: AtomicU64::new(0),
            next_event: AtomicU64::new(u64::MAX),
            serial_interrupts: AtomicBool::new(false),
        }
    }

    pub(super) fn parts(&self) -> MutexGuard<'_, Parts<W>> {
        // Devices that panicked leave registers that are whole all the same.
        self.parts.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Says in which cycle the next instruction is.
    pub(super) fn set_now(&self, now: u64) {
        self.now.store(now, Ordering::Relaxed);
    }

    /// The next cycle in which a peripheral does something of itself.
    pub(super) fn next_event(&self) -> u64 {
        self.next_event.load(Ordering::Relaxed)
    }

    /// Whether USART1 asks for its interrupt.
    pub(super) fn serial_interrupts(&self) -> bool {
        self.serial_interrupts.load(Ordering::Relaxed)
    }

    /// Does something with the peripherals, and notes what the main loop must know afterwards.
    pub(super) fn with<T>(&self, act: impl FnOnce(&mut Parts<W>, u64) -> T) -> T {
        let mut parts = self.parts();
        let result = act(&mut parts, self.now.load(Ordering::Relaxed));
        self.next_event.store(parts.next_event(), Ordering::Relaxed);
        let interrupts = parts.serial_interrupts();
        self.serial_interrupts.store(interrupts, Ordering::Relaxed);
        result
    }
}

impl<W> fmt::Debug for Bus<W> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("Bus").finish_non_exhaustive()
    }
}

impl<W: Wires + Send> MemOps for Bus<W> {
    fn read(&self, offset: u64, bytes: &mut [u8], _: MemAttrs) -> MemResult {
        let address = PERIPHERALS_AT + offset as u32;
        let mut parts = self.parts();
        let value = parts
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
        self.with(|parts, now| parts.write(address, u32::from_le_bytes(value), now));
        Ok(())
    }

    /// Registers are written and read whole: as words, or as half-words where they are 16 bits wide.
    fn constraints(&self) -> AccessConstraints {
        AccessConstraints::word(Width::U32, Endian::Little).with_widths(Width::U16, Width::U32)
    }
}
