//! Properties of every chart, for any data.

use super::canvas::{Area, Draw, Drawn, FINE, HEIGHT, WIDTH, pixels, svg, width};
use super::{
    Axis, BarChart, BarSeries, Histogram, Ink, Layer, Line, LineChart, Plan, Sample, Span, Spot,
    TrackChart,
};
use crate::export::OutDir;
use plotters::prelude::DrawingBackend;
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

fn track(points: Vec<(f64, f64)>) -> TrackChart {
    TrackChart {
        title: "track".into(),
        unit: "m".into(),
        obstacles: vec![vec![(1.0, -2.0), (2.0, -2.0), (2.0, -1.0), (1.0, -1.0)]],
        cells: Vec::new(),
        tracks: vec![Line::new("robot", points)],
        spots: vec![Spot::new("start", (f64::NAN, 0.0))],
    }
}

fn plan(ink: Ink, run: &[(f64, f64)]) -> Plan {
    Plan {
        title: "plan".into(),
        layers: vec![Layer {
            name: "layer".into(),
            ink,
            runs: vec![run.to_vec()],
        }],
    }
}

/// One element of an SVG document: its tag, its attributes, and its text.
#[derive(Debug)]
struct Element {
    tag: String,
    text: String,
}

impl Element {
    /// The elements of a chart.
    fn all(chart: &impl Draw) -> Vec<Self> {
        let svg = svg(chart).unwrap();
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
        let (x, y, em) = (self.number("x"), self.number("y"), self.number("font-size"));
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
        let wide = width(&shown, em);
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

fn contains_text(chart: &impl Draw, text: &str) -> bool {
    Element::all(chart)
        .iter()
        .any(|element| element.text == text)
}

/// No text is cut off by the picture's edge or lies on another, and every point is within it.
fn assert_legible(name: &str, chart: &impl Draw) {
    let elements = Element::all(chart);
    let (wide, high) = (f64::from(WIDTH), f64::from(HEIGHT));
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

/// A chart of any kind.
enum Chart {
    Lines(LineChart),
    Bars(BarChart),
    Histogram(Histogram),
    Track(TrackChart),
    Plan(Plan),
}

impl Draw for Chart {
    fn draw<D: DrawingBackend>(&self, area: &Area<D>) -> Drawn<D> {
        match self {
            Self::Lines(chart) => chart.draw(area),
            Self::Bars(chart) => chart.draw(area),
            Self::Histogram(chart) => chart.draw(area),
            Self::Track(chart) => chart.draw(area),
            Self::Plan(chart) => chart.draw(area),
        }
    }
}

/// A chart of each kind, as reports have them.
fn usual() -> Vec<(&'static str, Chart)> {
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
    let bars = vec![
        bars("no fault", [23.0, 43.0, 24.0, 24.0]),
        bars("one stuck far", [75.0, 58.0, 38.0, 38.0]),
    ];
    let spread = |scale: f64, shift: f64| -> Vec<f64> {
        let value = |n: u32| (f64::from(n) * 0.7).sin() + (f64::from(n) * 1.3).cos();
        (0..300).map(|n| shift + scale * value(n)).collect()
    };
    let samples = vec![
        sample("A0_0", &spread(14.0, 0.0)),
        sample("A1_1", &spread(8.0, 12.0)),
        sample("A2_2", &spread(20.0, -9.0)),
    ];
    let methods = ["bayes", "robust", "trimmed", "median"];
    let square = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0), (0.0, 0.0)];
    let goal = Spot::new("goal", (4.0, 3.0)).within(0.5);
    vec![
        (
            "lines",
            Chart::Lines(line_chart(lines.collect(), vec![fault])),
        ),
        ("bars", Chart::Bars(bar_chart(&methods, bars))),
        ("histogram", Chart::Histogram(histogram(5.0, samples))),
        (
            "track",
            Chart::Track(TrackChart {
                spots: vec![Spot::new("start", (0.0, 0.0)), goal],
                ..track(vec![(0.0, 0.0), (4.0, 3.0)])
            }),
        ),
        ("plan", Chart::Plan(plan(Ink::Solid, &square))),
    ]
}

/// Charts of unusual data.
fn unusual() -> Vec<(&'static str, Chart)> {
    const NAN: f64 = f64::NAN;
    const MAX: f64 = f64::MAX;
    let lines = |lines| Chart::Lines(line_chart(lines, vec![]));
    let line = |points: &[(f64, f64)]| lines(vec![Line::new("only", points.to_vec())]);
    let bars = |groups: &[&str], bars| Chart::Bars(bar_chart(groups, bars));
    let bar = |values: &[Option<f64>]| {
        let series = BarSeries {
            name: "only".into(),
            values: values.to_vec(),
            errors: Some(vec![NAN, MAX]),
        };
        bars(&["one", "two"], vec![series])
    };
    let samples = |samples| Chart::Histogram(histogram(1.0, samples));
    let bins = |values: &[f64]| samples(vec![sample("only", values)]);
    let many: Vec<String> = (0..60).map(|n| format!("a group named {n}")).collect();
    let many: Vec<&str> = many.iter().map(String::as_str).collect();
    let named = |n: u32| Line::new(&format!("line {n} \u{0}\n<&>"), vec![(0.0, n.into())]);
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
    let mut nowhere = track(vec![]);
    nowhere.obstacles.clear();
    let far = vec![
        sample("one", &[-199.0, 0.0, 7.0]),
        sample("two", &[1.0, 7.0, 199.0]),
    ];
    vec![
        ("no line", lines(vec![])),
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
        ("no group", bars(&[], vec![])),
        ("no bar", bar(&[])),
        ("absent bars", bar(&[None, Some(NAN)])),
        ("one bar", bar(&[Some(-3.0)])),
        ("huge bars", bar(&[Some(MAX), Some(-MAX)])),
        ("many groups", bars(&many, vec![])),
        ("no sample", samples(vec![])),
        ("no values", bins(&[])),
        ("no number to count", bins(&[NAN])),
        ("one value", bins(&[4.0])),
        ("equal values", bins(&[4.0; 50])),
        ("far apart", bins(&[-MAX, 0.0, MAX])),
        ("narrow bins", samples(far)),
        ("many lines", lines((0..90).map(named).collect())),
        ("a long title", Chart::Lines(titled)),
        ("no track", Chart::Track(track(vec![]))),
        (
            "odd track",
            Chart::Track(track(vec![(0.0, NAN), (MAX, 1.0), (1.0, 1.0)])),
        ),
        (
            "huge track",
            Chart::Track(track(vec![(MAX, -MAX), (-MAX, MAX)])),
        ),
        ("no place", Chart::Track(nowhere)),
        ("an empty plan", Chart::Plan(plan(Ink::Dots, &[(NAN, 0.0)]))),
        ("a lone place", Chart::Plan(plan(Ink::Solid, &[(1.0, 0.0)]))),
    ]
}

#[test]
fn every_chart_is_legible() {
    for (name, chart) in usual().into_iter().chain(unusual()) {
        assert_legible(name, &chart);
    }
}

#[test]
fn charts_without_data_have_a_note() {
    for (name, chart) in unusual() {
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
            "no place",
            "an empty plan",
        ];
        let noted = contains_text(&chart, "no data");
        assert_eq!(noted, nothing.contains(&name), "{name}");
    }
}

