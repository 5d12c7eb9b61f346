//! World files: TOML in which every length carries its unit.
//!
//! A file names a world and lists its obstacles as `[[box]]`, `[[disc]]` and `[[wall]]` tables;
//! [`SMART_CAR`](super::SMART_CAR) is a sample. What is wrong with a file is said in one line that
//! starts with `file:line`.

use super::{Obstacle, ObstacleError, World};
use crate::quantity::{self, QuantityError, SignedMillimeters};
use crate::toml_file::{self, TomlError, TomlFile};
use certainty_core::units::{BinaryAngle, Millimeters, Point};
use core::fmt;
use core::ops::Range;
use serde::de::{self, Deserialize, Deserializer, Visitor};
use std::path::Path;
use toml::Spanned;

/// What the file is called in errors.
const WHAT: &str = "world file";

/// How thick a wall is that does not say.
const WALL_THICKNESS: Millimeters = Millimeters::new(20);

/// What a world file must hold at the least.
const SAMPLE: &str = r#"[[disc]] center = ["0mm", "500mm"] radius = "80mm", on three lines"#;

impl World {
    /// Reads the world file at `path`.
    ///
    /// # Errors
    ///
    /// [`TomlError`] says in one line which file and line are wrong and what to do.
    pub fn load(path: &Path) -> Result<Self, TomlError> {
        Self::parse(&toml_file::read(path, WHAT)?, &path.display().to_string())
    }

    /// Reads a world from the bytes of a world file, which errors call `file`.
    ///
    /// ```
    /// use certainty_sim::world::World;
    ///
    /// let text = br#"
    ///     name = "corner"
    ///     [[wall]]
    ///     from = ["0mm", "1m"]
    ///     to = ["1m", "1m"]
    /// "#;
    /// assert_eq!(World::parse(text, "corner.toml")?.obstacles().len(), 1);
    ///
    /// let wrong = World::parse(b"[[disc]]\ncenter = [\"0mm\", \"1m\"]\nradius = \"8\"", "disc.toml");
    /// assert_eq!(
    ///     wrong.unwrap_err().to_string(),
    ///     "disc.toml:3: '8' has no unit: write a length such as 100mm, 35cm or 8m"
    /// );
    /// # Ok::<(), certainty_sim::toml_file::TomlError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`TomlError::Invalid`] names the line and what to do.
    pub fn parse(bytes: &[u8], file: &str) -> Result<Self, TomlError> {
        let file = TomlFile {
            file,
            bytes,
            what: WHAT,
            sample: SAMPLE,
        };
        let parsed: WorldFile = file.parse()?;
        let obstacles = parsed
            .obstacles()
            .map_err(|(at, e)| file.invalid(at.start, e.to_string()))?;
        if obstacles.is_empty() {
            let problem = format!("the world has no obstacle: add for example: {SAMPLE}");
            return Err(file.invalid(bytes.len(), problem));
        }
        Ok(Self::new(
            parsed.name.unwrap_or_else(|| file.file.to_owned()),
            obstacles,
        ))
    }
}

/// A world file as it is written.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct WorldFile {
    name: Option<String>,
    #[serde(default, rename = "box")]
    boxes: Vec<Spanned<BoxTable>>,
    #[serde(default, rename = "disc")]
    discs: Vec<Spanned<DiscTable>>,
    #[serde(default, rename = "wall")]
    walls: Vec<Spanned<WallTable>>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct BoxTable {
    center: [Coordinate; 2],
    size: Spanned<[Length; 2]>,
    rotation: Option<Angle>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct DiscTable {
    center: [Coordinate; 2],
    radius: Spanned<Length>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct WallTable {
    from: [Coordinate; 2],
    to: [Coordinate; 2],
    thickness: Option<Length>,
}

impl WorldFile {
    /// The obstacles: boxes, discs, walls; or what is wrong, and in which bytes.
    fn obstacles(&self) -> Result<Vec<Obstacle>, (Range<usize>, ObstacleError)> {
        let boxes = self.boxes.iter().map(|table| {
            let entry = table.get_ref();
            let [width, height] = entry.size.get_ref();
            let rotation = entry.rotation.as_ref().map_or(BinaryAngle::ZERO, |r| r.0);
            Obstacle::rectangle(point(&entry.center), (width.0, height.0), rotation)
                .map_err(|e| (entry.size.span(), e))
        });
        let discs = self.discs.iter().map(|table| {
            let entry = table.get_ref();
            Obstacle::disc(point(&entry.center), entry.radius.get_ref().0)
                .map_err(|e| (entry.radius.span(), e))
        });
        let walls = self.walls.iter().map(|table| {
            let entry = table.get_ref();
            let thickness = entry.thickness.as_ref().map_or(WALL_THICKNESS, |t| t.0);
            Obstacle::wall(point(&entry.from), point(&entry.to), thickness)
                .map_err(|e| (table.span(), e))
        });
        boxes.chain(discs).chain(walls).collect()
    }
}

/// The place of two coordinates; they are within [`Point::LIMIT`] or were not read.
fn point([x, y]: &[Coordinate; 2]) -> Point {
    Point::from_mm(x.0.get(), y.0.get())
}

#[derive(Debug)]
struct Coordinate(SignedMillimeters);

#[derive(Debug)]
struct Length(Millimeters);

#[derive(Debug)]
struct Angle(BinaryAngle);

/// Hands a string to a quantity's parser, so that its complaint gets the place.
struct Written<T> {
    /// What is expected, for what is no string.
    expected: &'static str,
    parse: fn(&str) -> Result<T, QuantityError>,
}

impl<T> Visitor<'_> for Written<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.expected)
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<T, E> {
        (self.parse)(text).map_err(E::custom)
    }
}

/// A length that may be below zero, as a coordinate is.
const SIGNED_LENGTH: Written<SignedMillimeters> = Written {
    expected: r#"a length in quotes, such as "-200mm" or "8m""#,
    parse: quantity::signed_length,
};

const LENGTH: Written<Millimeters> = Written {
    expected: r#"a length in quotes, such as "100mm" or "8m""#,
    parse: quantity::length,
};

const ANGLE: Written<BinaryAngle> = Written {
    expected: r#"an angle in quotes, such as "15deg""#,
    parse: quantity::angle,
};

impl<'de> Deserialize<'de> for Coordinate {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_str(SIGNED_LENGTH).map(Self)
    }
}

impl<'de> Deserialize<'de> for Length {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_str(LENGTH).map(Self)
    }
}

impl<'de> Deserialize<'de> for Angle {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_str(ANGLE).map(Self)
    }
}
