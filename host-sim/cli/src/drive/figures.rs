//! The figures of one run: \[004\] Fig. 6 to 9.

use super::super::outlines::{self, at};
use certainty_sim::export::{ExportError, OutDir};
use certainty_sim::plot::{Axis, Line, LineChart, Span, Spot, TrackChart};
use certainty_sim::robot::drive::{EventKind, Step};
use certainty_sim::robot::sensors::NAMES;
use certainty_sim::robot::{Drive, Outcome};

/// Draws the track over the world, and over the map where there is one (Fig. 6); the wheels' speeds with
/// the robot's and its mean (Fig. 7a to 9a); distance and angle to the goal (Fig. 7b to 9b).
pub(super) fn draw(drive: &Drive, outcome: &Outcome, out: &OutDir) -> Result<(), ExportError> {
    track(drive, outcome).write(out, "drive-track")?;
    let points = |value: &dyn Fn(&Step) -> f64| -> Vec<(f64, f64)> {
        let steps = outcome.steps.iter();
        steps.map(|step| (step.time_s, value(step))).collect()
    };
    let chart = |title: &str, y: Axis, lines: Vec<Line>| LineChart {
        title: titled(title, drive),
        x: Axis::new("time", "s").from(0.0),
        y,
        lines,
        shaded: faults(outcome),
    };
    let mean = outcome.quality.mean_speed;
    let speeds = vec![
        Line::new("v_R, right wheels", points(&|step| step.wheels_m_s.0)),
        Line::new("v_L, left wheels", points(&|step| step.wheels_m_s.1)),
        Line::new("v, the robot", points(&|step| step.speed_m_s)),
        Line::new("v_M, mean of v", points(&|_| mean)).dashed(),
    ];
    chart("Speeds", Axis::new("speed", "m/s"), speeds).write(out, "drive-speeds")?;
    let goal = vec![Line::new("distance", points(&|step| step.distance_m))];
    chart("Distance to the goal", Axis::new("e", "m").from(0.0), goal).write(out, "drive-goal")?;
    let angle = broken_at_the_back(points(&|step| step.angle_deg));
    let axis = Axis::new("angle, positive to the left", "°");
    chart("Angle to the goal", axis, vec![Line::new("angle", angle)]).write(out, "drive-angle")?;
    Ok(())
}

/// `points` with a gap wherever the goal passes behind the robot: from 180° to −180° is no way that the
/// angle goes.
fn broken_at_the_back(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let mut broken: Vec<(f64, f64)> = Vec::with_capacity(points.len());
    for point in points {
        if broken
            .last()
            .is_some_and(|last| (last.1 - point.1).abs() > 180.0)
        {
            broken.push((point.0, f64::NAN));
        }
        broken.push(point);
    }
    broken
}

/// A figure's title: what it shows, and of which run.
fn titled(what: &str, drive: &Drive) -> String {
    format!("{what}, health {}: {}", drive.health, befallen(drive))
}

/// The faults, or where they are many, how many they are and of whom.
fn befallen(drive: &Drive) -> String {
    /// In characters; about half of a title.
    const MOST: usize = 50;
    let faults = &drive.faults;
    if faults.is_empty() {
        return "every sensor sound".to_owned();
    }
    let all: Vec<String> = faults.iter().map(ToString::to_string).collect();
    let all = all.join(", ");
    if all.chars().count() <= MOST {
        return all;
    }
    let ill = |slot: usize| {
        let mut sensors = faults
            .iter()
            .filter_map(|spec| spec.sensor.resolve(&NAMES).ok());
        sensors.any(|sensor| sensor.slot() == slot)
    };
    let names = NAMES.iter().enumerate().filter(|&(slot, _)| ill(slot));
    let names: Vec<&str> = names.map(|(_, &name)| name).collect();
    let count = faults.len();
    format!("{count} faults, of {}", names.join(", "))
}

fn track(drive: &Drive, outcome: &Outcome) -> TrackChart {
    let course = &drive.course;
    let mut way = vec![at(course.start.at)];
    way.extend(outcome.steps.iter().map(|step| at(step.pose.at)));
    let rules = drive.pilot.rules();
    let radius_m = f64::from(rules.config().goal_radius.get()) / 1000.0;
    let map = outcome.map.as_ref();
    let cells = map.map(|(geometry, cells)| outlines::of_map(geometry, cells));
    TrackChart {
        title: titled("Track", drive),
        unit: "m".into(),
        obstacles: outlines::of_world(&course.world),
        cells: cells.unwrap_or_default(),
        tracks: vec![Line::new("robot", way)],
        spots: vec![
            Spot::new("start", at(course.start.at)),
            Spot::new(&format!("goal (within {radius_m} m)"), at(course.goal)).within(radius_m),
        ],
    }
}

/// When faults were active; those of the same time are one.
fn faults(outcome: &Outcome) -> Vec<Span> {
    let end = outcome.steps.last().map_or(0.0, |step| step.time_s);
    let mut times: Vec<(f64, f64, Vec<&str>)> = Vec::new();
    for (number, event) in outcome.events.iter().enumerate() {
        let EventKind::FaultBegan(name) = event.what else {
            continue;
        };
        let later = &outcome.events[number..];
        let over = later
            .iter()
            .find(|event| event.what == EventKind::FaultEnded(name));
        let (from, to) = (event.time_s, over.map_or(end, |event| event.time_s));
        match times.iter_mut().find(|time| (time.0, time.1) == (from, to)) {
            Some((_, _, names)) => names.push(name),
            None => times.push((from, to, vec![name])),
        }
    }
    let spans = times.into_iter().map(|(from, to, names)| Span {
        from,
        to,
        label: format!("fault of {}", names.join(", ")),
    });
    spans.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_sim::robot::{Course, HealthMode};

    #[test]
    fn an_angle_does_not_run_through_zero_behind_the_robot() {
        let broken =
            broken_at_the_back(vec![(0.0, 170.0), (1.0, -175.0), (2.0, 5.0), (3.0, 179.0)]);
        assert!(broken[1].1.is_nan());
        let kept: Vec<f64> = broken.iter().map(|point| point.1).collect();
        assert_eq!((kept[0], &kept[2..]), (170.0, &[-175.0, 5.0, 179.0][..]));
    }

    #[test]
    fn a_title_has_few_faults_whole_and_of_many_the_sensors() {
        let mut drive = Drive::new(Course::built_in(), HealthMode::Given, 1);
        assert_eq!(
            titled("Track", &drive),
            "Track, health given: every sensor sound"
        );
        drive.faults = vec!["stuck-far:FL@5s".parse().unwrap()];
        assert_eq!(
            titled("Track", &drive),
            "Track, health given: stuck-far:FL@5000ms"
        );
        let many = ["scanner", "2", "FL", "FR"].map(|name| format!("dropout:{name}=100%"));
        drive.faults = many.iter().map(|text| text.parse().unwrap()).collect();
        let expected = "Track, health given: 4 faults, of FL, OL, FR, scanner";
        assert_eq!(titled("Track", &drive), expected);
    }

    #[test]
    fn faults_of_the_same_time_are_set_off_as_one() {
        let mut drive = Drive::new(Course::built_in(), HealthMode::Given, 1);
        let specs = ["dropout:FL=100%", "dropout:SR=100%", "stuck-far:OL@1s"];
        drive.faults = specs.map(|text| text.parse().unwrap()).into();
        let spans = faults(&drive.run().unwrap());
        let labels: Vec<&str> = spans.iter().map(|span| span.label.as_str()).collect();
        assert_eq!(labels, ["fault of FL, SR", "fault of OL"]);
    }
}