#[test]
fn equal_data_give_equal_bytes() {
    let both = |chart: &Chart| (pixels(chart).unwrap(), svg(chart).unwrap());
    let (first, again) = (usual(), usual());
    let first: Vec<_> = first.iter().map(|(_, chart)| both(chart)).collect();
    for (one, (name, other)) in first.iter().zip(&again) {
        assert!(*one == both(other), "{name}");
        assert!(!one.1.contains("NaN"), "{name}");
    }
    assert!(first[0].0 != first[1].0 && first[0].1 != first[1].1);
}

#[test]
fn unusual_data_have_pixels() {
    for name in [
        "huge",
        "tiny",
        "a gap",
        "huge bars",
        "far apart",
        "huge track",
    ] {
        let charts = unusual();
        let (_, chart) = charts.iter().find(|chart| chart.0 == name).unwrap();
        let pixels = pixels(chart).unwrap();
        assert!(pixels.iter().any(|&byte| byte < 200), "{name}");
    }
}

#[test]
fn both_files_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = OutDir::create(folder.path()).unwrap();
    let chart = line_chart(vec![Line::new("a", vec![(0.0, 0.0), (1.0, 1.0)])], vec![]);
    let [png, svg] = chart.write(&out, "chart").unwrap();
    let path = |name: &str| folder.path().join(name);
    assert_eq!((png, svg), (path("chart.png"), path("chart.svg")));
    let file = fs::File::open(path("chart.png")).unwrap();
    let reader = png::Decoder::new(std::io::BufReader::new(file));
    let info = reader.read_info().unwrap();
    let (width, height) = (WIDTH as u32 / FINE, HEIGHT as u32 / FINE);
    assert_eq!(info.info().size(), (width, height));
    let svg = fs::read_to_string(path("chart.svg")).unwrap();
    assert!(svg.starts_with("<svg width=\"1600\" height=\"1000\" viewBox=\"0 0 3200 2000\""));
    assert!(svg.ends_with("</svg>\n"));
    assert!(contains_text(&chart, "time (s)") && contains_text(&chart, "error (mm)"));
    assert!(chart.write(&out, "no/folder").is_err());
}

