//! Where an interrupt leaves things for the main loop, or the main loop for an interrupt.

use core::cell::RefCell;
use core::fmt;
use critical_section::Mutex;
use heapless::spsc::Queue;

/// A queue that an interrupt and the main loop share; room for `N − 1` items.
///
/// Prefer it to the two ends of a [`heapless::spsc::Queue`] in what must not panic: those know their
/// length at run time only, so that going round the queue divides by a number that might be zero. Here
/// `N` is known to the compiler, and where it is a power of two nothing is divided.
///
/// Cost: interrupts are held back while one item is moved, some 30 cycles on a Cortex-M3.
///
/// ```
/// use certainty_firmware::mailbox::Mailbox;
///
/// static LETTERS: Mailbox<u8, 4> = Mailbox::new();
///
/// assert_eq!(LETTERS.room(), 3);
/// assert_eq!(LETTERS.put(b'a'), Ok(()));
/// assert_eq!(LETTERS.take(), Some(b'a'));
/// assert_eq!(LETTERS.take(), None);
/// ```
pub struct Mailbox<T, const N: usize>(Mutex<RefCell<Queue<T, N>>>);

impl<T, const N: usize> Mailbox<T, N> {
    /// Creates an empty one.
    #[must_use]
    pub const fn new() -> Self {
        Self(Mutex::new(RefCell::new(Queue::new())))
    }

    /// Puts an item behind the others.
    ///
    /// # Errors
    ///
    /// Hands it back where there is no room.
    pub fn put(&self, item: T) -> Result<(), T> {
        critical_section::with(|section| match self.0.borrow(section).try_borrow_mut() {
            Ok(mut queue) => queue.enqueue(item),
            // Nobody keeps it borrowed beyond these functions.
            Err(_) => Err(item),
        })
    }

    /// Takes the item that waits longest.
    pub fn take(&self) -> Option<T> {
        critical_section::with(|section| {
            let queue = self.0.borrow(section).try_borrow_mut();
            queue.ok().and_then(|mut queue| queue.dequeue())
        })
    }

    /// Returns how many more items there is room for.
    #[must_use]
    pub fn room(&self) -> usize {
        critical_section::with(|section| {
            let queue = self.0.borrow(section).try_borrow();
            queue.map_or(0, |queue| queue.capacity().wrapping_sub(queue.len()))
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
    fn items_come_out_in_their_order_and_what_finds_no_room_is_handed_back() {
        let letters: Mailbox<u8, 4> = Mailbox::new();
        for round in 0..10 {
            for item in 0..3 {
                assert_eq!(letters.room(), 3 - usize::from(item));
                assert_eq!(letters.put(round + item), Ok(()));
            }
            assert_eq!(letters.put(99), Err(99));
            assert_eq!(letters.room(), 0);
            let taken = [letters.take(), letters.take(), letters.take()];
            assert_eq!(taken, [Some(round), Some(round + 1), Some(round + 2)]);
            assert_eq!(letters.take(), None);
        }
    }
}
