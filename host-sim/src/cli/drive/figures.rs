//! The figures of one run: \[004\] Fig. 6 to 9.

use super::super::outlines::{self, at};
use crate::export::{ExportError, OutDir};
use crate::plot::{Axis, Line, LineChart, Span, TrackChart};
use crate::robot::drive::{Happening, Step};
use crate::robot::{Drive, Outcome};

/// Draws the track over the world, and over the map where there is one (Fig. 6); the wheels' speeds with
/// their mean (Fig. 7a to 9a); distance and angle to the goal (Fig. 7b to 9b).
pub(super) fn draw(drive: &Drive, outcome: &Outcome, out: &OutDir) -> Result<(), ExportError> {
    track(drive, outcome).write(out, "drive-track")?;
    let points = |value: &dyn Fn(&Step) -> f64| -> Vec<(f64, f64)> {
        let steps = outcome.steps.iter();
        steps.map(|step| (step.time_s, value(step))).collect()
    };
    let chart = |title: &str, y: Axis, lines: Vec<Line>| LineChart {
        title: format!("{title}: {}", subtitle(drive)),
        x: Axis::new("time", "s").from(0.0),
        y,
        lines,
        shaded: faults(outcome),
    };
    let mean = outcome.quality.mean_speed;
    let speeds = vec![
        Line::new("v_R", points(&|step| step.wheels_m_s.0)),
        Line::new("v_L", points(&|step| step.wheels_m_s.1)),
        Line::new("v_M", points(&|_| mean)).dashed(),
    ];
    chart("Speeds", Axis::new("speed", "m/s"), speeds).write(out, "drive-speeds")?;
    let goal = vec![Line::new("distance", points(&|step| step.distance_m))];
    chart("Distance to the goal", Axis::new("e", "m").from(0.0), goal).write(out, "drive-goal")?;
    let angle = vec![Line::new("angle", points(&|step| step.angle_deg))];
    let axis = Axis::new("angle", "°");
    chart("Angle to the goal", axis, angle).write(out, "drive-angle")?;
    Ok(())
}

fn subtitle(drive: &Drive) -> String {
    let faults: Vec<String> = drive.faults.iter().map(ToString::to_string).collect();
    let faults = if faults.is_empty() {
        "every sensor sound".to_owned()
    } else {
        faults.join(", ")
    };
    format!("{faults}; health {}", drive.health)
}

fn track(drive: &Drive, outcome: &Outcome) -> TrackChart {
    let course = &drive.course;
    let mut way = vec![at(course.start.at)];
    way.extend(outcome.steps.iter().map(|step| at(step.pose.at)));
    let map = outcome.map.as_ref();
    let cells = map.map(|(geometry, cells)| outlines::of_map(geometry, cells));
    TrackChart {
        title: format!("Track: {}", subtitle(drive)),
        unit: "m".into(),
        obstacles: outlines::of_world(&course.world),
        cells: cells.unwrap_or_default(),
        tracks: vec![Line::new("robot", way)],
        places: vec![at(course.start.at), at(course.goal)],
    }
}

/// When faults were active.
fn faults(outcome: &Outcome) -> Vec<Span> {
    let end = outcome.steps.last().map_or(0.0, |step| step.time_s);
    let mut spans = Vec::new();
    for (number, event) in outcome.events.iter().enumerate() {
        let Happening::FaultBegan(name) = event.what else {
            continue;
        };
        let later = outcome.events[number..].iter();
        let over = later
            .clone()
            .find(|event| event.what == Happening::FaultEnded(name));
        spans.push(Span {
            from: event.time_s,
            to: over.map_or(end, |event| event.time_s),
            label: format!("fault of {name}"),
        });
    }
    spans
}
