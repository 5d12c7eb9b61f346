//! Charts as PNG and SVG.
//!
//! | type | shows |
//! |---|---|
//! | [`LineChart`] | values over an axis of numbers, with intervals shaded |
//! | [`BarChart`] | values of groups side by side |
//! | [`Histogram`] | how many values fall into each bin |
//! | [`Plan`] | layers of lines, points and areas on a plane, to scale: tracks, obstacles, maps |
//!
//! Each chart's `write` puts a PNG of 1600 × 1000 pixels and an SVG of the same drawing in place,
//! whole or not at all. One function draws both, by the crate `plotters`.
//!
//! Any data give a picture: values that are not finite are left out, a single value gets an axis
//! around it, and no value at all gives the text *no data*. The same data give the same bytes: the
//! font is part of the program. Colours are those of Okabe and Ito, which colour-blind people can
//! distinguish.
//!
//! Memory: 24 MB for the pixels.

mod charts;
mod frame;
mod plan;

pub use charts::{BarChart, BarSeries, Histogram, Line, LineChart, Sample, Span};
pub use frame::Axis;
pub use plan::{Ink, Layer, Plan};

#[cfg(test)]
mod tests {
    //! Properties of every chart, for any data, read from its SVG.

    use super::frame::{Draw, SIZE, pixels, svg, width};
    use super::*;
    use crate::export::OutDir;
    use proptest::prelude::*;

    fn line_chart(lines: Vec<Line>, shaded: Vec<Span>) -> LineChart {
        LineChart {
            title: "Error of the map over time".into(),
            x: Axis::new("time", "s"),
            y: Axis::new("error", "mm"),
            lines,
            shaded,
        }
    }

    fn bar_chart(groups: &[&str], bars: Vec<BarSeries>) -> BarChart {
        BarChart {
            title: "Missed obstacle cells by method".into(),
            y: Axis::new("missed", "%"),
            groups: groups.iter().map(|&group| group.to_owned()).collect(),
            bars,
        }
    }

    fn histogram(bin_width: f64, samples: Vec<Sample>) -> Histogram {
        Histogram {
            title: "Error of the distance".into(),
            x: Axis::new("error", "mm"),
            y: Axis::counting("readings"),
            bin_width,
            samples,
        }
    }

    fn sample(name: &str, values: &[f64]) -> Sample {
        Sample {
            name: name.into(),
            values: values.to_vec(),
        }
    }

    fn plan(ink: Ink, run: &[(f64, f64)]) -> Plan {
        let obstacle = vec![vec![(2.0, 0.0), (3.0, 0.0), (3.0, 1.0), (2.0, 1.0)]];
        Plan {
            title: "plan".into(),
            layers: vec![
                Layer::new(
                    "obstacle",
                    Ink::Obstacle,
                    if run.is_empty() { vec![] } else { obstacle },
                ),
                Layer::new("layer", ink, vec![run.to_vec()]),
            ],
        }
    }

    /// One element of an SVG document: its tag, its attributes, and its text.
    #[derive(Debug)]
    struct Element {
        tag: String,
        text: String,
    }

    impl Element {
        /// The elements of a document.
        fn all(svg: &str) -> Vec<Self> {
            let mut elements: Vec<Self> = Vec::new();
            for line in svg.lines() {
                match elements.last_mut() {
                    Some(last) if !line.starts_with('<') => last.text += line,
                    _ if line.starts_with("</") => {}
                    _ => elements.push(Self {
                        tag: line.to_owned(),
                        text: String::new(),
                    }),
                }
            }
            elements
        }

        fn is(&self, name: &str) -> bool {
            self.tag.starts_with(&format!("<{name} "))
        }

        fn get(&self, attribute: &str) -> &str {
            let (_, rest) = self.tag.split_once(&format!(" {attribute}=\"")).unwrap();
            rest.split_once('"').unwrap().0
        }

        fn number(&self, attribute: &str) -> f64 {
            self.get(attribute).parse().unwrap()
        }

        /// The points of a line or an area, or the corners of a rectangle.
        fn points(&self) -> Vec<(f64, f64)> {
            if self.is("rect") {
                let (x, y) = (self.number("x"), self.number("y"));
                return vec![
                    (x, y),
                    (x + self.number("width"), y + self.number("height")),
                ];
            }
            let points = self.get("points").split_ascii_whitespace();
            let point = |text: &str| {
                let (x, y) = text.split_once(',').unwrap();
                (x.parse().unwrap(), y.parse().unwrap())
            };
            points.map(point).collect()
        }

