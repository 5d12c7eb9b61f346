//! `certainty calibrate`: sensors' characteristics from measured bytes, and the remaining errors.

use super::options::OutputOptions;
use super::output::Failure;
use super::output::{self, Report};
use super::table::{counted, row, table};
use certainty_core::units::Millimeters;
use certainty_sim::calibration::{
    Assessment, Spread, error_histogram, error_over_distance, load, typical,
};
use certainty_sim::export::{OutDir, display_path};
use certainty_sim::quantity::{self, Excerpt};
use certainty_sim::transducer::{Adc, GP2D02_UNITS, MeasuredUnit};
use clap::Args;
use clap::builder::PossibleValuesParser;
use serde::Serialize;
use std::path::PathBuf;

/// The options of `certainty calibrate`.
#[derive(Debug, Args)]
#[command(mut_arg("out", |out| out.help("Folder for the charts")))]
pub(super) struct Arguments {
    /// Measured points: CSV with the header `dist_cm,NAME,NAME…` or `distance_mm,raw`; - is stdin [default:
    /// sixteen real GP2D02, part of the program]
    file: Option<PathBuf>,
    /// Bits of the ADC whose counts the table has
    #[arg(long, value_name = "BITS", default_value = "8", value_parser = PossibleValuesParser::new(["8", "10", "12"]), requires = "file")]
    adc_bits: String,
    /// The table has volts, which become counts of the ADC
    #[arg(long, requires = "file")]
    volts: bool,
    /// The ADC's reference, the volts of the largest count
    #[arg(long, value_name = "VOLTS", default_value_t = 5.0, requires = "volts")]
    vref: f64,
    /// Shortest distance that is fitted
    #[arg(long, value_name = "LENGTH", default_value = "100mm", value_parser = quantity::length, allow_hyphen_values = true)]
    nearest: Millimeters,
    /// Longest distance that is fitted
    #[arg(long, value_name = "LENGTH", default_value = "800mm", value_parser = quantity::length, allow_hyphen_values = true)]
    farthest: Millimeters,
    #[command(flatten)]
    output: OutputOptions,
}

/// Calibrates every unit, draws and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.nearest >= arguments.farthest {
        return Err(Failure::Input(format!(
            "--nearest {} is not below --farthest {}: expected a range such as 100mm to 800mm",
            arguments.nearest, arguments.farthest
        )));
    }
    arguments.output.check()?;
    let adc = arguments.adc()?;
    let units = arguments.assess()?;
    let out = arguments.output.create()?;
    let files = draw(&units, &out)?;
    out.finish().map_err(|error| Failure::input(&error))?;
    arguments.output.print(&Calibration {
        arguments,
        adc,
        units,
        files,
    })
}

impl Arguments {
    /// Returns the converter whose counts the table has.
    fn adc(&self) -> Result<Adc, Failure> {
        let bits = self.adc_bits.parse().ok().and_then(Adc::try_new);
        let adc = bits.unwrap_or(Adc::BYTE); // clap takes 8, 10 and 12 alone
        if !self.volts {
            return Ok(adc);
        }
        let line = "--vref: expected a number of volts above 0, such as 5.0 or 3.3";
        adc.volts(self.vref)
            .ok_or_else(|| Failure::Input(line.into()))
    }

    fn assess(&self) -> Result<Vec<Assessment>, Failure> {
        let units = match &self.file {
            Some(file) => load(file, self.adc()?).map_err(|error| Failure::input(&error))?,
            None => MeasuredUnit::parse(GP2D02_UNITS)
                .map_err(|error| Failure::Internal(error.to_string()))?,
        };
        let assess = |unit| Assessment::of(unit, self.nearest, self.farthest);
        let units: Result<_, _> = units.iter().map(assess).collect();
        units.map_err(|error| match &self.file {
            Some(file) => Failure::Input(format!("{}: {error}", file.display())),
            None => Failure::Input(format!("the shipped units: {error}")),
        })
    }
}

/// Writes [001] Fig. 6 and the errors over the distance, of at most three units.
fn draw(units: &[Assessment], out: &OutDir) -> Result<Vec<PathBuf>, Failure> {
    let units = typical(units);
    let histogram = error_histogram(&units).write(out, "calibrate-errors");
    let over_distance = || error_over_distance(&units).write(out, "calibrate-over-distance");
    let files = histogram.and_then(|files| Ok([files, over_distance()?].concat()));
    files.map_err(|error| Failure::input(&error))
}

/// The calibrated units and the charts.
struct Calibration<'a> {
    arguments: &'a Arguments,
    adc: Adc,
    units: Vec<Assessment>,
    files: Vec<PathBuf>,
}

/// The report as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct Document<'a> {
    /// The table; null for the shipped units.
    file: Option<String>,
    nearest_mm: u32,
    farthest_mm: u32,
    /// The bits of the ADC whose counts a, c and the errors are in.
    adc_bits: u8,
    /// Its reference if the table has volts, else null.
    reference_volts: Option<f64>,
    units: Vec<UnitReport<'a>>,
    files: Vec<String>,
}

