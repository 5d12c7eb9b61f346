//! Conversions to narrower integers for `const fn`, where `TryFrom` cannot be called.
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "each function says what it does with the bits that do not fit"
)]

macro_rules! wrapping {
    ($($name:ident: $wide:ty => $narrow:ty;)*) => {$(
        #[doc = concat!("Returns the low bits as a `", stringify!($narrow), "`.")]
        #[must_use]
        pub const fn $name(value: $wide) -> $narrow {
            value as $narrow
        }
    )*};
}

macro_rules! saturating {
    ($($name:ident: $wide:ty => $narrow:ty;)*) => {$(
        #[doc = concat!("Returns the nearest `", stringify!($narrow), "`.")]
        #[must_use]
        pub const fn $name(value: $wide) -> $narrow {
            if value > <$narrow>::MAX as $wide {
                <$narrow>::MAX
            } else if value < <$narrow>::MIN as $wide {
                <$narrow>::MIN
            } else {
                value as $narrow
            }
        }
    )*};
}

wrapping! {
    wrapping_u8: u32 => u8;
    wrapping_u16: u32 => u16;
    wrapping_u32: i64 => u32;
    low_u32: u64 => u32;
}

saturating! {
    saturating_i8: i64 => i8;
    saturating_i16: i32 => i16;
    saturating_i32: i64 => i32;
}

/// Returns the nearest `u8`.
#[must_use]
pub const fn saturating_u8(value: u64) -> u8 {
    if value > u8::MAX as u64 {
        u8::MAX
    } else {
        value as u8
    }
}

/// Returns the nearest `u16`.
#[must_use]
pub const fn saturating_u16_of_u64(value: u64) -> u16 {
    if value > u16::MAX as u64 {
        u16::MAX
    } else {
        value as u16
    }
}