        /// The box around a text: left, top, right, bottom.
        fn extent(&self) -> [f64; 4] {
            let [x, y, em] = ["x", "y", "font-size"].map(|name| self.number(name));
            let escapes = [
                ("&lt;", "<"),
                ("&gt;", ">"),
                ("&quot;", "\""),
                ("&apos;", "'"),
                ("&amp;", "&"),
            ];
            let shown = escapes.iter().fold(self.text.clone(), |text, (escape, c)| {
                text.replace(escape, c)
            });
            let wide = f64::from(width(&shown, em.round() as i32));
            let before = match self.get("text-anchor") {
                "start" => 0.0,
                "middle" => wide / 2.0,
                _ => wide,
            };
            // The anchor is at the top of the letters, or in their middle.
            let above = if self.get("dy") == "0.76em" {
                0.0
            } else {
                em / 2.0
            };
            if self.tag.contains("rotate") {
                [x - above, y - wide + before, x - above + em, y + before]
            } else {
                [x - before, y - above, x - before + wide, y - above + em]
            }
        }
    }

    fn contains_text(svg: &str, text: &str) -> bool {
        Element::all(svg).iter().any(|element| element.text == text)
    }

    /// No text is cut off by the picture's edge or lies on another, and every point is within it.
    fn assert_legible(name: &str, svg: &str) {
        assert!(!svg.contains("NaN"), "{name}");
        let elements = Element::all(svg);
        let (wide, high) = (f64::from(SIZE.0), f64::from(SIZE.1));
        let texts = elements.iter().filter(|element| element.is("text"));
        let texts: Vec<_> = texts.map(Element::extent).collect();
        for (number, a) in texts.iter().enumerate() {
            let inside = a[0] >= 0.0 && a[1] >= 0.0 && a[2] <= wide && a[3] <= high;
            assert!(inside, "{name}: a text at {a:?} is cut off");
            for b in &texts[..number] {
                let apart = a[2] <= b[0] || b[2] <= a[0] || a[3] <= b[1] || b[3] <= a[1];
                assert!(apart, "{name}: texts at {a:?} and {b:?} overlap");
            }
        }
        let shapes = ["polyline", "polygon", "rect"];
        let shapes = elements
            .iter()
            .filter(|element| shapes.iter().any(|tag| element.is(tag)));
        for (x, y) in shapes.flat_map(Element::points) {
            let within = (0.0..=wide).contains(&x) && (0.0..=high).contains(&y);
            assert!(within, "{name}: ({x}, {y})");
        }
    }

