//! The YAML file of a map: which image, how wide a cell is, where the map lies, what a pixel means.
//!
//! Read as navigation2's `map_io.cpp` with yaml-cpp reads it, and more leniently where that refuses: a
//! threshold or `negate` that is not there has its default, and keys that are not read are skipped.
//! Either is noted.

use super::files::one_line;
use core::f64::consts::{PI, TAU};
use core::fmt;
use serde::Deserialize;
use serde::de::{Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_saphyr::{DuplicateKeyPolicy, Options, Spanned, from_str_with_options, options};

/// What is wrong with a map's YAML file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum YamlError {
    /// It is not UTF-8.
    #[error("is not text; give the map's .yaml")]
    NotText,
    /// It is not YAML.
    #[error("is not a map description (YAML); correct this line, or give the map's .yaml")]
    Syntax,
    /// It has no keys.
    #[error("is not a map description; write `key: value` lines, starting with `image:`")]
    NotKeys,
    /// It has keys, but none of a map.
    #[error(
        "is YAML of something else: it has neither `image` nor `resolution`; give the map's .yaml"
    )]
    NotOfMap,
    /// A key is missing.
    #[error("`{0}` is missing; add it")]
    Missing(&'static str),
    /// A key's value is not what it must be.
    #[error("`{key}` must be {expected}; correct it")]
    Value {
        /// The key.
        key: &'static str,
        /// What its value must be.
        expected: &'static str,
    },
}

/// How pixels become probabilities.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mode {
    /// By brightness, into three states.
    Trinary,
    /// By brightness; between the thresholds a probability.
    Scale,
    /// A pixel is a percentage; above 100 it is unknown.
    Raw,
}

/// A map's description.
///
/// Possession proves that the resolution is positive and all numbers are finite.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MapYaml {
    pub(super) image: String,
    pub(super) resolution_m: f64,
    pub(super) origin_m: [f64; 2],
    /// The turn about the origin, counter-clockwise, above −π and up to π.
    pub(super) yaw_rad: f64,
    pub(super) negate: bool,
    pub(super) occupied_thresh: f64,
    pub(super) free_thresh: f64,
    pub(super) mode: Mode,
    /// What was assumed or skipped, a line each.
    pub(super) notes: Vec<String>,
}

/// The keys that are read, each value as it is written, with its line; others are ignored.
#[derive(Debug, Deserialize)]
struct Keys {
    image: Scalar,
    resolution: Scalar,
    origin: Option<Spanned<Vec<String>>>,
    negate: Scalar,
    occupied_thresh: Scalar,
    free_thresh: Scalar,
    mode: Scalar,
    trinary: Scalar,
}

type Scalar = Option<Spanned<String>>;

/// The names of [`Keys`], each with what its value must be.
const KNOWN: [(&str, &str); 8] = [
    ("image", FILE_NAME),
    ("resolution", METRES),
    ("origin", PLACE),
    ("negate", TRUTH),
    ("occupied_thresh", PROBABILITY),
    ("free_thresh", PROBABILITY),
    ("mode", MODES),
    ("trinary", TRUTH),
];
const FILE_NAME: &str = "a file name";
const METRES: &str = "metres a cell, above 0";
const PLACE: &str = "numbers: [x, y, yaw]";
const TRUTH: &str = "0 or 1 (or true or false)";
const PROBABILITY: &str = "a probability from 0 to 1";
const MODES: &str = "trinary, scale or raw";

/// Up to this turn a map is not turned: it moves no cell of a map of 5,000 cells by half a cell.
const NO_TURN_RAD: f64 = 1e-4;

pub(super) const DEFAULT_OCCUPIED: f64 = 0.65;
pub(super) const DEFAULT_FREE: f64 = 0.196;

/// How many keys a note names.
const MOST_NAMED: usize = 5;

pub(super) type Parsed<T> = Result<T, (u64, YamlError)>;

