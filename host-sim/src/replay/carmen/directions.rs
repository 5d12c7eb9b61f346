//! The directions of a scan's beams, which many messages do not contain.
//!
//! In order: what the options set; the message's own fields; the log's `PARAM` lines; the lasers that
//! give this number of beams; the half plane ahead.

use crate::quantity::FieldOfView;
use certainty_core::units::BinaryAngle;
use core::f64::consts::{PI, TAU};
use core::fmt;

/// The directions of a scan's beams relative to the sensor's heading: the first, and the step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Directions {
    pub(super) start_rad: f64,
    pub(super) step_rad: f64,
}

/// Where [`Directions`] come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Basis {
    /// The options.
    Options,
    /// The message.
    Message,
    /// The message's field of view, because its step is 0.
    MessageField,
    /// `PARAM` lines.
    Parameters,
    /// A known laser has this number of beams.
    KnownCount,
    /// Nothing: the half plane ahead.
    HalfPlane,
    /// Nothing: sonars all around.
    AllAround,
}

impl fmt::Display for Basis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Options => "set by --fov and --start-angle",
            Self::Message => "as logged",
            Self::MessageField => "the logged step is 0, so by the logged field of view",
            Self::Parameters => "by the log's PARAM lines",
            Self::KnownCount => "assumed, as lasers with this number of beams have it",
            Self::HalfPlane => "assumed, since the log does not give it",
            Self::AllAround => "assumed evenly around, counter-clockwise from straight ahead",
        })
    }
}

/// The fields of a message that describe its laser.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Header {
    pub(super) start_rad: f64,
    pub(super) fov_rad: f64,
    pub(super) step_rad: f64,
}

impl Header {
    /// Whether the angles can be radians: none of them, nor the angle between the first beam and the last,
    /// is over a turn.
    pub(super) fn is_radians(self, beams: usize) -> bool {
        // Logged numbers are rounded.
        const MOST: f64 = TAU + 0.01;
        let across_rad = self.step_rad * beams.saturating_sub(1) as f64;
        [self.start_rad, self.fov_rad, self.step_rad, across_rad]
            .iter()
            .all(|angle| angle.abs() <= MOST)
    }
}

/// What `PARAM` lines give of one laser, in radians.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Parameters {
    pub(super) fov_rad: Option<f64>,
    pub(super) step_rad: Option<f64>,
}

/// What the options set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Overrides {
    pub(super) fov: Option<FieldOfView>,
    pub(super) start: Option<BinaryAngle>,
}

impl Overrides {
    /// Puts the options in the place of what was assumed or logged.
    fn apply(self, beams: usize, otherwise: (Directions, Basis)) -> (Directions, Basis) {
        let (mut directions, mut basis) = otherwise;
        if let Some(fov) = self.fov {
            let fov_rad = fov.degrees().to_radians();
            directions = centred(fov_rad, step(fov_rad, beams), beams);
            basis = Basis::Options;
        }
        if let Some(start) = self.start {
            directions.start_rad = f64::from(start.to_bits()) / 65536.0 * TAU;
        }
        (directions, basis)
    }
}

/// The directions of a laser's `beams`.
pub(super) fn of_laser(
    beams: usize,
    header: Option<Header>,
    parameters: Parameters,
    overrides: Overrides,
) -> (Directions, Basis) {
    let logged = header.and_then(|header| by_header(beams, header));
    let found = logged
        .or_else(|| by_parameters(beams, parameters))
        .or_else(|| by_count(beams))
        .unwrap_or_else(|| (centred(PI, step(PI, beams), beams), Basis::HalfPlane));
    overrides.apply(beams, found)
}

/// The directions of `beams` sonars: evenly around, the first straight ahead.
pub(super) fn of_sonars(beams: usize, overrides: Overrides) -> (Directions, Basis) {
    let around = Directions {
        start_rad: 0.0,
        step_rad: TAU / beams.max(1) as f64,
    };
    overrides.apply(beams, (around, Basis::AllAround))
}

fn by_header(beams: usize, header: Header) -> Option<(Directions, Basis)> {
    let Header {
        start_rad,
        fov_rad,
        step_rad,
    } = header;
    if step_rad != 0.0 || beams == 1 {
        let directions = Directions {
            start_rad,
            step_rad,
        };
        return Some((directions, Basis::Message));
    }
    // The field of view of an even number of beams ends at the last beam or one step behind it: the
    // first if that makes the step a whole number of eighths of a degree, as lasers have it.
    let to_last = fov_rad / (beams.max(2) - 1) as f64;
    let eighths = to_last.to_degrees() * 8.0;
    let step_rad = if fov_rad < TAU && (eighths - eighths.round()).abs() < 1e-3 {
        to_last
    } else {
        step(fov_rad, beams)
    };
    let directions = Directions {
        start_rad,
        step_rad,
    };
    (fov_rad > 0.0).then_some((directions, Basis::MessageField))
}

