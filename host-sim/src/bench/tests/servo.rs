use super::pins::{Clock, servo};
use crate::bench::MILLISECOND;
use certainty_core::units::BinaryAngle;
use certainty_firmware::servo::{ServoConfig, ServoModel};
use certainty_firmware::smart_car::SWEEP;

use crate::bench::{ServoShaft, pulse_of};

#[test]
fn a_head_looks_exactly_where_its_sweep_says_once_it_had_its_time() {
    let clock = Clock::new(0);
    let (mut servo, shaft) = servo(&clock, 2_400);
    for step in 0..3 * u32::from(SWEEP.directions()) {
        for head in 0..3 {
            let direction = SWEEP.direction(step, head, 3);
            let aimed = servo.aim(direction).unwrap();
            clock.advance(u64::from(aimed.settle_ms) * MILLISECOND);
            let shaft = shaft.borrow();
            assert!(shaft.is_settled(clock.now()));
            assert_eq!(shaft.angle(clock.now()), direction);
        }
    }
}

#[test]
fn the_worst_time_is_enough_from_anywhere_and_half_of_it_is_not() {
    for pulse_us in [600, 1_500, 2_400] {
        let clock = Clock::new(0);
        let (mut servo, shaft) = servo(&clock, pulse_us);
        let aimed = servo.aim(BinaryAngle::from_millidegrees(-90_000)).unwrap();
        assert_eq!(aimed.settle_ms, ServoModel::COMMON.worst_settling_ms());
        clock.advance(u64::from(aimed.settle_ms / 2) * MILLISECOND);
        assert_eq!(shaft.borrow().is_settled(clock.now()), pulse_us < 2_400);
        clock.advance(u64::from(aimed.settle_ms / 2) * MILLISECOND);
        assert!(shaft.borrow().is_settled(clock.now()));
    }
}

#[test]
fn the_shaft_turns_at_its_speed_and_changes_its_mind_on_the_way() {
    let degrees = |degrees: i32| BinaryAngle::from_millidegrees(degrees * 1_000);
    let mut shaft = ServoShaft::new(ServoConfig::COMMON, 1_500);
    shaft.set_pulse(2_100, 0); // 60°, 200 ms away
    assert_eq!(shaft.angle(0), degrees(0));
    assert_eq!(shaft.angle(100 * MILLISECOND), degrees(30));
    assert!(!shaft.is_settled(200 * MILLISECOND - 1));
    assert!(shaft.is_settled(200 * MILLISECOND));
    shaft.set_pulse(1_500, 100 * MILLISECOND);
    assert_eq!(shaft.angle(150 * MILLISECOND), degrees(15));
    shaft.set_pulse(0, 150 * MILLISECOND);
    assert_eq!(shaft.angle(u64::MAX), degrees(15));
    // No pulse turns it past its stops.
    shaft.set_pulse(9_999, 150 * MILLISECOND);
    assert_eq!(shaft.angle(u64::MAX), degrees(90));
}

#[test]
fn a_jammed_shaft_stays_and_goes_on_when_it_is_freed() {
    let clock = Clock::new(0);
    let (mut servo, shaft) = servo(&clock, 1_500);
    let target = BinaryAngle::from_millidegrees(45_000);
    shaft.borrow_mut().set_jammed(true, clock.now());
    let aimed = servo.aim(target).unwrap();
    clock.advance(u64::from(aimed.settle_ms) * MILLISECOND);
    assert_eq!(shaft.borrow().angle(clock.now()), BinaryAngle::ZERO);
    shaft.borrow_mut().set_jammed(false, clock.now());
    clock.advance(150 * MILLISECOND);
    assert_eq!(shaft.borrow().angle(clock.now()), target);
}

#[test]
fn an_upside_down_servo_turns_the_other_way() {
    let config = ServoConfig {
        quarter_us: -900,
        ..ServoConfig::COMMON
    };
    let model = ServoModel::try_new(config).unwrap();
    for millidegrees in [-90_000, -33_300, 0, 5_000, 90_000] {
        let angle = BinaryAngle::from_millidegrees(millidegrees);
        let pulse = model.pulse_us(angle).unwrap();
        let at = ServoShaft::new(config, pulse.into()).angle(0);
        assert!(at.separation(angle).to_bits() <= 9); // half a microsecond of 900 in 16384 steps
    }
}

#[test]
fn a_channel_without_steps_has_no_pulses() {
    assert_eq!(pulse_of(0, 40_000, 20_000), 0);
    assert_eq!(pulse_of(3_000, 40_000, 20_000), 1_500);
    assert_eq!(pulse_of(1, 0, 20_000), 0);
}