impl MapYaml {
    /// Parses the file's bytes; an error comes with its line.
    pub(super) fn parse(bytes: &[u8]) -> Parsed<Self> {
        let text = str::from_utf8(bytes).map_err(|_| (1, YamlError::NotText))?;
        let text = text.strip_prefix('\u{FEFF}').unwrap_or(text);
        // Nothing but blanks and comments is no mapping.
        let mut lines = text.lines().map(str::trim);
        if lines.all(|line| line.is_empty() || line.starts_with('#')) {
            return Err((1, YamlError::NotKeys));
        }
        let mut notes = Vec::new();
        check_kinds(text, &mut notes)?;
        // yaml-cpp finds the first of equal keys.
        let keys: Keys = read(
            text,
            options! { duplicate_keys: DuplicateKeyPolicy::FirstWins },
        )?;
        let (line, image) = scalar(&keys.image, "image")?;
        if image.is_empty() || image.contains('\0') {
            return Err(wrong(line, "image", FILE_NAME));
        }
        let resolution = number(&keys.resolution, "resolution", METRES, |m| m > 0.0)?;
        let (origin_m, yaw_rad) = origin(keys.origin.as_ref())?;
        let mut defaults = Vec::new();
        let mut probability = |value: &Scalar, key, default: f64| match value {
            Some(_) => number(value, key, PROBABILITY, |p| (0.0..=1.0).contains(&p)),
            None => {
                defaults.push(format!("`{key}: {default}`"));
                Ok(default)
            }
        };
        let occupied_thresh =
            probability(&keys.occupied_thresh, "occupied_thresh", DEFAULT_OCCUPIED)?;
        let free_thresh = probability(&keys.free_thresh, "free_thresh", DEFAULT_FREE)?;
        let negate = match &keys.negate {
            Some(value) => truth(value, "negate")?,
            None => {
                defaults.push("`negate: 0`".into());
                false
            }
        };
        if !defaults.is_empty() {
            let defaults = defaults.join(", ");
            notes.push(format!("not in the file, so by default: {defaults}"));
        }
        if free_thresh >= occupied_thresh {
            notes.push(format!(
                "free_thresh {free_thresh} is not below occupied_thresh {occupied_thresh}: a cell \
                 that meets both is free"
            ));
        }
        if yaw_rad != 0.0 {
            let degrees = yaw_rad.to_degrees();
            notes.push(format!("turned by {degrees:.2} degrees about its origin"));
        }
        Ok(Self {
            image: image.to_owned(),
            resolution_m: resolution,
            origin_m,
            yaw_rad,
            negate,
            occupied_thresh,
            free_thresh,
            mode: mode(&keys, &mut notes)?,
            notes,
        })
    }
}

fn read<'a, T: Deserialize<'a>>(text: &'a str, options: Options) -> Parsed<T> {
    from_str_with_options(text, options).map_err(|error| {
        let line = error.location().map_or(1, |at| at.line());
        (line.max(1), YamlError::Syntax)
    })
}

/// Checks that it is a mapping and that known keys have values of the right kind; notes the others.
fn check_kinds(text: &str, notes: &mut Vec<String>) -> Parsed<()> {
    let options = options! { duplicate_keys: DuplicateKeyPolicy::PassThrough };
    let Document(Some(entries)) = read(text, options)? else {
        return Err((1, YamlError::NotKeys));
    };
    let (mut seen, mut unknown, mut twice) = ([false; KNOWN.len()], Vec::new(), Vec::new());
    for (key, value) in entries {
        let Some(place) = KNOWN.iter().position(|&(known, _)| known == key) else {
            unknown.push(format!("`{}`", one_line(key)));
            continue;
        };
        let (key, expected) = KNOWN[place];
        if seen[place] {
            twice.push(format!("`{key}`"));
            continue;
        }
        seen[place] = true;
        let fits = match value.value {
            Kind::Scalar => key != "origin",
            Kind::List => key == "origin",
            Kind::Empty => true,
            Kind::Nested => false,
        };
        if !fits {
            return Err(wrong(value.referenced.line(), key, expected));
        }
    }
    if !seen[0] && !seen[1] {
        return Err((1, YamlError::NotOfMap));
    }
    for (what, mut keys) in [
        ("keys that are not read", unknown),
        ("given twice, the first is read", twice),
    ] {
        if !keys.is_empty() {
            let more = keys.len().saturating_sub(MOST_NAMED);
            keys.truncate(MOST_NAMED);
            let more = if more > 0 {
                format!(" and {more} more")
            } else {
                String::new()
            };
            notes.push(format!("{what}: {}{more}", keys.join(", ")));
        }
    }
    Ok(())
}

/// The document's keys in their order, each with the kind of its value; `None` if it is no mapping.
struct Document(Option<Vec<(String, Spanned<Kind>)>>);

/// What a value is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Empty,
    Scalar,
    /// A list of scalars.
    List,
    /// A mapping, or a list of others than scalars.
    Nested,
}

