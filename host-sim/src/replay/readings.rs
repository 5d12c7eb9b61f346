//! Readings files, the interchange format of this project: CSV with one beam a line.
//!
//! The six fields are numbers and plain words without quotes, so a line is split at its commas.

use super::recording::{RecordedBeam, SkipReason};
use crate::quantity;
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Missing, Reading};
use certainty_core::units::{BinaryAngle, Millimeters, Point, Ticks};

/// The first line of a readings file.
pub const HEADER: &str = "t_ms,sensor,x_mm,y_mm,bearing_mdeg,reading";

/// Millidegrees of a turn.
const TURN: i64 = 360_000;

/// Returns the beams' opening angle if `line` is a comment such as `# beam-width: 20deg`, or why it is
/// not an angle.
///
/// The six columns do not have the width of a beam; a file has it once.
pub(super) fn beam_width(line: &str) -> Option<Result<BinaryAngle, SkipReason>> {
    let note = line.strip_prefix('#')?.trim().strip_prefix("beam-width:")?;
    Some(quantity::opening(note.trim()).map_err(|_| SkipReason::BadBeamWidth))
}

/// Returns `beams` as a readings file, for tests.
///
/// Reading the file gives the same beams, bit for bit, with one exception: all kinds of missing
/// readings are written as `missing`, which is read as [`Missing::Timeout`]. A step of
/// [`BinaryAngle`] is 5.5 millidegrees, so a bearing in whole millidegrees identifies its step.
#[cfg(test)]
pub(super) fn written(beams: &[RecordedBeam]) -> String {
    let mut text = format!("{HEADER}\n");
    for beam in beams {
        let mdeg = (i64::from(beam.bearing.to_bits()) * TURN + (1 << 15)) >> 16;
        text += &format!(
            "{},{},{},{},{mdeg},",
            beam.at.get(),
            beam.sensor,
            beam.origin.x_mm(),
            beam.origin.y_mm()
        );
        text += &match beam.reading {
            Reading::Echo(distance) => format!("{}\n", distance.get()),
            Reading::NoObject => "none\n".to_owned(),
            Reading::TooNear => "near\n".to_owned(),
            Reading::Missing(_) => "missing\n".to_owned(),
        };
    }
    text
}

/// Parses one line; `None` if it is the header, a comment or blank.
///
/// Echoes at `max_range` or beyond are no object.
pub(super) fn parse(
    line: &str,
    max_range: Option<Millimeters>,
) -> Result<Option<RecordedBeam>, SkipReason> {
    let line = line.trim_ascii();
    if line.is_empty() || line.starts_with('#') || line == HEADER {
        return Ok(None);
    }
    let mut fields = line.split(',').map(str::trim_ascii);
    let mut field = || fields.next().ok_or(SkipReason::FieldCount);
    let (at, sensor, x, y, bearing, reading) =
        (field()?, field()?, field()?, field()?, field()?, field()?);
    if fields.next().is_some() {
        return Err(SkipReason::FieldCount);
    }
    let at = u32::try_from(number(at)?).map_err(|_| SkipReason::BadTime)?;
    let sensor = u8::try_from(number(sensor)?)
        .ok()
        .and_then(SensorId::try_new)
        .ok_or(SkipReason::BadSensor)?;
    let origin = Point::from_mm(coordinate(x)?, coordinate(y)?);
    // A number within a turn fits.
    let within_turn = i32::try_from(number(bearing)?.rem_euclid(TURN)).unwrap_or(0);
    let reading = match reading {
        "none" => Reading::NoObject,
        "near" => Reading::TooNear,
        "missing" => Reading::Missing(Missing::Timeout),
        digits => {
            let mm = digits.parse().map_err(|_| SkipReason::BadReading)?;
            let distance = Millimeters::new(mm);
            if max_range.is_some_and(|limit| distance >= limit) {
                Reading::NoObject
            } else {
                Reading::Echo(distance)
            }
        }
    };
    Ok(Some(RecordedBeam {
        at: Ticks::new(at),
        sensor,
        origin,
        bearing: BinaryAngle::from_millidegrees(within_turn),
        reading,
    }))
}

fn number(text: &str) -> Result<i64, SkipReason> {
    text.parse().map_err(|_| SkipReason::NotANumber)
}

