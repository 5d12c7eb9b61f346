//! Conversions to fewer bits, each named for what it does with the rest.
//!
//! `TryFrom` is not `const`, and `as` does not say what it means; these do, in one place.
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "dropping bits is what these functions are named for"
)]

/// The low 8 bits.
#[must_use]
pub const fn wrapping_u8(value: u32) -> u8 {
    value as u8
}

/// The low 16 bits.
#[must_use]
pub const fn wrapping_u16(value: u32) -> u16 {
    value as u16
}

/// The low 32 bits.
#[must_use]
pub const fn wrapping_u32(value: i64) -> u32 {
    value as u32
}

/// The low 32 bits.
#[must_use]
pub const fn low_u32(value: u64) -> u32 {
    value as u32
}

/// The nearest value of 32 bits.
#[must_use]
pub const fn saturating_i32(value: i64) -> i32 {
    if value > i32::MAX as i64 {
        i32::MAX
    } else if value < i32::MIN as i64 {
        i32::MIN
    } else {
        value as i32
    }
}

/// The nearest value of 16 bits.
#[must_use]
pub const fn saturating_i16(value: i32) -> i16 {
    if value > i16::MAX as i32 {
        i16::MAX
    } else if value < i16::MIN as i32 {
        i16::MIN
    } else {
        value as i16
    }
}

/// The nearest value of 16 bits.
#[must_use]
pub const fn saturating_u16_of_u64(value: u64) -> u16 {
    if value > u16::MAX as u64 {
        u16::MAX
    } else {
        value as u16
    }
}

/// The nearest value of 8 bits.
#[must_use]
pub const fn saturating_i8(value: i64) -> i8 {
    if value > i8::MAX as i64 {
        i8::MAX
    } else if value < i8::MIN as i64 {
        i8::MIN
    } else {
        value as i8
    }
}

/// The nearest value of 8 bits.
#[must_use]
pub const fn saturating_u8(value: u64) -> u8 {
    if value > u8::MAX as u64 {
        u8::MAX
    } else {
        value as u8
    }
}
