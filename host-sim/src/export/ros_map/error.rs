//! Why files are no map.

use crate::export::shown;
use crate::export::shown::one_line;
use std::io;
use std::path::PathBuf;
use yaml_rust2::ScanError;

/// Why a map cannot be loaded; each reads as one line that says what to do.
#[derive(Debug, thiserror::Error)]
pub enum MapError {
    /// A file cannot be read.
    #[error(
        "{}: cannot be read ({source}); name the map's .yaml, and keep its image where that says",
        shown(.path)
    )]
    Open {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A file is larger than any such file should be.
    #[error("{}: is larger than {limit} bytes; name the map's .yaml", shown(.path))]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// The most that is read.
        limit: u64,
    },
    /// The YAML file describes no map.
    #[error("{}:{line}: {source}", shown(.path))]
    Yaml {
        /// The file.
        path: PathBuf,
        /// The line.
        line: usize,
        /// What is wrong there.
        source: YamlError,
    },
    /// The image cannot be used.
    #[error("{}: {source}", shown(.path))]
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
    /// It is no YAML.
    #[error("is no YAML ({}); correct it", one_line(.0.to_string()))]
    Syntax(ScanError),
    /// It is no list of keys with values.
    #[error("is no map description; write `key: value` lines, starting with `image:`")]
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
    /// It is neither PGM nor PNG.
    #[error("is neither PGM (P5, P2) nor PNG; convert the image")]
    UnknownFormat,
    /// Its header is damaged.
    #[error("its PGM header is damaged; it must be P5 or P2, width, height and 255")]
    Header,
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
    /// It announces another size than it has.
    #[error("announces {width} x {height} pixels but does not hold them; copy the file anew")]
    Size {
        /// Pixels a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A sample is no number or larger than the largest that the header allows.
    #[error("has a pixel that is no number or above the header's largest; save the map again")]
    Sample,
    /// It is interlaced.
    #[error("is an interlaced PNG; save it without interlacing")]
    Interlaced,
    /// The PNG decoder gave up.
    #[error("is a damaged PNG ({}); save the map again", one_line(.0.to_string()))]
    Png(#[from] png::DecodingError),
}
