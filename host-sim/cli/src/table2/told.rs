//! The report for people.

use super::{Sensitivity, printed_place};
use crate::simulate::percent;
use crate::table::{row, table};
use certainty_repro::table2::{
    Candidate, Choices, Evaluation, Figures, MethodFigures, Search, factor,
};
use certainty_sim::export::shown;
use std::path::PathBuf;

/// The whole report.
pub(super) fn told(
    seed: u64,
    evaluation: &Evaluation,
    sensitivity: Option<&Sensitivity>,
    files: &[PathBuf],
) -> String {
    let mut text = format!(
        "[001] Table 2   worlds: {}   readings a method and world: {}   seed: {seed}\n\
         MAE and MSE in thousandths: mean ± standard deviation over the worlds\n\n",
        evaluation.worlds().len(),
        evaluation.readings,
    );
    text += &methods(evaluation);
    let holds = if evaluation.figures().in_the_papers_order() {
        "holds"
    } else {
        "does not hold"
    };
    text += &format!(
        "The paper's order, median < robust < bayes in MAE and MSE, {holds} for the\n\
         means; in {} of the worlds.\n",
        percent(evaluation.order_held_in())
    );
    if let Some(sensitivity) = sensitivity {
        text += &varied(sensitivity);
    }
    let files: Vec<_> = files.iter().map(|file| shown(file)).collect();
    text += &format!("\nwritten: {}\n", files.join(", "));
    text
}

/// The table of the methods beside the paper's.
fn methods(evaluation: &Evaluation) -> String {
    let head = [
        "method", "MAE", "paper", "ratio", "MSE", "paper", "ratio", "missed", "ghost",
    ];
    let mut rows = vec![row(head)];
    rows.extend(evaluation.methods.iter().map(|method| {
        let MethodFigures {
            method,
            mean,
            deviation,
            floor: _,
            to_oracle: _,
        } = method;
        let printed = Figures::PRINTED.values();
        let place = printed_place(*method);
        let mut cells = vec![method.to_string()];
        for (nth, mean, deviation) in [
            (0, mean.mae, deviation.map(|score| score.mae)),
            (1, mean.mse, deviation.map(|score| score.mse)),
        ] {
            cells.push(match deviation {
                Some(deviation) => format!("{} ± {}", thousandths(mean), thousandths(deviation)),
                None => thousandths(mean),
            });
            let printed = place.map(|place| printed[2 * place + nth]);
            cells.push(printed.map_or("-".into(), |printed| format!("{:.0}", printed * 1e3)));
            cells.push(printed.map_or("-".into(), |printed| format!("{:.2}", mean / printed)));
        }
        cells.extend([percent(mean.missed), percent(mean.ghost)]);
        cells
    }));
    let head = [
        "method",
        "MAE - oracle's",
        "MAE of perfect readings",
        "MSE of perfect readings",
    ];
    let mut limits = vec![row(head)];
    limits.extend(evaluation.methods.iter().map(|row| {
        vec![
            row.method.to_string(),
            format!("{:+.1}", row.to_oracle * 1e3),
            thousandths(row.floor.mae),
            thousandths(row.floor.mse),
        ]
    }));
    format!("{}\n{}\n", table(&rows), table(&limits))
}

