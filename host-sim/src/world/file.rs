//! World files: TOML in which every length carries its unit.
//!
//! A file names a world and lists its obstacles as `[[box]]`, `[[disc]]` and `[[wall]]` tables;
//! [`SMART_CAR`] is a sample. An error is one line that starts with
//! `file:line`.

use super::obstacle::{Obstacle, ObstacleError};
use super::scene::World;
use crate::quantity::{self, QuantityError, SignedMillimeters};
use crate::toml_file::{self, TomlError, TomlFile};
use certainty_core::units::{BinaryAngle, Millimeters, Point};
use core::fmt;
use core::ops::Range;
use serde::de::{self, Deserialize, Deserializer, Visitor};
use std::path::Path;
use toml::Spanned;

/// The world file of the built-in scene, also a sample of the format.
///
/// Modelled on \[001\] Fig. 5(a), whose layout the paper does not give in numbers.
pub const SMART_CAR: &str = include_str!("../../data/smart-car.toml");

/// The world file of the office in which `certainty ring` checks a sonar ring.
///
/// Modelled on the room in the figures of \[003\], which gives no plan of it.
pub const OFFICE: &str = include_str!("../../data/office.toml");

/// The kind of file, for errors.
const WHAT: &str = "world file";

/// The thickness of a wall without one.
const WALL_THICKNESS: Millimeters = Millimeters::new(20);

/// The smallest content of a world file, for errors.
const SAMPLE: &str = r#"[[disc]] center = ["0mm", "500mm"] radius = "80mm", on three lines"#;

impl World {
    /// Reads the world file at `path`.
    ///
    /// # Errors
    ///
    /// [`TomlError`] names the file, the line and what to do.
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

    /// Returns a furnished office of 6 m by 5 m with its lower left corner at the origin: [`OFFICE`].
    ///
    /// # Panics
    ///
    /// If the built-in file is invalid, which a test excludes.
    #[must_use]
    pub fn office() -> Self {
        Self::parse(OFFICE.as_bytes(), "office.toml").expect("the built-in office is valid")
    }