/// A coordinate in millimetres that a [`Point`] can hold.
fn coordinate(text: &str) -> Result<i32, SkipReason> {
    let mm = i32::try_from(number(text)?).map_err(|_| SkipReason::OutOfReach)?;
    if mm.unsigned_abs() > Point::LIMIT.unsigned_abs() {
        return Err(SkipReason::OutOfReach);
    }
    Ok(mm)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn line_of_each_kind_is_parsed() {
        let reading = |word: &str| {
            let line = format!("1500,3,-20,40,-90000,{word}");
            parse(&line, None).unwrap().unwrap()
        };
        let beam = reading("1234");
        assert_eq!(beam.at, Ticks::new(1500));
        assert_eq!(beam.sensor.number(), 3);
        assert_eq!(beam.origin, Point::from_mm(-20, 40));
        assert_eq!(beam.bearing.to_bits(), 0xC000);
        assert_eq!(beam.reading, Reading::Echo(Millimeters::new(1234)));
        assert_eq!(reading("none").reading, Reading::NoObject);
        assert_eq!(reading("near").reading, Reading::TooNear);
        assert_eq!(
            reading("missing").reading,
            Reading::Missing(Missing::Timeout)
        );
    }

    #[test]
    fn header_comments_and_blanks_have_no_beams() {
        for line in ["", "  ", "\r", "# 1,2,3", HEADER, &format!("{HEADER}\r")] {
            assert_eq!(parse(line, None), Ok(None), "{line:?}");
        }
    }

    #[test]
    fn wrong_field_names_its_reason() {
        for (line, reason) in [
            ("0,1,0,0,0", SkipReason::FieldCount),
            ("0,1,0,0,0,5,6", SkipReason::FieldCount),
            ("0,1,0,0,0,", SkipReason::BadReading),
            ("0,1,0,0,0,-5", SkipReason::BadReading),
            ("0,1,0,0,0,NaN", SkipReason::BadReading),
            ("0,1,0,0,0,1e3", SkipReason::BadReading),
            ("0,1,0,0,0,4294967296", SkipReason::BadReading),
            ("0,0,0,0,0,5", SkipReason::BadSensor),
            ("0,256,0,0,0,5", SkipReason::BadSensor),
            ("0,-1,0,0,0,5", SkipReason::BadSensor),
            ("-1,1,0,0,0,5", SkipReason::BadTime),
            ("4294967296,1,0,0,0,5", SkipReason::BadTime),
            ("0,1,268435457,0,0,5", SkipReason::OutOfReach),
            ("0,1,0,-2147483648,0,5", SkipReason::OutOfReach),
            ("0,1,0,99999999999,0,5", SkipReason::OutOfReach),
            ("0,1,nan,0,0,5", SkipReason::NotANumber),
            ("0,1,1.5,0,0,5", SkipReason::NotANumber),
            ("0,1,0,0,99999999999999999999,5", SkipReason::NotANumber),
        ] {
            assert_eq!(parse(line, None), Err(reason), "{line}");
        }
    }

    #[test]
    fn far_echoes_become_no_object() {
        let reading = |mm: u32, limit: u32| {
            let line = format!("0,1,0,0,0,{mm}");
            parse(&line, Some(Millimeters::new(limit)))
                .unwrap()
                .unwrap()
                .reading
        };
        assert_eq!(reading(3999, 4000), Reading::Echo(Millimeters::new(3999)));
        assert_eq!(reading(4000, 4000), Reading::NoObject);
        assert_eq!(reading(u32::MAX, 4000), Reading::NoObject);
    }

    #[test]
    fn a_beam_is_a_line_below_the_header() {
        let beam = RecordedBeam {
            at: Ticks::new(40),
            sensor: SensorId::try_new(2).unwrap(),
            origin: Point::from_mm(-100, 250),
            bearing: BinaryAngle::QUARTER,
            reading: Reading::NoObject,
        };
        let expected = "t_ms,sensor,x_mm,y_mm,bearing_mdeg,reading\n40,2,-100,250,90000,none\n";
        assert_eq!(written(&[beam]), expected);
    }

    #[test]
    fn every_bearing_survives_millidegrees() {
        for bits in 0..=u16::MAX {
            let beam = RecordedBeam {
                at: Ticks::new(0),
                sensor: SensorId::try_new(1).unwrap(),
                origin: Point::ORIGIN,
                bearing: BinaryAngle::from_bits(bits),
                reading: Reading::TooNear,
            };
            let text = written(&[beam]);
            let back = parse(text.lines().nth(1).unwrap(), None);
            assert_eq!(back, Ok(Some(beam)));
        }
    }
}
