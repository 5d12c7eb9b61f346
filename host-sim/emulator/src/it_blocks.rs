//! IT blocks that an interrupt enters.
//!
//! A processor that is interrupted between the conditional instructions of an IT block stores its place
//! in the block: bits 26 to 25 and 15 to 10 of the xPSR that it stacks (Armv7-M Architecture Reference
//! Manual, B1.4.2 and B1.5.6). `rsemu` 0.0.7 leaves those bits out, so that the rest of the block is
//! executed after the return whatever its condition; and a handler that returns from within an IT block
//! of its own advances the interrupted one by an instruction. [`restore`] corrects both.

use rsemu::core::space::{MemResult, RamStore};
use rsemu::cpu::arm::v7m::{ArmV7m, Regs, xpsr};

/// Bytes of an exception's frame: eight words, the last of them xPSR, the one before the PC.
const FRAME: u32 = 32;

/// Restores the bits that the step from `before` to `after` lost, in the processor and in `after`; `ram`
/// begins at `ram_at`.
pub(crate) fn restore(core: &ArmV7m, ram: &RamStore, ram_at: u32, before: &Regs, after: &mut Regs) {
    let block = before.xpsr & xpsr::IT_MASK;
    if block == 0 || before.exception() == after.exception() {
        return;
    }
    let word = |at: u32| -> MemResult<u32> {
        let mut bytes = [0; 4];
        ram.read_at(at.wrapping_sub(ram_at).into(), &mut bytes)?;
        Ok(u32::from_le_bytes(bytes))
    };
    if after.msp < before.msp {
        let at = after.msp + FRAME - 4;
        // A stack outside the RAM raises a fault of its own.
        if let Ok(stacked) = word(at) {
            let whole = (stacked | block).to_le_bytes();
            let _ = ram.write_at(at.wrapping_sub(ram_at).into(), &whole); // it was just read
        }
    } else if after.msp > before.msp {
        // The frame may have had a word of padding behind it.
        let bases = [after.msp - FRAME, after.msp - FRAME - 4];
        let frame = bases
            .into_iter()
            .find(|base| word(base + 24) == Ok(after.r[15]));
        if let Some(Ok(stacked)) = frame.map(|base| word(base + 28)) {
            let interrupted = stacked & xpsr::IT_MASK;
            after.xpsr = after.xpsr & !xpsr::IT_MASK | interrupted;
            core.set_xpsr(after.xpsr);
        }
    }
}
