//! Claims about quantities as people write them.

use super::*;
use proptest::prelude::*;

#[test]
fn lengths_come_in_three_units() {
    for (text, mm) in [
        ("100mm", 100),
        ("35cm", 350),
        ("8m", 8000),
        ("0.25m", 250),
        (" 1e3 mm ", 1000),
        ("0mm", 0),
        ("-0m", 0),
        ("0.5mm", 1),
        ("0.49mm", 0),
        ("268435456mm", 1 << 28),
    ] {
        assert_eq!(length(text), Ok(Millimeters::new(mm)), "{text}");
    }
    assert_eq!(signed_length("-200mm"), Ok(SignedMillimeters::new(-200)));
    assert_eq!(signed_length("+2cm"), Ok(SignedMillimeters::new(20)));
}

#[test]
fn angles_durations_and_shares_have_units_of_their_own() {
    assert_eq!(angle("90deg"), Ok(BinaryAngle::QUARTER));
    assert_eq!(angle("-270deg"), Ok(BinaryAngle::QUARTER));
    assert_eq!(angle("3.14159265rad"), Ok(BinaryAngle::HALF));
    assert_eq!(duration("3s"), Ok(Ticks::new(3000)));
    assert_eq!(duration("250ms"), Ok(Ticks::new(250)));
    assert_eq!(duration("2min"), Ok(Ticks::new(120_000)));
    assert_eq!(fraction("20%"), Ok(0.2));
    assert_eq!(fraction("100%"), Ok(1.0));
}

#[test]
fn each_way_to_be_wrong_has_its_line() {
    for (text, line) in [
        (
            "100",
            "'100' has no unit: write a length such as 100mm, 35cm or 8m",
        ),
        (
            "3furlongs",
            "'3furlongs' has the unknown unit 'furlongs': write a length such as 100mm, 35cm or 8m",
        ),
        (
            "nanmm",
            "'nanmm' is not a finite number: write a length such as 100mm, 35cm or 8m",
        ),
        (
            "-inf m",
            "'-inf m' is not a finite number: write a length such as 100mm, 35cm or 8m",
        ),
        ("1e400mm", "'1e400mm' is too large: at most 268435456mm"),
        (
            "269km",
            "'269km' has the unknown unit 'km': write a length such as 100mm, 35cm or 8m",
        ),
        ("300000m", "'300000m' is too large: at most 268435456mm"),
        (
            "-1mm",
            "'-1mm' is negative: write a length such as 100mm, 35cm or 8m",
        ),
        (
            "mm",
            "'mm' is not a number with a unit: write a length such as 100mm, 35cm or 8m",
        ),
        (
            "",
            "'' is not a number with a unit: write a length such as 100mm, 35cm or 8m",
        ),
    ] {
        assert_eq!(length(text).unwrap_err().to_string(), line, "{text}");
    }
    assert_eq!(
        percentage("101%").unwrap_err().to_string(),
        "'101%' is too large: at most 100%"
    );
    assert_eq!(
        angle("1e9deg").unwrap_err().to_string(),
        "'1e9deg' is too large: at most 36000deg either way"
    );
}

#[test]
fn a_long_or_multi_line_text_is_quoted_as_one_short_line() {
    let line = length(&"7\n".repeat(10_000)).unwrap_err().to_string();
    assert!(!line.contains('\n') && line.len() < 200, "{line}");
}

proptest! {
    #[test]
    fn no_text_panics_and_every_complaint_is_one_line(text in any::<String>(), unit in "(mm|deg|s|%)?") {
        let text = text + &unit;
        let complaints = [
            length(&text).err(),
            signed_length(&text).err(),
            angle(&text).err(),
            duration(&text).err(),
            percentage(&text).err(),
        ];
        for complaint in complaints.into_iter().flatten() {
            prop_assert_eq!(complaint.to_string().lines().count(), 1);
        }
    }

    #[test]
    fn every_number_of_millimetres_is_read_back(mm in 0..=1_u32 << 28) {
        prop_assert_eq!(length(&Millimeters::new(mm).to_string()), Ok(Millimeters::new(mm)));
    }

    #[test]
    fn a_percentage_is_read_back_to_the_bit(percent in 0.0..=100.0_f64) {
        let written = Percentage::try_new(percent).unwrap();
        prop_assert_eq!(percentage(&written.to_string()), Ok(written));
    }
}
