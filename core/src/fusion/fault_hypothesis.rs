//! The fault hypothesis of \[001\] §2.1, exhaustively.

use std::vec::Vec;

/// Calls `check` with what up to seven sensors say about a cell, and what the correct ones among them
/// say, lowest first: every minority of ⌊(n − 1)/2⌋ liars, saying 0, 120 or 255 each.
pub(super) fn every_minority(mut check: impl FnMut(&[u8], &[u8])) {
    for sensors in 1..=7_u32 {
        let minority = |liars: &u32| liars.count_ones() <= (sensors - 1) / 2;
        for liars in (0_u32..1 << sensors).filter(minority) {
            for mut lies in 0..3_u32.pow(liars.count_ones()) {
                let (mut told, mut correct) = (Vec::new(), Vec::new());
                for sensor in 0..sensors {
                    if liars >> sensor & 1 == 0 {
                        correct.push(100 + 7 * sensor as u8);
                        told.push(100 + 7 * sensor as u8);
                    } else {
                        told.push([0, 120, 255][lies as usize % 3]);
                        lies /= 3;
                    }
                }
                check(&told, &correct);
            }
        }
    }
}
