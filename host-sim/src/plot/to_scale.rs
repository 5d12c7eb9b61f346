//! A plane to scale: axes on which a metre is as long upwards as to the right.

use super::axis::{Axis, Scale};
use super::frame::{Bottom, Frame, Sign, Words, X_TICKS, Y_TICKS};
use super::picture::Place;

/// From where to where along an axis.
pub(super) type Range = (f64, f64);

/// A frame whose two axes have the same scale, and its axes.
///
/// A unit has as many pixels across as upwards, within a thousandth: a test tries all kinds of ranges.
#[derive(Debug)]
pub(super) struct ToScale {
    pub frame: Frame,
    x: Scale,
    y: Scale,
    /// What the axes show.
    shown: [Range; 2],
}

/// So large a value that differences and margins still are finite.
const LARGEST: f64 = 1e300;

impl ToScale {
    /// Shows the plane from and to these places, a margin, and more along one axis than asked.
    pub(super) fn new(
        title: &str,
        unit: &str,
        legend: &[(String, Sign)],
        [x, y]: [Range; 2],
    ) -> Self {
        let framed = |[x, y]: [Range; 2]| {
            let axis = |name, (from, to): Range, ticks| {
                let axis = Axis::new(name, unit).from(from).to(to);
                (Scale::covering(&axis, [from, to].into_iter(), ticks), axis)
            };
            let ((x_scale, x_axis), (y_scale, y_axis)) =
                (axis("x", x, X_TICKS), axis("y", y, Y_TICKS));
            let words = Words {
                title,
                x: x_axis.title(),
                y: y_axis.title(),
                legend,
                above: 0.0,
            };
            Self {
                frame: Frame::new(words, Bottom::Numbers(&x_scale), &y_scale),
                x: x_scale,
                y: y_scale,
                shown: [x, y],
            }
        };
        let bounded = |value: f64| value.clamp(-LARGEST, LARGEST);
        let [x, y] = [x, y].map(|(from, to)| (bounded(from), bounded(to)));
        let margin = 0.05 * (x.1 - x.0).max(y.1 - y.0).max(0.1);
        let wider = |(from, to): Range| (from - margin, to + margin);
        let mut plane = framed([wider(x), wider(y)]);
        // The labels' width depends on what is shown, and what is shown on the room that they leave.
        for _ in 0..8 {
            let [across, upwards] = plane.pixels();
            if (across - upwards).abs() < 1e-3 * across.min(upwards) {
                break;
            }
            let unit = across.min(upwards);
            let [x, y] = plane.shown;
            let grown = |(from, to): Range, by: f64| {
                let (middle, half) = (f64::midpoint(from, to), (to - from) / 2.0 * by);
                (middle - half, middle + half)
            };
            plane = framed([grown(x, across / unit), grown(y, upwards / unit)]);
        }
        plane
    }

    /// How many pixels a unit has across and upwards.
    fn pixels(&self) -> [f64; 2] {
        let ((left, bottom), (right, top)) = (self.frame.at(0.0, 0.0), self.frame.at(1.0, 1.0));
        let [x, y] = self.shown;
        [(right - left) / (x.1 - x.0), (bottom - top) / (y.1 - y.0)]
    }

    /// From where to where the axes show.
    pub(super) const fn shown(&self) -> [Range; 2] {
        self.shown
    }

    /// Where a place of the plane is in the picture.
    pub(super) fn at(&self, (x, y): (f64, f64)) -> Place {
        self.frame.at(self.x.part(x), self.y.part(y))
    }
}

/// The least range along both axes that has all `places` that are some; `None` for none.
pub(super) fn around<'a>(places: impl Iterator<Item = &'a (f64, f64)>) -> Option<[Range; 2]> {
    let places = places.filter(|place| finite(place));
    places.fold(None, |range, &(x, y)| {
        let [across, upwards] = range.unwrap_or([(x, x), (y, y)]);
        Some([
            (across.0.min(x), across.1.max(x)),
            (upwards.0.min(y), upwards.1.max(y)),
        ])
    })
}

/// Whether a point is at a place.
pub(super) fn finite(&(x, y): &(f64, f64)) -> bool {
    x.is_finite() && y.is_finite()
}

