//! Synthetic recordings: the log of a laser in a known room.

use core::f64::consts::{FRAC_PI_2, PI};
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;

/// A wall from one corner to the next, in metres.
type Wall = ([f64; 2], [f64; 2]);

/// A room: a closed line of walls.
#[derive(Debug, Clone)]
pub(crate) struct Room {
    corners: Vec<[f64; 2]>,
}

/// The laser's pose: metres and radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    /// Metres.
    pub(crate) x: f64,
    /// Metres.
    pub(crate) y: f64,
    /// Radians, counter-clockwise from +x.
    pub(crate) heading: f64,
}

/// A laser's range without an echo, in metres.
pub(crate) const NO_ECHO_M: f64 = 81.83;

/// Beams of a scan, over the half circle ahead.
pub(crate) const BEAMS: usize = 180;

impl Room {
    /// Creates the room between `corners`, each joined to the next and the last to the first.
    #[must_use]
    pub(crate) fn new(corners: &[[f64; 2]]) -> Self {
        Self {
            corners: corners.to_vec(),
        }
    }

    fn walls(&self) -> impl Iterator<Item = Wall> + '_ {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().copied().zip(next.copied())
    }

    /// Returns how far it is from (`x`, `y`) along `bearing` to the nearest wall.
    #[must_use]
    pub(crate) fn distance(&self, x: f64, y: f64, bearing: f64) -> f64 {
        let (dy, dx) = bearing.sin_cos();
        let hits = self.walls().filter_map(|([ax, ay], [bx, by])| {
            let (ex, ey) = (bx - ax, by - ay);
            let cross = dx * ey - dy * ex;
            let along = ((ax - x) * ey - (ay - y) * ex) / cross;
            let part = ((ax - x) * dy - (ay - y) * dx) / cross;
            (along > 0.0 && (0.0..=1.0).contains(&part)).then_some(along)
        });
        hits.fold(f64::INFINITY, f64::min)
    }

    /// Returns the ranges of a scan of [`BEAMS`] beams, the first a quarter turn to the right.
    #[must_use]
    pub(crate) fn scan(&self, place: Place) -> Vec<f64> {
        let bearing = |beam: usize| place.heading - FRAC_PI_2 + beam as f64 * PI / BEAMS as f64;
        (0..BEAMS)
            .map(|beam| self.distance(place.x, place.y, bearing(beam)))
            .map(|metres| {
                if metres < NO_ECHO_M {
                    metres
                } else {
                    NO_ECHO_M
                }
            })
            .collect()
    }
}

/// Returns four poses at (`x`, `y`): their half circles cover every direction twice.
#[must_use]
pub(crate) fn all_around(x: f64, y: f64) -> [Place; 4] {
    let place = |quarter: u8| Place {
        x,
        y,
        heading: f64::from(quarter) * FRAC_PI_2,
    };
    [0, 1, 2, 3].map(place)
}

/// Returns a `FLASER` line of a CARMEN log.
#[must_use]
pub(crate) fn flaser(ranges: &[f64], place: Place, time_s: f64) -> String {
    let Place { x, y, heading } = place;
    format!(
        "FLASER {} {} {x} {y} {heading} {x} {y} {heading} {time_s} robot {time_s}\n",
        ranges.len(),
        joined(ranges)
    )
}

/// Returns a `ROBOTLASER1` line of a CARMEN log for the same beams as [`flaser`].
#[must_use]
pub(crate) fn robotlaser(ranges: &[f64], place: Place, time_s: f64) -> String {
    let Place { x, y, heading } = place;
    format!(
        "ROBOTLASER1 0 {} {PI} {} {NO_ECHO_M} 0.01 0 {} {} 0 {x} {y} {heading} {x} {y} {heading} \
         0 0 0.5 0.5 1000000 {time_s} robot {time_s}\n",
        -FRAC_PI_2,
        PI / ranges.len() as f64,
        ranges.len(),
        joined(ranges)
    )
}

/// Returns a log of `room` seen from `places`, a scan every 100 ms, a line each by `line`.
#[must_use]
pub(crate) fn log(
    room: &Room,
    places: &[Place],
    line: impl Fn(&[f64], Place, f64) -> String,
) -> String {
    let scans = places.iter().zip(0_u32..);
    scans
        .map(|(&place, number)| line(&room.scan(place), place, f64::from(number) / 10.0))
        .collect()
}

/// Compresses `bytes`; writing to memory never fails.
#[must_use]
pub(crate) fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).expect("memory takes every byte");
    encoder.finish().expect("memory takes every byte")
}

fn joined(ranges: &[f64]) -> String {
    let texts: Vec<String> = ranges.iter().map(f64::to_string).collect();
    texts.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scan_of_a_square_has_the_right_ranges() {
        let room = Room::new(&[[-1.0, -1.0], [3.0, -1.0], [3.0, 1.0], [-1.0, 1.0]]);
        let place = Place {
            x: 0.0,
            y: 0.0,
            heading: 0.0,
        };
        let scan = room.scan(place);
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        assert!(near(scan[0], 1.0), "right");
        assert!(near(scan[90], 3.0), "ahead");
        assert!(
            near(scan[135], 2.0_f64.sqrt()),
            "left ahead, to the wall above"
        );
        assert!(
            near(scan[30], 2.0 / 3.0_f64.sqrt()),
            "60 degrees to the right"
        );
    }
}
