use super::*;
use certainty_repro::table2::{CHOICES, Figures};
use serde_json::Value;

/// What little work finds: no screen, one world.
fn little() -> (Evaluation, Sensitivity) {
    let effort = Effort {
        screen_worlds: 0,
        finalists: 1,
        final_worlds: 1,
    };
    let sensitivity = Sensitivity {
        worlds: 1,
        screen_worlds: 0,
        neighbours: neighbours(1, 1, || {}),
        search: Search::run(1, &effort, |_| {}, || {}),
    };
    (Evaluation::run(Choices::PRIMARY, 1, 1, || {}), sensitivity)
}

#[test]
fn the_sensitivity_lists_every_alternative_in_json_and_in_words() {
    let (evaluation, sensitivity) = little();
    let report = Report::new(1, &evaluation, Some(&sensitivity), &[]);
    let document: Value = serde_json::to_value(&report).unwrap();
    let text = told::told(1, &evaluation, Some(&sensitivity), &[]);

    let one = document["sensitivity"]["one_at_a_time"].as_array().unwrap();
    let others: usize = CHOICES.iter().map(|choice| choice.alternatives - 1).sum();
    assert_eq!(one.len(), 1 + others);
    assert_eq!(one[0]["choice"], Value::Null);
    for row in &one[1..] {
        let alternative = row["alternative"].as_str().unwrap();
        assert!(text.contains(alternative), "{alternative}");
        for key in ["figures", "near"] {
            assert_eq!(row[key].as_array().unwrap().len(), 6);
        }
        let figure = row["moved_most"]["figure"].as_str().unwrap();
        assert!(Figures::NAMES.contains(&figure));
    }

    let search = &document["sensitivity"]["search"];
    let by_choice = search["by_choice"].as_array().unwrap();
    assert_eq!(by_choice.len(), CHOICES.len());
    let decides: Vec<f64> = by_choice
        .iter()
        .map(|choice| choice["decides"].as_f64().unwrap())
        .collect();
    assert!(decides.is_sorted_by(|a, b| a >= b), "{decides:?}");
    let worst = search["best"]["worst_factor"].as_f64().unwrap();
    assert_eq!(worst, sensitivity.search.best.figures.worst_factor());

    let answer = document["sensitivity"]["answer"].as_str().unwrap();
    assert!(text.contains(answer));
    let yes = search["reproduces"].as_bool().unwrap();
    assert_eq!(answer.starts_with("Yes: "), yes);
    assert_eq!(answer.starts_with("No: "), !yes);
}

#[test]
fn the_choices_in_json_are_those_of_the_primary_set_up() {
    let evaluation = Evaluation::run(Choices::PRIMARY, 1, 1, || {});
    let report = serde_json::to_value(Report::new(1, &evaluation, None, &[])).unwrap();
    let choices = report["choices"].as_object().unwrap();
    assert_eq!(choices.len(), CHOICES.len());
    for choice in CHOICES {
        assert_eq!(choices[choice.name], choice.alternative(0).name);
    }
    assert_eq!(report.get("sensitivity"), None);
}
