//! Why a map cannot be loaded.

use crate::export::files::{display_path, one_line};
use image::ImageError;
use std::io;
use std::path::PathBuf;

/// Why a map cannot be loaded; each reads as one line that says what to do.
#[derive(Debug, thiserror::Error)]
pub enum MapError {
    /// A file cannot be read.
    #[error(
        "{}: cannot be read ({source}); name the map's .yaml, and keep its image where that names it",
        display_path(.path)
    )]
    Open {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// A file is larger than the limit for such files.
    #[error("{}: is larger than {limit} bytes; name the map's .yaml", display_path(.path))]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// The limit in bytes.
        limit: u64,
    },
    /// The YAML file does not describe a map.
    #[error("{}:{line}: {source}", display_path(.path))]
    Yaml {
        /// The file.
        path: PathBuf,
        /// The line.
        line: u64,
        /// What is wrong there.
        source: YamlError,
    },
    /// The image cannot be used.
    #[error("{}: {source}", display_path(.path))]
    Image {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: PixelError,
    },
}

/// What is wrong with a map's YAML file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum YamlError {
    /// It is not UTF-8.
    #[error("is not text; name the map's .yaml, not its image")]
    NotText,
    /// It is not YAML, or a value is of another kind; with the parser's message.
    #[error("is not a map description ({0}); correct it")]
    Syntax(String),
    /// It has no keys.
    #[error("is not a map description; write `key: value` lines, starting with `image:`")]
    NotKeys,
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

/// What is wrong with a map's image.
#[derive(Debug, thiserror::Error)]
pub enum PixelError {
    /// It is not a PGM, PNG or BMP.
    #[error("is not PGM (P5, P2), PNG or BMP; convert the image")]
    UnknownFormat,
    /// It has no pixels.
    #[error("has no pixels; save the map again")]
    Empty,
    /// It has more pixels than a map may have.
    #[error("is of {width} x {height} pixels, more than a map may have; cut it down")]
    TooLarge {
        /// Pixels a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// Its samples are wider than a byte.
    #[error("has the largest value {0} where 255 is supported; convert it to 8 bits")]
    Depth(u32),
    /// The header's size differs from the data's.
    #[error("announces {width} x {height} pixels but does not hold them; copy the file anew")]
    Size {
        /// Pixels a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// The decoder failed.
    #[error("is damaged ({}); save the map again", one_line(.0.to_string()))]
    Decode(#[from] ImageError),
}
