//! Claims about descriptions of maps.

use super::*;

const WHOLE: &str = "image: map.pgm\nresolution: 0.05\norigin: [-1.5, 2, 0.0]\nnegate: 0\n\
                     occupied_thresh: 0.65\nfree_thresh: 0.196\n";

fn message(text: &str) -> String {
    let (line, error) = MapYaml::parse(text.as_bytes()).unwrap_err();
    format!("{line}: {error}")
}

#[test]
fn a_description_as_map_saver_writes_it() {
    let expected = MapYaml {
        image: "map.pgm".to_owned(),
        resolution_m: 0.05,
        origin_m: [-1.5, 2.0],
        negate: false,
        occupied_thresh: 0.65,
        free_thresh: 0.196,
        mode: Mode::Trinary,
    };
    assert_eq!(MapYaml::parse(WHOLE.as_bytes()).unwrap(), expected);
    let block = WHOLE.replace(" [-1.5, 2, 0.0]", "\n  - -1.5\n  - 2\n  - 0.0");
    assert_eq!(MapYaml::parse(block.as_bytes()).unwrap(), expected);
    let short = "{image: 'map.pgm', resolution: 5e-2, origin: [-1.5, 2.0]}";
    assert_eq!(MapYaml::parse(short.as_bytes()).unwrap(), expected);
}

#[test]
fn keys_of_others_are_left_alone_however_nested() {
    let more =
        format!("{WHOLE}mode: raw\nnotes: {{a: [1, {{b: c}}], origin: [9, 9, 0]}}\nx: &y 1\n");
    let yaml = MapYaml::parse(more.as_bytes()).unwrap();
    assert_eq!((yaml.mode, yaml.origin_m), (Mode::Raw, [-1.5, 2.0]));
}

#[test]
fn every_wrong_value_is_named_with_its_line() {
    for (from, to, expected) in [
        ("image: map.pgm\n", "", "1: `image` is missing; add it"),
        (
            "0.05",
            "0",
            "2: `resolution` must be metres a cell, above 0; correct it",
        ),
        (
            "0.05",
            "nan",
            "2: `resolution` must be metres a cell, above 0; correct it",
        ),
        (
            "0.05",
            "[0.05]",
            "2: `resolution` must be metres a cell, above 0; correct it",
        ),
        (
            "2, 0.0",
            "2, 1.57",
            "3: `origin` must be without rotation: [x, y, 0.0]; correct it",
        ),
        (
            "2, 0.0",
            "[2], 0.0",
            "3: `origin` must be a list: [x, y, yaw]; correct it",
        ),
        (
            "-1.5, 2, 0.0",
            "1",
            "3: `origin` must be numbers: [x, y, yaw]; correct it",
        ),
        (
            "negate: 0",
            "negate: maybe",
            "4: `negate` must be 0 or 1; correct it",
        ),
        (
            "0.65",
            "1.5",
            "5: `occupied_thresh` must be a probability within 0 to 1; correct it",
        ),
        (
            "0.196",
            "0.7",
            "6: `free_thresh` must be below `occupied_thresh`; correct it",
        ),
    ] {
        assert_eq!(
            message(&WHOLE.replace(from, to)),
            expected,
            "{from:?} -> {to:?}"
        );
    }
}

#[test]
fn what_is_no_description_is_told_so() {
    for text in [
        "",
        "\n",
        "# only a note\n",
        "just words",
        "- image: map.pgm\n",
        "? [a]\n: b\n",
    ] {
        assert!(
            message(text).ends_with("starting with `image:`"),
            "{text:?}"
        );
    }
    assert!(message("image: \"map").contains("is no YAML"));
    assert_eq!(
        MapYaml::parse(b"image: \xff").unwrap_err().1,
        YamlError::NotText
    );
}

#[test]
fn no_nesting_overflows_the_stack() {
    for nest in ["[", "{a: ", "- ", "? ", "a:\n "] {
        let deep = nest.repeat((1 << 16) / nest.len());
        assert!(MapYaml::parse(deep.as_bytes()).is_err());
        let deep = format!("image: map.pgm\nx: {deep}");
        assert!(MapYaml::parse(deep.as_bytes()).is_err());
    }
}
