//! The wire form of requests and answers.

use super::{Channel, Line, Refused, Request};

/// Bytes of a request: its kind, its place, its value with the lowest byte first.
pub const REQUEST: usize = 6;

/// Bytes of an answer: [`YES`] or [`NO`], its value and the time in microseconds, both with the
/// lowest byte first.
pub const ANSWER: usize = 9;

/// The request was carried out.
pub const YES: u8 = b'+';

/// It was not.
pub const NO: u8 = b'-';

/// Instead of a request: so many bytes of telemetry follow, which are not answered.
pub const REPORT: u8 = b'#';

/// The kind of [`Request::Feed`], with which a round ends.
pub const FEED: u8 = b'F';

const fn line(line: Line) -> (u8, u8) {
    match line {
        Line::Vin(slot) => (b'i', slot),
        Line::Vout(slot) => (b'o', slot),
        Line::Trigger(slot) => (b't', slot),
        Line::Echo(slot) => (b'e', slot),
    }
}

/// Returns the bytes of `request`.
///
/// A line's letter is small where it is asked and large where it is driven.
#[must_use]
pub fn encode(request: Request) -> [u8; REQUEST] {
    let (kind, place, value) = match request {
        Request::Drive(at, high) => {
            let (letter, slot) = line(at);
            (letter.to_ascii_uppercase(), slot, u32::from(high))
        }
        Request::Level(at) => {
            let (letter, slot) = line(at);
            (letter, slot, 0)
        }
        Request::Pulse(Channel::Servo(slot), micros) => (b'P', slot, u32::from(micros)),
        Request::Pulse(Channel::Motor(side), micros) => (b'M', side, u32::from(micros)),
        Request::Pass(nanoseconds) => (b'D', 0, nanoseconds),
        Request::Until(tick) => (b'N', 0, tick),
        Request::Tick => (b'n', 0, 0),
        Request::Micros => (b'u', 0, 0),
        Request::Feed => (FEED, 0, 0),
        Request::Unused(bytes) => (b'S', 0, bytes),
    };
    let [a, b, c, d] = value.to_le_bytes();
    [kind, place, a, b, c, d]
}

/// Returns the request that these bytes are; `None` if they are none.
#[must_use]
pub fn decode([kind, place, a, b, c, d]: [u8; REQUEST]) -> Option<Request> {
    let value = u32::from_le_bytes([a, b, c, d]);
    let line = |letter: u8| match letter {
        b'i' => Some(Line::Vin(place)),
        b'o' => Some(Line::Vout(place)),
        b't' => Some(Line::Trigger(place)),
        b'e' => Some(Line::Echo(place)),
        _ => None,
    };
    Some(match kind {
        b'P' => Request::Pulse(Channel::Servo(place), u16::try_from(value).ok()?),
        b'M' => Request::Pulse(Channel::Motor(place), u16::try_from(value).ok()?),
        b'D' => Request::Pass(value),
        b'N' => Request::Until(value),
        b'n' => Request::Tick,
        b'u' => Request::Micros,
        FEED => Request::Feed,
        b'S' => Request::Unused(value),
        b'i' | b'o' | b't' | b'e' => Request::Level(line(kind)?),
        _ => Request::Drive(line(kind.to_ascii_lowercase())?, value != 0),
    })
}

/// Returns the bytes of an answer.
#[must_use]
pub fn answer(answer: Result<u32, Refused>, micros: u32) -> [u8; ANSWER] {
    let (kind, value) = match answer {
        Ok(value) => (YES, value),
        Err(Refused) => (NO, 0),
    };
    let [a, b, c, d] = value.to_le_bytes();
    let [e, f, g, h] = micros.to_le_bytes();
    [kind, a, b, c, d, e, f, g, h]
}

/// Returns the answer that these bytes are, and the time; what is no answer is a refusal.
pub const fn answered(bytes: [u8; ANSWER]) -> (Result<u32, Refused>, u32) {
    let [kind, a, b, c, d, e, f, g, h] = bytes;
    let answer = if kind == YES {
        Ok(u32::from_le_bytes([a, b, c, d]))
    } else {
        Err(Refused)
    };
    (answer, u32::from_le_bytes([e, f, g, h]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn lines() -> impl Strategy<Value = Line> {
        (0..4, any::<u8>()).prop_map(|(kind, slot)| match kind {
            0 => Line::Vin(slot),
            1 => Line::Vout(slot),
            2 => Line::Trigger(slot),
            _ => Line::Echo(slot),
        })
    }

    fn channels() -> impl Strategy<Value = Channel> {
        any::<(bool, u8)>().prop_map(|(motor, place)| {
            if motor {
                Channel::Motor(place)
            } else {
                Channel::Servo(place)
            }
        })
    }

    fn requests() -> impl Strategy<Value = Request> {
        prop_oneof![
            (lines(), any::<bool>()).prop_map(|(line, high)| Request::Drive(line, high)),
            lines().prop_map(Request::Level),
            (channels(), any::<u16>())
                .prop_map(|(channel, micros)| Request::Pulse(channel, micros)),
            any::<u32>().prop_map(Request::Pass),
            any::<u32>().prop_map(Request::Until),
            Just(Request::Tick),
            Just(Request::Micros),
            Just(Request::Feed),
            any::<u32>().prop_map(Request::Unused),
        ]
    }

    proptest! {
        #[test]
        fn a_request_arrives_as_it_was_sent_and_is_never_taken_for_a_report(request in requests()) {
            let bytes = encode(request);
            prop_assert_eq!(decode(bytes), Some(request));
            prop_assert_ne!(bytes[0], REPORT);
            prop_assert_eq!(bytes[0] == FEED, request == Request::Feed);
        }

        #[test]
        fn any_bytes_are_a_request_or_none(bytes in any::<[u8; REQUEST]>()) {
            if let Some(request) = decode(bytes) {
                prop_assert_eq!(decode(encode(request)), Some(request));
            }
        }

        #[test]
        fn an_answer_arrives_with_its_time(value in any::<u32>(), micros in any::<u32>()) {
            for told in [Ok(value), Err(Refused)] {
                let bytes = answer(told, micros);
                prop_assert_eq!(answered(bytes), (told, micros));
            }
        }
    }

    #[test]
    fn what_is_no_answer_is_a_refusal() {
        assert_eq!(answered([b'?'; ANSWER]).0, Err(Refused));
    }
}
