//! The car's wiring where every connection is at the far end of a link.

use super::{HEADS, RANGERS};
use crate::board::{HeadWires, MotorWires, RangerWires, Start, Wiring};
use crate::remote::{
    Channel, Line, Link, RemoteBoard, RemoteOutbox, RemotePin, RemotePwm, RemoteTime,
};

/// Returns the wiring of a car whose pins, pulses and time are at the far end of `link`.
pub fn remote_wiring<L: Link>(
    link: &L,
) -> Wiring<RemoteBoard<'_, L>, { HEADS as usize }, { RANGERS as usize }> {
    let head = |slot| HeadWires {
        vin: RemotePin::new(link, Line::Vin(slot)),
        vout: RemotePin::new(link, Line::Vout(slot)),
        pwm: RemotePwm::new(link, Channel::Servo(slot)),
    };
    let ranger = |slot| RangerWires {
        trigger: RemotePin::new(link, Line::Trigger(slot)),
        echo: RemotePin::new(link, Line::Echo(slot)),
    };
    Wiring {
        heads: [head(0), head(1), head(2)],
        rangers: [ranger(0), ranger(1)],
        motors: MotorWires {
            right: RemotePwm::new(link, Channel::Motor(0)),
            left: RemotePwm::new(link, Channel::Motor(1)),
        },
        delay: RemoteTime::new(link),
        stopwatch: RemoteTime::new(link),
        outbox: RemoteOutbox::new(link),
        start: Start::ByHand,
    }
}
