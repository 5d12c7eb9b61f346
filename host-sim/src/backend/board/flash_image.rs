//! From an ELF file to what a programmer writes into the flash.

use super::BoardError;
use object::Endianness;
use object::elf;
use object::read::elf::{FileHeader, ProgramHeader};

/// Where the flash is.
pub(super) const FLASH_AT: u32 = 0x0800_0000;

/// Its bytes, on an STM32F100RB.
pub(super) const FLASH_BYTES: usize = 128 << 10;

/// Where the RAM is.
pub(super) const RAM_AT: u32 = 0x2000_0000;

/// Its bytes.
pub(super) const RAM_BYTES: usize = 8 << 10;

/// Erased flash reads so.
const ERASED: u8 = 0xff;

/// What a programmer writes into the flash for the ELF file `bytes`.
///
/// # Errors
///
/// [`BoardError::NotAnImage`], with what is wrong.
pub(super) fn flash_image(bytes: &[u8]) -> Result<Vec<u8>, BoardError> {
    let bad = |why: &str| BoardError::NotAnImage(why.to_owned());
    let unreadable = |error: object::Error| bad(&error.to_string());
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
pub(super) fn initial_stack_pointer(flash: &[u8]) -> u32 {
    flash
        .first_chunk()
        .map_or(0, |word| u32::from_le_bytes(*word))
}

/// Refuses what no Cortex-M could start from: the first two words are the stack and the entry.
fn check_vectors(flash: &[u8]) -> Result<(), BoardError> {
    let stack = initial_stack_pointer(flash);
    let entry = flash[4..]
        .first_chunk()
        .map_or(0, |word| u32::from_le_bytes(*word));
    let ram = RAM_AT..=RAM_AT + RAM_BYTES as u32;
    let code = FLASH_AT..FLASH_AT + FLASH_BYTES as u32;
    if ram.contains(&stack) && code.contains(&entry) && entry % 2 == 1 {
        Ok(())
    } else {
        Err(BoardError::NotAnImage(format!(
            "its vector table says stack {stack:#010x}, entry {entry:#010x}"
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::super::elf_of::elf_of as image;
    use super::*;
    use proptest::prelude::*;

    /// A vector table: the stack ends with the RAM, the program begins behind the table.
    const VECTORS: [u8; 8] = [0x00, 0x20, 0x00, 0x20, 0x09, 0x00, 0x00, 0x08];

    #[test]
    fn a_segment_lands_at_its_load_address_and_the_rest_is_erased() {
        let mut data = VECTORS.to_vec();
        data.extend([1, 2, 3]);
        let flash = flash_image(&image(FLASH_AT, &data)).unwrap();
        assert_eq!(flash.len(), FLASH_BYTES);
        assert_eq!(flash[..11], data);
        assert!(flash[11..].iter().all(|&byte| byte == 0xff));
        assert_eq!(initial_stack_pointer(&flash), 0x2000_2000);
    }

    fn refusal(bytes: &[u8]) -> String {
        flash_image(bytes).unwrap_err().to_string()
    }

    #[test]
    fn what_is_no_image_is_refused_with_the_reason() {
        let prefix = "not an image for the STM32F100RB: ";
        assert!(refusal(b"").starts_with(prefix));
        assert!(refusal(b"#!/bin/sh\n").starts_with(prefix));
        let elsewhere = refusal(&image(0x2000_0000, &VECTORS));
        assert_eq!(
            elsewhere,
            format!("{prefix}a part of it does not lie in the flash")
        );
        let beyond = refusal(&image(FLASH_AT + FLASH_BYTES as u32 - 4, &VECTORS));
        assert_eq!(beyond, elsewhere);
        let whole = image(FLASH_AT, &VECTORS);
        assert_eq!(refusal(&whole[..88]), format!("{prefix}it is cut short"));
        let no_vectors = refusal(&image(FLASH_AT, &[0; 8]));
        let told = "its vector table says stack 0x00000000, entry 0x00000000";
        assert_eq!(no_vectors, format!("{prefix}{told}"));
        let mut foreign = whole;
        foreign[18] = 62; // x86-64
        assert_eq!(
            refusal(&foreign),
            format!("{prefix}it is for another processor")
        );
    }

    proptest! {
        #[test]
        fn any_bytes_are_an_image_or_refused(
            at in 0_usize..100, byte: u8, length in 0_usize..100,
        ) {
            let mut file = image(FLASH_AT, &VECTORS);
            if let Some(place) = file.get_mut(at) {
                *place = byte;
            }
            file.truncate(length);
            let _either = flash_image(&file);
        }
    }
}