impl<'de> Deserialize<'de> for Document {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Keyed;
        impl<'de> Visitor<'de> for Keyed {
            type Value = Document;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("keys and values")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Document, A::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    entries.push(entry);
                }
                Ok(Document(Some(entries)))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Document, A::Error> {
                while list.next_element::<IgnoredAny>()?.is_some() {}
                Ok(Document(None))
            }

            fn visit_str<E>(self, _: &str) -> Result<Document, E> {
                Ok(Document(None))
            }
        }
        deserializer.deserialize_any(Keyed)
    }
}

impl<'de> Deserialize<'de> for Kind {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Any;
        impl<'de> Visitor<'de> for Any {
            type Value = Kind;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("any value")
            }

            fn visit_bool<E>(self, _: bool) -> Result<Kind, E> {
                Ok(Kind::Scalar)
            }

            fn visit_i64<E>(self, _: i64) -> Result<Kind, E> {
                Ok(Kind::Scalar)
            }

            fn visit_i128<E>(self, _: i128) -> Result<Kind, E> {
                Ok(Kind::Scalar)
            }

            fn visit_u64<E>(self, _: u64) -> Result<Kind, E> {
                Ok(Kind::Scalar)
            }

            fn visit_u128<E>(self, _: u128) -> Result<Kind, E> {
                Ok(Kind::Scalar)
            }

            fn visit_f64<E>(self, _: f64) -> Result<Kind, E> {
                Ok(Kind::Scalar)
            }

            fn visit_str<E>(self, _: &str) -> Result<Kind, E> {
                Ok(Kind::Scalar)
            }

            fn visit_bytes<E>(self, _: &[u8]) -> Result<Kind, E> {
                Ok(Kind::Scalar)
            }

            fn visit_unit<E>(self) -> Result<Kind, E> {
                Ok(Kind::Empty)
            }

            fn visit_none<E>(self) -> Result<Kind, E> {
                Ok(Kind::Empty)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Kind, A::Error> {
                let mut kind = Kind::List;
                while let Some(element) = list.next_element::<Kind>()? {
                    if element != Kind::Scalar {
                        kind = Kind::Nested;
                    }
                }
                Ok(kind)
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Kind, A::Error> {
                while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
                Ok(Kind::Nested)
            }
        }
        deserializer.deserialize_any(Any)
    }
}

const fn wrong(line: u64, key: &'static str, expected: &'static str) -> (u64, YamlError) {
    (line, YamlError::Value { key, expected })
}

fn scalar<'a>(value: &'a Scalar, key: &'static str) -> Parsed<(u64, &'a str)> {
    let value = value.as_ref().ok_or((1, YamlError::Missing(key)))?;
    Ok((value.referenced.line(), &value.value))
}

fn number(
    value: &Scalar,
    key: &'static str,
    expected: &'static str,
    fits: impl Fn(f64) -> bool,
) -> Parsed<f64> {
    let (line, text) = scalar(value, key)?;
    let number = finite(text).filter(|&number| fits(number));
    number.ok_or(wrong(line, key, expected))
}

/// Returns x and y, and the yaw within half a turn.
fn origin(value: Option<&Spanned<Vec<String>>>) -> Parsed<([f64; 2], f64)> {
    let key = "origin";
    let value = value.ok_or((1, YamlError::Missing(key)))?;
    let numbers: Option<Vec<f64>> = value.value.iter().map(|text| finite(text)).collect();
    let (x, y, yaw) = match numbers.as_deref() {
        Some(&[x, y]) => (x, y, 0.0),
        Some(&[x, y, yaw]) => (x, y, yaw),
        _ => return Err(wrong(value.referenced.line(), key, PLACE)),
    };
    let turn = yaw.rem_euclid(TAU);
    let turn = if turn > PI { turn - TAU } else { turn };
    let turn = if turn.abs() < NO_TURN_RAD { 0.0 } else { turn };
    Ok(([x, y], turn))
}