fn by_parameters(beams: usize, parameters: Parameters) -> Option<(Directions, Basis)> {
    let directions = match (parameters.fov_rad, parameters.step_rad) {
        (None, None) => return None,
        (Some(fov), None) => centred(fov, step(fov, beams), beams),
        (None, Some(step)) => centred(step * gaps(beams) as f64, step, beams),
        (Some(fov), Some(logged)) => {
            let last = logged * (beams.max(1) - 1) as f64;
            // Two that contradict each other: the field of view and the number of beams agree on a step.
            if (fov - last).abs() < 1.5 * logged {
                centred(fov, logged, beams)
            } else {
                centred(fov, step(fov, beams), beams)
            }
        }
    };
    Some((directions, Basis::Parameters))
}

/// The directions of lasers that are known by their number of beams.
///
/// SICK LMS 200: 180° in steps of 1° or 0.5°, 100° in steps of 0.25°. SICK LMS 100 and Hokuyo UTM-30LX:
/// 270° in steps of 0.5° or 0.25°. Hokuyo URG-04LX: 1024 steps a turn, step 384 straight ahead; a scan
/// has the steps 44 to 725 (682), 0 to 725 (726) or 0 to 768 (769). An even number of SICK's beams
/// leaves out the last direction.
fn by_count(beams: usize) -> Option<(Directions, Basis)> {
    const STEP: f64 = TAU / 1024.0;
    let urg = |first: f64| Directions {
        start_rad: -first * STEP,
        step_rad: STEP,
    };
    let even = |degrees: f64| {
        let fov = degrees.to_radians();
        centred(fov, step(fov, beams), beams)
    };
    let directions = match beams {
        180 | 181 | 360 | 361 => even(180.0),
        400 | 401 => even(100.0),
        540 | 541 | 1080 | 1081 => even(270.0),
        682 => urg(340.0),
        683 => urg(341.0),
        726 | 769 => urg(384.0),
        _ => return None,
    };
    Some((directions, Basis::KnownCount))
}

/// How many steps a field of view has: an even number of beams leaves out the last direction, an odd
/// one has beams at both ends.
fn gaps(beams: usize) -> usize {
    if beams.is_multiple_of(2) {
        beams
    } else {
        beams - 1
    }
}

/// The step of `beams` in a field of view; a full turn does not repeat its first direction.
fn step(fov_rad: f64, beams: usize) -> f64 {
    if beams < 2 {
        0.0
    } else if fov_rad >= TAU - 1e-9 {
        TAU / beams as f64
    } else {
        fov_rad / gaps(beams) as f64
    }
}

