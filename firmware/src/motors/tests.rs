use super::*;
use certainty_control::Effort;
use embedded_hal_mock::eh1::MockError;
use embedded_hal_mock::eh1::pwm::{Mock as Channel, Transaction as Step};
use std::io::ErrorKind;

/// A channel that gets these duty cycles, of 40 000: two steps a microsecond.
fn channel(duties: &[u16]) -> Channel {
    let steps: Vec<Step> = duties
        .iter()
        .flat_map(|&duty| [Step::max_duty_cycle(40_000), Step::set_duty_cycle(duty)])
        .collect();
    Channel::new(&steps)
}

/// A channel that gets the first duty cycle and refuses it, and gets the second.
fn deaf_once(refused: u16, then: u16) -> Channel {
    Channel::new(&[
        Step::max_duty_cycle(40_000),
        Step::set_duty_cycle(refused).with_error(MockError::Io(ErrorKind::NotConnected)),
        Step::max_duty_cycle(40_000),
        Step::set_duty_cycle(then),
    ])
}

fn wheels(right: f64, left: f64) -> Wheels {
    Wheels {
        right: Effort::from_num(right),
        left: Effort::from_num(left),
    }
}

fn motors(right: Channel, left: Channel) -> Motors<Channel> {
    Motors::new(right, left, MotorModel::COMMON)
}

fn done(motors: Motors<Channel>) {
    let (mut right, mut left) = motors.release();
    right.done();
    left.done();
}

#[test]
fn a_pulse_is_a_millisecond_and_a_half_and_up_to_half_a_one_more_or_less() {
    let mut motors = motors(
        channel(&[3_000, 4_000, 2_000]),
        channel(&[3_000, 3_250, 4_000]),
    );
    for (asked, right_us, left_us) in [
        (Wheels::STOPPED, 0, 0),
        (wheels(1.0, 0.25), 500, 125),
        (wheels(-1.0, 9.0), -500, 500),
    ] {
        let thrust = motors.drive(asked);
        assert_eq!(thrust, Ok(MotorPulses { right_us, left_us }));
    }
    done(motors);
}

#[test]
fn where_one_motor_refuses_both_are_told_to_stand() {
    // The right one is told first; then the left one is not told to turn at all.
    let mut deaf_right = motors(deaf_once(3_500, 3_000), channel(&[3_000]));
    assert_eq!(deaf_right.drive(wheels(0.5, 0.5)), Err(MotorError::Right));
    done(deaf_right);
    // The right one turns already when the left one refuses.
    let mut deaf_left = motors(channel(&[3_500, 3_000]), deaf_once(3_500, 3_000));
    assert_eq!(deaf_left.drive(wheels(0.5, 0.5)), Err(MotorError::Left));
    done(deaf_left);
}

#[test]
fn every_speed_has_the_pulse_of_the_formula_and_its_opposite_the_opposite() {
    let odd = MotorModel::try_new(MotorConfig {
        full_us: 417,
        ..MotorConfig::COMMON
    });
    for model in [MotorModel::COMMON, odd.unwrap()] {
        let full = f64::from(model.config().full_us);
        for bits in 0..=70_000 {
            let speed = Effort::from_bits(bits);
            let exact = (f64::from(bits) / 65_536.0).min(1.0) * full;
            let thrust = model.thrust_us(speed);
            assert_eq!(f64::from(thrust), (exact + 0.5).floor(), "{bits}");
            assert_eq!(model.thrust_us(-speed), -thrust);
        }
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let refused = |change: fn(&mut MotorConfig)| {
        let mut config = MotorConfig::COMMON;
        change(&mut config);
        MotorModel::try_new(config).unwrap_err()
    };
    use MotorConfigError as Why;
    assert_eq!(refused(|c| c.full_us = 0), Why::Full);
    assert_eq!(refused(|c| c.full_us = 32_768), Why::Full);
    assert_eq!(refused(|c| c.stand_us = 500), Why::Stand);
    assert_eq!(refused(|c| c.period_us = 2_000), Why::Period);
    assert_eq!(refused(|c| c.period_us = 32_768), Why::Period);
    let common = MotorModel::try_new(MotorConfig::COMMON);
    assert_eq!(common, Ok(MotorModel::COMMON));
}
