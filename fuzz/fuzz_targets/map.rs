//! Maps of navigation: any YAML with any image.
//!
//! The first two bytes are the length of the YAML; the rest is the image.
#![no_main]

use certainty_sim::export::{LoadedMap, RosMap, compare};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let Some((length, data)) = data.split_first_chunk() else {
        return;
    };
    let length = usize::from(u16::from_le_bytes(*length)).min(data.len());
    let (yaml, image) = data.split_at(length);
    let Ok(LoadedMap { map, notes }) = RosMap::from_bytes(yaml, image) else {
        return;
    };
    let cells = u64::from(map.width()) * u64::from(map.height());
    assert_eq!(map.states().len() as u64, cells);
    assert!(map.resolution_m() > 0.0 && notes.len() < 16);
    assert!(notes.iter().all(|note| note.lines().count() == 1));
    // Its memory is bounded by the file: 1,100 is the most that deflate can pack.
    assert!(cells <= image.len() as u64 * 8 * 1100);
    if let Ok(comparison) = compare(&map, &map) {
        assert_eq!(comparison.agreeing, comparison.known_in_both);
        assert_eq!((comparison.only_a, comparison.only_b), (0, 0));
    }
});
