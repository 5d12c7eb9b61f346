//! A fingerprint of maps and records, to compare machines.

/// FNV-1a, 32 bits, over little-endian words.
///
/// It tells that two machines disagree; it protects against nothing else.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Digest(u32);

impl Digest {
    /// The digest of nothing.
    pub const NEW: Self = Self(0x811C_9DC5);

    /// Takes a byte.
    pub const fn take(&mut self, byte: u8) {
        self.0 = (self.0 ^ byte as u32).wrapping_mul(0x0100_0193);
    }

    /// Takes the four bytes of a word, the lowest first.
    pub fn take_word(&mut self, word: u32) {
        for byte in word.to_le_bytes() {
            self.take(byte);
        }
    }

    /// Returns the digest of everything taken.
    #[must_use]
    pub const fn value(self) -> u32 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The vectors that the function's authors publish.
    #[test]
    fn the_digest_is_fnv_1a() {
        for (text, hash) in [("", 0x811C_9DC5), ("a", 0xE40C_292C), ("foobar", 0xBF9C_F968)] {
            let mut digest = Digest::NEW;
            text.bytes().for_each(|byte| digest.take(byte));
            assert_eq!(digest.value(), hash, "{text}");
        }
    }
}
