//! What holds for every chart, whatever the data.

use super::font;
use super::picture::{Anchor, HEIGHT, Picture, Shape, WIDTH};
use super::{Axis, BarChart, BarSeries, Histogram, Line, LineChart, Sample, Span, raster, svg};
use crate::export::OutDir;
use proptest::prelude::*;
use std::fs;

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

/// A chart of each kind as reports have them.
fn usual() -> [(&'static str, Picture); 3] {
    let wave = |shift: f64| {
        let at = move |number: u32| {
            let x = f64::from(number) / 5.0;
            (x, 40.0 + 30.0 * (x / 3.0 + shift).sin())
        };
        (0..100).map(at).collect::<Vec<_>>()
    };
    let band = |points: &[(f64, f64)]| points.iter().map(|p| (p.1 - 6.0, p.1 + 9.0)).collect();
    let lines = ["bayes", "robust", "trimmed", "median", "expected"];
    let lines = lines.into_iter().zip(0_u8..).map(|(name, number)| {
        let points = wave(f64::from(number) * 0.4);
        let band = band(&points);
        let line = Line::new(name, points);
        match number {
            0 => line.with_band(band),
            4 => line.dashed(),
            _ => line,
        }
    });
    let fault = Span {
        from: 5.0,
        to: 12.0,
        label: "fault of sensor 1".into(),
    };
    let bars = |name: &str, values: [f64; 4]| BarSeries {
        name: name.into(),
        values: values.map(Some).to_vec(),
        errors: Some(values.map(|value| value / 8.0).to_vec()),
    };
    let spread = |scale: f64, shift: f64| -> Vec<f64> {
        let value = |n: u32| (f64::from(n) * 0.7).sin() + (f64::from(n) * 1.3).cos();
        (0..300).map(|n| shift + scale * value(n)).collect()
    };
    [
        ("lines", line_chart(lines.collect(), vec![fault]).picture()),
        (
            "bars",
            bar_chart(
                &["bayes", "robust", "trimmed", "median"],
                vec![
                    bars("all sound", [23.0, 43.0, 24.0, 24.0]),
                    bars("one stuck far", [75.0, 58.0, 38.0, 38.0]),
                ],
            )
            .picture(),
        ),
        (
            "histogram",
            histogram(
                5.0,
                vec![
                    sample("A0_0", &spread(14.0, 0.0)),
                    sample("A1_1", &spread(8.0, 12.0)),
                    sample("A2_2", &spread(20.0, -9.0)),
                ],
            )
            .picture(),
        ),
    ]
}

/// Charts whose data are as bad as data can be.
fn unusual() -> Vec<(&'static str, Picture)> {
    const NAN: f64 = f64::NAN;
    const MAX: f64 = f64::MAX;
    let line = |points: &[(f64, f64)]| {
        line_chart(vec![Line::new("only", points.to_vec())], vec![]).picture()
    };
    let bar = |values: &[Option<f64>]| {
        let bars = BarSeries {
            name: "only".into(),
            values: values.to_vec(),
            errors: Some(vec![NAN, MAX]),
        };
        bar_chart(&["one", "two"], vec![bars]).picture()
    };
    let bins = |values: &[f64]| histogram(1.0, vec![sample("only", values)]).picture();
    let many: Vec<String> = (0..60).map(|n| format!("a group named {n}")).collect();
    let many: Vec<&str> = many.iter().map(String::as_str).collect();
    let named = |n: u32| Line::new(&format!("line {n} \u{0}\n<&>"), vec![(0.0, n.into())]);
    let long = "an endless title ".repeat(100);
    vec![
        ("no line", line_chart(vec![], vec![]).picture()),
        ("an empty line", line(&[])),
        ("no number", line(&[(NAN, 1.0), (1.0, f64::INFINITY)])),
        ("a point", line(&[(3.0, 4.0)])),
        (
            "a gap",
            line(&[(0.0, 1.0), (1.0, 2.0), (2.0, NAN), (3.0, 1.0)]),
        ),
        ("all equal", line(&[(2.0, 7.0), (2.0, 7.0)])),
        ("huge", line(&[(-MAX, -MAX), (MAX, MAX)])),
        ("tiny", line(&[(0.0, 0.0), (5e-324, 5e-324)])),
        (
            "next to each other",
            line(&[(0.0, 1e15), (1.0, 1e15 + 0.125)]),
        ),
        ("no group", bar_chart(&[], vec![]).picture()),
        ("no bar", bar(&[])),
        ("absent bars", bar(&[None, Some(NAN)])),
        ("one bar", bar(&[Some(-3.0)])),
        ("huge bars", bar(&[Some(MAX), Some(-MAX)])),
        ("many groups", bar_chart(&many, vec![]).picture()),
        ("no sample", histogram(1.0, vec![]).picture()),
        ("no values", bins(&[])),
        ("no number to count", bins(&[NAN])),
        ("one value", bins(&[4.0])),
        ("equal values", bins(&[4.0; 50])),
        ("far apart", bins(&[-MAX, 0.0, MAX])),
        (
            "narrow bins",
            histogram(
                1.0,
                vec![
                    sample("one", &[-199.0, 0.0, 7.0]),
                    sample("two", &[1.0, 7.0, 199.0]),
                ],
            )
            .picture(),
        ),
        (
            "many lines",
            line_chart((0..90).map(named).collect(), vec![]).picture(),
        ),
        (
            "a long title",
            LineChart {
                title: long.clone(),
                x: Axis::new(&long, "s"),
                y: Axis::new(&long, "mm"),
                lines: vec![],
                shaded: vec![Span {
                    from: 1.0,
                    to: 0.0,
                    label: long,
                }],
            }
            .picture(),
        ),
    ]
}

/// Intervals as many faults have them: over each other, after each other, at once.
fn many_spans() -> Vec<Span> {
    let span = |number: u32| {
        let from = f64::from(number * 7 % 20);
        Span {
            from,
            to: from + f64::from(number % 5) * 2.0,
            label: format!("fault of sensor {number}"),
        }
    };
    (0..30).map(span).collect()
}

#[test]
fn many_intervals_are_told_apart_above_the_data_and_do_not_grow_dark() {
    let lines = || vec![Line::new("only", vec![(0.0, 0.0), (20.0, 1.0)])];
    for count in [2, 3, 7, 30] {
        let spans = many_spans().into_iter().take(count).collect();
        let picture = line_chart(lines(), spans).picture();
        assert_legible("spans", &picture);
        assert_within("spans", &picture);
        let labels = picture.shapes.iter().filter_map(extent).collect::<Vec<_>>();
        let areas = picture.shapes.iter().filter_map(|shape| match shape {
            Shape::Area(points, _, opacity) => Some((points, *opacity)),
            _ => None,
        });
        let (shades, bars): (Vec<_>, Vec<_>) = areas.partition(|area| area.1 < 0.2);
        let top = shades[0].0[0].1;
        for (number, (a, _)) in shades.iter().enumerate() {
            for (b, _) in &shades[..number] {
                assert!(a[0].0 >= b[2].0 || b[0].0 >= a[2].0, "{a:?} darkens {b:?}");
            }
        }
        assert!(
            bars.iter().all(|(bar, _)| bar[2].1 <= top),
            "{count}: above the data"
        );
        assert!(bars.len() == count || says(&picture, &format!("and {} more", count - bars.len())));
        let above = labels.iter().filter(|label| label[3] <= top).count();
        // The title, and on the left the y axis's first label or two, are above it too.
        assert!(above > bars.len(), "{above} labels for {} bars", bars.len());
    }
}

fn bytes(picture: &Picture) -> (Vec<u8>, String) {
    let mut png = Vec::new();
    raster::write(picture, &mut png).unwrap();
    (png, svg::text(picture))
}

/// Where a text is: left, top, right, bottom.
fn extent(shape: &Shape) -> Option<[f64; 4]> {
    let Shape::Text(text) = shape else {
        return None;
    };
    let width = font::width(&text.content, text.size);
    let before = match text.anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => width / 2.0,
        Anchor::End => width,
    };
    let (x, y) = text.place;
    let (above, below) = (text.size * 0.76, text.size * 0.24);
    Some(if text.upwards {
        [x - above, y - width + before, x + below, y + before]
    } else {
        [x - before, y - above, x - before + width, y + below]
    })
}

