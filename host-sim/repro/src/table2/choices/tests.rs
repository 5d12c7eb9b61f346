use super::super::{Measure, Teller, repetition};
use super::*;
use certainty_sim::fusion::Method;

/// Every set-up that departs from the primary one in a single choice.
fn neighbours() -> Vec<(Choice, usize, Choices)> {
    let places = CHOICES
        .into_iter()
        .flat_map(|choice| (1..choice.alternatives).map(move |place| (choice, place)));
    places
        .map(|(choice, place)| (choice, place, choice.choose(Choices::PRIMARY, place)))
        .collect()
}

#[test]
fn the_primary_set_up_is_the_first_alternative_of_every_choice_and_fits_the_text() {
    assert_eq!(Choices::PRIMARY.departures(), []);
    assert!(!Choices::PRIMARY.contradicts_the_text());
}

#[test]
fn a_choice_changes_itself_alone() {
    for (choice, place, changed) in neighbours() {
        let alternative = choice.alternative(place);
        assert_eq!(changed.departures(), [(choice.name, alternative.name)]);
        assert_eq!(
            changed.contradicts_the_text(),
            alternative.against.is_some()
        );
    }
}

#[test]
fn alternatives_are_told_apart_by_name() {
    for choice in CHOICES {
        let names = (0..choice.alternatives).map(|place| choice.alternative(place).name);
        let mut names: Vec<_> = names.collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), choice.alternatives, "{}", choice.name);
    }
}

#[test]
fn every_alternative_changes_some_printed_figure() {
    let figures = |choices: &Choices| {
        let tellers = Method::ALL.map(|method| Teller::new(method, choices));
        let measures = [Measure::of(choices)];
        let told = repetition(choices, &tellers, &measures, 1, 0);
        let scores = told.scores.iter();
        scores
            .map(|score| (score.mae, score.mse))
            .collect::<Vec<_>>()
    };
    let primary = figures(&Choices::PRIMARY);
    for (choice, place, changed) in neighbours() {
        let alternative = choice.alternative(place).name;
        assert_ne!(figures(&changed), primary, "{} {alternative}", choice.name);
    }
}