#[test]
fn several_series_have_a_legend() {
    let lines = |count: u8| {
        let line = |n: u8| Line::new(&format!("line {n}"), vec![(0.0, n.into()), (1.0, 0.0)]);
        line_chart((0..count).map(line).collect(), vec![])
    };
    assert!(!contains_text(&lines(1), "line 0"));
    assert!(contains_text(&lines(2), "line 0") && contains_text(&lines(2), "line 1"));
    let many = lines(200);
    assert!(
        !contains_text(&many, "line 199"),
        "the legend leaves room for the data"
    );
}

#[test]
fn ticks_of_counts_are_whole() {
    for count in [1, 2, 3, 9, 40] {
        let chart = histogram(1.0, vec![sample("a", &vec![0.0; count])]);
        let elements = Element::all(&chart);
        let labels = elements.iter().filter(|one| one.is("text"));
        let labels = labels.filter(|one| one.get("text-anchor") == "end");
        let ticks: Vec<f64> = labels.map(|one| one.text.parse().unwrap()).collect();
        let whole = ticks.iter().all(|tick| tick.fract() == 0.0);
        assert!(ticks.len() >= 2 && whole, "{ticks:?}");
    }
}

#[test]
fn histogram_counts_every_number_once() {
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

#[test]
fn equal_samples_do_not_hide_each_other() {
    for (bin_width, shapes) in [(10.0, 4), (0.1, 2)] {
        let values = [0.0, 30.0];
        let samples = vec![sample("a", &values), sample("b", &values)];
        let elements = Element::all(&histogram(bin_width, samples));
        let low = |element: &&Element| {
            (element.is("rect") || element.is("polygon"))
                && element.points().iter().any(|point| point.1 > 1600.0)
                && element.get("fill") != "#FFFFFF"
        };
        let drawn: Vec<_> = elements.iter().filter(low).collect();
        assert_eq!(drawn.len(), shapes, "bins of {bin_width} mm");
        for (number, shape) in drawn.iter().enumerate() {
            let opaque = shape.number("opacity") == 1.0;
            assert_eq!(opaque, shapes == 4);
            let mut others = drawn[..number].iter();
            assert!(!opaque || others.all(|other| other.points() != shape.points()));
        }
    }
}

/// Intervals that overlap, follow each other, and have no length.
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
fn many_intervals_have_bars_and_shades_do_not_add_up() {
    for count in [2, 3, 7, 30] {
        let line = Line::new("only", vec![(0.0, 0.0), (20.0, 1.0)]);
        let chart = line_chart(vec![line], many_spans().into_iter().take(count).collect());
        assert_legible("spans", &chart);
        let elements = Element::all(&chart);
        let of = |opacity: f64| {
            let areas = elements.iter().filter(|element| element.is("rect"));
            let areas = areas.filter(move |element| element.number("opacity") == opacity);
            areas.map(Element::points).collect::<Vec<_>>()
        };
        let (shades, bars) = (of(0.16), of(0.35));
        let top = shades[0][0].1;
        for (number, a) in shades.iter().enumerate() {
            for b in &shades[..number] {
                assert!(a[0].0 >= b[1].0 || b[0].0 >= a[1].0, "{a:?} darkens {b:?}");
            }
        }
        assert!(
            bars.iter().all(|bar| bar[1].1 <= top),
            "{count}: above the data"
        );
        let more = format!("and {} more", count - bars.len());
        assert!(bars.len() == count || contains_text(&chart, &more));
    }
}

#[test]
fn square_is_drawn_as_a_square() {
    let sides = |points: &[(f64, f64)]| -> Vec<f64> {
        let pairs = points.iter().zip(points.iter().cycle().skip(1));
        let sides = pairs.map(|(a, b)| (a.0 - b.0).hypot(a.1 - b.1));
        sides.filter(|side| *side > 0.0).collect()
    };
    for end in [(10.0, 3.0), (3.0, 10.0), (-1.0, 5.0), (2.5, -2.5)] {
        let elements = Element::all(&track(vec![(1.5, -1.5), end]));
        let square = elements
            .iter()
            .find(|element| element.is("polygon"))
            .unwrap();
        let sides = sides(&square.points());
        assert_eq!(sides.len(), 4);
        for side in &sides {
            assert!((side - sides[0]).abs() <= 2.0, "{end:?}: {sides:?}");
        }
    }
    let square = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0), (0.0, 0.0)];
    let elements = Element::all(&plan(Ink::Solid, &square));
    let mut lines = elements.iter().filter(|element| element.is("polyline"));
    let sides = sides(
        &lines
            .find(|line| line.points().len() == 5)
            .unwrap()
            .points(),
    );
    assert!(sides[0] > 600.0, "{sides:?}");
    for side in &sides {
        assert!((side - sides[0]).abs() <= 2.0, "{sides:?}");
    }
}

