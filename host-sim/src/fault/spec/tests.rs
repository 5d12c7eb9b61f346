//! Claims about faults as they are written.

use super::*;
use certainty_core::units::Ticks;
use proptest::prelude::*;

fn spec(text: &str) -> FaultSpec {
    text.parse().unwrap_or_else(|e| panic!("{text}: {e}"))
}

#[test]
fn every_kind_has_the_value_it_was_given() {
    let share = |percent| Percentage::try_new(percent).unwrap();
    for (text, defect) in [
        ("stuck-far:1", Defect::StuckFar),
        (
            "stuck-near:1=30cm",
            Defect::StuckNear(Millimeters::new(300)),
        ),
        ("noise:1=5%", Defect::Noise(share(5.0))),
        ("output-noise:1=5%", Defect::OutputNoise(share(5.0))),
        ("bias:1=-200mm", Defect::Bias(SignedMillimeters::new(-200))),
        ("scale:1=1.5", Defect::Scale(Factor::try_new(1.5).unwrap())),
        ("random:1", Defect::Random),
        ("dropout:1=100%", Defect::Dropout(share(100.0))),
        ("chatter:1=2", Defect::Chatter(Times::try_new(2).unwrap())),
    ] {
        assert_eq!(spec(text).fault, Fault::permanent(defect), "{text}");
    }
}

#[test]
fn a_value_left_out_is_the_documented_one() {
    for (short, long) in [
        ("stuck-near:1", "stuck-near:1=250mm"),
        ("noise:1", "noise:1=20%"),
        ("output-noise:1", "output-noise:1=20%"),
        ("bias:1", "bias:1=200mm"),
        ("scale:1", "scale:1=0.6"),
        ("dropout:1", "dropout:1=50%"),
        ("chatter:1", "chatter:1=4"),
        ("intermittent:1=noise", "intermittent:1=noise=20%"),
    ] {
        assert_eq!(spec(short), spec(long));
        assert_eq!(spec(short).to_string(), long);
    }
}

#[test]
fn windows_are_readings_or_times() {
    let window = |text| spec(text).fault.window;
    assert_eq!(window("random:1"), Window::Always);
    assert_eq!(
        window("random:1@0..50"),
        Window::Readings {
            from: 0,
            to: Some(50)
        }
    );
    assert_eq!(window("random:1@7"), Window::Readings { from: 7, to: None });
    assert_eq!(
        window("bias:1=2cm@3s..8s"),
        Window::Times {
            from: Ticks::new(3000),
            to: Some(Ticks::new(8000))
        }
    );
    assert_eq!(
        window("intermittent:FL=scale=0.5@250ms"),
        Window::Times {
            from: Ticks::new(250),
            to: None
        }
    );
}

#[test]
fn sensors_have_numbers_or_names() {
    let names = ["FL", "FR", ""];
    let slot = |text| spec(text).sensor.resolve(&names).map(SensorId::slot);
    assert_eq!(slot("random:1"), Ok(0));
    assert_eq!(slot("random:3"), Ok(2));
    assert_eq!(slot("random:FR"), Ok(1));
    assert_eq!(
        slot("random:4").unwrap_err().to_string(),
        "no sensor '4': there are sensors 1 to 3 (FL, FR)"
    );
    assert_eq!(
        slot("random:fr").unwrap_err().to_string(),
        "no sensor 'fr': there are sensors 1 to 3 (FL, FR)"
    );
}

#[test]
fn faults_are_dealt_out_in_the_order_given() {
    let specs = ["bias:2", "random:1", "scale:FR"].map(spec);
    let dealt = assign(&specs, &["FL", "FR"]).unwrap();
    assert_eq!(dealt[0], [specs[1].fault]);
    assert_eq!(dealt[1], [specs[0].fault, specs[2].fault]);
    assert!(assign(&specs, &["FL"]).is_err());
}

