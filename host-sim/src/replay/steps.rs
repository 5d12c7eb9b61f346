//! The robot's steps between poses, and poses far from all others.

use super::line_index::LineIndex;
use super::recording::{Recording, SkipReason};
use certainty_core::units::{Millimeters, Point};
use core::fmt;
use core::ops::Range;

/// A pose far from those before and after it, compared with the other steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StrayPose {
    /// Its line in the file, from 1.
    pub line: u64,
    /// Where it is.
    pub at: Point,
    /// The step to it, or from it if it is the first.
    pub step: Millimeters,
    /// Half of all steps are below this.
    pub median_step: Millimeters,
}

impl fmt::Display for StrayPose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "line {} has a pose at {}mm,{}mm, a step of {} where half of all are below {}; --max-step \
             LENGTH leaves out beams behind such a step",
            self.line,
            self.at.x_mm(),
            self.at.y_mm(),
            self.step,
            self.median_step
        )
    }
}

/// A step is far beyond the others if it is this many times the median one …
const TIMES_THE_MEDIAN: u64 = 50;
/// … and at least this long, in millimetres.
const LEAST_STEP: u64 = 10_000;

fn step(from: Point, to: Point) -> u64 {
    let along = i64::from(to.x_mm()) - i64::from(from.x_mm());
    let across = i64::from(to.y_mm()) - i64::from(from.y_mm());
    ((along * along + across * across) as u64).isqrt()
}

/// The upper bound of a power of two's bin that holds the median of all steps that are not 0.
fn median(counts: &[u64; 64]) -> u64 {
    let all: u64 = counts.iter().sum();
    let mut below = 0;
    for (power, count) in counts.iter().enumerate() {
        below += count;
        if 2 * below >= all.max(1) {
            return 2_u64.saturating_pow(power as u32 + 1);
        }
    }
    u64::MAX
}

impl Recording {
    /// Returns the ranges of successive beams between two steps for which `apart` holds.
    fn segments(&self, apart: impl Fn(u64) -> bool) -> Vec<Range<usize>> {
        let mut segments = Vec::new();
        let mut start = 0;
        for (place, pair) in self.beams.windows(2).enumerate() {
            if pair[0].origin != pair[1].origin && apart(step(pair[0].origin, pair[1].origin)) {
                segments.push(start..place + 1);
                start = place + 1;
            }
        }
        segments.push(start..self.beams.len());
        segments
    }

    /// Returns the first pose far beyond what the other steps show, if there is one.
    ///
    /// Of two poses with a long step between them it is the one in the shorter piece of the track.
    #[must_use]
    pub fn stray_pose(&self) -> Option<StrayPose> {
        let mut counts = [0; 64];
        for pair in self.beams.windows(2) {
            if pair[0].origin != pair[1].origin {
                let length = step(pair[0].origin, pair[1].origin).max(1);
                counts[length.ilog2() as usize] += 1;
            }
        }
        let median = median(&counts);
        let far = median.saturating_mul(TIMES_THE_MEDIAN).max(LEAST_STEP);
        let segments = self.segments(|step| step > far);
        let (before, after) = match &segments[..] {
            [before, after, ..] => (before, after),
            _ => return None,
        };
        let (from, to) = (before.end - 1, after.start);
        let stray = if before.start == 0 && before.len() < after.len() {
            from
        } else {
            to
        };
        let length = step(self.beams[from].origin, self.beams[to].origin);
        let millimetres = |length: u64| Millimeters::new(u32::try_from(length).unwrap_or(u32::MAX));
        Some(StrayPose {
            line: self.lines.line(stray),
            at: self.beams[stray].origin,
            step: millimetres(length),
            median_step: millimetres(median),
        })
    }

    /// Leaves out beams whose pose is more than `most` from that of the nearest kept beam in the file,
    /// and counts their lines as [`SkipReason::FarStep`].
    ///
    /// The longest piece of the track without such a step is kept, then what continues it in both
    /// directions.
    pub(super) fn leave_out_far_steps(&mut self, most: Millimeters) {
        let most = u64::from(most.get());
        let segments = self.segments(|step| step > most);
        // Of equally long ones the first.
        let Some(longest) = (0..segments.len())
            .rev()
            .max_by_key(|&place| segments[place].len())
        else {
            return;
        };
        let mut kept = vec![false; segments.len()];
        kept[longest] = true;
        let near = |one: usize, other: usize| {
            step(self.beams[one].origin, self.beams[other].origin) <= most
        };
        let mut last = segments[longest].clone();
        for place in longest + 1..segments.len() {
            if near(last.end - 1, segments[place].start) {
                kept[place] = true;
                last = segments[place].clone();
            }
        }
        let mut last = segments[longest].clone();
        for place in (0..longest).rev() {
            if near(segments[place].end - 1, last.start) {
                kept[place] = true;
                last = segments[place].clone();
            }
        }
        let mut beams = Vec::new();
        let mut lines = LineIndex::default();
        for (segment, kept) in segments.into_iter().zip(kept) {
            let mut start = segment.start;
            while start < segment.end {
                let line = self.lines.line(start);
                let end = (start + 1..segment.end)
                    .find(|&beam| self.lines.line(beam) != line)
                    .unwrap_or(segment.end);
                if kept {
                    let first = beams.len();
                    beams.extend_from_slice(&self.beams[start..end]);
                    lines.push(line, first, beams.len());
                } else {
                    self.skipped.add(line, SkipReason::FarStep);
                }
                start = end;
            }
        }
        self.beams = beams;
        self.lines = lines;
    }
}