    /// A chart of each kind, as reports have them.
    fn usual() -> (LineChart, BarChart, Histogram, Plan) {
        let lines = ["bayes", "robust", "trimmed", "median", "expected"];
        let lines = lines.into_iter().zip(0..5).map(|(name, number)| {
            let wave = |x: f64| (x, 40.0 + 30.0 * (x / 3.0 + f64::from(number) * 0.4).sin());
            let points: Vec<_> = (0..100).map(|x| wave(f64::from(x) / 5.0)).collect();
            let band = points
                .iter()
                .map(|point| (point.1 - 6.0, point.1 + 9.0))
                .collect();
            let line = Line::new(name, points);
            match number {
                0 => line.with_band(band),
                4 => line.dashed(),
                _ => line,
            }
        });
        let bars = |name: &str, values: [f64; 4]| BarSeries {
            name: name.into(),
            values: values.map(Some).to_vec(),
            errors: Some(values.map(|value| value / 8.0).to_vec()),
        };
        let bars = vec![
            bars("no fault", [23.0, 43.0, 24.0, 24.0]),
            bars("one stuck far", [75.0, 58.0, 38.0, 38.0]),
        ];
        let samples = vec![
            sample("A0_0", &[-4.0, 0.0, 1.0, 13.0]),
            sample("A1_1", &[8.0, 12.0]),
        ];
        let square = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0), (0.0, 0.0)];
        (
            line_chart(lines.collect(), many_spans(1)),
            bar_chart(&["bayes", "robust", "trimmed", "median"], bars),
            histogram(5.0, samples),
            plan(Ink::Solid, &square),
        )
    }

    #[test]
    fn usual_charts_are_legible() {
        let (lines, bars, histogram, plan) = usual();
        for svg in [svg(&lines), svg(&bars), svg(&histogram), svg(&plan)] {
            let svg = svg.unwrap();
            assert_legible("usual", &svg);
            assert!(!contains_text(&svg, "no data"));
        }
    }

    #[test]
    fn unusual_charts_are_legible() {
        const NAN: f64 = f64::NAN;
        const MAX: f64 = f64::MAX;
        let check = |name: &str, chart: &dyn Fn() -> std::io::Result<String>, empty: bool| {
            let svg = chart().unwrap();
            assert_legible(name, &svg);
            assert_eq!(contains_text(&svg, "no data"), empty, "{name}");
        };
        let named = |n: u32| Line::new(&format!("line {n} \u{0}\n<&>"), vec![(0.0, n.into())]);
        let many = (0..90).map(named).collect();
        check(
            "many lines",
            &|| svg(&line_chart(Vec::clone(&many), vec![])),
            false,
        );
        check("no line", &|| svg(&line_chart(vec![], vec![])), true);
        for (points, empty) in [
            (&[][..], true),
            (&[(NAN, 1.0), (1.0, f64::INFINITY)], true),
            (&[(3.0, 4.0)], false),
            (&[(0.0, 1.0), (1.0, 2.0), (2.0, NAN), (3.0, 1.0)], false),
            (&[(2.0, 7.0), (2.0, 7.0)], false),
            (&[(-MAX, -MAX), (MAX, MAX)], false),
            (&[(0.0, 0.0), (5e-324, 5e-324)], false),
            (&[(0.0, 1e15), (1.0, 1e15 + 0.125)], false),
            (&[(0.0, 1e6), (1e6, 1e6 + 1.5)], false),
        ] {
            let chart = line_chart(vec![Line::new("only", points.to_vec())], vec![]);
            check(&format!("line {points:?}"), &|| svg(&chart), empty);
        }
        let long = "an endless title ".repeat(100);
        let titled = LineChart {
            title: long.clone(),
            x: Axis::new(&long, "s"),
            y: Axis::new(&long, "mm"),
            lines: vec![],
            shaded: vec![Span {
                from: 1.0,
                to: 0.0,
                label: long,
            }],
        };
        check("a long title", &|| svg(&titled), true);
        for (values, empty) in [
            (&[][..], true),
            (&[None, Some(NAN)], true),
            (&[Some(-3.0)], false),
            (&[Some(MAX), Some(-MAX)], false),
        ] {
            let series = BarSeries {
                name: "only".into(),
                values: values.to_vec(),
                errors: Some(vec![NAN, MAX]),
            };
            let chart = bar_chart(&["one", "two"], vec![series]);
            check(&format!("bars {values:?}"), &|| svg(&chart), empty);
        }
        let groups: Vec<String> = (0..60).map(|n| format!("a group named {n}")).collect();
        let groups: Vec<&str> = groups.iter().map(String::as_str).collect();
        check("many groups", &|| svg(&bar_chart(&groups, vec![])), true);
        check("no group", &|| svg(&bar_chart(&[], vec![])), true);
        check("no sample", &|| svg(&histogram(1.0, vec![])), true);
        for (values, empty) in [
            (&[][..], true),
            (&[NAN], true),
            (&[4.0], false),
            (&[-MAX, 0.0, MAX], false),
            (&[-199.0, 0.0, 199.0], false),
        ] {
            let chart = histogram(1.0, vec![sample("only", values)]);
            check(&format!("bins {values:?}"), &|| svg(&chart), empty);
        }
        for (ink, run, empty) in [
            (Ink::Dots, &[][..], true),
            (Ink::Dots, &[(NAN, 0.0)], false),
            (Ink::Solid, &[(1.0, 0.0)], false),
            (Ink::Dashed, &[(0.0, NAN), (MAX, 1.0), (1.0, 1.0)], false),
            (Ink::Thin, &[(MAX, -MAX), (-MAX, MAX)], false),
            (Ink::Cells, &[(0.0, 0.0), (MAX, 0.0), (0.0, MAX)], false),
        ] {
            check(&format!("plan {run:?}"), &|| svg(&plan(ink, run)), empty);
        }
    }

    #[test]
    fn equal_data_give_equal_bytes() {
        fn bytes(chart: &impl Draw) -> (Vec<u8>, String) {
            let pixels = pixels(chart).unwrap().into_raw();
            assert!(pixels.iter().any(|&byte| byte < 200));
            (pixels, svg(chart).unwrap())
        }
        let all = || {
            let (lines, bars, histogram, plan) = usual();
            [bytes(&lines), bytes(&bars), bytes(&histogram), bytes(&plan)]
        };
        let first = all();
        assert!(first == all());
        assert!(first[0].0 != first[1].0 && first[0].1 != first[1].1);
    }

    #[test]
    fn both_files_are_written() {
        let folder = tempfile::tempdir().unwrap();
        let out = OutDir::create(folder.path()).unwrap();
        let chart = line_chart(vec![Line::new("a", vec![(0.0, 0.0), (1.0, 1.0)])], vec![]);
        let [png, svg] = chart.write(&out, "chart").unwrap();
        let path = |name: &str| folder.path().join(name);
        assert_eq!((&png, &svg), (&path("chart.png"), &path("chart.svg")));
        assert_eq!(image::image_dimensions(png).unwrap(), (1600, 1000));
        let svg = std::fs::read_to_string(svg).unwrap();
        assert!(svg.starts_with("<svg width=\"1600\" height=\"1000\" viewBox=\"0 0 3200 2000\""));
        assert!(svg.ends_with("</svg>\n"));
        assert!(contains_text(&svg, "time (s)") && contains_text(&svg, "error (mm)"));
        assert!(chart.write(&out, "no/folder").is_err());
    }

    #[test]
    fn several_series_have_a_legend() {
        let lines = |count: u8| {
            let line = |n: u8| Line::new(&format!("line {n}"), vec![(0.0, n.into()), (1.0, 0.0)]);
            svg(&line_chart((0..count).map(line).collect(), vec![])).unwrap()
        };
        assert!(!contains_text(&lines(1), "line 0"));
        assert!(contains_text(&lines(2), "line 0") && contains_text(&lines(2), "line 1"));
        // The legend leaves room for the data.
        assert!(!contains_text(&lines(200), "line 199"));
    }

    #[test]
    fn ticks_of_counts_are_whole() {
        for count in [1, 2, 3, 9, 40] {
            let chart = histogram(1.0, vec![sample("a", &vec![0.0; count])]);
            let elements = Element::all(&svg(&chart).unwrap());
            let labels = elements.iter().filter(|one| one.is("text"));
            let labels = labels.filter(|one| one.get("text-anchor") == "end");
            let ticks: Vec<f64> = labels.map(|one| one.text.parse().unwrap()).collect();
            let whole = ticks.iter().all(|tick| tick.fract() == 0.0);
            assert!(ticks.len() >= 2 && whole, "{ticks:?}");
        }
    }

    /// Intervals that overlap, follow each other, and have no length.
    fn many_spans(count: u32) -> Vec<Span> {
        let span = |number: u32| {
            let from = f64::from(number * 7 % 20);
            Span {
                from,
                to: from + f64::from(number % 5) * 2.0,
                label: format!("fault of sensor {number}"),
            }
        };
        (1..=count).map(span).collect()
    }

    #[test]
    fn intervals_have_a_bar_or_are_counted() {
        for (count, more) in [(2, None), (8, None), (30, Some("and 22 more"))] {
            let line = Line::new("only", vec![(0.0, 0.0), (20.0, 1.0)]);
            let svg = svg(&line_chart(vec![line], many_spans(count))).unwrap();
            assert_legible("spans", &svg);
            assert!(contains_text(&svg, "fault of sensor 2"));
            assert!(more.is_none_or(|more| contains_text(&svg, more)));
        }
    }

    #[test]
    fn square_is_drawn_as_a_square() {
        let square = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0), (0.0, 0.0)];
        let elements = Element::all(&svg(&plan(Ink::Solid, &square)).unwrap());
        let shapes = |tag: &str, count: usize| {
            let mut shapes = elements
                .iter()
                .filter(|element| element.is(tag))
                .map(Element::points);
            shapes.find(|points| points.len() == count).unwrap()
        };
        for points in [shapes("polyline", 5), shapes("polygon", 4)] {
            let pairs = points.iter().zip(points.iter().cycle().skip(1));
            let sides = pairs.map(|(a, b)| (a.0 - b.0).hypot(a.1 - b.1));
            let sides: Vec<f64> = sides.filter(|side| *side > 0.0).collect();
            assert!(sides.len() == 4 && sides[0] > 200.0, "{sides:?}");
            assert!(
                sides.iter().all(|side| (side - sides[0]).abs() <= 2.0),
                "{sides:?}"
            );
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn any_points_have_a_chart(
            points in prop::collection::vec((any::<f64>(), any::<f64>()), 0..5),
            band in prop::collection::vec((any::<f64>(), any::<f64>()), 0..5),
            span in (any::<f64>(), any::<f64>()),
            name in ".{0,12}",
        ) {
            let line = Line::new(&name, points).with_band(band);
            let span = Span { from: span.0, to: span.1, label: name };
            let chart = line_chart(vec![line.clone(), line.dashed()], vec![span]);
            assert_legible("any", &svg(&chart).unwrap());
        }
    }
}
