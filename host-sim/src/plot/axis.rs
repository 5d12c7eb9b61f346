//! Axes: their titles, their ranges, and their ticks.

use core::ops::Range;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged};

/// What an axis shows, its unit, and how far it reaches.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    title: String,
    from: Option<f64>,
    to: Option<f64>,
    /// A value that the axis reaches in any case.
    including: Option<f64>,
}

impl Axis {
    /// Creates an axis of `quantity` in `unit`: "error", "mm" is written *error (mm)*.
    ///
    /// ```
    /// use certainty_sim::plot::Axis;
    ///
    /// assert_eq!(Axis::new("error", "mm").title(), "error (mm)");
    /// assert_eq!(Axis::counting("readings").title(), "readings");
    /// ```
    #[must_use]
    pub fn new(quantity: &str, unit: &str) -> Self {
        Self::titled(format!("{quantity} ({unit})"))
    }

    /// Creates an axis of counts of `things`, or of numbers without unit.
    ///
    /// It does not always begin at 0; see [`Self::including`].
    #[must_use]
    pub fn counting(things: &str) -> Self {
        Self::titled(things.to_owned())
    }

    const fn titled(title: String) -> Self {
        Self {
            title,
            from: None,
            to: None,
            including: None,
        }
    }

    /// Begins the axis at `value` whatever the data; smaller values are drawn at its beginning.
    #[must_use]
    pub fn from(self, value: f64) -> Self {
        Self {
            from: Some(value).filter(|value| value.is_finite()),
            ..self
        }
    }

    /// Ends the axis at `value` whatever the data; larger values are drawn at its end.
    #[must_use]
    pub fn to(self, value: f64) -> Self {
        Self {
            to: Some(value).filter(|value| value.is_finite()),
            ..self
        }
    }

    /// Extends the axis to `value`, such as 0, if the data do not reach it.
    #[must_use]
    pub fn including(self, value: f64) -> Self {
        Self {
            including: Some(value).filter(|value| value.is_finite()),
            ..self
        }
    }

    /// Returns the text at the axis.
    #[must_use]
    pub fn title(&self) -> &str {
        &self.title
    }
}

/// A mark on an axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    pub value: f64,
    pub text: String,
}

/// The numbers along an axis, or the names of its equal parts.
///
/// Possession proves that its ends and their difference are finite, and that the first is less.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scale {
    low: f64,
    high: f64,
    pub ticks: Vec<Tick>,
    of_names: bool,
}

/// The largest value of which differences are finite.
const LARGEST: f64 = 1e300;

impl Scale {
    /// The scale that shows `values`, with about `aim` ticks at round numbers; it ends at ticks
    /// unless the axis sets its ends.
    pub(super) fn covering(axis: &Axis, values: impl Iterator<Item = f64>, aim: u32) -> Self {
        let values = values.chain(axis.including).filter(|v| v.is_finite());
        let span = values.fold(None, |span: Option<(f64, f64)>, value| {
            let (low, high) = span.unwrap_or((value, value));
            Some((low.min(value), high.max(value)))
        });
        let (low, high) = match (span, axis.from, axis.to) {
            (Some(span), ..) => span,
            (None, Some(from), None) => (from, from + 1.0),
            (None, None, Some(to)) => (to - 1.0, to),
            (None, ..) => (0.0, 1.0),
        };
        let bounded = |value: f64| value.clamp(-LARGEST, LARGEST);
        let low = bounded(axis.from.unwrap_or(low));
        let high = bounded(axis.to.unwrap_or(high));
        let (low, high) = widened(low, high);
        let step = round_step((high - low) / f64::from(aim));
        // Ends within a thousandth of a step of a tick are at the tick.
        let first = match axis.from {
            Some(_) => (low / step - 1e-3).ceil(),
            None => (low / step + 1e-3).floor(),
        };
        let last = match axis.to {
            Some(_) => (high / step + 1e-3).floor(),
            None => (high / step - 1e-3).ceil(),
        };
        let low = axis.from.map_or(first * step, |_| low);
        let high = axis.to.map_or(last * step, |_| high);
        let count = (last - first).clamp(0.0, 100.0) as u32;
        let ticks = (0..=count).map(|number| {
            // Adding zero turns −0 into 0.
            let value = (first + f64::from(number)) * step + 0.0;
            Tick {
                value,
                text: tick_text(value, step, low.abs().max(high.abs())),
            }
        });
        let ticks = ticks.collect();
        let (low, high) = widened(low, high);
        Self {
            low,
            high,
            ticks,
            of_names: false,
        }
    }

    /// A scale from 0 to the number of `names`, each in the middle of its part.
    pub(super) fn of_names(names: &[String]) -> Self {
        let ticks = names.iter().enumerate().map(|(number, name)| Tick {
            value: number as f64 + 0.5,
            text: name.clone(),
        });
        Self {
            low: 0.0,
            high: names.len().max(1) as f64,
            ticks: ticks.collect(),
            of_names: true,
        }
    }

    /// Whether the ticks are names.
    pub(super) const fn is_of_names(&self) -> bool {
        self.of_names
    }

    /// How far along the axis `value` is, from 0 to 1; values beyond are at the end.
    pub(super) fn part(&self, value: f64) -> f64 {
        ((value.clamp(-2.0 * LARGEST, 2.0 * LARGEST) - self.low) / (self.high - self.low))
            .clamp(0.0, 1.0)
    }

