//! Converts an ELF file to the contents of the flash.

use crate::error::RunError;
use object::Endianness;
use object::elf;
use object::read::elf::{FileHeader, ProgramHeader};

/// Where the flash is.
pub(crate) const FLASH_AT: u32 = 0x0800_0000;

/// Its bytes, on an STM32F100RB.
pub(crate) const FLASH_BYTES: usize = 128 << 10;

/// Where the RAM is.
pub(crate) const RAM_AT: u32 = 0x2000_0000;

/// Its bytes.
pub(crate) const RAM_BYTES: usize = 8 << 10;

/// A byte of erased flash.
const ERASED: u8 = 0xff;

/// Returns the contents of the flash after the ELF file `bytes` was programmed.
///
/// # Errors
///
/// [`RunError::NotAnImage`], with what is wrong.
pub(crate) fn flash_image(bytes: &[u8]) -> Result<Vec<u8>, RunError> {
    let bad = |why: &str| RunError::NotAnImage(why.to_owned());
    let unreadable = |_error: object::Error| bad("its 32-bit ELF headers are damaged or missing");
    let header = elf::FileHeader32::<Endianness>::parse(bytes).map_err(unreadable)?;
    let endian = header.endian().map_err(unreadable)?;
    if endian != Endianness::Little || header.e_machine(endian) != elf::EM_ARM {
        return Err(bad("it is for another processor"));
    }
    let mut flash = vec![ERASED; FLASH_BYTES];
    for segment in header.program_headers(endian, bytes).map_err(unreadable)? {
        if segment.p_type(endian) != elf::PT_LOAD || segment.p_filesz(endian) == 0 {
            continue;
        }
        let data = segment
            .data(endian, bytes)
            .map_err(|()| bad("it is cut short"))?;
        let outside = || bad("a part of it does not lie in the flash");
        let offset = segment
            .p_paddr(endian)
            .checked_sub(FLASH_AT)
            .ok_or_else(outside)?;
        let end = (offset as usize).saturating_add(data.len());
        let place = flash.get_mut(offset as usize..end).ok_or_else(outside)?;
        place.copy_from_slice(data);
    }
    check_vectors(&flash)?;
    Ok(flash)
}

/// The stack pointer that the processor starts with.
pub(crate) fn initial_stack_pointer(flash: &[u8]) -> u32 {
    flash
        .first_chunk()
        .map_or(0, |word| u32::from_le_bytes(*word))
}

/// Checks the first two words, the stack pointer and the entry, which a Cortex-M starts with.
fn check_vectors(flash: &[u8]) -> Result<(), RunError> {
    let stack = initial_stack_pointer(flash);
    let entry = flash[4..]
        .first_chunk()
        .map_or(0, |word| u32::from_le_bytes(*word));
    let ram = RAM_AT..=RAM_AT + RAM_BYTES as u32;
    let code = FLASH_AT..FLASH_AT + FLASH_BYTES as u32;
    if ram.contains(&stack) && code.contains(&entry) && entry % 2 == 1 {
        Ok(())
    } else {
        Err(RunError::NotAnImage(format!(
            "its vector table has stack {stack:#010x}, entry {entry:#010x}"
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_elf::elf_of as image;
    use proptest::prelude::*;

    /// A vector table: the stack ends with the RAM, the program begins behind the table.
    const VECTORS: [u8; 8] = [0x00, 0x20, 0x00, 0x20, 0x09, 0x00, 0x00, 0x08];

    #[test]
    fn a_segment_is_placed_at_its_load_address() {
        let mut data = VECTORS.to_vec();
        data.extend([1, 2, 3]);
        let flash = flash_image(&image(FLASH_AT, &data)).unwrap();
        assert_eq!(flash.len(), FLASH_BYTES);
        assert_eq!(flash[..11], data);
        assert!(flash[11..].iter().all(|&byte| byte == 0xff));
        assert_eq!(initial_stack_pointer(&flash), 0x2000_2000);
    }

    fn error_of(bytes: &[u8]) -> String {
        flash_image(bytes).unwrap_err().to_string()
    }

    #[test]
    fn a_file_that_is_no_image_is_refused() {
        let prefix = "not an image for the STM32F100RB: ";
        assert!(error_of(b"").starts_with(prefix));
        assert!(error_of(b"#!/bin/sh\n").starts_with(prefix));
        let elsewhere = error_of(&image(0x2000_0000, &VECTORS));
        assert_eq!(
            elsewhere,
            format!("{prefix}a part of it does not lie in the flash")
        );
        let beyond = error_of(&image(FLASH_AT + FLASH_BYTES as u32 - 4, &VECTORS));
        assert_eq!(beyond, elsewhere);
        let whole = image(FLASH_AT, &VECTORS);
        assert_eq!(error_of(&whole[..88]), format!("{prefix}it is cut short"));
        let no_vectors = error_of(&image(FLASH_AT, &[0; 8]));
        let reason = "its vector table has stack 0x00000000, entry 0x00000000";
        assert_eq!(no_vectors, format!("{prefix}{reason}"));
        let mut foreign = whole;
        foreign[18] = 62; // x86-64
        assert_eq!(
            error_of(&foreign),
            format!("{prefix}it is for another processor")
        );
    }

    proptest! {
        #[test]
        fn no_bytes_panic(
            at in 0_usize..100, byte: u8, length in 0_usize..100,
        ) {
            let mut file = image(FLASH_AT, &VECTORS);
            if let Some(place) = file.get_mut(at) {
                *place = byte;
            }
            file.truncate(length);
            let _ = flash_image(&file); // either result is right; it must not panic
        }
    }
}
