//! Faults as they are written: `KIND:SENSOR[=VALUE][@FROM[..TO]]`.
//!
//! | kind | value | default | meaning |
//! |---|---|---|---|
//! | `stuck-far` | – | – | every reading is *no object* |
//! | `stuck-near` | a length | `250mm` | every reading is that distance |
//! | `noise` | a percentage of the range | `20%` | uniform error of echoes |
//! | `output-noise` | a percentage of the range | `20%` | the same, with *no object* as the farthest distance |
//! | `bias` | a length, may be negative | `200mm` | constant error |
//! | `scale` | a factor | `0.6` | multiplies the distance |
//! | `random` | – | – | any distance of the range |
//! | `dropout` | a percentage of the readings | `50%` | readings that are missing |
//! | `chatter` | a whole number from 2 | `4` | reports that many times as often |
//! | `intermittent` | another kind, `noise=30%` | none | that kind, coming and going |
//!
//! SENSOR is a number from 1 or a name. FROM and TO are both readings of that sensor, counted from
//! 0 (`@0..50`), or both times (`@3s..8s`); FROM is within, TO is not, and without TO there is no
//! end. The defaults are the samples of the command line's help: open choices, large enough to see.

use super::defect::{Defect, Factor, Fault, Times, Window};
use crate::quantity::{self, Excerpt, Percentage, QuantityError, SignedMillimeters};
use certainty_core::sensor::SensorId;
use certainty_core::units::Millimeters;
use core::fmt;
use core::str::FromStr;
use thiserror::Error;

/// The kinds, as errors list them.
const KINDS: &str = "stuck-far, stuck-near, noise, output-noise, bias, scale, random, dropout, \
                     chatter or intermittent";

/// The further kinds of a bench.
const WIRE_KINDS: &str = "line-high, line-low, line-floating, unplugged, cut-short, mute, \
                          servo-jammed, servo-off, motor-dead, motor-weak, slip or motor-off";

/// Why a text is no fault, or a fault has no sensor; displays as one line with an example.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum SpecError {
    /// No colon between kind and sensor.
    #[error(
        "'{text}' names no sensor: write KIND:SENSOR[=VALUE][@FROM[..TO]], for example stuck-far:2"
    )]
    NoSensor {
        /// The text.
        text: Excerpt,
    },
    /// A kind that does not exist.
    #[error("unknown fault '{kind}': write {KINDS}, for example stuck-far:2")]
    UnknownKind {
        /// The text.
        kind: Excerpt,
    },
    /// A kind that neither sensors nor a bench have.
    #[error("unknown fault '{kind}': write {KINDS}, {WIRE_KINDS}, for example stuck-far:2")]
    UnknownWireKind {
        /// The text.
        kind: Excerpt,
    },
    /// Neither a number from 1 to 255 nor a name.
    #[error(
        "'{sensor}' is no sensor: write a number up to 65535 or a name, for example stuck-far:2"
    )]
    BadSensor {
        /// The text.
        sensor: Excerpt,
    },
    /// A sensor that does not exist.
    #[error("no sensor '{sensor}': {there_are}")]
    NoSuchSensor {
        /// The text.
        sensor: Excerpt,
        /// The sensors that exist.
        there_are: String,
    },
    /// A motor that does not exist.
    #[error("no motor '{motor}': write right or left, for example motor-dead:left")]
    NoSuchMotor {
        /// The text.
        motor: Excerpt,
    },
    /// A value for a kind that has none.
    #[error("{kind} takes no value: write {kind}:{of} without '={value}'")]
    NoValue {
        /// The kind.
        kind: &'static str,
        /// A sensor or motor for the example.
        of: &'static str,
        /// The text.
        value: Excerpt,
    },
    /// A value that is no quantity with the unit of the kind.
    #[error("{kind}: {source}, for example {example}")]
    Quantity {
        /// The kind.
        kind: &'static str,
        /// What is wrong with the value.
        source: QuantityError,
        /// A valid fault.
        example: &'static str,
    },
    /// A number outside the range of the kind.
    #[error("{kind}: '{value}' is not {allowed}, for example {example}")]
    BadValue {
        /// The kind.
        kind: &'static str,
        /// The text.
        value: Excerpt,
        /// The valid values.
        allowed: &'static str,
        /// A valid fault.
        example: &'static str,
    },
    /// An intermittent fault without a kind, or intermittent twice.
    #[error("intermittent needs another kind as its value, for example intermittent:1=stuck-far")]
    IntermittentWhat,
    /// A window that is neither readings nor times.
    #[error(
        "'@{window}' is no window: write two readings or two times, for example @0..50 or @3s..8s"
    )]
    BadWindow {
        /// The text.
        window: Excerpt,
    },
    /// A window that ends before it starts, or at its start.
    #[error(
        "'@{window}' is empty: its end is not within, so it must be above its start, for example @0..50"
    )]
    EmptyWindow {
        /// The text.
        window: Excerpt,
    },
}

