use super::*;
use embedded_hal_mock::eh1::MockError;
use embedded_hal_mock::eh1::pwm::{Mock as Channel, Transaction as Step};
use std::io::ErrorKind;

fn degrees(degrees: i32) -> BinaryAngle {
    BinaryAngle::from_millidegrees(degrees * 1_000)
}

/// A channel that gets these duty cycles, of 40 000.
fn channel(duties: &[u16]) -> Channel {
    let steps: Vec<Step> = duties
        .iter()
        .flat_map(|&duty| [Step::max_duty_cycle(40_000), Step::set_duty_cycle(duty)])
        .collect();
    Channel::new(&steps)
}

#[test]
fn pulses_are_whole_microseconds_and_duties_their_part_of_the_period() {
    // 600, 1500, 1450 and 2400 µs of 20 000, at two steps a microsecond.
    let mut servo = Servo::new(channel(&[1_200, 3_000, 2_900, 4_800]), ServoModel::COMMON);
    for (angle, pulse_us) in [(-90, 600), (0, 1_500), (-5, 1_450), (90, 2_400)] {
        assert_eq!(servo.aim(degrees(angle)).unwrap().pulse_us, pulse_us);
    }
    servo.release().done();
}

#[test]
fn the_first_way_is_the_longest_and_every_other_as_long_as_it_is() {
    let mut servo = Servo::new(channel(&[3_000, 4_200, 4_200]), ServoModel::COMMON);
    assert_eq!(ServoModel::COMMON.worst_settling_ms(), 600 + 20); // 180° and a period
    let mut settle = |millidegrees| {
        let angle = BinaryAngle::from_millidegrees(millidegrees);
        servo.aim(angle).unwrap().settle_ms
    };
    assert_eq!(settle(0), 620);
    assert_eq!(settle(60_000), 200 + 20);
    assert_eq!(settle(60_000), 0);
    servo.release().done();
}

#[test]
fn what_is_out_of_reach_is_refused_and_the_servo_stays() {
    let mut servo = Servo::new(channel(&[3_000, 3_600]), ServoModel::COMMON);
    servo.aim(degrees(0)).unwrap();
    for angle in [91, -91, 180, 135] {
        assert_eq!(servo.aim(degrees(angle)), Err(ServoError::OutOfReach));
    }
    // Still known to look straight ahead: 300 µs are 30°.
    assert_eq!(servo.aim(degrees(30)).unwrap().settle_ms, 100 + 20);
    servo.release().done();
}

#[test]
fn after_a_refused_duty_the_servo_may_be_anywhere() {
    let steps = [
        Step::max_duty_cycle(40_000),
        Step::set_duty_cycle(3_000),
        Step::max_duty_cycle(40_000),
        Step::set_duty_cycle(3_100).with_error(MockError::Io(ErrorKind::NotConnected)),
        Step::max_duty_cycle(40_000),
        Step::set_duty_cycle(3_100),
    ];
    let mut servo = Servo::new(Channel::new(&steps), ServoModel::COMMON);
    servo.aim(degrees(0)).unwrap();
    assert_eq!(servo.aim(degrees(5)), Err(ServoError::Pwm));
    assert_eq!(servo.aim(degrees(5)).unwrap().settle_ms, 620);
    servo.release().done();
}

#[test]
fn every_angle_has_the_pulse_of_the_formula_or_none() {
    let mirrored = ServoModel::try_new(ServoConfig {
        quarter_us: -917,
        ahead_us: 1_478,
        ..ServoConfig::COMMON
    })
    .unwrap();
    for model in [ServoModel::COMMON, mirrored] {
        let config = model.config();
        let mut reached = 0;
        for bits in 0..=u16::MAX {
            let turns = f64::from(bits as i16) / 65_536.0;
            let exact = f64::from(config.ahead_us) + 4.0 * turns * f64::from(config.quarter_us);
            let pulse = (exact + 0.5).floor();
            let inside = (600.0..=2_400.0).contains(&pulse);
            reached += u32::from(inside);
            assert_eq!(
                model.pulse_us(BinaryAngle::from_bits(bits)).ok(),
                inside.then_some(pulse as u16)
            );
        }
        assert!((32_000..33_000).contains(&reached)); // about half a turn
    }
}

#[test]
fn a_pulse_can_be_told_from_its_duty_at_one_step_a_microsecond_or_more() {
    for full in [20_000, 20_001, 40_000, u16::MAX] {
        for pulse in 600..=2_400_u16 {
            let duty = ServoModel::COMMON.duty(pulse, full);
            let back = (f64::from(duty) * 20_000.0 / f64::from(full)).round();
            assert_eq!(back, f64::from(pulse), "of {full}");
        }
    }
}

#[test]
fn a_duty_is_rounded_and_never_more_than_all() {
    // 1500 of 20 000 of 1000 is 75; 1503 would be 75.15, 1510 75.5.
    let duty = |pulse, full| ServoModel::COMMON.duty(pulse, full);
    assert_eq!(duty(1_503, 1_000), 75);
    assert_eq!(duty(1_510, 1_000), 76);
    assert_eq!(duty(u16::MAX, u16::MAX), u16::MAX);
    assert_eq!(duty(1_500, 0), 0);
}

#[test]
fn settling_rounds_up() {
    // 1 µs of 900 a quarter turn: 0.1°, a third of a millisecond; and the period.
    assert_eq!(ServoModel::COMMON.settling_ms(1_500, 1_501), 1 + 20);
    assert_eq!(ServoModel::COMMON.settling_ms(1_503, 1_500), 1 + 20);
    assert_eq!(ServoModel::COMMON.settling_ms(1_504, 1_500), 2 + 20);
    let slowest = ServoModel::try_new(ServoConfig {
        shortest_us: 1,
        longest_us: 32_766,
        quarter_us: 1,
        period_us: 32_767,
        sixth_ms: 10_000,
        ..ServoConfig::COMMON
    });
    // 32 765 quarter turns of 15 s.
    assert_eq!(slowest.unwrap().worst_settling_ms(), 491_475_000 + 33);
}

#[test]
fn what_cannot_be_is_refused() {
    let refused = |change: fn(&mut ServoConfig)| {
        let mut config = ServoConfig::COMMON;
        change(&mut config);
        ServoModel::try_new(config).unwrap_err()
    };
    use ServoConfigError as Why;
    assert_eq!(refused(|c| c.shortest_us = 0), Why::NoRange);
    assert_eq!(refused(|c| c.shortest_us = 2_400), Why::NoRange);
    assert_eq!(refused(|c| c.ahead_us = 599), Why::Ahead);
    assert_eq!(refused(|c| c.ahead_us = 2_401), Why::Ahead);
    assert_eq!(refused(|c| c.quarter_us = 0), Why::NoTurn);
    assert_eq!(refused(|c| c.period_us = 2_400), Why::Period);
    assert_eq!(refused(|c| c.period_us = 32_768), Why::Period);
    assert_eq!(refused(|c| c.sixth_ms = 0), Why::Slew);
    assert_eq!(refused(|c| c.sixth_ms = 10_001), Why::Slew);
    assert_eq!(
        ServoModel::try_new(ServoConfig::COMMON),
        Ok(ServoModel::COMMON)
    );
}
