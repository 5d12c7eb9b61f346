//! Faults as they are written: `KIND:SENSOR[=VALUE][@FROM[..TO]]`.
//!
//! | kind | value | default | meaning |
//! |---|---|---|---|
//! | `stuck-far` | – | – | says *no object* |
//! | `stuck-near` | a length | `250mm` | says that distance |
//! | `noise` | a percentage of the range | `20%` | uniform error of echoes |
//! | `output-noise` | a percentage of the range | `20%` | the same, *no object* being the farthest distance |
//! | `bias` | a length, may be negative | `200mm` | constant error |
//! | `scale` | a factor | `0.6` | multiplies the distance |
//! | `random` | – | – | any distance of the range |
//! | `dropout` | a percentage of the readings | `50%` | does not answer |
//! | `chatter` | a whole number from 2 | `4` | reports that many times as often |
//! | `intermittent` | another kind, `noise=30%` | none | that kind, in bursts |
//!
//! SENSOR is a number from 1 or a name. FROM and TO are both readings of that sensor, counted from
//! 0 (`@0..50`), or both times (`@3s..8s`); FROM is within, TO is not, and without TO there is no
//! end. The defaults are the samples of the command line's help: open choices, large enough to see.

use super::{Defect, Factor, Fault, SpecError, Times, Window};
use crate::quantity::{self, Excerpt, Percentage, QuantityError, SignedMillimeters};
use certainty_core::sensor::SensorId;
use certainty_core::units::Millimeters;
use core::fmt;
use core::str::FromStr;

/// Which sensor a fault is of: its number, or what it is called.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SensorName {
    /// Its number, from 1.
    Number(SensorId),
    /// Its name, such as `FL`: a letter, then letters, digits, `_` and `-`.
    Name(String),
}

impl SensorName {
    /// Returns the sensor that is meant among those called `names`, in the order of their numbers.
    ///
    /// A sensor without a name has an empty one. Names are told apart by case.
    ///
    /// # Errors
    ///
    /// [`SpecError::NoSuchSensor`] lists the sensors there are.
    pub fn resolve<N: AsRef<str>>(&self, names: &[N]) -> Result<SensorId, SpecError> {
        let slot = match self {
            Self::Number(number) => Some(number.slot()).filter(|&slot| slot < names.len()),
            Self::Name(name) => names.iter().position(|n| n.as_ref() == name),
        };
        slot.and_then(SensorId::from_slot)
            .ok_or_else(|| SpecError::NoSuchSensor {
                sensor: Excerpt::new(&self.to_string()),
                there_are: there_are(names),
            })
    }
}

/// The sensors there are, for an error message.
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

/// A fault and the sensor it is of.
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
    /// Which sensor has it.
    pub sensor: SensorName,
    /// What is wrong and when.
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
    /// Writes the fault with `of` behind its kind.
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

/// A fault's parts as they are written, whatever kinds there are.
#[derive(Debug)]
pub(crate) struct Parts<'t> {
    /// What is wrong.
    pub(crate) kind: &'t str,
    /// With whom.
    pub(crate) sensor: SensorName,
    /// How much.
    pub(crate) value: Option<&'t str>,
    /// When.
    pub(crate) window: Window,
}

impl<'t> Parts<'t> {
    /// Takes `KIND:SENSOR[=VALUE][@FROM[..TO]]` apart.
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

/// Deals the faults out: the list at a sensor's slot holds its faults, in the order given.
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

fn parse_sensor(text: &str) -> Result<SensorName, SpecError> {
    let bad = || SpecError::BadSensor {
        sensor: Excerpt::new(text),
    };
    if text.starts_with(|c: char| c.is_ascii_digit()) {
        let number = text.parse::<u8>().ok().and_then(SensorId::try_new);
        return number.map(SensorName::Number).ok_or_else(bad);
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

/// What a value that was left out means.
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

/// A value with a unit, or what stands for it where it was left out.
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
mod tests;
