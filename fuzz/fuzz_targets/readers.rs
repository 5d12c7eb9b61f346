//! Recordings and tables from arbitrary bytes.
//!
//! The first byte chooses the reader and its options; the rest is the file, plain or packed.
#![no_main]

use certainty_core::units::Millimeters;
use certainty_sim::replay::{Format, LoadOptions, RangeUnit, ZeroMeans, read};
use certainty_sim::ring::{RingOptions, RingRecording};
use certainty_sim::transducer::{Adc, MeasuredUnit};
use core::num::NonZeroU8;
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|data: &[u8]| {
    let Some((&choice, data)) = data.split_first() else {
        return;
    };
    let zero = [ZeroMeans::NoObject, ZeroMeans::TooNear][usize::from(choice >> 7)];
    let lenient = choice & 0x40 != 0;
    match choice % 6 {
        0 => recording(None, zero, lenient, data),
        1 => recording(Some(Format::Carmen), zero, lenient, data),
        2 => recording(Some(Format::Readings), zero, lenient, data),
        3 => recording(Some(Format::Wide), zero, lenient, data),
        4 => table(choice, data),
        _ => {
            let range = Millimeters::new(5000);
            let options = RingOptions {
                range,
                zero,
                lenient,
            };
            if let Err(error) = RingRecording::parse(data, &options) {
                assert_eq!(error.to_string().lines().count(), 1);
            }
        }
    }
});

fn recording(format: Option<Format>, zero: ZeroMeans, lenient: bool, data: &[u8]) {
    let options = LoadOptions {
        format,
        zero,
        lenient,
        sensors: NonZeroU8::new(3).unwrap(),
        unit: lenient.then_some(RangeUnit::Meters),
        max_step: lenient.then_some(Millimeters::new(1000)),
        max_beams: 100_000,
        ..LoadOptions::default()
    };
    match read(Path::new("input"), data, &options) {
        Ok(recording) => {
            assert!(!recording.beams.is_empty());
            assert_eq!(recording.names.len(), usize::from(recording.sensors));
            assert!(recording.names.is_sorted());
            let most = recording
                .beams
                .iter()
                .map(|beam| beam.sensor.number())
                .max();
            assert!(most <= Some(recording.sensors));
            let _ = (recording.extent(), recording.stray_pose());
        }
        Err(error) => assert_eq!(error.to_string().lines().count(), 1),
    }
}

fn table(choice: u8, data: &[u8]) {
    let Ok(text) = str::from_utf8(data) else {
        return;
    };
    let adc = Adc::try_new([8, 10, 12][usize::from(choice / 6 % 3)]).unwrap();
    let adc = if choice & 0x80 == 0 {
        adc
    } else {
        adc.volts(5.0).unwrap()
    };
    match MeasuredUnit::parse_as(text, adc) {
        Ok(units) => {
            for point in units.iter().flat_map(MeasuredUnit::points) {
                assert!(point.distance_mm > 0.0 && (0.0..=adc.most()).contains(&point.raw));
            }
        }
        Err(error) => assert_eq!(error.to_string().lines().count(), 1),
    }
}
