//! Small ELF files for tests, laid out as the standard's tables say.

/// An ELF file with one segment `data` that is loaded at `address`.
pub(crate) fn elf_of(address: u32, data: &[u8]) -> Vec<u8> {
    let mut file = b"\x7fELF\x01\x01\x01\0\0\0\0\0\0\0\0\0".to_vec();
    for half in [2_u16, 40] {
        file.extend(half.to_le_bytes()); // executable, Arm
    }
    for word in [1_u32, address + 9, 52, 0, 0x0500_0200] {
        file.extend(word.to_le_bytes()); // version, entry, program headers, sections, flags
    }
    for half in [52_u16, 32, 1, 40, 0, 0] {
        file.extend(half.to_le_bytes());
    }
    let length = data.len() as u32;
    for word in [1, 84, address, address, length, length, 5, 4] {
        file.extend(word.to_le_bytes()); // PT_LOAD at file offset 84
    }
    file.extend(data);
    file
}