/// No text is cut off by the picture's edge or lies on another.
fn assert_legible(name: &str, picture: &Picture) {
    let texts: Vec<_> = picture.shapes.iter().filter_map(extent).collect();
    for (number, a) in texts.iter().enumerate() {
        let inside =
            a[0] >= 0.0 && a[1] >= 0.0 && a[2] <= f64::from(WIDTH) && a[3] <= f64::from(HEIGHT);
        assert!(inside, "{name}: a text at {a:?} is cut off");
        for b in &texts[..number] {
            let apart = a[2] <= b[0] || b[2] <= a[0] || a[3] <= b[1] || b[3] <= a[1];
            assert!(apart, "{name}: texts at {a:?} and {b:?} overlap");
        }
    }
}

/// Every point of every shape is within the picture.
fn assert_within(name: &str, picture: &Picture) {
    for shape in &picture.shapes {
        let points = match shape {
            Shape::Line(points, _) | Shape::Area(points, ..) => points.clone(),
            Shape::Dot(place, ..) => vec![*place],
            Shape::Text(text) => vec![text.place],
        };
        for (x, y) in points {
            let within =
                (0.0..=f64::from(WIDTH)).contains(&x) && (0.0..=f64::from(HEIGHT)).contains(&y);
            assert!(within, "{name}: ({x}, {y})");
        }
    }
}