impl SpecError {
    /// The error for a value of a sensor's kind that takes none.
    pub(crate) fn no_value(kind: &'static str, value: &str) -> Self {
        Self::no_value_of(kind, "2", value)
    }

    /// The error for a value of a kind that takes none; `of` is a sensor or motor for the example.
    pub(crate) fn no_value_of(kind: &'static str, of: &'static str, value: &str) -> Self {
        Self::NoValue {
            kind,
            of,
            value: Excerpt::new(value),
        }
    }
}

/// The number or the name of a sensor that has a fault.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SensorName {
    /// Its number: from 1, or as a recording has it.
    Number(u16),
    /// Its name, such as `FL`: a letter, then letters, digits, `_` and `-`.
    Name(String),
}

impl SensorName {
    /// Returns the sensor with this number or name; `names` are those of all sensors, in the order of their
    /// numbers.
    ///
    /// A sensor without a name has an empty one. Names are case-sensitive.
    ///
    /// # Errors
    ///
    /// [`SpecError::NoSuchSensor`] lists the sensors that exist.
    pub fn resolve<N: AsRef<str>>(&self, names: &[N]) -> Result<SensorId, SpecError> {
        let slot = match self {
            Self::Number(number) => usize::from(*number)
                .checked_sub(1)
                .filter(|&slot| slot < names.len()),
            Self::Name(name) => names.iter().position(|n| n.as_ref() == name),
        };
        slot.and_then(SensorId::from_slot)
            .ok_or_else(|| SpecError::NoSuchSensor {
                sensor: Excerpt::new(&self.to_string()),
                there_are: there_are(names),
            })
    }
}

/// The sensors that exist, for an error message.
fn there_are<N: AsRef<str>>(names: &[N]) -> String {
    const MOST: usize = 32;
    let named: Vec<&str> = names
        .iter()
        .map(AsRef::as_ref)
        .filter(|name| !name.is_empty())
        .take(MOST)
        .collect();
    let numbers = match names.len() {
        0 => return "there is none".to_owned(),
        1 => "there is sensor 1".to_owned(),
        most => format!("there are sensors 1 to {most}"),
    };
    if named.is_empty() {
        numbers
    } else {
        format!("{numbers} ({})", named.join(", "))
    }
}

impl fmt::Display for SensorName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => number.fmt(f),
            Self::Name(name) => f.write_str(name),
        }
    }
}

/// A fault and its sensor.
///
/// ```
/// use certainty_sim::fault::FaultSpec;
///
/// let spec: FaultSpec = "stuck-near:2@3s..8s".parse()?;
/// assert_eq!(spec.to_string(), "stuck-near:2=250mm@3000ms..8000ms");
/// assert_eq!(
///     "stuck:2".parse::<FaultSpec>().unwrap_err().to_string(),
///     "unknown fault 'stuck': write stuck-far, stuck-near, noise, output-noise, bias, scale, \
///      random, dropout, chatter or intermittent, for example stuck-far:2"
/// );
/// # Ok::<(), certainty_sim::fault::SpecError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct FaultSpec {
    /// The sensor.
    pub sensor: SensorName,
    /// The defect, and when it is active.
    pub fault: Fault,
}

impl fmt::Display for FaultSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.fault.write(f, format_args!(":{}", self.sensor))
    }
}

impl fmt::Display for Fault {
    /// Writes the fault as a [`FaultSpec`] does, without its sensor.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f, format_args!(""))
    }
}

impl Fault {
    /// Writes the fault with `of` after its kind.
    fn write(&self, f: &mut fmt::Formatter<'_>, of: fmt::Arguments<'_>) -> fmt::Result {
        let Self {
            defect,
            intermittent,
            window,
        } = self;
        if *intermittent {
            write!(f, "intermittent{of}={}", defect.kind())?;
        } else {
            write!(f, "{}{of}", defect.kind())?;
        }
        defect.write_value(f, '=')?;
        fmt::Display::fmt(window, f)
    }
}