#[test]
fn each_way_to_be_wrong_has_its_line() {
    for (text, line) in [
        (
            "stuck-far",
            "'stuck-far' names no sensor: write KIND:SENSOR[=VALUE][@FROM[..TO]], for example stuck-far:2",
        ),
        (
            "stuck-far:0",
            "'0' is no sensor: write a number from 1 to 255 or a name, for example stuck-far:2",
        ),
        (
            "stuck-far:256",
            "'256' is no sensor: write a number from 1 to 255 or a name, for example stuck-far:2",
        ),
        (
            "stuck-far:",
            "'' is no sensor: write a number from 1 to 255 or a name, for example stuck-far:2",
        ),
        (
            "stuck-far:1=5",
            "stuck-far takes no value: write stuck-far:2 without '=5'",
        ),
        (
            "stuck-near:1=5",
            "stuck-near: '5' has no unit: write a length such as 100mm, 35cm or 8m, for example stuck-near:2=250mm",
        ),
        (
            "noise:1=20",
            "noise: '20' has no unit: write a percentage such as 20%, for example noise:1=20%",
        ),
        (
            "output-noise:1=20",
            "output-noise: '20' has no unit: write a percentage such as 20%, for example output-noise:1=20%",
        ),
        (
            "dropout:1=120%",
            "dropout: '120%' is too large: at most 100%, for example dropout:1=50%",
        ),
        (
            "scale:1=-1",
            "scale: '-1' is not a factor from 0 to 1000, for example scale:1=0.6",
        ),
        (
            "scale:1=nan",
            "scale: 'nan' is not a factor from 0 to 1000, for example scale:1=0.6",
        ),
        (
            "chatter:1=1",
            "chatter: '1' is not a whole number from 2 to 1000, for example chatter:2=4",
        ),
        (
            "intermittent:1",
            "intermittent needs another kind as its value, for example intermittent:1=stuck-far",
        ),
        (
            "intermittent:1=intermittent",
            "intermittent needs another kind as its value, for example intermittent:1=stuck-far",
        ),
        (
            "random:1@",
            "'@' is no window: write two readings or two times, for example @0..50 or @3s..8s",
        ),
        (
            "random:1@3s..",
            "'@3s..' is no window: write two readings or two times, for example @0..50 or @3s..8s",
        ),
        (
            "random:1@3..8s",
            "'@3..8s' is no window: write two readings or two times, for example @0..50 or @3s..8s",
        ),
        (
            "random:1@8..8",
            "'@8..8' is empty: its end is not within, so it must be above its start, for example @0..50",
        ),
        (
            "random:1@9s..8s",
            "'@9s..8s' is empty: its end is not within, so it must be above its start, for example @0..50",
        ),
    ] {
        let error = text.parse::<FaultSpec>().unwrap_err();
        assert_eq!(error.to_string(), line, "{text}");
    }
}

fn any_defect() -> impl Strategy<Value = Defect> {
    let share = || (0.0..=100.0_f64).prop_map(|p| Percentage::try_new(p).unwrap());
    prop_oneof![
        Just(Defect::StuckFar),
        (0..=1_u32 << 28).prop_map(|mm| Defect::StuckNear(Millimeters::new(mm))),
        share().prop_map(Defect::Noise),
        share().prop_map(Defect::OutputNoise),
        (-(1 << 28)..=1_i32 << 28).prop_map(|mm| Defect::Bias(SignedMillimeters::new(mm))),
        (0.0..=1000.0_f64).prop_map(|f| Defect::Scale(Factor::try_new(f).unwrap())),
        Just(Defect::Random),
        share().prop_map(Defect::Dropout),
        (2..=1000_u32).prop_map(|n| Defect::Chatter(Times::try_new(n).unwrap())),
    ]
}

fn any_window() -> impl Strategy<Value = Window> {
    prop_oneof![
        Just(Window::Always),
        (any::<u32>(), prop::option::of(1..1000_u64)).prop_map(|(from, length)| {
            let from = u64::from(from);
            Window::Readings {
                from,
                to: length.map(|l| from + l),
            }
        }),
        (0..1_u32 << 31, prop::option::of(1..1000_u32)).prop_map(|(from, length)| {
            Window::Times {
                from: Ticks::new(from),
                to: length.map(|l| Ticks::new(from + l)),
            }
        }),
    ]
}

proptest! {
    #[test]
    fn what_is_written_is_read_back_to_the_bit(
        number in 1..=255_u8,
        name in prop::option::of("[A-Za-z][A-Za-z0-9_-]{0,6}"),
        defect in any_defect(),
        intermittent in any::<bool>(),
        window in any_window(),
    ) {
        let number = SensorName::Number(SensorId::try_new(number).unwrap());
        let spec = FaultSpec {
            sensor: name.map_or(number, SensorName::Name),
            fault: Fault { defect, intermittent, window },
        };
        prop_assert_eq!(spec.to_string().parse(), Ok(spec));
    }

    #[test]
    fn no_text_panics_and_every_complaint_is_one_line(
        text in "(stuck-near|noise|intermittent|\\PC{0,5})?:?\\PC{0,3}(=\\PC{0,6})?(@\\PC{0,6}(\\.\\.)?\\PC{0,3})?",
        raw in any::<String>(),
    ) {
        for text in [text, raw] {
            if let Err(error) = text.parse::<FaultSpec>() {
                prop_assert_eq!(error.to_string().lines().count(), 1);
            }
        }
    }
}
