//! A queue that an interrupt and the main loop share.

use core::cell::RefCell;
use core::fmt;
use critical_section::Mutex;
use heapless::Deque;

/// A first-in, first-out queue of `N` items behind a critical section.
///
/// Both ends take a shared reference, so it can be a `static`. It needs no atomic operations, so it works on
/// cores without them, such as RV32IMC.
///
/// Cost: interrupts are disabled while one item is moved, about 30 cycles on a Cortex-M3.
///
/// ```
/// use certainty_firmware::mailbox::Mailbox;
///
/// static BYTES: Mailbox<u8, 3> = Mailbox::new();
///
/// assert_eq!(BYTES.room(), 3);
/// assert_eq!(BYTES.put(b'a'), Ok(()));
/// assert_eq!(BYTES.take(), Some(b'a'));
/// assert_eq!(BYTES.take(), None);
/// ```
pub struct Mailbox<T, const N: usize>(Mutex<RefCell<Deque<T, N>>>);

impl<T, const N: usize> Mailbox<T, N> {
    /// Creates an empty queue.
    #[must_use]
    pub const fn new() -> Self {
        Self(Mutex::new(RefCell::new(Deque::new())))
    }

    /// Appends an item.
    ///
    /// # Errors
    ///
    /// Returns the item if the queue is full.
    pub fn put(&self, item: T) -> Result<(), T> {
        critical_section::with(|section| match self.0.borrow(section).try_borrow_mut() {
            Ok(mut queue) => queue.push_back(item),
            // Unreachable: no borrow outlives these functions.
            Err(_) => Err(item),
        })
    }

    /// Removes and returns the oldest item.
    pub fn take(&self) -> Option<T> {
        critical_section::with(|section| {
            let queue = self.0.borrow(section).try_borrow_mut();
            queue.ok().and_then(|mut queue| queue.pop_front())
        })
    }

    /// Returns how many more items fit.
    #[must_use]
    pub fn room(&self) -> usize {
        critical_section::with(|section| {
            let queue = self.0.borrow(section).try_borrow();
            queue.map_or(0, |queue| N.wrapping_sub(queue.len()))
        })
    }
}

impl<T, const N: usize> Default for Mailbox<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T, const N: usize> fmt::Debug for Mailbox<T, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Mailbox").finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_come_out_in_order_and_a_full_queue_refuses() {
        let queue: Mailbox<u8, 3> = Mailbox::new();
        for round in 0..10 {
            for item in 0..3 {
                assert_eq!(queue.room(), 3 - usize::from(item));
                assert_eq!(queue.put(round + item), Ok(()));
            }
            assert_eq!(queue.put(99), Err(99));
            assert_eq!(queue.room(), 0);
            let taken = [queue.take(), queue.take(), queue.take()];
            assert_eq!(taken, [Some(round), Some(round + 1), Some(round + 2)]);
            assert_eq!(queue.take(), None);
        }
    }
}
