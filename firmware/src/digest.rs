//! A digest of bytes, to compare what two machines hold.

/// FNV-1a, 32 bits; a byte costs an exclusive or and a multiplication.
///
/// Two different contents have the same digest with probability 2⁻³². It detects accidents, not attacks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Digest(u32);

impl Digest {
    /// The digest of no bytes.
    pub const NEW: Self = Self(0x811C_9DC5);

    /// Adds bytes.
    pub fn bytes<'a>(&mut self, bytes: impl IntoIterator<Item = &'a u8>) {
        for &byte in bytes {
            self.0 = (self.0 ^ u32::from(byte)).wrapping_mul(0x0100_0193);
        }
    }

    /// Adds a word, the lowest byte first.
    pub fn word(&mut self, word: u32) {
        self.bytes(&word.to_le_bytes());
    }

    /// Returns the digest.
    #[must_use]
    pub const fn value(self) -> u32 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The vectors of the algorithm's authors (Fowler, Noll, Vo).
    #[test]
    fn the_authors_test_vectors_hold() {
        for (text, expected) in [
            ("", 0x811C_9DC5),
            ("a", 0xE40C_292C),
            ("foobar", 0xBF9C_F968),
        ] {
            let mut digest = Digest::NEW;
            digest.bytes(text.as_bytes());
            assert_eq!(digest.value(), expected, "{text}");
        }
    }
}