fn says(picture: &Picture, words: &str) -> bool {
    let texts = picture.shapes.iter();
    let mut texts = texts.filter_map(|shape| match shape {
        Shape::Text(text) => Some(&text.content),
        _ => None,
    });
    texts.any(|text| text == words)
}

#[test]
fn every_chart_is_legible_and_within_its_picture() {
    for (name, picture) in usual().into_iter().chain(unusual()) {
        assert_legible(name, &picture);
        assert_within(name, &picture);
    }
}

#[test]
fn charts_say_so_where_there_is_nothing_to_show() {
    for (name, picture) in unusual() {
        let nothing = [
            "no line",
            "an empty line",
            "no number",
            "no group",
            "no bar",
            "absent bars",
            "many groups",
            "no sample",
            "no values",
            "no number to count",
            "a long title",
        ];
        assert_eq!(says(&picture, "no data"), nothing.contains(&name), "{name}");
    }
}

#[test]
fn the_same_data_give_the_same_bytes_and_other_data_others() {
    let (first, again) = (usual(), usual());
    for ((name, a), (_, b)) in first.iter().zip(&again) {
        assert!(bytes(a) == bytes(b), "{name}");
    }
    let (line, bars) = (bytes(&first[0].1), bytes(&first[1].1));
    assert!(line.0 != bars.0 && line.1 != bars.1);
}

#[test]
fn both_files_are_written_and_are_what_they_are_called() {
    let folder = tempfile::tempdir().unwrap();
    let out = OutDir::create(folder.path()).unwrap();
    let chart = line_chart(vec![Line::new("a", vec![(0.0, 0.0), (1.0, 1.0)])], vec![]);
    let [png, svg] = chart.write(&out, "chart").unwrap();
    assert_eq!(
        (png, svg),
        (
            folder.path().join("chart.png"),
            folder.path().join("chart.svg")
        )
    );
    let file = fs::File::open(folder.path().join("chart.png")).unwrap();
    let reader = png::Decoder::new(std::io::BufReader::new(file));
    let info = reader.read_info().unwrap();
    assert_eq!(info.info().size(), (WIDTH, HEIGHT));
    let svg = fs::read_to_string(folder.path().join("chart.svg")).unwrap();
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    assert!(svg.contains(">time (s)<") && svg.contains(">error (mm)<"));
    assert!(chart.write(&out, "no/folder").is_err());
}