    /// The first value of the axis.
    pub(super) const fn low(&self) -> f64 {
        self.low
    }
}

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (from, to): (i32, i32)) -> i32 {
        from + (self.part(*value) * f64::from(to - from)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _hint: Hint) -> Vec<f64> {
        self.ticks.iter().map(|tick| tick.value).collect()
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

/// The ends, moved apart if they are closer than a billionth of their size.
fn widened(low: f64, high: f64) -> (f64, f64) {
    let (low, high) = (low.min(high), low.max(high));
    let size = low.abs().max(high.abs());
    if high - low > size * 1e-9 {
        return (low, high);
    }
    let margin = if size == 0.0 { 0.5 } else { size / 10.0 };
    (low - margin, high + margin)
}

/// The next of 1, 2 and 5 times a power of ten.
fn round_step(at_least: f64) -> f64 {
    let power = 10.0_f64.powi(at_least.log10().floor() as i32);
    let factors = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    let next = factors.into_iter().find(|step| *step >= at_least * 0.999);
    next.filter(|step| step.is_normal())
        .unwrap_or(f64::MIN_POSITIVE.max(at_least))
}

/// A tick's number, with enough digits to distinguish it from its neighbours.
fn tick_text(value: f64, step: f64, largest: f64) -> String {
    let digits = |of: f64| of.log10().floor() as i32;
    let text = if value == 0.0 {
        "0".to_owned()
    } else if largest >= 1e6 || step < 1e-4 {
        let kept = (digits(value.abs()) - digits(step * 1.001)).clamp(0, 17);
        format!("{value:.*e}", kept.unsigned_abs() as usize)
    } else {
        let decimals = (-digits(step * 1.001)).max(0);
        format!("{value:.*}", decimals.unsigned_abs() as usize)
    };
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ticks(axis: &Axis, values: &[f64]) -> Vec<String> {
        let scale = Scale::covering(axis, values.iter().copied(), 5);
        scale.ticks.into_iter().map(|tick| tick.text).collect()
    }

    #[test]
    fn ticks_are_round_and_enclose_values() {
        let axis = Axis::new("distance", "mm");
        for (values, expected) in [
            (&[0.0, 1.0][..], "0.0 0.2 0.4 0.6 0.8 1.0"),
            (&[3.0, 97.0], "0 20 40 60 80 100"),
            (&[-7.0, 12.0], "−10 −5 0 5 10 15"),
            (&[0.0, 0.3], "0.0 0.1 0.2 0.3"),
            (&[5.0], "4.4 4.6 4.8 5.0 5.2 5.4 5.6"),
            (&[0.0], "−0.6 −0.4 −0.2 0.0 0.2 0.4 0.6"),
            (&[], "0.0 0.2 0.4 0.6 0.8 1.0"),
            (&[f64::NAN, f64::INFINITY], "0.0 0.2 0.4 0.6 0.8 1.0"),
            (&[0.0, 4e6], "0 1e6 2e6 3e6 4e6"),
            (&[0.0, 2.5e-5], "0 5e−6 1.0e−5 1.5e−5 2.0e−5 2.5e−5"),
        ] {
            let expected: Vec<String> = expected
                .split(' ')
                .map(|text| {
                    let plain: Result<f64, _> = text.replace('−', "-").parse();
                    let zero = plain.is_ok_and(|value| value == 0.0);
                    if zero {
                        "0".to_owned()
                    } else {
                        text.to_owned()
                    }
                })
                .collect();
            assert_eq!(ticks(&axis, values), expected, "{values:?}");
        }
    }

    #[test]
    fn an_axis_with_set_ends_ends_there() {
        let axis = Axis::new("share", "%").from(0.0).to(90.0);
        let scale = Scale::covering(&axis, [40.0, 400.0].into_iter(), 5);
        assert_eq!(scale.part(0.0), 0.0);
        assert_eq!(scale.part(90.0), 1.0);
        assert_eq!(scale.part(400.0), 1.0);
        assert_eq!(scale.part(-1.0), 0.0);
        assert_eq!(ticks(&axis, &[40.0]), ["0", "20", "40", "60", "80"]);
        let reaching = Axis::new("share", "%").including(0.0);
        assert_eq!(ticks(&reaching, &[40.0]), ["0", "10", "20", "30", "40"]);
    }

    proptest! {
        #[test]
        fn any_values_have_an_axis(
            values in prop::collection::vec(any::<f64>(), 0..4),
            from in any::<f64>(),
            to in any::<f64>(),
            given in 0..4_u8,
        ) {
            let axis = Axis::new("x", "1");
            let axis = if given & 1 > 0 { axis.from(from) } else { axis };
            let axis = if given & 2 > 0 { axis.to(to) } else { axis };
            let scale = Scale::covering(&axis, values.iter().copied(), 5);
            prop_assert!(scale.low < scale.high && (scale.high - scale.low).is_finite());
            prop_assert!(scale.ticks.len() <= 101);
            for value in values.into_iter().filter(|value| value.is_finite()) {
                prop_assert!((0.0..=1.0).contains(&scale.part(value)), "{value}");
            }
        }
    }
}