/// What of the area within `outline` lies in a rectangle: its corners, none where nothing does.
///
/// Sutherland and Hodgman's: side by side, exact for convex outlines.
pub(super) fn clipped(outline: &[(f64, f64)], [x, y]: [Range; 2]) -> Vec<(f64, f64)> {
    let corners = outline.iter().filter(|place| finite(place));
    let mut corners: Vec<(f64, f64)> = corners
        .map(|&(x, y)| (x.clamp(-LARGEST, LARGEST), y.clamp(-LARGEST, LARGEST)))
        .collect();
    // Of a place how far it is within each side.
    let sides: [&dyn Fn((f64, f64)) -> f64; 4] = [
        &|place| place.0 - x.0,
        &|place| x.1 - place.0,
        &|place| place.1 - y.0,
        &|place| y.1 - place.1,
    ];
    for within in sides {
        let before = corners.iter().cycle().skip(corners.len().max(1) - 1);
        let edges = before.zip(&corners);
        let kept = edges.flat_map(|(&from, &to)| {
            let (a, b) = (within(from), within(to));
            let crossing = ((a < 0.0) != (b < 0.0)).then(|| {
                let part = a / (a - b);
                (
                    from.0 + (to.0 - from.0) * part,
                    from.1 + (to.1 - from.1) * part,
                )
            });
            crossing.into_iter().chain((b >= 0.0).then_some(to))
        });
        corners = kept.collect();
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn an_area_is_cut_where_the_rectangle_ends() {
        let range = [(0.0, 4.0), (0.0, 2.0)];
        let square = [(1.0, 1.0), (3.0, 1.0), (3.0, 3.0), (1.0, 3.0)];
        let cut = clipped(&square, range);
        assert_eq!(around(cut.iter()), Some([(1.0, 3.0), (1.0, 2.0)]));
        let within = [(1.0, 0.5), (2.0, 0.5), (2.0, 1.5)];
        let mut same = clipped(&within, range);
        let first = same.iter().position(|&at| at == within[0]);
        same.rotate_left(first.unwrap());
        assert_eq!(same, within);
        let around_all = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)];
        assert_eq!(around(clipped(&around_all, range).iter()), Some(range));
        // A rhombus whose corners all lie outside; clamped to the sides it would be another shape.
        let rhombus = [(2.0, -1.0), (5.0, 1.0), (2.0, 3.0), (-1.0, 1.0)];
        assert_eq!(clipped(&rhombus, range).len(), 8);
        for none in [
            &[][..],
            &[(5.0, 5.0), (6.0, 5.0), (6.0, 6.0)],
            &[(f64::NAN, 0.0)],
        ] {
            assert_eq!(clipped(none, range), []);
        }
    }

    proptest! {
        #[test]
        fn a_unit_is_as_long_upwards_as_across(
            x in (-1e4..1e4, 0.0..300.0),
            y in (-1e4..1e4, 0.0..300.0),
            legend in 0..4_usize,
        ) {
            let [x, y]: [Range; 2] = [x, y].map(|(from, length): Range| (from, from + length));
            let legend = vec![("a line".to_owned(), Sign::Area([0; 3], 1.0)); legend];
            let plane = ToScale::new("plane", "m", &legend, [x, y]);
            let (low, high) = (plane.at((x.0, y.0)), plane.at((x.1, y.1)));
            let [across, upwards] = plane.pixels();
            prop_assert!((across / upwards - 1.0).abs() < 1e-3, "{across} {upwards}");
            prop_assert!(((high.0 - low.0) - across * (x.1 - x.0)).abs() < 0.5);
            prop_assert!(((low.1 - high.1) - upwards * (y.1 - y.0)).abs() < 0.5);
        }

        #[test]
        fn any_ranges_have_a_plane(places in prop::collection::vec(any::<(f64, f64)>(), 0..4)) {
            let range = around(places.iter());
            prop_assert_eq!(range.is_some(), places.iter().any(finite));
            let plane = ToScale::new("any", "m", &[], range.unwrap_or_default());
            for &place in places.iter().filter(|place| finite(place)) {
                let (x, y) = plane.at(place);
                prop_assert!((0.0..=1600.0).contains(&x) && (0.0..=1000.0).contains(&y), "{x} {y}");
            }
        }
    }
}