impl FromStr for FaultSpec {
    type Err = SpecError;

    fn from_str(text: &str) -> Result<Self, SpecError> {
        let Parts {
            kind,
            sensor,
            value,
            window,
        } = Parts::split(text)?;
        let intermittent = kind == "intermittent";
        let defect = if intermittent {
            let inner = value.ok_or(SpecError::IntermittentWhat)?;
            let (kind, value) = match inner.split_once('=') {
                Some((kind, value)) => (kind, Some(value)),
                None => (inner, None),
            };
            if matches!(kind, "intermittent" | "") {
                return Err(SpecError::IntermittentWhat);
            }
            parse_defect(kind, value)?
        } else {
            parse_defect(kind, value)?
        };
        Ok(Self {
            sensor,
            fault: Fault {
                defect,
                intermittent,
                window,
            },
        })
    }
}

/// The parts of a written fault, of any kind.
#[derive(Debug)]
pub(crate) struct Parts<'t> {
    /// The kind.
    pub(crate) kind: &'t str,
    /// The sensor or motor.
    pub(crate) sensor: SensorName,
    /// The value.
    pub(crate) value: Option<&'t str>,
    /// When.
    pub(crate) window: Window,
}

impl<'t> Parts<'t> {
    /// Splits `KIND:SENSOR[=VALUE][@FROM[..TO]]` into its parts.
    pub(crate) fn split(text: &'t str) -> Result<Self, SpecError> {
        let text = text.trim();
        let (kind, rest) = text.split_once(':').ok_or_else(|| SpecError::NoSensor {
            text: Excerpt::new(text),
        })?;
        let (rest, window) = match rest.split_once('@') {
            Some((rest, window)) => (rest, parse_window(window)?),
            None => (rest, Window::Always),
        };
        let (sensor, value) = match rest.split_once('=') {
            Some((sensor, value)) => (sensor, Some(value)),
            None => (rest, None),
        };
        Ok(Self {
            kind,
            sensor: parse_sensor(sensor)?,
            value,
            window,
        })
    }
}

/// Assigns faults to sensors: the list at a sensor's slot holds its faults, in the order given.
///
/// # Errors
///
/// [`SpecError::NoSuchSensor`] for a fault of a sensor that is not among `names`.
pub fn assign<N: AsRef<str>>(
    specs: &[FaultSpec],
    names: &[N],
) -> Result<Vec<Vec<Fault>>, SpecError> {
    let mut faults = vec![Vec::new(); names.len()];
    for spec in specs {
        let slot = spec.sensor.resolve(names)?.slot();
        if let Some(of_sensor) = faults.get_mut(slot) {
            of_sensor.push(spec.fault);
        }
    }
    Ok(faults)
}

/// Assigns faults to the sensors of a recording, which are named by `numbers`, ascending.
///
/// # Errors
///
/// [`SpecError::NoSuchSensor`] for a fault of a sensor that is not among `numbers`.
pub fn assign_by_number(
    specs: &[FaultSpec],
    numbers: &[u16],
) -> Result<Vec<Vec<Fault>>, SpecError> {
    const MOST: usize = 16;
    let mut faults = vec![Vec::new(); numbers.len()];
    for spec in specs {
        let slot = match &spec.sensor {
            SensorName::Number(number) => numbers.binary_search(number).ok(),
            SensorName::Name(_) => None,
        };
        let Some(of_sensor) = slot.and_then(|slot| faults.get_mut(slot)) else {
            let mut all: Vec<String> = numbers.iter().take(MOST).map(u16::to_string).collect();
            if numbers.len() > MOST {
                all.push("…".to_owned());
            }
            return Err(SpecError::NoSuchSensor {
                sensor: Excerpt::new(&spec.sensor.to_string()),
                there_are: format!("the recording has {}", all.join(", ")),
            });
        };
        of_sensor.push(spec.fault);
    }
    Ok(faults)
}

fn parse_sensor(text: &str) -> Result<SensorName, SpecError> {
    let bad = || SpecError::BadSensor {
        sensor: Excerpt::new(text),
    };
    if text.starts_with(|c: char| c.is_ascii_digit()) {
        return text.parse().map(SensorName::Number).map_err(|_| bad());
    }
    let is_name = text.starts_with(|c: char| c.is_ascii_alphabetic())
        && text
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'));
    if is_name {
        Ok(SensorName::Name(text.to_owned()))
    } else {
        Err(bad())
    }
}

