//! The report for people.

use super::super::table::table;
use super::Arguments;
use certainty_sim::export::shown;
use certainty_sim::quantity::Excerpt;
use certainty_sim::robot::drive::{Event, EventSource};
use certainty_sim::robot::{Drive, Memory, Outcome};

/// What was compared, what happened, how well it went, and where the rest is.
pub(super) fn told(arguments: &Arguments, drive: &Drive, outcome: &Outcome) -> String {
    let mut text = header(drive);
    text += &happened(&outcome.events);
    text += &rated(outcome);
    text += &format!(
        "\nevery step in {}; charts in {}: drive-track, drive-speeds, drive-goal, drive-angle\n",
        shown(&arguments.out.join("drive.csv")),
        shown(&arguments.out)
    );
    text
}

/// Everything that a run is named by.
fn header(drive: &Drive) -> String {
    let faults: Vec<String> = drive.faults.iter().map(ToString::to_string).collect();
    let faults = if faults.is_empty() {
        "none".to_owned()
    } else {
        faults.join(" ")
    };
    let manner = drive.pilot;
    let idle = manner.memory != Memory::Nobody && !manner.memory.applies_to(drive.health);
    let memory = if idle {
        " (not used by this robot)"
    } else {
        ""
    };
    let bold = if manner.bold {
        "   bold: full speed however little is seen"
    } else {
        ""
    };
    format!(
        "world: {}   goal: {}mm,{}mm   seed: {}\nfaults: {faults}\n\
         health: {}   memory: {}{memory}   blame: {}   obstacles from: {}{bold}\n\n",
        Excerpt::new(drive.course.world.name()),
        drive.course.goal.x_mm(),
        drive.course.goal.y_mm(),
        drive.seed,
        drive.health,
        manner.memory.name(),
        super::blame_name(manner.sharing),
        drive.map,
    )
}

/// The events, each with whose word it is.
fn happened(events: &[Event]) -> String {
    /// What is more scrolls away; the JSON document has them all.
    const MOST: usize = 30;
    let mut text = String::from(
        "truth is what the simulator knows; robot is what the robot believes and does\n",
    );
    for event in events.iter().take(MOST) {
        let voice = match event.what.source() {
            EventSource::Truth => "truth",
            EventSource::Robot => "robot",
        };
        text += &format!("{:7.2} s  {voice}  {}\n", event.time_s, event.what);
    }
    if events.len() > MOST {
        text += &format!("           and {} more\n", events.len() - MOST);
    }
    text.push('\n');
    text
}

/// \[004\] eq. 17 to 19 in words, and what was touched.
fn rated(outcome: &Outcome) -> String {
    let quality = outcome.quality;
    let reached = if outcome.reached { "yes" } else { "no" };
    let to_goal = |value: Option<f64>, unit: &str| {
        value.map_or("-".to_owned(), |value| format!("{value:.2} {unit}"))
    };
    let clearance = Some(outcome.min_clearance_mm).filter(|clearance| clearance.is_finite());
    let rows = [
        ("goal reached", reached.to_owned()),
        ("T, time to the goal", to_goal(quality.time_s, "s")),
        (
            "E, squared distance to the goal over time",
            format!("{:.1} m² s", quality.error),
        ),
        (
            "S, standard deviation of the speed",
            format!("{:.3} m/s", quality.speed_deviation),
        ),
        ("s, way to the goal", to_goal(quality.route_m, "m")),
        ("v_M, mean speed", format!("{:.3} m/s", quality.mean_speed)),
        ("collisions", outcome.collisions.to_string()),
        (
            "least clearance",
            clearance.map_or("-".to_owned(), |clearance| format!("{clearance:.0} mm")),
        ),
    ];
    table(&rows.map(|(what, value)| vec![what.to_owned(), value]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_sim::robot::drive::EventKind;
    use certainty_sim::robot::{Course, HealthMode};
    use certainty_sim::world::World;

    #[test]
    fn the_header_says_all_that_was_chosen() {
        let mut drive = Drive::new(Course::built_in(), HealthMode::Given, 4);
        drive.pilot.bold = true;
        let text = header(&drive);
        for part in [
            "goal: 10000mm,0mm   seed: 4",
            "faults: none",
            "health: given   memory: diagnosed (not used by this robot)   blame: shared",
            "obstacles from: beams   bold",
        ] {
            assert!(text.contains(part), "no {part} in {text}");
        }
        drive.health = HealthMode::Diagnosed;
        assert!(!header(&drive).contains("not used"));
    }

    #[test]
    fn the_name_of_a_world_says_nothing_to_the_terminal() {
        let world = World::new("red \u{1b}[31m\nworld", Vec::new());
        let course = Course::to(Course::built_in().goal, world);
        let text = header(&Drive::new(course, HealthMode::Given, 1));
        assert!(
            text.starts_with("world: red \\u{1b}[31m\\nworld   goal"),
            "{text}"
        );
    }

    #[test]
    fn the_truth_and_what_the_robot_believes_are_told_apart() {
        let event = |what| Event { time_s: 5.0, what };
        let text = happened(&[
            event(EventKind::FaultBegan("FL")),
            event(EventKind::Distrusted("FL")),
        ]);
        let lines: Vec<&str> = text.lines().skip(1).collect();
        let expected = [
            "   5.00 s  truth  FL: fault began",
            "   5.00 s  robot  FL: no longer believed",
            "",
        ];
        assert_eq!(lines, expected);
        let many = happened(&[event(EventKind::Collision); 31]);
        assert!(many.contains("and 1 more"));
    }
}
