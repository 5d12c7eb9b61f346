//! Which line of a file a beam is from.

/// The lines of beams: which line of the file a beam is from.
///
/// Memory: 24 bytes for each irregularity, such as a comment between two lines.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct LineIndex {
    runs: Vec<Run>,
}

/// Successive lines with the same number of beams.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Run {
    first_beam: usize,
    first_line: u64,
    beams_a_line: usize,
}

impl LineIndex {
    /// Notes that the beams from `first_beam` to before `end` are from `line`.
    pub(super) fn push(&mut self, line: u64, first_beam: usize, end: usize) {
        let beams_a_line = end - first_beam;
        if beams_a_line == 0 {
            return;
        }
        let continued = self.runs.last().is_some_and(|run| {
            let lines = (first_beam - run.first_beam) / run.beams_a_line;
            run.beams_a_line == beams_a_line
                && (first_beam - run.first_beam).is_multiple_of(run.beams_a_line)
                && run.first_line + lines as u64 == line
        });
        if !continued {
            self.runs.push(Run {
                first_beam,
                first_line: line,
                beams_a_line,
            });
        }
    }

    /// Returns the line of a beam; 0 without any.
    pub(super) fn line(&self, beam: usize) -> u64 {
        let behind = self.runs.partition_point(|run| run.first_beam <= beam);
        self.runs[..behind].last().map_or(0, |run| {
            run.first_line + ((beam - run.first_beam) / run.beams_a_line) as u64
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_beam_has_the_line_it_came_from() {
        let mut index = LineIndex::default();
        let lines = [(2, 3), (3, 3), (5, 3), (6, 1), (7, 1), (8, 4)];
        let mut beams = Vec::new();
        for (line, count) in lines {
            let first = beams.len();
            beams.extend([line].repeat(count));
            index.push(line, first, beams.len());
        }
        let found: Vec<u64> = (0..beams.len()).map(|beam| index.line(beam)).collect();
        assert_eq!(found, beams);
        assert_eq!(index.runs.len(), 4);
        assert_eq!(LineIndex::default().line(7), 0);
    }
}