/// One unit: raw ≈ a / (d + b) + c.
#[derive(Debug, Serialize)]
struct UnitReport<'a> {
    name: &'a str,
    /// In count-millimetres.
    a: f64,
    b_mm: u32,
    /// In counts.
    c: f64,
    rms_counts: f64,
    worst_counts: f64,
    /// Points within the range, which are fitted.
    points: usize,
    /// Points outside the range.
    ignored: usize,
    /// Fields without a reading, which are left out.
    blank: usize,
    /// The calibrated reading less the true distance; null if no point reads as a distance.
    error_mm: Option<Spread>,
    /// The same as a percentage of the true distance.
    error_percent: Option<Spread>,
    /// Points within the range that read as too near or as no object after calibration.
    out_of_range: usize,
}

impl<'a> From<&'a Assessment> for UnitReport<'a> {
    fn from(unit: &'a Assessment) -> Self {
        Self {
            name: unit.name(),
            a: unit.fit().slope(),
            b_mm: unit.fit().offset().get(),
            c: unit.fit().floor(),
            rms_counts: unit.fit().rms(),
            worst_counts: unit.fit().worst(),
            points: unit.points(),
            ignored: unit.ignored(),
            blank: unit.blanks(),
            error_mm: unit.error_mm(),
            error_percent: unit.error_percent(),
            out_of_range: unit.out_of_range(),
        }
    }
}

impl Report for Calibration<'_> {
    fn document(&self) -> impl Serialize {
        let file = self.arguments.file.as_ref();
        Document {
            file: file.map(|file| file.to_string_lossy().into_owned()),
            nearest_mm: self.arguments.nearest.get(),
            farthest_mm: self.arguments.farthest.get(),
            adc_bits: self.adc.bits(),
            reference_volts: self.adc.reference(),
            units: self.units.iter().map(UnitReport::from).collect(),
            files: output::listed(&self.files),
        }
    }

    fn render(&self) -> String {
        let mut text =
            "raw = a / (d + b) + c, d the distance; error: the calibrated reading less the \
                    true distance\n\n"
                .to_owned();
        let mut rows = vec![
            row([
                "unit", "a", "b", "c", "rms", "max", "points", "mean", "sd", "worst", "sd", "lost",
            ]),
            row([
                "", "count mm", "mm", "counts", "counts", "counts", "", "mm", "mm", "mm", "%", "",
            ]),
        ];
        rows.extend(self.units.iter().map(|unit| {
            let fit = unit.fit();
            let shown =
                |spread: Option<f64>| spread.map_or_else(|| "-".into(), |v| format!("{v:.1}"));
            let (mm, percent) = (unit.error_mm(), unit.error_percent());
            vec![
                Excerpt::new(unit.name()).to_string(),
                format!("{:.0}", fit.slope()),
                fit.offset().get().to_string(),
                format!("{:.2}", fit.floor()),
                format!("{:.2}", fit.rms()),
                format!("{:.2}", fit.worst()),
                unit.points().to_string(),
                shown(mm.map(|spread| spread.mean)),
                shown(mm.map(|spread| spread.sd)),
                shown(mm.map(|spread| spread.worst)),
                shown(percent.map(|spread| spread.sd)),
                unit.out_of_range().to_string(),
            ]
        }));
        text += &table(&rows);
        let blank = self.units.iter().filter(|unit| unit.blanks() > 0);
        for unit in blank {
            let name = Excerpt::new(unit.name());
            let fields = counted(unit.blanks() as u64, "blank field");
            text += &format!("{name}: {fields} left out\n");
        }
        let bits = self.adc.bits();
        if let Some(reference) = self.adc.reference() {
            text += &format!("\nvolts are taken as counts of {bits} bits at {reference} V.\n");
        }
        if bits > 8 {
            text += &format!(
                "\ncounts are those of a {bits}-bit ADC. The Calibration of certainty-core takes 8 bits: give it \
                 readings without their lowest {} bits, and a and c divided by {}.\n",
                bits - 8,
                1_u32 << (bits - 8)
            );
        }
        if self.units.iter().any(|unit| unit.fit().floor() < 0.0) {
            text += "\nA Calibration of certainty-core has no c below 0: fit a shorter range (--nearest, --farthest) for it.\n";
        }
        text += "\nrms and max: of the fit; mean, sd and worst: of the distance; lost: points that read as \
             too near or as no object.\n";
        text += &format!(
            "Charts in {}: calibrate-errors and calibrate-over-distance, .png and .svg, of {}.\n",
            display_path(&self.arguments.output.out),
            if self.units.len() > 3 {
                "the units with the least, the middle and the largest sd"
            } else {
                "every unit"
            }
        );
        text
    }
}