/// A field of view around the straight direction; a single beam goes straight ahead.
fn centred(fov_rad: f64, step_rad: f64, beams: usize) -> Directions {
    Directions {
        start_rad: if beams == 1 { 0.0 } else { -fov_rad / 2.0 },
        step_rad,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NO_PARAMETERS: Parameters = Parameters {
        fov_rad: None,
        step_rad: None,
    };
    const NO_OVERRIDES: Overrides = Overrides {
        fov: None,
        start: None,
    };

    /// First direction, step and last direction in degrees, rounded to 1e-4.
    fn degrees(beams: usize, (directions, basis): (Directions, Basis)) -> ([f64; 3], Basis) {
        let last = directions.start_rad + (beams - 1) as f64 * directions.step_rad;
        let round = |rad: f64| (rad.to_degrees() * 1e4).round() / 1e4;
        let Directions {
            start_rad,
            step_rad,
        } = directions;
        ([start_rad, step_rad, last].map(round), basis)
    }

    fn guess(beams: usize) -> ([f64; 3], Basis) {
        degrees(beams, of_laser(beams, None, NO_PARAMETERS, NO_OVERRIDES))
    }

    fn by_param(beams: usize, fov: Option<f64>, step: Option<f64>) -> [f64; 3] {
        let parameters = Parameters {
            fov_rad: fov.map(f64::to_radians),
            step_rad: step.map(f64::to_radians),
        };
        let (found, basis) = degrees(beams, of_laser(beams, None, parameters, NO_OVERRIDES));
        assert_eq!(basis, Basis::Parameters);
        found
    }

    fn by_message(beams: usize, fov: f64, step: f64) -> ([f64; 3], Basis) {
        let header = Header {
            start_rad: -fov.to_radians() / 2.0,
            fov_rad: fov.to_radians(),
            step_rad: step.to_radians(),
        };
        degrees(
            beams,
            of_laser(beams, Some(header), NO_PARAMETERS, NO_OVERRIDES),
        )
    }

    fn with(beams: usize, fov: Option<&str>, start: Option<f64>) -> ([f64; 3], Basis) {
        let overrides = Overrides {
            fov: fov.map(|text| crate::quantity::field_of_view(text).unwrap()),
            start: start.map(|degrees| BinaryAngle::from_millidegrees((degrees * 1000.0) as i32)),
        };
        let (mut directions, basis) = of_laser(beams, None, NO_PARAMETERS, overrides);
        if directions.start_rad > PI {
            directions.start_rad -= TAU;
        }
        degrees(beams, (directions, basis))
    }

    #[test]
    fn known_counts_have_their_field_of_view() {
        for (beams, expected) in [
            (180, [-90.0, 1.0, 89.0]),
            (181, [-90.0, 1.0, 90.0]),
            (360, [-90.0, 0.5, 89.5]),
            (361, [-90.0, 0.5, 90.0]),
            (400, [-50.0, 0.25, 49.75]),
            (401, [-50.0, 0.25, 50.0]),
            (540, [-135.0, 0.5, 134.5]),
            (541, [-135.0, 0.5, 135.0]),
            (1081, [-135.0, 0.25, 135.0]),
            (682, [-119.5313, 0.3516, 119.8828]),
            (683, [-119.8828, 0.3516, 119.8828]),
            (726, [-135.0, 0.3516, 119.8828]),
            (769, [-135.0, 0.3516, 135.0]),
        ] {
            assert_eq!(guess(beams), (expected, Basis::KnownCount), "{beams}");
        }
    }

    #[test]
    fn other_counts_cover_the_half_plane_by_parity() {
        for (beams, expected) in [
            (1, [0.0, 0.0, 0.0]),
            (2, [-90.0, 90.0, 0.0]),
            (3, [-90.0, 90.0, 90.0]),
            (90, [-90.0, 2.0, 88.0]),
            (91, [-90.0, 2.0, 90.0]),
        ] {
            assert_eq!(guess(beams), (expected, Basis::HalfPlane), "{beams}");
        }
    }

    #[test]
    fn parameters_come_before_known_counts() {
        let resolution = |beams, step| by_param(beams, None, Some(step));
        assert_eq!(resolution(181, 0.5), [-45.0, 0.5, 45.0]);
        assert_eq!(resolution(180, 1.0), [-90.0, 1.0, 89.0]);
        assert_eq!(by_param(271, Some(270.0), None), [-135.0, 1.0, 135.0]);
        assert_eq!(by_param(360, Some(360.0), None), [-180.0, 1.0, 179.0]);
        let both = by_param(1081, Some(270.0), Some(0.25));
        assert_eq!(both, [-135.0, 0.25, 135.0]);
        // The step of a file of defaults contradicts the number of beams.
        let contradiction = by_param(361, Some(180.0), Some(1.0));
        assert_eq!(contradiction, [-90.0, 0.5, 90.0]);
    }

    #[test]
    fn message_comes_before_parameters() {
        assert_eq!(
            by_message(181, 180.0, 1.0),
            ([-90.0, 1.0, 90.0], Basis::Message)
        );
        for (beams, fov, step) in [
            (181, 180.0, 1.0),
            (180, 180.0, 1.0),
            (180, 179.0, 1.0),
            (360, 179.5, 0.5),
            (360, 360.0, 1.0),
            (1081, 270.0, 0.25),
        ] {
            let ([first, found, _], basis) = by_message(beams, fov, 0.0);
            assert_eq!((first, found), (-fov / 2.0, step), "{beams} {fov}");
            assert_eq!(basis, Basis::MessageField);
        }
        // Neither a step nor a field of view.
        assert_eq!(by_message(181, 0.0, 0.0), guess(181));
    }

    #[test]
    fn options_come_before_everything() {
        let [full, wider] = ["360deg", "400deg"].map(|fov| with(360, Some(fov), None));
        assert_eq!(full, ([-180.0, 1.0, 179.0], Basis::Options));
        assert_eq!(wider, full);
        assert_eq!(with(361, Some("90deg"), None).0, [-45.0, 0.25, 45.0]);
        assert_eq!(with(360, Some("90deg"), None).0, [-45.0, 0.25, 44.75]);
        let turned = with(181, Some("180deg"), Some(-45.0));
        assert_eq!(turned.0, [-45.0, 1.0, 135.0]);
        // A start alone keeps the steps.
        assert_eq!(
            with(181, None, Some(-45.0)),
            ([-45.0, 1.0, 135.0], Basis::KnownCount)
        );
    }

    #[test]
    fn sonars_are_evenly_around() {
        assert_eq!(
            degrees(8, of_sonars(8, NO_OVERRIDES)),
            ([0.0, 45.0, 315.0], Basis::AllAround)
        );
    }
}
