//! The YAML file that describes a map.
//!
//! Read event by event: a tree would recurse as deep as the file pleases.

use super::error::YamlError;
use yaml_rust2::parser::{Event, Parser};

/// How pixels become probabilities.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mode {
    /// By brightness, into three states.
    Trinary,
    /// By brightness; what is transparent is unknown.
    Scale,
    /// A pixel is a percentage; above 100 it is unknown.
    Raw,
}

/// What the file says.
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

/// A value, so far as one of a map can be.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Value {
    Scalar(String),
    List(Vec<String>),
    /// Something nested, which no key of a map has.
    Other,
}

/// The keys of the file in order, each with its line and value.
struct Keys(Vec<(String, usize, Value)>);

type Result<T> = core::result::Result<T, (usize, YamlError)>;

impl MapYaml {
    /// Parses the file's bytes; an error comes with its line.
    ///
    /// Thresholds that are not given are 0.65 and 0.196, negation 0, the mode trinary.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self> {
        let text = str::from_utf8(bytes).map_err(|_| (1, YamlError::NotText))?;
        let keys = Keys::parse(text.strip_prefix('\u{FEFF}').unwrap_or(text))?;
        let (line, image) = keys.scalar("image", "a file name")?;
        if image.is_empty() || image.contains('\0') {
            let expected = "a file name";
            return Err((
                line,
                YamlError::Value {
                    key: "image",
                    expected,
                },
            ));
        }
        let thresh = |key, default| match keys.get(key) {
            Some(_) => keys.number(key, "a probability within 0 to 1", |p| {
                (0.0..=1.0).contains(&p)
            }),
            None => Ok((1, default)),
        };
        let (_, occupied_thresh) = thresh("occupied_thresh", 0.65)?;
        let (line, free_thresh) = thresh("free_thresh", 0.196)?;
        if free_thresh >= occupied_thresh {
            let expected = "below `occupied_thresh`";
            return Err((
                line,
                YamlError::Value {
                    key: "free_thresh",
                    expected,
                },
            ));
        }
        let one_of = |key, expected, words: &[(&str, u8)]| match keys.get(key) {
            None => Ok(0),
            Some(_) => {
                let (line, word) = keys.scalar(key, expected)?;
                let found = words.iter().find(|(name, _)| *name == word);
                found
                    .map(|&(_, index)| index)
                    .ok_or((line, YamlError::Value { key, expected }))
            }
        };
        let flags = [("0", 0), ("1", 1), ("false", 0), ("true", 1)];
        let modes = [("trinary", 0), ("scale", 1), ("raw", 2)];
        Ok(Self {
            image: image.to_owned(),
            resolution_m: keys
                .number("resolution", "metres a cell, above 0", |metres| {
                    metres > 0.0
                })?
                .1,
            origin_m: keys.origin()?,
            negate: one_of("negate", "0 or 1", &flags)? == 1,
            occupied_thresh,
            free_thresh,
            mode: match one_of("mode", "trinary, scale or raw", &modes)? {
                0 => Mode::Trinary,
                1 => Mode::Scale,
                _ => Mode::Raw,
            },
        })
    }
}

impl Keys {
    fn parse(text: &str) -> Result<Self> {
        let mut parser = Parser::new_from_str(text);
        let mut keys = Vec::new();
        let mut key: Option<(String, usize)> = None;
        let mut value = Value::Other;
        // 1 is among the keys, 2 within a key's value.
        let mut depth = 0_usize;
        loop {
            let (event, mark) = parser
                .next_token()
                .map_err(|error| (error.marker().line().max(1), YamlError::Syntax(error)))?;
            let is_value = depth == 1 && key.is_some();
            match event {
                Event::StreamEnd | Event::DocumentEnd => break,
                Event::MappingStart(..) if depth == 0 => depth = 1,
                Event::Scalar(text, ..) if depth == 1 && !is_value => {
                    key = Some((text, mark.line()));
                    continue;
                }
                Event::Scalar(text, ..) if is_value => value = Value::Scalar(text),
                Event::Scalar(text, ..) if depth == 2 => {
                    if let Value::List(list) = &mut value {
                        list.push(text);
                    }
                    continue;
                }
                Event::Scalar(..) if depth > 2 => continue,
                Event::SequenceStart(..) if is_value => {
                    value = Value::List(Vec::new());
                    depth = 2;
                    continue;
                }
                Event::MappingStart(..) | Event::SequenceStart(..) if is_value || depth >= 2 => {
                    value = Value::Other;
                    depth += 1;
                    continue;
                }
                Event::MappingEnd | Event::SequenceEnd if depth >= 2 => {
                    depth -= 1;
                    if depth > 1 {
                        continue;
                    }
                }
                Event::MappingEnd if depth == 1 => break,
                Event::Alias(_) if is_value => value = Value::Other,
                Event::Alias(_) if depth >= 2 => {
                    value = Value::Other;
                    continue;
                }
                Event::StreamStart | Event::DocumentStart | Event::Nothing => continue,
                // A scalar or a list where the keys should be, or a key that is none.
                _ => return Err((mark.line().max(1), YamlError::NotKeys)),
            }
            if let Some((key, line)) = key.take() {
                keys.push((key, line, core::mem::replace(&mut value, Value::Other)));
            }
        }
        if keys.is_empty() {
            return Err((1, YamlError::NotKeys));
        }
        Ok(Self(keys))
    }

    /// The line and value of `key`; of the last, if there are several.
    fn get(&self, key: &str) -> Option<(usize, &Value)> {
        let found = self.0.iter().rev().find(|(name, ..)| name == key);
        found.map(|(_, line, value)| (*line, value))
    }

    fn scalar(&self, key: &'static str, expected: &'static str) -> Result<(usize, &str)> {
        match self.get(key) {
            Some((line, Value::Scalar(text))) => Ok((line, text)),
            Some((line, _)) => Err((line, YamlError::Value { key, expected })),
            None => Err((1, YamlError::Missing(key))),
        }
    }

    fn number(
        &self,
        key: &'static str,
        expected: &'static str,
        fits: impl Fn(f64) -> bool,
    ) -> Result<(usize, f64)> {
        let (line, text) = self.scalar(key, expected)?;
        let number = finite(text).filter(|&number| fits(number));
        let number = number.ok_or((line, YamlError::Value { key, expected }))?;
        Ok((line, number))
    }

    fn origin(&self) -> Result<[f64; 2]> {
        let key = "origin";
        let wrong = |line, expected| (line, YamlError::Value { key, expected });
        let (line, list) = match self.get(key) {
            Some((line, Value::List(list))) => (line, list),
            Some((line, _)) => return Err(wrong(line, "a list: [x, y, yaw]")),
            None => return Err((1, YamlError::Missing(key))),
        };
        let numbers: Option<Vec<f64>> = list.iter().map(|text| finite(text)).collect();
        match numbers.as_deref() {
            Some(&[x, y] | &[x, y, 0.0]) => Ok([x, y]),
            Some(&[_, _, _]) => Err(wrong(line, "without rotation: [x, y, 0.0]")),
            _ => Err(wrong(line, "numbers: [x, y, yaw]")),
        }
    }
}

fn finite(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

#[cfg(test)]
#[path = "yaml_tests.rs"]
mod tests;
