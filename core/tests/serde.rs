//! The forms of the feature `serde`: stable to the byte, and checked when they are read back.

use certainty_core::certainty::Certainty;
use certainty_core::health::{Claim, Confidence, Health, Status};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Finding, FindingCounts, Missing, Reading, Validated};
use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose, Ticks};
use core::fmt::Debug;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Asserts that `value` is written as `json` and as `bytes`, and read back from both.
#[track_caller]
fn assert_form<T>(value: T, json: &str, bytes: &[u8])
where
    T: Serialize + DeserializeOwned + PartialEq + Debug,
{
    assert_eq!(serde_json::to_string(&value).unwrap(), json);
    assert_eq!(serde_json::from_str::<T>(json).unwrap(), value);
    let mut buffer = [0; 64];
    assert_eq!(postcard::to_slice(&value, &mut buffer).unwrap(), bytes);
    assert_eq!(postcard::from_bytes::<T>(bytes).unwrap(), value);
}

#[test]
fn newtypes_are_written_as_their_numbers() {
    assert_form(Millimeters::new(300), "300", &[0xAC, 0x02]);
    assert_form(BinaryAngle::QUARTER, "16384", &[0x80, 0x80, 0x01]);
    assert_form(Ticks::new(7), "7", &[7]);
    assert_form(Certainty::OCCUPIED, "255", &[255]);
    assert_form(Confidence::FULL, "65535", &[0xFF, 0xFF, 0x03]);
    assert_form(SensorId::try_new(255).unwrap(), "255", &[255]);
}

#[test]
fn places_are_written_as_their_coordinates() {
    let point = Point::from_mm(-1, Point::LIMIT);
    assert_form(
        point,
        r#"{"x_mm":-1,"y_mm":268435456}"#,
        &[1, 0x80, 0x80, 0x80, 0x80, 0x02],
    );
    assert_form(
        Pose::new(Point::from_mm(1, 2), BinaryAngle::from_bits(3)),
        r#"{"at":{"x_mm":1,"y_mm":2},"heading":3}"#,
        &[2, 4, 3],
    );
}

#[test]
fn readings_are_written_as_their_variants() {
    assert_form(Reading::Echo(Millimeters::new(5)), r#"{"Echo":5}"#, &[0, 5]);
    assert_form(Reading::NoObject, r#""NoObject""#, &[1]);
    assert_form(Reading::TooNear, r#""TooNear""#, &[2]);
    for (reason, name) in [
        (Missing::Timeout, "Timeout"),
        (Missing::Bus, "Bus"),
        (Missing::Implausible, "Implausible"),
        (Missing::Late, "Late"),
    ] {
        let json = format!(r#"{{"Missing":"{name}"}}"#);
        assert_form(Reading::Missing(reason), &json, &[3, reason as u8]);
    }
}

#[test]
fn findings_are_written_as_their_variants() {
    for (number, finding) in (0..).zip(Finding::ALL) {
        assert_form(finding, &format!(r#""{finding:?}""#), &[number]);
    }
    let validated = Validated {
        reading: Reading::NoObject,
        finding: Finding::Jump,
    };
    let json = r#"{"reading":"NoObject","finding":"Jump"}"#;
    assert_form(validated, json, &[1, 1]);
    assert_form(FindingCounts::default(), "[0,0,0,0,0]", &[0; 5]);
}

#[test]
fn a_health_record_is_read_back_whole() {
    assert_form(Status::Recovering, r#""Recovering""#, &[3]);
    assert_form(Claim::Free, r#""Free""#, &[1]);
    let mut health = Health::new(Confidence::from_bits(9));
    health.record(Reading::NoObject, Ticks::new(4));
    health.record(Reading::Missing(Missing::Bus), Ticks::new(5));
    let json = serde_json::to_string(&health).unwrap();
    assert_eq!(serde_json::from_str::<Health>(&json).unwrap(), health);
}

#[test]
fn values_that_the_types_refuse_are_errors() {
    assert!(serde_json::from_str::<SensorId>("0").is_err());
    assert!(serde_json::from_str::<SensorId>("256").is_err());
    assert!(serde_json::from_str::<Millimeters>("-1").is_err());
    assert!(serde_json::from_str::<BinaryAngle>("65536").is_err());
    let beyond = serde_json::from_str::<Point>(r#"{"x_mm":0,"y_mm":-268435457}"#);
    let error = beyond.unwrap_err().to_string();
    assert_eq!(error, "a coordinate is beyond 268435456 mm");
}
