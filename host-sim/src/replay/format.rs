//! Which format a recording is in, by its content.

use super::carmen;
use super::readings::HEADER;
use core::fmt;
use serde::Serialize;

/// A recording's format. Either may be packed with gzip, which [`load`](super::load) sees itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Format {
    /// The log of the CARMEN toolkit: a message a line, scans of a laser with corrected poses.
    Carmen,
    /// Our own interchange format: comma-separated, a beam a line.
    Readings,
}

impl Format {
    /// Tells the format from the first bytes of the (unpacked) file.
    ///
    /// The first line that is a CARMEN message or the readings header decides; garbage before it
    /// does not matter. Comments alone (`#`) are taken for a CARMEN log.
    ///
    /// ```
    /// use certainty_sim::replay::Format;
    ///
    /// let start = b"# note\nt_ms,sensor,x_mm,y_mm,bearing_mdeg,reading\n0,1,0,0,0,none\n";
    /// assert_eq!(Format::detect(start), Some(Format::Readings));
    /// assert_eq!(Format::detect(b"ODOM 0 0 0 0 0 0 0.1 host 0.1\n"), Some(Format::Carmen));
    /// assert_eq!(Format::detect(b"Dear all,\n"), None);
    /// ```
    #[must_use]
    pub fn detect(start: &[u8]) -> Option<Self> {
        let start = start.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(start);
        let mut comments = false;
        let mut others = false;
        for line in start.split(|&byte| byte == b'\n') {
            let line = line.trim_ascii();
            let word = line.split(u8::is_ascii_whitespace).next().unwrap_or(line);
            if line == HEADER.as_bytes() {
                return Some(Self::Readings);
            }
            match line.first() {
                None => {}
                Some(b'#') => comments = true,
                Some(_) if str::from_utf8(word).is_ok_and(carmen::is_message) => {
                    return Some(Self::Carmen);
                }
                Some(_) => others = true,
            }
        }
        (comments && !others).then_some(Self::Carmen)
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Carmen => "CARMEN log",
            Self::Readings => "readings",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_line_that_means_something_decides() {
        let carmen = Some(Format::Carmen);
        let readings = Some(Format::Readings);
        assert_eq!(
            Format::detect(b"# message formats defined: PARAM\n"),
            carmen
        );
        assert_eq!(Format::detect(b"\n\nFLASER 2 1.0"), carmen);
        assert_eq!(Format::detect(b"RAWLASER3 0 1\n"), carmen);
        assert_eq!(Format::detect(b"\xff\x00\nODOM 1 2\n"), carmen);
        let with_mark = format!("\u{FEFF}{HEADER}\r\n");
        assert_eq!(Format::detect(with_mark.as_bytes()), readings);
        let noted = format!("# FLASER is mentioned here\n\n{HEADER}\n");
        assert_eq!(Format::detect(noted.as_bytes()), readings);
    }

    #[test]
    fn what_only_resembles_a_format_is_unknown() {
        for text in [
            "",
            "\n\n",
            "FLASERS 1 2\n",
            "t_ms,sensor,x_mm\n",
            "# note\n1 2 3\n",
            "\u{89}PNG\r\n",
        ] {
            assert_eq!(Format::detect(text.as_bytes()), None, "{text:?}");
        }
    }
}