#[test]
fn distant_obstacles_are_not_drawn() {
    let mut chart = track(vec![(0.0, 0.0), (10.0, 0.0)]);
    chart
        .obstacles
        .push(vec![(9e4, 0.0), (1e5, 0.0), (1e5, 1.0)]);
    let elements = Element::all(&chart);
    let areas = elements.iter().filter(|element| element.is("polygon"));
    assert_eq!(areas.count(), 1);
}

#[test]
fn names_of_near_spots_do_not_overlap() {
    let chart = TrackChart {
        spots: vec![
            Spot::new("start", (0.0, 0.0)),
            Spot::new("goal", (0.1, 0.0)).within(0.5),
        ],
        ..track(vec![(0.0, 0.0), (4.0, 3.0)])
    };
    assert_legible("spots", &chart);
    assert!(contains_text(&chart, "start") && contains_text(&chart, "goal"));
    let elements = Element::all(&chart);
    let lines = elements.iter().filter(|element| element.is("polyline"));
    let circles: Vec<_> = lines
        .map(Element::points)
        .filter(|line| line.len() == 65)
        .collect();
    assert_eq!(circles.len(), 1);
    let circle = &circles[0];
    let (wide, high) = (circle[0].0 - circle[32].0, circle[48].1 - circle[16].1);
    assert!((wide - high).abs() <= 2.0, "{wide} by {high}");
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
        let chart = line_chart(vec![line.clone(), line.dashed()], vec![span]);
        assert_legible("any", &chart);
        prop_assert!(!svg(&chart).unwrap().contains("NaN"));
    }
}