    /// Returns the scene in front of the Smart Car: [`SMART_CAR`].
    ///
    /// Units and range: obstacles in x −850..=850 mm and y 0..=1100 mm, the certainty grid of
    /// \[001\] §6.1; none within 150 mm of the sensors at the origin. Of the directions from
    /// −90° to 90° about half meet no obstacle within a GP2D02's 800 mm.
    ///
    /// # Panics
    ///
    /// If the built-in file is invalid, which a test excludes.
    #[must_use]
    pub fn built_in() -> Self {
        Self::parse(SMART_CAR.as_bytes(), "smart-car.toml").expect("the built-in world is valid")
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
    /// The obstacles: boxes, discs, walls; or the error and its bytes.
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

/// The point of two coordinates, which parsing has checked to be within [`Point::LIMIT`].
fn point([x, y]: &[Coordinate; 2]) -> Point {
    Point::from_mm(x.0.get(), y.0.get())
}

#[derive(Debug)]
struct Coordinate(SignedMillimeters);

#[derive(Debug)]
struct Length(Millimeters);

#[derive(Debug)]
struct Angle(BinaryAngle);

/// Passes a string to a quantity's parser, so that serde adds the place to its error.
struct Written<T> {
    /// What is expected, for values that are no strings.
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

/// A length that may be negative, as a coordinate.
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

#[cfg(test)]
mod tests {
    use super::super::obstacle::Bounds;
    use super::*;
    use proptest::prelude::*;

    const fn mm(mm: u32) -> Millimeters {
        Millimeters::new(mm)
    }

    const fn degrees(degrees: i32) -> BinaryAngle {
        BinaryAngle::from_millidegrees(degrees * 1000)
    }

    #[test]
    fn half_the_beams_of_the_built_in_scene_echo() {
        let world = World::built_in();
        let beams: Vec<_> = (0..=180)
            .map(|bearing| world.distance(Point::ORIGIN, degrees(bearing), mm(800)))
            .collect();
        let echoes: Vec<f64> = beams.iter().copied().flatten().collect();
        let share = echoes.len() as f64 / beams.len() as f64;
        assert!((0.4..=0.6).contains(&share), "{share} of the beams echo");
        let (least, most) = echoes
            .iter()
            .fold((f64::MAX, 0.0_f64), |(l, m), &d| (l.min(d), m.max(d)));
        assert!(least > 150.0 && least < 400.0, "nearest {least}");
        assert!(most > 550.0 && most < 800.0, "farthest {most}");
        // Left, ahead and right all have obstacles and free directions.
        for third in beams.chunks(61) {
            let echoes = third.iter().flatten().count();
            assert!((10..=50).contains(&echoes), "{echoes} of {}", third.len());
        }
    }

    #[test]
    fn the_built_in_scene_lies_on_the_grid() {
        let world = World::built_in();
        for obstacle in world.obstacles() {
            assert!(obstacle.clearance(Point::ORIGIN) > 150.0, "{obstacle:?}");
        }
        let Bounds {
            lower_left: low,
            upper_right: high,
        } = world.bounds().unwrap();
        assert!(low.x_mm() >= -850 && low.y_mm() >= 0, "{low:?}");
        assert!(high.x_mm() <= 850 && high.y_mm() <= 1100, "{high:?}");
    }

    fn error_of(text: &str) -> String {
        World::parse(text.as_bytes(), "w.toml")
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn errors_name_the_line() {
        let length = "write a length such as 100mm, 35cm or 8m";
        for (text, line) in [
            ("[[disc]]\ncenter = [\"0mm\", \"1m\"]\nradius = \"0mm\"", "w.toml:3: an obstacle needs a size above 0mm".to_owned()),
            ("\n[[box]]\ncenter = [\"0mm\", \"1m\"]\nsize = [\"1m\", \"-1m\"]", format!("w.toml:4: '-1m' is negative: {length}")),
            ("[[wall]]\nfrom = [\"1m\", \"1m\"]\nto = [\"1m\", \"1m\"]", "w.toml:1: a wall must end elsewhere than it starts".to_owned()),
            ("[[disc]]\nradius = \"1m\"\ncenter = [\"0mm\", \"300000m\"]", "w.toml:3: '300000m' is too large: at most 268435456mm".to_owned()),
            ("name = \"void\"\n", "w.toml:2: the world has no obstacle: add for example: [[disc]] center = [\"0mm\", \"500mm\"] radius = \"80mm\", on three lines".to_owned()),
        ] {
            assert_eq!(error_of(text), line);
        }
        let unknown =
            error_of("[[disc]]\ncenter = [\"0mm\", \"1m\"]\nradius = \"1m\"\ncolour = \"red\"");
        assert!(
            unknown.starts_with("w.toml:4: unknown field `colour`"),
            "{unknown}"
        );
        let bare = error_of("[[disc]]\ncenter = [0, 1]\nradius = \"1m\"");
        assert!(
            bare.starts_with("w.toml:2: invalid type: integer"),
            "{bare}"
        );
        assert!(
            bare.ends_with(r#"expected a length in quotes, such as "-200mm" or "8m""#),
            "{bare}"
        );
        for (text, part) in [
            (
                "[[disc]]\ncenter = [\"0mm\", \"1m\"]\nradius = 80",
                "w.toml:3: invalid type: integer `80`, expected a length in quotes, such as \"100mm\" or \"8m\"",
            ),
            (
                "[[box]]\ncenter = [\"0mm\", \"1m\"]\nsize = [\"1m\", \"1m\"]\nrotation = 1.5",
                "w.toml:4: invalid type: floating point `1.5`, expected an angle in quotes, such as \"15deg\"",
            ),
            (
                "disc = 5",
                "w.toml:1: invalid type: integer `5`, expected a sequence; write for example: [[disc]] center",
            ),
            (
                "[[disc]]\ncenter = [\"0mm\"]\nradius = \"1m\"",
                "write for example: [[disc]] center = [\"0mm\", \"500mm\"]",
            ),
        ] {
            let error = error_of(text);
            assert!(error.contains(part), "{error}");
        }
        let missing = error_of("name = \"x\"\n[[disc]]\nradius = \"1m\"");
        assert!(
            missing.starts_with("w.toml:2: missing field `center`"),
            "{missing}"
        );
        assert!(error_of("name = \"a\"\n=").starts_with("w.toml:2: "));
        let latin = World::parse(b"name = \"x\"\n# \xFF", "w.toml").unwrap_err();
        assert_eq!(
            latin.to_string(),
            "w.toml:2: not UTF-8 text; a world file is TOML"
        );
    }

    #[test]
    fn a_missing_file_is_named() {
        let error = World::load(Path::new("no/such/world.toml")).unwrap_err();
        let line = error.to_string();
        assert!(
            line.starts_with("no/such/world.toml: cannot read the world file: "),
            "{line}"
        );
        assert_eq!(line.lines().count(), 1);
    }

    #[test]
    fn an_endless_file_is_refused() {
        let endless = Path::new("/dev/zero");
        if endless.exists() {
            assert!(matches!(
                World::load(endless),
                Err(TomlError::TooLong { .. })
            ));
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        #[test]
        fn no_bytes_panic_and_errors_are_one_line(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            if let Err(error) = World::parse(&bytes, "w.toml") {
                prop_assert_eq!(error.to_string().lines().count(), 1);
            }
        }

        #[test]
        fn no_damaged_file_panics(at in 0..SMART_CAR.len(), bytes in prop::collection::vec(any::<u8>(), 0..6), cut in 0..6_usize) {
            let mut file = SMART_CAR.as_bytes().to_vec();
            let end = (at + cut).min(file.len());
            file.splice(at..end, bytes);
            match World::parse(&file, "w.toml") {
                Ok(world) => prop_assert!(!world.obstacles().is_empty()),
                Err(error) => prop_assert!(error.to_string().starts_with("w.toml:")),
            }
        }
    }
}