/// The values of kinds that are written without one.
const STUCK_NEAR_AT: Millimeters = Millimeters::new(250);
const BIAS_BY: SignedMillimeters = SignedMillimeters::new(200);

fn parse_defect(kind: &str, value: Option<&str>) -> Result<Defect, SpecError> {
    let of_range = Percentage::try_new(20.0).unwrap_or_default();
    let of_readings = Percentage::try_new(50.0).unwrap_or_default();
    match kind {
        "stuck-far" => valueless(Defect::StuckFar, value),
        "random" => valueless(Defect::Random, value),
        "stuck-near" => measured(
            ("stuck-near", "stuck-near:2=250mm"),
            value,
            STUCK_NEAR_AT,
            quantity::length,
        )
        .map(Defect::StuckNear),
        "noise" => measured(
            ("noise", "noise:1=20%"),
            value,
            of_range,
            quantity::percentage,
        )
        .map(Defect::Noise),
        "output-noise" => measured(
            ("output-noise", "output-noise:1=20%"),
            value,
            of_range,
            quantity::percentage,
        )
        .map(Defect::OutputNoise),
        "bias" => measured(
            ("bias", "bias:3=200mm"),
            value,
            BIAS_BY,
            quantity::signed_length,
        )
        .map(Defect::Bias),
        "dropout" => measured(
            ("dropout", "dropout:1=50%"),
            value,
            of_readings,
            quantity::percentage,
        )
        .map(Defect::Dropout),
        "scale" => {
            let value = value.unwrap_or("0.6");
            let factor = value.parse().ok().and_then(Factor::try_new);
            factor
                .map(Defect::Scale)
                .ok_or_else(|| SpecError::BadValue {
                    kind: "scale",
                    value: Excerpt::new(value),
                    allowed: "a factor from 0 to 1000",
                    example: "scale:1=0.6",
                })
        }
        "chatter" => {
            let value = value.unwrap_or("4");
            let times = value.parse().ok().and_then(Times::try_new);
            times
                .map(Defect::Chatter)
                .ok_or_else(|| SpecError::BadValue {
                    kind: "chatter",
                    value: Excerpt::new(value),
                    allowed: "a whole number from 2 to 1000",
                    example: "chatter:2=4",
                })
        }
        _ => Err(SpecError::UnknownKind {
            kind: Excerpt::new(kind),
        }),
    }
}

fn valueless(defect: Defect, value: Option<&str>) -> Result<Defect, SpecError> {
    match value {
        None => Ok(defect),
        Some(value) => Err(SpecError::no_value(defect.kind(), value)),
    }
}

/// Parses a value with a unit; `default` where there is none.
fn measured<T>(
    (kind, example): (&'static str, &'static str),
    value: Option<&str>,
    default: T,
    parse: fn(&str) -> Result<T, QuantityError>,
) -> Result<T, SpecError> {
    value.map_or(Ok(default), |value| {
        parse(value).map_err(|source| SpecError::Quantity {
            kind,
            source,
            example,
        })
    })
}

