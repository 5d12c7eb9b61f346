//! Claims about whole maps, written, read and made up.

use super::*;
use crate::export::{OutDir, write_grey_png};
use certainty_core::certainty::Certainty;
use certainty_core::units::Point;
use core::num::NonZeroU32;
use proptest::prelude::*;
use std::fs;

const FREE: CellState = CellState::Free;
const UNKNOWN: CellState = CellState::Unknown;
const OCCUPIED: CellState = CellState::Occupied;

fn yaml(more: &str) -> MapYaml {
    let text = format!("image: m.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n{more}");
    MapYaml::parse(text.as_bytes()).unwrap()
}

/// The states that pixels have in a map one row high.
fn states(more: &str, pixels: &[u8]) -> Vec<CellState> {
    let mut image = format!("P5\n{} 1\n255\n", pixels.len()).into_bytes();
    image.extend_from_slice(pixels);
    RosMap::from_parts(&yaml(more), &image).unwrap().states
}

#[test]
fn the_files_are_what_ros_expects() {
    let cells = [0, 50, 51, 128, 166, 167].map(Certainty::from_bits);
    let map = MapImage::try_new(3, 2, &cells, 50, Point::from_mm(-12_300, 4)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let files = write_ros_map(&OutDir::create(folder.path()).unwrap(), "hall", &map).unwrap();
    assert_eq!(
        fs::read(&files.pgm).unwrap(),
        b"P5\n3 2\n255\n\xCD\xCD\x00\xFE\xFE\xCD"
    );
    assert_eq!(
        fs::read_to_string(&files.yaml).unwrap(),
        "image: hall.pgm\nresolution: 0.05\norigin: [-12.3, 0.004, 0.0]\nnegate: 0\n\
         occupied_thresh: 0.65\nfree_thresh: 0.196\n"
    );
    let map = RosMap::load(&files.yaml).unwrap();
    assert_eq!(
        map.states(),
        [FREE, FREE, UNKNOWN, UNKNOWN, UNKNOWN, OCCUPIED]
    );
    assert_eq!(
        (map.width(), map.height(), map.resolution_m()),
        (3, 2, 0.05)
    );
    assert_eq!(map.origin_m(), [-12.3, 0.004]);
    assert_eq!(
        (map.state(2, 1), map.state(0, 0)),
        (Some(OCCUPIED), Some(FREE))
    );
    for (x, y) in [(-1, 0), (3, 0), (0, 2), (0, -1), (i64::MAX, i64::MIN)] {
        assert_eq!(map.state(x, y), None);
    }
}

#[test]
fn rows_keep_their_order_from_the_lowest_up_whatever_their_number() {
    for height in 1..=7_u8 {
        // As many occupied cells in a row as its number, counted from the lowest.
        let cell = |y, x| if x < y { 255 } else { 0 };
        let cells = (0..height).flat_map(|y| (0..8).map(move |x| cell(y, x)));
        let cells: Vec<Certainty> = cells.map(Certainty::from_bits).collect();
        let map = MapImage::try_new(8, height.into(), &cells, 100, Point::ORIGIN).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let files = write_ros_map(&OutDir::create(folder.path()).unwrap(), "m", &map).unwrap();
        let back = RosMap::load(&files.yaml).unwrap();
        assert_eq!(back, RosMap::from_image(&map), "{height} rows");
    }
}

#[test]
fn any_name_of_a_file_reads_back() {
    let cells = [Certainty::OCCUPIED];
    let map = MapImage::try_new(1, 1, &cells, 100, Point::ORIGIN).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let out = OutDir::create(folder.path()).unwrap();
    for name in [
        "plain-1_2",
        "it's: #1",
        "a b",
        "[x]",
        "\"q\" \\",
        "tab\there",
        "früh",
        "-",
    ] {
        let files = write_ros_map(&out, name, &map).unwrap();
        assert_eq!(
            RosMap::load(&files.yaml).unwrap(),
            RosMap::from_image(&map),
            "{name}"
        );
    }
    assert!(write_ros_map(&out, "../up", &map).is_err());
}

#[test]
fn a_png_serves_as_the_image() {
    let cells = [255, 10, 128, 0].map(Certainty::from_bits);
    let map = MapImage::try_new(2, 2, &cells, 100, Point::ORIGIN).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let out = OutDir::create(folder.path()).unwrap();
    out.write("m.png", |file| write_grey_png(&map, NonZeroU32::MIN, file))
        .unwrap();
    let text = b"image: m.png\nresolution: 0.1\norigin: [0, 0, 0]\n";
    let path = out.write_bytes("m.yaml", text).unwrap();
    assert_eq!(RosMap::load(&path).unwrap(), RosMap::from_image(&map));
}

#[test]
fn unknown_stays_unknown_under_a_free_thresh_that_would_swallow_it() {
    let pixels = [254, 206, 205, 204, 0];
    let expected = [FREE, UNKNOWN, UNKNOWN, UNKNOWN, OCCUPIED];
    assert_eq!(states("free_thresh: 0.19", &pixels), expected);
    let expected = [FREE, FREE, UNKNOWN, FREE, OCCUPIED];
    assert_eq!(states("free_thresh: 0.25", &pixels), expected);
}

#[test]
fn modes_and_negation_are_those_of_map_server() {
    assert_eq!(
        states("negate: 1", &[0, 50, 255]),
        [FREE, UNKNOWN, OCCUPIED]
    );
    let raw = [0, 19, 20, 65, 66, 100, 101, 255];
    let expected = [
        FREE, FREE, UNKNOWN, UNKNOWN, OCCUPIED, OCCUPIED, UNKNOWN, UNKNOWN,
    ];
    assert_eq!(states("mode: raw", &raw), expected);
    let scale = yaml("mode: scale");
    assert_eq!(state_of(&scale, 255, 255), FREE);
    assert_eq!(state_of(&scale, 255, 254), UNKNOWN);
}

#[test]
fn errors_name_the_file_that_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let message = |name: &str| {
        let message = RosMap::load(&at(name)).unwrap_err().to_string();
        assert_eq!(message.lines().count(), 1, "{message}");
        message
    };
    let starts = |message: &str, name: &str, rest: &str| {
        let expected = format!("{}{rest}", at(name).display());
        assert!(message.starts_with(&expected), "{message}");
    };
    starts(&message("none.yaml"), "none.yaml", ": cannot be read (");
    starts(&message("."), ".", ": cannot be read (");
    let text = "image: gone.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n";
    fs::write(at("a.yaml"), text).unwrap();
    starts(&message("a.yaml"), "gone.pgm", ": cannot be read (");
    fs::write(at("gone.pgm"), "P5 9 9 255\n123").unwrap();
    starts(&message("a.yaml"), "gone.pgm", ": announces 9 x 9 pixels");
    starts(
        &message("gone.pgm"),
        "gone.pgm",
        ":1: is no map description",
    );
    fs::write(at("b.yaml"), "image: [\u{1b}\n\n").unwrap();
    starts(&message("b.yaml"), "b.yaml", ":");
    fs::write(at("c.yaml"), vec![b'#'; 70_000]).unwrap();
    starts(&message("c.yaml"), "c.yaml", ": is larger than 65536 bytes");
}

