//! The YAML file that describes a map.

use super::error::YamlError;
use crate::export::files::one_line;
use serde::Deserialize;
use serde_saphyr::{DuplicateKeyPolicy, Spanned, from_str_with_options, options};

/// How pixels become probabilities.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mode {
    /// By brightness, into three states.
    Trinary,
    /// By brightness; transparent pixels are unknown.
    Scale,
    /// A pixel is a percentage; above 100 it is unknown.
    Raw,
}

/// A map's description.
///
/// Possession proves that the resolution is positive, all numbers are finite, and the free
/// threshold is below the occupied one.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MapYaml {
    pub(super) image: String,
    pub(super) resolution_m: f64,
    pub(super) origin_m: [f64; 2],
    pub(super) negate: bool,
    pub(super) occupied_thresh: f64,
    pub(super) free_thresh: f64,
    pub(super) mode: Mode,
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
}

type Scalar = Option<Spanned<String>>;

type Result<T> = core::result::Result<T, (u64, YamlError)>;

impl MapYaml {
    /// Parses the file's bytes; an error comes with its line.
    ///
    /// Default thresholds are 0.65 and 0.196, the default negation is 0, the default mode trinary.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self> {
        let text = str::from_utf8(bytes).map_err(|_| (1, YamlError::NotText))?;
        let text = text.strip_prefix('\u{FEFF}').unwrap_or(text);
        // Nothing but blanks and comments is no mapping.
        let mut lines = text.lines().map(str::trim);
        if lines.all(|line| line.is_empty() || line.starts_with('#')) {
            return Err((1, YamlError::NotKeys));
        }
        let options = options! { duplicate_keys: DuplicateKeyPolicy::LastWins };
        let keys: Keys = from_str_with_options(text, options).map_err(|error| {
            let line = error.location().map_or(1, |at| at.line());
            let message = one_line(error.without_snippet().to_string());
            (line.max(1), YamlError::Syntax(message))
        })?;
        let (line, image) = scalar(&keys.image, "image")?;
        if image.is_empty() || image.contains('\0') {
            return Err(wrong(line, "image", "a file name"));
        }
        let thresh = |value: &Scalar, key, default| match value {
            Some(_) => number(value, key, "a probability from 0 to 1", |p| {
                (0.0..=1.0).contains(&p)
            }),
            None => Ok((1, default)),
        };
        let (_, occupied_thresh) = thresh(&keys.occupied_thresh, "occupied_thresh", 0.65)?;
        let (line, free_thresh) = thresh(&keys.free_thresh, "free_thresh", 0.196)?;
        if free_thresh >= occupied_thresh {
            return Err(wrong(line, "free_thresh", "below `occupied_thresh`"));
        }
        let resolution = number(
            &keys.resolution,
            "resolution",
            "metres a cell, above 0",
            |m| m > 0.0,
        );
        Ok(Self {
            image: image.to_owned(),
            resolution_m: resolution?.1,
            origin_m: origin(keys.origin.as_ref())?,
            negate: match &keys.negate {
                None => false,
                Some(value) => match value.value.as_str() {
                    "0" | "false" => false,
                    "1" | "true" => true,
                    _ => return Err(wrong(value.referenced.line(), "negate", "0 or 1")),
                },
            },
            occupied_thresh,
            free_thresh,
            mode: match &keys.mode {
                None => Mode::Trinary,
                Some(value) => match value.value.as_str() {
                    "trinary" => Mode::Trinary,
                    "scale" => Mode::Scale,
                    "raw" => Mode::Raw,
                    _ => {
                        let line = value.referenced.line();
                        return Err(wrong(line, "mode", "trinary, scale or raw"));
                    }
                },
            },
        })
    }
}

const fn wrong(line: u64, key: &'static str, expected: &'static str) -> (u64, YamlError) {
    (line, YamlError::Value { key, expected })
}

fn scalar<'a>(value: &'a Scalar, key: &'static str) -> Result<(u64, &'a str)> {
    let value = value.as_ref().ok_or((1, YamlError::Missing(key)))?;
    Ok((value.referenced.line(), &value.value))
}

fn number(
    value: &Scalar,
    key: &'static str,
    expected: &'static str,
    fits: impl Fn(f64) -> bool,
) -> Result<(u64, f64)> {
    let (line, text) = scalar(value, key)?;
    let number = finite(text).filter(|&number| fits(number));
    Ok((line, number.ok_or(wrong(line, key, expected))?))
}

fn origin(value: Option<&Spanned<Vec<String>>>) -> Result<[f64; 2]> {
    let key = "origin";
    let value = value.ok_or((1, YamlError::Missing(key)))?;
    let line = value.referenced.line();
    let numbers: Option<Vec<f64>> = value.value.iter().map(|text| finite(text)).collect();
    match numbers.as_deref() {
        Some(&[x, y] | &[x, y, 0.0]) => Ok([x, y]),
        Some(&[_, _, _]) => Err(wrong(line, key, "without rotation: [x, y, 0.0]")),
        _ => Err(wrong(line, key, "numbers: [x, y, yaw]")),
    }
}

fn finite(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHOLE: &str = "image: map.pgm\nresolution: 0.05\norigin: [-1.5, 2, 0.0]\nnegate: 0\n\
                         occupied_thresh: 0.65\nfree_thresh: 0.196\n";

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
        let twice = format!("resolution: 7\n{WHOLE}");
        assert_eq!(MapYaml::parse(twice.as_bytes()).unwrap(), expected);
    }

    #[test]
    fn unknown_keys_are_ignored_however_nested() {
        let more =
            format!("{WHOLE}mode: raw\nnotes: {{a: [1, {{b: c}}], origin: [9, 9, 0]}}\nx: &y 1\n");
        let yaml = MapYaml::parse(more.as_bytes()).unwrap();
        assert_eq!((yaml.mode, yaml.origin_m), (Mode::Raw, [-1.5, 2.0]));
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
                "2, 0.0",
                "2, 1.57",
                "3: `origin` must be without rotation: [x, y, 0.0]; correct it",
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
                "5: `occupied_thresh` must be a probability from 0 to 1; correct it",
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
        // A value of another kind is reported by the parser.
        for (from, to, line) in [("0.05", "[0.05]", "2"), ("2, 0.0", "[2], 0.0", "3")] {
            let message = message(&WHOLE.replace(from, to));
            assert!(message.starts_with(&format!("{line}: ")), "{message}");
            assert_eq!(message.lines().count(), 1, "{message}");
        }
    }

    #[test]
    fn other_text_is_refused_in_one_line() {
        for text in ["", "\n", "# only a note\n"] {
            assert!(
                message(text).ends_with("starting with `image:`"),
                "{text:?}"
            );
        }
        for text in [
            "just words",
            "- image: map.pgm\n",
            "? [a]\n: b\n",
            "image: \"map",
        ] {
            let message = message(text);
            assert!(message.contains("is not a map description ("), "{message}");
            assert_eq!(message.lines().count(), 1, "{message}");
        }
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
}
