//! `certainty drive --study`: statistics over many drives.

use super::options::OutputOptions;
use super::output::Failure;
use super::output::{self, Report, progress};
use super::table::{row, table};
use certainty_repro::Spread;
use certainty_repro::drive_study::{Case, KINDS, Study, Summary, Trial};
use certainty_sim::fault::SpecError;
use certainty_sim::robot::HealthMode;
use serde::Serialize;
use std::io::{self, Write};

/// The report as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct Document {
    seed: u64,
    worlds: u32,
    map: String,
    blame: &'static str,
    memory: &'static str,
    simulations: Vec<Summary>,
    failures: Vec<Summary>,
    by_sensors: Vec<Summary>,
    files: Vec<String>,
}

type Driven = (Case, Vec<Trial>);

/// Drives every case in every world and reports.
pub(super) fn run(
    study: &Study,
    blame: &'static str,
    options: &OutputOptions,
) -> Result<(), Failure> {
    let out = options.create()?;
    let internal = |error: SpecError| Failure::Internal(error.to_string());
    let simulations = Study::simulations().map_err(internal)?;
    let failures = Study::failures().map_err(internal)?;
    let bar = progress("drives", (simulations.len() + failures.len()) as u64);
    let drive_all = |cases: Vec<Case>| -> Result<Vec<Driven>, Failure> {
        let driven = cases.into_iter().map(|case| {
            let trials = study.drive(&case);
            bar.inc(1);
            let trials = trials.map_err(|error| Failure::Internal(error.to_string()))?;
            Ok((case, trials))
        });
        driven.collect()
    };
    let (simulations, failures) = (drive_all(simulations)?, drive_all(failures)?);
    bar.finish_and_clear();
    let all = || simulations.iter().chain(&failures);
    let written = out.write("study.csv", |file| write_csv(all(), file));
    let written = written.map_err(|error| Failure::input(&error))?;
    out.finish().map_err(|error| Failure::input(&error))?;
    let document = Document {
        seed: study.seed,
        worlds: study.worlds,
        map: study.map.to_string(),
        blame,
        memory: study.pilot.memory.name(),
        simulations: simulations.iter().map(of_case).collect(),
        failures: groups(&failures),
        by_sensors: failures.iter().map(of_case).collect(),
        files: output::listed(&[written]),
    };
    options.print(&document)
}

fn of_case((case, trials): &Driven) -> Summary {
    Summary::of(case.name, &case.sensors, case.health, case.bold, trials)
}

/// Returns the statistics of singles and pairs of each kind, and of all together, by mode.
fn groups(driven: &[Driven]) -> Vec<Summary> {
    let mut groups = Vec::new();
    let kinds = KINDS.iter().copied().map(Some).chain([None]);
    for kind in kinds {
        for (failing, name) in [(1, "single"), (2, "pair")] {
            for health in HealthMode::ALL {
                let of_group = driven.iter().filter(|(case, _)| {
                    kind.is_none_or(|kind| case.name == kind)
                        && case.failing == failing
                        && case.health == health
                });
                let trials: Vec<Trial> = of_group.flat_map(|(_, trials)| trials).copied().collect();
                groups.push(Summary::of(
                    kind.unwrap_or("all"),
                    name,
                    health,
                    false,
                    &trials,
                ));
            }
        }
    }
    groups
}

/// Writes a line per drive.
fn write_csv<'a>(driven: impl Iterator<Item = &'a Driven>, out: &mut dyn Write) -> io::Result<()> {
    writeln!(
        out,
        "case,failing,health,bold,world,reached,collisions,min_clearance_mm,E,S,s,T,v_M,found,found_after_s,accused"
    )?;
    let optional = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.3}"));
    for (case, trials) in driven {
        for trial in trials {
            writeln!(
                out,
                "{},{},{},{},{},{},{},{:.0},{:.3},{:.4},{},{},{:.4},{},{},{}",
                case.name,
                case.sensors,
                case.health,
                case.bold,
                trial.world,
                trial.reached,
                trial.collisions,
                trial.min_clearance_mm,
                trial.error,
                trial.speed_deviation,
                optional(trial.route_m),
                optional(trial.time_s),
                trial.mean_speed,
                trial.found,
                optional(trial.found_after_s),
                trial.accused
            )?;
        }
    }
    Ok(())
}

impl Report for Document {
    fn document(&self) -> impl Serialize {
        self
    }

    fn render(&self) -> String {
        let header = || {
            row([
                "case",
                "failing",
                "health",
                "bold",
                "runs",
                "reached",
                "collisions",
                "E",
                "T",
                "S",
                "s",
                "v_M",
                "found",
                "after",
                "accused",
            ])
        };
        let line = |summary: &Summary| {
            let spread = |spread: &Option<Spread>, digits: usize| {
                spread.map_or("-".to_owned(), |spread| {
                    format!("{:.digits$} ± {:.digits$}", spread.mean, spread.sd)
                })
            };
            row([
                &summary.name,
                if summary.failing.is_empty() {
                    "none"
                } else {
                    &summary.failing
                },
                summary.health_mode,
                if summary.bold { "yes" } else { "no" },
                &summary.runs.to_string(),
                &summary.reached.to_string(),
                &summary.collisions.to_string(),
                &spread(&summary.error, 0),
                &spread(&summary.time_s, 1),
                &spread(&summary.speed_deviation, 3),
                &spread(&summary.route_m, 1),
                &spread(&summary.mean_speed, 3),
                &format!("{}/{}", summary.found.0, summary.found.1),
                &spread(&summary.found_after_s, 1),
                &summary.accused.to_string(),
            ])
        };
        let rows = |summaries: &[Summary]| {
            let mut rows = vec![header()];
            rows.extend(summaries.iter().map(line));
            table(&rows)
        };
        format!(
            "{} random courses from seed {}   obstacles from: {}   blame: {}   memory: {}\n\n{}\n{}\nevery run in {}\n",
            self.worlds,
            self.seed,
            self.map,
            self.blame,
            self.memory,
            rows(&self.simulations),
            rows(&self.failures),
            self.files.join(", ")
        )
    }
}