fn parse_window(text: &str) -> Result<Window, SpecError> {
    let bad = || SpecError::BadWindow {
        window: Excerpt::new(text),
    };
    let (from, to) = match text.split_once("..") {
        Some((from, to)) => (from, Some(to)),
        None => (text, None),
    };
    let count = |text: &str| {
        Some(text)
            .filter(|t| t.bytes().all(|b| b.is_ascii_digit()))
            .and_then(|t| t.parse::<u64>().ok())
    };
    let (window, empty) = if let Some(from) = count(from) {
        let to = to.map(|to| count(to).ok_or_else(bad)).transpose()?;
        let empty = to.is_some_and(|to| to <= from);
        (Window::Readings { from, to }, empty)
    } else {
        let time = |text| quantity::duration(text).map_err(|_| bad());
        let from = time(from)?;
        let to = to.map(time).transpose()?;
        let empty = to.is_some_and(|to| to.get() <= from.get());
        (Window::Times { from, to }, empty)
    };
    if empty {
        return Err(SpecError::EmptyWindow {
            window: Excerpt::new(text),
        });
    }
    Ok(window)
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::units::Ticks;
    use proptest::prelude::*;

    fn spec(text: &str) -> FaultSpec {
        text.parse().unwrap_or_else(|e| panic!("{text}: {e}"))
    }

    #[test]
    fn every_kind_has_its_value() {
        let share = |percent| Percentage::try_new(percent).unwrap();
        for (text, defect) in [
            ("stuck-far:1", Defect::StuckFar),
            (
                "stuck-near:1=30cm",
                Defect::StuckNear(Millimeters::new(300)),
            ),
            ("noise:1=5%", Defect::Noise(share(5.0))),
            ("output-noise:1=5%", Defect::OutputNoise(share(5.0))),
            ("bias:1=-200mm", Defect::Bias(SignedMillimeters::new(-200))),
            ("scale:1=1.5", Defect::Scale(Factor::try_new(1.5).unwrap())),
            ("random:1", Defect::Random),
            ("dropout:1=100%", Defect::Dropout(share(100.0))),
            ("chatter:1=2", Defect::Chatter(Times::try_new(2).unwrap())),
        ] {
            assert_eq!(spec(text).fault, Fault::permanent(defect), "{text}");
        }
    }

    #[test]
    fn an_omitted_value_is_the_documented_one() {
        for (short, long) in [
            ("stuck-near:1", "stuck-near:1=250mm"),
            ("noise:1", "noise:1=20%"),
            ("output-noise:1", "output-noise:1=20%"),
            ("bias:1", "bias:1=200mm"),
            ("scale:1", "scale:1=0.6"),
            ("dropout:1", "dropout:1=50%"),
            ("chatter:1", "chatter:1=4"),
            ("intermittent:1=noise", "intermittent:1=noise=20%"),
        ] {
            assert_eq!(spec(short), spec(long));
            assert_eq!(spec(short).to_string(), long);
        }
    }

    #[test]
    fn windows_are_readings_or_times() {
        let window = |text| spec(text).fault.window;
        assert_eq!(window("random:1"), Window::Always);
        assert_eq!(
            window("random:1@0..50"),
            Window::Readings {
                from: 0,
                to: Some(50)
            }
        );
        assert_eq!(window("random:1@7"), Window::Readings { from: 7, to: None });
        assert_eq!(
            window("bias:1=2cm@3s..8s"),
            Window::Times {
                from: Ticks::new(3000),
                to: Some(Ticks::new(8000))
            }
        );
        assert_eq!(
            window("intermittent:FL=scale=0.5@250ms"),
            Window::Times {
                from: Ticks::new(250),
                to: None
            }
        );
    }

    #[test]
    fn sensors_have_numbers_or_names() {
        let names = ["FL", "FR", ""];
        let slot = |text| spec(text).sensor.resolve(&names).map(SensorId::slot);
        assert_eq!(slot("random:1"), Ok(0));
        assert_eq!(slot("random:3"), Ok(2));
        assert_eq!(slot("random:FR"), Ok(1));
        assert_eq!(
            slot("random:4").unwrap_err().to_string(),
            "no sensor '4': there are sensors 1 to 3 (FL, FR)"
        );
        assert_eq!(
            slot("random:fr").unwrap_err().to_string(),
            "no sensor 'fr': there are sensors 1 to 3 (FL, FR)"
        );
    }

    #[test]
    fn faults_are_assigned_in_the_order_given() {
        let specs = ["bias:2", "random:1", "scale:FR"].map(spec);
        let dealt = assign(&specs, &["FL", "FR"]).unwrap();
        assert_eq!(dealt[0], [specs[1].fault]);
        assert_eq!(dealt[1], [specs[0].fault, specs[2].fault]);
        assert!(assign(&specs, &["FL"]).is_err());
    }

    #[test]
    fn each_error_has_its_text() {
        for (text, line) in [
            (
                "stuck-far",
                "'stuck-far' names no sensor: write KIND:SENSOR[=VALUE][@FROM[..TO]], for example stuck-far:2",
            ),
            (
                "stuck-far:65536",
                "'65536' is no sensor: write a number up to 65535 or a name, for example stuck-far:2",
            ),
            (
                "stuck-far:",
                "'' is no sensor: write a number up to 65535 or a name, for example stuck-far:2",
            ),
            (
                "stuck-far:1=5",
                "stuck-far takes no value: write stuck-far:2 without '=5'",
            ),
            (
                "stuck-near:1=5",
                "stuck-near: '5' has no unit: write a length such as 100mm, 35cm or 8m, for example stuck-near:2=250mm",
            ),
            (
                "noise:1=20",
                "noise: '20' has no unit: write a percentage such as 20%, for example noise:1=20%",
            ),
            (
                "output-noise:1=20",
                "output-noise: '20' has no unit: write a percentage such as 20%, for example output-noise:1=20%",
            ),
            (
                "dropout:1=120%",
                "dropout: '120%' is too large: at most 100%, for example dropout:1=50%",
            ),
            (
                "scale:1=-1",
                "scale: '-1' is not a factor from 0 to 1000, for example scale:1=0.6",
            ),
            (
                "scale:1=nan",
                "scale: 'nan' is not a factor from 0 to 1000, for example scale:1=0.6",
            ),
            (
                "chatter:1=1",
                "chatter: '1' is not a whole number from 2 to 1000, for example chatter:2=4",
            ),
            (
                "intermittent:1",
                "intermittent needs another kind as its value, for example intermittent:1=stuck-far",
            ),
            (
                "intermittent:1=intermittent",
                "intermittent needs another kind as its value, for example intermittent:1=stuck-far",
            ),
            (
                "random:1@",
                "'@' is no window: write two readings or two times, for example @0..50 or @3s..8s",
            ),
            (
                "random:1@3s..",
                "'@3s..' is no window: write two readings or two times, for example @0..50 or @3s..8s",
            ),
            (
                "random:1@3..8s",
                "'@3..8s' is no window: write two readings or two times, for example @0..50 or @3s..8s",
            ),
            (
                "random:1@8..8",
                "'@8..8' is empty: its end is not within, so it must be above its start, for example @0..50",
            ),
            (
                "random:1@9s..8s",
                "'@9s..8s' is empty: its end is not within, so it must be above its start, for example @0..50",
            ),
        ] {
            let error = text.parse::<FaultSpec>().unwrap_err();
            assert_eq!(error.to_string(), line, "{text}");
        }
    }

    fn any_defect() -> impl Strategy<Value = Defect> {
        let share = || (0.0..=100.0_f64).prop_map(|p| Percentage::try_new(p).unwrap());
        prop_oneof![
            Just(Defect::StuckFar),
            (0..=1_u32 << 28).prop_map(|mm| Defect::StuckNear(Millimeters::new(mm))),
            share().prop_map(Defect::Noise),
            share().prop_map(Defect::OutputNoise),
            (-(1 << 28)..=1_i32 << 28).prop_map(|mm| Defect::Bias(SignedMillimeters::new(mm))),
            (0.0..=1000.0_f64).prop_map(|f| Defect::Scale(Factor::try_new(f).unwrap())),
            Just(Defect::Random),
            share().prop_map(Defect::Dropout),
            (2..=1000_u32).prop_map(|n| Defect::Chatter(Times::try_new(n).unwrap())),
        ]
    }

    fn any_window() -> impl Strategy<Value = Window> {
        prop_oneof![
            Just(Window::Always),
            (any::<u32>(), prop::option::of(1..1000_u64)).prop_map(|(from, length)| {
                let from = u64::from(from);
                Window::Readings {
                    from,
                    to: length.map(|l| from + l),
                }
            }),
            (0..1_u32 << 31, prop::option::of(1..1000_u32)).prop_map(|(from, length)| {
                Window::Times {
                    from: Ticks::new(from),
                    to: length.map(|l| Ticks::new(from + l)),
                }
            }),
        ]
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_back_to_the_bit(
            number: u16,
            name in prop::option::of("[A-Za-z][A-Za-z0-9_-]{0,6}"),
            defect in any_defect(),
            intermittent in any::<bool>(),
            window in any_window(),
        ) {
            let number = SensorName::Number(number);
            let spec = FaultSpec {
                sensor: name.map_or(number, SensorName::Name),
                fault: Fault { defect, intermittent, window },
            };
            prop_assert_eq!(spec.to_string().parse(), Ok(spec));
        }

        #[test]
        fn no_text_panics_and_every_complaint_is_one_line(
            text in "(stuck-near|noise|intermittent|\\PC{0,5})?:?\\PC{0,3}(=\\PC{0,6})?(@\\PC{0,6}(\\.\\.)?\\PC{0,3})?",
            raw in any::<String>(),
        ) {
            for text in [text, raw] {
                if let Err(error) = text.parse::<FaultSpec>() {
                    prop_assert_eq!(error.to_string().lines().count(), 1);
                }
            }
        }
    }
}
