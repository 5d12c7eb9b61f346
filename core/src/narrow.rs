//! Conversions to narrower integers for `const fn`, where `TryFrom` cannot be called.
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the doc comment of each function states what becomes of the bits that do not fit"
)]

/// Returns the low bits.
pub(crate) const fn wrapping_u8(value: u32) -> u8 {
    value as u8
}

/// Returns the low bits.
pub(crate) const fn wrapping_u16(value: u32) -> u16 {
    value as u16
}

/// Returns the low bits.
pub(crate) const fn wrapping_u32(value: i64) -> u32 {
    value as u32
}

/// Returns the low bits.
pub(crate) const fn low_u32(value: u64) -> u32 {
    value as u32
}

/// Returns the nearest `i8`.
pub(crate) const fn saturating_i8(value: i64) -> i8 {
    if value > i8::MAX as i64 {
        i8::MAX
    } else if value < i8::MIN as i64 {
        i8::MIN
    } else {
        value as i8
    }
}

/// Returns the nearest `i32`.
pub(crate) const fn saturating_i32(value: i64) -> i32 {
    if value > i32::MAX as i64 {
        i32::MAX
    } else if value < i32::MIN as i64 {
        i32::MIN
    } else {
        value as i32
    }
}