/// What the open choices do.
fn varied(sensitivity: &Sensitivity) -> String {
    let mut text = format!(
        "\nOne choice at a time, {} worlds each; * is within {:.0} % of the paper\n\n",
        sensitivity.worlds,
        Figures::NEAR * 100.0
    );
    let head = [&["choice", "alternative"][..], &COLUMNS, &["moves most"]].concat();
    let mut rows = vec![head.into_iter().map(str::to_owned).collect::<Vec<_>>()];
    rows.push([vec!["paper".into(), String::new()], six(&Figures::PRINTED)].concat());
    rows.extend(sensitivity.neighbours.iter().map(|neighbour| {
        let (choice, alternative) = match neighbour.departure {
            Some((choice, to)) => (choice, to.name),
            None => ("primary", ""),
        };
        let moved = neighbour
            .moved_most
            .map(|(figure, ratio)| format!("{} ×{ratio:.2}", Figures::NAMES[figure]));
        let mut cells = vec![choice.to_owned(), alternative.to_owned()];
        cells.extend(six(&neighbour.figures));
        cells.push(moved.unwrap_or_default());
        cells
    }));
    text += &table(&rows);

    let search = &sensitivity.search;
    text += &format!(
        "\nThe best set-up given each alternative, by its farthest figure: {} set-ups screened, {} run \
         in {} other worlds\n\n",
        search.screened, search.finalists, sensitivity.worlds
    );
    let head = [
        &["choice", "alternative"][..],
        &COLUMNS,
        &["off by", "in order"],
    ]
    .concat();
    let mut rows = vec![head.into_iter().map(str::to_owned).collect::<Vec<_>>()];
    for (choice, _) in search.deciding() {
        let given = search.given.iter();
        for given in given.filter(|given| given.choice.name == choice.name) {
            let alternative = choice.alternative(given.place);
            let mark = if alternative.against.is_some() {
                "!"
            } else {
                ""
            };
            let mut cells = vec![
                choice.name.to_owned(),
                format!("{}{mark}", alternative.name),
            ];
            cells.extend(six(&given.best.figures));
            cells.push(off_by(&given.best));
            cells.push(format!("{:.0} %", given.in_order * 100.0));
            rows.push(cells);
        }
    }
    text += &table(&rows);
    text += &format!(
        "! the text speaks against it\n\n\
         Of {} set-ups that the text allows, {} come in the paper's order ({} worlds each).\n",
        search.allowed, search.in_order, sensitivity.screen_worlds
    );
    text += &answer(search);
    text.push('\n');
    text
}

const COLUMNS: [&str; 6] = ["bayes", "MSE", "robust", "MSE", "median", "MSE"];

/// The six figures in thousandths; an asterisk where one is near the printed one.
fn six(figures: &Figures) -> Vec<String> {
    let marked = figures.values().into_iter().zip(figures.near());
    marked
        .map(|(value, near)| format!("{}{}", thousandths(value), if near { "*" } else { " " }))
        .collect()
}

fn thousandths(value: f64) -> String {
    format!("{:.1}", value * 1e3)
}

fn off_by(candidate: &Candidate) -> String {
    format!("×{:.2}", candidate.figures.worst_factor())
}

/// Whether any set-up reproduces the table, and what decides it, in words.
pub(super) fn answer(search: &Search) -> String {
    let best = &search.best;
    let allowed = search.allowed;
    let yes_or_no = if search.reproduces() {
        format!("Yes: among {allowed} combinations that the text allows, one comes")
    } else {
        format!("No: among {allowed} combinations that the text allows, none was found to come")
    };
    let ratios = best.figures.ratios().into_iter().enumerate();
    let farthest = ratios.max_by(|a, b| factor(a.1).total_cmp(&factor(b.1)));
    let farthest = farthest.map(|(figure, ratio)| {
        format!(
            "{} is {ratio:.2} times the printed one",
            Figures::NAMES[figure]
        )
    });
    let deciding: Vec<_> = search
        .deciding()
        .into_iter()
        .take(3)
        .map(|(choice, decides)| format!("{} (×{decides:.2})", choice.name))
        .collect();
    format!(
        "{yes_or_no} within a quarter of all six printed figures. The best is {}; its farthest figure, {}. What decides most, by how much \
         farther the best set-up is given the worst alternative: {}.",
        described(&best.choices),
        farthest.unwrap_or_default(),
        deciding.join(", ")
    )
}

/// A set-up by what it departs in.
fn described(choices: &Choices) -> String {
    let departures = choices.departures();
    if departures.is_empty() {
        return "the primary set-up".into();
    }
    let departures: Vec<_> = departures
        .into_iter()
        .map(|(choice, name)| format!("{choice} {name}"))
        .collect();
    format!("the primary set-up but for {}", departures.join(", "))
}