fn finite(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

/// A boolean of YAML 1.1, in any case, or a whole number, of which 0 is false.
fn truth(value: &Spanned<String>, key: &'static str) -> Parsed<bool> {
    match value.value.to_ascii_lowercase().as_str() {
        "true" | "yes" | "on" | "y" => Ok(true),
        "false" | "no" | "off" | "n" => Ok(false),
        text => match text.parse::<i64>() {
            Ok(number) => Ok(number != 0),
            Err(_) => Err(wrong(value.referenced.line(), key, TRUTH)),
        },
    }
}

/// Returns the mode by `mode`, else by the `trinary` of old map servers.
fn mode(keys: &Keys, notes: &mut Vec<String>) -> Parsed<Mode> {
    let by_trinary = keys.trinary.as_ref();
    let trinary = by_trinary
        .map(|value| truth(value, "trinary"))
        .transpose()?;
    let Some(value) = &keys.mode else {
        if trinary == Some(false) {
            notes.push("`trinary: false` is read as `mode: scale`".into());
            return Ok(Mode::Scale);
        }
        return Ok(Mode::Trinary);
    };
    if trinary.is_some() {
        notes.push("`trinary` is not read where `mode` is given".into());
    }
    match value.value.to_ascii_lowercase().as_str() {
        "trinary" => Ok(Mode::Trinary),
        "scale" => Ok(Mode::Scale),
        "raw" => Ok(Mode::Raw),
        _ => Err(wrong(value.referenced.line(), "mode", MODES)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const WHOLE: &str = "image: map.pgm\nresolution: 0.05\norigin: [-1.5, 2, 0.0]\nnegate: 0\n\
                         occupied_thresh: 0.65\nfree_thresh: 0.196\n";

    fn parse(text: &str) -> MapYaml {
        MapYaml::parse(text.as_bytes()).unwrap()
    }

    fn message(text: &str) -> String {
        let (line, error) = MapYaml::parse(text.as_bytes()).unwrap_err();
        format!("{line}: {error}")
    }

    #[test]
    fn map_saver_description_is_read() {
        let expected = MapYaml {
            image: "map.pgm".to_owned(),
            resolution_m: 0.05,
            origin_m: [-1.5, 2.0],
            yaw_rad: 0.0,
            negate: false,
            occupied_thresh: 0.65,
            free_thresh: 0.196,
            mode: Mode::Trinary,
            notes: Vec::new(),
        };
        assert_eq!(parse(WHOLE), expected);
        assert_eq!(parse(&format!("\u{FEFF}---\n{WHOLE}")), expected);
        assert_eq!(parse(&WHOLE.replace('\n', "\r\n")), expected);
        assert_eq!(
            parse(&WHOLE.replace(" [-1.5, 2, 0.0]", "\n  - -1.5\n  - 2\n  - 0.0")),
            expected
        );
        assert_eq!(parse(&WHOLE.replace("2, 0.0", "2")), expected);
    }

    #[test]
    fn missing_keys_have_noted_defaults() {
        let short = parse("{image: 'map.pgm', resolution: 5e-2, origin: [-1.5, 2.0]}");
        let found = (short.occupied_thresh, short.free_thresh, short.negate);
        assert_eq!(found, (0.65, 0.196, false));
        assert_eq!(
            short.notes,
            [
                "not in the file, so by default: `occupied_thresh: 0.65`, `free_thresh: 0.196`, `negate: 0`"
            ]
        );
        let low = WHOLE.replace("free_thresh: 0.196\n", "");
        let low = parse(&low.replace("0.65", "0.1"));
        assert_eq!((low.occupied_thresh, low.free_thresh), (0.1, 0.196));
        assert_eq!(
            low.notes,
            [
                "not in the file, so by default: `free_thresh: 0.196`",
                "free_thresh 0.196 is not below occupied_thresh 0.1: a cell that meets both is free",
            ]
        );
        let empty = parse(&WHOLE.replace("negate: 0", "negate:"));
        assert_eq!(empty.notes, ["not in the file, so by default: `negate: 0`"]);
    }

    #[test]
    fn keys_that_are_not_read_are_named() {
        let more =
            format!("{WHOLE}mode: raw\nnotes: {{a: [1, {{b: c}}], origin: [9, 9, 0]}}\nx: &y 1\n");
        let yaml = parse(&more);
        assert_eq!((yaml.mode, yaml.origin_m), (Mode::Raw, [-1.5, 2.0]));
        assert_eq!(yaml.notes, ["keys that are not read: `notes`, `x`"]);
        let many: String = (0..8).map(|key| format!("k{key}: 1\n")).collect();
        let yaml = parse(&format!("{WHOLE}{many}"));
        assert_eq!(
            yaml.notes,
            ["keys that are not read: `k0`, `k1`, `k2`, `k3`, `k4` and 3 more"]
        );
    }

    #[test]
    fn first_of_equal_keys_is_read_and_noted() {
        let yaml = parse(&format!("{WHOLE}resolution: 7\n"));
        assert_eq!(yaml.resolution_m, 0.05);
        assert_eq!(yaml.notes, ["given twice, the first is read: `resolution`"]);
    }

    #[test]
    fn booleans_of_yaml_are_read_in_any_case() {
        for (text, expected) in [
            ("0", false),
            ("False", false),
            ("FALSE", false),
            ("no", false),
            ("Off", false),
            ("n", false),
            ("1", true),
            ("2", true),
            ("TRUE", true),
            ("Yes", true),
            ("on", true),
            ("'true'", true),
        ] {
            let yaml = parse(&WHOLE.replace("negate: 0", &format!("negate: {text}")));
            assert_eq!(yaml.negate, expected, "{text}");
            assert!(yaml.notes.is_empty());
        }
    }

    #[test]
    fn mode_is_read_in_any_case() {
        for (line, expected) in [
            ("mode: Trinary", Mode::Trinary),
            ("mode: SCALE", Mode::Scale),
            ("mode: Raw", Mode::Raw),
            ("trinary: false", Mode::Scale),
            ("trinary: 1", Mode::Trinary),
            ("trinary: no\nmode: trinary", Mode::Trinary),
        ] {
            assert_eq!(parse(&format!("{WHOLE}{line}\n")).mode, expected, "{line}");
        }
        assert_eq!(
            parse(&format!("{WHOLE}trinary: false\n")).notes,
            ["`trinary: false` is read as `mode: scale`"]
        );
    }

    #[test]
    fn yaw_of_whole_turns_is_none() {
        for (yaw, expected) in [
            ("1e-7", 0.0),
            ("-0.0000001", 0.0),
            ("6.283185", 0.0),
            ("-12.566371", 0.0),
            ("3.1", 3.1),
            ("-1.57", -1.57),
            ("4.5", 4.5 - TAU),
        ] {
            let yaml = parse(&WHOLE.replace("2, 0.0", &format!("2, {yaw}")));
            assert!((yaml.yaw_rad - expected).abs() < 1e-12, "{yaw}");
            assert_eq!(yaml.notes.is_empty(), expected == 0.0, "{yaw}");
        }
        let yaml = parse(&WHOLE.replace("2, 0.0", "2, 3.14"));
        assert_eq!(yaml.notes, ["turned by 179.91 degrees about its origin"]);
    }

    #[test]
    fn wrong_value_is_named_with_its_line() {
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
                "[2], 0.0",
                "3: `origin` must be numbers: [x, y, yaw]; correct it",
            ),
            (
                "[-1.5, 2, 0.0]",
                "-1.5",
                "3: `origin` must be numbers: [x, y, yaw]; correct it",
            ),
            (
                "-1.5, 2, 0.0",
                "1",
                "3: `origin` must be numbers: [x, y, yaw]; correct it",
            ),
            (
                "negate: 0",
                "negate: maybe",
                "4: `negate` must be 0 or 1 (or true or false); correct it",
            ),
            (
                "0.65",
                "1.5",
                "5: `occupied_thresh` must be a probability from 0 to 1; correct it",
            ),
            (
                "free_thresh: 0.196",
                "mode: triple",
                "6: `mode` must be trinary, scale or raw; correct it",
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
    fn other_text_is_refused_in_one_line() {
        for text in [
            "",
            "\n",
            "# only a note\n",
            "just words",
            "- image: map.pgm\n",
        ] {
            assert!(
                message(text).ends_with("starting with `image:`"),
                "{text:?}"
            );
        }
        for text in ["? [a]\n: b\n", "image: \"map", "image: [\u{1b}\n\n"] {
            let message = message(text);
            assert!(
                message.contains("is not a map description (YAML)"),
                "{message}"
            );
            assert_eq!(message.lines().count(), 1, "{message}");
        }
        let other = "controller_server:\n  ros__parameters:\n    rate: 20\n";
        assert!(message(other).contains("is YAML of something else"));
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

    proptest! {
        #[test]
        fn no_description_panics(bytes: Vec<u8>, text in "[-?:,\\[\\]{}#&*!|>'\"%@` a0\n\t]{0,60}") {
            let _ = MapYaml::parse(&bytes);
            let _ = MapYaml::parse(text.as_bytes());
            let _ = MapYaml::parse(format!("image: m\nresolution: 1\norigin: {text}\n").as_bytes());
        }
    }
}