proptest! {
    #[test]
    fn no_description_panics(bytes: Vec<u8>, text in "[-?:,\\[\\]{}#&*!|>'\"%@` a0\n\t]{0,60}") {
        let _ = MapYaml::parse(&bytes);
        let _ = MapYaml::parse(text.as_bytes());
        let _ = MapYaml::parse(format!("image: m\nresolution: 1\norigin: {text}\n").as_bytes());
    }

    #[test]
    fn no_image_panics(
        kind in 0_usize..5,
        header in "[ #0-9\n]{0,20}",
        bytes: Vec<u8>,
        place: usize,
        byte: u8,
    ) {
        let image = match kind {
            0 => bytes,
            1 => [b"P5", header.as_bytes(), &bytes].concat(),
            2 => [b"P2", header.as_bytes(), &bytes].concat(),
            3 => [&b"\x89PNG\r\n\x1a\n"[..], &bytes].concat(),
            _ => {
                let cells = [0, 99, 200, 255, 128, 1].map(Certainty::from_bits);
                let map = MapImage::try_new(3, 2, &cells, 100, Point::ORIGIN).unwrap();
                let mut file = Vec::new();
                write_grey_png(&map, NonZeroU32::MIN, &mut file).unwrap();
                let place = place % file.len();
                file[place] = byte;
                file
            }
        };
        if let Ok(map) = RosMap::from_parts(&yaml(""), &image) {
            let count = u64::from(map.width) * u64::from(map.height);
            prop_assert_eq!(map.states.len() as u64, count);
        }
    }
}