#[test]
fn there_is_a_legend_where_there_is_more_than_one_series() {
    let lines = |count: u8| {
        let line = |n: u8| Line::new(&format!("line {n}"), vec![(0.0, n.into()), (1.0, 0.0)]);
        line_chart((0..count).map(line).collect(), vec![]).picture()
    };
    assert!(!says(&lines(1), "line 0"));
    assert!(says(&lines(2), "line 0") && says(&lines(2), "line 1"));
    let many = lines(200);
    assert!(
        !says(&many, "line 199"),
        "the legend leaves room for the data"
    );
}

#[test]
fn the_ticks_of_counts_are_whole() {
    for count in [1, 2, 3, 9, 40] {
        let samples = vec![sample("a", &vec![0.0; count])];
        let picture = histogram(1.0, samples).picture();
        let ticks = picture.shapes.iter().filter_map(|shape| match shape {
            Shape::Text(text) if text.anchor == Anchor::End => Some(text.content.parse::<f64>()),
            _ => None,
        });
        let ticks: Vec<f64> = ticks.map(Result::unwrap).collect();
        assert!(
            ticks.len() >= 2 && ticks.iter().all(|tick| tick.fract() == 0.0),
            "{ticks:?}"
        );
    }
}

#[test]
fn a_histogram_counts_every_number_once() {
    let values = [-5.0, -4.999, 4.999, 5.0, 14.9, f64::NAN, 100.0];
    let counts = histogram(10.0, vec![sample("a", &values), sample("b", &[95.0])]).counts();
    let of = |sample: usize, middle: f64| {
        let mut bins = counts[sample].iter();
        bins.find(|bin| bin.0 == middle).unwrap().1
    };
    assert_eq!((of(0, 0.0), of(0, 10.0), of(0, 100.0)), (3, 2, 1));
    assert_eq!((of(1, 0.0), of(1, 100.0)), (0, 1));
    assert_eq!(counts[0].len(), 11);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_values_fall_into_bins(
        values in prop::collection::vec(any::<f64>(), 0..6),
        bin_width in any::<f64>(),
    ) {
        let finite = values.iter().filter(|value| value.is_finite()).count() as u64;
        let counts = histogram(bin_width, vec![sample("a", &values)]).counts();
        prop_assert_eq!(counts[0].iter().map(|bin| bin.1).sum::<u64>(), finite);
        prop_assert!(counts[0].len() <= Histogram::MOST_BINS);
    }

    #[test]
    fn any_points_have_a_chart(
        points in prop::collection::vec((any::<f64>(), any::<f64>()), 0..5),
        band in prop::collection::vec((any::<f64>(), any::<f64>()), 0..5),
        span in (any::<f64>(), any::<f64>()),
        name in ".{0,12}",
    ) {
        let line = Line::new(&name, points).with_band(band);
        let span = Span { from: span.0, to: span.1, label: name };
        let picture = line_chart(vec![line.clone(), line.dashed()], vec![span]).picture();
        assert_within("any", &picture);
        prop_assert!(!svg::text(&picture).contains("NaN"));
    }
}

/// Both encoders take every picture there is.
#[test]
fn unusual_data_have_files() {
    for (name, picture) in unusual() {
        let (png, svg) = bytes(&picture);
        assert!(png.len() > 1000 && svg.lines().count() > 5, "{name}");
    }
}

#[test]
fn samples_of_equal_count_do_not_hide_each_other() {
    for (width, bars) in [(10.0, 4), (0.1, 2)] {
        let values = [0.0, 30.0];
        let samples = vec![sample("a", &values), sample("b", &values)];
        let picture = histogram(width, samples).picture();
        let plot = |shape: &&Shape| matches!(shape, Shape::Area(points, ..) if points[0].1 > 800.0);
        let drawn: Vec<_> = picture.shapes.iter().filter(plot).collect();
        assert_eq!(drawn.len(), bars, "bins of {width} mm");
        for (number, shape) in drawn.iter().enumerate() {
            let opaque = matches!(shape, Shape::Area(_, _, opacity) if *opacity == 1.0);
            assert_eq!(opaque, bars == 4);
            let places = |shape: &Shape| match shape {
                Shape::Area(points, ..) => points.clone(),
                _ => vec![],
            };
            let others = &drawn[..number];
            assert!(!opaque || others.iter().all(|other| places(other) != places(shape)));
        }
    }
}
